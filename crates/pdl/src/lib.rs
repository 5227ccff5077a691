//! The front end of PDL: turns text into a checked library with messages for authors, and prints libraries as text.
//!
//! Text becomes a lossless tree (this never fails), the tree becomes data with places, the data become the types of `apex-model`. No I/O:
//! texts are passed in as strings, required texts through a callback.

mod analysis;
mod api;
mod apply;
mod check;
mod check_conditions;
mod codes;
mod constants;
mod diagnostic;
mod fix;
mod format;
mod host;
mod interfaces;
mod locate;
mod lookup;
mod loose;
mod lower;
mod matching;
mod print;
mod read;
mod reference;
mod reference_page;
mod render;
mod requirement;
mod suggest;
mod syntax;
mod typed_time;
mod vocabulary;
mod words;

pub use api::{ParsedCondition, error_code, error_codes, parse_condition, read_value};
pub use apply::{Applied, apply};
pub use check::{CheckOptions, Checked, SourceText, check, check_forms};
pub use check_conditions::{CheckedConditions, check_conditions};
pub use codes::ErrorCode;
pub use constants::report_constants;
pub use diagnostic::{Diagnostic, Label, Severity, Span};
pub use fix::{Applicability, Fix, TextEdit};
pub use format::format;
pub use host::HostSignature;
pub use interfaces::{KnownNames, check_names};
pub use print::{PrintedPlan, print_condition, print_expression, print_plan, print_primitive, print_procedure};
pub use reference::library_reference;
pub use render::render;
pub use requirement::{Requirement, Unresolved};
pub use typed_time::read_time;
pub use vocabulary::{VOCABULARY, Words};
pub use words::{explain_word, nearest_word};
