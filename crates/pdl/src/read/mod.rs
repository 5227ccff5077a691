//! Lossless tree to data: numbers, quantities, names and lists with their places (`pdl.md`, Text).

mod atom;
mod datum;
mod flaws;
mod quotes;
mod reader;

pub(crate) use atom::{Atom, classify, is_number_like_symbol, number_and_unit, parse_unit_misspelt};
pub(crate) use datum::{Datum, DatumKind};
pub(crate) use reader::read_file;
