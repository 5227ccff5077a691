//! Random families of tasks that compete for resources, and a naive arbiter for them.
#![allow(missing_docs, unreachable_pub)]

pub mod twin;
pub mod world;
