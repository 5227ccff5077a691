//! Explanations: what a task is and what it waits for, read from the agent as it is now.
//!
//! Nothing here changes an agent. The words are the ones that `apex why`, Sherpa and Python show.

mod choice;
mod reasons;
mod task_view;
mod watched;

pub use choice::{MethodOption, options};
pub use reasons::{Reason, ReasonKind, waiting};
pub use task_view::{TaskView, agenda, describe_task};
pub use watched::{ConditionNode, WatchedClause, bindings, watched};
