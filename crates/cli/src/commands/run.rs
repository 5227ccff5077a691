//! `apex run`: any PDL program without a vehicle, with scripted inputs and a trace.

use crate::options::RunOptions;
use crate::sources;
use crate::trouble::{Outcome, Trouble, read_text};
use apex_model::library::Library;
use apex_model::time::Time;
use apex_runtime::input_lines::read_inputs;
use apex_runtime::ports::{Input, Observer};
use apex_runtime::record::{RecordOptions, Recorder};
use apex_runtime::trace::{TraceFilter, TraceFormat, Tracer};
use apex_runtime::{FlyOptions, RunEnd, program};
use std::io::{BufWriter, Read, Write};
use std::path::Path;
use std::sync::Arc;

/// Runs a program to its end.
pub fn run(options: &RunOptions) -> Outcome {
    let library = sources::load_program(&options.program)?;
    let inputs = options.inputs.as_deref().map(inputs_of).transpose()?.unwrap_or_default();
    let until = options.until.as_deref().map(|text| sources::parse_time(text, "--until")).transpose()?;
    let out = trace_output(options.trace.as_deref())?;
    let format = if options.text { TraceFormat::Text } else { TraceFormat::JsonLines };
    let mut tracer = Tracer::new(out, format, TraceFilter::default(), &library);
    let fly_options = FlyOptions { until: until.unwrap_or(Time::END), inputs, ..FlyOptions::default() };
    let declaration = sources::agent_of(&library);
    let mut agent = apex_executive::load(Arc::clone(&library), &declaration, sources::host_functions())
        .map_err(|reason| Trouble::user("the program cannot be executed").because(reason))?;

    let mut recorder = options.record.as_deref().map(|path| recorder(path, &library)).transpose()?;
    let mut observers: Vec<&mut dyn Observer> = Vec::new();
    if let Some(recorder) = &mut recorder {
        observers.push(recorder);
    }
    observers.push(&mut tracer);
    let end =
        program::run(&mut agent, &mut observers, fly_options).map_err(|error| Trouble::failure(error.to_string()))?;
    finish(tracer, recorder, &end)
}

fn finish(tracer: Tracer<Box<dyn Write>>, recorder: Option<Recorder>, end: &RunEnd) -> Outcome {
    let flushed = tracer.into_inner().and_then(|mut out| out.flush());
    match flushed {
        // A reader such as `head` that has seen enough is no failure.
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => {}
        Err(error) => return Err(Trouble::failure("cannot write the trace").because(error)),
        Ok(()) => {}
    }
    match recorder {
        Some(mut recorder) => {
            recorder.finish(end.at, &end.reason.text()).map_err(|error| Trouble::failure(error.to_string()))
        }
        None => Ok(()),
    }
}

/// A record with the program's sources inside.
fn recorder(path: &Path, library: &Library) -> Outcome<Recorder> {
    let failed = |error: apex_runtime::RecordError| Trouble::failure(error.to_string());
    let mut recorder = Recorder::create(path, library, RecordOptions::default()).map_err(failed)?;
    recorder.program(library).map_err(failed)?;
    recorder.meta("agent", sources::agent_of(library).name.printed()).map_err(failed)?;
    Ok(recorder)
}

/// Reads scripted inputs from a file, or from standard input for `-`.
pub fn inputs_of(path: &Path) -> Outcome<Vec<Input>> {
    let (name, text) = if path.as_os_str() == "-" {
        let mut text = String::new();
        std::io::stdin()
            .read_to_string(&mut text)
            .map_err(|error| Trouble::user("cannot read standard input").because(error))?;
        ("<standard input>".to_string(), text)
    } else {
        (path.display().to_string(), read_text(path)?)
    };
    let read_value = |text: &str| apex_pdl::read_value(text).map_err(|diagnostic| diagnostic.message);
    read_inputs(&name, &text, &read_value).map_err(|errors| {
        Trouble::user(errors.to_string())
            .help("each line is {\"t\": SECONDS, \"event\": \"(FORM)\"} or {\"t\": SECONDS, \"measurement\": \"(ATTRIBUTE OBJECT)\", \"value\": VALUE}")
    })
}

fn trace_output(path: Option<&Path>) -> Outcome<Box<dyn Write>> {
    match path {
        Some(path) if path.as_os_str() != "-" => match std::fs::File::create(path) {
            Ok(file) => Ok(Box::new(BufWriter::new(file))),
            Err(error) => Err(Trouble::failure(format!("cannot write the trace to {}", path.display())).because(error)),
        },
        _ => Ok(Box::new(BufWriter::new(std::io::stdout()))),
    }
}
