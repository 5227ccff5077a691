//! apex-model
