//! `:modems ((900MHzModem :station home :full-level 2km) (satellite-link :dropouts ((6h 6.1h))))`

use super::Mission;
use crate::error::{MissionError, MissionResult};
use apex_model::problem::Position;
use apex_model::quantity::Dimension;
use apex_model::value::Value;

/// Distance at which a ground radio is still full where the mission does not say.
const FULL_LEVEL_M: f64 = 1_000.0;

/// A radio between vehicle and ground.
#[derive(Debug, Clone, PartialEq)]
pub struct Modem {
    /// Its name: the object of `signal-level`, for example `900MHzModem`.
    pub name: String,
    /// Where the ground station is; none for a satellite link, whose level does not fall with distance.
    pub station: Option<Position>,
    /// Distance at which the level is still full, m.
    pub full_level_m: f64,
    /// Spans `(from_s, until_s)` without any signal.
    pub dropouts_s: Vec<(f64, f64)>,
}

/// Reads the radios of a mission; none without the option.
///
/// # Errors
/// A form of another shape, a station that is no place.
pub(crate) fn read(mission: &Mission) -> MissionResult<Vec<Modem>> {
    let forms = &mission.settings.modems;
    forms.iter().map(|form| modem(mission, form)).collect()
}

fn modem(mission: &Mission, form: &Value) -> MissionResult<Modem> {
    let wrong = |what: String| {
        MissionError::setting(format!("in :modems, {form}: {what}"))
            .at(&mission.settings.place)
            .help("write (NAME :station PLACE :full-level 2km), or (NAME) for a satellite link; :dropouts ((6h 6.5h)) is optional")
    };
    let items = form.as_list().unwrap_or_default();
    let Some((Value::Symbol(name), options)) = items.split_first() else {
        return Err(wrong("it does not begin with a name".to_string()));
    };
    let mut modem =
        Modem { name: name.printed().to_string(), station: None, full_level_m: FULL_LEVEL_M, dropouts_s: Vec::new() };
    for pair in options.chunks(2) {
        let [Value::Symbol(key), value] = pair else { return Err(wrong("an option has no value".to_string())) };
        match key.folded() {
            ":station" => {
                let (station, _) =
                    mission.place(value).ok_or_else(|| wrong(format!("the station `{value}` is no place")))?;
                modem.station = Some(station);
            }
            ":full-level" => match value.as_number() {
                Some((metres, Dimension::LENGTH | Dimension::NONE)) if metres > 0.0 => modem.full_level_m = metres,
                _ => return Err(wrong(format!("`:full-level {value}` is no length"))),
            },
            ":dropouts" => {
                modem.dropouts_s =
                    dropouts(value).ok_or_else(|| wrong(format!("`:dropouts {value}` is no list of spans")))?;
            }
            other => return Err(wrong(format!("unknown option {other}"))),
        }
    }
    Ok(modem)
}

fn dropouts(value: &Value) -> Option<Vec<(f64, f64)>> {
    let span = |item: &Value| match item.as_list()? {
        [Value::Duration(from), Value::Duration(until)] if from < until => Some((from.seconds(), until.seconds())),
        _ => None,
    };
    value.as_list()?.iter().map(span).collect()
}
