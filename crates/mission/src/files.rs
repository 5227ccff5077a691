//! Reads files, with errors that state the reason and the remedy.

use crate::error::{MissionError, MissionResult};
use std::io::Read;

/// Reads a text file.
///
/// # Errors
/// The file, the reason for which it cannot be read, and the remedy.
pub fn read_text(path: &std::path::Path) -> MissionResult<String> {
    text_of(&path.display().to_string(), read_bytes(path)?)
}

/// Size of the largest file that is read at once: a matrix of 5,000 x 5,000 travel times is half of it.
const FILE_BYTES_MAX: u64 = 512 << 20;
/// Largest amount that is read from a device or pipe, whose length is unknown.
const STREAM_BYTES_MAX: u64 = 64 << 20;
/// Some editors write this mark at the beginning of a file; it is not part of the text.
const BYTE_ORDER_MARK: char = '\u{feff}';

/// Returns the bytes of the file `place` as text, without a byte order mark.
pub(crate) fn text_of(place: &str, bytes: Vec<u8>) -> MissionResult<String> {
    let text = String::from_utf8(bytes);
    let text = text.map(|text| text.strip_prefix(BYTE_ORDER_MARK).map(str::to_string).unwrap_or(text));
    text.map_err(|error| {
        let valid = error.utf8_error().valid_up_to();
        MissionError::data(format!("{place} is not text"))
            .because(format!("byte {valid} is not UTF-8"))
            .help("save the file as UTF-8")
    })
}

/// Reads a file.
///
/// # Errors
/// The file, the reason for which it cannot be read, and the remedy.
pub fn read_bytes(path: &std::path::Path) -> MissionResult<Vec<u8>> {
    if path.is_dir() {
        return Err(MissionError::data(format!("{} is a folder", path.display())).help("name a file in it"));
    }
    let unreadable = |error: std::io::Error| unreadable(path, &error);
    let file = std::fs::File::open(path).map_err(unreadable)?;
    let found = file.metadata().map_err(unreadable)?;
    let limit = if found.is_file() { FILE_BYTES_MAX } else { STREAM_BYTES_MAX };
    let mut bytes = Vec::new();
    if found.len() <= limit {
        file.take(limit + 1).read_to_end(&mut bytes).map_err(unreadable)?;
    }
    if found.len() > limit || bytes.len() as u64 > limit {
        return Err(MissionError::data(format!("{} is too large to be read", path.display()))
            .because(format!("it holds more than {} MiB", limit >> 20))
            .help("name a text file; logs are read by `apex monitor` and `apex export`"));
    }
    Ok(bytes)
}

/// Returns the error of a file that is not found or not readable.
pub fn unreadable(path: &std::path::Path, error: &std::io::Error) -> MissionError {
    let help = match error.kind() {
        std::io::ErrorKind::PermissionDenied => "ask its owner for the right to read it".to_string(),
        _ => nearby_help(path),
    };
    MissionError::data(format!("cannot read {}", path.display())).because(error).help(help)
}

/// Maximum number of names in a message.
const NEARBY_MAX: usize = 12;

/// Returns a help text that names similar files and missions of the same folder, or the folder in which a relative path was searched.
pub fn nearby_help(path: &std::path::Path) -> String {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let folder = folder.unwrap_or_else(|| std::path::Path::new("."));
    let extension = path.extension();
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .into_iter()
        .flatten()
        .flatten()
        .map(|entry| entry.path())
        .filter(|candidate| candidate.extension() == extension || candidate.join("mission.pdl").is_file())
        .filter_map(|candidate| candidate.file_name().map(|name| name.to_string_lossy().into_owned()))
        .filter(|name| !name.starts_with('.'))
        .collect();
    let wanted = path.file_stem().map(|stem| stem.to_string_lossy().to_lowercase()).unwrap_or_default();
    // Names that begin alike first: most wrong names are misspelt or cut short.
    names.sort_by_key(|name| (usize::MAX - alike(&name.to_lowercase(), &wanted), name.clone()));
    let more = names.len().saturating_sub(NEARBY_MAX);
    names.truncate(NEARBY_MAX);
    if more > 0 {
        names.push(format!("{more} more"));
    }
    let folder_name =
        if folder == std::path::Path::new(".") { "this folder".into() } else { folder.display().to_string() };
    match (folder.is_dir(), names.is_empty()) {
        (false, _) => format!("the folder {} does not exist; check the path", folder.display()),
        (true, true) => format!("there is nothing like it in {folder_name}; check the path"),
        (true, false) => format!("{folder_name} holds {}", names.join(", ")),
    }
}

/// Returns the number of characters at the beginning that two names share.
fn alike(a: &str, b: &str) -> usize {
    a.chars().zip(b.chars()).take_while(|(a, b)| a == b).count()
}
