//! `apex plan`: prints the plan that a mission's planner makes from the start, without flying.

use crate::error::{CliError, CliResult};
use crate::options::{PlanFormat, PlanOptions};
use crate::sources::{parse_length_m, parse_time};
use crate::{output, sources, stopping};
use apex_mission::deliberation::{Deliberation, PlanningResources, SolveOptions, name_obstacles, solve_for_landing};
use apex_mission::export::chart::{Chart, chart};
use apex_mission::export::table::PlanFacts;
use apex_mission::export::{geojson, json, kml, qgc, table};
use apex_mission::plan::import::import;
use apex_mission::plan::input::{PlanInput, survival_cost};
use apex_mission::plan::problem_file;
use apex_mission::plan::proof;
use apex_mission::plan::turns;
use apex_model::problem::Problem;
use apex_model::time::Time;
use apex_planning::Registry;
use apex_runtime::invocation::Invocations;
use apex_runtime::ports::CancelToken;
use apex_solvers::planners::human::Human;
use std::path::Path;
use std::sync::Arc;

/// Advice if there is no plan.
const NO_PLAN_HELP: &str = "check the mission's data: `apex check MISSION`";
/// Advice if the planner of `--solver` has no plan.
const NO_PLAN_OF_SOLVER_HELP: &str =
    "check the mission's data, or leave `--solver` out so that the solver is chosen by the features of the mission";
/// Advice if an operator's visits are empty.
const NO_PLAN_BY_HAND_HELP: &str = "write the names of targets as in the mission, separated by commas";

/// Plans and prints.
pub fn run(options: &PlanOptions, planners: &Arc<Registry>) -> CliResult {
    let out = options.out.as_deref().filter(|path| path.as_os_str() != "-");
    let format = format_of(options, out);
    let height_m = options.height.as_deref().map(|text| parse_length_m(text, "--height")).transpose()?;
    if height_m.is_some() && format != PlanFormat::Qgc {
        return Err(CliError::user("`--height` is for plan files of QGroundControl")
            .help("add `--format qgc`, or leave `--height` out"));
    }
    let question = read(options, planners)?;
    if let Some(out) = out {
        refuse_to_overwrite(out, &options.mission)?;
        options.plan.iter().try_for_each(|plan| refuse_to_overwrite(out, plan))?;
    }
    if options.problem {
        return output::put(out, &format!("{}\n", problem_file::write(&question.problem)));
    }
    refuse(format, &question)?;
    if options.survival {
        refuse_survival(format, &question)?;
    }
    let mut solved = match &options.plan {
        Some(file) => import(file, options.retime, &question)?,
        None => planned(options, &question, planners)?,
    };
    if let Some((mission, _)) = &question.mission {
        name_obstacles(mission, &mut solved);
    }
    let is_stated = options.budget.is_none() || options.bound_budget.is_some();
    let bound_budget = if is_stated { question.bound_budget } else { question.bound_budget_after(solved.work) };
    let proven = proof::prove(&mut solved, question.is_tour(), bound_budget)?;
    let survival = if options.survival { Some(survival_cost(&solved)?) } else { None };
    let turns = turns::of(&solved.problem, &solved.plan, question.mission());
    let facts = PlanFacts { proven: &proven, turns, survival, air_changes: question.air_changes() };
    let text = match format {
        PlanFormat::Table => table::write(&question.name, question.benchmark.as_ref(), &solved, &facts),
        PlanFormat::Json => json::write(&question.name, question.benchmark.as_ref(), &solved, &facts),
        PlanFormat::Pdl => question.procedure_text(&solved),
        PlanFormat::Geojson => geojson::write(&charted(&question, &solved)?),
        PlanFormat::Kml => kml::write(&charted(&question, &solved)?),
        PlanFormat::Qgc => qgc::write(&charted(&question, &solved)?, height_m).map_err(|reason| {
            CliError::user(format!("{}: the plan cannot be a plan file of QGroundControl", question.name))
                .because(reason)
                .help("add `--height 60m` for a flight at 60 m above the start")
        })?,
    };
    output::put(out, &text)
}

/// Determines the input of planning.
///
/// # Errors
/// If nothing has that name, or it is not a problem.
fn read(options: &PlanOptions, planners: &Registry) -> CliResult<PlanInput> {
    let mut question = match PlanInput::find(&options.mission)? {
        Some(question) => question,
        None => PlanInput::of_mission(sources::load_mission(&options.mission, planners)?)?,
    };
    question.refuse_fleets(options.vehicles)?;
    if let Some(budget) = &options.budget {
        let end = parse_time(budget, "--budget")?;
        if end <= Time::ZERO {
            return Err(CliError::user(format!(
                "invalid value `{budget}` for `--budget`: expected a duration greater than zero"
            ))
            .help("write how long a solver may take, for example `--budget 2s`"));
        }
        question.budget = end - Time::ZERO;
    }
    if let Some(budget) = &options.bound_budget {
        let end = parse_time(budget, "--bound-budget")?;
        // A budget of 0 s is valid here: then only the fast bound is computed.
        question.bound_budget = end - Time::ZERO;
    }
    question.seed = options.seed.unwrap_or(question.seed);
    Ok(question)
}

/// Returns the answer of a solver, or the plan of the visits that an operator names.
fn planned(options: &PlanOptions, question: &PlanInput, planners: &Arc<Registry>) -> CliResult<Deliberation> {
    let by_hand = !options.visits.is_empty();
    let solver = if by_hand { Some("human") } else { options.solver.as_deref() };
    let no_plan_help = match solver {
        _ if by_hand => NO_PLAN_BY_HAND_HELP,
        Some(_) => NO_PLAN_OF_SOLVER_HELP,
        None => NO_PLAN_HELP,
    };
    let (budget, seed) = (question.budget, question.seed);
    let mut means = PlanningResources::of(planners);
    if by_hand {
        let mut planners = Registry::clone(planners);
        planners
            .add(Arc::new(Human { visits: options.visits.clone(), repeat: options.repeat }))
            .map_err(|reason| CliError::user("the visits of an operator cannot be planned").because(reason))?;
        means.planners = Arc::new(planners);
    }
    means.table = options.table.as_deref().map(super::profile::table).transpose()?;
    let wish = SolveOptions { means: &means, solver, budget, seed, previous: None };
    // On Ctrl-C the solver returns its best plan so far, which is a valid answer.
    let cancel = CancelToken::new();
    let token = cancel.clone();
    stopping::at_signal(move || token.cancel());
    solve_for_landing(question.mission(), question.problem.clone(), wish, &mut Invocations::new(), &cancel)
        .map_err(|reason| CliError::user("no plan was found").because(reason).help(no_plan_help))
}

/// Returns the requested format; otherwise that of the file name; otherwise a table.
fn format_of(options: &PlanOptions, out: Option<&Path>) -> PlanFormat {
    let extension = out.and_then(Path::extension).map(|extension| extension.to_string_lossy().to_lowercase());
    let of_name = || match extension.as_deref() {
        Some("json") => PlanFormat::Json,
        Some("pdl") => PlanFormat::Pdl,
        Some("geojson") => PlanFormat::Geojson,
        Some("kml") => PlanFormat::Kml,
        Some("plan") => PlanFormat::Qgc,
        _ => PlanFormat::Table,
    };
    if options.json { PlanFormat::Json } else { options.format.unwrap_or_else(of_name) }
}

fn refuse_to_overwrite(out: &Path, input: &Path) -> CliResult {
    let same = std::fs::canonicalize(out).ok().zip(std::fs::canonicalize(input).ok()).is_some_and(|(a, b)| a == b);
    if same {
        return Err(CliError::user(format!("{} is the source of the plan, and would be overwritten", out.display()))
            .help("name another file with `--out`"));
    }
    Ok(())
}

/// Rejects, before planning, an output that could not be written afterwards.
fn refuse(format: PlanFormat, question: &PlanInput) -> CliResult {
    match format {
        PlanFormat::Pdl if question.mission.is_none() => {
            Err(CliError::user("only a mission's plan can be a PDL procedure")
                .because("its goal, and the places and heights of its steps, come from a mission")
                .help("plan for a mission's folder, or choose another `--format`"))
        }
        PlanFormat::Qgc if question.benchmark.is_some() => {
            Err(CliError::user("the plan of a benchmark cannot be a plan file of QGroundControl")
                .because("its coordinates are those of a plane, not places on Earth")
                .help("choose `--format json` or `--format geojson`"))
        }
        _ => Ok(()),
    }
}

/// Rejects `--survival` for problems other than surveillance, which have no cost of ignorance, and for formats that do not hold it.
fn refuse_survival(format: PlanFormat, question: &PlanInput) -> CliResult {
    if !matches!(question.problem, Problem::Surveillance(_)) {
        return Err(CliError::user("`--survival` is for plans of surveillance")
            .because("single visits have no cost of ignorance")
            .help("leave `--survival` out"));
    }
    match format {
        PlanFormat::Table | PlanFormat::Json => Ok(()),
        _ => Err(CliError::user("`--survival` is for tables and JSON")
            .because("the other formats hold the flight only, without its cost")
            .help("leave `--survival` or `--format` out")),
    }
}

fn charted(question: &PlanInput, solved: &Deliberation) -> CliResult<Chart> {
    let mission = question.mission();
    chart(&question.name, (&solved.problem, &solved.plan), question.start, mission).map_err(|reason| {
        CliError::user(format!("{} has no places to put on a map", question.name))
            .because(reason)
            .help("choose `--format table` or `--format json`, or give its targets coordinates")
    })
}
