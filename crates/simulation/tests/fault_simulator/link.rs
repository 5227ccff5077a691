//! A link between the simulated vehicle and the executive that delays, reorders and duplicates its contents, and a vehicle clock that
//! jumps.

use crate::draws::Draws;
use apex_model::effect::CommandId;
use apex_model::event::EventKind;
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
use apex_runtime::ports::{Input, Vehicle};
use apex_sim::SimulatedWorld;

/// The vehicle behind a bad link. Samples keep the instants at which they were taken; acknowledgements and messages are delayed, too.
pub(crate) struct BadLink {
    vehicle: SimulatedWorld,
    draws: Draws,
    /// Probabilities that an input is late, lost (samples only) or sent twice.
    late: f64,
    lost: f64,
    doubled: f64,
    /// Start and end of a span of time, and the error of the vehicle's clock in it.
    jump: Option<(Time, Time, Duration)>,
    held: Vec<(Time, Input)>,
    /// True from the take-off to the landing, as the vehicle reports them before any delay.
    pub(crate) is_in_air: bool,
}

impl BadLink {
    pub(crate) fn new(vehicle: SimulatedWorld, seed: u64) -> BadLink {
        let mut draws = Draws::new(seed ^ 0x5EED);
        let is_bad = draws.happens(0.5);
        let share = |draws: &mut Draws| if is_bad { draws.between(0.0, 0.05) } else { 0.0 };
        let (late, lost, doubled) = (share(&mut draws), share(&mut draws), share(&mut draws));
        let jump = draws.happens(0.3).then(|| {
            let from = Time::from_seconds(draws.between(60.0, 3_000.0));
            let by_s = draws.between(-30.0, 10.0);
            (from, from + Duration::from_seconds(draws.between(20.0, 600.0)), Duration::from_seconds(by_s))
        });
        BadLink { vehicle, draws, late, lost, doubled, jump, held: Vec::new(), is_in_air: false }
    }

    fn note_phase(&mut self, kind: &EventKind) {
        let EventKind::Occurrence(form) = kind else { return };
        match form.head().map(|head| head.folded()) {
            Some("airborne") => self.is_in_air = true,
            Some("landed" | "crashed") => self.is_in_air = false,
            _ => {}
        }
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
        for mut input in said {
            self.note_phase(&input.kind);
            if let Some((from, until, by)) = self.jump
                && (from..until).contains(&to)
            {
                input.at = (input.at + by).max(Time::ZERO);
            }
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
