//! Test missions: any number of them in each cell.
//!
//! A mission of a cell is drawn from a seed that is the hash of its features and number, so every platform draws the
//! same one; the hashes of missions are committed, so that the generator cannot drift unseen. The generator of the
//! original is lost; this one is defined in `docs/reference/test-missions.md`.

mod generate;
mod hash;

pub use generate::{CENTRE, GENERATOR_VERSION};

#[cfg(test)]
mod tests;
