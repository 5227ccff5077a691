//! `apex run`: any PDL program without a vehicle, in simulated time, by the clock on the wall or at that of an outside
//! simulator, with a trace.

use crate::console::{self, Asker, OpenQuestions};
use crate::options::RunOptions;
use crate::output::Listened;
use crate::trouble::{Outcome, Trouble, read_text};
use crate::{output, outside, recording, sources};
use apex_mission::scenario;
use apex_model::library::Library;
use apex_model::time::Time;
use apex_runtime::answer_lines::read_answers;
use apex_runtime::ports::{Input, Observer};
use apex_runtime::record::{RecordOptions, Recorder};
use apex_runtime::terms::Lateness;
use apex_runtime::trace::{TraceFilter, TraceFormat, Tracer};
use apex_runtime::{EndReason, FlyOptions, RunEnd, ScriptedAnswer, program};
use std::io::Read;
use std::path::Path;

/// Runs a program to its end.
pub fn run(options: &RunOptions) -> Outcome {
    let library = sources::load_program(&options.program)?;
    let way = Way::of(&library, options)?;
    let inputs = options.inputs.as_deref().map(inputs_of).transpose()?.unwrap_or_default();
    let answers = options.answers.as_deref().map(answers_of).transpose()?.unwrap_or_default();
    let until = options.until.as_deref().map(|text| sources::parse_time(text, "--until")).transpose()?;
    let terms = || FlyOptions {
        until: until.unwrap_or(Time::END),
        inputs: inputs.clone(),
        answers: answers.clone(),
        ..FlyOptions::default()
    };
    refuse_to_overwrite_inputs(options)?;
    let mut recorder = options.record.as_deref().map(|path| recorder(path, &library)).transpose()?;
    let out = trace_output(options.trace.as_deref(), way.owns_output(options))?;
    let gone = out.gone();
    let format = if options.text { TraceFormat::Text } else { TraceFormat::JsonLines };
    let mut tracer = Tracer::new(out, format, TraceFilter::default(), &library);
    let open = OpenQuestions::default();
    let mut asker = Asker::new(open.clone(), library.crew().into_iter().map(|agent| agent.name).collect());

    let mut observers: Vec<&mut dyn Observer> = Vec::new();
    if let Some(recorder) = &mut recorder {
        observers.push(recorder);
    }
    observers.push(&mut tracer);
    let ended = match way {
        Way::Simulated => program::run_all(&mut sources::crew_of(&library)?, &mut observers, terms()),
        Way::Live(pace) => {
            let stdin = options.inputs.as_deref().is_none_or(|path| path.as_os_str() != "-");
            let controls = Some(console::listen(&open, stdin, options.listen)?);
            observers.push(&mut asker);
            let terms = FlyOptions { pace: Some(pace), controls, ..terms() };
            program::run_all(&mut sources::crew_of(&library)?, &mut observers, terms)
        }
        Way::Foreign => {
            let recorded = options.record.is_some();
            Ok(outside::run(&library, options.listen, recorded, &mut observers, &terms)?)
        }
    };
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
    tell_end(&end);
    match recorder {
        Some(mut recorder) => recorder.finish(end.at, &end.reason.text()).map_err(recording::written),
        None => Ok(()),
    }
}

fn tell_end(end: &RunEnd) {
    if !matches!(end.reason, EndReason::Application(_)) {
        output::complain(format_args!("note: the run ended at {} because {}", end.at, end.reason.text()));
    }
    if end.late.steps > 0 {
        let Lateness { steps, worst } = end.late;
        let of = end.steps;
        output::complain(format_args!(
            "note: {steps} of {of} steps came late, the worst by {} ms: the computer does not keep up",
            worst.as_millis()
        ));
    }
}

/// Whose clock counts.
enum Way {
    /// Simulated time, as fast as possible.
    Simulated,
    /// The clock on the wall, at this pace.
    Live(f64),
    /// The clock of an outside simulator.
    Foreign,
}

impl Way {
    fn of(library: &Library, options: &RunOptions) -> Outcome<Way> {
        let kind = library.application.as_ref().map(|application| application.kind.clone());
        let is = |name: &str| kind.as_ref().is_some_and(|kind| kind.is(name));
        let paced = options.pace.map(crate::commands::fly::checked_pace).transpose()?;
        if is("foreign-sim") {
            let stray = if options.interactive { Some("--interactive") } else { options.pace.map(|_| "--pace") };
            return match stray {
                None => Ok(Way::Foreign),
                Some(option) => Err(Trouble::user(format!("`{option}` has no meaning for this application"))
                    .because("it is of type foreign-sim: an outside simulator owns the clock")
                    .help("leave the option out")),
            };
        }
        let live = is("realtime") || options.interactive || options.listen.is_some() || paced.is_some();
        Ok(if live { Way::Live(paced.unwrap_or(1.0)) } else { Way::Simulated })
    }

    /// True when standard output belongs to the simulator.
    fn owns_output(&self, options: &RunOptions) -> bool {
        matches!(self, Way::Foreign) && options.listen.is_none()
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
    if path.as_os_str() != "-" {
        return Ok(scenario::read(path)?);
    }
    let mut text = String::new();
    std::io::stdin()
        .read_to_string(&mut text)
        .map_err(|error| Trouble::user("cannot read standard input").because(error))?;
    Ok(scenario::parse("<standard input>", &text)?)
}

/// Reads what the operator answers.
fn answers_of(path: &Path) -> Outcome<Vec<ScriptedAnswer>> {
    let read_value = |text: &str| apex_pdl::read_value(text).map_err(|diagnostic| diagnostic.message);
    read_answers(&path.display().to_string(), &read_text(path)?, &read_value).map_err(|errors| {
        Trouble::user(errors.to_string())
            .help("each line is {\"question\": \"WORDS OF THE QUESTION\", \"value\": VALUE, \"after\": SECONDS}")
    })
}

/// Where the trace goes. What belongs to a simulator is not written into.
fn trace_output(path: Option<&Path>, output_is_taken: bool) -> Outcome<Listened> {
    match path {
        Some(path) if path.as_os_str() != "-" => match std::fs::File::create(path) {
            Ok(file) => Ok(Listened::new(Box::new(file))),
            Err(error) => Err(Trouble::user(format!("cannot write the trace to {}", path.display()))
                .because(error)
                .help("choose another place with `--trace`, or leave it out to see the trace here")),
        },
        Some(_) if output_is_taken => Err(Trouble::user("`--trace -` would write between the lines to the simulator")
            .help("give `--trace` a file, or connect the simulator with `--listen`")),
        None if output_is_taken => Ok(Listened::new(Box::new(std::io::sink()))),
        _ => Ok(Listened::standard()),
    }
}
