//! Reads a closed record while its file is compared with its seal: both read the whole file, on different processors.
//!
//! Nothing that was read early is used before the comparison has succeeded, and only if the file has not changed meanwhile. A file that is
//! not as it was closed may keep this reading busy; it is interrupted as soon as the comparison has failed.

use crate::record::open::{self, Stamp};
use crate::record::reader::RecordReader;
use rusqlite::InterruptHandle;
use std::path::Path;
use std::sync::Arc;
use std::thread;

/// A reading that has begun before its record was checked, with the indexes `I` that it fills. It is interrupted when this value is
/// dropped, unless its result was taken.
pub(super) struct EarlyReading<I> {
    /// Another connection of the reading, with the same effects and tasks in memory.
    reader: RecordReader,
    indexes: Arc<I>,
    stamp: Stamp,
    /// `None` after the result was taken.
    interrupt: Option<InterruptHandle>,
}

impl<I> Drop for EarlyReading<I> {
    fn drop(&mut self) {
        if let Some(interrupt) = &self.interrupt {
            interrupt.interrupt();
        }
    }
}

impl<I: Default + Send + Sync + 'static> EarlyReading<I> {
    /// Begins to read agent number `agent` of a file that has a seal; `None` for any other file, and for one that cannot be read: the
    /// checked reading then reports the reason. `read` fills the indexes.
    pub(super) fn begin(
        path: &Path,
        agent: usize,
        read: impl FnOnce(RecordReader, Arc<I>) + Send + 'static,
    ) -> Option<EarlyReading<I>> {
        let stamp = open::stamp(path);
        let working = RecordReader::of_unchecked(path, agent)?;
        let reader = working.of_agent(agent).ok()?;
        let interrupt = Some(working.connection.get_interrupt_handle());
        let indexes: Arc<I> = Arc::default();
        let filled = Arc::clone(&indexes);
        thread::Builder::new().name("early reading".into()).spawn(move || read(working, filled)).ok()?;
        Some(EarlyReading { reader, indexes, stamp, interrupt })
    }

    /// Hands what was read, and is still being read, to the checked reader of the same file. Returns the indexes; `None` if the file is
    /// not the one that was read.
    pub(super) fn taken_over_by(mut self, reader: &mut RecordReader) -> Option<Arc<I>> {
        if !reader.is_of_file(self.stamp) {
            return None;
        }
        self.interrupt = None;
        reader.share(&self.reader);
        Some(Arc::clone(&self.indexes))
    }
}
