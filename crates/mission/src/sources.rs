//! Sources of a mission's data files: a folder, or files held in memory, such as those stored in a flight record.

use crate::error::{MissionError, MissionResult};
use crate::files::{nearby_help, read_bytes, text_of};
use std::path::PathBuf;

/// The text of a world file.
#[derive(Debug, Clone, PartialEq)]
pub struct WorldText {
    /// Name of the file in messages.
    pub place: String,
    /// Contents of the file.
    pub text: String,
}

/// The data files of a mission, read by name.
#[derive(Debug, Clone)]
pub(crate) enum Sources {
    /// Files in this folder.
    Folder(PathBuf),
    /// Names with bytes.
    Held(Vec<(String, Vec<u8>)>),
}

/// A file that has been read.
#[derive(Debug)]
pub(crate) struct DataFile {
    /// Its name in messages.
    pub(crate) place: String,
    /// Its bytes.
    pub(crate) bytes: Vec<u8>,
}

impl DataFile {
    /// Returns the file as text.
    pub(crate) fn text(&self) -> MissionResult<String> {
        text_of(&self.place, self.bytes.clone())
    }
}

impl Sources {
    /// Returns the bytes of a file held in memory; `None` for a folder, and if there is no such file.
    pub(crate) fn held(&self, name: &str) -> Option<&[u8]> {
        let Sources::Held(files) = self else { return None };
        files.iter().find(|(known, _)| known == name).map(|(_, bytes)| bytes.as_slice())
    }

    /// Reads the file `name`, which the mission names at `named_by`.
    pub(crate) fn read(&self, name: &str, named_by: impl Fn() -> String) -> MissionResult<DataFile> {
        let missing = |place: &str, help: String| {
            MissionError::data(format!("cannot read {place}"))
                .because(format!("there is no such file, but {}", named_by()))
                .help(help)
        };
        match self {
            Sources::Folder(folder) => {
                let path = folder.join(name);
                let place = path.display().to_string();
                if !path.is_file() {
                    return Err(missing(&place, nearby_help(&path)));
                }
                Ok(DataFile { place, bytes: read_bytes(&path)? })
            }
            Sources::Held(files) => {
                let found = files.iter().find(|(known, _)| known == name);
                let names = || files.iter().map(|(known, _)| known.as_str()).collect::<Vec<_>>().join(", ");
                let (_, bytes) = found.ok_or_else(|| missing(name, format!("the sources hold {}", names())))?;
                Ok(DataFile { place: name.to_string(), bytes: bytes.clone() })
            }
        }
    }
}
