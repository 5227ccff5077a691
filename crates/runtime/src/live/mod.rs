//! Live sources: the programs and operators that send inputs during a run, each with a name, a class and a bounded queue.
//!
//! A reader passes its inputs to its [`LiveSource`]. The flight takes them from [`LiveSources`] by class: operators and safing first,
//! then vehicles, then feeds, and sources of one class in turn. `class` states the permitted rates, `rate_limit` enforces them, `queue`
//! holds waiting inputs (of telemetry the latest value, of other inputs all), `introduction` reads the introduction of a source,
//! `hearing` reads lines of connections, `fault_messages` limits messages about them. Lost inputs of a source are an input of the run:
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
