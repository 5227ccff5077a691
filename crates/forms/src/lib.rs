//! Functions on the forms of PDL that the checker and the executive share: their text, their variables, and the results that steps of a
//! procedure await from each other.
//!
//! The forms themselves are types of `apex-model`, the only crate of Apex that this crate imports.

pub mod awaited;
pub mod print;
pub mod variables;
