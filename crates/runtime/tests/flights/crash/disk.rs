//! A disk that loses unsynchronised writes: the files of a folder as they may be after a program is killed, or the power is cut, in the
//! middle of its writes (`writes.c` logs them).

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::Rng;
use std::collections::BTreeMap;
use std::path::Path;

/// Size of a sector, which a disk writes whole or not at all.
const SECTOR_BYTES: usize = 512;

/// One operation of the program.
#[derive(Clone, Debug)]
pub(crate) enum Operation {
    Create,
    Write { offset: usize, data: Vec<u8> },
    Truncate(usize),
    Sync,
    SyncFolder,
    Unlink,
}

/// Returns the operations in order, each with the name of its file.
pub(crate) fn read_log(bytes: &[u8]) -> Vec<(String, Operation)> {
    let mut operations = Vec::new();
    let mut rest = bytes;
    let number = |bytes: &[u8]| usize::try_from(u64::from_le_bytes(bytes.try_into().unwrap())).unwrap();
    while let [kind, length, ..] = rest {
        let (name, after) = rest[2..].split_at(usize::from(*length));
        let (offset, size) = (number(&after[..8]), number(&after[8..16]));
        let data = &after[16..16 + size];
        let operation = match kind {
            b'c' => Operation::Create,
            b'w' => Operation::Write { offset, data: data.to_vec() },
            b't' => Operation::Truncate(offset),
            b's' => Operation::Sync,
            b'd' => Operation::SyncFolder,
            b'u' => Operation::Unlink,
            other => panic!("unknown operation {other}"),
        };
        operations.push((String::from_utf8(name.to_vec()).unwrap(), operation));
        rest = &after[16 + size..];
    }
    operations
}

/// Files of the folder, by name.
#[derive(Clone, Default)]
pub(crate) struct Files(BTreeMap<String, Vec<u8>>);

impl Files {
    /// Does the operation.
    pub(crate) fn apply(&mut self, name: &str, operation: &Operation) {
        match operation {
            Operation::Create => drop(self.0.insert(name.to_string(), Vec::new())),
            Operation::Write { offset, data } => write(self.0.entry(name.to_string()).or_default(), *offset, data),
            Operation::Truncate(length) => self.0.entry(name.to_string()).or_default().resize(*length, 0),
            Operation::Sync | Operation::SyncFolder => {}
            Operation::Unlink => drop(self.0.remove(name)),
        }
    }

    /// Writes all files into an empty folder.
    pub(crate) fn put(&self, folder: &Path) {
        for entry in std::fs::read_dir(folder).unwrap() {
            std::fs::remove_file(entry.unwrap().path()).unwrap();
        }
        for (name, bytes) in &self.0 {
            std::fs::write(folder.join(name), bytes).unwrap();
        }
    }
}

fn write(file: &mut Vec<u8>, offset: usize, data: &[u8]) {
    let end = offset + data.len();
    if file.len() < end {
        file.resize(end, 0);
    }
    file[offset..end].copy_from_slice(data);
}

/// Files that are safe on the disk, and operations since that are not.
#[derive(Clone, Default)]
pub(crate) struct Disk {
    safe: Files,
    /// In order.
    waiting: Vec<(String, Operation)>,
}

impl Disk {
    /// Performs a logged operation; a sync makes the waiting writes of its file permanent.
    pub(crate) fn apply(&mut self, name: &str, operation: &Operation) {
        let is_safe_now = |waiting: &str, other: &Operation| match operation {
            // A synced file is found again: its name is safe, too.
            Operation::Sync => waiting == name,
            Operation::SyncFolder => matches!(other, Operation::Create | Operation::Unlink),
            _ => false,
        };
        let waiting = std::mem::take(&mut self.waiting);
        for (of, other) in waiting {
            if is_safe_now(&of, &other) {
                self.safe.apply(&of, &other);
            } else {
                self.waiting.push((of, other));
            }
        }
        if !matches!(operation, Operation::Sync | Operation::SyncFolder) {
            self.waiting.push((name.to_string(), operation.clone()));
        }
    }

    /// Returns the files after the power is cut now: of the waiting writes, the disk has performed a random part, in any order, sector by
    /// sector.
    pub(crate) fn cut(&self, rng: &mut ChaCha8Rng) -> Files {
        let mut files = self.safe.clone();
        // All writes, none, or each with this chance.
        let kept = [0, 255, 32, 128, 224][(rng.next_u32() % 5) as usize];
        let chance = |rng: &mut ChaCha8Rng| kept == 255 || (rng.next_u32() & 0xff) < kept;
        for (name, operation) in &self.waiting {
            if !files.0.contains_key(name) && !matches!(operation, Operation::Create) {
                // The creation of the file is lost, and so is its content.
                continue;
            }
            let Operation::Write { offset, data } = operation else {
                if chance(rng) {
                    files.apply(name, operation);
                }
                continue;
            };
            let mut from = 0;
            while from < data.len() {
                let to = data.len().min(((offset + from) / SECTOR_BYTES + 1) * SECTOR_BYTES - offset);
                if chance(rng) {
                    files.apply(name, &Operation::Write { offset: offset + from, data: data[from..to].to_vec() });
                }
                from = to;
            }
        }
        files
    }
}
