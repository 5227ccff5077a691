//! What `apex plan` is asked: a mission, a problem in a file (JSON, or a benchmark's format), or a test mission by the name
//! of its cell.

use crate::options::PlanOptions;
use crate::plan_output::proof;
use crate::sources::parse_time;
use crate::trouble::{Outcome, Trouble, nearby_help, read_text};
use apex_mission::Mission;
use apex_mission::deliberation::validate;
use apex_mission::problem::pose;
use apex_mission::situation::Situation;
use apex_model::problem::{Position, Problem};
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
use apex_planning::validate::TARGETS_MAX;
use apex_portfolio::cell::Cell;
use apex_portfolio::formats;
use std::path::Path;

/// Deliberation time where nobody says one.
const BUDGET_DEFAULT: Duration = Duration(10_000_000_000);

/// A problem with what is needed to plan for it.
pub(super) struct Question {
    /// What it is called.
    pub(super) name: String,
    /// The problem.
    pub(super) problem: Problem,
    /// How long solvers may take.
    pub(super) budget: Duration,
    /// What proofs of bounds may take.
    pub(super) bound_budget: Duration,
    /// Seed of solvers' chance.
    pub(super) seed: u64,
    /// The mission and its goal, if it is one's.
    pub(super) mission: Option<(Mission, Value)>,
    /// What a benchmark's file says beside the problem.
    pub(super) benchmark: Option<Benchmark>,
    /// Where the flight begins, if the problem does not say it.
    pub(super) start: Option<Position>,
}

impl Question {
    /// A problem by itself.
    fn new(name: String, problem: Problem) -> Question {
        let (budget, bound_budget) = (BUDGET_DEFAULT, proof::BUDGET_DEFAULT);
        Question { name, problem, budget, bound_budget, seed: 1, mission: None, benchmark: None, start: None }
    }
}

/// What a benchmark's file says beside the problem.
pub(crate) struct Benchmark {
    /// The format, in words.
    pub(crate) format: &'static str,
    /// What is asked.
    pub(crate) asked: formats::Question,
    /// Vehicles that the file names.
    pub(crate) vehicles: Option<usize>,
}

/// Extensions of benchmark files; other files are looked into.
const BENCHMARKS: &[&str] = &["toptw", "optw", "txt", "oplib", "op", "tsp", "atsp"];

/// Finds out what is asked.
///
/// # Errors
/// When nothing of that name exists, or it is no problem.
pub(super) fn read(options: &PlanOptions) -> Outcome<Question> {
    let path = options.mission.as_path();
    let text = path.to_string_lossy();
    let mut question = if !path.exists() && !text.contains(['/', '\\', '.']) {
        of_cell(&text)?
    } else if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("json")) {
        of_file(path)?
    } else if path.is_file() {
        of_benchmark(path)?
    } else {
        of_mission(path)?
    };
    refuse_fleets(options.vehicles, &question)?;
    if let Some(budget) = &options.budget {
        let end = parse_time(budget, "--budget")?;
        if end <= Time::ZERO {
            return Err(Trouble::user(format!("a budget of {budget} is no time to plan in"))
                .help("write how long a solver may take, for example `--budget 2s`"));
        }
        question.budget = end - Time::ZERO;
    }
    if let Some(budget) = &options.bound_budget {
        let end = parse_time(budget, "--bound-budget")?;
        // Nothing to spend leaves the quick bound.
        question.bound_budget = end - Time::ZERO;
    }
    question.seed = options.seed.unwrap_or(question.seed);
    Ok(question)
}

/// A test mission: the name of its cell, with `@NUMBER` for another one than the first.
fn of_cell(text: &str) -> Outcome<Question> {
    let (cell, number) = text.split_once('@').unwrap_or((text, "0"));
    let cell: Cell = cell.parse().map_err(|why: String| no_such_name(text, cell, &why))?;
    let number: u64 = number.parse().map_err(|_| {
        Trouble::user(format!("{number} is no number of a test mission")).help(format!("write for example `{cell}@7`"))
    })?;
    let problem = Problem::Surveillance(cell.mission(number));
    let start = Some(apex_portfolio::test_missions::CENTRE);
    Ok(Question { start, ..Question::new(format!("{cell}@{number}"), problem) })
}

/// Nothing is called so: the names that are nearest, and where names are listed.
fn no_such_name(text: &str, cell: &str, why: &str) -> Trouble {
    let trouble = Trouble::user(format!("there is no mission, file or test mission called {text}"));
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

/// Edits between a misspelt name and a known one at most, as a share of its length.
const MISSPELT_SHARE_MAX: f64 = 0.4;

/// The cell whose name is nearest to `text`, if any is near; the count stays as it is given.
fn nearest_cell(text: &str) -> Option<Cell> {
    let count = text.split('-').find_map(|part| part.parse().ok()).filter(|count| (1..=TARGETS_MAX).contains(count));
    let cells = Cell::all().into_iter().map(|cell| Cell { count: count.unwrap_or(cell.count), ..cell });
    let letters = text.chars().count();
    // A name that is far too long is compared with nothing.
    let near = |cell: Cell| (strsim::damerau_levenshtein(&cell.to_string(), text), cell);
    let (edits, cell) = (letters <= 80).then(|| cells.map(near).min_by_key(|(edits, _)| *edits)).flatten()?;
    (edits as f64 <= MISSPELT_SHARE_MAX * letters as f64).then_some(cell)
}

fn of_file(path: &Path) -> Outcome<Question> {
    let mut question = of_text(&read_text(path)?, &path.display().to_string())?;
    question.name = path.file_stem().map_or(question.name, |name| name.to_string_lossy().into_owned());
    Ok(question)
}

/// A problem in JSON; `place` says in messages where it stands.
pub(super) fn of_text(text: &str, place: &str) -> Outcome<Question> {
    let problem: Problem = serde_json::from_str(text).map_err(|error| {
        let place = format!("{place}:{}:{}", error.line(), error.column());
        Trouble::user(format!("{place}: this is no planning problem"))
            .because(error)
            .help("docs/reference/planning-problems.md says what a problem holds; `apex plan small-fixed-fixed-4-uniform --problem` prints one")
    })?;
    validate(&problem).map_err(|reason| {
        Trouble::user(format!("{place}: the problem makes no sense"))
            .because(reason)
            .help("docs/reference/schema/planning-problem.schema.json says what each member may hold")
    })?;
    Ok(Question::new("problem".into(), problem))
}

/// A file that is neither JSON nor, perhaps, PDL: a benchmark's, if its extension or its first lines say so.
fn of_benchmark(path: &Path) -> Outcome<Question> {
    let extension = path.extension().map(|extension| extension.to_string_lossy().to_lowercase()).unwrap_or_default();
    if extension == "pdl" {
        return of_mission(path);
    }
    let text = read_text(path)?;
    if !BENCHMARKS.contains(&extension.as_str()) && !formats::is_one(&text) {
        return of_mission(path);
    }
    let name = path.file_stem().map_or_else(|| "problem".into(), |name| name.to_string_lossy().into_owned());
    let instance = formats::read(&name, &text).map_err(|trouble| {
        let place = format!("{}:{}:{}", path.display(), trouble.line, trouble.column);
        Trouble::user(format!("{place}: {}\n  {}", trouble.message, trouble.text.trim()))
            .because(trouble.reason)
            .help(trouble.help)
    })?;
    let formats::Instance { name, format, question, vehicles, problem } = instance;
    let benchmark = Some(Benchmark { format, asked: question, vehicles });
    Ok(Question { benchmark, ..Question::new(name, Problem::SingleVisit(problem)) })
}

/// Plans are for one vehicle; whoever asks for more is told.
fn refuse_fleets(vehicles: Option<usize>, question: &Question) -> Outcome {
    match vehicles {
        None | Some(1) => Ok(()),
        Some(more) => {
            let named = question.benchmark.as_ref().and_then(|benchmark| benchmark.vehicles);
            let reason = match named {
                Some(named) => format!("a plan is the path of one vehicle, though the file names {named}"),
                None => "a plan is the path of one vehicle".to_string(),
            };
            Err(Trouble::user(format!("{more} vehicles cannot be planned for"))
                .because(reason)
                .help("leave `--vehicles` out to plan for one"))
        }
    }
}

fn of_mission(path: &Path) -> Outcome<Question> {
    let mission = Mission::load(path)?;
    let (goal, budget) = goal_and_budget(&mission);
    let situation = Situation::default();
    let problem = pose(&situation.updates.believed(&mission), &situation, Time::ZERO)
        .map_err(|reason| Trouble::user("there is nothing to plan").because(reason))?;
    let (name, seed) = (mission.settings.name.clone(), mission.settings.seed);
    Ok(Question { budget, seed, mission: Some((mission, goal)), ..Question::new(name, problem) })
}

/// The goal and budget of the mission's first declared solver.
fn goal_and_budget(mission: &Mission) -> (Value, Duration) {
    let declared = mission.library.solvers.first();
    let budget = declared.and_then(|solver| solver.budget.as_ref()).and_then(|budget| match &budget.kind {
        apex_model::expression::ExprKind::Constant(Value::Duration(duration)) => Some(*duration),
        _ => None,
    });
    let goal = declared.and_then(|solver| ground(&solver.index));
    (goal.unwrap_or_else(|| Value::list([Value::symbol("plan")])), budget.unwrap_or(BUDGET_DEFAULT))
}

/// The goal that an index without variables serves.
fn ground(index: &apex_model::pattern::Pattern) -> Option<Value> {
    use apex_model::pattern::Pattern;
    match index {
        Pattern::Literal(value) => Some(value.clone()),
        Pattern::List(items) => items.iter().map(ground).collect::<Option<Vec<_>>>().map(Value::list),
        _ => None,
    }
}
