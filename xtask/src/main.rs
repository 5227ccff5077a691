//! House rules as a program: `cargo xtask tidy` checks them, `cargo xtask catalogue` writes the list of services.
//!
//! Every rule that the project prints in its pages and that no lint can see is checked here, so that it stays true
//! without good will. Each rule is one file with one public function from texts to findings.

mod bans;
mod catalogue;
mod finding;
mod headers;
mod imports;
mod mask;
mod readmes;
mod sizes;
mod tidy;
mod tree;
mod words;

use std::path::PathBuf;
use std::process::ExitCode;

const USAGE: &str = "usage: cargo xtask tidy       check the house rules\n       cargo xtask catalogue  write docs/reference/services.md from the services' headers";

fn main() -> ExitCode {
    let command = std::env::args().nth(1).unwrap_or_default();
    let result = match command.as_str() {
        "tidy" => tidy::run(&root()),
        "catalogue" => catalogue::write(&root()),
        _ => Err(USAGE.to_string()),
    };
    match result {
        Ok(text) => {
            println!("{text}");
            ExitCode::SUCCESS
        }
        Err(text) => {
            eprintln!("{text}");
            ExitCode::FAILURE
        }
    }
}

/// The top folder of the project: the parent of this package.
fn root() -> PathBuf {
    let package = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    package.parent().map(PathBuf::from).unwrap_or(package)
}
