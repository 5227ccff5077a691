//! The `apex` command: check, run, fly, replay, explain, plan, profile, serve.

#![expect(unreachable_pub, reason = "a binary has no public face; `pub` says that another module uses it")]

mod commands;
mod console;
mod mission;
mod monitor;
mod options;
mod output;
mod outside;
mod plan_output;
mod recording;
mod replacing;
mod sources;
mod telling;
mod trouble;

use clap::Parser;
use options::{Command, Options};
use std::process::ExitCode;

fn main() -> ExitCode {
    let outcome = match Options::parse().command {
        Command::Check(options) => commands::check::run(&options),
        Command::Explain(options) => commands::explain::run(&options),
        Command::Fmt(options) => commands::format::run(&options),
        Command::Run(options) => commands::run::run(&options),
        Command::Fly(options) => commands::fly::run(&options),
        Command::Replay(options) => commands::replay::run(&options),
        Command::Why(options) => commands::why::run(&options),
        Command::WhyNot(options) => commands::why_not::run(&options),
        Command::Trace(options) => commands::trace::run(&options),
        Command::Monitor(options) => commands::monitor::run(&options),
        Command::Export(options) => commands::export::run(&options),
        Command::Plan(options) => commands::plan::run(&options),
        Command::Profile(command) => commands::profile::run(&command),
        Command::Serve(options) => commands::serve::run(&options),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(trouble) => {
            if !trouble.message.is_empty() {
                output::complain(&trouble);
            }
            trouble.exit_code()
        }
    }
}
