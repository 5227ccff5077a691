//! Whole programs: PDL in, flown without a vehicle, recorded, replayed, restored, explained.
#![cfg(test)]

mod explaining;
mod paced;
mod recording;
mod support;
