//! Effects as bytes: one row for each step that has any, with tables of words and shapes that all rows refer to.
//!
//! `splitter` separates an effect into its shape and its values, `encoder` writes the values as differences, `decoder` reads them
//! again, `table` knows in memory where the effects of each task and kind are.

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

/// Effects after which differences begin again: one effect can be read without all that stand before it in its step.
pub(super) const BLOCK_EFFECTS: usize = 256;
