//! `:vehicle` of an application: `(sim :model NAME|"FILE" :at PLACE [:heading ANGLE])`.

use crate::error::{MissionError, MissionResult};
use apex_model::library::{Application, Library};
use apex_model::quantity::Dimension;
use apex_model::value::Value;

/// Source of a mission's vehicle model.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ModelSource {
    /// A model that ships with Apex, by name.
    Shipped(String),
    /// A vehicle file, relative to the mission's folder.
    File(String),
}

/// `:vehicle` of an application.
pub(crate) struct StatedVehicle {
    /// Source of the model.
    pub(crate) model: ModelSource,
    /// Start: a location or the name of a place in the data.
    pub(crate) start: Value,
    /// Heading of the parked vehicle at the start, in degrees clockwise from north.
    pub(crate) heading_deg: f64,
}

const WANTED: &str = "`:vehicle (sim :model NAME :at PLACE)`, or the name of a vehicle file in quotes for NAME; optional: `:heading 90deg`";

/// Reads `:vehicle` of the application of `library`.
///
/// # Errors
/// No vehicle, or a form of another shape.
pub(crate) fn vehicle_of(application: &Application, library: &Library) -> MissionResult<StatedVehicle> {
    let place = || library.describe_place(application.option_place("vehicle"));
    let Some(form) = application.option("vehicle") else {
        return Err(MissionError::setting("the mission names no vehicle")
            .at(place())
            .help("add `:vehicle (sim :model predator-b :at (34.9 -117.9))`, or use `apex run`"));
    };
    let items = form.as_list().unwrap_or_default();
    let wrong = |form: &Value| {
        MissionError::setting(format!("`:vehicle {form}` cannot be read")).at(place()).help(format!("write {WANTED}"))
    };
    match items.first() {
        Some(Value::Symbol(kind)) if kind.is("sim") => {}
        Some(Value::Symbol(kind)) => {
            return Err(MissionError::setting(format!("unknown kind of vehicle `{kind}`"))
                .at(place())
                .because("only the built-in simulator `sim` can be flown so far")
                .help(format!("write {WANTED}")));
        }
        _ => return Err(wrong(form)),
    }
    let mut model = None;
    let mut start = None;
    let mut heading_deg = 0.0;
    for pair in items.get(1..).unwrap_or_default().chunks(2) {
        match pair {
            [Value::Symbol(key), Value::Symbol(name)] if key.is(":model") => {
                model = Some(ModelSource::Shipped(name.folded().to_string()));
            }
            [Value::Symbol(key), Value::Text(file)] if key.is(":model") => {
                model = Some(ModelSource::File(file.to_string()));
            }
            [Value::Symbol(key), place] if key.is(":at") => start = Some(place.clone()),
            [Value::Symbol(key), angle] if key.is(":heading") => {
                heading_deg = heading(angle).ok_or_else(|| wrong(form))?;
            }
            _ => return Err(wrong(form)),
        }
    }
    match (model, start) {
        (Some(model), Some(start)) => Ok(StatedVehicle { model, start, heading_deg }),
        _ => Err(wrong(form)),
    }
}

/// Returns the degrees of a heading from 0 to 360: an angle, or a bare number in degrees.
fn heading(value: &Value) -> Option<f64> {
    let degrees = match value.as_number()? {
        (radians, Dimension::ANGLE) => radians.to_degrees(),
        (degrees, Dimension::NONE) => degrees,
        _ => return None,
    };
    (0.0..=360.0).contains(&degrees).then_some(degrees)
}
