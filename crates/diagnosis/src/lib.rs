//! Diagnosis with a dependency model: components with failure modes, signals, tests, and the conclusions from each test's failure.
//!
//! A model (multi-signal flow graph; Deb, Pattipati, Raghavan, Shakeri and Shrestha 1995) states which failure modes make which tests
//! fail, with AND/OR paths for redundancy. The testability figures follow from it. Together with test outcomes it gives the health of
//! each failure mode, and the minimal sets of faults that explain the outcomes (Reiter 1987). The crate is pure: it reads text, touches
//! no file, clock or random source, and iterates over nothing in hash order. `docs/reference/diagnosis.md` describes the files and every
//! figure.

mod bits;
mod contradiction;
mod diagnoser;
mod doubt;
mod error;
mod evidence;
mod formula;
mod grouping;
mod hitting;
pub mod limits;
mod model;
mod pdl;
mod raw;
mod read;
mod results;
mod testability;
mod text;

pub use bits::Bits;
pub use contradiction::Contradiction;
pub use diagnoser::{Candidate, Diagnoser, Diagnosis, GroupDiagnosis, Health};
pub use doubt::Doubt;
pub use error::DiagnosisError;
pub use evidence::Outcome;
pub use hitting::SearchEnd;
pub use model::{Component, FailureMode, Model, Monitor, Test};
pub use results::Results;
pub use testability::{ISOLATION_SIZES, Mask, TestSet, Testability, testability};
pub use text::{explain, explain_json};
