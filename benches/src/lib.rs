//! apex-benches
