//! Whole programs: PDL is loaded, flown without a vehicle, recorded, replayed, restored and explained.
#![cfg(test)]

mod crash;
mod durability;
mod explaining;
mod integrity;
mod memory;
mod paced;
mod record_thread;
mod recording;
mod recording_lost;
mod segments;
mod support;
mod viewed;
