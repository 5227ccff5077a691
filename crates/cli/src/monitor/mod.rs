//! Inputs of all kinds for `apex monitor` and `apex export`.

pub mod input;
