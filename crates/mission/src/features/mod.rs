//! Files with places and their properties: GeoJSON, KML, KMZ, tables of places, and tables of fire detections (FIRMS).
//!
//! Each reader makes features with properties in the form of GeoJSON, so that one set of rules applies to all formats. Every error names
//! file, feature and property.

mod crossing;
mod detections;
mod geojson_file;
mod geometry;
mod kml;
mod permitted;
mod placed;
mod table;

pub(crate) use geometry::area_m2;

use crate::error::{MissionError, MissionResult};
use crate::sources::DataFile;
use crate::terrain;
use apex_geo::terrain::Terrain;
use apex_model::problem::{Position, TimeWindow};
use geojson::{Feature, JsonValue};
use permitted::hyphenated;
use placed::PlacedFeature;

/// One feature of a file.
#[derive(Debug)]
pub(crate) struct NamedFeature {
    /// File, and the feature in it, for errors.
    place: String,
    feature: Feature,
    /// The property `id`, otherwise `name`.
    pub id: String,
    /// The property `name`, otherwise `id`.
    pub name: String,
}

/// Reads the features of a file, whose ids must be unique. The file name's extension determines the format: `.kml`, `.kmz`, `.csv`; any
/// other name is GeoJSON.
///
/// # Errors
/// A file of another format, a feature without id and name, an id given twice, no features.
pub(crate) fn read(file: &DataFile) -> MissionResult<Vec<NamedFeature>> {
    let place = &file.place;
    let extension = place.rsplit_once('.').map(|(_, end)| end.to_lowercase());
    let features: Vec<PlacedFeature> = match extension.as_deref() {
        Some("kml") => kml::read(place, &file.bytes)?,
        Some("kmz") => kml::read_archive(place, &file.bytes)?,
        Some("csv") if detections::is_detections(file) => detections::read(file)?,
        Some("csv") => table::read(file)?,
        _ => geojson_file::read(file)?,
    };
    let mut found: Vec<NamedFeature> = Vec::new();
    for (place, feature) in features {
        let named = NamedFeature::new(place, feature)?;
        if let Some(earlier) = found.iter().find(|earlier| earlier.id == named.id) {
            return Err(MissionError::data(format!("two features have the id `{}`", named.id))
                .at(&named.place)
                .because(format!("the other one is {}", earlier.place))
                .help("give each its own id"));
        }
        found.push(named);
    }
    if found.is_empty() {
        return Err(MissionError::data(format!("{place} holds no features")));
    }
    Ok(found)
}

impl NamedFeature {
    fn new(place: String, feature: Feature) -> MissionResult<NamedFeature> {
        let mut named = NamedFeature { place, feature, id: String::new(), name: String::new() };
        let id = named.text("id")?;
        let name = named.text("name")?;
        let Some(id) = id.or_else(|| name.as_deref().map(hyphenated)) else {
            return Err(named.trouble("it has neither `id` nor `name`").help("add the property `id`"));
        };
        permitted::id(&id, |what| named.trouble(what))?;
        named.name = name.unwrap_or_else(|| id.clone());
        named.id = id;
        Ok(named)
    }

    /// Returns an error of this feature.
    pub(crate) fn trouble(&self, what: impl std::fmt::Display) -> MissionError {
        let which = if self.id.is_empty() { String::new() } else { format!(" `{}`", self.id) };
        MissionError::data(what.to_string()).at(format!("{}{which}", self.place))
    }

    /// Returns the elevation of the ground: the property `elevation_m`; without it that of the terrain if the mission has one; otherwise
    /// 0.
    ///
    /// # Errors
    /// An elevation that is impossible on Earth or contradicts the terrain; a position outside of the terrain.
    pub(crate) fn elevation_m(&self, terrain: Option<&Terrain>) -> MissionResult<f64> {
        let stated_m = self.number("elevation_m", -500.0, 9_000.0)?;
        let Some(terrain) = terrain else { return Ok(stated_m.unwrap_or(0.0)) };
        let what = format!("`{}`", self.id);
        let found = terrain::elevation_m(Some(terrain), self.position()?, stated_m);
        let ground_m = found.map_err(|mismatch| mismatch.error(&what, &self.place))?;
        self.covered(Some(terrain), self.polygons()?.into_iter().flatten().chain(self.line()?))?;
        Ok(ground_m)
    }

    /// Checks that all of these positions are on the terrain, if the mission has one.
    ///
    /// # Errors
    /// The first position that is not.
    pub(crate) fn covered(
        &self,
        terrain: Option<&Terrain>,
        places: impl IntoIterator<Item = Position>,
    ) -> MissionResult<()> {
        let Some(terrain) = terrain else { return Ok(()) };
        let uncovered = places.into_iter().find(|place| terrain.elevation_m_at(*place).is_none());
        uncovered.map_or(Ok(()), |position| {
            Err(terrain::Mismatch::NotCovered { position }.error(&format!("`{}`", self.id), &self.place))
        })
    }

    /// Returns true if the property exists.
    pub(crate) fn has(&self, key: &str) -> bool {
        self.property(key).is_some()
    }

    /// Returns the names of its properties that have a value.
    pub(crate) fn properties(&self) -> impl Iterator<Item = &str> {
        let all = self.feature.properties.iter().flat_map(|properties| properties.iter());
        all.filter(|(_, value)| !value.is_null()).map(|(name, _)| name.as_str())
    }

    fn property(&self, key: &str) -> Option<&JsonValue> {
        self.feature.property(key).filter(|value| !value.is_null())
    }

    /// Returns a text property; `None` if it is absent.
    pub(crate) fn text(&self, key: &str) -> MissionResult<Option<String>> {
        match self.property(key) {
            None => Ok(None),
            Some(JsonValue::String(text)) if !text.trim().is_empty() => Ok(Some(text.trim().to_string())),
            Some(other) => Err(self.trouble(format!("`{key}` is {other}, not a text"))),
        }
    }

    /// Returns the property as JSON; `None` if it is absent.
    pub(crate) fn json(&self, key: &str) -> Option<&JsonValue> {
        self.property(key)
    }

    /// Returns a list of texts; a single text is a list of one, and an absent property is empty.
    pub(crate) fn texts(&self, key: &str) -> MissionResult<Vec<String>> {
        let wrong = |other: &JsonValue| self.trouble(format!("`{key}` is {other}, not a list of texts"));
        match self.property(key) {
            None => Ok(Vec::new()),
            Some(value @ JsonValue::Array(items)) => {
                items.iter().map(|item| item.as_str().map(str::to_string).ok_or_else(|| wrong(value))).collect()
            }
            Some(JsonValue::String(text)) => Ok(vec![text.clone()]),
            Some(other) => Err(wrong(other)),
        }
    }

    /// Returns the option if it is one of `words`; `None` if it is absent.
    pub(crate) fn word(&self, key: &str, words: &[&'static str]) -> MissionResult<Option<&'static str>> {
        let Some(text) = self.text(key)? else { return Ok(None) };
        let found = words.iter().copied().find(|word| *word == text);
        found.map(Some).ok_or_else(|| {
            self.trouble(format!("unknown `{key}`: `{text}`")).help(format!("known are {}", words.join(", ")))
        })
    }

    /// Converts spans of hours of mission time, `[[from, until], ..]`, to seconds; empty if the property is absent.
    pub(crate) fn spans_s(&self, key: &str) -> MissionResult<Vec<TimeWindow>> {
        let mut spans = Vec::new();
        let pairs = self.pairs(key)?;
        if pairs.is_empty() && self.property(key).is_some() {
            return Err(self
                .trouble(format!("`{key}` is an empty list"))
                .because("a list without spans would mean always")
                .help(format!(
                    "name a span such as [[2, 5]], hours since the mission's start, or leave `{key}` out for always"
                )));
        }
        for (from_h, until_h) in pairs {
            if until_h <= from_h {
                return Err(self.trouble(format!("`{key}`: the span [{from_h}, {until_h}] ends before it begins")));
            }
            spans.push(TimeWindow { from_s: from_h * 3600.0, until_s: until_h * 3600.0 });
        }
        Ok(spans)
    }

    /// Returns a list of pairs of numbers, `[[from, until], ..]`; empty if it is absent.
    pub(crate) fn pairs(&self, key: &str) -> MissionResult<Vec<(f64, f64)>> {
        let wrong = |other: &JsonValue| self.trouble(format!("`{key}` is {other}, not a list of pairs of numbers"));
        let Some(value) = self.property(key) else { return Ok(Vec::new()) };
        let items = value.as_array().ok_or_else(|| wrong(value))?;
        let pair = |item: &JsonValue| match item.as_array().map(Vec::as_slice) {
            Some([a, b]) => a.as_f64().zip(b.as_f64()),
            _ => None,
        };
        items.iter().map(|item| pair(item).ok_or_else(|| wrong(value))).collect()
    }

    /// Reads a pair of numbers, `[first, second]`, the second not less than the first; `None` if it is absent.
    pub(crate) fn pair(&self, key: &str, low: f64, high: f64) -> MissionResult<Option<(f64, f64)>> {
        let Some(value) = self.property(key) else { return Ok(None) };
        let wrong = |what: String| {
            self.trouble(format!("`{key}` is {value}, {what}"))
                .help(format!("write two numbers from {low} to {high}, the second not less than the first"))
        };
        let found = match value.as_array().map(Vec::as_slice) {
            Some([a, b]) => a.as_f64().zip(b.as_f64()),
            _ => None,
        };
        let (first, second) = found.ok_or_else(|| wrong("not a pair of numbers".to_string()))?;
        if first < low || second > high || second < first {
            return Err(wrong("out of range, or with the second number less than the first".to_string()));
        }
        Ok(Some((first, second)))
    }

    /// Returns `true` or `false`; `None` if the property is absent.
    pub(crate) fn flag(&self, key: &str) -> MissionResult<Option<bool>> {
        match self.property(key) {
            None => Ok(None),
            Some(JsonValue::Bool(flag)) => Ok(Some(*flag)),
            Some(other) => Err(self.trouble(format!("`{key}` is {other}, not true or false"))),
        }
    }

    /// Returns the object in property `key` as a separate feature, whose properties are those of the object. `known` are the permitted
    /// properties.
    pub(crate) fn object(&self, key: &str, known: &[&str]) -> MissionResult<NamedFeature> {
        let value = self.property(key).unwrap_or(&JsonValue::Null);
        let own = value.as_object().ok_or_else(|| self.trouble(format!("`{key}` is {value}, not an object")))?;
        if let Some(unknown) = own.keys().find(|name| !known.contains(&name.as_str())) {
            return Err(self
                .trouble(format!("`{key}` has the unknown property `{unknown}`"))
                .help(format!("known are {}", known.join(", "))));
        }
        let mut feature = self.feature.clone();
        feature.properties = Some(own.clone());
        let (place, id, name) = (self.place.clone(), self.id.clone(), self.name.clone());
        Ok(NamedFeature { place, feature, id, name })
    }

    /// Returns the objects in a list as separate features: at the same place, with the object's properties, which default to those of
    /// this feature, and with the id `ID/OWN`. `known` are the permitted properties of an object.
    pub(crate) fn parts(&self, key: &str, known: &[&str]) -> MissionResult<Vec<NamedFeature>> {
        let Some(value) = self.property(key) else { return Ok(Vec::new()) };
        let wrong = |what: String| {
            self.trouble(what).help(format!("write a list of objects, for example `\"{key}\": [{{\"id\": \"night\", \"value\": 60, \"light\": \"night\"}}]`"))
        };
        let items = value.as_array().filter(|items| !items.is_empty());
        let items = items.ok_or_else(|| wrong(format!("`{key}` is {value}, not a list of objects")))?;
        let mut parts: Vec<NamedFeature> = Vec::new();
        for (number, item) in items.iter().enumerate() {
            let place = format!("`{key}` {}", number + 1);
            let own = item.as_object().ok_or_else(|| wrong(format!("{place} is {item}, not an object")))?;
            if let Some(unknown) = own.keys().find(|name| !known.contains(&name.as_str())) {
                return Err(self
                    .trouble(format!("{place} has the unknown property `{unknown}`"))
                    .help(format!("known are {}", known.join(", "))));
            }
            let id = match own.get("id") {
                Some(JsonValue::String(id)) if !id.is_empty() && hyphenated(id) == *id => id.clone(),
                Some(id) => {
                    let help = "write lower-case letters, digits and hyphens";
                    return Err(self.trouble(format!("{place} has the id {id}")).help(help));
                }
                None => return Err(wrong(format!("{place} has no `id`"))),
            };
            let id = format!("{}/{id}", self.id);
            if parts.iter().any(|part| part.id == id) {
                return Err(self
                    .trouble(format!("{place} has the id `{id}`, which another has"))
                    .help("give each its own id"));
            }
            let mut feature = self.feature.clone();
            let mut properties = feature.properties.take().unwrap_or_default();
            properties.extend(own.iter().map(|(name, value)| (name.clone(), value.clone())));
            feature.properties = Some(properties);
            parts.push(NamedFeature { place: self.place.clone(), feature, id, name: self.name.clone() });
        }
        Ok(parts)
    }

    /// Returns a number inside `[low, high]`; `None` if it is absent.
    pub(crate) fn number(&self, key: &str, low: f64, high: f64) -> MissionResult<Option<f64>> {
        match self.property(key).map(|value| (value, value.as_f64())) {
            None => Ok(None),
            Some((_, Some(number))) if (low..=high).contains(&number) => Ok(Some(number)),
            Some((_, Some(number))) => {
                Err(self.trouble(format!("`{key}` is {number}, which is not {}", crate::tables::range(low, high))))
            }
            Some((other, None)) => Err(self.trouble(format!("`{key}` is {other}, not a number"))),
        }
    }
}
