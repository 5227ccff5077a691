//! Radio links: what the mission states of them, what is learned in flight, and what plans avoid.

mod form;
mod level;

pub(crate) use form::LinkForm;
pub(crate) use level::{KEYS, LevelReader};
