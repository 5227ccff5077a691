//! Messages about lines that cannot be understood: the first ones, then as many as an operator can read, and the number of the rest.

use crate::output;
use apex_runtime::limits::INPUT_MESSAGES_MAX;
use apex_runtime::live::RateLimit;
use std::time::Instant;

/// Messages per second of one source, after the first ones.
const PER_SECOND: f64 = 2.0;

/// The messages about one source.
pub(super) struct Complaints {
    limit: RateLimit,
    began: Instant,
    hidden: u64,
}

impl Complaints {
    /// Returns a limiter without messages.
    pub(super) fn new() -> Complaints {
        let limit = RateLimit::with_burst(PER_SECOND, INPUT_MESSAGES_MAX as f64);
        Complaints { limit, began: Instant::now(), hidden: 0 }
    }

    /// Returns true if a message may be printed; otherwise it is counted.
    pub(super) fn admits(&mut self) -> bool {
        let admitted = self.limit.admits(self.began.elapsed());
        self.hidden += u64::from(!admitted);
        admitted
    }

    /// Prints a message that was admitted, after the number of those that were not. `name` is that of the source, if it has one.
    pub(super) fn print(&mut self, name: Option<&str>, fault: &str) {
        self.print_hidden(name);
        let of = name.map(|name| format!("source {name}: ")).unwrap_or_default();
        output::print_error(format_args!("  {of}{fault}"));
    }

    /// Prints how many messages were not shown since the last one.
    pub(super) fn print_hidden(&mut self, name: Option<&str>) {
        let hidden = std::mem::take(&mut self.hidden);
        if hidden > 0 {
            let name = name.unwrap_or("without a name");
            output::print_error(format_args!("  source {name}: {hidden} more lines were not understood"));
        }
    }
}
