//! Input of `apex plan`: a mission, a problem in a file (JSON, or a benchmark's format), or a test mission by the name
//! of its cell.

use super::{problem_file, proof};
use crate::Mission;
use crate::deliberation::{Deliberation, translate, validate};
use crate::error::{MissionError, MissionResult};
use crate::files::{nearby_help, read_text};
use crate::problem::pose;
use crate::situation::Situation;
use apex_metrics::survival;
use apex_model::problem::{Plan, Position, Problem};
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
use apex_planning::solver::time_of;
use apex_planning::validate::TARGETS_MAX;
use apex_portfolio::cell::Cell;
use apex_portfolio::formats;
use std::path::Path;

/// Least time that [`PlanInput::bound_budget_after`] adds to what remains of the budget for planning.
const BOUND_BUDGET_MIN: Duration = Duration(500_000_000);
/// Deliberation time where none is stated.
const BUDGET_DEFAULT: Duration = Duration(10_000_000_000);

/// A problem with the data for planning.
pub struct PlanInput {
    /// Name.
    pub name: String,
    /// The problem.
    pub problem: Problem,
    /// Greatest time of solvers.
    pub budget: Duration,
    /// Greatest time of proofs of bounds.
    pub bound_budget: Duration,
    /// Seed of the solvers' random numbers.
    pub seed: u64,
    /// The mission and its goal, if the problem belongs to a mission.
    pub mission: Option<(Mission, Value)>,
    /// Statements of a benchmark's file in addition to the problem.
    pub benchmark: Option<Benchmark>,
    /// Start of the flight, if the problem does not state it.
    pub start: Option<Position>,
}

impl PlanInput {
    /// Returns a problem without mission or benchmark.
    fn new(name: String, problem: Problem) -> PlanInput {
        let (budget, bound_budget) = (BUDGET_DEFAULT, proof::BUDGET_DEFAULT);
        PlanInput { name, problem, budget, bound_budget, seed: 1, mission: None, benchmark: None, start: None }
    }
}

impl PlanInput {
    /// Returns the budget of a proof if only a budget for planning is stated: what remains of it after planning with `work` units, plus a
    /// twentieth of it or half a second.
    pub fn bound_budget_after(&self, work: u64) -> Duration {
        let more = Duration(self.budget.0 / 20).max(BOUND_BUDGET_MIN);
        let left = Duration(self.budget.0.saturating_sub(time_of(work).0).max(0));
        Duration(left.0.saturating_add(more.0)).min(self.bound_budget)
    }

    /// Refuses to plan for more than one vehicle.
    ///
    /// # Errors
    /// If `vehicles` is stated and not 1.
    pub fn refuse_fleets(&self, vehicles: Option<usize>) -> MissionResult<()> {
        let Some(more) = vehicles.filter(|vehicles| *vehicles != 1) else { return Ok(()) };
        let reason = match self.benchmark.as_ref().and_then(|benchmark| benchmark.vehicles) {
            Some(named) => format!("a plan is the path of one vehicle, though the file names {named}"),
            None => "a plan is the path of one vehicle".to_string(),
        };
        Err(MissionError::planning(format!("{more} vehicles cannot be planned for"))
            .because(reason)
            .help("leave `--vehicles` out to plan for one"))
    }

    /// Returns the plan as a procedure for the mission's goal, with the libraries of its steps, so that it can be checked alone; empty if
    /// the problem does not belong to a mission.
    pub fn procedure_text(&self, solved: &Deliberation) -> String {
        let Some((mission, goal)) = &self.mission else { return String::new() };
        let application = mission.library.application.as_ref();
        let libraries = application.and_then(|application| application.option("libraries")).and_then(Value::as_list);
        let named = libraries.unwrap_or_default().iter().filter_map(|library| match library {
            Value::Text(name) => Some(format!("(require-apex-library \"{name}\")\n")),
            _ => None,
        });
        named.chain([translate(solved, goal, 1, mission).source.text.to_string()]).collect()
    }
}

/// Returns the cost of a surveillance plan if only the first event after an observation counts.
///
/// # Errors
/// If the plan is not a surveillance plan, or its cost cannot be computed.
pub fn survival_cost(solved: &Deliberation) -> MissionResult<f64> {
    let (Problem::Surveillance(problem), Plan::Surveillance(plan)) = (&solved.problem, &solved.plan) else {
        return Err(MissionError::planning("the plan is not one of surveillance"));
    };
    let cost = survival::expected_cost(problem, &plan.visits);
    cost.map(|cost| cost.total)
        .map_err(|why| MissionError::planning("the cost of first events is not known").because(why))
}

/// Statements of a benchmark's file in addition to the problem.
pub struct Benchmark {
    /// Name of the format.
    pub format: &'static str,
    /// Kind of the problem.
    pub asked: formats::ProblemKind,
    /// Number of vehicles that the file states.
    pub vehicles: Option<usize>,
}

/// Extensions of benchmark files; of other files the content decides.
const BENCHMARKS: &[&str] = &["toptw", "optw", "txt", "oplib", "op", "tsp", "atsp"];

impl PlanInput {
    /// Returns the input called `path` if it is a problem: a cell of test missions, a problem in JSON, a benchmark file. `None` for
    /// everything else, such as a mission's folder or program.
    ///
    /// # Errors
    /// If nothing has that name, or the file has another content.
    pub fn find(path: &Path) -> MissionResult<Option<PlanInput>> {
        let text = path.to_string_lossy();
        if !path.exists() && !text.contains(['/', '\\', '.']) {
            of_cell(&text).map(Some)
        } else if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("json")) {
            of_file(path).map(Some)
        } else if path.is_file() {
            // A table may be a benchmark; a map never is.
            let found = if is_of(path, MAPS) { None } else { of_benchmark(path)? };
            match found.is_none() && (is_of(path, MAPS) || is_of(path, TABLES)) {
                true => Err(places_alone(path)),
                false => Ok(found),
            }
        } else {
            Ok(None)
        }
    }

    /// Returns the problem that a mission poses at its start, for the goal and with the budget of its first solver.
    ///
    /// # Errors
    /// If there is nothing to plan.
    pub fn of_mission(mission: Mission) -> MissionResult<PlanInput> {
        let (goal, budget) = goal_and_budget(&mission);
        let (situation, here) = (Situation::default(), mission.start);
        let mission = situation.links.without_weak_links(mission, here);
        let problem = pose(&situation.updates.believed(&mission), &situation, None, Time::ZERO)
            .map_err(|reason| MissionError::planning("there is nothing to plan").because(reason))?;
        let (name, seed) = (mission.settings.name.clone(), mission.settings.seed);
        Ok(PlanInput { budget, seed, mission: Some((mission, goal)), ..PlanInput::new(name, problem) })
    }

    /// Returns a problem in JSON; `place` names the text in messages.
    ///
    /// # Errors
    /// The text is not a problem, or a field has an impossible value.
    pub fn of_json(text: &str, place: &str) -> MissionResult<PlanInput> {
        let problem = problem_file::read(text).map_err(|error| {
            let place = format!("{place}:{}:{}", error.line(), error.column());
            MissionError::planning("this is not a planning problem").at(place)
                .because(error)
                .help("docs/reference/planning-problems.md describes problems; `apex plan small-fixed-fixed-4-uniform --problem` prints one")
        })?;
        validate(&problem).map_err(|reason| {
            MissionError::planning("the problem is invalid")
                .at(place)
                .because(reason)
                .help("docs/reference/schema/planning-problem.schema.json describes each member")
        })?;
        Ok(PlanInput::new("problem".into(), problem))
    }

    /// Returns true if a mission of single visits changes its forecast of the air: bounds then hold in the air of the earliest arrivals.
    pub fn air_changes(&self) -> bool {
        matches!(self.problem, Problem::SingleVisit(_)) && self.mission().is_some_and(Mission::air_changes)
    }

    /// Returns the mission of the input, if it has one.
    pub fn mission(&self) -> Option<&Mission> {
        self.mission.as_ref().map(|(mission, _)| mission)
    }

    /// Returns true if the benchmark asks for a shortest tour through all nodes.
    pub fn is_tour(&self) -> bool {
        self.benchmark.as_ref().is_some_and(|benchmark| benchmark.asked == formats::ProblemKind::Tour)
    }
}

/// Returns a test mission: the name of its cell, with `@NUMBER` for another mission than the first.
fn of_cell(text: &str) -> MissionResult<PlanInput> {
    let (cell, number) = text.split_once('@').unwrap_or((text, "0"));
    let cell: Cell = cell.parse().map_err(|why: String| no_such_name(text, cell, &why))?;
    let number: u64 = number.parse().map_err(|_| {
        MissionError::planning(format!("{number} is not a number of a test mission"))
            .help(format!("write for example `{cell}@7`"))
    })?;
    let problem = Problem::Surveillance(cell.mission(number));
    let start = Some(apex_portfolio::test_missions::CENTRE);
    Ok(PlanInput { start, ..PlanInput::new(format!("{cell}@{number}"), problem) })
}

/// Returns the error of an unknown name: the nearest names, and the place where names are listed.
fn no_such_name(text: &str, cell: &str, why: &str) -> MissionError {
    let trouble = MissionError::planning(format!("there is no mission, file or test mission called {text}"));
    let shipped = Path::new("missions").join(text);
    if shipped.join("mission.pdl").is_file() {
        return trouble.because(nearby_help(Path::new(text))).help(format!("did you mean `{}`?", shipped.display()));
    }
    let lists = "docs/reference/test-missions.md names them; a mission is named by its folder, a problem by its file";
    match nearest_cell(cell) {
        Some(near) => {
            let number = text.strip_prefix(cell).unwrap_or_default();
            trouble.because(why).help(format!("did you mean the test mission `{near}{number}`? {lists}"))
        }
        None => trouble.because(nearby_help(Path::new(text))).help(format!(
            "test missions are called SCALE-RATE-COST-COUNT-SPACE, for example `small-clustered-fixed-8-two-cluster@7`; {lists}"
        )),
    }
}

/// Greatest number of edits between a misspelt name and a known one, as a share of its length.
const MISSPELT_SHARE_MAX: f64 = 0.4;

/// Returns the cell with the most similar name to `text`, if one is similar; the count is kept.
fn nearest_cell(text: &str) -> Option<Cell> {
    let count = text.split('-').find_map(|part| part.parse().ok()).filter(|count| (1..=TARGETS_MAX).contains(count));
    let cells = Cell::all().into_iter().map(|cell| Cell { count: count.unwrap_or(cell.count), ..cell });
    let letters = text.chars().count();
    // A name that is far too long is compared with nothing.
    let near = |cell: Cell| (strsim::damerau_levenshtein(&cell.to_string(), text), cell);
    let (edits, cell) = (letters <= 80).then(|| cells.map(near).min_by_key(|(edits, _)| *edits)).flatten()?;
    (edits as f64 <= MISSPELT_SHARE_MAX * letters as f64).then_some(cell)
}

fn of_file(path: &Path) -> MissionResult<PlanInput> {
    let mut input = PlanInput::of_json(&read_text(path)?, &path.display().to_string())?;
    input.name = path.file_stem().map_or(input.name, |name| name.to_string_lossy().into_owned());
    Ok(input)
}

/// Extensions of files that hold places, which missions name.
const MAPS: &[&str] = &["geojson", "kml", "kmz"];
const TABLES: &[&str] = &["csv"];

fn is_of(path: &Path, extensions: &[&str]) -> bool {
    let extension = path.extension().map(|extension| extension.to_string_lossy().to_lowercase());
    extension.is_some_and(|extension| extensions.contains(&extension.as_str()))
}

/// Returns the error for places without a problem: a mission must state the vehicle, the start, the duration and the goal.
fn places_alone(path: &Path) -> MissionError {
    let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let folder = path.parent().filter(|folder| folder.join("mission.pdl").is_file());
    let help = match folder {
        Some(folder) => format!("plan for the mission in the same folder: `apex plan {}`", folder.display()),
        None => format!(
            "write a mission next to it that names it, `:targets \"{name}\"`, and plan for its folder; docs/guides/your-own-mission.md shows how"
        ),
    };
    MissionError::planning(format!("{} holds places, not a planning problem", path.display()))
        .because("the vehicle, its start, the duration and the goal are stated in a mission")
        .help(help)
}

/// Reads a benchmark file, recognised by its extension or its first lines; `None` for PDL and all other texts.
fn of_benchmark(path: &Path) -> MissionResult<Option<PlanInput>> {
    let extension = path.extension().map(|extension| extension.to_string_lossy().to_lowercase()).unwrap_or_default();
    if extension == "pdl" {
        return Ok(None);
    }
    let text = read_text(path)?;
    if !BENCHMARKS.contains(&extension.as_str()) && !formats::is_one(&text) {
        return Ok(None);
    }
    let name = path.file_stem().map_or_else(|| "problem".into(), |name| name.to_string_lossy().into_owned());
    let instance = formats::read(&name, &text).map_err(|trouble| {
        let place = format!("{}:{}:{}", path.display(), trouble.line, trouble.column);
        MissionError::planning(format!("{place}: {}\n  {}", trouble.message, trouble.text.trim()))
            .because(trouble.reason)
            .help(trouble.help)
    })?;
    let formats::Instance { name, format, question, vehicles, problem } = instance;
    let benchmark = Some(Benchmark { format, asked: question, vehicles });
    Ok(Some(PlanInput { benchmark, ..PlanInput::new(name, Problem::SingleVisit(problem)) }))
}

/// Returns the goal and budget of the mission's first declared solver.
fn goal_and_budget(mission: &Mission) -> (Value, Duration) {
    let declared = mission.library.solvers.first();
    let budget = declared.and_then(|solver| solver.budget.as_ref()).and_then(|budget| match &budget.kind {
        apex_model::expression::ExprKind::Constant(Value::Duration(duration)) => Some(*duration),
        _ => None,
    });
    let goal = declared.and_then(|solver| ground(&solver.index));
    (goal.unwrap_or_else(|| Value::list([Value::symbol("plan")])), budget.unwrap_or(BUDGET_DEFAULT))
}

/// Returns the goal that an index without variables serves.
fn ground(index: &apex_model::pattern::Pattern) -> Option<Value> {
    use apex_model::pattern::Pattern;
    match index {
        Pattern::Literal(value) => Some(value.clone()),
        Pattern::List(items) => items.iter().map(ground).collect::<Option<Vec<_>>>().map(Value::list),
        _ => None,
    }
}
