//! Copies of shipped missions with changed programs.

#![allow(clippy::unwrap_used, reason = "a failed test should stop")]

use std::path::Path;
use tempfile::TempDir;

/// Copies the shipped mission `name` into a folder, and replaces texts of its program. A small `:budget` suits tests of the flight:
/// planning takes most of the processor time of a flight, and these tests do not depend on the quality of plans.
///
/// # Panics
/// Where the program does not contain a text that is to be replaced.
pub(crate) fn copy_with(name: &str, changes: &[(&str, &str)]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../missions").join(name);
    for file in std::fs::read_dir(shipped).unwrap() {
        let file = file.unwrap();
        std::fs::copy(file.path(), folder.path().join(file.file_name())).unwrap();
    }
    let path = folder.path().join("mission.pdl");
    let mut program = std::fs::read_to_string(&path).unwrap();
    for (from, to) in changes {
        assert!(program.contains(from), "the program of {name} does not contain `{from}`");
        program = program.replace(from, to);
    }
    std::fs::write(&path, program).unwrap();
    folder
}
