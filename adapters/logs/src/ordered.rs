//! Samples in order of time: logs write topics in blocks, so adjacent samples may be out of order. A sample that is more
//! than a second late is passed on where it was read, whatever follows in the log.

use crate::Sampled;
use apex_model::time::{Duration, Time};
use std::collections::BinaryHeap;

/// A sample is held until another one arrives that is later by this duration.
const WINDOW: Duration = Duration(1_000_000_000);
/// Maximum number of samples that wait.
const WAITING_MAX: usize = 100_000;

/// Puts samples into order of time, if they are at most a second behind the newest one before them in the log.
#[derive(Debug, Default)]
pub struct Ordered {
    waiting: BinaryHeap<Waiting>,
    newest: Option<Time>,
    number: u64,
}

#[derive(Debug)]
struct Waiting {
    /// Its instant; for a late sample that of the newest one before it, behind which it stays.
    place: Time,
    sampled: Sampled,
    number: u64,
}

impl PartialEq for Waiting {
    fn eq(&self, other: &Waiting) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Waiting {}

impl PartialOrd for Waiting {
    fn partial_cmp(&self, other: &Waiting) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Waiting {
    /// Orders samples for the heap: the earliest is the greatest; at equal instants, the first arrival.
    fn cmp(&self, other: &Waiting) -> std::cmp::Ordering {
        (other.place, other.number).cmp(&(self.place, self.number))
    }
}

impl Ordered {
    /// Adds a sample that was read.
    pub fn push(&mut self, sampled: Sampled) {
        let newest = self.newest.map_or(sampled.at, |newest| newest.max(sampled.at));
        self.newest = Some(newest);
        self.number += 1;
        let place = if newest - sampled.at > WINDOW { newest } else { sampled.at };
        self.waiting.push(Waiting { place, sampled, number: self.number });
    }

    /// Returns the earliest sample, once a sample has arrived that is a second later, or too many samples wait; at the end of the log
    /// without waiting.
    pub fn pop(&mut self, at_end: bool) -> Option<Sampled> {
        let first = self.waiting.peek()?;
        let over = self.newest.is_some_and(|newest| newest - first.place >= WINDOW);
        if at_end || over || self.waiting.len() > WAITING_MAX {
            self.waiting.pop().map(|each| each.sampled)
        } else {
            None
        }
    }
}
