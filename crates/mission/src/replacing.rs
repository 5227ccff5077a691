//! Replaces a file completely or not at all, unless another program has changed it.

use crate::error::{MissionError, MissionResult};
use crate::files::{read_bytes, unreadable};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Byte order mark of UTF-8.
const BYTE_ORDER_MARK: &[u8] = &[0xef, 0xbb, 0xbf];

/// Replaces the file that contained `before` by `text`. The text is written to a temporary file in the same folder, which is then
/// renamed, so that a full disk cannot leave half a file. The permissions are kept; for a link, its target is replaced.
///
/// # Errors
/// If the file has changed since it was read, or cannot be written; it is unchanged then.
pub fn replace(file: &Path, before: &str, text: &str) -> MissionResult {
    let target = std::fs::canonicalize(file).map_err(|error| unreadable(file, &error))?;
    let found = read_bytes(&target)?;
    // Readers drop the byte order mark; the file keeps it.
    let (mark, rest) = match found.strip_prefix(BYTE_ORDER_MARK) {
        Some(rest) if !before.as_bytes().starts_with(BYTE_ORDER_MARK) => (BYTE_ORDER_MARK, rest),
        _ => (&[][..], found.as_slice()),
    };
    if rest != before.as_bytes() {
        return Err(MissionError::output(format!("{} changed while it was read", file.display()))
            .because("another program has written it")
            .help("the file is left as it is; run the command again"));
    }
    let permissions = std::fs::metadata(&target).map_err(|error| unreadable(file, &error))?.permissions();
    if permissions.readonly() {
        return Err(MissionError::output(format!("cannot write {}", file.display()))
            .because("it is read-only")
            .help("the file is unchanged; permit writing to it"));
    }
    let temporary = temporary_of(&target);
    let written = std::fs::File::create_new(&temporary).and_then(|mut handle| {
        handle.set_permissions(permissions)?;
        handle.write_all(mark)?;
        handle.write_all(text.as_bytes())?;
        handle.sync_all()?;
        std::fs::rename(&temporary, &target)
    });
    written.map_err(|error| {
        // The half-written copy must not remain; if it cannot be removed, no further remedy exists.
        std::fs::remove_file(&temporary).ok();
        MissionError::output(format!("cannot write {}", file.display())).because(error).help("the file is unchanged")
    })
}

/// Returns a name in the same folder that only this process uses.
fn temporary_of(file: &Path) -> PathBuf {
    let mut name = file.as_os_str().to_owned();
    name.push(format!(".writing-{}", std::process::id()));
    PathBuf::from(name)
}
