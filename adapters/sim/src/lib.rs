//! apex-sim
