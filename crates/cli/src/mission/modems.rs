//! `:modems ((900MHzModem :station home :full-level 2km) (satellite-link :dropouts ((6h 6.1h))))`

use super::Mission;
use crate::trouble::{Outcome, Trouble};
use apex_model::quantity::Dimension;
use apex_model::value::Value;
use apex_sim::Modem;

/// Distance at which a ground radio is still full where the mission does not say.
const FULL_LEVEL_M: f64 = 1_000.0;

/// Reads the radios of a mission; none without the option.
///
/// # Errors
/// A form of another shape, a station that is no place.
pub fn read(mission: &Mission) -> Outcome<Vec<Modem>> {
    let forms = &mission.settings.modems;
    forms.iter().map(|form| modem(mission, form)).collect()
}

fn modem(mission: &Mission, form: &Value) -> Outcome<Modem> {
    let wrong = |what: String| {
        Trouble::user(format!("{}: in :modems, {form}: {what}", mission.settings.place))
            .help("write (NAME :station PLACE :full-level 2km), or (NAME) for a satellite link; :dropouts ((6h 6.5h)) is optional")
    };
    let items = form.as_list().unwrap_or_default();
    let Some((Value::Symbol(name), options)) = items.split_first() else {
        return Err(wrong("it does not begin with a name".to_string()));
    };
    let mut modem = Modem::satellite(name.printed());
    for pair in options.chunks(2) {
        let [Value::Symbol(key), value] = pair else { return Err(wrong("an option has no value".to_string())) };
        match key.folded() {
            ":station" => {
                let (station, _) =
                    mission.place(value).ok_or_else(|| wrong(format!("the station `{value}` is no place")))?;
                modem =
                    Modem { dropouts_s: modem.dropouts_s, ..Modem::at_station(name.printed(), station, FULL_LEVEL_M) };
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
