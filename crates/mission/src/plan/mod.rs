//! Plans made on the ground: the problem that is planned for, plans that are brought, and how good a plan is.

pub mod import;
pub mod input;
pub mod problem_file;
pub mod proof;
pub mod turns;
