//! Reads a form of a setting about radio links: its keys and figures, with errors that name them.

use crate::error::{MissionError, MissionResult};
use apex_model::problem::Position;
use apex_model::quantity::Dimension;
use apex_model::value::Value;

/// Finds a location or a named place, with its elevation.
pub(crate) type PlaceOf<'a> = &'a dyn Fn(&Value) -> Option<(Position, f64)>;

/// A form such as `(900MHzModem :station home)` of an option such as `modems`.
pub(crate) struct LinkForm<'a> {
    /// The place of the application.
    pub(crate) at: &'a str,
    /// The option, without its colon.
    pub(crate) option: &'static str,
    /// The form.
    pub(crate) form: &'a Value,
    /// Usage of such a form.
    pub(crate) usage: &'static str,
    /// The places of the mission.
    pub(crate) place_of: PlaceOf<'a>,
}

impl<'a> LinkForm<'a> {
    /// Returns an error of this form.
    pub(crate) fn wrong(&self, why: String) -> MissionError {
        MissionError::setting(format!("in :{}, `{}` cannot be read", self.option, self.form))
            .at(self.at)
            .because(why)
            .help(format!("write {}", self.usage))
    }

    pub(crate) fn unknown(&self, key: &str, known: &str) -> MissionError {
        self.wrong(format!("unknown key `{key}`; known are {known}"))
    }

    /// Returns the keys with their values; a repeated key is an error.
    pub(crate) fn pairs<'v>(&self, items: &'v [Value]) -> MissionResult<Vec<(&'v str, &'v Value)>> {
        let mut pairs: Vec<(&str, &Value)> = Vec::new();
        for pair in items.chunks(2) {
            let [Value::Symbol(key), value] = pair else {
                let found = pair.first().map(Value::to_string).unwrap_or_default();
                return Err(self.wrong(format!("expected keys, each with a value; found `{found}`")));
            };
            if pairs.iter().any(|(known, _)| *known == key.folded()) {
                return Err(self.wrong(format!("`{key}` is given twice")));
            }
            pairs.push((key.folded(), value));
        }
        Ok(pairs)
    }

    /// Returns the pairs of a list inside of the form.
    pub(crate) fn pairs_of<'v>(&self, item: &'v Value) -> MissionResult<Vec<(&'v str, &'v Value)>> {
        let items = item.as_list().ok_or_else(|| self.wrong(format!("`{item}` is not a list of keys with values")))?;
        self.pairs(items)
    }

    pub(crate) fn list<'v>(&self, key: &str, value: &'v Value) -> MissionResult<&'v [Value]> {
        value.as_list().ok_or_else(|| self.wrong(format!("`{key} {value}` is not a list")))
    }

    /// Returns a figure in SI units above zero and up to `most`; a bare number is an error, unless `unit` is none.
    pub(crate) fn figure(&self, key: &str, value: &Value, unit: Dimension, most: f64) -> MissionResult<f64> {
        match value.as_number() {
            Some((si, found)) if found == unit && si > 0.0 && si <= most => Ok(si),
            Some((bare, Dimension::NONE)) if bare > 0.0 && unit != Dimension::NONE => {
                let suffix = if unit == Dimension::TIME { "s" } else { "m" };
                Err(self.wrong(format!(
                    "`{key} {value}` has no unit: write `{key} {value}{suffix}`, or the unit that is meant"
                )))
            }
            _ => {
                let what = match unit {
                    Dimension::LENGTH => "length in metres",
                    Dimension::TIME => "duration in seconds",
                    _ => "number",
                };
                Err(self.wrong(format!("`{key} {value}` is not a {what} above 0 and up to {most}")))
            }
        }
    }

    /// Returns a number from 0 to 1.
    pub(crate) fn share(&self, key: &str, value: &Value) -> MissionResult<f64> {
        match value.as_number() {
            Some((share, Dimension::NONE)) if (0.0..=1.0).contains(&share) => Ok(share),
            _ => Err(self.wrong(format!("`{key} {value}` is not a number from 0 to 1"))),
        }
    }

    /// Returns a direction, clockwise from north; bare numbers are degrees.
    pub(crate) fn angle_deg(&self, key: &str, value: &Value) -> MissionResult<f64> {
        let degrees = match value.as_number() {
            Some((radians, Dimension::ANGLE)) => Some(radians.to_degrees()),
            Some((degrees, Dimension::NONE)) => Some(degrees),
            _ => None,
        };
        degrees
            .filter(|degrees| (-360.0..=360.0).contains(degrees))
            .ok_or_else(|| self.wrong(format!("`{key}`: `{value}` is not a direction from -360 to 360 degrees")))
    }

    /// Returns the position and the elevation of a location or of a named place.
    pub(crate) fn place(&self, key: &str, value: &Value) -> MissionResult<(Position, f64)> {
        (self.place_of)(value).ok_or_else(|| self.wrong(format!("`{key}`: `{value}` is not a place of the mission")))
    }
}
