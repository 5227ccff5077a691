//! The nouns of Apex.
//!
//! Everything that can influence an agent's behaviour is one of a few shared types, after the paper's own rule
//! (section V, Extensibility): tasks with their monitors and controllers, histories, resource tables, procedures,
//! the library, the agent, events and effects. Services elsewhere are functions over them.
//!
//! This crate imports no other crate of Apex. It holds no clock, no I/O, no randomness.

pub mod agent;
pub mod agent_limits;
pub mod because;
pub mod bindings;
pub mod builtins;
pub mod cause;
mod cause_words;
pub mod children;
pub mod clause;
pub mod condition;
pub mod controller;
pub mod effect;
pub mod episode_bank;
pub mod estimate;
pub mod event;
pub mod event_log;
pub mod evidence_list;
pub mod expression;
mod ground;
pub mod history;
mod history_table;
pub mod host;
pub mod index;
pub mod interests;
pub mod library;
pub mod limits;
pub mod moments;
pub mod monitor;
pub mod monitor_cyclic;
pub mod monitor_numbers;
mod monitor_parts;
pub mod monitor_set;
pub mod ordered_numbers;
mod pairs;
pub mod pattern;
pub mod plain_episode;
pub mod planned;
pub mod planted;
pub mod probing;
pub mod problem;
pub mod procedure;
pub mod quantity;
pub mod resource;
pub mod source;
pub mod step_clauses;
pub mod symbol;
pub mod table;
pub mod task;
pub mod thresholds;
pub mod time;
pub mod unmet;
pub mod value;
pub mod variable_map;
pub mod variables;
pub mod waiting;
pub mod wake;
pub mod walk;
pub mod words;
