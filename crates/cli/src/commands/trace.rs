//! `apex trace`: what happened in a flight, filtered.

use crate::options::TraceOptions;
use crate::trouble::{Outcome, Trouble};
use crate::{commands, sources};
use apex_runtime::trace::{TraceFilter, TraceFormat, trace_record};
use std::io::{BufWriter, Write};

/// Prints the lines of a record that the filters admit.
pub fn run(options: &TraceOptions) -> Outcome {
    let reader = commands::replay::open(&options.record)?;
    let time =
        |text: &Option<String>, option: &str| text.as_deref().map(|text| sources::parse_time(text, option)).transpose();
    let filter = TraceFilter {
        kinds: options.kinds.iter().cloned().collect(),
        object: options.object.clone(),
        from: time(&options.from, "--from")?,
        to: time(&options.to, "--to")?,
        place: options.procedure.clone(),
    };
    filter.check().map_err(Trouble::user)?;
    let format = if options.json { TraceFormat::JsonLines } else { TraceFormat::Text };
    let out = BufWriter::new(std::io::stdout().lock());
    match trace_record(&reader, out, format, filter) {
        Ok(mut out) => {
            // Whoever reads our output may have closed it; there is nobody left to tell.
            out.flush().ok();
            Ok(())
        }
        Err(error) => Err(Trouble::failure(error.to_string())),
    }
}
