//! Copies committed groups from the write-ahead log into the main file once a second, on a separate thread. A plain copy of the `*.apex`
//! file is then complete except for the last seconds, and the flight does not wait for the disk.

use crate::limits::CHECKPOINT_INTERVAL;
use rusqlite::{Connection, OpenFlags};
use std::path::Path;
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::thread::{self, JoinHandle};

/// The running thread; dropping it ends the thread.
pub(super) struct Checkpoints {
    /// Dropping this end of the channel ends the thread.
    stop: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Checkpoints {
    /// Starts for the record at `path`, which must be in WAL mode. `None` if the record cannot be opened twice or no thread can be made:
    /// SQLite then checkpoints alone, every four megabytes.
    pub(super) fn begin(path: &Path) -> Option<Checkpoints> {
        let flags = OpenFlags::SQLITE_OPEN_READ_WRITE | OpenFlags::SQLITE_OPEN_NO_MUTEX;
        let connection = Connection::open_with_flags(path, flags).ok()?;
        let (stop, stopped) = mpsc::channel();
        let work = move || {
            while stopped.recv_timeout(CHECKPOINT_INTERVAL) == Err(RecvTimeoutError::Timeout) {
                // A reader may hold back a part of the log; the next second copies the rest.
                let _ = connection.query_row("PRAGMA wal_checkpoint(PASSIVE)", [], |_| Ok(()));
            }
        };
        let thread = thread::Builder::new().name("record".into()).spawn(work).ok()?;
        Some(Checkpoints { stop: Some(stop), thread: Some(thread) })
    }
}

impl Drop for Checkpoints {
    fn drop(&mut self) {
        self.stop = None;
        if let Some(thread) = self.thread.take() {
            // A panic of the thread harms nothing: checkpoints only save time later.
            let _ = thread.join();
        }
    }
}
