//! Benchmark files of orienteering and touring: TOPTW (Solomon and Cordeau), OPLib, TSPLIB.
//!
//! Text in, a single-visit problem out, or where the text is wrong, why, and what to do. Which format it is follows from
//! the content. `docs/reference/planning-problems.md` tells the conventions.
//! Bound: O(length of the text + targets squared); more than `validate::TARGETS_MAX` targets are refused before they are read.

mod distance;
pub mod generate;
mod instance;
mod pose;
mod solomon;
mod toptw;
mod tsplib;
mod words;

pub use instance::{Instance, ProblemKind};

use crate::format_error::FormatError;

/// Returns true if `text` is meant to be one of these formats, by its first words only.
pub fn is_one(text: &str) -> bool {
    tsplib::is_one(text) || solomon::is_one(text) || toptw::is_one(text)
}

/// Reads `text`; `name` serves where the text tells none.
///
/// # Errors
/// The place, what is wrong there, and what to do.
pub fn read(name: &str, text: &str) -> Result<Instance, FormatError> {
    if tsplib::is_one(text) {
        tsplib::read(name, text)
    } else if solomon::is_one(text) {
        solomon::read(name, text)
    } else {
        toptw::read(name, text)
    }
}

#[cfg(test)]
mod tests;
