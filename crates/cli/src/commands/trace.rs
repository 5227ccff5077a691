//! `apex trace`: prints the filtered events and decisions of a flight.

use crate::error::{CliError, CliResult};
use crate::options::TraceOptions;
use crate::{output, recording, sources};
use apex_model::time::Time;
use apex_runtime::trace::{TraceFilter, TraceFormat, trace_record};
use std::cell::Cell;
use std::io::{self, Write};
use std::rc::Rc;

/// Prints the lines of a record that the filters admit.
pub fn run(options: &TraceOptions) -> CliResult {
    let reader = recording::open(&options.record)?;
    let time =
        |text: &Option<String>, option: &str| text.as_deref().map(|text| sources::parse_time(text, option)).transpose();
    let filter = TraceFilter {
        kinds: options.kinds.iter().cloned().collect(),
        agent: options.agent.clone(),
        object: options.object.clone(),
        from: time(&options.from, "--from")?,
        to: time(&options.to, "--to")?,
        place: options.procedure.clone(),
    };
    filter.check().map_err(CliError::user)?;
    if let Some(agent) = &options.agent {
        reader.agent_called(agent).map_err(|error| CliError::user(error.to_string()))?;
    }
    if filter.from.unwrap_or(Time::ZERO) > filter.to.unwrap_or(Time::END) {
        return Err(CliError::user("`--from` is later than `--to`").help("exchange them"));
    }
    let filtered = filter != TraceFilter::default();
    let format = if options.json { TraceFormat::JsonLines } else { TraceFormat::Text };
    let out = output::Listened::standard();
    let gone = out.gone();
    let written = Rc::new(Cell::new(false));
    let traced = trace_record(&reader, Noticed { out, written: Rc::clone(&written) }, format, filter);
    match traced {
        // A reader such as `head` has closed the output.
        _ if gone.get() => Ok(()),
        Err(error) => Err(CliError::failure(error.to_string())),
        Ok(_) => {
            if filtered && !written.get() {
                output::print_error("note: nothing in this record matches");
            }
            Ok(())
        }
    }
}

/// A writer that records whether anything was written.
struct Noticed {
    out: output::Listened,
    written: Rc<Cell<bool>>,
}

impl Write for Noticed {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.written.set(true);
        self.out.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}
