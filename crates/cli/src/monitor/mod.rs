//! What `apex monitor` needs: inputs of all kinds and lists of fields.

pub mod field_list;
pub mod input;
