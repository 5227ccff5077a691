//! The `apex` command as a library: a third party's program is the whole command with additional planners.
//!
//! ```no_run
//! let planners = apex_cli::shipped();
//! // planners.add(Arc::new(MyPlanner))?;
//! apex_cli::main(std::env::args_os(), planners);
//! ```

#![expect(unreachable_pub, reason = "except for `main` it has no public face; `pub` says that another module uses it")]

mod commands;
mod console;
mod error;
mod external_simulator;
mod options;
mod output;
mod recording;
mod solver_programs;
mod sources;
mod stopping;
mod table_file;

pub use apex_planning::Registry;
pub use apex_solvers::shipped;

use clap::Parser;
use options::{Command, Options};
use std::ffi::OsString;
use std::process::ExitCode;
use std::sync::Arc;

/// Runs the command with these arguments (the program's name first) and planners. It prints its own output, also that of `--help`.
///
/// Planners that do not ship work in separate processes: this program is started again for each problem.
pub fn main(arguments: impl IntoIterator<Item = OsString>, planners: Registry) -> ExitCode {
    let options = match Options::try_parse_from(arguments) {
        Ok(options) => options,
        Err(answer) => return output::print_answer(&answer),
    };
    // A profile measures planners without the time that a process takes to begin.
    let planners = match options.command {
        Command::Solver(_) | Command::Profile(_) => planners,
        _ => solver_programs::isolated(&planners),
    };
    run(options, &Arc::new(planners))
}

/// Like [`main`], but it never ends the process, and all planners run in it.
///
/// # Errors
/// The error in the arguments, as worded by `clap`; also the text of `--help`.
pub fn try_main(arguments: impl IntoIterator<Item = OsString>, planners: Registry) -> Result<ExitCode, String> {
    let options = Options::try_parse_from(arguments).map_err(|told| told.to_string())?;
    Ok(run(options, &Arc::new(planners)))
}

fn run(options: Options, planners: &Arc<Registry>) -> ExitCode {
    let programs = options.command.solver_programs();
    let outcome = solver_programs::with_programs(planners, programs).and_then(|all| obey(options.command, &all));
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            if !error.message.is_empty() {
                output::print_error(&error);
            }
            error.exit_code()
        }
    }
}

fn obey(command: Command, planners: &Arc<Registry>) -> error::CliResult {
    match command {
        Command::Check(options) => commands::check::run(&options),
        Command::Explain(options) => commands::explain::run(&options),
        Command::Fmt(options) => commands::format::run(&options),
        Command::Run(options) => commands::run::run(&options, planners),
        Command::Fly(options) => commands::fly::run(&options, planners),
        Command::Replay(options) => commands::replay::run(&options),
        Command::Verify(options) => commands::verify::run(&options),
        Command::Recover(options) => commands::recover::run(&options),
        Command::Convert(options) => commands::convert::run(&options),
        Command::Score(options) => commands::score::run(&options),
        Command::Fork(options) => commands::fork::run(&options, planners),
        Command::Why(options) => commands::why::run(&options),
        Command::WhyNot(options) => commands::why_not::run(&options),
        Command::Trace(options) => commands::trace::run(&options),
        Command::Monitor(options) => commands::monitor::run(&options),
        Command::Export(options) => commands::export::run(&options),
        Command::Plan(options) => commands::plan::run(&options, planners),
        Command::Profile(command) => commands::profile::run(&command, planners),
        Command::Vehicle(options) => commands::vehicle::run(&options),
        Command::Diagnose(options) => commands::diagnose::run(&options),
        Command::Solver(options) => commands::solver::run(&options, planners),
        Command::Serve(options) => commands::serve::run(&options, planners),
    }
}
