//! A store on a separate thread: SQLite, hashes and writes take an eighth of the time of a simulated flight; no decision waits for them.
//!
//! Before the flight, after its end, and from the first failed write on, rows are written on the thread that inserts them. In between
//! they are handed over in parts of whole steps, in order, and a commit waits until all of them are committed.

use super::disk_news::DiskNews;
use super::kept_rows::{get, put};
use super::signature::SigningKey;
use super::store::{RowStore, SqlValue};
use super::tables::Table;
use crate::error::RecordError;
use apex_model::time::Time;
use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{self, Receiver, Sender, SyncSender};
use std::thread::{self, JoinHandle};

/// Steps and bytes that are handed over together.
const PART_STEPS: u32 = 64;
const PART_BYTES: usize = 64 << 10;
/// Parts that may wait for the thread; then the flight waits for it.
const PARTS_MAX: usize = 4;

/// A store whose rows are written by a separate thread while the flight continues.
pub(super) struct StoreThread {
    /// The store while it is on this side.
    here: Option<Box<dyn RowStore>>,
    writer: Option<Writer>,
    /// File of the store when it was handed over.
    path: PathBuf,
    part: RowPart,
    /// Parts that were written, to be filled again.
    spare: Vec<RowPart>,
    news: VecDeque<DiskNews>,
    failed: Option<RecordError>,
}

/// The thread that has the store.
struct Writer {
    requests: SyncSender<Request>,
    reports: Receiver<WriteReport>,
    thread: JoinHandle<Option<Box<dyn RowStore>>>,
}

enum Request {
    Write(RowPart),
    Commit,
}

/// Result of a request.
struct WriteReport {
    /// The part that was written; `None` after a commit.
    part: Option<RowPart>,
    news: Vec<DiskNews>,
    result: Result<(), RecordError>,
}

/// Calls of a store in their order.
#[derive(Default)]
struct RowPart {
    calls: Vec<Call>,
    /// Cells of the rows.
    bytes: Vec<u8>,
    steps: u32,
}

enum Call {
    SetNow(Time),
    Insert {
        doing: &'static str,
        table: Table,
        /// End of its cells in the bytes.
        end: usize,
    },
    EndStep,
}

impl RowPart {
    fn is_large(&self) -> bool {
        self.steps >= PART_STEPS || self.bytes.len() >= PART_BYTES
    }

    fn insert(&mut self, doing: &'static str, table: Table, cells: &[SqlValue<'_>]) {
        cells.iter().for_each(|cell| put(&mut self.bytes, *cell));
        self.calls.push(Call::Insert { doing, table, end: self.bytes.len() });
    }

    /// Makes the calls, up to the first that fails.
    fn write(&self, store: &mut dyn RowStore) -> Result<(), RecordError> {
        let (mut begin, mut cells) = (0, Vec::new());
        for call in &self.calls {
            match call {
                Call::SetNow(now) => store.set_now(*now),
                Call::EndStep => store.end_step()?,
                Call::Insert { doing, table, end } => {
                    cells.clear();
                    get(self.bytes.get(begin..*end).unwrap_or_default(), &mut cells);
                    begin = *end;
                    store.insert(doing, *table, &cells)?;
                }
            }
        }
        Ok(())
    }

    fn clear(&mut self) {
        self.calls.clear();
        self.bytes.clear();
        self.steps = 0;
    }
}

impl StoreThread {
    pub(super) fn new(store: Box<dyn RowStore>) -> StoreThread {
        let path = store.path().to_path_buf();
        let (part, spare, news) = (RowPart::default(), Vec::new(), VecDeque::new());
        StoreThread { here: Some(store), writer: None, path, part, spare, news, failed: None }
    }

    /// Hands the store over to a thread; without a thread it stays on this side.
    fn launch(&mut self) {
        let (give, take) = mpsc::channel();
        let (requests, received) = mpsc::sync_channel(PARTS_MAX);
        let (answers, reports) = mpsc::channel();
        let work = move || take.recv().ok().map(|store| serve(store, &received, &answers));
        let Ok(thread) = thread::Builder::new().name("record rows".into()).spawn(work) else { return };
        if let Some(store) = self.here.take() {
            self.path = store.path().to_path_buf();
            give.send(store).ok();
            self.writer = Some(Writer { requests, reports, thread });
        }
    }

    /// Hands over the calls so far.
    fn hand_over(&mut self) {
        if let Some(writer) = self.writer.as_ref().filter(|_| !self.part.calls.is_empty()) {
            let part = std::mem::replace(&mut self.part, self.spare.pop().unwrap_or_default());
            // A thread that has ended is noticed when it is joined.
            writer.requests.send(Request::Write(part)).ok();
        }
    }

    fn take_in(&mut self, WriteReport { part, news, result }: WriteReport) {
        self.spare.extend(part);
        self.news.extend(news);
        self.failed = self.failed.take().or(result.err());
    }

    /// Takes the reports that have arrived. Messages about the disk end the work of the thread: what happens to the steps from here on is
    /// decided where they are made, as without a thread.
    fn hear(&mut self) -> Result<(), RecordError> {
        while let Some(report) = self.writer.as_ref().and_then(|writer| writer.reports.try_recv().ok()) {
            self.take_in(report);
        }
        if !self.news.is_empty() {
            self.recall();
        }
        self.failed.take().map_or(Ok(()), Err)
    }

    /// Lets the thread finish its work and takes the store back; returns true if there was a thread.
    fn finish(&mut self) -> thread::Result<bool> {
        self.hand_over();
        let Some(Writer { requests, reports, thread }) = self.writer.take() else { return Ok(false) };
        drop(requests);
        for report in reports {
            self.take_in(report);
        }
        self.here = thread.join()?;
        Ok(true)
    }

    /// Like [`StoreThread::finish`]; a panic of the thread continues here.
    fn recall(&mut self) -> bool {
        self.finish().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    }

    /// Does something with the store on this side.
    fn settled<T>(&mut self, act: impl FnOnce(&mut dyn RowStore) -> T) -> Option<T> {
        let continues = self.recall() && self.news.is_empty();
        let result = self.here.as_mut().map(|store| act(&mut **store));
        if continues {
            self.launch();
        }
        result
    }

    fn gone(&self, doing: &str) -> RecordError {
        let reason = "the thread that writes the record has ended".to_string();
        RecordError::Unwritable { path: self.path.clone(), doing: doing.to_string(), reason }
    }
}

/// Writes parts until no more can come; returns the store.
fn serve(
    mut store: Box<dyn RowStore>,
    requests: &Receiver<Request>,
    reports: &Sender<WriteReport>,
) -> Box<dyn RowStore> {
    for request in requests {
        let (part, result) = match request {
            Request::Commit => (None, store.commit()),
            Request::Write(mut part) => {
                let result = part.write(&mut *store);
                part.clear();
                (Some(part), result)
            }
        };
        let news = std::iter::from_fn(|| store.take_news()).collect();
        reports.send(WriteReport { part, news, result }).ok();
    }
    store
}

impl RowStore for StoreThread {
    fn insert(&mut self, doing: &'static str, table: Table, cells: &[SqlValue<'_>]) -> Result<(), RecordError> {
        match &mut self.here {
            Some(store) => store.insert(doing, table, cells),
            None if self.writer.is_none() => Err(self.gone(doing)),
            None => {
                self.part.insert(doing, table, cells);
                Ok(())
            }
        }
    }

    fn set_now(&mut self, now: Time) {
        match &mut self.here {
            Some(store) => store.set_now(now),
            None => self.part.calls.push(Call::SetNow(now)),
        }
    }

    fn end_step(&mut self) -> Result<(), RecordError> {
        if let Some(store) = &mut self.here {
            return store.end_step();
        }
        self.part.calls.push(Call::EndStep);
        self.part.steps += 1;
        if self.part.is_large() {
            self.hand_over();
            return self.hear();
        }
        Ok(())
    }

    fn commit(&mut self) -> Result<(), RecordError> {
        if let Some(store) = &mut self.here {
            return store.commit();
        }
        self.hand_over();
        let Some(writer) = &self.writer else { return Err(self.gone("committing")) };
        writer.requests.send(Request::Commit).ok();
        while let Some(report) = self.writer.as_ref().and_then(|writer| writer.reports.recv().ok()) {
            let is_commit = report.part.is_none();
            self.take_in(report);
            if is_commit {
                return self.hear();
            }
        }
        // The thread has ended: joining it says why.
        self.recall();
        Err(self.gone("committing"))
    }

    fn close(&mut self) -> Result<(), RecordError> {
        self.recall();
        let failed = self.failed.take().map_or(Ok(()), Err);
        match &mut self.here {
            Some(store) => failed.and(store.close()),
            None => Err(self.gone("closing it")),
        }
    }

    fn unstorable(&mut self, what: &str, reason: String) -> RecordError {
        self.recall();
        match &mut self.here {
            Some(store) => store.unstorable(what, reason),
            None => self.gone(what),
        }
    }

    fn path(&self) -> &Path {
        self.here.as_ref().map_or(&self.path, |store| store.path())
    }

    fn set_bytes_max(&mut self, bytes: u64) -> Result<(), RecordError> {
        self.settled(|store| store.set_bytes_max(bytes)).unwrap_or_else(|| Err(self.gone("limiting its size")))
    }

    fn sign_with(&mut self, key: SigningKey) {
        self.settled(|store| store.sign_with(key));
    }

    /// The flight begins: from here on no write ends it, and the thread begins its work.
    fn outlive_the_disk(&mut self) {
        if let Some(store) = &mut self.here {
            store.outlive_the_disk();
            self.launch();
        }
    }

    fn take_news(&mut self) -> Option<DiskNews> {
        self.news.pop_front().or_else(|| self.here.as_mut()?.take_news())
    }
}

impl Drop for StoreThread {
    /// All rows are handed over and written, also those of a record that was never finished.
    fn drop(&mut self) {
        self.finish().ok();
    }
}
