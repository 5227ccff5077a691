//! The simulated world as the vehicle of a flight.

use crate::world::{Received, SimulatedWorld};
use apex_model::effect::CommandId;
use apex_model::time::Time;
use apex_model::value::Value;
use apex_runtime::ports::{Input, Vehicle};

impl Vehicle for SimulatedWorld {
    fn next_report(&self) -> Option<Time> {
        Some(self.next_instant())
    }

    fn advance(&mut self, to: Time, inputs: &mut Vec<Input>) -> Result<(), String> {
        loop {
            let next = self.next_instant();
            if next > to {
                return Ok(());
            }
            self.live_until(next, inputs);
        }
    }

    fn command(&mut self, command: CommandId, form: &Value, at: Time) {
        self.receive(at, Received::Command(command, form.clone()));
    }

    fn withdraw(&mut self, command: CommandId, at: Time) {
        self.receive(at, Received::Withdrawal(command));
    }

    fn acts_outside(&self) -> bool {
        false
    }
}
