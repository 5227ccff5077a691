//! Samples in order of time: logs write topics in blocks, so adjacent samples may be out of order.

use crate::Sampled;
use apex_model::time::{Duration, Time};
use std::collections::BinaryHeap;

/// A sample is held until another one arrives that is later by this duration.
const WINDOW: Duration = Duration(1_000_000_000);
/// Maximum number of samples that wait.
const WAITING_MAX: usize = 100_000;

/// Puts samples into order of time, if adjacent samples in the log are less than a second out of order.
#[derive(Debug, Default)]
pub struct Ordered {
    waiting: BinaryHeap<Waiting>,
    newest: Option<Time>,
    number: u64,
}

#[derive(Debug)]
struct Waiting {
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
        (other.sampled.at, other.number).cmp(&(self.sampled.at, self.number))
    }
}

impl Ordered {
    /// Adds a sample that was read.
    pub fn push(&mut self, sampled: Sampled) {
        self.newest = self.newest.max(Some(sampled.at));
        self.number += 1;
        self.waiting.push(Waiting { sampled, number: self.number });
    }

    /// Returns the earliest sample, once a sample has arrived that is a second later, or too many samples wait; at the end of the log
    /// without waiting.
    pub fn pop(&mut self, at_end: bool) -> Option<Sampled> {
        let first = self.waiting.peek()?;
        let over = self.newest.is_some_and(|newest| newest - first.sampled.at >= WINDOW);
        if at_end || over || self.waiting.len() > WAITING_MAX {
            self.waiting.pop().map(|each| each.sampled)
        } else {
            None
        }
    }
}
