//! JSON objects as fields: `{"a": {"b": [1, 2]}}` has `a.b[0]` and `a.b[1]`.

use crate::{Cell, FIELDS_MAX, Topic};
use serde_json::Value as Json;

/// Objects within objects.
const DEPTH_MAX: usize = 16;

/// Puts the values of `json` where the fields of `topic` stand, adding fields that are new.
pub(crate) fn spread(json: &Json, topic: &mut Topic, values: &mut Vec<Cell>) {
    values.clear();
    collect(json, String::new(), 0, topic, values);
}

fn collect(json: &Json, name: String, depth: usize, topic: &mut Topic, values: &mut Vec<Cell>) {
    let child = |key: &str| if name.is_empty() { key.to_string() } else { format!("{name}.{key}") };
    let cell = match json {
        Json::Object(fields) if depth < DEPTH_MAX => {
            fields.iter().for_each(|(key, value)| collect(value, child(key), depth + 1, topic, values));
            return;
        }
        Json::Array(items) if depth < DEPTH_MAX => {
            for (index, item) in items.iter().enumerate().take(FIELDS_MAX) {
                collect(item, format!("{name}[{index}]"), depth + 1, topic, values);
            }
            return;
        }
        Json::Number(number) => number.as_f64().map_or(Cell::Nothing, Cell::Number),
        Json::Bool(truth) => Cell::Number(f64::from(u8::from(*truth))),
        Json::String(text) => Cell::Text(text.clone()),
        Json::Null | Json::Object(_) | Json::Array(_) => Cell::Nothing,
    };
    let known = topic.fields.iter().position(|field| *field == name);
    let index = match known {
        Some(index) => index,
        None if topic.fields.len() < FIELDS_MAX => {
            topic.fields.push(name);
            topic.fields.len() - 1
        }
        None => return,
    };
    if values.len() <= index {
        values.resize(index + 1, Cell::Nothing);
    }
    if let Some(slot) = values.get_mut(index) {
        *slot = cell;
    }
}
