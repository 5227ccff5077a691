//! What `apex monitor` and `apex export` read: inputs of all kinds.

pub mod input;
