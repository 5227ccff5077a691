//! Bytes of a log with their offset, read forward; the buffer holds as much as one message needs.

use std::io::{self, Read};

/// Number of bytes per read.
const BLOCK: usize = 1 << 16;

/// A window over the bytes that are read next.
pub(crate) struct Bytes<R> {
    input: R,
    buffer: Vec<u8>,
    start: usize,
    /// Offset of the window in the log.
    pub(crate) offset: u64,
    ended: bool,
}

impl<R: Read> Bytes<R> {
    pub(crate) fn new(input: R) -> Bytes<R> {
        Bytes { input, buffer: Vec::new(), start: 0, offset: 0, ended: false }
    }

    /// Returns the next `length` bytes without consuming them; fewer where the log ends.
    pub(crate) fn peek(&mut self, length: usize) -> io::Result<&[u8]> {
        while self.buffer.len() - self.start < length && !self.ended {
            if self.start > 0 {
                self.buffer.drain(..self.start);
                self.start = 0;
            }
            let filled = self.buffer.len();
            self.buffer.resize(filled + BLOCK, 0);
            let slot = self.buffer.get_mut(filled..).unwrap_or_default();
            let read = loop {
                match self.input.read(slot) {
                    Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                    other => break other,
                }
            };
            let read = read.inspect_err(|_| self.buffer.truncate(filled))?;
            self.buffer.truncate(filled + read);
            self.ended = read == 0;
        }
        let end = self.buffer.len().min(self.start.saturating_add(length));
        Ok(self.buffer.get(self.start..end).unwrap_or_default())
    }

    /// Skips `length` bytes of the window.
    pub(crate) fn skip(&mut self, length: usize) {
        let length = length.min(self.buffer.len() - self.start);
        self.start += length;
        self.offset += length as u64;
    }

    /// Returns the next line without its end; `None` at the end of the log. A line that is too long is cut.
    pub(crate) fn line(&mut self, longest: usize) -> io::Result<Option<Vec<u8>>> {
        let mut seen = BLOCK;
        loop {
            let window = self.peek(seen)?;
            if window.is_empty() {
                return Ok(None);
            }
            let end = window.iter().position(|byte| *byte == b'\n');
            let whole = window.len() < seen || window.len() >= longest;
            if let Some(end) = end.or(whole.then_some(window.len())) {
                let line = window.get(..end).unwrap_or_default().strip_suffix(b"\r");
                let line = line.or(window.get(..end)).unwrap_or_default().to_vec();
                self.skip(end + 1);
                return Ok(Some(line));
            }
            seen = seen.saturating_mul(2);
        }
    }
}

/// Returns the `N` bytes of a slice that begin at `at`; `None` if the slice ends before.
pub(crate) fn array<const N: usize>(bytes: &[u8], at: usize) -> Option<[u8; N]> {
    bytes.get(at..at.checked_add(N)?)?.try_into().ok()
}

pub(crate) fn u16_at(bytes: &[u8], at: usize) -> Option<u16> {
    array(bytes, at).map(u16::from_le_bytes)
}

pub(crate) fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    array(bytes, at).map(u32::from_le_bytes)
}

pub(crate) fn u64_at(bytes: &[u8], at: usize) -> Option<u64> {
    array(bytes, at).map(u64::from_le_bytes)
}

/// Returns text up to the first zero byte.
pub(crate) fn text(bytes: &[u8]) -> String {
    let end = bytes.iter().position(|byte| *byte == 0).unwrap_or(bytes.len());
    String::from_utf8_lossy(bytes.get(..end).unwrap_or_default()).trim_end().to_string()
}
