//! One program with its inputs, checked and run without a vehicle.

use crate::late;
use crate::outside::{PagePlanner, PageVehicle, PlannerManner, VehicleManner};
use crate::projection::Teller;
use crate::reasons::Asker;
use apex_executive::load;
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
use apex_pdl::{CheckOptions, Checked, HostSignature, Requirement, SourceText, Unresolved};
use apex_runtime::error::RunError;
use apex_runtime::mission_loop::{EndReason, RunEnd, RunSettings, fly_all};
use apex_runtime::ports::Observer;
use apex_runtime::record::RestoredProgram;
use std::path::Path;
use std::sync::Arc;

/// The name of a page's program in messages.
pub const PROGRAM_NAME: &str = "page.pdl";
/// End of a run if its page states none.
const UNTIL_DEFAULT: Time = Time(3600 * apex_model::time::NANOSECONDS_PER_SECOND);

/// Content of a page up to a compared block.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Scenario {
    /// The program.
    pub pdl: String,
    /// Files that the program may require, by name.
    pub files: Vec<(String, String)>,
    /// Inputs as JSON lines.
    pub inputs: String,
    /// `until 20s`, `show print ongoing`, `vehicle silent`, `planner fails after 3s no idea`.
    pub options: String,
    /// Outcomes of the tests of a dependency model, as JSON.
    pub outcomes: String,
    /// Ground, wanted looks, lines and costs to be scored (`observed.rs`).
    pub look: String,
}

/// Runs the scenario and returns its whole report.
///
/// # Errors
/// The checker's messages; an invalid input line or option; a task that could not state for what it waited. A run that fails reports that
/// in its last line.
pub fn run(scenario: &Scenario) -> Result<Teller, String> {
    let mut teller = Teller::new(&read_options(&scenario.options)?.kinds)?;
    let mut asker = Asker::default();
    let program = program_of(scenario)?;
    if program.0.has_several_agents() {
        teller.name_agents(program.0.agents.iter().map(|agent| agent.name.printed().to_string()).collect());
    }
    let line = match run_observed(scenario, &program, &mut [&mut teller, &mut asker])? {
        Ok(end) => last_line(&end),
        Err(error) => format!("error: {error}"),
    };
    if !asker.missing().is_empty() {
        return Err(format!("a task cannot say what it waits for:\n    {}", asker.missing().join("\n    ")));
    }
    teller.tell(line);
    Ok(teller)
}

/// Returns the scenario's program, ready to be run.
///
/// # Errors
/// The checker's messages.
pub fn program(pdl: &str) -> Result<RestoredProgram, String> {
    program_of(&Scenario { pdl: pdl.to_string(), ..Scenario::default() })
}

/// Returns the checked program, with the files that it requires.
///
/// # Errors
/// The checker's messages.
pub fn program_of(scenario: &Scenario) -> Result<RestoredProgram, String> {
    let checked = check(scenario);
    if checked.has_errors() {
        return Err(format!("the program has errors:\n{}", messages(&checked)));
    }
    let declaration = checked.library.crew().swap_remove(0);
    Ok((Arc::new(checked.library), declaration, apex_geo::functions::host_functions()))
}

/// Runs `program` with the scenario's inputs and options; `observers` see everything. The inner result states how the run ended.
///
/// # Errors
/// A bad input line or a bad option, or an agent that cannot be made.
pub fn run_observed(
    scenario: &Scenario,
    program: &RestoredProgram,
    observers: &mut [&mut dyn Observer],
) -> Result<Result<RunEnd, RunError>, String> {
    let Options { until, vehicle, planner, .. } = read_options(&scenario.options)?;
    let late::Inputs { prompt: inputs, late } = late::read(&scenario.inputs)?;
    let (library, _, host) = program.clone();
    let crew = library.crew();
    let mut agents =
        crew.iter().map(|each| load(Arc::clone(&library), each, host.clone())).collect::<Result<Vec<_>, _>>()?;
    let options = RunSettings { until, inputs, ..RunSettings::default() };
    let (mut vehicle, mut planner) = (PageVehicle::new(vehicle, late), PagePlanner(planner));
    Ok(fly_all(&mut agents, &mut vehicle, &mut planner, observers, options))
}

/// Checks a page's program; shipped libraries and the page's files are found.
pub fn check(scenario: &Scenario) -> Checked {
    let host: Vec<HostSignature> =
        apex_geo::functions::host_signatures().into_iter().map(HostSignature::pure).collect();
    let source = SourceText { name: PROGRAM_NAME.to_string(), text: scenario.pdl.clone() };
    let mut resolve = |requirement| resolve(requirement, &scenario.files);
    let mut checked =
        apex_pdl::check(vec![source], CheckOptions { fragment: false, host: &host, resolve: &mut resolve });
    if !checked.has_errors() && !checked.library.constants.is_empty() {
        let host = apex_geo::functions::host_functions();
        let failures = apex_executive::failing_constants(&Arc::new(checked.library.clone()), host);
        apex_pdl::report_constants(&mut checked, failures);
    }
    checked
}

/// Returns the checker's messages as shown to the user.
pub fn messages(checked: &Checked) -> String {
    let rendered = apex_pdl::render(&checked.diagnostics, &checked.library.sources, false);
    rendered.lines().map(|line| format!("{}\n", line.trim_end())).collect()
}

fn resolve(requirement: Requirement, files: &[(String, String)]) -> Result<SourceText, Unresolved> {
    match requirement {
        Requirement::Library(name) => {
            let file = format!("library/{name}.pdl");
            if let Some((_, text)) = files.iter().find(|(known, _)| *known == file) {
                return Ok(SourceText { name: file, text: text.clone() });
            }
            let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../library").join(format!("{name}.pdl"));
            let text = std::fs::read_to_string(&path).map_err(|_| format!("no library `{name}`"))?;
            Ok(SourceText { name: file, text })
        }
        Requirement::File { name, .. } => match files.iter().find(|(known, _)| *known == name) {
            Some((_, text)) => Ok(SourceText { name, text: text.clone() }),
            None => Err(format!("this page has no file `{name}`").into()),
        },
    }
}

/// Content of the `options` block.
struct Options {
    until: Time,
    kinds: Vec<String>,
    vehicle: VehicleManner,
    planner: PlannerManner,
}

fn read_options(text: &str) -> Result<Options, String> {
    let (vehicle, planner) = (VehicleManner::default(), PlannerManner::default());
    let mut options = Options { until: UNTIL_DEFAULT, kinds: Vec::new(), vehicle, planner };
    for line in text.lines().filter(|line| !line.trim().is_empty()) {
        match line.split_whitespace().collect::<Vec<_>>().as_slice() {
            ["until", time] => options.until = read_time(time)?,
            ["show", some @ ..] => options.kinds.extend(some.iter().map(ToString::to_string)),
            ["vehicle", manner @ ..] => options.vehicle = VehicleManner::read(manner)?,
            ["planner", manner @ ..] => options.planner = PlannerManner::read(manner)?,
            _ => {
                let known = "`until TIME`, `show KIND..`, `vehicle MANNER..` and `planner MANNER..`";
                return Err(format!("option `{line}` is not known; there are {known}"));
            }
        }
    }
    Ok(options)
}

/// Returns an instant such as `20s` or `P1M30S`.
pub(crate) fn read_time(text: &str) -> Result<Time, String> {
    match apex_pdl::read_value(text) {
        Ok(Value::Duration(Duration(nanoseconds))) => Ok(Time(nanoseconds)),
        _ => Err(format!("`{text}` is not an instant: expected a duration such as 20s")),
    }
}

fn last_line(end: &RunEnd) -> String {
    let word = match end.reason {
        EndReason::Application { .. } => "end",
        EndReason::Until => "until",
        EndReason::Quiescent => "quiet",
        EndReason::Stopped => "stopped",
    };
    format!("{} {word}", end.at)
}
