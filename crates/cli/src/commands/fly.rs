//! `apex fly`: flies a whole mission in simulated time, with record and report.

use crate::error::{CliError, CliResult};
use crate::options::FlyOptions;
use crate::recording::RecordingWatch;
use crate::{commands, output, recording, sources, stopping};
use apex_mission::Mission;
use apex_mission::deliberation::PlanningResources;
use apex_mission::flight::{FlightOutcome, MissionFlight};
use apex_mission::text::{plain_duration, shell_word};
use apex_model::effect::Effect;
use apex_model::event::Batch;
use apex_model::time::{Duration, Time};
use apex_planning::Registry;
use apex_runtime::EndReason;
use apex_runtime::ports::Observer;
use apex_server::{AccessOptions, FlightDoor};
use indicatif::{ProgressBar, ProgressStyle};
use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpListener};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread::JoinHandle;

/// Greatest valid pace, in simulated seconds per second of wall time.
const PACE_MAX: f64 = 1e9;

/// Flies a mission.
pub fn run(options: &FlyOptions, planners: &Arc<Registry>) -> CliResult {
    let pace = options.pace.map(checked_pace).transpose()?;
    let until = options.until.as_deref().map(|text| sources::parse_time(text, "--until")).transpose()?;
    let mission = Arc::new(sources::load_mission(&options.mission, planners)?);
    if let Some(runs) = options.runs {
        return commands::fly_runs::run(options, runs, until, &mission, &means(options, planners)?);
    }
    let pace = apex_simulation::pace_of(&mission, pace)?;
    if options.paused && !options.serve {
        return Err(CliError::user("`--paused` needs `--serve`: the page resumes the flight")
            .help("write `apex fly MISSION --serve --paused`"));
    }
    let short_name = Mission::short_name(&options.mission);
    let path = options.record.clone().unwrap_or_else(|| PathBuf::from(format!("{short_name}.apex")));
    if options.serve {
        check_port(options.port)?;
    }
    // If the mission cannot be simulated, an older record is left unchanged.
    apex_simulation::world(&mission, options.seed)?;
    let key = options.sign.as_deref().map(recording::signing_key).transpose()?;
    let terms = recording::options(options.power_safe, options.spare_folder.as_ref());
    let mut recorder = apex_simulation::create_record_with(&path, &mission, options.seed, terms)?;
    if let Some(key) = key {
        recorder.sign_with(key).map_err(recording::written)?;
    }
    let started = std::time::Instant::now();
    let begin = if options.paused { Some(0.0) } else { pace };
    let (door, controls) = match options.serve.then(|| FlightDoor::new(&mission, begin, commands::serve::read_datum()))
    {
        Some((door, controls)) => (Some(door), controls),
        None => (None, stopping::controls()),
    };
    let sherpa = door.as_ref().map(|door| {
        door.continues_at(pace);
        serve_beside(&path, door.clone(), options.port, planners)
    });
    let mut watch = door.as_ref().map(FlightDoor::watch);
    let terms = apex_runtime::RunSettings {
        pace: begin,
        controls: Some(controls),
        authority: door.as_ref().map(FlightDoor::authority).unwrap_or_default(),
        ..MissionFlight::terms(&mission, until)
    };
    let means = means(options, planners)?;
    let mut progress = TimeBar::new(terms.until, options.no_progress || options.json);
    let mut observers: Vec<&mut dyn Observer> = vec![&mut progress];
    observers.extend(watch.as_mut().map(|watch| watch as &mut dyn Observer));
    let mut recording = RecordingWatch;
    observers.push(&mut recording);
    let flown = apex_simulation::fly_to_the_end(mission, means, options.seed, terms, &mut recorder, &mut observers);
    // The page learns that the flight is over.
    drop(watch);
    progress.bar.finish_and_clear();
    let (flight, lost) = flown?;
    let seconds = started.elapsed().as_secs_f64();
    print_flight(&flight, seconds, (&path, recorder.path()), options.json)?;
    if let Some(sherpa) = sherpa {
        // After Ctrl-C the server has ended already; an operator who stops the flight from the page still uses the page.
        if !sherpa.is_finished() {
            output::print_line("Sherpa continues to serve the record; Ctrl-C ends it")?;
        }
        // The thread of the server has printed its failure, if any.
        sherpa.join().ok();
    }
    lost.map_or(Ok(()), |error| Err(error.into()))
}

/// Prints the report, and where the record begins and ends.
fn print_flight(flight: &FlightOutcome, seconds: f64, (first, path): (&Path, &Path), json: bool) -> CliResult {
    if json {
        return output::print_line(flight.report.json());
    }
    output::print(flight.report.text())?;
    output::print_line(format_args!(
        "\n{} of flight in {seconds:.2} s ({:.2} s planning, {:.2} s flying): {} steps, {} events, {} decisions and other effects",
        plain_duration(Duration(flight.end.at.0)),
        flight.planned_for.as_secs_f64(),
        (seconds - flight.planned_for.as_secs_f64()).max(0.0),
        flight.end.steps,
        flight.end.events,
        flight.end.effects
    ))?;
    let continued = if first == path { String::new() } else { format!(", which continues {}", first.display()) };
    output::print_line(format_args!("Flight record: {}{continued}", path.display()))?;
    let path = shell_word(&path.display().to_string());
    output::print_line(format_args!("Next: apex serve {path} --open      Sherpa, the web page, on this flight"))?;
    output::print_line(format_args!("      apex trace {path} --type transition,plan,trouble"))?; // english: allow
    match &flight.end.reason {
        EndReason::Application { failed: true, .. } => output::print_line(format_args!("      apex why {path} T0")),
        _ => output::print_line(format_args!("      apex replay {path}")),
    }
}

/// Returns `pace`, in simulated seconds per second of wall time.
///
/// # Errors
/// `pace` is not above 0, or exceeds [`PACE_MAX`].
pub fn checked_pace(pace: f64) -> CliResult<f64> {
    if pace > 0.0 && pace <= PACE_MAX {
        return Ok(pace);
    }
    Err(CliError::user(format!("`--pace {pace}` is invalid"))
        .help("write simulated seconds per second, above 0: 1 is real time, 10 is ten times faster; leave it out to fly as fast as possible"))
}

/// Reports before the flight that the port of Sherpa is not available.
fn check_port(port: u16) -> CliResult {
    match TcpListener::bind((Ipv4Addr::LOCALHOST, port)) {
        Ok(_) => Ok(()),
        Err(error) => Err(CliError::failure(format!("cannot serve on 127.0.0.1:{port}"))
            .because(error)
            .help("stop the program that uses the port, or choose another one with `--port` (0 takes any free one)")),
    }
}

/// Returns the planners with the limits of the options.
fn means(options: &FlyOptions, planners: &Arc<Registry>) -> CliResult<PlanningResources> {
    let mut means = PlanningResources::of(planners);
    means.table = options.table.as_deref().map(commands::profile::table).transpose()?;
    if let Some(text) = &options.solver_timeout {
        let time = sources::parse_time(text, "--solver-timeout")? - Time::ZERO;
        if time <= Duration::ZERO {
            return Err(CliError::user(format!("`--solver-timeout {text}` is not above zero"))
                .help("write a time above 0, for example `30s`"));
        }
        means.timeout = std::time::Duration::from_secs_f64(time.seconds());
    }
    if let Some(mebibytes) = options.solver_memory {
        means.memory_bytes = u64::from(mebibytes) << 20;
    }
    Ok(means)
}

/// Serves the growing record on a separate thread. Ctrl-C, which the server receives, ends the flight cleanly.
fn serve_beside(path: &Path, door: FlightDoor, port: u16, planners: &Arc<Registry>) -> JoinHandle<()> {
    let (path, planners) = (path.to_path_buf(), Arc::clone(planners));
    std::thread::spawn(move || {
        let address = SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), port);
        let ready = |url: &str| {
            // The page is served even if this line cannot be written.
            output::print_line(format_args!("Sherpa: {url}")).ok();
        };
        let (record, door_of_page) = (Some((path.as_path(), 0)), Some(door.clone()));
        let served = commands::serve::Served { record, door: door_of_page, others: Vec::new(), flights: None };
        match commands::serve::serve(served, &planners, AccessOptions::default(), address, ready) {
            // Without effect if the flight is over already.
            Ok(()) => door.stop(),
            Err(error) => {
                output::print_error(format_args!("{error}\n  the flight continues without Sherpa"));
                // Otherwise a flight that began paused would wait forever.
                door.resume();
            }
        }
    })
}

/// A bar over mission time.
struct TimeBar {
    bar: ProgressBar,
    shown: u64,
}

impl TimeBar {
    fn new(until: Time, hidden: bool) -> TimeBar {
        let bar = if hidden { ProgressBar::hidden() } else { ProgressBar::new(until.seconds() as u64) };
        let style = ProgressStyle::with_template("{bar:40} {percent:>3} %  mission time {msg}  (real {elapsed})");
        if let Ok(style) = style {
            bar.set_style(style);
        }
        TimeBar { bar, shown: 0 }
    }
}

impl Observer for TimeBar {
    fn observe(&mut self, batch: &Batch, _: &[Effect]) -> Result<(), String> {
        let minutes = (batch.now.seconds() / 60.0) as u64;
        if minutes > self.shown {
            self.shown = minutes;
            self.bar.set_position(minutes * 60);
            self.bar.set_message(format!("{}:{:02}", minutes / 60, minutes % 60));
        }
        Ok(())
    }
}
