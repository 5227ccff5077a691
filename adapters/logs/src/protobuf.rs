//! Protobuf messages in MCAP (mcap.dev/spec/registry, "protobuf"). The data of the schema is a `FileDescriptorSet`; the
//! name of the schema is the name of the message.

use crate::FIELDS_MAX;
use crate::nested::{DEPTH_MAX, Nested};
use prost_reflect::{DescriptorPool, DynamicMessage, MapKey, MessageDescriptor, ReflectMessage, Value};

/// Returns the descriptor of the message `name` in a set of descriptors.
///
/// # Errors
/// An error message if the set cannot be decoded or does not contain the message.
pub(crate) fn descriptor(name: &str, set: &[u8]) -> Result<MessageDescriptor, String> {
    let pool = DescriptorPool::decode(set).map_err(|error| error.to_string())?;
    pool.get_message_by_name(name).ok_or_else(|| format!("its descriptors have no message `{name}`"))
}

/// Returns the values of a message. An absent field has its default, unless the definition tracks its presence.
///
/// # Errors
/// An error message if the bytes cannot be decoded as this message.
pub(crate) fn read(descriptor: &MessageDescriptor, data: &[u8]) -> Result<Nested, String> {
    let message = DynamicMessage::decode(descriptor.clone(), data).map_err(|error| error.to_string())?;
    Ok(members(&message, 0))
}

fn members(message: &DynamicMessage, depth: usize) -> Nested {
    if depth >= DEPTH_MAX {
        return Nested::Nothing;
    }
    let mut members = Vec::new();
    for field in message.descriptor().fields() {
        let missing = field.supports_presence() && !message.has_field(&field);
        let value = if missing { Nested::Nothing } else { nested(&message.get_field(&field), depth) };
        members.push((field.name().to_string(), value));
    }
    Nested::Members(members)
}

fn nested(value: &Value, depth: usize) -> Nested {
    match value {
        Value::Bool(truth) => Nested::truth(*truth),
        Value::I32(number) | Value::EnumNumber(number) => Nested::Number(f64::from(*number)),
        Value::U32(number) => Nested::Number(f64::from(*number)),
        Value::I64(number) => Nested::Number(*number as f64),
        Value::U64(number) => Nested::Number(*number as f64),
        Value::F32(number) => Nested::Number(f64::from(*number)),
        Value::F64(number) => Nested::Number(*number),
        Value::String(text) => Nested::Text(text.clone()),
        Value::Bytes(_) => Nested::Nothing,
        Value::Message(message) => members(message, depth + 1),
        Value::List(items) => Nested::List(items.iter().take(FIELDS_MAX).map(|item| nested(item, depth + 1)).collect()),
        Value::Map(entries) => {
            // Maps have no order; sorting by the text of the keys makes the output reproducible.
            let mut entries: Vec<(String, Nested)> =
                entries.iter().map(|(key, value)| (key_name(key), nested(value, depth + 1))).collect();
            entries.sort_by(|(one, _), (other, _)| one.cmp(other));
            entries.truncate(FIELDS_MAX);
            Nested::Members(entries)
        }
    }
}

fn key_name(key: &MapKey) -> String {
    match key {
        MapKey::Bool(truth) => truth.to_string(),
        MapKey::I32(number) => number.to_string(),
        MapKey::I64(number) => number.to_string(),
        MapKey::U32(number) => number.to_string(),
        MapKey::U64(number) => number.to_string(),
        MapKey::String(text) => text.clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use prost_reflect::prost::Message;
    use prost_reflect::prost_types::field_descriptor_proto::{Label, Type};
    use prost_reflect::prost_types::{DescriptorProto, FieldDescriptorProto, FileDescriptorProto, FileDescriptorSet};

    fn field(name: &str, number: i32, kind: Type, label: Label) -> FieldDescriptorProto {
        FieldDescriptorProto {
            name: Some(name.into()),
            number: Some(number),
            r#type: Some(kind.into()),
            label: Some(label.into()),
            ..FieldDescriptorProto::default()
        }
    }

    fn set() -> Vec<u8> {
        let inner = FieldDescriptorProto {
            type_name: Some(".pack.In".into()),
            ..field("in", 3, Type::Message, Label::Optional)
        };
        let file = FileDescriptorProto {
            name: Some("pack.proto".into()),
            package: Some("pack".into()),
            syntax: Some("proto3".into()),
            message_type: vec![
                DescriptorProto {
                    name: Some("Whole".into()),
                    field: vec![
                        field("roll", 1, Type::Double, Label::Optional),
                        field("cells", 2, Type::Uint32, Label::Repeated),
                        inner,
                        field("mode", 4, Type::String, Label::Optional),
                    ],
                    ..DescriptorProto::default()
                },
                DescriptorProto {
                    name: Some("In".into()),
                    field: vec![field("count", 1, Type::Sint64, Label::Optional)],
                    ..DescriptorProto::default()
                },
            ],
            ..FileDescriptorProto::default()
        };
        FileDescriptorSet { file: vec![file] }.encode_to_vec()
    }

    /// The bytes are written by hand from protobuf.dev, "Encoding".
    #[test]
    fn fields_are_read_and_missing_ones_distinguished_from_zero() {
        let whole = descriptor("pack.Whole", &set()).unwrap();
        let mut bytes = vec![0x09];
        bytes.extend(1.5_f64.to_le_bytes());
        // Packed cells 3 and 300; the message within holds -2 as a zigzag number.
        bytes.extend([0x12, 3, 3, 0xac, 2, 0x1a, 2, 0x08, 3]);
        let number = |number| Nested::Number(number);
        let of = |name: &str, value| (name.to_string(), value);
        let all = |count: Nested| {
            Nested::Members(vec![
                of("roll", number(1.5)),
                of("cells", Nested::List(vec![number(3.0), number(300.0)])),
                of("in", count),
                of("mode", Nested::Text(String::new())),
            ])
        };
        assert_eq!(read(&whole, &bytes).unwrap(), all(Nested::Members(vec![of("count", number(-2.0))])));
        assert_eq!(read(&whole, &bytes[..14]).unwrap(), all(Nested::Nothing));
        assert!(read(&whole, &bytes[..5]).is_err());
        assert!(descriptor("pack.Other", &set()).is_err());
        assert!(descriptor("pack.Whole", &[0xff]).is_err());
    }
}
