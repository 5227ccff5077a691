//! Histories of measurements and messages.

pub mod event_log;
pub mod history;
mod history_table;
pub mod variable_map;
