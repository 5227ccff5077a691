//! Definitions of ROS 2 messages in MCAP (mcap.dev/spec/registry, "ros2msg"): the text of a `.msg` file, followed by the
//! definitions of nested messages, each after a line of `=` and a line `MSG: package/Name`.

use std::collections::BTreeMap;

/// A type that is not a message (design.ros2.org, "Interface definition").
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Primitive {
    Bool,
    U8,
    I8,
    U16,
    I16,
    U32,
    I32,
    F32,
    U64,
    I64,
    F64,
    Text,
    WideText,
}

impl Primitive {
    fn named(name: &str) -> Option<Primitive> {
        Some(match name {
            "bool" => Primitive::Bool,
            "byte" | "uint8" | "char" => Primitive::U8,
            "int8" => Primitive::I8,
            "uint16" => Primitive::U16,
            "int16" => Primitive::I16,
            "uint32" => Primitive::U32,
            "int32" => Primitive::I32,
            "float32" => Primitive::F32,
            "uint64" => Primitive::U64,
            "int64" => Primitive::I64,
            "float64" => Primitive::F64,
            "string" => Primitive::Text,
            "wstring" => Primitive::WideText,
            _ => return None,
        })
    }

    /// Returns the size of a value in bytes; `None` for text, which is preceded by its length.
    pub(crate) fn size(self) -> Option<usize> {
        Some(match self {
            Primitive::Bool | Primitive::U8 | Primitive::I8 => 1,
            Primitive::U16 | Primitive::I16 => 2,
            Primitive::U32 | Primitive::I32 | Primitive::F32 => 4,
            Primitive::U64 | Primitive::I64 | Primitive::F64 => 8,
            Primitive::Text | Primitive::WideText => return None,
        })
    }
}

/// Number of values of a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ValueCount {
    One,
    /// An array of a fixed length.
    Fixed(usize),
    /// A sequence, which is preceded by its length.
    Counted,
}

/// Kind of a field's values.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum ValueKind {
    Primitive(Primitive),
    /// The message with this number in [`Schema::messages`].
    Message(usize),
}

/// A field of a message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct SchemaField {
    pub(crate) name: String,
    pub(crate) kind: ValueKind,
    pub(crate) count: ValueCount,
}

/// A message definition with all nested definitions; the first one is the message itself.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Schema {
    pub(crate) messages: Vec<Vec<SchemaField>>,
}

/// A parsed line of a definition: a field whose type name is not resolved yet.
struct SchemaLine<'a> {
    kind: &'a str,
    name: &'a str,
    count: ValueCount,
}

impl Schema {
    /// Reads the definition of the message `name` (`package/msg/Name`).
    ///
    /// # Errors
    /// An error message with the line that cannot be parsed, or the type that is not defined.
    pub(crate) fn parse(name: &str, text: &str) -> Result<Schema, String> {
        let mut parts: Vec<(&str, Vec<SchemaLine<'_>>)> = vec![(name, Vec::new())];
        for line in text.lines() {
            let line = line.split('#').next().unwrap_or_default().trim();
            if line.is_empty() || line.bytes().all(|byte| byte == b'=') {
                continue;
            }
            if let Some(next) = line.strip_prefix("MSG:") {
                parts.push((next.trim(), Vec::new()));
                continue;
            }
            if let (Some(field), Some((_, fields))) = (field(line)?, parts.last_mut()) {
                fields.push(field);
            }
        }
        let numbers: BTreeMap<String, usize> =
            parts.iter().enumerate().rev().map(|(number, (name, _))| (short(name), number)).collect();
        let message = |(name, lines): &(&str, Vec<SchemaLine<'_>>)| -> Result<Vec<SchemaField>, String> {
            lines.iter().map(|line| resolved(line, name, &numbers)).collect()
        };
        Ok(Schema { messages: parts.iter().map(message).collect::<Result<_, _>>()? })
    }
}

/// Shortens `package/msg/Name` to `package/Name`.
fn short(name: &str) -> String {
    name.replace("/msg/", "/")
}

/// Parses a line; `None` for a constant.
fn field(line: &str) -> Result<Option<SchemaLine<'_>>, String> {
    let wrong = || format!("`{line}` is not a field of a ROS 2 message");
    let (kind, rest) = line.split_once(char::is_whitespace).ok_or_else(wrong)?;
    let name = rest.trim_start().split(|letter: char| letter.is_whitespace() || letter == '=').next();
    let name = name.filter(|name| !name.is_empty()).ok_or_else(wrong)?;
    let after = rest.trim_start().get(name.len()..).unwrap_or_default().trim_start();
    // A default value follows the name like the value of a constant, but without `=`.
    if after.starts_with('=') {
        return Ok(None);
    }
    let (kind, count) = match kind.split_once('[') {
        None => (kind, ValueCount::One),
        Some((kind, length)) => {
            let length = length.strip_suffix(']').ok_or_else(wrong)?;
            let bounded = length.is_empty() || length.starts_with("<=");
            let fixed = || length.parse().map(ValueCount::Fixed).map_err(|_| wrong());
            (kind, if bounded { ValueCount::Counted } else { fixed()? })
        }
    };
    // The maximum length of a bounded string does not affect the encoding.
    let kind = kind.split("<=").next().unwrap_or(kind);
    Ok(Some(SchemaLine { kind, name, count }))
}

fn resolved(line: &SchemaLine<'_>, message: &str, numbers: &BTreeMap<String, usize>) -> Result<SchemaField, String> {
    let SchemaLine { kind, name, count } = line;
    let package = message.split('/').next().unwrap_or_default();
    let number = || {
        let known = |name: String| numbers.get(&name).copied();
        known(short(kind)).or_else(|| known(format!("{package}/{kind}"))).or_else(|| {
            // `Header` without a package means `std_msgs/Header`.
            (*kind == "Header").then(|| known("std_msgs/Header".into())).flatten()
        })
    };
    let kind = match Primitive::named(kind) {
        Some(primitive) => ValueKind::Primitive(primitive),
        None => ValueKind::Message(number().ok_or_else(|| format!("the type `{kind}` of `{name}` is not defined"))?),
    };
    Ok(SchemaField { name: (*name).to_string(), kind, count: *count })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_have_types_counts_and_messages_within() {
        let text = "# A comment\nuint8 MODE_AUTO=3\nstd_msgs/Header header\nfloat64[3] rate  # rad/s\nstring<=8[] names\n\
                    uint8 mode 3\nOwn[<=4] own\n================\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\n\
                    string frame_id\n====\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n===\nMSG: pack/Own\nbool on\n";
        let schema = Schema::parse("pack/msg/Whole", text).unwrap();
        let whole: Vec<(&str, &ValueKind, ValueCount)> =
            schema.messages[0].iter().map(|field| (field.name.as_str(), &field.kind, field.count)).collect();
        let of = ValueKind::Primitive;
        assert_eq!(
            whole,
            [
                ("header", &ValueKind::Message(1), ValueCount::One),
                ("rate", &of(Primitive::F64), ValueCount::Fixed(3)),
                ("names", &of(Primitive::Text), ValueCount::Counted),
                ("mode", &of(Primitive::U8), ValueCount::One),
                ("own", &ValueKind::Message(3), ValueCount::Counted),
            ]
        );
        assert_eq!(schema.messages[1][0].kind, ValueKind::Message(2));
    }

    #[test]
    fn what_is_not_a_definition_is_named() {
        assert_eq!(Schema::parse("a/b", "float64").unwrap_err(), "`float64` is not a field of a ROS 2 message");
        assert_eq!(Schema::parse("a/b", "Other x").unwrap_err(), "the type `Other` of `x` is not defined");
        assert_eq!(Schema::parse("a/b", "int8[x] x").unwrap_err(), "`int8[x] x` is not a field of a ROS 2 message");
    }
}
