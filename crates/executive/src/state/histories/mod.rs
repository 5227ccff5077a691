//! What was measured and what happened.

pub mod event_log;
pub mod history;
mod history_table;
pub mod variable_map;
