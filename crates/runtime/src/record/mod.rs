//! The flight record: one SQLite file per flight. Schema, writer, reader, restoring, and the
//! view that answers questions (`docs/reference/flight-record.md`).

mod check;
mod checkpoints;
mod closing;
mod codec;
mod convert;
mod difference;
mod effect_access;
mod effects;
mod file_seal;
mod fold;
mod integrity_text;
mod kept_rows;
mod numbers;
mod open;
mod problems;
mod reader;
mod recover;
mod restore;
mod rows;
mod schema;
mod seal;
mod signature;
mod steps;
mod store;
mod tables;
mod task_rows;
#[cfg(test)]
mod tests;
mod track;
mod twin;
pub mod view;
mod writer;

pub use check::{Damage, seal_rows};
pub use convert::convert;
pub(crate) use difference::RowDifference;
pub(crate) use effect_access::{Effects, Told};
pub use effects::EffectRows;
pub(crate) use effects::{EffectKind, EffectNeed};
pub use file_seal::FileSeal;
pub use fold::fold_both;
pub use open::{Integrity, check_integrity};
pub use problems::{ProblemRow, SituationRow};
pub use reader::{RecordGap, RecordReader, Sample, StoredSource};
pub use recover::{Recovered, recover};
pub use restore::{LoadProgram, RestoredProgram};
pub use rows::TargetRow;
pub use schema::{APPLICATION_ID, SCHEMA_VERSION, agents, look_at_agent};
pub use signature::{SignatureState, SigningKey, check_signature, signature_path};
pub use steps::{RecordedEffect, RecordedStep, Steps};
pub use store::Durability;
pub use task_rows::TaskRow;
pub(crate) use twin::{Derivable, recorder as twin_recorder};
pub use writer::{RECORDING_LOST, RECORDING_RESUMED, RecordOptions, Recorder, SIGNED_BY};
