//! Messages of ROS 2 in CDR (OMG DDSI-RTPS 2.2, 10.2: four bytes that name the representation; then values, each aligned to
//! its own size, counted from after these four bytes).

use crate::FIELDS_MAX;
use crate::nested::{DEPTH_MAX, Nested};
use crate::ros_schema::{Primitive, Schema, SchemaField, ValueCount, ValueKind};

/// Bytes that name the representation.
const HEADER: usize = 4;
/// Maximum number of values of one message, including values that take no byte.
const VALUES_MAX: usize = 1 << 22;

/// Returns the values of a message.
///
/// # Errors
/// The representation is not plain CDR, or the message ends within a value.
pub(crate) fn read(schema: &Schema, data: &[u8]) -> Result<Nested, String> {
    let little = match data.get(..2) {
        Some([0, 0]) => false,
        Some([0, 1]) => true,
        Some([high, low]) => {
            return Err(format!("its representation {:#06x} is not plain CDR", u16::from_be_bytes([*high, *low])));
        }
        _ => return Err("it is shorter than the header of CDR".to_string()),
    };
    let body = data.get(HEADER..).ok_or("it is shorter than the header of CDR")?;
    CdrReader { schema, body, at: 0, left: VALUES_MAX, little }.message(0, 0)
}

struct CdrReader<'a> {
    schema: &'a Schema,
    body: &'a [u8],
    at: usize,
    /// Number of values that may still be read.
    left: usize,
    little: bool,
}

impl CdrReader<'_> {
    fn message(&mut self, number: usize, depth: usize) -> Result<Nested, String> {
        if depth >= DEPTH_MAX {
            return Err(format!("messages are nested more than {DEPTH_MAX} deep"));
        }
        let schema = self.schema;
        let fields = schema.messages.get(number).map(Vec::as_slice).unwrap_or_default();
        if fields.is_empty() {
            // A message without fields is sent as a single byte.
            self.bytes(1)?;
        }
        let mut members = Vec::with_capacity(fields.len());
        for field in fields {
            members.push((field.name.clone(), self.field(field, depth)?));
        }
        Ok(Nested::Members(members))
    }

    fn field(&mut self, field: &SchemaField, depth: usize) -> Result<Nested, String> {
        let count = match field.count {
            ValueCount::One => return self.value(&field.kind, depth),
            ValueCount::Fixed(count) => count,
            ValueCount::Counted => usize::try_from(u32::from_le_bytes(self.number()?)).unwrap_or(usize::MAX),
        };
        // Each value takes at least one byte, so a count above the remaining bytes is damaged.
        if count > self.body.len().saturating_sub(self.at) {
            return Err(format!("`{}` claims {count} values, more than the message has bytes", field.name));
        }
        let mut items = Vec::with_capacity(count.min(FIELDS_MAX));
        for index in 0..count {
            if let (true, ValueKind::Primitive(kind)) = (index >= FIELDS_MAX, &field.kind)
                && let Some(size) = kind.size()
            {
                // For images and point clouds: values that are not kept are skipped at once.
                self.align(size);
                self.bytes((count - index).saturating_mul(size))?;
                break;
            }
            let item = self.value(&field.kind, depth)?;
            if index < FIELDS_MAX {
                items.push(item);
            }
        }
        Ok(Nested::List(items))
    }

    fn value(&mut self, kind: &ValueKind, depth: usize) -> Result<Nested, String> {
        let left = self.left.checked_sub(1);
        self.left = left.ok_or_else(|| format!("it has more than {VALUES_MAX} values"))?;
        let primitive = match kind {
            ValueKind::Message(number) => return self.message(*number, depth + 1),
            ValueKind::Primitive(primitive) => *primitive,
        };
        Ok(match primitive {
            Primitive::Bool => Nested::truth(self.bytes(1)? != [0]),
            Primitive::U8 => Nested::Number(f64::from(u8::from_le_bytes(self.number()?))),
            Primitive::I8 => Nested::Number(f64::from(i8::from_le_bytes(self.number()?))),
            Primitive::U16 => Nested::Number(f64::from(u16::from_le_bytes(self.number()?))),
            Primitive::I16 => Nested::Number(f64::from(i16::from_le_bytes(self.number()?))),
            Primitive::U32 => Nested::Number(f64::from(u32::from_le_bytes(self.number()?))),
            Primitive::I32 => Nested::Number(f64::from(i32::from_le_bytes(self.number()?))),
            Primitive::F32 => Nested::Number(f64::from(f32::from_le_bytes(self.number()?))),
            Primitive::U64 => Nested::Number(u64::from_le_bytes(self.number()?) as f64),
            Primitive::I64 => Nested::Number(i64::from_le_bytes(self.number()?) as f64),
            Primitive::F64 => Nested::Number(f64::from_le_bytes(self.number()?)),
            Primitive::Text => {
                let length = usize::try_from(u32::from_le_bytes(self.number()?)).unwrap_or(usize::MAX);
                let text = self.bytes(length)?;
                Nested::Text(String::from_utf8_lossy(text.strip_suffix(&[0]).unwrap_or(text)).into_owned())
            }
            Primitive::WideText => return Err("wide texts (`wstring`) are not read".to_string()),
        })
    }

    /// Returns the bytes of an aligned number, the least significant one first.
    fn number<const N: usize>(&mut self) -> Result<[u8; N], String> {
        self.align(N);
        let little = self.little;
        let mut bytes: [u8; N] = self.bytes(N)?.try_into().map_err(|_| "it ends within a number")?;
        if !little {
            bytes.reverse();
        }
        Ok(bytes)
    }

    fn align(&mut self, size: usize) {
        self.at = self.at.next_multiple_of(size.max(1));
    }

    fn bytes(&mut self, count: usize) -> Result<&[u8], String> {
        let end = self.at.checked_add(count).filter(|end| *end <= self.body.len());
        let end = end.ok_or_else(|| format!("it ends at byte {} within a value", self.body.len() + HEADER))?;
        let bytes = self.body.get(self.at..end).unwrap_or_default();
        self.at = end;
        Ok(bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn members(pairs: &[(&str, Nested)]) -> Nested {
        Nested::Members(pairs.iter().map(|(name, value)| ((*name).to_string(), value.clone())).collect())
    }

    #[test]
    fn values_are_aligned_in_both_byte_orders() {
        let schema = Schema::parse("p/M", "uint8 a\nfloat64 b\nstring c\nint16[] d\nbool e").unwrap();
        let mut little = vec![0, 1, 0, 0, 7, 0, 0, 0, 0, 0, 0, 0];
        little.extend(2.5_f64.to_le_bytes());
        little.extend([3, 0, 0, 0, b'o', b'k', 0, 0, 2, 0, 0, 0, 0xff, 0xff, 5, 0, 1]);
        let mut big = vec![0, 0, 0, 0, 7, 0, 0, 0, 0, 0, 0, 0];
        big.extend(2.5_f64.to_be_bytes());
        big.extend([0, 0, 0, 3, b'o', b'k', 0, 0, 0, 0, 0, 2, 0xff, 0xff, 0, 5, 1]);
        let expected = members(&[
            ("a", Nested::Number(7.0)),
            ("b", Nested::Number(2.5)),
            ("c", Nested::Text("ok".into())),
            ("d", Nested::List(vec![Nested::Number(-1.0), Nested::Number(5.0)])),
            ("e", Nested::Number(1.0)),
        ]);
        assert_eq!(read(&schema, &little).unwrap(), expected);
        assert_eq!(read(&schema, &big).unwrap(), expected);
    }

    #[test]
    fn damaged_messages_are_named() {
        let schema = Schema::parse("p/M", "float64[] a").unwrap();
        assert_eq!(read(&schema, &[1]).unwrap_err(), "it is shorter than the header of CDR");
        assert_eq!(read(&schema, &[0, 3, 0, 0]).unwrap_err(), "its representation 0x0003 is not plain CDR");
        assert_eq!(read(&schema, &[0, 1, 0, 0, 1]).unwrap_err(), "it ends at byte 5 within a value");
        let huge = [0, 1, 0, 0, 0xff, 0xff, 0xff, 0xff, 0];
        assert!(read(&schema, &huge).unwrap_err().starts_with("`a` claims 4294967295 values"));
        let endless = Schema::parse("p/M", "p/M inner").unwrap();
        assert_eq!(read(&endless, &[0, 1, 0, 0, 0]).unwrap_err(), "messages are nested more than 16 deep");
        // Each message contains a hundred of the next level, and the messages of the last level take no bytes.
        let mut text = "p/A0[100] a\n".to_string();
        for level in 0..12 {
            text.push_str(&format!("MSG: p/A{level}\np/A{}[100] a\n", level + 1));
        }
        text.push_str("MSG: p/A12\nuint8[0] a\n");
        let wide = Schema::parse("p/M", &text).unwrap();
        assert_eq!(read(&wide, &[0; 200]).unwrap_err(), "it has more than 4194304 values");
    }
}
