//! The imperative shell: clock, inbox, outbox, solver pool, flight record, replay, ports.
//!
//! Everything with side effects that is not an adapter, the web server or the command line belongs here. A flight calls the executive in
//! one place (`flight.rs`); replay, forks, restoration and explanations call it again with recorded inputs.

pub mod agent_group;
pub mod answer_lines;
pub mod asker;
pub mod authority;
pub mod commands;
pub mod effect_describer;
pub mod error;
pub mod escaping;
pub mod explain;
mod flight;
pub mod foreign;
pub mod fork;
pub mod inbox;
pub mod input_lines;
pub mod input_stream;
pub mod invocation;
pub mod limits;
pub mod live;
pub mod live_lines;
mod method_detail;
pub mod mission_loop;

pub mod outbox;
pub mod pacing;
pub mod pool;
pub mod ports;
pub mod program;
pub mod record;
pub mod replay;
pub mod reserved;
pub mod run_settings;
#[cfg(test)]
mod samples;
pub mod solver_process;
pub mod solver_thread;
mod solver_words;
pub mod target_state;
pub mod trace;
#[cfg(test)]
mod typescript;
mod unique_json;

pub use error::{RecordError, RunError};
pub use mission_loop::{Control, EndReason, RunEnd, RunSettings, ScriptedAnswer, fly, fly_all};
pub use unique_json::{Unique as UniqueJson, parse as parse_unique_json};
