//! Stimuli (M&I)
//! What: defines what a monitor may notice: samples, messages, ends and states of tasks.
//! Runs: recorded first, then shown to the monitors that are interested.
//! Reads: nothing.
//! Writes: nothing.
//! Bound: O(1).
//! PDL: none.
//! Paper: section III, sources of information for monitors.

use crate::state::clause::MonitorId;
use apex_model::event::StateVariable;
use apex_model::task::{TaskId, TaskState};
use apex_model::time::Time;
use apex_model::value::Value;

/// Something that a monitor may notice. Histories have recorded it already.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Stimulus {
    /// A sample.
    Sample {
        /// The state variable.
        variable: StateVariable,
        /// The value, in the declared unit.
        value: Value,
        /// Instant.
        at: Time,
        /// Arrival number.
        sequence: u64,
        /// True if no other sample of the variable is as new.
        newest: bool,
    },
    /// A message.
    Event {
        /// Its form.
        form: Value,
        /// Instant.
        at: Time,
        /// Arrival number.
        sequence: u64,
    },
    /// A task ended and will not be repeated.
    TaskEnded {
        /// The task.
        task: TaskId,
        /// The words of its outcome; empty if only the end is known.
        outcome: &'static [&'static str],
        /// Instant.
        at: Time,
        /// The number of the first monitor that was made later: a monitor that begins later does not receive it.
        before: MonitorId,
    },
    /// A task changed state (`TaskEnded` comes separately when it ended).
    TaskState {
        /// The task.
        task: TaskId,
        /// State before the change.
        from: TaskState,
        /// State after the change.
        state: TaskState,
        /// Instant.
        at: Time,
        /// The number of the first monitor that was made later, as for `TaskEnded`.
        before: MonitorId,
    },
}
