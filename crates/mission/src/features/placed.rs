//! Output of every reader of features: a feature with its place in the file.

use geojson::{Feature, GeometryValue, JsonObject, JsonValue};

/// A feature with its place in the file, for errors: `fires.csv:3`, `fires.geojson: feature 3`.
pub(super) type PlacedFeature = (String, Feature);

/// Returns a feature of this geometry.
pub(super) fn feature(geometry: GeometryValue, properties: JsonObject) -> Feature {
    Feature { geometry: Some(geometry.into()), properties: Some(properties), ..Feature::default() }
}

/// Returns the value of a property given as text: JSON if it is a number, a list or a truth value. Names remain text, because a fire may
/// be called 12.
pub(super) fn typed(name: &str, text: &str) -> JsonValue {
    let as_text = || JsonValue::String(text.to_string());
    if matches!(name, "id" | "name") {
        return as_text();
    }
    match serde_json::from_str(text) {
        Ok(value @ (JsonValue::Number(_) | JsonValue::Array(_) | JsonValue::Bool(_))) => value,
        _ => as_text(),
    }
}
