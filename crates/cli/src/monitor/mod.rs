//! What `apex monitor` needs: inputs of all kinds, and results as a table.

pub mod input;
pub mod result_table;
