//! Rules of the repository as a program: `cargo xtask tidy` checks them; other commands list, lower and generate.
//!
//! Every rule that is written in the project's pages and that no lint can check is checked here, so that it does not depend on good will.
//! Each rule is one file or folder with one public function from texts to findings.

mod bans;
mod catalogue;
mod ceilings;
mod commits;
mod english;
mod finding;
mod git;
mod headers;
mod imports;
mod mask;
mod paths;
mod phrases;
mod prose;
mod quality;
mod quick;
mod readmes;
mod rings;
mod sizes;
mod testing;
mod third_party;
mod tidy;
mod tree;
mod words;
mod workspace;
mod wrap;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use workspace::Workspace;

const USAGE: &str = "usage: cargo xtask tidy                check the rules of the repository
       cargo xtask quick               check and test what a change needs
       cargo xtask test ARGUMENT ..    run tests as `cargo test` does, several programs at a time
       cargo xtask rings [--update]    list rings of imports; lower their ceilings
       cargo xtask phrases [--update]  list phrases to avoid in changed lines; lower their ceilings
       cargo xtask english [--update]  list breaches of the rules for texts in changed lines; lower their ceilings
       cargo xtask pages --update      lower the ceilings of absent pages that code names
       cargo xtask wrap PATH ..        wrap long lines of Markdown
       cargo xtask catalogue           write docs/reference/services.md from the services' headers
       cargo xtask quality             write docs/reference/quality.md from the measurements of `make quality`";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match root().and_then(|root| run(&root, &words)) {
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

fn run(root: &Path, words: &[&str]) -> Result<String, String> {
    match words {
        ["tidy"] => tidy::run(root),
        ["quick"] => quick::run(root),
        ["test", arguments @ ..] => testing::run(root, arguments),
        ["rings"] => rings::report(&Workspace::read(root)?, &tree::read(root)?),
        ["rings", "--update"] => rings::update(root, &Workspace::read(root)?, &tree::read(root)?),
        ["phrases"] => phrases::report(&tree::read(root)?, &git::changes(root)?),
        ["phrases", "--update"] => phrases::update(root, &tree::read(root)?),
        ["english"] => Ok(english::report(&tree::read(root)?, &git::changes(root)?)),
        ["english", "--update"] => english::update(root, &tree::read(root)?),
        ["pages", "--update"] => paths::update(root, &paths::Paths::new(&tree::names(root)?), &tree::read(root)?),
        ["wrap", paths @ ..] if !paths.is_empty() => wrap::run(root, &tree::names(root)?, paths),
        ["catalogue"] => catalogue::write(root),
        ["quality"] => quality::write(root),
        _ => Err(USAGE.to_string()),
    }
}

/// Returns the top folder of the project that contains the working directory: the nearest folder with `xtask/Cargo.toml`.
///
/// The folder in which this program was compiled is not used: a build that was copied with its tree would check the tree that it was
/// copied from.
///
/// # Errors
/// The working directory, if it is outside a project.
fn root() -> Result<PathBuf, String> {
    let here = std::env::current_dir().map_err(|error| format!("cannot read the working directory: {error}"))?;
    let root = here.ancestors().find(|folder| folder.join("xtask/Cargo.toml").is_file());
    root.map(PathBuf::from).ok_or_else(|| {
        format!("{}: neither this folder nor one above it holds xtask/Cargo.toml; run in the project", here.display())
    })
}
