//! Live sources: the programs and operators that speak during a run, each with a name, a class and a bounded queue.
//!
//! A reader says what it has read to its [`LiveSource`]; the flight takes from [`LiveSources`] by class: operators and safing
//! first, then vehicles, then feeds, and sources of one class in turn. `class` states what a class may say, `rate_limit` keeps
//! it, `queue` holds what waits (of telemetry the latest value, of everything else all), `introduction` reads who a source says
//! that it is, `hearing` reads lines of connections, `fault_messages` limits messages about them. What a source loses is an input of the run:
//! `(live-source NAME lost COUNT VARIABLE)`.

mod class;
mod fault_messages;
#[cfg(test)]
mod flight_tests;
mod hearing;
mod introduction;
mod queue;
mod rate_limit;
mod sources;

pub use class::SourceClass;
pub use hearing::{LineReader, hear_connections, hear_lines};
pub use introduction::Introduction;
pub use queue::LiveInput;
pub use rate_limit::RateLimit;
pub use sources::{LiveSource, LiveSources};
