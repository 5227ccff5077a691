//! Conditions on one sample, message, task, instant or expression.

pub(crate) mod event;
pub(crate) mod function;
pub(crate) mod measurement;
pub(crate) mod present;
pub(crate) mod task_state;
pub(crate) mod time_conditions;
