//! Retention of histories: the samples and messages that conditions on the past require.

pub(crate) mod absence_retention;
pub(crate) mod demand;
pub(crate) mod histories;
pub(crate) mod query_retention;
pub(crate) mod reach;
pub(crate) mod retention;
