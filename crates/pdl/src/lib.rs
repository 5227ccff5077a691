//! apex-pdl
