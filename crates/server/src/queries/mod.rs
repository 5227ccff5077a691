//! One file per answer of the API: its parameters, its shape, its query.

pub(crate) mod events;
pub(crate) mod mission;
pub(crate) mod report;
pub(crate) mod source;
pub(crate) mod targets;
pub(crate) mod tasks;
pub(crate) mod timeline;
pub(crate) mod track;
pub(crate) mod why;
