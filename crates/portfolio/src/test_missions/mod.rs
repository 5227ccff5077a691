//! Test missions: any number of them in each cell.
//!
//! The seed of a mission is the hash of its cell's features and its number, so every platform draws the same mission. The hashes of
//! missions are committed, so that a change of the generator is noticed. The generator of the original is lost; this one is defined in
//! `docs/reference/test-missions.md`.

mod generate;
mod hash;

pub use generate::{CENTRE, GENERATOR_VERSION};

#[cfg(test)]
mod tests;
