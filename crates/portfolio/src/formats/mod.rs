//! Benchmark files of orienteering and touring: TOPTW (Solomon and Cordeau), OPLib, TSPLIB.
//!
//! A reader turns text into a single-visit problem, or returns the error with its remedy. The content determines the format.
//! `docs/reference/planning-problems.md` states the conventions.
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

/// Returns true if `text` has one of these formats, judged by its first words only.
pub fn is_one(text: &str) -> bool {
    tsplib::is_one(text) || solomon::is_one(text) || toptw::is_one(text)
}

/// Reads `text`; `name` is used if the text contains no name.
///
/// # Errors
/// The place, the error there, and the remedy.
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
