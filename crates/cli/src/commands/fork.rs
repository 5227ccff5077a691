//! `apex fork`: continues a recorded flight from an instant on with changes, and compares both reports.

use crate::error::{CliError, CliResult};
use crate::options::ForkOptions;
use crate::{output, recording, sources, stopping};
use apex_mission::comparison::Comparison;
use apex_mission::deliberation::PlanningResources;
use apex_mission::fork::{Changes, scaled_wind};
use apex_mission::{recorded, scenario};
use apex_model::problem::WindField;
use apex_planning::Registry;
use apex_runtime::record::RecordReader;
use apex_simulation::{ForkTerms, Forked, WorldChanges, fork};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Forks a recorded flight.
pub fn run(options: &ForkOptions, planners: &Arc<Registry>) -> CliResult {
    let reader = recording::open(&options.record)?;
    let at = sources::parse_time(&options.at, "--at")?;
    let until = options.until.as_deref().map(|text| sources::parse_time(text, "--until")).transpose()?;
    let inputs = options.inputs.as_deref().map(scenario::read).transpose()?.unwrap_or_default();
    let changes = Changes { inputs, plan: options.plan.clone() };
    let world = WorldChanges { wind: wind(options, &reader)?, seed: options.seed };
    let path = options.output.clone().unwrap_or_else(|| beside(&options.record));
    let text = described(options);
    let terms = ForkTerms { until, controls: Some(stopping::controls()), ..ForkTerms::default() };
    let Forked { recorded, forked } =
        fork(&reader, at, (changes, world, text.clone()), PlanningResources::of(planners), terms, &path)?;
    let comparison = Comparison { headings: ["recorded", "forked"], reports: [&recorded, &forked.report], from: at };
    if options.json {
        return output::print_line(comparison.json());
    }
    let text = text.as_deref().unwrap_or("nothing is changed");
    output::print_line(format_args!("\n{}, forked at {at}: {text}\n", recorded.mission))?;
    output::print(comparison.text())?;
    output::print_line(format_args!("\nFlight record: {}", path.display()))
}

/// Returns the wind after the fork; `None` leaves it as recorded.
fn wind(options: &ForkOptions, reader: &RecordReader) -> CliResult<Option<WindField>> {
    match (options.wind_factor, &options.weather) {
        (Some(factor), _) if (0.0..=100.0).contains(&factor) => {
            Ok(recorded::mission_of(reader)?.map(|mission| scaled_wind(&mission.weather, factor)))
        }
        (Some(factor), _) => Err(CliError::user(format!("invalid value `{factor}` for `--wind-factor`"))
            .because("expected a number from 0 to 100")
            .help("write for example `--wind-factor 2`")),
        (None, Some(path)) => Ok(Some(apex_mission::read_wind(path)?)),
        (None, None) => Ok(None),
    }
}

/// Returns the default path of the fork's record: `flight.apex` -> `flight-fork.apex`
fn beside(record: &Path) -> PathBuf {
    let stem = record.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    record.with_file_name(format!("{stem}-fork.apex"))
}

/// Returns the changes as text; `None` if there are none.
fn described(options: &ForkOptions) -> Option<String> {
    let file = |path: &PathBuf| path.display().to_string();
    let parts = [
        options.wind_factor.map(|factor| format!("wind times {factor}")),
        options.weather.as_ref().map(|path| format!("weather of {}", file(path))),
        options.seed.map(|seed| format!("seed {seed}")),
        options.inputs.as_ref().map(|path| format!("inputs of {}", file(path))),
        (!options.plan.is_empty()).then(|| format!("plan {}", options.plan.join(", "))),
    ];
    let parts: Vec<String> = parts.into_iter().flatten().collect();
    (!parts.is_empty()).then(|| parts.join("; "))
}
