//! The life cycle of a task: creation, monitors and variables, execution, interruption and end.

pub(crate) mod binding;
pub(crate) mod episode_index_tasks;
pub(crate) mod execution_conditions;
pub(crate) mod failure;
pub(crate) mod goal;
pub(crate) mod hooks;
pub(crate) mod instantiation;
pub(crate) mod interruption;
pub(crate) mod messaging;
pub(crate) mod monitoring_clauses;
pub(crate) mod outcomes;
pub(crate) mod primitive;
pub(crate) mod probing;
pub(crate) mod procedure;
pub(crate) mod question;
mod reasons;
pub(crate) mod repetition;
pub(crate) mod restart;
pub(crate) mod termination;
