//! The flight record: one SQLite file per flight. Schema, writer, reader, restoring, and the
//! view that answers questions (`docs/reference/flight-record.md`).

mod codec;
mod problems;
mod reader;
mod restore;
mod rows;
mod schema;
mod steps;
mod store;
#[cfg(test)]
mod tests;
mod track;
pub mod view;
mod writer;

pub use problems::{ProblemRow, SituationRow};
pub use reader::{RecordReader, Sample, StoredSource, TaskRow};
pub use restore::{LoadProgram, Program};
pub use rows::TargetRow;
pub use schema::{APPLICATION_ID, SCHEMA_VERSION, agents, look_at_agent};
pub use steps::{RecordedEffect, RecordedStep, Steps};
pub use writer::{RecordOptions, Recorder};
