//! Runs every page below `spec/` as one test. `UPDATE=1` rewrites the compared parts of pages; further arguments are parts of names of
//! the pages to run.

use apex_spec::page;
use apex_spec::verdict::{Verdict, judge, updated};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

fn main() -> ExitCode {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    let filters: Vec<String> = std::env::args().skip(1).filter(|argument| !argument.starts_with('-')).collect();
    let listing = std::env::args().any(|argument| argument == "--list");
    let update = std::env::var("UPDATE").is_ok_and(|value| !value.is_empty() && value != "0");
    let named = page::files().into_iter().map(|path| (name_of(&root, &path), path));
    let chosen: Vec<_> = named
        .filter(|(name, _)| filters.is_empty() || filters.iter().any(|filter| name.contains(filter.as_str())))
        .collect();
    if listing {
        chosen.iter().for_each(|(name, _)| println!("{name}: test"));
        return ExitCode::SUCCESS;
    }
    let mut failures = Vec::new();
    println!("running {} tests", chosen.len());
    for (name, path) in &chosen {
        match run_page(path, update) {
            Ok(()) => println!("test {name} ... ok"),
            Err(difference) => {
                println!("test {name} ... FAILED");
                failures.push((name, difference));
            }
        }
    }
    for (name, difference) in &failures {
        println!("\n---- spec/{name}.md (- the page says, + what happens)\n{difference}");
    }
    let word = if failures.is_empty() { "ok" } else { "FAILED" };
    let passed = chosen.len() - failures.len();
    println!(
        "\ntest result: {word}. {passed} passed; {} failed; 0 ignored; 0 measured; 0 filtered out",
        failures.len()
    );
    if failures.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn run_page(path: &Path, update: bool) -> Result<(), String> {
    let text = fs::read_to_string(path).map_err(|error| format!("  cannot be read: {error}\n"))?;
    if update {
        let page = updated(&text)?;
        return fs::write(path, page).map_err(|error| format!("  cannot be written: {error}\n"));
    }
    match judge(&text) {
        Verdict::Holds => Ok(()),
        Verdict::Differs(difference) => Err(difference),
    }
}

fn name_of(root: &Path, path: &Path) -> String {
    let relative = path.strip_prefix(root).unwrap_or(path).with_extension("");
    relative.to_string_lossy().replace('\\', "/")
}
