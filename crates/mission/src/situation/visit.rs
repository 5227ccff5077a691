//! Observations so far, and the last reported state of the vehicle.

use super::scan_line::ScanLine;
use crate::predicted::Predicted;
use apex_model::planned::Location;
use apex_model::problem::Position;
use apex_model::quantity::Dimension;
use apex_model::time::Time;
use apex_model::value::Value;
use serde::{Deserialize, Serialize};

/// One observation of one target.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Visit {
    /// The target's id.
    pub target: String,
    /// Beginning.
    pub begin: Time,
    /// End; `None` while it continues, or if it was interrupted.
    pub end: Option<Time>,
    /// Number of segments that were flown again.
    pub reflies: u32,
    /// The lines to fly, with the seen parts of each.
    pub lines: Vec<ScanLine>,
    /// Sum and count of altitudes while scanning, for the mean.
    altitude_m: (f64, u32),
    /// The largest roll angle while on a line.
    pub roll_deg_max: f64,
    /// Prediction by the plan.
    pub predicted: Option<Predicted>,
}

impl Visit {
    /// Returns an observation that begins now.
    pub(super) fn new(target: String, begin: Time, lines: Vec<ScanLine>, predicted: Option<Predicted>) -> Visit {
        Visit { target, begin, end: None, reflies: 0, lines, altitude_m: (0.0, 0), roll_deg_max: 0.0, predicted }
    }

    /// Returns the mean altitude above mean sea level while scanning; `None` if nothing was scanned.
    pub fn altitude_m(&self) -> Option<f64> {
        let (sum, count) = self.altitude_m;
        (count > 0).then(|| sum / f64::from(count))
    }

    /// Marks the ground that the scanner of `vehicle` sees now, if it is on and the vehicle is on a line. Up to `level_roll_deg_max` the
    /// wings count as level, and the ground as seen.
    pub(super) fn scan(&mut self, vehicle: &VehicleState, level_roll_deg_max: f64) {
        let VehicleState { position: Some(position), altitude_m, roll_deg, on_line: true, scanning: true, .. } =
            *vehicle
        else {
            return;
        };
        self.altitude_m = (self.altitude_m.0 + altitude_m, self.altitude_m.1 + 1);
        self.roll_deg_max = self.roll_deg_max.max(roll_deg.abs());
        for line in &mut self.lines {
            line.mark(position, roll_deg.abs() <= level_roll_deg_max);
        }
    }
}

/// State of the vehicle as last reported.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct VehicleState {
    /// Position; `None` before the first report.
    pub position: Option<Position>,
    /// Altitude above mean sea level.
    pub altitude_m: f64,
    /// Fuel left.
    pub fuel_kg: Option<f64>,
    /// Share of the battery's capacity that is left.
    pub battery_charge: Option<f64>,
    /// Flight time that fuel or battery allow.
    pub endurance_s: Option<f64>,
    roll_deg: f64,
    on_line: bool,
    scanning: bool,
}

impl VehicleState {
    /// Processes a sample of one of the vehicle's attributes. Other attributes change nothing.
    pub(super) fn measure(&mut self, attribute: &str, value: &Value) {
        match (attribute, value) {
            ("location", Value::List(_)) => {
                if let Some(location) = Location::from_value(value) {
                    self.position = Some(location.position);
                    self.altitude_m = location.altitude_m;
                }
            }
            ("fuel", Value::Quantity(fuel)) if fuel.dimension == Dimension::MASS => self.fuel_kg = Some(fuel.si),
            ("battery-charge", Value::Real(share)) => self.battery_charge = Some(*share),
            ("endurance-remaining", Value::Duration(left)) => self.endurance_s = Some(left.seconds()),
            ("roll-angle", Value::Quantity(roll)) => self.roll_deg = roll.si.to_degrees(),
            ("flight-phase", Value::Symbol(phase)) => self.on_line = phase.is("line"),
            ("scanner-state", Value::Symbol(state)) => self.scanning = state.is("on"),
            _ => {}
        }
    }
}
