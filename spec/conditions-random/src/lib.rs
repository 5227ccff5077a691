//! Random questions about conditions for two independent implementations: the executive and `apex-definition`. See `README.md`.

pub mod campaign;
pub mod compare;
pub mod executive;
pub mod features;
pub mod generate;
pub mod page;
pub mod print;
mod rng;
pub mod shrink;
