//! Meaning of conditions by brute force: an independent second implementation for checking the executive's monitors.
//!
//! Every answer is computed from all arrivals, again at every instant. It shares no code with Apex; see `README.md`.
#![allow(clippy::indexing_slicing, reason = "loops over samples run below their number")]

mod absence;
mod aggregate;
mod allen;
pub mod condition;
mod cyclic;
mod episode;
mod event;
mod history;
mod measurement;
mod regression;
mod statistics;
mod trend;
mod value;
mod verdict;
mod ways;

pub use condition::{Condition, Kind, Span, Time};
pub use history::{Arrival, What};
pub use value::{Bindings, Value};
pub use verdict::{Outcome, Question, Verdict, first, instants, judge};
pub use ways::Interval;
