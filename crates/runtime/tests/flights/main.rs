//! Whole programs: PDL in, flown without a vehicle, recorded, replayed, restored, explained.
#![cfg(test)]

mod durability;
mod explaining;
mod integrity;
mod paced;
mod recording;
mod support;
