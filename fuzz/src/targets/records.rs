//! Damaged flight records: edits of the bytes of a finished record, with three bytes per edit (position and value), or a truncation.
//!
//! Property: if the check of a record finds no damage, its steps are those of the original.

use crate::planted;
use crate::sample;
use apex_model::time::Time;
use apex_runtime::record::{RecordReader, check_integrity};
use std::path::PathBuf;
use std::sync::LazyLock;

const EDITS_MAX: usize = 64;

/// A file in memory that each run overwrites.
static FILE: LazyLock<(tempfile::TempDir, PathBuf)> = LazyLock::new(|| {
    let folder = sample::folder().unwrap_or_else(|error| panic!("no folder for records: {error}"));
    let path = folder.path().join("damaged.apex");
    (folder, path)
});

static STEPS: LazyLock<String> = LazyLock::new(|| {
    let reader = RecordReader::open(&sample::record_path());
    reader
        .map_err(|error| error.to_string())
        .and_then(|reader| steps(&reader))
        .unwrap_or_else(|error| panic!("{error}"))
});

/// Returns all steps of a record as text.
fn steps(reader: &RecordReader) -> Result<String, String> {
    let mut text = String::new();
    for step in reader.steps_of_all(Time::END).map_err(|error| error.to_string())? {
        let step = step.map_err(|error| error.to_string())?;
        text += &format!("{:?} {:?}\n", step.batch, step.decoded_effects()?);
    }
    Ok(text)
}

/// Runs the target.
pub(crate) fn run(edits: &[u8]) {
    let original = sample::record();
    let mut bytes = original.to_vec();
    for edit in edits.chunks_exact(4).take(EDITS_MAX) {
        let position = (usize::from(edit[0]) << 16) | (usize::from(edit[1]) << 8) | usize::from(edit[2]);
        if edit[0] >= 0xf0 {
            bytes.truncate(position % original.len());
        } else if let Some(byte) = bytes.get_mut(position % original.len()) {
            *byte = edit[3];
        }
    }
    let is_changed = bytes != original;
    if std::fs::write(&FILE.1, &bytes).is_err() {
        return;
    }
    let Ok(integrity) = check_integrity(&FILE.1) else { return };
    let read = RecordReader::open(&FILE.1).map_err(|error| error.to_string()).and_then(|reader| steps(&reader));
    // The planted bug: the result of the check is ignored.
    let is_trusted = integrity.is_intact() || planted::ARE_IN;
    if let (true, Ok(read)) = (is_trusted && is_changed, read) {
        assert!(read == *STEPS, "a changed record is taken for intact with other steps");
    }
}
