//! Conditions over logs, flight records and lines of measurements: the inputs of `apex monitor` and `apex export`, and the results of
//! `apex monitor`.

mod absences;
mod monitor;
mod source;

pub use monitor::{Destinations, LogMonitor, LogMonitorTerms, ResultTable, unwritten_table};
pub use source::{Note, SampleSink, Source, field_list};
