//! The state of an agent: everything that can influence its behaviour, as plain data.
//!
//! [`agent::Agent`] holds all of it: tasks with their controllers and monitors, histories, resource tables, wakes. It can be cloned,
//! compared, stored and restored as a whole. The services of the executive are functions over it.

pub mod agent;
pub(crate) mod awaited_outcomes;
pub mod bindings;
pub mod children;
pub mod claim;
pub mod clause;
pub mod controller;
pub mod episode_index;
pub mod guards;
pub mod histories;
pub mod index;
pub mod interests;
pub mod listening;
pub mod memory_count;
pub mod monitor_set;
pub mod monitors;
pub mod orders;
pub mod pairs;
pub mod probing;
pub mod queue;
pub mod queue_place;
pub mod recorded;
pub mod resource;
pub mod resource_id;
pub mod step_clauses;
pub mod table;
pub mod task;
pub mod threshold_episode;
pub mod thresholds;
pub mod turns;
pub mod variable_index;
pub mod waiting;
pub mod wake;
pub mod walk;
