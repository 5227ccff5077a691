//! The links of a flight as remembered by the situation, and the measurements published about them.
//!
//! Published as inputs of the next batch, so that the record contains them: `(good-link-place MODEM)` as the vehicle moves, or, once,
//! `(link-is-the-same-everywhere MODEM)` for a link without a station on the ground, such as that of a satellite;
//! `(contingency-place MODEM)` and `(lost-link-default MODEM)` when the link is lost; `(weak-link-areas AIRCRAFT)` when it is lost or
//! regained. Flown paths avoid these areas.

use super::avoid;
use super::belief::Beliefs;
use super::learned::{Cells, Learned};
use crate::Mission;
use crate::in_air::AirState;
use crate::position::PositionFilter;
use apex_geo::geodesy;
use apex_model::effect::{CommandId, Effect};
use apex_model::event::{Batch, EventKind, StateVariable};
use apex_model::planned::Location;
use apex_model::problem::{AirspaceZone, LandingPlace, Position};
use apex_model::quantity::Dimension;
use apex_model::symbol::Symbol;
use apex_model::time::Time;
use apex_model::value::Value;
use apex_runtime::ports::Input;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A good place is published when it has moved by this many seconds of flight at cruise, or by at least this distance.
const MOVED_S: f64 = 2.0;
const MOVED_M_MIN: f64 = 50.0;
/// Maximum number of remembered links.
const LINKS_MAX: usize = 16;
/// Flight commands with a destination.
const FLIGHTS: [&str; 6] = ["fly-to", "fly-line", "join-line", "loiter", "hover", "land"];

/// Everything remembered of links.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LinkMemory {
    links: BTreeMap<String, Link>,
    here: Option<Location>,
    positions: PositionFilter,
    is_on_ground: bool,
    /// The last flight command, and its goal.
    goal: Option<(CommandId, Position)>,
    /// The areas that were published last.
    areas: Vec<AirspaceZone>,
}

/// One link.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Link {
    /// The name as reported.
    name: String,
    pub(crate) learned: Learned,
    published: Option<Location>,
    /// True if the level does not depend on the place: places teach nothing, and a loss is not one on the way to a place.
    is_everywhere: bool,
}

impl LinkMemory {
    /// Observes a step of the agent that flies; returns the inputs for the next batch.
    pub(crate) fn observe(
        &mut self,
        (mission, air): (&Mission, &AirState),
        batch: &Batch,
        effects: &[Effect],
    ) -> Vec<Input> {
        self.is_on_ground = air.is_on_ground();
        let mut inputs = Vec::new();
        for event in &batch.events {
            match &event.kind {
                EventKind::Measurement(variable, value) => {
                    self.measure(mission, batch.now, (variable, value), &mut inputs);
                }
                EventKind::Occurrence(form) => self.hear(mission, batch.now, form, &mut inputs),
                _ => {}
            }
        }
        for effect in effects {
            match effect {
                Effect::Command { command, form, .. } => self.take_command(mission, *command, form),
                Effect::Inform { form, .. } => self.hear(mission, batch.now, form, &mut inputs),
                _ => {}
            }
        }
        inputs
    }

    fn measure(
        &mut self,
        mission: &Mission,
        at: Time,
        (variable, value): (&StateVariable, &Value),
        inputs: &mut Vec<Input>,
    ) {
        if variable.object.as_symbol() == Some(&mission.agent.name)
            && variable.attribute.is("location")
            && self.positions.admits(mission, at.seconds(), "location", value)
        {
            self.here = Location::from_value(value).or(self.here);
        }
        let level = value.as_number().filter(|(_, unit)| *unit == Dimension::NONE).map(|(level, _)| level);
        let Some((level, here)) = level.filter(|_| variable.attribute.is("signal-level")).zip(self.here) else {
            return;
        };
        let key = variable.object.to_string().to_lowercase();
        if self.is_on_ground || !level.is_finite() || (self.links.len() >= LINKS_MAX && !self.links.contains_key(&key))
        {
            return;
        }
        let cells = Cells::new(mission.start, mission.model.true_airspeed_m_s_cruise);
        let is_new = !self.links.contains_key(&key);
        let link = self.links.entry(key).or_default();
        if is_new {
            link.name = variable.object.to_string();
            link.is_everywhere = has_no_station(mission, &link.name);
            if link.is_everywhere {
                inputs.push(sample(at, "link-is-the-same-everywhere", &link.name, Value::symbol("t")));
            }
        }
        if link.is_everywhere {
            return;
        }
        link.learned.measure(&mission.lost_link, &cells, (at.seconds(), here), level);
        let moved_m = (MOVED_S * mission.model.true_airspeed_m_s_cruise).max(MOVED_M_MIN);
        let Some(good) = link.learned.good_place else { return };
        let has_moved = |before: Location| is_as_far(before.position, good.position, moved_m);
        if link.published.is_none_or(has_moved) {
            link.published = Some(good);
            inputs.push(sample(at, "good-link-place", &link.name, good.value()));
        }
    }

    fn hear(&mut self, mission: &Mission, at: Time, form: &Value, inputs: &mut Vec<Input>) {
        let Some([Value::Symbol(head), name, ..]) = form.as_list() else { return };
        if head.is("communication-regained") {
            inputs.extend(self.new_areas(mission, at));
            return;
        }
        if !head.is("communication-lost") {
            return;
        }
        let (here, goal) = (self.here, self.goal.map(|(_, goal)| goal));
        let (Some(here), Some(link)) = (here, self.links.get_mut(&name.to_string().to_lowercase())) else { return };
        match link.is_everywhere {
            true => link.learned.lose_everywhere(),
            false => link.learned.lose(at.seconds(), here, goal),
        }
        let cells = Cells::new(mission.start, mission.model.true_airspeed_m_s_cruise);
        let default = link.learned.default_of(&mission.lost_link, &cells);
        let name = link.name.clone();
        let place = contingency_place(mission, &name, &link.learned, here);
        inputs.push(sample(at, "contingency-place", &name, place));
        inputs.push(sample(at, "lost-link-default", &name, Value::symbol(default.word())));
        inputs.extend(self.new_areas(mission, at));
    }

    /// Returns the areas that paths avoid from now on; `None` if they have not changed.
    fn new_areas(&mut self, mission: &Mission, at: Time) -> Option<Input> {
        let areas = avoid::weak_areas(mission, &|name| self.link(name));
        if areas == self.areas {
            return None;
        }
        let shown = areas.iter().map(area_value).collect::<Vec<Value>>();
        self.areas = areas;
        Some(sample(at, "weak-link-areas", mission.agent.name.printed(), Value::list(shown)))
    }

    fn take_command(&mut self, mission: &Mission, command: CommandId, form: &Value) {
        let Some([Value::Symbol(head), items @ ..]) = form.as_list() else { return };
        if !FLIGHTS.iter().any(|name| head.is(name)) {
            return;
        }
        let is_option = |item: &&Value| item.as_symbol().is_some_and(|symbol| symbol.folded().starts_with(':'));
        let places = items.iter().take_while(|item| !is_option(item)).filter_map(|item| mission.place(item));
        if let Some((goal, _)) = places.last() {
            self.goal = Some((command, goal));
        }
    }

    /// Returns the mission adapted to the weak links that are known when the vehicle is `here`: zones are added, targets are left out.
    pub(crate) fn without_weak_links(&self, mission: Mission, here: Position) -> Mission {
        avoid::without_weak_links(mission, &|name| self.link(name), here)
    }

    /// Returns true for a link whose level does not depend on the place.
    pub(crate) fn is_everywhere(&self, name: &str) -> bool {
        self.links.get(&name.to_lowercase()).is_some_and(|link| link.is_everywhere)
    }

    /// Returns a link by its name.
    pub(crate) fn link(&self, name: &str) -> Option<&Learned> {
        self.links.get(&name.to_lowercase()).map(|link| &link.learned)
    }
}

/// Returns true for a link of which the mission states that its level does not depend on the place: a modem without a station.
fn has_no_station(mission: &Mission, name: &str) -> bool {
    let is_it = |known: &str| known.eq_ignore_ascii_case(name);
    let is_mapped = mission.link_map.iter().any(|link| is_it(&link.name));
    !is_mapped && mission.modems.iter().any(|modem| is_it(&modem.name) && modem.level.station.is_none())
}

/// Returns true if two places are at least `least_m` apart. A plane chart decides clear cases, because geodesics are expensive.
fn is_as_far(from: Position, to: Position, least_m: f64) -> bool {
    const DEGREE_M: f64 = 111_195.0;
    let north_m = (to.latitude_deg - from.latitude_deg) * DEGREE_M;
    let east_deg = geodesy::wrap_180(to.longitude_deg - from.longitude_deg);
    let chart_m = libm::hypot(north_m, east_deg * DEGREE_M * libm::cos(from.latitude_deg.to_radians()));
    // Below these latitudes the chart is wrong by less than 3 % over some kilometres.
    let is_chart_right = from.latitude_deg.abs() < 80.0 && least_m < 5_000.0;
    match chart_m / least_m {
        share if is_chart_right && share < 0.95 => false,
        share if is_chart_right && (1.05..20.0).contains(&share) => true,
        _ => geodesy::distance_m(from, to) >= least_m,
    }
}

/// Returns the place of `:contingency`; without one the nearest landing place whose link is not known to be weak, then the nearest
/// landing place, then the start of the mission.
fn contingency_place(mission: &Mission, name: &str, learned: &Learned, here: Location) -> Value {
    if let Some(place) = &mission.lost_link.contingency {
        return place.clone();
    }
    let stated = mission.link_map.iter().find(|link| link.name.eq_ignore_ascii_case(name));
    let beliefs = stated.map(|link| Beliefs::new(mission, link, Some(learned)));
    let is_weak = |place: &LandingPlace| {
        beliefs.as_ref().is_some_and(|beliefs| beliefs.weak_at(place.position, here.altitude_m).is_some())
    };
    let places = mission.landing_places();
    let distance_m = |place: &LandingPlace| geodesy::distance_m(here.position, place.position);
    let nearest =
        places.iter().min_by(|a, b| is_weak(a).cmp(&is_weak(b)).then(distance_m(a).total_cmp(&distance_m(b))));
    nearest.map_or_else(|| mission.settings.start.clone(), |place| Value::symbol(&place.name))
}

/// Returns `(NAME TOP CORNER ..)`: the name of an area, its upper face in metres above sea level, and its corners.
fn area_value(area: &AirspaceZone) -> Value {
    let tenth = |degrees: f64| Value::Real(libm::round(degrees * 1e6) / 1e6);
    let corner = |at: &Position| Value::list([tenth(at.latitude_deg), tenth(at.longitude_deg)]);
    let head = [Value::text(&area.name), Value::Real(area.altitude_m_max)];
    Value::list(head.into_iter().chain(area.corners.iter().map(corner)))
}

fn sample(at: Time, attribute: &str, name: &str, value: Value) -> Input {
    let variable = StateVariable::new(Symbol::new(attribute), Value::symbol(name));
    Input::new(at, EventKind::Measurement(variable, value))
}
