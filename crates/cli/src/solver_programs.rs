//! Planners in separate processes: programs that the user names, and planners that a third party has linked.

use crate::error::{CliError, CliResult};
use apex_planning::Registry;
use apex_planning::solver::Solver;
use apex_runtime::solver_process::SolverProgram;
use std::ffi::OsString;
use std::sync::Arc;

/// Returns the planners, plus one for each `NAME=COMMAND`.
///
/// # Errors
/// A text of another form, or a name that is in use or invalid.
pub fn with_programs(planners: &Arc<Registry>, programs: &[String]) -> CliResult<Arc<Registry>> {
    if programs.is_empty() {
        return Ok(Arc::clone(planners));
    }
    let mut all = Registry::clone(planners);
    for text in programs {
        let bad = |why: &str| {
            CliError::user(format!("`--solver-program {text}` names no program"))
                .because(why)
                .help("write a name, `=` and a command, for example `--solver-program mine='python3 mine.py'`")
        };
        let (name, command) = text.split_once('=').ok_or_else(|| bad("`=` is missing"))?;
        let words = shlex::split(command).ok_or_else(|| bad("a quotation mark in the command is not closed"))?;
        if words.is_empty() {
            return Err(bad("the command is empty"));
        }
        let program = SolverProgram::new(name, words.into_iter().map(OsString::from).collect());
        all.add(Arc::new(program)).map_err(|why| bad(&why))?;
    }
    Ok(Arc::new(all))
}

/// Returns the planners, where each that does not ship works in a separate process: this program again, as `solver NAME`.
pub fn isolated(planners: &Registry) -> Registry {
    let shipped = apex_solvers::shipped();
    let Ok(program) = std::env::current_exe() else { return planners.clone() };
    let isolate = |solver: &Arc<dyn Solver>| -> Arc<dyn Solver> {
        if shipped.find(solver.name()).is_some() {
            return Arc::clone(solver);
        }
        let command = vec![program.clone().into(), "solver".into(), solver.name().into()];
        Arc::new(SolverProgram::of_solver(Arc::clone(solver), command))
    };
    Registry::of(planners.iter().map(isolate).collect())
}
