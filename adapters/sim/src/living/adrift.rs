//! The vehicle while its navigation fails: its true position, the growing error, and their entries in the record.

use super::FaultKind;
use super::navigation::NavigationError;
use crate::motion::moved;
use crate::world::SimulatedWorld;
use apex_model::event::{EventKind, StateVariable};
use apex_model::problem::Position;
use apex_model::symbol::Symbol;
use apex_model::value::Value;
use apex_runtime::ports::Input;

impl SimulatedWorld {
    /// Returns the true position of the vehicle.
    pub fn position(&self) -> Position {
        self.navigation.truth(self.state.position)
    }

    /// Increases the error for the last `dt` seconds, or removes it.
    pub(crate) fn navigate(&mut self, dt: f64) {
        let Some(living) = &self.living else { return };
        let before = self.navigation.clone();
        match living.faults.find(FaultKind::Navigation, "", self.now) {
            None if before.is_none() && before.known_wind.is_none() => return,
            None => self.navigation = NavigationError::default(),
            Some(span) => match span.by {
                Some(drift_mps) => self.navigation.east_m = drift_mps * (self.now - span.from).seconds(),
                None => {
                    let known = *self.navigation.known_wind.get_or_insert(self.wind);
                    self.navigation.north_m += (known.north_mps - self.wind.north_mps) * dt;
                    self.navigation.east_m += (known.east_mps - self.wind.east_mps) * dt;
                }
            },
        }
        let after = &self.navigation;
        let (north_m, east_m) = (after.north_m - before.north_m, after.east_m - before.east_m);
        if north_m != 0.0 || east_m != 0.0 {
            self.state.position = moved(self.state.position, north_m, east_m);
        }
    }

    /// Reports the true position of the vehicle, just before a report of its estimated position.
    pub(crate) fn report_true_location(&self, inputs: &mut Vec<Input>) {
        let is_failed = self.suffers(FaultKind::Navigation, "");
        if self.navigation.is_none() && !is_failed {
            return;
        }
        let variable = StateVariable::new(Symbol::new("truth-location"), Value::symbol(&self.vehicle));
        let truth = crate::packet::location_at(self.position(), self.state.altitude_m);
        inputs.push(Input::new(self.now, EventKind::Measurement(variable, truth)));
    }
}
