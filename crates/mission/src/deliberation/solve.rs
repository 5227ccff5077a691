//! Solves a posed problem: chooses a planner, runs it isolated and within its budget, and checks its plan.

use crate::problem::{NoPlan, survey, trouble};
use crate::site_pictures::Daylight;
use crate::{Mission, Target, TargetKind};
use apex_model::problem::{LeftOut, Obstacle, Plan, Position, Problem, TimeLimit};
use apex_model::time::{Duration, Time};
use apex_planning::Registry;
use apex_planning::obstacle::LeftOutReason;
use apex_planning::solver::units_in;
use apex_portfolio::{ProfileTable, Selection};
use apex_runtime::invocation::{Invocations, SolverLimits};
use apex_runtime::limits::{SOLVER_MEMORY_BYTES, SOLVER_TIMEOUT};
use apex_runtime::ports::CancelToken;
use std::sync::Arc;

/// Result of one deliberation.
#[derive(Debug, Clone)]
pub struct Deliberation {
    /// The problem of the plan.
    pub problem: Problem,
    /// The problem of all plans, for bounds, if that of the plan excludes some: windows of looks may follow from looks that were planned
    /// before, and the worth of images from the plan's own landing.
    pub whole: Option<Problem>,
    /// The plan, checked.
    pub plan: Plan,
    /// Reason for the choice of the solver.
    pub reason: String,
    /// Work units used.
    pub work: u64,
    /// Processor seconds; `None` if the system does not report them.
    pub cpu_s: Option<f64>,
    /// Position and instant at which the plan begins; `None`: the mission's start.
    pub from: Option<(Position, Time)>,
    /// True if operators plan such missions better according to the profile table.
    pub people_plan_better: bool,
}

/// Planners, with the limits of their wall time and memory.
#[derive(Clone)]
pub struct PlanningResources {
    /// All registered planners.
    pub planners: Arc<Registry>,
    /// Profile table for the choice; `None` for the shipped one.
    pub table: Option<Arc<ProfileTable>>,
    /// Wall time until a solver is abandoned.
    pub timeout: std::time::Duration,
    /// Bytes by which the program may grow while a solver works.
    pub memory_bytes: u64,
}

impl PlanningResources {
    /// Returns resources with these planners and the default limits.
    pub fn of(planners: &Arc<Registry>) -> PlanningResources {
        PlanningResources {
            planners: Arc::clone(planners),
            table: None,
            timeout: SOLVER_TIMEOUT,
            memory_bytes: SOLVER_MEMORY_BYTES,
        }
    }
}

/// Options of a solution.
pub struct SolveOptions<'a> {
    /// Planners and their resources.
    pub means: &'a PlanningResources,
    /// Name of the planner; `None` lets the profile table choose.
    pub solver: Option<&'a str>,
    /// Deliberation time; the solver gets the corresponding work units.
    pub budget: Duration,
    /// Seed of the planner's random numbers.
    pub seed: u64,
    /// The plan that is flown now.
    pub previous: Option<Plan>,
}

/// Chooses a planner (or takes the requested one), runs it isolated and within its budget, and checks its plan.
///
/// # Errors
/// A message if no solver serves the problem, none finds a plan, or the plan does not pass the checker.
pub fn solve(
    problem: Problem,
    wish: SolveOptions<'_>,
    invocations: &mut Invocations,
    cancel: &CancelToken,
) -> Result<Deliberation, NoPlan> {
    let units = units_in(wish.budget);
    let Selection { solver: name, mut reason, people_plan_better } = match (wish.solver, &wish.means.table) {
        (Some(name), _) => {
            Selection { solver: name.to_string(), reason: "asked for by name".to_string(), people_plan_better: false }
        }
        (None, Some(table)) => table.select(&problem, units, &wish.means.planners),
        (None, None) => apex_portfolio::select_within(&problem, units, &wish.means.planners),
    };
    let Some(solver) = wish.means.planners.find(&name) else {
        let names: Vec<&str> = wish.means.planners.iter().map(|solver| solver.name()).collect();
        let by = if wish.solver.is_none() { ", which the profile table chooses" } else { "" };
        return Err(NoPlan::Fault(format!("there is no solver `{name}`{by}; known are {}", names.join(", "))));
    };
    if !solver.serves(&problem) {
        return Err(NoPlan::Fault(format!("the solver `{name}` does not plan for this kind of problem")));
    }
    validate(&problem).map_err(NoPlan::Fault)?;
    let problem = Arc::new(problem);
    let limits = SolverLimits { units, timeout: wish.means.timeout, memory_bytes: wish.means.memory_bytes };
    let answer = invocations.solve(solver, &problem, wish.previous, wish.seed, limits, cancel);
    // If a planner misbehaved and has no plan, that does not mean that nothing is left to visit.
    let violation = answer.violation;
    let no_plan = |why| if violation.is_some() { NoPlan::Fault(why) } else { NoPlan::NothingLeft(why) };
    let mut plan = answer.plan.map_err(no_plan)?;
    usable(&name, &problem, &plan).map_err(NoPlan::Fault)?;
    if let Some(violation) = violation {
        reason = format!("{reason}; {violation}, and its best plan until then is used");
    }
    if let Err(contradiction) = apex_solvers::bounds::state(&problem, &mut plan) {
        // The plan passed the check and can be flown; only its bound is wrong.
        reason = format!("{reason}; {contradiction}");
    }
    tell_quality(&problem, &mut plan);
    let problem = Arc::unwrap_or_clone(problem);
    let (work, cpu_s) = (answer.used.min(units), answer.cpu_s);
    Ok(Deliberation { problem, whole: None, plan, reason, work, cpu_s, from: None, people_plan_better })
}

/// Copies the predicted quality of each visit's manoeuvre into the plan: the plan is kept, the problem is not.
fn tell_quality(problem: &Problem, plan: &mut Plan) {
    let (Problem::SingleVisit(problem), Plan::SingleVisit(plan)) = (problem, plan) else { return };
    for visit in &mut plan.visits {
        let target = problem.targets.iter().find(|target| target.name == visit.target);
        let manoeuvre = target.and_then(|target| target.manoeuvres.get(visit.manoeuvre));
        visit.quality = manoeuvre.map(|manoeuvre| manoeuvre.quality.clone());
    }
}

/// Maximum number of visits of a plan: more than any mission needs. A longer plan is refused unchecked, because a check could take
/// arbitrarily long.
pub const PLAN_VISITS_MAX: usize = 100_000;

/// Returns the verdict of the checker.
fn usable(name: &str, problem: &Problem, plan: &Plan) -> Result<(), String> {
    let visits = plan.targets().len();
    if visits > PLAN_VISITS_MAX {
        return Err(format!("the plan of `{name}` has {visits} visits, more than {PLAN_VISITS_MAX}, and is not used"));
    }
    let violations = apex_planning::checker::violations(problem, plan);
    match violations.first() {
        None => Ok(()),
        Some(first) => Err(format!(
            "the plan of `{name}` breaks {} rule{} and is not used; the first: it {first}",
            violations.len(),
            if violations.len() == 1 { "" } else { "s" }
        )),
    }
}

/// Checks the problem: an invalid problem is an error, and not a mission with nothing left to visit.
///
/// # Errors
/// A message that names the target and the field.
pub fn validate(problem: &Problem) -> Result<(), String> {
    match problem {
        Problem::Surveillance(problem) => apex_planning::validate::surveillance(problem),
        Problem::SingleVisit(problem) => apex_planning::validate::single_visit(problem),
    }
}

/// States the reasons of left-out targets: the link is weak there, they are in a restricted area, or no manoeuvre can observe them.
pub fn name_obstacles(mission: &Mission, solved: &mut Deliberation) {
    name_obstacles_of(mission, solved, &|_| true);
}

/// Like [`name_obstacles`], for the looks that are still open.
pub(super) fn name_obstacles_of(mission: &Mission, solved: &mut Deliberation, is_open: &dyn Fn(&str) -> bool) {
    name_zones(mission, solved);
    name_pictures(mission, solved);
    name_unseen(mission, solved, is_open);
    let left_out = match &mut solved.plan {
        Plan::Surveillance(plan) => &mut plan.left_out,
        Plan::SingleVisit(plan) => &mut plan.left_out,
    };
    let targets = mission.targets.iter();
    for (target, reason) in targets.filter_map(|target| Some((target, mission.weak_reason(&target.id)?))) {
        for (name, ..) in target.plan_names() {
            let reason = LeftOutReason::from(reason);
            match left_out.iter_mut().find(|left_out| left_out.target == name) {
                Some(left_out) => reason.replace_in(left_out),
                None => left_out.push(reason.of(name)),
            }
        }
    }
}

/// Lists the looks that are not in the problem because no manoeuvre can observe them, with the nearest possibility.
fn name_unseen(mission: &Mission, solved: &mut Deliberation, is_open: &dyn Fn(&str) -> bool) {
    let (Problem::SingleVisit(problem), Plan::SingleVisit(plan)) = (&solved.problem, &mut solved.plan) else { return };
    let is_posed = |name: &str| problem.targets.iter().any(|target| target.name == name);
    for target in mission.targets.iter().filter(|target| mission.weak_reason(&target.id).is_none()) {
        for (name, ..) in target.plan_names() {
            if !is_posed(&name)
                && is_open(&name)
                && let Some(why) = trouble(mission, target, &name)
            {
                plan.left_out.push(unobservable(&why).of(name));
            }
        }
    }
}

fn name_zones(mission: &Mission, solved: &mut Deliberation) {
    let Plan::Surveillance(plan) = &mut solved.plan else { return };
    let sites: Vec<&Target> =
        mission.targets.iter().filter(|target| matches!(target.kind, TargetKind::Site(_))).collect();
    let positions: Vec<Position> = sites.iter().map(|target| target.position).collect();
    let (start, begin) = solved.from.unwrap_or((mission.start, Time::ZERO));
    let Ok(ways) = survey(mission, &positions, start, begin.seconds()) else { return };
    for left_out in &mut plan.left_out {
        let site = sites.iter().position(|target| target.id == left_out.target);
        if let Some(trouble) = site.and_then(|site| ways.trouble(site)) {
            LeftOutReason::from(trouble.to_string()).replace_in(left_out);
        }
    }
}

/// States where visits of sites cannot give valid pictures: at no time, or outside of the daylight, which the summary names.
fn name_pictures(mission: &Mission, solved: &mut Deliberation) {
    let Plan::Surveillance(plan) = &mut solved.plan else { return };
    let now_s = solved.from.map_or(0.0, |(_, begin)| begin.seconds());
    let daylight = Daylight::next(mission, now_s).ok().flatten();
    for left_out in &mut plan.left_out {
        let site = mission.targets.iter().find(|target| target.id == left_out.target);
        if let Some(why) = site.and_then(|site| trouble(mission, site, &site.id)) {
            unobservable(&why).replace_in(left_out);
        } else if let Some(late) = daylight.as_ref().and_then(|daylight| in_daylight(left_out, daylight)) {
            late.replace_in(left_out);
        }
    }
    if let Some(daylight) = daylight {
        plan.summary = format!("{} {}", plan.summary, daylight.told(now_s));
    }
}

fn unobservable(why: &str) -> LeftOutReason {
    format!("no way to observe it: {why}").into()
}

/// Returns the reason with the daylight as its limit instead of the endurance; `None` if another obstacle keeps the target out.
fn in_daylight(left_out: &LeftOut, daylight: &Daylight) -> Option<LeftOutReason> {
    let Some(Obstacle::Late { over_s, limit: TimeLimit::Flight { is_energy: true, .. }, alone }) = left_out.obstacle
    else {
        return None;
    };
    let limit = TimeLimit::Flight { name: "the daylight".to_string(), cause: Some(daylight.cause()), is_energy: false };
    Some(Obstacle::Late { over_s, limit, alone }.into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use apex_model::problem::SingleVisitProblem;

    #[test]
    fn a_fault_of_planning_does_not_pass_for_a_mission_with_nothing_left() {
        let means = PlanningResources::of(&Arc::new(apex_solvers::shipped()));
        for solver in ["no-such-solver", "two-opt", "single-visit"] {
            let problem = Problem::SingleVisit(SingleVisitProblem::default());
            let budget = Duration::from_seconds(1.0);
            let wish = SolveOptions { means: &means, solver: Some(solver), budget, seed: 1, previous: None };
            let solved = solve(problem, wish, &mut Invocations::new(), &CancelToken::new());
            assert!(matches!(solved, Err(NoPlan::Fault(_))), "{solver}");
        }
    }
}
