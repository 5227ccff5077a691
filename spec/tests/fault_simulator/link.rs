//! A link between the simulated vehicle and the executive that is late, out of order, and doubles what it carries.

use crate::draws::Draws;
use apex_model::effect::CommandId;
use apex_model::event::EventKind;
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
use apex_runtime::ports::{Input, Vehicle};
use apex_sim::SimulatedWorld;

/// The vehicle behind a bad link. Samples keep the instants at which they were taken; acknowledgements and messages are late, too.
pub(crate) struct BadLink {
    vehicle: SimulatedWorld,
    draws: Draws,
    /// Probabilities of being late, lost (samples only) and doubled.
    late: f64,
    lost: f64,
    doubled: f64,
    held: Vec<(Time, Input)>,
}

impl BadLink {
    pub(crate) fn new(vehicle: SimulatedWorld, seed: u64) -> BadLink {
        let mut draws = Draws::new(seed ^ 0x5EED);
        let is_bad = draws.happens(0.5);
        let share = |draws: &mut Draws| if is_bad { draws.between(0.0, 0.05) } else { 0.0 };
        let (late, lost, doubled) = (share(&mut draws), share(&mut draws), share(&mut draws));
        BadLink { vehicle, draws, late, lost, doubled, held: Vec::new() }
    }
}

impl Vehicle for BadLink {
    fn next_report(&self) -> Option<Time> {
        let held = self.held.iter().map(|(comes, _)| *comes).min();
        self.vehicle.next_report().into_iter().chain(held).min()
    }

    fn advance(&mut self, to: Time, inputs: &mut Vec<Input>) -> Result<(), String> {
        let mut said = Vec::new();
        self.vehicle.advance(to, &mut said)?;
        for input in said {
            let is_sample = matches!(input.kind, EventKind::Measurement(..));
            if is_sample && self.draws.happens(self.lost) {
                continue;
            }
            if is_sample && self.draws.happens(self.doubled) {
                inputs.push(input.clone());
            }
            if self.draws.happens(self.late) {
                let delay = Duration::from_seconds(self.draws.between(0.1, 8.0));
                self.held.push((to + delay, input));
            } else {
                inputs.push(input);
            }
        }
        let due = |(comes, _): &mut (Time, Input)| *comes <= to;
        inputs.extend(self.held.extract_if(.., due).map(|(_, input)| input));
        Ok(())
    }

    fn command(&mut self, command: CommandId, form: &Value, at: Time) {
        self.vehicle.command(command, form, at);
    }

    fn withdraw(&mut self, command: CommandId, at: Time) {
        self.vehicle.withdraw(command, at);
    }

    fn acts_outside(&self) -> bool {
        false
    }
}
