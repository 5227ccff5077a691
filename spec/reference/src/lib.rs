//! A naive interpreter of PDL: an independent second implementation for checking the executive.
//!
//! It determines the behaviour of a program by recomputing everything from the whole past, in every round of every instant. It shares no
//! code with Apex; see `README.md`.
#![allow(clippy::indexing_slicing, reason = "tasks, steps and procedures are never removed: their numbers are places")]

mod acting;
mod agent;
mod arbitration;
mod binding;
mod choosing;
mod clauses;
mod competition;
mod creation;
mod ending;
mod evidence;
mod execution;
mod expression;
mod failure;
mod importance;
pub mod program;
mod repetition;
mod suspension;
mod task;
pub mod trace;
mod value;

pub use agent::{Input, Said, run};
pub use program::Program;
pub use trace::{Cut, Line, Run, What};
pub use value::Value;
