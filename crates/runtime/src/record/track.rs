//! The track: positions of the vehicle, thinned for drawing.

use apex_model::event::{Batch, EventKind, StateVariable};
use apex_model::symbol::Symbol;
use apex_model::time::{Duration, Time};
use apex_model::value::Value;

/// Greatest time between two rows while samples arrive.
const INTERVAL_MAX: Duration = Duration(10_000_000_000);
/// Least time between two rows, however much the vehicle turns.
const INTERVAL_MIN: Duration = Duration(1_000_000_000);
/// Change of heading or bank in degrees that makes a new row.
const TURN_DEG: f64 = 3.0;
/// Change of altitude in metres that makes a new row.
const CLIMB_M: f64 = 30.0;

/// One row of the `track` table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TrackRow {
    pub(super) at: Time,
    pub(super) latitude_deg: f64,
    pub(super) longitude_deg: f64,
    pub(super) altitude_m: Option<f64>,
    pub(super) heading_deg: Option<f64>,
    pub(super) roll_deg: Option<f64>,
    pub(super) ground_speed_mps: Option<f64>,
    pub(super) fuel_kg: Option<f64>,
}

/// Makes track rows from the measurements of one vehicle.
#[derive(Clone, Debug)]
pub(super) struct TrackWatcher {
    vehicle: Symbol,
    latest: TrackRow,
    written: Option<TrackRow>,
}

impl TrackWatcher {
    /// Returns a watcher of the vehicle called `vehicle`, for example `aircraft-1`.
    pub(super) fn new(vehicle: &str) -> TrackWatcher {
        let nowhere = TrackRow {
            at: Time::BEGINNING,
            latitude_deg: f64::NAN,
            longitude_deg: f64::NAN,
            altitude_m: None,
            heading_deg: None,
            roll_deg: None,
            ground_speed_mps: None,
            fuel_kg: None,
        };
        TrackWatcher { vehicle: Symbol::new(vehicle), latest: nowhere, written: None }
    }

    /// Reads a batch. Returns a row if the batch has a location of the vehicle and, since the last row, [`INTERVAL_MAX`] has passed, or
    /// [`INTERVAL_MIN`] with enough change of altitude, heading or bank.
    pub(super) fn hear(&mut self, batch: &Batch) -> Option<TrackRow> {
        let mut located = false;
        for event in &batch.events {
            if let EventKind::Measurement(variable, value) = &event.kind
                && variable.object.as_symbol() == Some(&self.vehicle)
            {
                located |= self.sample(variable, value);
            }
        }
        if !located {
            return None;
        }
        self.latest.at = batch.now;
        let due = self.written.is_none_or(|written| worth_drawing(&written, &self.latest));
        due.then(|| *self.written.insert(self.latest))
    }

    /// Takes in a sample; returns true for a location.
    fn sample(&mut self, variable: &StateVariable, value: &Value) -> bool {
        let number = value.as_number().map(|(si, _)| si).filter(|si| si.is_finite());
        match variable.attribute.folded() {
            "location" => return self.locate(value),
            "altitude" => self.latest.altitude_m = number,
            "heading" => self.latest.heading_deg = degrees(value),
            "roll-angle" => self.latest.roll_deg = degrees(value),
            "ground-speed" => self.latest.ground_speed_mps = number,
            "fuel" | "fuel-mass" | "fuel-remaining" => self.latest.fuel_kg = number,
            _ => {}
        }
        false
    }

    fn locate(&mut self, value: &Value) -> bool {
        let numbers: Vec<f64> =
            value.as_list().unwrap_or_default().iter().filter_map(|item| item.as_number().map(|(si, _)| si)).collect();
        let (&[latitude, longitude] | &[latitude, longitude, _]) = numbers.as_slice() else { return false };
        if !latitude.is_finite() || !longitude.is_finite() {
            return false;
        }
        (self.latest.latitude_deg, self.latest.longitude_deg) = (latitude, longitude);
        if let Some(altitude) = numbers.get(2).filter(|altitude| altitude.is_finite()) {
            self.latest.altitude_m = Some(*altitude);
        }
        true
    }
}

/// Returns the degrees of an angle; a bare number is in degrees already, as everywhere in PDL's vehicle variables.
fn degrees(value: &Value) -> Option<f64> {
    let (number, dimension) = value.as_number()?;
    let angle = dimension == apex_model::quantity::Dimension::ANGLE;
    Some(if angle { number.to_degrees() } else { number }).filter(|degrees| degrees.is_finite())
}

fn worth_drawing(written: &TrackRow, latest: &TrackRow) -> bool {
    let passed = latest.at - written.at;
    let moved = |before: Option<f64>, after: Option<f64>, limit: f64| match (before, after) {
        (Some(before), Some(after)) => {
            let difference = (after - before).abs();
            // Headings of 359 and 1 degree are neighbours.
            difference.min((360.0 - difference).abs()) > limit
        }
        (before, after) => before.is_some() != after.is_some(),
    };
    let climbed = (latest.altitude_m.unwrap_or(0.0) - written.altitude_m.unwrap_or(0.0)).abs() > CLIMB_M;
    passed >= INTERVAL_MAX
        || (passed >= INTERVAL_MIN
            && (climbed
                || moved(written.heading_deg, latest.heading_deg, TURN_DEG)
                || moved(written.roll_deg, latest.roll_deg, TURN_DEG)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use apex_model::event::Event;
    use apex_model::quantity::{Quantity, unit_named};

    fn batch(seconds: f64, heading_deg: f64) -> Batch {
        let at = Time::from_seconds(seconds);
        let location = Value::list([Value::Real(34.5), Value::Real(-117.0), Value::Real(7000.0)]);
        let heading = Value::Quantity(Quantity::of(heading_deg, unit_named("deg").unwrap()));
        let sample = |attribute: &str, value| {
            let variable = StateVariable::new(Symbol::new(attribute), Value::symbol("aircraft-1"));
            Event { sequence: 1, at, kind: EventKind::Measurement(variable, value) }
        };
        Batch { now: at, events: vec![sample("heading", heading), sample("location", location)] }
    }

    #[test]
    fn straight_flight_is_thinned_and_turns_are_kept() {
        let mut track = TrackWatcher::new("Aircraft-1");
        let first = track.hear(&batch(0.0, 359.0)).unwrap();
        assert_eq!((first.latitude_deg, first.altitude_m), (34.5, Some(7000.0)));
        assert!((first.heading_deg.unwrap() - 359.0).abs() < 1e-9);
        assert_eq!(track.hear(&batch(5.0, 1.0)), None, "two degrees across north are not a turn");
        assert!(track.hear(&batch(6.0, 20.0)).is_some());
        assert_eq!(track.hear(&batch(6.5, 60.0)), None, "not more often than once a second");
        assert!(track.hear(&batch(16.0, 20.0)).is_some());
    }
}
