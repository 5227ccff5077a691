//! The surroundings of a flight: airspace zones and landing places of the mission's GeoJSON files, which are known from
//! the start. Files of other formats are not read.

use super::RecordView;
use crate::error::RecordError;
use serde::Serialize;
use serde_json::Value;

/// The surroundings of a flight.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Surroundings {
    /// Zones in the order of the mission's files.
    pub zones: Vec<Zone>,
    /// Bases and emergency landing places.
    pub landing_places: Vec<LandingPlace>,
}

/// A zone of airspace.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Zone {
    /// Its name for operators.
    pub name: String,
    /// True if the flight must stay inside, false if it must stay out.
    pub permitted: bool,
    /// Lower face, metres above mean sea level.
    pub altitude_m_min: f64,
    /// Upper face, metres above mean sea level; none if the file states none.
    pub altitude_m_max: Option<f64>,
    /// Active intervals as start and end in hours of mission time; empty if it is always active.
    pub active_h: Vec<[f64; 2]>,
    /// GeoJSON.
    #[cfg_attr(test, ts(type = "GeoJSON.Geometry"))]
    pub geometry: Value,
}

/// A place to land.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct LandingPlace {
    /// Its name for operators.
    pub name: String,
    /// True for a base, false for an emergency landing place.
    pub base: bool,
    /// Degrees north.
    pub latitude_deg: f64,
    /// Degrees east.
    pub longitude_deg: f64,
}

impl RecordView {
    /// Returns the surroundings.
    ///
    /// # Errors
    /// [`RecordError::Damaged`].
    pub fn surroundings(&self) -> Result<Surroundings, RecordError> {
        let mut surroundings = Surroundings::default();
        for source in self.reader.sources()?.into_iter().filter(|source| source.role == "data") {
            // Other data files, such as wind tables, are not JSON.
            let Ok(data) = serde_json::from_slice::<Value>(&source.body) else { continue };
            for feature in data.get("features").and_then(Value::as_array).into_iter().flatten() {
                surroundings.zones.extend(zone(feature));
                surroundings.landing_places.extend(landing_place(feature));
            }
        }
        Ok(surroundings)
    }
}

fn property<'a>(feature: &'a Value, name: &str) -> Option<&'a Value> {
    feature.get("properties")?.get(name)
}

fn text<'a>(feature: &'a Value, name: &str) -> Option<&'a str> {
    property(feature, name)?.as_str()
}

fn name(feature: &Value) -> String {
    text(feature, "name").or_else(|| text(feature, "id")).unwrap_or_default().to_owned()
}

/// Returns the zone of a feature: a feature with a kind of zone, a height or a time; without a kind the zone is restricted.
fn zone(feature: &Value) -> Option<Zone> {
    let kind = text(feature, "kind");
    let is_zone = match kind {
        Some(kind) => kind == "restricted" || kind == "permitted",
        None => property(feature, "altitude_m_max").is_some() || property(feature, "active_h").is_some(),
    };
    let number = |name: &str| property(feature, name).and_then(Value::as_f64);
    let span = |span: &Value| Some([span.get(0)?.as_f64()?, span.get(1)?.as_f64()?]);
    let spans = property(feature, "active_h").and_then(Value::as_array).into_iter().flatten();
    is_zone.then(|| feature.get("geometry").cloned()).flatten().map(|geometry| Zone {
        name: name(feature),
        permitted: kind == Some("permitted"),
        altitude_m_min: number("altitude_m_min").unwrap_or(0.0),
        altitude_m_max: number("altitude_m_max"),
        active_h: spans.filter_map(span).collect(),
        geometry,
    })
}

fn landing_place(feature: &Value) -> Option<LandingPlace> {
    let kind = text(feature, "kind").filter(|kind| matches!(*kind, "base" | "landing-place"))?;
    let position = feature.get("geometry")?.get("coordinates")?;
    Some(LandingPlace {
        name: name(feature),
        base: kind == "base",
        latitude_deg: position.get(1)?.as_f64()?,
        longitude_deg: position.get(0)?.as_f64()?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn zones_and_landing_places_are_distinguished_from_targets() {
        let ring = json!({"type": "Polygon", "coordinates": [[[0, 0], [1, 0], [1, 1], [0, 0]]]});
        let feature = |properties: Value| json!({"properties": properties, "geometry": ring});
        let found = zone(&feature(json!({"name": "Hanford", "kind": "restricted", "active_h": [[13, 19]]}))).unwrap();
        assert_eq!((found.permitted, found.active_h, found.altitude_m_max), (false, vec![[13.0, 19.0]], None));
        assert!(!zone(&feature(json!({"id": "a", "altitude_m_max": 5}))).unwrap().permitted);
        assert!(zone(&feature(json!({"id": "zaca", "kind": "fire", "acres": 3}))).is_none());
        let field =
            json!({"properties": {"id": "edwards", "kind": "base"}, "geometry": {"coordinates": [-117.9, 34.9]}});
        let place = landing_place(&field).unwrap();
        assert_eq!((place.base, place.name.as_str(), place.latitude_deg), (true, "edwards", 34.9));
        assert!(landing_place(&feature(json!({"kind": "fire"}))).is_none());
    }
}
