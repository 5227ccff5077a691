//! Radio links: learning in flight, and avoidance in plans.

mod avoid;
pub(crate) mod belief;
mod learned;
mod memory;

pub use memory::LinkMemory;
