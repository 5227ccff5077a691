//! Radio links: what is learned of them in flight, and what plans avoid.

mod avoid;
mod belief;
mod learned;
mod memory;

pub(crate) use avoid::without_weak_links;
pub use memory::LinkMemory;
