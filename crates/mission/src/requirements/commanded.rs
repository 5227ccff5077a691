//! The commanded route: the open flight command, and the last reported state of the vehicle.

use super::ice::IceMemory;
use crate::Mission;
use crate::wind_error::WindError;
use apex_geo::geodesy::{inverse, wrap_180};
use apex_geo::wind::Wind;
use apex_model::effect::{CommandId, Effect};
use apex_model::event::{EventKind, StateVariable};
use apex_model::planned::Location;
use apex_model::problem::Position;
use apex_model::quantity::Dimension;
use apex_model::value::Value;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Order of a flight command.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) enum FlightOrder {
    /// Climb from the ground; the point is the centre of the circle of the climb, once it is known.
    TakeOff(Vec<Position>),
    /// Over these points; the last one is the goal.
    FlyBy(Vec<Position>),
    /// To the first point of a line and along it, over the points before it.
    Line(Vec<Position>),
    /// To the circle around the last point.
    Circle(Vec<Position>),
    /// To the last point, and stay there.
    Stay(Vec<Position>),
    /// To the last point, and land there.
    Land(Vec<Position>),
}

/// Flight commands so far, computed from effects and acknowledgements.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Commanded {
    /// The flight command that is open.
    pub(super) order: Option<FlightOrder>,
    command: Option<CommandId>,
    /// Altitude that was commanded last, for the end of the route.
    altitude_m: Option<f64>,
    /// Altitude of the last flight command, whatever altitude is set meanwhile because of ice.
    pub(super) planned_m: Option<f64>,
    /// Number of points ahead before the goal, and the altitude of the path over them.
    via: (usize, Option<f64>),
    /// Beginning of the leg to the first point.
    leg_from: Option<Position>,
    /// Instant, in seconds of mission time, until which the vehicle circles or hovers before it leaves.
    hold_until_s: Option<f64>,
    /// Centre of the circle on which a fixed wing waits before it leaves or without a command; `None` until the next position.
    circle: Option<Position>,
    /// Airspeed that was commanded last.
    pub(super) true_airspeed_mps: Option<f64>,
    /// Place at which a contingency lands, with its elevation: the zones around it are broken on purpose.
    pub(super) landing_at: Option<(Position, f64)>,
    /// Number of changes of the order: a change is evaluated at once.
    pub(super) changes: u32,
}

impl Commanded {
    /// Takes an effect at `now_s`; `place` finds places by name.
    pub(super) fn take(&mut self, now_s: f64, effect: &Effect, place: impl Fn(&Value) -> Option<(Position, f64)>) {
        match effect {
            Effect::Command { command, form, .. } => self.begin(now_s, *command, form, place),
            Effect::WithdrawCommand { command, .. } => self.end(*command),
            Effect::Inform { form, .. } => {
                if let Some([Value::Symbol(head), _, to]) = form.as_list()
                    && (head.is("landing-because") || head.is("engine-out"))
                {
                    self.landing_at = place(to);
                }
            }
            _ => {}
        }
    }

    /// Takes an event.
    pub(super) fn hear(&mut self, event: &EventKind) {
        if let EventKind::CommandAcknowledged(command, _) = event {
            self.end(*command);
        }
    }

    /// Returns true while a landing is commanded.
    pub(super) fn lands(&self) -> bool {
        matches!(self.order, Some(FlightOrder::Land(_)))
    }

    /// Returns the altitude that the vehicle flies at now, or climbs or descends to.
    pub(super) fn altitude_m(&self) -> Option<f64> {
        match self.via {
            (1.., Some(altitude_m)) => Some(altitude_m),
            _ => self.altitude_m,
        }
    }

    /// Drops the points of the path that are passed: those behind the end of their leg, those at which a vehicle that hovers has arrived,
    /// and, at the beginning of the command, those less than `behind_m` behind the vehicle (0 for a vehicle that hovers: it flies back);
    /// only these depend on the track, so `track_deg` is called for them alone. While the vehicle waits, it passes nothing.
    pub(super) fn pass(&mut self, here: Position, (now_s, behind_m): (f64, f64), track_deg: impl Fn() -> f64) {
        self.circle.get_or_insert(here);
        if self.order_at(now_s).is_none() {
            return;
        }
        let Some(points) = self.order.as_mut().and_then(FlightOrder::points_mut) else { return };
        let track = || {
            let track_rad = track_deg().to_radians();
            (libm::sin(track_rad), libm::cos(track_rad))
        };
        while let (1.., Some(first)) = (self.via.0, points.first().copied()) {
            let beyond = offset_m(first, here);
            let distance_m = libm::hypot(beyond.0, beyond.1);
            let is_passed = match self.leg_from {
                _ if behind_m <= 0.0 && distance_m <= ARRIVED_M => true,
                Some(from) => dot(beyond, offset_m(from, first)) >= 0.0,
                None => distance_m < behind_m && dot(beyond, track()) > 0.0,
            };
            if !is_passed {
                self.leg_from.get_or_insert(here);
                return;
            }
            points.remove(0);
            self.via.0 -= 1;
            self.leg_from = self.leg_from.map(|_| first);
        }
    }

    /// Notes the place at which a fixed wing that takes off begins to turn.
    pub(super) fn begin_turns(&mut self, here: Position) {
        if let Some(FlightOrder::TakeOff(centre)) = &mut self.order
            && centre.is_empty()
        {
            centre.push(here);
        }
    }

    /// Returns the centre of the circle of a vehicle that waits or has no command.
    pub(super) fn circle(&self) -> Option<Position> {
        self.circle
    }

    fn end(&mut self, command: CommandId) {
        if self.command == Some(command) {
            (self.order, self.command, self.circle) = (None, None, None);
            self.changes = self.changes.wrapping_add(1);
        }
    }

    /// Returns the order that is flown at `now_s`: none while the vehicle holds.
    pub(super) fn order_at(&self, now_s: f64) -> Option<&FlightOrder> {
        self.order.as_ref().filter(|_| self.hold_until_s.is_none_or(|until_s| now_s >= until_s))
    }

    fn begin(
        &mut self,
        now_s: f64,
        command: CommandId,
        form: &Value,
        place: impl Fn(&Value) -> Option<(Position, f64)>,
    ) {
        let Some([Value::Symbol(name), items @ ..]) = form.as_list() else { return };
        let places = items.iter().take_while(|item| !is_keyword(item));
        let ends: Vec<(Position, f64)> = places.filter_map(&place).collect();
        let (mut points, via_altitude_m) = via(items);
        let via_count = points.len();
        points.extend(ends.iter().map(|(position, _)| *position));
        let order = match name.folded() {
            "take-off" => {
                FlightOrder::TakeOff(keyword(items, ":centre").and_then(&place).map(|at| at.0).into_iter().collect())
            }
            "fly-to" => FlightOrder::FlyBy(points),
            // After a join the vehicle continues along the line.
            "fly-line" | "join-line" => FlightOrder::Line(points),
            "loiter" => {
                if let Some(((centre, _), last)) = keyword(items, ":centre").and_then(&place).zip(points.last_mut()) {
                    *last = centre;
                }
                FlightOrder::Circle(points)
            }
            "hover" => FlightOrder::Stay(points),
            "land" => FlightOrder::Land(points),
            "set-altitude" => {
                self.altitude_m = items.first().and_then(|value| number(value, Dimension::LENGTH)).or(self.altitude_m);
                // It replaces the altitudes of the way, too, except those of a landing.
                if !matches!(self.order, Some(FlightOrder::Land(_))) {
                    self.via.1 = None;
                }
                return;
            }
            "set-speed" => {
                self.true_airspeed_mps =
                    items.first().and_then(|value| number(value, Dimension::SPEED)).or(self.true_airspeed_mps);
                return;
            }
            _ => return,
        };
        let lands = matches!(order, FlightOrder::Land(_));
        let stated = keyword(items, ":altitude").and_then(|value| number(value, Dimension::LENGTH));
        let with_location = items.iter().find_map(with_altitude).filter(|_| !lands);
        let taken_off = (name.is("take-off")).then(|| items.first().and_then(|value| number(value, Dimension::LENGTH)));
        let altitude_m = stated.or(with_location).or(taken_off.flatten());
        self.altitude_m = altitude_m.or(self.altitude_m);
        self.planned_m = altitude_m.or(self.planned_m);
        let speed = keyword(items, ":speed").and_then(|value| number(value, Dimension::SPEED));
        self.true_airspeed_mps = speed.or(self.true_airspeed_mps);
        (self.order, self.command) = (Some(order), Some(command));
        (self.via, self.leg_from) = ((via_count, via_altitude_m), None);
        let hold_s = keyword(items, ":hold").and_then(|value| number(value, Dimension::TIME));
        self.hold_until_s = hold_s.map(|hold_s| now_s + hold_s);
        self.circle = keyword(items, ":hold-around").and_then(&place).map(|at| at.0);
        self.changes = self.changes.wrapping_add(1);
    }
}

/// Reads `:via (LOCATION ..)`: points before the goal, and the altitude of the first.
fn via(items: &[Value]) -> (Vec<Position>, Option<f64>) {
    let points = keyword(items, ":via").and_then(Value::as_list).unwrap_or_default();
    let positions = points.iter().filter_map(Location::from_value).map(|location| location.position).collect();
    (positions, points.first().and_then(with_altitude))
}

impl FlightOrder {
    /// Returns the points ahead.
    fn points_mut(&mut self) -> Option<&mut Vec<Position>> {
        match self {
            FlightOrder::TakeOff(_) => None,
            FlightOrder::FlyBy(points)
            | FlightOrder::Line(points)
            | FlightOrder::Circle(points)
            | FlightOrder::Stay(points)
            | FlightOrder::Land(points) => Some(points),
        }
    }
}

/// Minimum time between two temperatures that are compared.
const WARMING_SPAN_S: f64 = 5.0;
/// Time of flight up to which a point behind a fixed wing counts as passed: it was passed while the command was on its way.
pub(super) const BEHIND_S: f64 = 20.0;
/// Distance from a point at which a vehicle that hovers has arrived there.
const ARRIVED_M: f64 = 5.0;
const DEGREE_M: f64 = 111_195.0;

/// Returns the offset to the east and north of one position from another on a plane chart, used only to determine the side of a line.
fn offset_m(from: Position, to: Position) -> (f64, f64) {
    let east = libm::cos(from.latitude_deg.to_radians()) * DEGREE_M;
    (wrap_180(to.longitude_deg - from.longitude_deg) * east, (to.latitude_deg - from.latitude_deg) * DEGREE_M)
}

fn dot(a: (f64, f64), b: (f64, f64)) -> f64 {
    a.0 * b.0 + a.1 * b.1
}

fn is_keyword(item: &Value) -> bool {
    item.as_symbol().is_some_and(|symbol| symbol.folded().starts_with(':'))
}

fn keyword<'a>(items: &'a [Value], name: &str) -> Option<&'a Value> {
    let place = items.iter().position(|item| item.as_symbol().is_some_and(|symbol| symbol.is(name)))?;
    items.get(place + 1)
}

fn number(value: &Value, unit: Dimension) -> Option<f64> {
    value.as_number().filter(|(_, found)| *found == unit || *found == Dimension::NONE).map(|(si, _)| si)
}

/// Returns the altitude of a location, if it states one.
fn with_altitude(item: &Value) -> Option<f64> {
    let items = item.as_list().filter(|items| items.len() == 3)?;
    let altitude = items.get(2).and_then(|value| number(value, Dimension::LENGTH));
    altitude.filter(|_| Location::from_value(item).is_some())
}

/// Last reported state of the vehicle, as far as requirements need it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Flown {
    pub(super) position: Option<Position>,
    pub(super) altitude_m: f64,
    pub(super) height_above_ground_m: Option<f64>,
    pub(super) true_airspeed_mps: Option<f64>,
    pub(super) ground_speed_mps: Option<f64>,
    pub(super) endurance_s: Option<f64>,
    /// Fuel left, and the charge of the battery as a share of its capacity.
    pub(super) fuel_kg: Option<f64>,
    pub(super) charge: Option<f64>,
    pub(super) edr: Option<f64>,
    pub(super) wind_mps: Option<f64>,
    wind_from_deg: Option<f64>,
    /// Error of the forecast of the wind.
    pub(super) wind_error: WindError,
    pub(super) is_on_ground: bool,
    /// Taking off or landing, near the ground on purpose; `None` for a vehicle that does not report its flight phase.
    pub(super) is_near_ground: Option<bool>,
    pub(super) heading_deg: Option<f64>,
    /// Cameras by their names.
    pub(super) cameras: BTreeMap<String, ReportedCamera>,
    pub(super) outside_k: Option<f64>,
    /// Seconds of ice that the airframe carries.
    pub(super) ice_s: Option<f64>,
    pub(super) is_icing: bool,
    /// Ice that was met.
    pub(super) ice: IceMemory,
    /// True once a link has reported its level.
    pub(super) has_signal_level: bool,
    /// Instants since when links, by their names in small letters, have been below their nominal level.
    pub(super) weak_since_s: BTreeMap<String, f64>,
    track_deg: Option<f64>,
    /// The preceding position, for vehicles that report no track.
    previous: Option<Position>,
}

impl Flown {
    /// Takes a sample; returns true if the position is new.
    pub(super) fn measure(&mut self, attribute: &str, value: &Value) -> bool {
        let of = |unit: Dimension| number(value, unit);
        match attribute {
            "location" => {
                let Some(location) = Location::from_value(value) else { return false };
                if self.position != Some(location.position) {
                    self.previous = self.position;
                }
                (self.position, self.altitude_m) = (Some(location.position), location.altitude_m);
                return true;
            }
            "height-above-ground" => self.height_above_ground_m = of(Dimension::LENGTH),
            "true-airspeed" => self.true_airspeed_mps = of(Dimension::SPEED),
            "ground-speed" => self.ground_speed_mps = of(Dimension::SPEED),
            "wind-speed" => self.wind_mps = of(Dimension::SPEED),
            "wind-direction" => self.wind_from_deg = of(Dimension::ANGLE).map(f64::to_degrees),
            "edr" => self.edr = of(Dimension::NONE),
            "heading" => self.heading_deg = of(Dimension::ANGLE).map(f64::to_degrees),
            "track" => self.track_deg = of(Dimension::ANGLE).map(f64::to_degrees),
            "endurance-remaining" => self.endurance_s = of(Dimension::TIME),
            "fuel" => self.fuel_kg = of(Dimension::MASS),
            "battery-charge" => self.charge = of(Dimension::NONE),
            "outside-temperature" => self.outside_k = of(Dimension::TEMPERATURE),
            "ice-exposure" => self.ice_s = of(Dimension::TIME),
            "icing" => self.is_icing = value.is_true(),
            "flight-phase" => {
                let word = value.as_symbol().map_or("", |symbol| symbol.folded());
                self.is_near_ground = Some(matches!(
                    word,
                    "parked" | "taking-off" | "climbing" | "approaching" | "landing" | "gliding" | "crashed"
                ));
            }
            _ => {}
        }
        false
    }

    /// Takes a sample of a camera or a modem.
    pub(super) fn measure_part(&mut self, mission: &Mission, at_s: f64, variable: &StateVariable, value: &Value) {
        let attribute = variable.attribute.folded();
        let name = || variable.object.to_string().to_lowercase();
        if attribute.starts_with("camera-") || attribute == "detector-temperature" {
            self.cameras.entry(name()).or_default().measure(attribute, value, at_s);
        } else if attribute == "signal-level"
            && mission.requirements.link_lost_s.is_some()
            && let Some(level) = number(value, Dimension::NONE)
        {
            self.has_signal_level = true;
            if level >= mission.lost_link.nominal {
                self.weak_since_s.remove(&name());
            } else {
                self.weak_since_s.entry(name()).or_insert(at_s);
            }
        }
    }

    /// Returns the wind as last measured; none where the vehicle reports none.
    pub(super) fn wind(&self) -> Option<Wind> {
        let (speed_mps, from_rad) = (self.wind_mps?, self.wind_from_deg?.to_radians());
        let edr = self.edr.unwrap_or(0.0);
        Some(Wind { east_mps: -speed_mps * libm::sin(from_rad), north_mps: -speed_mps * libm::cos(from_rad), edr })
    }

    /// Returns the direction of flight over ground, clockwise from north; without a reported track that between the last two positions,
    /// otherwise 0.
    pub(super) fn track_deg(&self) -> f64 {
        // Geodesics are expensive: none for a vehicle that reports its track, one for the others.
        let between = || {
            let (from, to) = self.previous.zip(self.position)?;
            let (distance_m, azimuth_deg) = inverse(from, to);
            (distance_m > 1.0).then_some(azimuth_deg)
        };
        self.track_deg.or_else(between).unwrap_or(0.0)
    }
}

/// A camera as last reported.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct ReportedCamera {
    /// From the horizon up.
    pub(super) tilt_deg: f64,
    /// From the nose clockwise.
    pub(super) pan_deg: f64,
    /// True while the camera slews, points or exposes.
    pub(super) is_pointing: bool,
    /// True once the camera has slewed, pointed or exposed.
    pub(super) has_pointed: bool,
    /// Last compared temperature of its detector, and its instant.
    pub(super) detector_k: Option<f64>,
    detector_s: f64,
    /// Rate between the last two compared temperatures, K/s; they are at least [`WARMING_SPAN_S`] apart.
    pub(super) warming_k_s: Option<f64>,
}

impl ReportedCamera {
    /// Takes a sample of the camera.
    pub(super) fn measure(&mut self, attribute: &str, value: &Value, at_s: f64) {
        let angle_deg = || number(value, Dimension::ANGLE).map(f64::to_degrees);
        match attribute {
            "camera-tilt" => self.tilt_deg = angle_deg().unwrap_or(self.tilt_deg),
            "camera-pan" => self.pan_deg = angle_deg().unwrap_or(self.pan_deg),
            "detector-temperature" => {
                let Some(detector_k) = number(value, Dimension::TEMPERATURE) else { return };
                let span_s = at_s - self.detector_s;
                if self.detector_k.is_some() && span_s < WARMING_SPAN_S {
                    return;
                }
                self.warming_k_s = self.detector_k.map(|before_k| (detector_k - before_k) / span_s);
                (self.detector_k, self.detector_s) = (Some(detector_k), at_s);
            }
            "camera-state" => {
                let word = value.as_symbol().map_or("", |symbol| symbol.folded());
                self.is_pointing = matches!(word, "slewing" | "pointing" | "exposing");
                self.has_pointed |= self.is_pointing;
            }
            _ => {}
        }
    }
}

#[cfg(test)]
#[path = "commanded_tests.rs"]
mod tests;
