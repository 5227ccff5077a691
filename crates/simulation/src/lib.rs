//! A mission in the built-in simulator. Crate `mission` knows no simulator, and crate `adapters/sim` knows no mission; this crate joins
//! the two for all callers.

mod flight;
mod fork;
mod ignorance;
mod runs;
mod runs_table;
mod world;

pub use flight::{create_record, create_record_with, fly, fly_to_the_end, pace_of};
pub use fork::{ForkTerms, Forked, WorldChanges, check_fork, fork};
pub use ignorance::IgnoranceSummary;
pub use runs::{JOBS_MAX, NotCompleted, RUNS_MAX, RunOutcome, RunRow, RunSummary, RunTerms, Violated, fly_runs};
pub use runs_table::RunsTable;
pub use world::world;
