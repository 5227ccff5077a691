//! What `apex monitor` needs: inputs of all kinds, mappings of logs, results in words.

pub mod field_list;
pub mod input;
pub mod telling;
