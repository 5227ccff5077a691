//! Values within values as fields: `{"a": {"b": [1, 2]}}` has `a.b[0]` and `a.b[1]`. Messages in JSON, CDR and protobuf all
//! become fields in this way.

use crate::{Cell, FIELDS_MAX, Topic};
use serde_json::Value as Json;

/// Maximum depth of values within values.
pub(crate) const DEPTH_MAX: usize = 16;

/// A value of a message.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Nested {
    /// A value that cannot be compared: missing, bytes, or nested too deeply.
    Nothing,
    Number(f64),
    Text(String),
    /// At most [`FIELDS_MAX`] items are kept.
    List(Vec<Nested>),
    Members(Vec<(String, Nested)>),
}

impl Nested {
    /// Returns a truth value as 0 or 1.
    pub(crate) fn truth(truth: bool) -> Nested {
        Nested::Number(f64::from(u8::from(truth)))
    }
}

impl From<Json> for Nested {
    fn from(json: Json) -> Nested {
        match json {
            Json::Null => Nested::Nothing,
            Json::Bool(truth) => Nested::truth(truth),
            Json::Number(number) => number.as_f64().map_or(Nested::Nothing, Nested::Number),
            Json::String(text) => Nested::Text(text),
            Json::Array(items) => Nested::List(items.into_iter().take(FIELDS_MAX).map(Nested::from).collect()),
            Json::Object(members) => {
                Nested::Members(members.into_iter().map(|(name, value)| (name, value.into())).collect())
            }
        }
    }
}

/// Stores the values of `message` at the positions of the topic's fields, after adding new fields to `topic`.
pub(crate) fn spread(message: Nested, topic: &mut Topic, values: &mut Vec<Cell>) {
    values.clear();
    let mut spreading = Spreading { topic, values, next: 0 };
    spreading.collect(message, String::new(), 0);
}

struct Spreading<'a> {
    topic: &'a mut Topic,
    values: &'a mut Vec<Cell>,
    /// Index of the field that is probably next, because messages of a topic mostly have the same fields in the same order.
    next: usize,
}

impl Spreading<'_> {
    fn collect(&mut self, value: Nested, name: String, depth: usize) {
        let cell = match value {
            Nested::Members(members) if depth < DEPTH_MAX => {
                for (key, value) in members {
                    let child = if name.is_empty() { key } else { format!("{name}.{key}") };
                    self.collect(value, child, depth + 1);
                }
                return;
            }
            Nested::List(items) if depth < DEPTH_MAX => {
                for (index, item) in items.into_iter().enumerate().take(FIELDS_MAX) {
                    self.collect(item, format!("{name}[{index}]"), depth + 1);
                }
                return;
            }
            Nested::Number(number) => Cell::Number(number),
            Nested::Text(text) => Cell::Text(text),
            Nested::Nothing | Nested::Members(_) | Nested::List(_) => Cell::Nothing,
        };
        let Some(index) = self.index(name) else { return };
        self.next = index + 1;
        if self.values.len() <= index {
            self.values.resize(index + 1, Cell::Nothing);
        }
        if let Some(slot) = self.values.get_mut(index) {
            *slot = cell;
        }
    }

    /// Returns the index of the field with this name, which is added if necessary; `None` if the topic has too many fields.
    fn index(&mut self, name: String) -> Option<usize> {
        let fields = &mut self.topic.fields;
        if fields.get(self.next) == Some(&name) {
            return Some(self.next);
        }
        if let Some(index) = fields.iter().position(|field| *field == name) {
            return Some(index);
        }
        if fields.len() >= FIELDS_MAX {
            return None;
        }
        fields.push(name);
        Some(fields.len() - 1)
    }
}
