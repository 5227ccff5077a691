//! Functions over the forms of PDL that the checker and the executive share: their text, the variables that they
//! mention, and the results that steps of a procedure await of each other.
//!
//! The forms themselves are types of `apex-model`, the only crate of Apex that this one imports.

pub mod awaited;
pub mod print;
pub mod variables;
