//! Whole monitors: their creation, inputs and verdicts, and the conditions that combine others.

pub(crate) mod absence;
pub(crate) mod allen;
pub(crate) mod condition_names;
pub(crate) mod condition_tree;
pub(crate) mod conjunction_firsts;
pub(crate) mod conjunction_pairs;
pub(crate) mod conjunction_span;
pub(crate) mod creation;
pub(crate) mod dispatch;
pub(crate) mod dominance;
pub(crate) mod interest;
pub(crate) mod logic;
pub(crate) mod monitors;
pub(crate) mod numbers_unmet;
pub(crate) mod order_constraints;
pub(crate) mod order_span;
pub(crate) mod part_results;
pub(crate) mod parts;
pub(crate) mod point_order;
pub(crate) mod point_steps;
pub(crate) mod point_sweep;
pub(crate) mod relation;
pub(crate) mod replay;
pub(crate) mod result_report;
pub(crate) mod unmet;
