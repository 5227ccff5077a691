//! `:modems`: the radios of a mission's simulated world (docs/reference/mission-data.md, "Radio links").
//!
//! The planner does not read them: it assumes the contents of `:link-map` and uses the measurements of the flight.

use super::Mission;
use crate::error::MissionResult;
use crate::link_form::LinkForm;
use crate::link_level::{KEYS, LevelReader};
use apex_geo::link::LevelModel;
use apex_model::quantity::Dimension;
use apex_model::value::Value;

/// Standard deviation of the fading, if the mission does not state it: ground radio, satellite link.
const FADING_DB: (f64, f64) = (3.0, 1.0);
const FADING_DB_MAX: f64 = 30.0;
const USAGE: &str = "`(NAME :station PLACE :full-level 2km :range 9km :shadows ((:around PLACE :radius 300m :factor 0.1)) \
                     :fading-db 3 :dropouts ((6h 6.5h)))`, all but NAME optional; without a station it is a satellite link";

/// A radio between vehicle and ground in the simulated world.
#[derive(Debug, Clone, PartialEq)]
pub struct Modem {
    /// Its name: the object of `signal-level`, for example `900MHzModem`.
    pub name: String,
    /// Its level by place.
    pub level: LevelModel,
    /// Standard deviation of the fading, dB.
    pub fading_db: f64,
    /// Spans `(from_s, until_s)` without any signal.
    pub dropouts_s: Vec<(f64, f64)>,
}

/// Reads the radios of a mission; empty without the option.
///
/// # Errors
/// A form of another shape, a figure of another type or outside of its range, a station that is not a place, a name twice.
pub(crate) fn read(mission: &Mission) -> MissionResult<Vec<Modem>> {
    let mut modems: Vec<Modem> = Vec::new();
    for form in &mission.settings.modems {
        let place_of = |value: &Value| mission.place(value);
        let form = LinkForm {
            at: mission.settings.place_of("modems"),
            option: "modems",
            form,
            usage: USAGE,
            place_of: &place_of,
        };
        let modem = modem(&form)?;
        if modems.iter().any(|known| known.name.eq_ignore_ascii_case(&modem.name)) {
            return Err(form.wrong(format!("the modem `{}` is stated twice", modem.name)));
        }
        modems.push(modem);
    }
    Ok(modems)
}

fn modem(form: &LinkForm<'_>) -> MissionResult<Modem> {
    let items = form.form.as_list().unwrap_or_default();
    let Some((Value::Symbol(name), options)) = items.split_first() else {
        return Err(form.wrong("it does not begin with a name".to_string()));
    };
    let mut level = LevelReader::default();
    let (mut fading_db, mut dropouts_s) = (None, Vec::new());
    for (key, value) in form.pairs(options)? {
        match key {
            ":fading-db" => match value.as_number() {
                Some((db, Dimension::NONE)) if (0.0..=FADING_DB_MAX).contains(&db) => fading_db = Some(db),
                _ => return Err(form.wrong(format!("`:fading-db {value}` is not a number from 0 to {FADING_DB_MAX}"))),
            },
            ":dropouts" => {
                dropouts_s = dropouts(value).ok_or_else(|| {
                    form.wrong(format!("`:dropouts {value}` is not a list of spans, each of two durations that rise"))
                })?;
            }
            key if level.take(form, key, value)? => {}
            other => return Err(form.unknown(other, &format!("{KEYS}, :fading-db, :dropouts"))),
        }
    }
    let level = level.finish(form)?;
    let fading_db = fading_db.unwrap_or(if level.station.is_some() { FADING_DB.0 } else { FADING_DB.1 });
    Ok(Modem { name: name.printed().to_string(), level, fading_db, dropouts_s })
}

fn dropouts(value: &Value) -> Option<Vec<(f64, f64)>> {
    let span = |item: &Value| match item.as_list()? {
        [Value::Duration(from), Value::Duration(until)] if from < until => Some((from.seconds(), until.seconds())),
        _ => None,
    };
    value.as_list()?.iter().map(span).collect()
}
