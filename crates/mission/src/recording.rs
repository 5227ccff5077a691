//! The files of flight records: checks the path of a record to be written or read before anything is changed.

use crate::error::{MissionError, MissionResult};
use crate::files::{nearby_help, unreadable};
use crate::{Mission, flight};
use apex_model::library::Library;
use apex_model::time::Time;
use apex_runtime::RecordError;
use apex_runtime::record::{RecordOptions, RecordReader, Recorder};
use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// Starts a record of a run of `library`; `fill` adds further contents. These are on the disk before the run begins, so that an
/// interrupted record can be explained.
///
/// # Errors
/// A path that cannot hold a record is the user's mistake (another file exists, the folder is missing); a disk that is full or fails is a
/// failure. Other files are left unchanged.
pub fn create(
    path: &Path,
    library: &Library,
    options: RecordOptions,
    fill: impl FnOnce(&mut Recorder) -> Result<(), RecordError>,
) -> MissionResult<Recorder> {
    check_place(path)?;
    options.spare_folder.as_deref().map_or(Ok(()), check_spare_folder)?;
    refuse_when_held(path)?;
    let mut recorder = Recorder::create(path, library, options).map_err(|error| match error {
        RecordError::DiskFull { .. } => {
            remove_beginning(path);
            no_room(path)
        }
        other => written(other),
    })?;
    let filled = recorder.program(library).and_then(|()| fill(&mut recorder)).and_then(|()| recorder.commit());
    if let Err(error) = filled {
        drop(recorder);
        remove_beginning(path);
        return Err(match error {
            RecordError::DiskFull { .. } => no_room(path),
            other => MissionError::record(other.to_string()),
        });
    }
    hold(path);
    Ok(recorder)
}

/// Starts a record of a flight of `mission`, with its program, data and targets inside; the record's track is that of the vehicle.
///
/// # Errors
/// As [`create`].
pub fn of_mission(path: &Path, mission: &Mission, options: RecordOptions) -> MissionResult<Recorder> {
    let vehicle = mission.agent.name.printed().to_string();
    let options = RecordOptions { vehicle: Some(vehicle), ..options };
    create(path, &mission.library, options, |recorder| flight::describe(mission, recorder))
}

/// The records of this program's runs, kept open until they are released or the program ends: closing the file of a record that is still
/// written would release SQLite's own locks on it.
static HELD: Mutex<Vec<(PathBuf, File)>> = Mutex::new(Vec::new());

/// Locks the record for this process. SQLite's locks are not sufficient: a paced flight releases them whenever it waits.
fn hold(path: &Path) {
    // On file systems without such locks, only SQLite's locks protect the record.
    if cfg!(unix)
        && let Ok(file) = File::open(path)
        && file.try_lock().is_ok()
    {
        HELD.lock().unwrap_or_else(PoisonError::into_inner).push((path.to_path_buf(), file));
    }
}

/// Prevents other runs from replacing the record at `path` while this program displays it. A flight that still writes it has the file to
/// itself: then a thread waits for the end of that flight.
pub fn protect(path: &Path) {
    let Some(file) = File::open(path).ok().filter(|_| cfg!(unix)) else { return };
    let keep = |path: PathBuf, file| HELD.lock().unwrap_or_else(PoisonError::into_inner).push((path, file));
    let path = path.to_path_buf();
    match file.try_lock_shared() {
        Ok(()) => keep(path, file),
        Err(TryLockError::WouldBlock) => {
            let wait = move || file.lock_shared().is_ok().then(|| keep(path, file));
            // Without another thread the record is displayed without protection, and readers notice that it was replaced.
            _ = std::thread::Builder::new().name("record lock".into()).spawn(wait);
        }
        Err(TryLockError::Error(_)) => {}
    }
}

/// Permits other runs to replace the record at `path`. For programs that fly more than once; call it after the recorder is dropped.
pub fn release(path: &Path) {
    HELD.lock().unwrap_or_else(PoisonError::into_inner).retain(|(held, _)| held != path);
}

/// Refuses to replace a record that another run still writes or serves.
fn refuse_when_held(path: &Path) -> MissionResult {
    let Ok(file) = File::open(path) else { return Ok(()) };
    match file.try_lock() {
        Err(TryLockError::WouldBlock) if cfg!(unix) => {
            Err(MissionError::record(format!("the flight record {} cannot be replaced", path.display()))
                .because("another run of apex still writes or serves it")
                .help("wait for its end, or choose another name with `--record` (of `apex fork`: `--output`)"))
        }
        _ => Ok(()),
    }
}

/// Returns the error of a disk without space even for the beginning of a record.
fn no_room(path: &Path) -> MissionError {
    MissionError::record(format!("the flight record {} cannot be begun", path.display()))
        .because("the disk is full")
        .help("free some space, or record to another disk with `--record`; nothing was run, and no record is left")
}

/// Removes a record that lacks its program, because it cannot be explained. If it cannot be removed, it remains marked as incomplete.
fn remove_beginning(path: &Path) {
    for suffix in ["", "-wal", "-shm", "-journal"] {
        let mut name = path.as_os_str().to_owned();
        name.push(suffix);
        std::fs::remove_file(name).ok();
    }
}

/// Remedy for a place that cannot hold a record; the option is that of the command.
const ANOTHER_PLACE: &str = "choose another place with `--record` (of `apex fork`: `--output`)";

/// Checks that a record can be created here.
fn check_place(path: &Path) -> MissionResult {
    // SQLite does not treat these names as files: the record would be lost with the program, or options would be read from the name.
    let name = path.to_string_lossy();
    if name.is_empty() || name == ":memory:" || name.get(..5).is_some_and(|start| start.eq_ignore_ascii_case("file:")) {
        return Err(MissionError::record_file(format!("the flight record cannot be `{}`", name.escape_debug()))
            .because("SQLite does not use this name for a file")
            .help("name a file with `--record`, for example `./flight.apex`"));
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or_else(|| Path::new("."));
    let refused = |reason: String, help: &str| {
        let place = format!("the flight record {} cannot be written", path.display());
        Err(MissionError::record_file(place).because(reason).help(help))
    };
    match std::fs::metadata(folder) {
        Ok(found) if found.is_dir() => {}
        Ok(_) => {
            return refused(format!("{} is not a folder", folder.display()), ANOTHER_PLACE);
        }
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            let help = "make the folder, or choose another place with `--record` (of `apex fork`: `--output`)";
            return refused(format!("there is no folder {}", folder.display()), help);
        }
        Err(error) => {
            return refused(format!("{}: {error}", folder.display()), ANOTHER_PLACE);
        }
    }
    check_kind(
        path,
        "choose another name with `--record` (of `apex fork`: `--output`); the existing file is left as it is",
    )
}

/// Checks that a record can continue in the spare folder, which is not created during the flight.
fn check_spare_folder(folder: &Path) -> MissionResult {
    let fault = match std::fs::metadata(folder) {
        Ok(found) if found.is_dir() => match tempfile_in(folder) {
            Ok(()) => return Ok(()),
            Err(error) => error.to_string(),
        },
        Ok(_) => "it is not a folder".into(),
        Err(error) => error.to_string(),
    };
    Err(MissionError::record_file(format!("the flight record cannot continue in {}", folder.display()))
        .because(fault)
        .help("name a folder on another disk with `--spare-folder`, or leave the option out"))
}

/// Creates a file in the folder and removes it.
fn tempfile_in(folder: &Path) -> std::io::Result<()> {
    let path = folder.join(format!(".apex-spare-{}", std::process::id()));
    File::create_new(&path)?;
    std::fs::remove_file(path)
}

/// Rejects devices, pipes and folders: they are not records, and opening some of them blocks forever.
fn check_kind(path: &Path, help: &str) -> MissionResult {
    match std::fs::metadata(path) {
        Ok(found) if !found.is_file() => {
            let kind = if found.is_dir() { "it is a folder" } else { "it is not an ordinary file" };
            Err(MissionError::record_file(format!("{} is not a flight record", path.display()))
                .because(kind)
                .help(help))
        }
        _ => Ok(()),
    }
}

/// Opens a record; a warning states that it is incomplete.
///
/// # Errors
/// A missing file, another kind of file, a record of a newer Apex, or a damaged one.
pub fn open(path: &Path) -> MissionResult<(RecordReader, Option<String>)> {
    check_kind(path, "give a file that `apex fly` or `apex run --record` has written")?;
    if !path.exists() {
        return Err(MissionError::record_file(format!("there is no flight record at {}", path.display()))
            .help(nearby_help(path)));
    }
    File::open(path).map_err(|error| unreadable(path, &error))?;
    let reader = RecordReader::open(path).map_err(read)?;
    let warning = reader.warning().map_err(read)?;
    Ok((reader, warning))
}

/// Returns the error for a record that cannot be written; its kind determines the exit code.
pub fn written(error: RecordError) -> MissionError {
    match error {
        RecordError::NotARecord { .. } => MissionError::record_file(error.to_string()),
        _ => MissionError::record(error.to_string()),
    }
}

/// Returns the error of a record that cannot be read: an error of the file that the user named.
pub fn read(error: RecordError) -> MissionError {
    match error {
        RecordError::NotARecord { path, found } => {
            MissionError::record_file(format!("{} is not a flight record", path.display()))
                .because(found)
                .help("give a file that `apex fly` or `apex run --record` has written")
        }
        // A copy for reading, or a new record that is made of another one.
        RecordError::DiskFull { .. } | RecordError::Unwritable { .. } => MissionError::output(error.to_string()),
        other => MissionError::record_file(other.to_string()),
    }
}

/// Returns the nanoseconds of UTC at mission time 0 of a record; `None` if its mission has no civil time.
///
/// # Errors
/// A record that cannot be read.
pub fn utc_of_zero_ns(reader: &RecordReader) -> MissionResult<Option<i64>> {
    let epoch = reader.meta("epoch_utc").map_err(read)?;
    let seconds = epoch.as_deref().and_then(crate::settings::parse_utc);
    Ok(seconds.map(|seconds| Time::from_seconds(seconds).0))
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::thread;
    use std::time::Duration;

    #[test]
    #[allow(clippy::disallowed_methods, reason = "the test waits for a thread")]
    fn a_record_that_is_shown_while_it_is_written_is_protected_after_its_flight() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("flight.apex");
        std::fs::write(&path, "a record").unwrap();
        let writer = File::open(&path).unwrap();
        writer.lock().unwrap();
        protect(&path);
        assert!(refuse_when_held(&path).is_err(), "the flight has it to itself");
        drop(writer);
        let is_protected = || HELD.lock().unwrap().iter().any(|(held, _)| *held == path);
        for _ in 0..1_000 {
            if is_protected() {
                break;
            }
            thread::sleep(Duration::from_millis(10));
        }
        assert!(is_protected() && refuse_when_held(&path).is_err());
        release(&path);
        assert!(refuse_when_held(&path).is_ok());
    }
}
