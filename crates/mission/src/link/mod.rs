//! Radio links: what is learned of them in flight, and what plans avoid.

mod avoid;
pub(crate) mod belief;
mod learned;
mod memory;

pub use memory::LinkMemory;
