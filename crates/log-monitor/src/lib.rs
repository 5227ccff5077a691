//! Conditions over logs, flight records and lines of measurements: what `apex monitor` and `apex export` read, and what
//! `apex monitor` finds.

mod absences;
mod monitor;
mod source;

pub use monitor::{Destinations, LogMonitor, LogMonitorTerms, ResultTable, unwritten_table};
pub use source::{Note, SampleSink, Source, field_list};
