//! `apex run`: runs any PDL program without a vehicle, in simulated time, by the wall clock or by the clock of an external simulator, with
//! a trace.

use crate::console;
use crate::error::{CliError, CliResult, read_text};
use crate::options::RunOptions;
use crate::output::Listened;
use crate::recording::RecordingWatch;
use crate::{external_simulator, output, recording, sources};
use apex_mission::Mission;
use apex_mission::deliberation::PlanningResources;
use apex_mission::flight::{FlightOutcome, MissionFlight};
use apex_mission::report::Report;
use apex_mission::scenario::ScriptedInputs;
use apex_model::library::{Application, Library};
use apex_model::time::Time;
use apex_planning::Registry;
use apex_runtime::answer_lines::read_answers;
use apex_runtime::asker::Asker;
use apex_runtime::foreign::{self, ForeignEnd};
use apex_runtime::input_stream::InputStream;
use apex_runtime::live_lines::OpenQuestions;
use apex_runtime::ports::{Input, Observer};
use apex_runtime::program::{NoDeliberator, NoVehicle};
use apex_runtime::record::{RecordOptions, Recorder};
use apex_runtime::run_settings::Lateness;
use apex_runtime::trace::{TraceFilter, TraceFormat, Tracer};
use apex_runtime::{EndReason, RunEnd, RunSettings, ScriptedAnswer, program};
use std::cell::Cell;
use std::path::Path;
use std::sync::Arc;

/// Runs a program to its end. A mission that uses the wall clock or the clock of an external simulator is flown: it plans, records its
/// visits, and reports.
pub fn run(options: &RunOptions, planners: &Arc<Registry>) -> CliResult {
    let library = sources::load_program(&options.program)?;
    let clock = ClockSource::of(&library, options)?;
    let (inputs, stream) = inputs_of(options, &clock)?;
    let answers = options.answers.as_deref().map(answers_of).transpose()?.unwrap_or_default();
    let until = options.until.as_deref().map(|text| sources::parse_time(text, "--until")).transpose()?;
    let mission = live_mission(&library, options, planners)?;
    let terms = || {
        let mut terms = match &mission {
            Some(mission) => MissionFlight::terms(mission, until),
            None => RunSettings { until: until.unwrap_or(Time::END), ..RunSettings::default() },
        };
        terms.inputs.extend(inputs.iter().cloned());
        RunSettings { answers: answers.clone(), stream: stream.take(), ..terms }
    };
    refuse_to_overwrite_inputs(options)?;
    let mut recorder = signed_recorder(options, &library, mission.as_deref())?;
    let out = trace_output(options.trace.as_deref(), clock.owns_output(options))?;
    let gone = out.gone();
    let format = if options.text { TraceFormat::Text } else { TraceFormat::JsonLines };
    let mut tracer = Tracer::new(out, format, TraceFilter::default(), &library);
    let open = OpenQuestions::default();
    let mut asker = Asker::new(open.clone(), library.crew().into_iter().map(|agent| agent.name).collect(), |line| {
        output::print_error(format_args!("{line}"))
    });

    // The recorder comes first, so that every input is stored before it is used.
    let is_recorded = recorder.is_some();
    let mut observers: Vec<&mut dyn Observer> = recorder.iter_mut().map(|recorder| recorder as _).collect();
    let mut recording = RecordingWatch;
    observers.push(&mut recording);
    observers.push(&mut tracer);
    let (live, controls) = match clock {
        ClockSource::Wall(_) => {
            let stdin = options.inputs.as_deref().is_none_or(|path| path.as_os_str() != "-");
            observers.push(&mut asker);
            let (live, controls) = console::listen(&open, stdin, options.listen)?;
            (Some(live), Some(controls))
        }
        ClockSource::Simulated | ClockSource::Simulator => (None, None),
    };
    let flight = mission.clone().map(|mission| MissionFlight::new(mission, PlanningResources::of(planners)));
    let run = Run { library: &library, flight, is_recorded, terms: &terms };
    let ended = match clock {
        ClockSource::Simulated => run.with_inputs(&mut observers, terms()),
        ClockSource::Wall(pace) => {
            run.tell_who_acknowledges();
            run.with_inputs(&mut observers, RunSettings { pace: Some(pace), live, controls, ..terms() })
        }
        ClockSource::Simulator => run.with_simulator(&mut observers, options.listen),
    };
    let flushed = tracer.into_inner();
    // A reader such as `head` that closes the output ends the run; a record then states that it is incomplete.
    if gone.get() {
        return Ok(());
    }
    let (end, report) = ended?;
    flushed.map_err(|error| {
        CliError::failure("cannot write the trace")
            .because(error)
            .help("the trace is incomplete; check its destination and the free space there")
    })?;
    tell_end(&end);
    let unexpected = options.expect.is_some() && !end.reason.is_success();
    let message = format!("expected the run to succeed, but it ended because {}", end.reason.text());
    finish(end, report, recorder)?;
    if unexpected { Err(CliError::failure(message)) } else { Ok(()) }
}

/// Returns the scripted inputs in memory, and those of a long file, which are read when they are needed.
fn inputs_of(options: &RunOptions, clock: &ClockSource) -> CliResult<(Vec<Input>, Cell<Option<InputStream>>)> {
    let Some(path) = options.inputs.as_deref() else { return Ok((Vec::new(), Cell::new(None))) };
    if let ClockSource::Simulator = clock {
        // A simulator may reset the run; the next episode needs all inputs again.
        return Ok((sources::held_inputs_of(path)?, Cell::new(None)));
    }
    Ok(match sources::inputs_of(path)? {
        ScriptedInputs::Held(inputs) => (inputs, Cell::new(None)),
        ScriptedInputs::Streamed(stream) => (Vec::new(), Cell::new(Some(*stream))),
    })
}

/// Returns the mission of an application that names a vehicle and does not run in simulated time.
fn live_mission(library: &Arc<Library>, options: &RunOptions, planners: &Registry) -> CliResult<Option<Arc<Mission>>> {
    let is_live = |application: &Application| {
        (application.kind.is("realtime") || application.kind.is("foreign-sim"))
            && application.option("vehicle").is_some()
    };
    if !library.application.as_ref().is_some_and(is_live) {
        if library.application.as_ref().is_some_and(|application| application.option("diagnosis").is_some()) {
            return Err(CliError::user("`:diagnosis` has no effect in this run")
                .because(
                    "tests of a model are diagnosed in the flight of a mission, and this program is run without one",
                )
                .help("fly it with `apex fly`, or give it a `:vehicle` and the type realtime or foreign-sim"));
        }
        return Ok(None);
    }
    let mission = Mission::of_program(&options.program, Arc::clone(library))?;
    sources::check_names_of(&mission, planners)?;
    Ok(Some(Arc::new(mission)))
}

/// Prints the report of a flight, and closes the record.
fn finish(end: RunEnd, report: Option<Report>, recorder: Option<Recorder>) -> CliResult {
    if let Some(report) = &report {
        // Standard output belongs to the trace, or to the simulator.
        output::print_error(report.text().trim());
    }
    let Some(mut recorder) = recorder else { return Ok(()) };
    match report {
        Some(report) => FlightOutcome { end, report, planned_for: std::time::Duration::ZERO }.store(&mut recorder),
        None => recorder.finish(end.at, &end.reason.text()),
    }
    .map_err(recording::written)
}

/// A program that is ready to run, with the flight of its mission.
struct Run<'a> {
    library: &'a Arc<Library>,
    /// The flight of a mission; `None` for a program without one.
    flight: Option<MissionFlight>,
    is_recorded: bool,
    terms: &'a dyn Fn() -> RunSettings,
}

/// The end of a run, with the report of a mission.
type Ended = (RunEnd, Option<Report>);

impl Run<'_> {
    /// Tells the user that no built-in vehicle acknowledges commands.
    fn tell_who_acknowledges(&self) {
        if self.flight.is_some() {
            output::print_error(
                "note: no vehicle is built in: a vehicle reads commands in the trace and acknowledges them by lines such \
                 as {\"acknowledge\": 3}; `apex fly` flies the mission with the built-in simulator",
            );
        }
    }

    fn with_inputs(&self, observers: &mut Vec<&mut dyn Observer>, terms: RunSettings) -> CliResult<Ended> {
        if let Some(flight) = &self.flight {
            let flown = flight.fly(&mut NoVehicle::silent(), terms, observers)?;
            return Ok((flown.end, Some(flown.report)));
        }
        let end = program::run_all(&mut sources::crew_of(self.library)?, observers, terms);
        Ok((end.map_err(|error| CliError::failure(error.to_string()))?, None))
    }

    fn with_simulator(&self, observers: &mut Vec<&mut dyn Observer>, port: Option<u16>) -> CliResult<Ended> {
        let mut report = None;
        let end = external_simulator::run(self.library, port, self.is_recorded, &mut |link| {
            let Some(flight) = &self.flight else {
                let mut agents = sources::crew_of(self.library)?;
                return foreign::run(&mut agents, link, &mut NoDeliberator, observers, (self.terms)())
                    .map_err(|error| CliError::failure(error.to_string()));
            };
            let mut reset = false;
            let flown = flight.run((self.terms)(), |agents, deliberator, terms| {
                let ended = foreign::run(agents, link, deliberator, observers, terms)?;
                reset = ended.reset;
                Ok(ended.end)
            })?;
            report = Some(flown.report);
            Ok(ForeignEnd { end: flown.end, reset })
        })?;
        Ok((end, report))
    }
}

/// Number of acknowledgements without a command that are named one by one.
const UNUSED_TOLD_MAX: usize = 10;

fn tell_end(end: &RunEnd) {
    if !matches!(end.reason, EndReason::Application { .. }) {
        output::print_error(format_args!("note: the run ended at {} because {}", end.at, end.reason.text()));
    }
    // A stream of inputs is unbounded; the number of notes must not be.
    for unused in end.unused.iter().take(UNUSED_TOLD_MAX) {
        output::print_error(format_args!(
            "note: an input acknowledges {unused}, but no such command was waiting for it"
        ));
    }
    if let Some(more) = end.unused.len().checked_sub(UNUSED_TOLD_MAX).filter(|more| *more > 0) {
        output::print_error(format_args!("note: {more} further acknowledgements belong to no command"));
    }
    if end.late.steps > 0 {
        let Lateness { steps, worst } = end.late;
        let of = end.steps;
        output::print_error(format_args!(
            "note: {steps} of {of} steps came late, the worst by {} ms: the computer does not keep up",
            worst.as_millis()
        ));
    }
}

/// The clock of mission time.
enum ClockSource {
    /// Simulated time, as fast as possible.
    Simulated,
    /// Wall time, at this pace.
    Wall(f64),
    /// The clock of an external simulator.
    Simulator,
}

impl ClockSource {
    fn of(library: &Library, options: &RunOptions) -> CliResult<ClockSource> {
        let kind = library.application.as_ref().map(|application| application.kind.clone());
        let is = |name: &str| kind.as_ref().is_some_and(|kind| kind.is(name));
        let paced = options.pace.map(crate::commands::fly::checked_pace).transpose()?;
        if is("foreign-sim") {
            let stray = if options.interactive { Some("--interactive") } else { options.pace.map(|_| "--pace") };
            return match stray {
                None => Ok(ClockSource::Simulator),
                Some(option) => Err(CliError::user(format!("`{option}` has no meaning for this application"))
                    .because("it is of type foreign-sim: an external simulator owns the clock")
                    .help("leave the option out")),
            };
        }
        let live = is("realtime") || options.interactive || options.listen.is_some() || paced.is_some();
        Ok(if live { ClockSource::Wall(paced.unwrap_or(1.0)) } else { ClockSource::Simulated })
    }

    /// Returns true when standard output belongs to the simulator.
    fn owns_output(&self, options: &RunOptions) -> bool {
        matches!(self, ClockSource::Simulator) && options.listen.is_none()
    }
}

/// Refuses a trace that would replace the program, the file of inputs or the flight record.
fn refuse_to_overwrite_inputs(options: &RunOptions) -> CliResult {
    let real = |path: &Path| std::fs::canonicalize(path).ok();
    let program = real(&sources::program_path(&options.program));
    let inputs = options.inputs.as_deref().and_then(real);
    if let (Some(trace), Some(record)) = (&options.trace, &options.record)
        && is_same_file(trace, record)
    {
        return Err(CliError::user(format!("the trace would overwrite the flight record, {}", trace.display()))
            .help("give `--trace` another file"));
    }
    options.trace.as_deref().map_or(Ok(()), output::refuse_record)?;
    let trace = options.trace.as_deref().and_then(real);
    let Some(trace) = trace else { return Ok(()) };
    let what = match Some(&trace) {
        same if same == program.as_ref() => "the program",
        same if same == inputs.as_ref() => "the file of inputs",
        _ => return Ok(()),
    };
    Err(CliError::user(format!("the trace would overwrite {what}, {}", trace.display()))
        .help("give `--trace` another file"))
}

/// Returns true if both paths name one file, which need not exist.
fn is_same_file(one: &Path, other: &Path) -> bool {
    let real = |path: &Path| {
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let target = std::fs::canonicalize(path).ok();
        target.or_else(|| Some(std::fs::canonicalize(folder).ok()?.join(path.file_name()?)))
    };
    real(one).is_some_and(|one| real(other) == Some(one))
}

/// Creates the record that the options name, and signs it at its end if they name a key; `None` without a record.
fn signed_recorder(options: &RunOptions, library: &Library, mission: Option<&Mission>) -> CliResult<Option<Recorder>> {
    let key = options.sign.as_deref().map(recording::signing_key).transpose()?;
    let Some(path) = options.record.as_deref() else { return Ok(None) };
    let mut recorder =
        recorder(path, library, mission, recording::options(options.power_safe, options.spare_folder.as_ref()))?;
    if let Some(key) = key {
        recorder.sign_with(key).map_err(recording::written)?;
    }
    Ok(Some(recorder))
}

/// Creates a record with the program's sources and, for a mission, all of its data.
fn recorder(path: &Path, library: &Library, mission: Option<&Mission>, options: RecordOptions) -> CliResult<Recorder> {
    if let Some(mission) = mission {
        return Ok(recording::of_mission(path, mission, options)?);
    }
    Ok(recording::create(path, library, options, |recorder| {
        recorder.meta("agent", sources::agent_of(library).name.printed())
    })?)
}

/// Reads the operator's answers.
fn answers_of(path: &Path) -> CliResult<Vec<ScriptedAnswer>> {
    let read_value = |text: &str| apex_pdl::read_value(text).map_err(|diagnostic| diagnostic.message);
    read_answers(&path.display().to_string(), &read_text(path)?, &read_value).map_err(|errors| {
        CliError::user(errors.to_string())
            .help("each line is {\"question\": \"WORDS OF THE QUESTION\", \"value\": VALUE, \"after\": SECONDS}")
    })
}

/// Returns the output of the trace, which never writes into the input of a simulator.
fn trace_output(path: Option<&Path>, output_is_taken: bool) -> CliResult<Listened> {
    match path {
        Some(path) if path.as_os_str() != "-" => match std::fs::File::create(path) {
            Ok(file) => Ok(Listened::new(Box::new(file))),
            Err(error) => Err(CliError::user(format!("cannot write the trace to {}", path.display()))
                .because(error)
                .help("choose another place with `--trace`, or leave it out to see the trace here")),
        },
        Some(_) if output_is_taken => {
            Err(CliError::user("`--trace -` would mix the trace with the lines that the simulator reads")
                .help("give `--trace` a file, or connect the simulator with `--listen`"))
        }
        None if output_is_taken => Ok(Listened::new(Box::new(std::io::sink()))),
        _ => Ok(Listened::standard()),
    }
}
