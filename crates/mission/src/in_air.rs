//! Whether the aircraft is in the air: as it reports, otherwise derived from its commands, its messages and its positions.
//!
//! Unknown never counts as "on the ground". A vehicle that reports neither `on-ground` nor `flight-phase` is on the ground until a
//! flight command is acknowledged, it says `(airborne ..)`, or it leaves the place and the height of its first position; then it is in
//! the air until a landing is acknowledged, or it says `(landed ..)` or `(crashed ..)`.
//! Bound: O(1) per sample, O(log n) in open commands per command.

use apex_geo::geodesy;
use apex_model::effect::{CommandId, Effect};
use apex_model::event::{Batch, EventKind};
use apex_model::planned::Location;
use apex_model::value::Value;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Flight commands other than take-off and landing: a vehicle that executed one of them is in the air.
const FLIGHTS: [&str; 5] = ["fly-to", "fly-line", "join-line", "loiter", "hover"];
/// Phases of flight on the ground.
const GROUND_PHASES: [&str; 2] = ["parked", "crashed"];
/// Height over ground from which on the vehicle is in the air, whatever its commands are: more than the error of such a height.
const ALOFT_M: f64 = 5.0;
/// Distance and difference of altitude within which a vehicle counts as standing at a place: errors of satellite navigation.
const STANDS_M: (f64, f64) = (50.0, 15.0);
/// Maximum number of open commands that are remembered; a vehicle has few.
const COMMANDS_MAX: usize = 64;

/// Kind of an open flight command.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
enum FlightKind {
    TakeOff,
    Flight,
    Land,
}

/// Knowledge about whether the aircraft is in the air.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct AirState {
    /// `on-ground` as last reported.
    on_ground: Option<bool>,
    /// True if the last reported `flight-phase` is one on the ground.
    ground_phase: Option<bool>,
    has_height: bool,
    has_ground_speed: bool,
    height_m: Option<f64>,
    /// True if the commands, messages and positions show that it is in the air.
    is_aloft: bool,
    /// Place at which the vehicle was on the ground.
    stands_at: Option<Location>,
    open: BTreeMap<CommandId, FlightKind>,
    has_told_missing: bool,
}

impl AirState {
    /// Takes the reports and answers of a batch, then the commands of its step. `is_vehicle` is true for the objects whose measurements
    /// are those of the vehicle.
    pub(crate) fn observe(&mut self, batch: &Batch, effects: &[Effect], is_vehicle: impl Fn(&Value) -> bool) {
        for event in &batch.events {
            match &event.kind {
                EventKind::Measurement(variable, value) if is_vehicle(&variable.object) => {
                    self.measure(variable.attribute.folded(), value);
                }
                kind => self.hear(kind),
            }
        }
        effects.iter().for_each(|effect| self.take(effect));
    }

    /// Takes a sample of the vehicle.
    pub(crate) fn measure(&mut self, attribute: &str, value: &Value) {
        match attribute {
            "on-ground" => self.on_ground = Some(value.is_true()),
            "flight-phase" => {
                let phase = value.as_symbol().map(|phase| phase.folded());
                self.ground_phase = phase.map(|phase| GROUND_PHASES.contains(&phase)).or(self.ground_phase);
            }
            "ground-speed" => self.has_ground_speed = true,
            "height-above-ground" => {
                self.height_m = value.as_number().map(|(metres, _)| metres);
                self.has_height |= self.height_m.is_some();
                self.is_aloft |= self.height_m.is_some_and(|height_m| height_m > ALOFT_M);
            }
            "location" => {
                if let Some(here) = Location::from_value(value) {
                    self.locate(here);
                }
            }
            _ => {}
        }
    }

    fn locate(&mut self, here: Location) {
        if self.is_aloft {
            return;
        }
        let place = *self.stands_at.get_or_insert(here);
        let is_low = self.height_m.is_some_and(|height_m| height_m <= ALOFT_M);
        let climbed = (here.altitude_m - place.altitude_m).abs() > STANDS_M.1;
        // Geodesics are expensive: a vehicle that stands repeats its position.
        let moved =
            || here.position != place.position && geodesy::distance_m(place.position, here.position) > STANDS_M.0;
        self.is_aloft = !is_low && (climbed || moved());
    }

    /// Takes an event that is not a measurement of the vehicle.
    pub(crate) fn hear(&mut self, kind: &EventKind) {
        match kind {
            EventKind::Occurrence(form) => match form.head().map(|head| head.folded()) {
                Some("airborne") => self.is_aloft = true,
                Some("landed" | "crashed") => self.stand(),
                _ => {}
            },
            EventKind::CommandAcknowledged(command, result) => match (self.open.remove(command), result) {
                (Some(FlightKind::TakeOff | FlightKind::Flight), Ok(_)) => self.is_aloft = true,
                (Some(FlightKind::Land), Ok(_)) => self.stand(),
                _ => {}
            },
            _ => {}
        }
    }

    /// The vehicle is on the ground, where it reports its next position.
    fn stand(&mut self) {
        (self.is_aloft, self.stands_at, self.height_m) = (false, None, None);
    }

    /// Takes an effect.
    pub(crate) fn take(&mut self, effect: &Effect) {
        match effect {
            Effect::Command { command, form, .. } => {
                let Some(head) = form.head().map(|head| head.folded()) else { return };
                let kind = match head {
                    "take-off" => FlightKind::TakeOff,
                    "land" => FlightKind::Land,
                    _ if FLIGHTS.contains(&head) => FlightKind::Flight,
                    _ => return,
                };
                self.open.insert(*command, kind);
                while self.open.len() > COMMANDS_MAX {
                    self.open.pop_first();
                }
            }
            Effect::WithdrawCommand { command, .. } => {
                // Nothing shows how far a take-off came if the vehicle reports no position.
                let takes_off = self.open.remove(command) == Some(FlightKind::TakeOff);
                self.is_aloft |= takes_off && self.stands_at.is_none();
            }
            _ => {}
        }
    }

    /// Returns true if the vehicle reports or shows that it is on the ground.
    pub(crate) fn is_on_ground(&self) -> bool {
        self.on_ground.or(self.ground_phase).unwrap_or(!self.is_aloft)
    }

    /// Returns true if the vehicle reports whether it is on the ground.
    pub(crate) fn is_reported(&self) -> bool {
        self.on_ground.or(self.ground_phase).is_some()
    }

    /// Returns true while a take-off or a landing is commanded.
    pub(crate) fn takes_off_or_lands(&self) -> bool {
        self.open.values().any(|kind| *kind != FlightKind::Flight)
    }

    /// Returns, once and when the flight begins, the reports that the vehicle has not made and what is lost without them.
    pub(crate) fn take_missing(&mut self) -> Option<String> {
        if self.has_told_missing || self.is_on_ground() {
            return None;
        }
        self.has_told_missing = true;
        let lost = [
            ("on-ground", self.on_ground.is_some(), "whether it flies follows from its commands and positions"),
            ("flight-phase", self.ground_phase.is_some(), "take-off and landing follow from its commands"),
            ("height-above-ground", self.has_height, "its height over ground is not watched"),
            ("ground-speed", self.has_ground_speed, "a position that does not change counts as a new one"),
        ];
        let missing = lost.iter().filter(|(_, is_reported, _)| !is_reported);
        let missing: Vec<String> = missing.map(|(name, _, what)| format!("`{name}` ({what})")).collect();
        (!missing.is_empty()).then(|| format!("the vehicle does not report {}", missing.join(", ")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use apex_model::because::{Because, Cause};
    use apex_model::quantity::Dimension;

    fn command(number: u64, head: &str) -> Effect {
        Effect::Command {
            command: CommandId(number),
            task: apex_model::task::TaskId(1),
            form: Value::list([Value::symbol(head)]),
            because: Because::new(Cause::InitialTask, None),
        }
    }

    fn done(number: u64) -> EventKind {
        EventKind::CommandAcknowledged(CommandId(number), Ok(Value::nil()))
    }

    fn at(latitude_deg: f64, altitude_m: f64) -> Value {
        Value::list([latitude_deg, -121.0, altitude_m].map(Value::Real))
    }

    #[test]
    fn acknowledged_commands_show_where_a_vehicle_is_that_does_not_report_it() {
        let mut air = AirState::default();
        assert!(air.is_on_ground() && !air.takes_off_or_lands());
        air.take(&command(0, "take-off"));
        assert!(air.is_on_ground() && air.takes_off_or_lands(), "not acknowledged");
        air.hear(&done(0));
        assert!(!air.is_on_ground() && !air.takes_off_or_lands());
        air.take(&command(1, "land"));
        assert!(!air.is_on_ground() && air.takes_off_or_lands());
        air.hear(&EventKind::CommandAcknowledged(CommandId(1), Err("wind".into())));
        assert!(!air.is_on_ground(), "the landing failed");
        air.take(&command(2, "land"));
        air.hear(&done(2));
        assert!(air.is_on_ground());
    }

    #[test]
    fn a_vehicle_that_leaves_its_place_is_in_the_air_without_an_answer() {
        for (latitude_deg, altitude_m, flies) in [(37.0, 30.0, true), (37.001, 5.0, true), (37.0001, 12.0, false)] {
            let mut air = AirState::default();
            air.measure("location", &at(37.0, 5.0));
            air.measure("location", &at(latitude_deg, altitude_m));
            assert_eq!(!air.is_on_ground(), flies, "{latitude_deg} {altitude_m}");
        }
        let mut air = AirState::default();
        air.measure("height-above-ground", &Value::measured(40.0, Dimension::LENGTH));
        assert!(!air.is_on_ground());
    }

    #[test]
    fn reports_come_before_all_that_is_derived() {
        let mut air = AirState::default();
        air.measure("on-ground", &Value::symbol("t"));
        air.measure("location", &at(37.0, 5.0));
        air.measure("location", &at(38.0, 500.0));
        assert!(air.is_on_ground() && air.is_reported());
        air.measure("on-ground", &Value::nil());
        assert!(!air.is_on_ground());
    }

    #[test]
    fn missing_reports_are_named_once() {
        let mut air = AirState::default();
        air.measure("ground-speed", &Value::measured(0.0, Dimension::SPEED));
        assert_eq!(air.take_missing(), None, "the flight has not begun");
        air.hear(&EventKind::Occurrence(Value::list([Value::symbol("airborne")])));
        let told = air.take_missing().unwrap_or_default();
        for name in ["`on-ground`", "`flight-phase`", "`height-above-ground`"] {
            assert!(told.contains(name), "{told}");
        }
        assert!(!told.contains("ground-speed"), "{told}");
        assert_eq!(air.take_missing(), None);
    }
}
