//! Explanations: the description of a task and of what it waits for, read from the present state of the agent.
//!
//! No function here changes an agent. `apex why`, Sherpa and Python show these texts.

mod choice;
mod reasons;
mod task_view;
mod watched;

pub use choice::{MethodOption, options};
pub use reasons::{Reason, ReasonKind, waiting};
pub use task_view::{TaskView, agenda, describe_task};
pub use watched::{ConditionNode, WatchedClause, bindings, watched};
