//! The `apex` command: check, run, fly, replay, explain, plan, profile, serve.

use std::process::ExitCode;

fn main() -> ExitCode {
    apex_cli::main(std::env::args_os(), apex_cli::shipped())
}
