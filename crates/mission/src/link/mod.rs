//! Radio links: what the mission states of them, what is learned in flight, and what plans avoid.

mod avoid;
mod belief;
mod form;
mod learned;
mod level;
pub(crate) mod lost;
mod memory;
pub(crate) mod stated;

pub(crate) use avoid::without_weak_links;
pub(crate) use form::LinkForm;
pub(crate) use level::{KEYS, LevelReader};
pub use lost::{LostDefault, LostLink};
pub use memory::LinkMemory;
pub use stated::StatedLink;
