//! `:link-map`: the radios as the planner assumes them before any measurement.

use crate::error::MissionResult;
use crate::link_form::{LinkForm, PlaceOf};
use crate::link_level::{KEYS, LevelReader};
use apex_geo::link::LevelModel;
use apex_model::problem::Position;
use apex_model::value::Value;

const USAGE: &str = "`(NAME :station PLACE :full-level 2km :range 9km :shadows ((:around PLACE :radius 300m :factor 0.1)))`, \
                     all but NAME and :station optional";

/// A radio as stated to the planner.
#[derive(Debug, Clone, PartialEq)]
pub struct StatedLink {
    /// Its name, as in `signal-level`.
    pub name: String,
    /// Position of its station.
    pub station: Position,
    /// Its level by place; `None` if the mission states nothing, and the flight measures it.
    pub level: Option<LevelModel>,
}

/// Reads the forms of a mission's link map; `at` is the place of the application. Of ground radios that it does not name, only their
/// `stations` are assumed.
///
/// # Errors
/// A form of another shape, a figure of another type or outside of its range, no station, a name twice.
pub(crate) fn read(
    (forms, at): (&[Value], &str),
    place_of: PlaceOf<'_>,
    stations: impl Iterator<Item = (String, Position)>,
) -> MissionResult<Vec<StatedLink>> {
    let mut links: Vec<StatedLink> = Vec::new();
    for form in forms {
        let form = LinkForm { at, option: "link-map", form, usage: USAGE, place_of };
        let items = form.form.as_list().unwrap_or_default();
        let Some((Value::Symbol(name), options)) = items.split_first() else {
            return Err(form.wrong("it does not begin with a name".to_string()));
        };
        let mut reader = LevelReader::default();
        for (key, value) in form.pairs(options)? {
            if !reader.take(&form, key, value)? {
                return Err(form.unknown(key, KEYS));
            }
        }
        let level = reader.finish(&form)?;
        let Some(station) = level.station else {
            return Err(form.wrong(
                "it has no `:station`: the level of a satellite link does not depend on the place".to_string(),
            ));
        };
        if links.iter().any(|known| known.name.eq_ignore_ascii_case(name.folded())) {
            return Err(form.wrong(format!("the link `{name}` is stated twice")));
        }
        links.push(StatedLink { name: name.printed().to_string(), station, level: Some(level) });
    }
    // Of other ground radios only the station's place is known: the figures belong to the simulated world.
    for (name, station) in stations {
        if !links.iter().any(|known| known.name.eq_ignore_ascii_case(&name)) {
            links.push(StatedLink { name, station, level: None });
        }
    }
    Ok(links)
}
