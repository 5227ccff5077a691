//! `apex fly`: a whole mission in simulated time, recorded, reported.

use crate::mission::Mission;
use crate::mission::bookkeeping::{Bookkeeping, BookkeepingObserver, SharedBookkeeping, lock};
use crate::mission::deliberator::MissionDeliberator;
use crate::mission::report::{Report, report};
use crate::mission::world::world;
use crate::options::FlyOptions;
use crate::trouble::{Outcome, Trouble};
use crate::{commands, sources};
use apex_model::effect::Effect;
use apex_model::event::Batch;
use apex_model::time::{Duration, Time};
use apex_runtime::RunEnd;
use apex_runtime::pool::Contained;
use apex_runtime::ports::Observer;
use apex_runtime::record::{RecordOptions, Recorder, TargetRow, TargetState};
use indicatif::{ProgressBar, ProgressStyle};
use std::net::{IpAddr, Ipv4Addr};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

/// Wall time after which a solver that does not return is given up; its budget is counted in work, so this is far off.
const SOLVER_PATIENCE: std::time::Duration = std::time::Duration::from_secs(300);

type SharedRecorder = Arc<Mutex<Recorder>>;
type TargetChange = (String, Time, TargetState, String);

/// Flies a mission.
pub fn run(options: &FlyOptions) -> Outcome {
    let mission = Arc::new(Mission::load(&options.mission)?);
    let short_name = Mission::short_name(&options.mission);
    let path = options.record.clone().unwrap_or_else(|| PathBuf::from(format!("{short_name}.apex")));
    let limit = Time::ZERO + mission.settings.duration;
    let until = options.until.as_deref().map(|text| sources::parse_time(text, "--until")).transpose()?;
    let until = until.map_or(limit, |until| until.min(limit));
    let recorder: SharedRecorder = Arc::new(Mutex::new(recorder(&path, &mission)?));
    if options.serve {
        serve_beside(&path, options.port);
    }
    let started = std::time::Instant::now();
    let flight = fly(&mission, options, until, &recorder)?;
    let seconds = started.elapsed().as_secs_f64();
    finish(&recorder, &flight)?;

    if options.json {
        let sections: serde_json::Map<String, serde_json::Value> =
            flight.report.sections().into_iter().map(|(name, body)| (name.to_string(), body)).collect();
        println!("{}", serde_json::Value::Object(sections));
    } else {
        print!("{}", flight.report.text());
        println!(
            "\n{} of flight in {seconds:.2} s: {} steps, {} events, {} decisions and other effects",
            Duration(flight.end.at.0),
            flight.end.steps,
            flight.end.events,
            flight.end.effects
        );
        println!("Flight record: {}", path.display());
        println!("Next: apex serve {0} --open   |   apex replay {0}   |   apex trace {0}", path.display());
    }
    if options.serve {
        println!("Sherpa goes on serving the record; Ctrl-C ends it");
        loop {
            std::thread::park();
        }
    }
    Ok(())
}

/// Everything that a flight came to.
struct Flight {
    end: RunEnd,
    report: Report,
}

fn fly(mission: &Arc<Mission>, options: &FlyOptions, until: Time, recorder: &SharedRecorder) -> Outcome<Flight> {
    let mut vehicle = world(mission, options.seed)?;
    let books: SharedBookkeeping = Arc::new(Mutex::new(Bookkeeping::default()));
    let deliberator = MissionDeliberator::new(Arc::clone(mission), Arc::clone(&books));
    let mut deliberator = Contained::new(Box::new(deliberator), SOLVER_PATIENCE)
        .map_err(|reason| Trouble::failure("no thread for the solvers").because(reason))?;
    let mut agent = apex_executive::load(Arc::clone(&mission.library), &mission.agent, sources::host_functions())
        .map_err(|reason| Trouble::user("the mission cannot be executed").because(reason))?;
    let mut bookkeeper = BookkeepingObserver(Arc::clone(&books));
    let mut targets = TargetRecorder { recorder: Arc::clone(recorder), books: Arc::clone(&books), changes: Vec::new() };
    let mut progress = Progress::new(until, options.no_progress || options.json);
    let mut shared_recorder = Arc::clone(recorder);
    let fly_options = apex_runtime::FlyOptions {
        until,
        pace: options.pace,
        inputs: mission.scenario.clone(),
        ..apex_runtime::FlyOptions::default()
    };
    let mut observers: Vec<&mut dyn Observer> =
        vec![&mut shared_recorder, &mut bookkeeper, &mut targets, &mut progress];
    let end = apex_runtime::fly(&mut agent, &mut vehicle, &mut deliberator, &mut observers, fly_options)
        .map_err(|error| Trouble::failure(error.to_string()))?;
    progress.bar.finish_and_clear();
    let report = report(mission, &lock(&books), &targets.changes, (end.at, end.reason.text()));
    Ok(Flight { end, report })
}

fn failed(error: apex_runtime::RecordError) -> Trouble {
    Trouble::failure(error.to_string())
}

/// A record with the mission's program, data and targets inside.
fn recorder(path: &Path, mission: &Mission) -> Outcome<Recorder> {
    let vehicle = mission.agent.name.printed().to_string();
    let options = RecordOptions { vehicle: Some(vehicle), ..RecordOptions::default() };
    let mut recorder = Recorder::create(path, &mission.library, options).map_err(failed)?;
    recorder.program(&mission.library).map_err(failed)?;
    for (name, bytes) in &mission.data {
        recorder.source(name, "data", bytes).map_err(failed)?;
    }
    recorder.meta("mission", &mission.settings.name).map_err(failed)?;
    recorder.meta("agent", mission.agent.name.printed()).map_err(failed)?;
    recorder.meta("vehicle", &mission.model.name).map_err(failed)?;
    if let Some(epoch) = &mission.settings.epoch_text {
        recorder.meta("epoch_utc", epoch).map_err(failed)?;
    }
    for target in mission.targets.iter().filter(|target| target.is_observable()) {
        recorder
            .target(&TargetRow {
                id: target.id.clone(),
                name: target.name.clone(),
                latitude_deg: target.position.latitude_deg,
                longitude_deg: target.position.longitude_deg,
                value: target.worth(),
                geometry: target.geometry.clone(),
            })
            .map_err(failed)?;
    }
    Ok(recorder)
}

fn finish(recorder: &SharedRecorder, flight: &Flight) -> Outcome {
    let mut recorder = recorder.lock().unwrap_or_else(PoisonError::into_inner);
    for (section, body) in flight.report.sections() {
        recorder.report(section, &body.to_string()).map_err(failed)?;
    }
    recorder.finish(flight.end.at, &flight.end.reason.text()).map_err(failed)
}

/// Serves the growing record on a thread of its own.
fn serve_beside(path: &Path, port: u16) {
    let path = path.to_path_buf();
    std::thread::spawn(move || {
        let address = IpAddr::V4(Ipv4Addr::LOCALHOST);
        if let Err(trouble) = commands::serve::serve(&path, address, port, |url| println!("Sherpa: {url}")) {
            eprintln!("{trouble}\n  the flight goes on without Sherpa");
        }
    });
}

/// Moves changes of targets' states from the books into the record.
struct TargetRecorder {
    recorder: SharedRecorder,
    books: SharedBookkeeping,
    changes: Vec<TargetChange>,
}

impl Observer for TargetRecorder {
    fn observe(&mut self, _: &Batch, _: &[Effect]) -> Result<(), String> {
        let new = std::mem::take(&mut lock(&self.books).target_changes);
        if new.is_empty() {
            return Ok(());
        }
        let mut recorder = self.recorder.lock().unwrap_or_else(PoisonError::into_inner);
        for (target, at, state, detail) in &new {
            recorder.target_state(target, *at, *state, detail).map_err(|error| error.to_string())?;
        }
        self.changes.extend(new);
        Ok(())
    }
}

/// A bar over mission time.
struct Progress {
    bar: ProgressBar,
    shown: u64,
}

impl Progress {
    fn new(until: Time, hidden: bool) -> Progress {
        let bar = if hidden { ProgressBar::hidden() } else { ProgressBar::new(until.seconds() as u64) };
        let style = ProgressStyle::with_template("{bar:40} {percent:>3} %  mission time {msg}  (real {elapsed})");
        if let Ok(style) = style {
            bar.set_style(style);
        }
        Progress { bar, shown: 0 }
    }
}

impl Observer for Progress {
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
