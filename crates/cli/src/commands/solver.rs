//! `apex solver`: runs a planner as a solver program, over standard input and output.

use crate::error::{CliError, CliResult};
use crate::options::SolverOptions;
use apex_planning::Registry;
use apex_runtime::limits::SOLVER_STACK_BYTES;
use apex_runtime::solver_process::serve;
use std::fs::File;
use std::io::{self, BufReader};
use std::os::fd::AsFd;
use std::sync::Arc;

/// Answers the single request on standard input.
pub fn run(options: &SolverOptions, planners: &Arc<Registry>) -> CliResult {
    let name = &options.name;
    let Some(solver) = planners.find(name).cloned() else {
        let names: Vec<&str> = planners.iter().map(|solver| solver.name()).collect();
        return Err(
            CliError::user(format!("there is no solver `{name}`")).help(format!("known are {}", names.join(", ")))
        );
    };
    let failed = |error: io::Error| CliError::failure(format!("the solver `{name}` cannot be served")).because(error);
    let mut output = own_output().map_err(failed)?;
    // Recursive planners need a larger stack than the main thread has.
    let work = move || serve(&*solver, BufReader::new(io::stdin()), &mut output);
    let thread = std::thread::Builder::new().name("solver".into()).stack_size(SOLVER_STACK_BYTES).spawn(work);
    let served = thread.map_err(failed)?.join();
    served.unwrap_or_else(|_| Err(io::Error::other("it panicked"))).map_err(|error| match error.kind() {
        io::ErrorKind::InvalidData => CliError::user(error.to_string()).help(
            "`apex solver` is started by Apex; `docs/reference/solver-programs.md` says what it reads and writes",
        ),
        _ => failed(error),
    })
}

/// Returns the standard output for the protocol alone: other output of the planner goes to standard error from now on.
fn own_output() -> io::Result<File> {
    let output = io::stdout().as_fd().try_clone_to_owned()?;
    rustix::stdio::dup2_stdout(io::stderr().as_fd())?;
    Ok(File::from(output))
}
