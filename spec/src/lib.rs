//! apex-spec
