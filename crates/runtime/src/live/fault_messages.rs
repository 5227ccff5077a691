//! Messages about unreadable lines: the first ones, then as many as an operator can read, and the number of the others.

use super::rate_limit::RateLimit;
use crate::escaping::shortened;
use crate::limits::INPUT_MESSAGES_MAX;
use std::time::Instant;

/// Messages per second of one source, after the first ones.
const PER_SECOND: f64 = 2.0;

/// The messages about one source.
pub(super) struct FaultMessages {
    /// Prints a line.
    note: fn(&str),
    limit: RateLimit,
    began: Instant,
    hidden: u64,
}

impl FaultMessages {
    /// Returns a limiter without messages so far; `note` prints them.
    pub(super) fn new(note: fn(&str)) -> FaultMessages {
        let limit = RateLimit::with_burst(PER_SECOND, INPUT_MESSAGES_MAX as f64);
        FaultMessages { note, limit, began: Instant::now(), hidden: 0 }
    }

    /// Returns true if a message may be printed; otherwise it is counted.
    pub(super) fn admits(&mut self) -> bool {
        let admitted = self.limit.admits(self.began.elapsed());
        self.hidden += u64::from(!admitted);
        admitted
    }

    /// Prints an admitted message, preceded by the number of suppressed ones. `name` is that of the source, if it has one.
    pub(super) fn print(&mut self, name: Option<&str>, fault: &str) {
        self.print_hidden(name);
        let of = name.map(|name| format!("source {name}: ")).unwrap_or_default();
        (self.note)(&format!("  {of}{}", shortened(fault)));
    }

    /// Prints the number of messages suppressed since the last one.
    pub(super) fn print_hidden(&mut self, name: Option<&str>) {
        let hidden = std::mem::take(&mut self.hidden);
        if hidden > 0 {
            let name = name.unwrap_or("without a name");
            (self.note)(&format!("  source {name}: {hidden} more lines were not understood"));
        }
    }
}
