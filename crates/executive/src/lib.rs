//! apex-executive
