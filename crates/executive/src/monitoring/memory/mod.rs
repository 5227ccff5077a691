//! What histories must keep for the conditions that look back.

pub(crate) mod demand;
pub(crate) mod histories;
pub(crate) mod reach;
pub(crate) mod retention;
pub(crate) mod retention_of_absence;
pub(crate) mod retention_of_queries;
