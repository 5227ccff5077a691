//! `apex run`: any PDL program without a vehicle, with scripted inputs and a trace.

use crate::options::RunOptions;
use crate::output::Listened;
use crate::trouble::{Outcome, Trouble, read_text};
use crate::{output, recording, sources};
use apex_model::library::Library;
use apex_model::time::Time;
use apex_runtime::input_lines::read_inputs;
use apex_runtime::ports::{Input, Observer};
use apex_runtime::record::{RecordOptions, Recorder};
use apex_runtime::trace::{TraceFilter, TraceFormat, Tracer};
use apex_runtime::{EndReason, FlyOptions, program};
use std::io::Read;
use std::path::Path;

/// Runs a program to its end.
pub fn run(options: &RunOptions) -> Outcome {
    let library = sources::load_program(&options.program)?;
    let inputs = options.inputs.as_deref().map(inputs_of).transpose()?.unwrap_or_default();
    let until = options.until.as_deref().map(|text| sources::parse_time(text, "--until")).transpose()?;
    let fly_options = FlyOptions { until: until.unwrap_or(Time::END), inputs, ..FlyOptions::default() };
    let mut agents = sources::crew_of(&library)?;
    refuse_to_overwrite_inputs(options)?;
    let mut recorder = options.record.as_deref().map(|path| recorder(path, &library)).transpose()?;
    let out = trace_output(options.trace.as_deref())?;
    let gone = out.gone();
    let format = if options.text { TraceFormat::Text } else { TraceFormat::JsonLines };
    let mut tracer = Tracer::new(out, format, TraceFilter::default(), &library);

    let mut observers: Vec<&mut dyn Observer> = Vec::new();
    if let Some(recorder) = &mut recorder {
        observers.push(recorder);
    }
    observers.push(&mut tracer);
    let ended = program::run_all(&mut agents, &mut observers, fly_options);
    let flushed = tracer.into_inner();
    // A reader such as `head` that has seen enough ends the run; a record then says that it is incomplete.
    if gone.get() {
        return Ok(());
    }
    let end = ended.map_err(|error| Trouble::failure(error.to_string()))?;
    flushed.map_err(|error| {
        Trouble::failure("cannot write the trace")
            .because(error)
            .help("the trace is incomplete; look at where it goes, and at the space there")
    })?;
    if !matches!(end.reason, EndReason::Application(_)) {
        output::complain(format_args!("note: the run ended at {} because {}", end.at, end.reason.text()));
    }
    match recorder {
        Some(mut recorder) => recorder.finish(end.at, &end.reason.text()).map_err(recording::written),
        None => Ok(()),
    }
}

/// A trace or record written over what is being run would be lost work.
fn refuse_to_overwrite_inputs(options: &RunOptions) -> Outcome {
    let real = |path: &Path| std::fs::canonicalize(path).ok();
    let program = real(&sources::program_path(&options.program));
    let inputs = options.inputs.as_deref().and_then(real);
    let trace = options.trace.as_deref().and_then(real);
    let Some(trace) = trace else { return Ok(()) };
    let record = options.record.as_deref().and_then(real);
    let what = match Some(&trace) {
        same if same == program.as_ref() => "the program",
        same if same == inputs.as_ref() => "the file of inputs",
        same if same == record.as_ref() => "the flight record",
        _ => return Ok(()),
    };
    Err(Trouble::user(format!("the trace would be written over {what}, {}", trace.display()))
        .help("give `--trace` another file"))
}

/// A record with the program's sources inside.
fn recorder(path: &Path, library: &Library) -> Outcome<Recorder> {
    recording::create(path, library, RecordOptions::default(), |recorder| {
        recorder.meta("agent", sources::agent_of(library).name.printed())
    })
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

fn trace_output(path: Option<&Path>) -> Outcome<Listened> {
    match path {
        Some(path) if path.as_os_str() != "-" => match std::fs::File::create(path) {
            Ok(file) => Ok(Listened::new(Box::new(file))),
            Err(error) => Err(Trouble::user(format!("cannot write the trace to {}", path.display()))
                .because(error)
                .help("choose another place with `--trace`, or leave it out to see the trace here")),
        },
        _ => Ok(Listened::standard()),
    }
}
