//! The shared types of Apex.
//!
//! Values, time, quantities and symbols; the nouns of PDL; events, effects and causes; planning problems; limits. Their
//! functions compute on these values alone. The state of an agent is in the executive's `state`.
//!
//! This crate imports no other crate of Apex. It contains no clock, no I/O and no randomness.

pub mod agent_limits;
pub mod because;
pub mod builtins;
pub mod cause;
mod cause_kinds;
mod cause_words;
pub mod condition;
mod cyclic;
pub mod derivation;
pub mod effect;
pub mod estimate;
pub mod event;
pub mod evidence_list;
pub mod expression;
mod ground;
pub mod host;
pub mod interface;
pub mod library;
pub mod limits;
pub mod pattern;
pub mod planned;
pub mod probing;
pub mod problem;
pub mod procedure;
pub mod quantity;
pub mod source;
pub mod symbol;
pub mod task;
pub mod time;
pub mod value;
