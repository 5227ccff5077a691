//! Monitoring and interpretation services: what conditions mean (`monitoring.md`; paper, section IV and Appendix B).
//!
//! One file per service. A monitor is plain data (`apex_model::monitor`); it is made by [`create`], fed by [`notice`]
//! with the stimuli it has an interest in, and asked by [`verdict`].

pub mod pattern_matching;

use crate::expression::{EvaluationError, Surroundings};
use apex_model::condition::Condition;
use apex_model::event::StateVariable;
use apex_model::history::Histories;
use apex_model::library::Library;
use apex_model::monitor::{Interest, Monitor, Trouble, Unmet, Verdict, Window};
use apex_model::task::{TaskId, TaskState};
use apex_model::time::Time;
use apex_model::value::Value;

/// Something that a monitor may notice. Histories have recorded it before.
#[derive(Clone, Debug, PartialEq)]
pub enum Stimulus {
    /// A sample.
    Sample {
        /// The state variable.
        variable: StateVariable,
        /// The value, in the declared unit.
        value: Value,
        /// When.
        at: Time,
        /// Arrival number.
        sequence: u64,
    },
    /// A message.
    Event {
        /// Its form.
        form: Value,
        /// When.
        at: Time,
        /// Arrival number.
        sequence: u64,
    },
    /// A task ended.
    TaskEnded {
        /// The task.
        task: TaskId,
        /// When.
        at: Time,
    },
    /// A task changed state (`TaskEnded` follows separately when it ended).
    TaskState {
        /// The task.
        task: TaskId,
        /// Before.
        from: TaskState,
        /// After.
        state: TaskState,
        /// When.
        at: Time,
    },
}

/// What became of a measurement that arrived.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// To be shown to the monitors interested; none when it changes nothing (repeated, missing, too late, refused).
    pub stimulus: Option<Stimulus>,
    /// A sentence for the trace when the sample was refused or kept aside.
    pub trouble: Option<String>,
}

/// Prepares `histories` for `library`: how far back its conditions, queries and log policies look.
pub fn prepare(histories: &mut Histories, library: &Library) {
    let _ = (histories, library);
}

/// Puts a measurement into its history. A bare number takes the unit that the variable is declared with.
pub fn record_sample(
    histories: &mut Histories,
    library: &Library,
    variable: StateVariable,
    value: Value,
    at: Time,
    sequence: u64,
) -> Recording {
    let _ = (histories, library);
    Recording { stimulus: Some(Stimulus::Sample { variable, value, at, sequence }), trouble: None }
}

/// Puts a message into the memory of events.
pub fn record_event(histories: &mut Histories, form: Value, at: Time, sequence: u64) -> Stimulus {
    let _ = histories;
    Stimulus::Event { form, at, sequence }
}

/// Makes the monitor of `condition` and looks back over what is remembered since the window's start.
///
/// # Errors
/// When an expression that must be known now (a duration, a gap) cannot be evaluated.
pub fn create(
    condition: &Condition,
    window: Window,
    surroundings: &dyn Surroundings,
) -> Result<Monitor, EvaluationError> {
    let _ = window;
    let _ = surroundings;
    Err(EvaluationError { message: "no monitors".into(), place: condition.place })
}

/// What `monitor` must be told of. May shrink or grow after `notice`, when a task or object becomes known.
pub fn interests(monitor: &Monitor) -> Vec<Interest> {
    let _ = monitor;
    Vec::new()
}

/// Tells `monitor` what happened. Stimuli it has no interest in change nothing.
pub fn notice(monitor: &mut Monitor, stimulus: &Stimulus, surroundings: &dyn Surroundings) {
    let _ = (monitor, stimulus, surroundings);
}

/// Is the condition true at `surroundings.now()`? Asked after all stimuli of the instant were noticed.
pub fn verdict(monitor: &mut Monitor, surroundings: &dyn Surroundings) -> Verdict {
    let _ = (monitor, surroundings);
    Verdict::Unknown
}

/// When the verdict can change by time alone, strictly after the last `verdict`, and why.
pub fn next_wake(monitor: &Monitor) -> Option<(Time, String)> {
    let _ = monitor;
    None
}

/// The parts that do not hold, with what is known about each.
pub fn unmet(monitor: &Monitor, surroundings: &dyn Surroundings) -> Vec<Unmet> {
    let _ = (monitor, surroundings);
    Vec::new()
}

/// Errors met while judging since the last call: to be reported as trouble.
pub fn take_troubles(monitor: &mut Monitor) -> Vec<Trouble> {
    std::mem::take(&mut monitor.troubles)
}
