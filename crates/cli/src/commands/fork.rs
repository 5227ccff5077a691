//! `apex fork`: a recorded flight, flown on from an instant with changes, and both reports side by side.

use crate::options::ForkOptions;
use crate::trouble::{Outcome, Trouble};
use crate::world::world;
use crate::{output, recording, sources};
use apex_mission::comparison::Comparison;
use apex_mission::deliberation::Means;
use apex_mission::flight::MissionFlight;
use apex_mission::fork::{Changes, Fork, scaled_wind};
use apex_mission::{Mission, recorded, scenario};
use apex_model::problem::WindField;
use apex_model::time::Time;
use apex_planning::Registry;
use apex_runtime::record::{RecordReader, Recorder};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Text for a fork without changes.
const NOTHING: &str = "nothing is changed";

/// Forks a recorded flight.
pub fn run(options: &ForkOptions, planners: &Arc<Registry>) -> Outcome {
    let reader = recording::open(&options.record)?;
    let mission = Arc::new(mission(&reader, &options.record)?);
    let at = instant(&reader, &options.at)?;
    let until = options.until.as_deref().map(|text| sources::parse_time(text, "--until")).transpose()?;
    let wind = wind(options, &mission)?;
    let inputs = options.inputs.as_deref().map(scenario::read).transpose()?.unwrap_or_default();
    let changes = Changes { inputs, plan: options.plan.clone() };
    let seed = reader.meta("seed").map_err(|error| Trouble::user(error.to_string()))?;
    let mut vehicle = world(&mission, seed.and_then(|seed| seed.parse().ok()))?;
    let path = options.output.clone().unwrap_or_else(|| beside(&options.record));
    refuse_the_same(&options.record, &path)?;
    let mut recorder = recording::of_mission(&path, &mission)?;
    describe(&mut recorder, options, at).map_err(recording::written)?;
    let fork = Fork { reader: &reader, mission: Arc::clone(&mission), means: Means::of(planners), at };
    let change = |vehicle: &mut apex_sim::SimulatedWorld| {
        if let Some(wind) = wind {
            vehicle.change_wind(wind);
        }
        if let Some(seed) = options.seed {
            vehicle.reseed(seed);
        }
    };
    let forked =
        fork.fly(&mut vehicle, change, changes, MissionFlight::terms(&mission, until), &mut [&mut recorder])?;
    forked.store(&mut recorder).map_err(recording::written)?;
    let recorded = recorded::report_of(&reader, &mission)?;
    let comparison = Comparison { headings: ["recorded", "forked"], reports: [&recorded, &forked.report], from: at };
    if options.json {
        return output::print_line(comparison.json());
    }
    output::print_line(format_args!("\n{}, forked at {at}: {}\n", mission.settings.name, what(options)))?;
    output::print(comparison.text())?;
    output::print_line(format_args!("\nFlight record: {}", path.display()))
}

fn mission(reader: &RecordReader, path: &Path) -> Outcome<Mission> {
    let fact = |key: &str| reader.meta(key).map_err(|error| Trouble::user(error.to_string()));
    let cannot = |why: &str, help: &str| {
        Err(Trouble::user(format!("{} cannot be forked", path.display())).because(why.to_string()).help(help))
    };
    if let Some(changes) = fact("forked_with")?.filter(|changes| changes != NOTHING) {
        let why = format!("it is itself a fork ({changes}), and the simulated world before its change is another");
        return cannot(&why, "fork the record that it continues");
    }
    if fact("mission")?.is_some() && fact("vehicle_type")?.is_none() {
        let why = "its vehicle was not the built-in simulator, which alone can repeat what a vehicle did";
        return cannot(why, "fork a record that `apex fly` has written");
    }
    let not_a_mission = || {
        Trouble::user(format!("{} does not hold a mission", path.display()))
            .because("its program names no vehicle and no targets")
            .help("fork a record that `apex fly` has written")
    };
    recorded::mission_of(reader)?.ok_or_else(not_a_mission)
}

/// The instant of the fork, which the record must hold.
fn instant(reader: &RecordReader, text: &str) -> Outcome<Time> {
    let at = sources::parse_time(text, "--at")?;
    let span = reader.span().map_err(|error| Trouble::user(error.to_string()))?;
    let Some((first, last)) = span else {
        return Err(Trouble::user(format!("{} holds no steps", reader.path().display())).help("fly the mission again"));
    };
    let end = reader.meta("end_ns").map_err(|error| Trouble::user(error.to_string()))?;
    let last = end.and_then(|text| text.parse().ok()).map_or(last, |end| last.max(Time(end)));
    if (first..=last).contains(&at) {
        return Ok(at);
    }
    Err(Trouble::user(format!("`--at {text}` lies outside of the record"))
        .because(format!("it holds the flight from {first} to {last}"))
        .help("give an instant between"))
}

/// The wind that blows after the fork; none leaves it as recorded.
fn wind(options: &ForkOptions, mission: &Mission) -> Outcome<Option<WindField>> {
    match (options.wind_factor, &options.weather) {
        (Some(factor), _) if (0.0..=100.0).contains(&factor) => Ok(Some(scaled_wind(&mission.weather, factor))),
        (Some(factor), _) => Err(Trouble::user(format!("invalid value `{factor}` for `--wind-factor`"))
            .because("expected a number from 0 to 100")
            .help("write for example `--wind-factor 2`")),
        (None, Some(path)) => Ok(Some(apex_mission::read_wind(path)?)),
        (None, None) => Ok(None),
    }
}

/// `flight.apex` -> `flight-fork.apex`
fn beside(record: &Path) -> PathBuf {
    let stem = record.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    record.with_file_name(format!("{stem}-fork.apex"))
}

fn refuse_the_same(record: &Path, output: &Path) -> Outcome {
    let real = |path: &Path| std::fs::canonicalize(path).ok();
    match (real(record), real(output)) {
        (Some(record), Some(output)) if record == output => {
            Err(Trouble::user("the forked flight would be written over the record that it continues")
                .help("give `--output` another file"))
        }
        _ => Ok(()),
    }
}

/// The changes as text.
fn what(options: &ForkOptions) -> String {
    let file = |path: &PathBuf| path.display().to_string();
    let parts = [
        options.wind_factor.map(|factor| format!("wind times {factor}")),
        options.weather.as_ref().map(|path| format!("weather of {}", file(path))),
        options.seed.map(|seed| format!("seed {seed}")),
        options.inputs.as_ref().map(|path| format!("inputs of {}", file(path))),
        (!options.plan.is_empty()).then(|| format!("plan {}", options.plan.join(", "))),
    ];
    let parts: Vec<String> = parts.into_iter().flatten().collect();
    if parts.is_empty() { NOTHING.to_string() } else { parts.join("; ") }
}

fn describe(recorder: &mut Recorder, options: &ForkOptions, at: Time) -> Result<(), apex_runtime::RecordError> {
    recorder.meta("forked_from", &options.record.display().to_string())?;
    recorder.meta("forked_at_ns", &at.0.to_string())?;
    recorder.meta("forked_with", &what(options))
}
