//! What `apex monitor` needs: inputs of all kinds.

pub mod input;
