//! Options of solver programs.

use clap::Args;

/// `apex solver`
#[derive(Args)]
pub struct SolverOptions {
    /// The planner that answers.
    pub name: String,
}

/// Planners that are programs, for commands that plan.
#[derive(Args)]
pub struct SolverProgramOptions {
    /// Add the planner NAME, which is a program in a separate process, for example `mine='python3 mine.py'`; may be repeated.
    #[arg(long = "solver-program", value_name = "NAME=COMMAND")]
    pub solver_programs: Vec<String>,
}
