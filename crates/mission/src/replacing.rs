//! Replaces a file as a whole or not at all, unless another program has written it meanwhile.

use crate::error::{MissionError, MissionResult};
use crate::files::{read_bytes, unreadable};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Puts `text` in place of the file that held `before`. The text is written to a temporary file in the same folder and renamed, so that a full disk
/// cannot leave half a file; the file's permissions stay, and of a link the file behind it is replaced.
///
/// # Errors
/// The file has changed since it was read, or cannot be written; it is unchanged then.
pub fn replace(file: &Path, before: &str, text: &str) -> MissionResult {
    let target = std::fs::canonicalize(file).map_err(|error| unreadable(file, &error))?;
    if read_bytes(&target)? != before.as_bytes() {
        return Err(MissionError::output(format!("{} changed while it was looked at", file.display()))
            .because("somebody else has written it")
            .help("the file is left as it is; run the command again"));
    }
    let permissions = std::fs::metadata(&target).map_err(|error| unreadable(file, &error))?.permissions();
    if permissions.readonly() {
        return Err(MissionError::output(format!("cannot write {}", file.display()))
            .because("it is read-only")
            .help("the file is unchanged"));
    }
    let temporary = temporary_of(&target);
    let written = std::fs::File::create_new(&temporary).and_then(|mut handle| {
        handle.set_permissions(permissions)?;
        handle.write_all(text.as_bytes())?;
        handle.sync_all()?;
        std::fs::rename(&temporary, &target)
    });
    written.map_err(|error| {
        // The half-written copy must not stay behind; if it cannot be removed there is nothing more to do.
        std::fs::remove_file(&temporary).ok();
        MissionError::output(format!("cannot write {}", file.display())).because(error).help("the file is unchanged")
    })
}

/// A name in the same folder that belongs to this process alone.
fn temporary_of(file: &Path) -> PathBuf {
    let mut name = file.as_os_str().to_owned();
    name.push(format!(".writing-{}", std::process::id()));
    PathBuf::from(name)
}
