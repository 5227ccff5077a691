//! Selection of the best planner for a mission: features of problems, and the measured profile of planners.
//!
//! [`test_missions`] draws missions of each [`cell`] of the feature space, [`profile`] measures planners on them, and [`table`] chooses a
//! planner by these measurements. [`formats`] reads benchmark files. Planners are passed in as a registry; this crate contains none.

pub mod cell;
pub mod features;
pub mod format_error;
pub mod formats;
pub mod parallel;
pub mod profile;
pub mod table;
pub mod test_missions;

pub use table::{ProfileTable, Selection, select, select_within};
