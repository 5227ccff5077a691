//! Whole monitors: their making, feeding and judging, and the conditions that combine others.

pub(crate) mod absence;
pub(crate) mod allen;
pub(crate) mod choices;
pub(crate) mod creation;
pub(crate) mod dispatch;
pub(crate) mod extents;
pub(crate) mod harvest;
pub(crate) mod interest;
pub(crate) mod logic;
pub(crate) mod monitors;
pub(crate) mod numbers_unmet;
pub(crate) mod parts;
pub(crate) mod relation;
pub(crate) mod replay;
pub(crate) mod together;
pub(crate) mod unmet;
