//! Formats of ULog messages: `name:type field;type field;..`, with arrays and nested formats.

use crate::bytes::{array, text, u16_at, u32_at, u64_at};
use crate::{Cell, FIELDS_MAX};
use std::collections::BTreeMap;

/// Maximum depth of formats within formats.
const DEPTH_MAX: usize = 8;

/// One value of a message.
#[derive(Clone, Debug)]
pub(crate) struct Leaf {
    pub(crate) name: String,
    offset: usize,
    kind: UlogMessageKind,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum UlogMessageKind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
    Bool,
    Text(usize),
}

impl UlogMessageKind {
    fn named(name: &str) -> Option<UlogMessageKind> {
        Some(match name {
            "int8_t" => UlogMessageKind::I8,
            "uint8_t" => UlogMessageKind::U8,
            "int16_t" => UlogMessageKind::I16,
            "uint16_t" => UlogMessageKind::U16,
            "int32_t" => UlogMessageKind::I32,
            "uint32_t" => UlogMessageKind::U32,
            "int64_t" => UlogMessageKind::I64,
            "uint64_t" => UlogMessageKind::U64,
            "float" => UlogMessageKind::F32,
            "double" => UlogMessageKind::F64,
            "bool" => UlogMessageKind::Bool,
            "char" => UlogMessageKind::Text(1),
            _ => return None,
        })
    }

    fn size(self) -> usize {
        match self {
            UlogMessageKind::I8 | UlogMessageKind::U8 | UlogMessageKind::Bool => 1,
            UlogMessageKind::I16 | UlogMessageKind::U16 => 2,
            UlogMessageKind::I32 | UlogMessageKind::U32 | UlogMessageKind::F32 => 4,
            UlogMessageKind::I64 | UlogMessageKind::U64 | UlogMessageKind::F64 => 8,
            UlogMessageKind::Text(length) => length,
        }
    }
}

impl Leaf {
    /// Returns its value in `payload`; nothing where the message ends before.
    pub(crate) fn value(&self, payload: &[u8]) -> Cell {
        let at = self.offset;
        let number = match self.kind {
            UlogMessageKind::I8 => array(payload, at).map(i8::from_le_bytes).map(f64::from),
            UlogMessageKind::U8 | UlogMessageKind::Bool => payload.get(at).map(|byte| f64::from(*byte)),
            UlogMessageKind::I16 => array(payload, at).map(i16::from_le_bytes).map(f64::from),
            UlogMessageKind::U16 => u16_at(payload, at).map(f64::from),
            UlogMessageKind::I32 => array(payload, at).map(i32::from_le_bytes).map(f64::from),
            UlogMessageKind::U32 => u32_at(payload, at).map(f64::from),
            UlogMessageKind::I64 => array(payload, at).map(i64::from_le_bytes).map(|number| number as f64),
            UlogMessageKind::U64 => u64_at(payload, at).map(|number| number as f64),
            UlogMessageKind::F32 => array(payload, at).map(f32::from_le_bytes).map(f64::from),
            UlogMessageKind::F64 => array(payload, at).map(f64::from_le_bytes),
            UlogMessageKind::Text(length) => {
                let bytes = payload.get(at..).unwrap_or_default();
                return Cell::Text(text(bytes.get(..length).unwrap_or(bytes)));
            }
        };
        number.map_or(Cell::Nothing, Cell::Number)
    }

    /// Returns the value as whole microseconds, if it is a `uint64_t`.
    pub(crate) fn microseconds(&self, payload: &[u8]) -> Option<u64> {
        (self.kind == UlogMessageKind::U64).then(|| u64_at(payload, self.offset)).flatten()
    }
}

/// The formats of one log by name.
#[derive(Clone, Debug, Default)]
pub(crate) struct Formats(BTreeMap<String, Vec<(String, String)>>);

impl Formats {
    /// Adds a definition; false if the text is not a definition.
    pub(crate) fn define(&mut self, definition: &str) -> bool {
        let Some((name, fields)) = definition.split_once(':') else { return false };
        let parts = fields.split(';').filter(|part| !part.trim().is_empty());
        let fields: Option<Vec<(String, String)>> = parts
            .map(|part| part.trim().split_once(' ').map(|(kind, name)| (kind.to_string(), name.trim().to_string())))
            .collect();
        let Some(fields) = fields.filter(|fields| fields.len() <= FIELDS_MAX) else { return false };
        self.0.insert(name.to_string(), fields);
        true
    }

    /// Returns all values of a message of format `name`, and their number of bytes.
    ///
    /// # Errors
    /// The message names the definition that is missing or wrong.
    pub(crate) fn leaves(&self, name: &str) -> Result<(Vec<Leaf>, usize), String> {
        let mut leaves = Vec::new();
        let mut offset = 0;
        self.collect(name, "", 0, &mut offset, &mut leaves)?;
        Ok((leaves, offset))
    }

    fn collect(
        &self,
        format: &str,
        prefix: &str,
        depth: usize,
        offset: &mut usize,
        leaves: &mut Vec<Leaf>,
    ) -> Result<(), String> {
        let fields = self.0.get(format).ok_or_else(|| format!("the format `{format}` is not defined"))?;
        if depth > DEPTH_MAX {
            return Err(format!("the format `{format}` contains itself, or is nested too deep"));
        }
        for (kind, name) in fields {
            let (kind, count) = counted(kind).ok_or_else(|| format!("the type `{kind}` is not known"))?;
            let plain = UlogMessageKind::named(kind);
            if plain == Some(UlogMessageKind::Text(1)) {
                push(leaves, format!("{prefix}{name}"), *offset, UlogMessageKind::Text(count.unwrap_or(1)), format)?;
                *offset += count.unwrap_or(1);
                continue;
            }
            for index in 0..count.unwrap_or(1) {
                let name = count.map_or_else(|| format!("{prefix}{name}"), |_| format!("{prefix}{name}[{index}]"));
                match plain {
                    Some(plain) => {
                        if !name.starts_with("_padding") {
                            push(leaves, name, *offset, plain, format)?;
                        }
                        *offset += plain.size();
                    }
                    None => self.collect(kind, &format!("{name}."), depth + 1, offset, leaves)?,
                }
            }
        }
        Ok(())
    }
}

fn push(
    leaves: &mut Vec<Leaf>,
    name: String,
    offset: usize,
    kind: UlogMessageKind,
    format: &str,
) -> Result<(), String> {
    if leaves.len() >= FIELDS_MAX {
        return Err(format!("the format `{format}` has more than {FIELDS_MAX} fields"));
    }
    leaves.push(Leaf { name, offset, kind });
    Ok(())
}

/// Returns a type without its length, and the length: `float[4]` as `float` and 4.
fn counted(kind: &str) -> Option<(&str, Option<usize>)> {
    match kind.split_once('[') {
        None => Some((kind, None)),
        Some((plain, count)) => {
            let count: usize = count.strip_suffix(']')?.parse().ok()?;
            (count <= usize::from(u16::MAX)).then_some((plain, Some(count)))
        }
    }
}
