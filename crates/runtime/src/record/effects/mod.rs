//! Effects as bytes: one row for each step with effects, and tables of words and shapes to which all rows refer.
//!
//! `splitter` separates an effect into its shape and its values, `encoder` writes the values as differences, `decoder` reads them,
//! `table` indexes the effects of each task and kind in memory.

mod decoder;
mod encoder;
mod kind;
mod rows;
mod splitter;
mod table;
#[cfg(test)]
mod tests;

pub(super) use decoder::{Dictionary, EffectReader, Item};
pub(super) use encoder::EffectEncoder;
pub(crate) use kind::{EffectKind, EffectNeed};
pub use rows::EffectRows;
pub(crate) use table::EffectTable;
pub(super) use table::StepRow;

/// Number of effects after which the encoding as differences begins again, so that a reader of one effect need not decode all preceding
/// effects of its step.
pub(super) const BLOCK_EFFECTS: usize = 256;
