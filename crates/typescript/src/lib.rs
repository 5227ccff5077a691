//! TypeScript types of the page, generated from types of Rust. Tests call [`check`]; with `UPDATE=1` they write the files.

use std::path::{Path, PathBuf};
use ts_rs::{Config, TS};

/// Returns `export type ..` with its documentation. Whole numbers are numbers: nanoseconds of mission time stay below 2^53 for a hundred
/// days.
pub fn declaration<T: TS>() -> String {
    let config = Config::default().with_large_int("number");
    format!("{}export {}\n", T::docs().unwrap_or_default(), T::decl(&config))
}

/// Compares a file of `web/src/record/generated` with the declarations of a crate.
///
/// # Errors
/// The file differs from the generated text; the message names the command that writes it. With `UPDATE` in the environment the file is
/// written instead.
pub fn check(crate_name: &str, file: &str, imports: &str, declarations: &[String]) -> Result<(), String> {
    let command = format!("UPDATE=1 cargo test -p apex-{crate_name} typescript");
    let header = format!("// Generated from crates/{crate_name} by `{command}`. Do not edit.\n");
    let text = format!("{header}{imports}\n{}", declarations.join("\n"));
    let path = folder().join(file);
    if std::env::var_os("UPDATE").is_some() {
        return std::fs::write(&path, &text).map_err(|error| format!("cannot write {}: {error}", path.display()));
    }
    match std::fs::read_to_string(&path) {
        Ok(found) if found == text => Ok(()),
        _ => Err(format!("{} differs from the types in Rust; run `{command}`", path.display())),
    }
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../web/src/record/generated")
}
