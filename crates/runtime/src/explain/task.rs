//! A task at an instant with its explanation, for the web page.

use super::answer::Why;
use super::moment::Moment;
use crate::record::view::Task;
use apex_model::task::TaskState;
use serde::Serialize;

/// Maximum number of moments of the history; the oldest are left out. A task that restarts for hours has thousands.
const MOMENTS_MAX: usize = 60;

/// A task at an instant, its neighbours in the tree, and the reasons for its state.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct TaskExplanation {
    /// The instant of the question, nanoseconds of mission time.
    pub at_ns: i64,
    /// The task then.
    pub task: Task,
    /// Its children then.
    pub children: Vec<Task>,
    /// Its state and the cause of that state in one sentence.
    pub now: String,
    /// The cause of that state as text; empty if `now` states none.
    pub cause: String,
    /// The explanation; its history holds the last 60 moments.
    pub explanation: Why,
    /// True if older moments are left out.
    pub left_out: bool,
    /// Reason for which the instant could not be restored; the explanation is then made from the record's decisions alone.
    pub explanation_error: Option<String>,
}

impl TaskExplanation {
    /// Joins the parts of the answer.
    pub fn new(at_ns: i64, task: Task, children: Vec<Task>, mut why: Why, error: Option<String>) -> TaskExplanation {
        let (state, cause) = state_and_cause(&task, &why.history);
        let now = if cause.is_empty() { state } else { format!("{state} because {cause}") };
        let older = why.history.len().saturating_sub(MOMENTS_MAX);
        why.history.drain(..older);
        let left_out = older > 0;
        TaskExplanation { at_ns, task, children, now, cause, explanation: why, left_out, explanation_error: error }
    }
}

/// Returns the task's state as text, and the cause of that state; the cause is empty if it is not known.
fn state_and_cause(task: &Task, history: &[Moment]) -> (String, String) {
    let last = |kinds: &[&str]| history.iter().rev().find(|moment| kinds.contains(&moment.kind.as_str()));
    let moved = last(&["transition", "created"]);
    let (state, reason) = match task.state.0 {
        TaskState::Pending => ("is pending: it waits for its preconditions", None),
        TaskState::Enabled => ("waits for its resources", last(&["refused"]).or(moved)),
        TaskState::Ongoing => ("is ongoing", moved),
        TaskState::Interrupted => ("is interrupted", moved),
        TaskState::Terminated => ("has ended", moved),
    };
    let outcome = task.outcome.as_ref().map_or_else(String::new, |word| format!(" ({word})"));
    let cause = reason.map(|moment| moment.because.clone()).unwrap_or_default();
    (format!("T{} {state}{outcome}", task.id), cause)
}
