//! Segments: a record whose file accepts no more rows continues in a new file, next to it or in a spare folder.
//!
//! A segment begins with every row that later steps need (facts, sources, variables, words, shapes, targets), so it can be read alone.
//! The fact `continues` names the preceding file, its last group that counts, and the chain of that group, so that both can be joined
//! again (`segment_join.rs`).

use super::closing;
use super::connect::plain;
use super::schema::{self, PAGE_BYTES, limit_bytes, remove};
use super::seal::{ChainPosition, Hash};
use crate::error::RecordError;
use rusqlite::Connection;
use std::fmt;
use std::path::{Path, PathBuf};

/// The fact that names the file that a segment continues ([`Continuation`]).
pub(super) const CONTINUES: &str = "continues";
/// The fact that names the folder in which segments may be, as well as next to the record.
pub(super) const SPARE_FOLDER: &str = "spare_folder";
/// The fact that names the step after which a snapshot was taken only because the segment began.
pub(super) const SEGMENT_SNAPSHOT: &str = "segment_snapshot";
/// Maximum number of files of one record: names of segments are looked for up to this number.
const SEGMENTS_MAX: usize = 10_000;

/// The place in an earlier file after which a segment continues.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Continuation {
    /// Number of the last group before the segment, and its chain.
    pub(super) after: ChainPosition,
    /// Number of the last step before the segment.
    pub(super) batch: i64,
    /// The file of that group.
    pub(super) path: PathBuf,
}

impl fmt::Display for Continuation {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{} {} ", self.after.id, self.batch)?;
        self.after.chain.iter().try_for_each(|byte| write!(out, "{byte:02x}"))?;
        write!(out, " {}", self.path.display())
    }
}

impl Continuation {
    /// Reads the value of the fact [`CONTINUES`].
    pub(super) fn parse(text: &str) -> Option<Continuation> {
        let mut words = text.splitn(4, ' ');
        let (id, batch, chain, path) = (words.next()?, words.next()?, words.next()?, words.next()?);
        let mut bytes: Hash = Hash::default();
        let digit = |at: usize| chain.get(at..at + 2).and_then(|pair| u8::from_str_radix(pair, 16).ok());
        for (index, byte) in bytes.iter_mut().enumerate() {
            *byte = digit(2 * index)?;
        }
        let after = ChainPosition { id: id.parse().ok()?, chain: bytes };
        Some(Continuation { after, batch: batch.parse().ok()?, path: PathBuf::from(path) })
    }

    /// Returns the preceding file: at its recorded path, or next to `segment` if both were moved together.
    pub(super) fn find(&self, segment: &Path) -> Option<PathBuf> {
        let same_folder = self.path.file_name().map(|name| segment.with_file_name(name));
        [Some(self.path.clone()), same_folder].into_iter().flatten().find(|path| path.is_file())
    }
}

/// Returns the fact [`CONTINUES`] of an open record.
pub(super) fn continuation(connection: &Connection) -> rusqlite::Result<Option<String>> {
    use rusqlite::OptionalExtension;
    let sql = "SELECT value FROM main.meta WHERE key = ?1 ORDER BY position DESC LIMIT 1";
    connection.query_row(sql, [CONTINUES], |row| row.get(0)).optional()
}

/// Returns true if the file at `segment` continues the file at `path`: an older flight may have left a segment of the same name.
fn continues(segment: &Path, path: &Path) -> bool {
    let fact = plain(segment, segment).ok().and_then(|connection| continuation(&connection).ok().flatten());
    let Some(continuation) = fact.and_then(|text| Continuation::parse(&text)) else { return false };
    let earlier = continuation.find(segment).and_then(|earlier| std::fs::canonicalize(earlier).ok());
    if earlier.is_none() || earlier != std::fs::canonicalize(path).ok() {
        return false;
    }
    let ChainPosition { id, chain } = continuation.after;
    let chain_of = |connection: Connection| {
        connection.query_row("SELECT chain FROM main.seal WHERE id = ?1", [id], |row| row.get::<_, Vec<u8>>(0)).ok()
    };
    id == 0 || plain(path, path).ok().and_then(chain_of).is_some_and(|found| found == chain)
}

/// Places of a record's segments.
#[derive(Clone, Debug, Default)]
pub(super) struct SegmentPlaces {
    /// Folder on another disk.
    pub(super) spare_folder: Option<PathBuf>,
    /// Largest size of a file in the record's own folder, in bytes.
    pub(super) bytes_max: Option<u64>,
}

impl SegmentPlaces {
    /// Returns the next name, next to the file at `path` and in the spare folder: no folder has a segment of that number.
    pub(super) fn next(&self, path: &Path) -> Vec<PathBuf> {
        let mut names = self.later(path).take(SEGMENTS_MAX);
        names.find(|names| names.iter().all(|path| !path.exists())).unwrap_or_default()
    }

    /// Returns the names of segments after the file at `path`, by number: in its folder and in the spare folder.
    fn later(&self, path: &Path) -> impl Iterator<Item = Vec<PathBuf>> + use<> {
        let folder = path.parent().map(Path::to_path_buf).unwrap_or_default();
        let stem = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
        let numbered = stem.rsplit_once("-segment-").and_then(|(first, number)| Some((first, number.parse().ok()?)));
        let (stem, number): (&str, u32) = numbered.unwrap_or((&stem, 1));
        let stem = stem.to_owned();
        let spare = self.spare_folder.clone().filter(|spare| *spare != folder);
        let folders: Vec<PathBuf> = [Some(folder), spare].into_iter().flatten().collect();
        (number + 1..).map(move |number| {
            folders.iter().map(|folder| folder.join(format!("{stem}-segment-{number}.apex"))).collect()
        })
    }

    /// Returns the file in which the record that ends with the file at `path` continues, if there is one: the last, if there are several.
    pub(super) fn successor(&self, path: &Path) -> Option<PathBuf> {
        let mut last = None;
        for _ in 0..SEGMENTS_MAX {
            let path = last.as_deref().unwrap_or(path);
            // Numbers of other files are skipped, as when the segment got its name.
            let existing = self.later(path).map(|names| names.into_iter().filter(|name| name.is_file()).collect());
            let mut existing = existing.take_while(|names: &Vec<PathBuf>| !names.is_empty()).flatten();
            let Some(next) = existing.find(|segment| continues(segment, path)) else { break };
            last = Some(next);
        }
        last
    }

    /// Makes the file of a segment of the record at `path`.
    pub(super) fn make(&self, segment: &Path, path: &Path) -> Result<Connection, RecordError> {
        let made = schema::create(segment).and_then(|connection| {
            if let Some(bytes) = self.bytes_max.filter(|_| segment.parent() == path.parent()) {
                limit_bytes(&connection, segment, bytes)?;
                check_room(&connection, segment, bytes)?;
            }
            Ok(connection)
        });
        made.inspect_err(|_| remove(segment))
    }
}

/// Checks the size of the tables: SQLite never makes a file smaller, so tables beyond `bytes` are rejected.
fn check_room(connection: &Connection, path: &Path, bytes: u64) -> Result<(), RecordError> {
    let pages: i64 = connection
        .query_row("PRAGMA page_count", [], |row| row.get(0))
        .map_err(|error| schema::write_error(path, "making its tables", error))?;
    if pages.unsigned_abs() * PAGE_BYTES <= bytes {
        return Ok(());
    }
    Err(RecordError::DiskFull { path: path.to_path_buf(), doing: "making its tables".into() })
}

/// Closes the file of a segment that a newer one continues. As much of its log as the disk accepts is copied into it.
pub(super) fn leave(connection: Option<Connection>, path: &Path) {
    if let Some(connection) = connection {
        // The log next to it keeps what the disk does not accept.
        let _ = closing::close(connection, path);
    }
}

/// Lets a write beyond the largest size of files (`ulimit -f`) fail from now on. Without this, its signal would end the program.
pub(super) fn outlive_file_size_limits() {
    #[cfg(unix)]
    {
        use std::sync::atomic::AtomicBool;
        use std::sync::{Arc, Once};
        static ONCE: Once = Once::new();
        // Where no handler can be set, the limit ends the program, as before.
        ONCE.call_once(|| {
            _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, Arc::new(AtomicBool::new(false)))
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_continuation_is_read_as_it_is_written() {
        let chain = std::array::from_fn(|index| index as u8 * 7);
        let path = PathBuf::from("/flights/a b-segment-3.apex");
        let continuation = Continuation { after: ChainPosition { id: 12, chain }, batch: 3_400, path };
        assert_eq!(Continuation::parse(&continuation.to_string()), Some(continuation.clone()));
        let cut: String = continuation.to_string().chars().take(40).collect();
        for text in ["", "12", "12 3400 00ff /a", &format!("x{continuation}"), &cut] {
            assert_eq!(Continuation::parse(text), None, "{text}");
        }
    }

    #[test]
    fn names_of_segments_count_on_and_replace_nothing() {
        let (here, spare) = (tempfile::TempDir::new().unwrap(), tempfile::TempDir::new().unwrap());
        let places = SegmentPlaces { spare_folder: Some(spare.path().to_path_buf()), bytes_max: None };
        let names = |path: &Path| places.next(path);
        let first = here.path().join("flight.apex");
        let of = |number: u32| {
            [here.path(), spare.path()].map(|folder| folder.join(format!("flight-segment-{number}.apex")))
        };
        let [second, _] = of(2);
        assert_eq!(names(&first), of(2));
        std::fs::write(&second, "").unwrap();
        assert_eq!((names(&first), names(&second)), (of(3).to_vec(), of(3).to_vec()));
        let [_, third] = of(3);
        std::fs::write(&third, "").unwrap();
        assert_eq!(names(&first), of(4));
    }
}
