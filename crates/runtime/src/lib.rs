//! apex-runtime
