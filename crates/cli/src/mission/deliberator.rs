//! Deliberation for a mission: pose the problem, choose and run a solver, check its plan, translate it into PDL.

use super::Mission;
use super::bookkeeping::{SharedBookkeeping, lock};
use super::problem::{NoPlan, pose};
use apex_model::effect::SolveRequest;
use apex_model::event::PlannedProcedure;
use apex_model::expression::Template;
use apex_model::problem::{Plan, Position, Problem, SingleVisitPlan, SingleVisitProblem, SurveillancePlan};
use apex_model::solver::{Environment, WorkBudget, time_of, units_in};
use apex_model::source::SourceFile;
use apex_model::symbol::Symbol;
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
use apex_runtime::ports::{Deliberator, SolverAnswer};
use apex_runtime::record::TargetState;
use std::sync::Arc;

/// Deliberation time where neither the mission nor the request says one.
const BUDGET_DEFAULT: Duration = Duration(10_000_000_000);

/// Height above ground from which a site is looked at.
const VISIT_HEIGHT_M: f64 = 60.0;

/// What one deliberation came to.
#[derive(Debug, Clone)]
pub struct Deliberation {
    /// The problem.
    pub problem: Problem,
    /// The plan, checked.
    pub plan: Plan,
    /// Why this solver.
    pub reason: String,
    /// Work units used.
    pub work: u64,
}

/// Plans for one mission.
pub struct MissionDeliberator {
    mission: Arc<Mission>,
    books: SharedBookkeeping,
    made: u32,
}

impl MissionDeliberator {
    /// A deliberator that knows the mission and, through the books, what has been achieved.
    pub fn new(mission: Arc<Mission>, books: SharedBookkeeping) -> MissionDeliberator {
        MissionDeliberator { mission, books, made: 0 }
    }
}

impl Deliberator for MissionDeliberator {
    fn deliberate(&mut self, request: &SolveRequest, at: Time) -> SolverAnswer {
        let budget = request.budget.unwrap_or(BUDGET_DEFAULT);
        let wanted = (!request.solver.is("auto")).then(|| request.solver.folded().to_string());
        let solved = {
            let books = lock(&self.books);
            pose(&self.mission, &books, at)
        }
        .and_then(|problem| solve(problem, wanted.as_deref(), budget, self.mission.settings.seed));
        match solved {
            Err(NoPlan::NothingLeft(reason)) if lock(&self.books).observed().next().is_some() => {
                self.made += 1;
                SolverAnswer { result: Ok(nothing_more(&request.goal, self.made, &reason)), charged: Duration::ZERO }
            }
            Err(none) => SolverAnswer { result: Err(none.to_string()), charged: Duration::ZERO },
            Ok(solved) => {
                self.made += 1;
                self.tell_targets(&solved.plan, at);
                let charged = time_of(solved.work);
                let result = translate(&solved, &request.goal, self.made, &self.mission);
                SolverAnswer { result: Ok(result), charged: charged.min(budget) }
            }
        }
    }
}

impl MissionDeliberator {
    /// Targets in the plan become `planned`, those left out `skipped` with the reason.
    fn tell_targets(&self, plan: &Plan, at: Time) {
        let mut books = lock(&self.books);
        let visits: Vec<(String, String)> = match plan {
            Plan::SingleVisit(plan) => plan
                .visits
                .iter()
                .map(|visit| {
                    (visit.target.clone(), format!("planned for {}", Time::from_seconds(visit.begin_s.round())))
                })
                .collect(),
            Plan::Surveillance(plan) => {
                plan.cycle.iter().map(|target| (target.clone(), "in the cycle".to_string())).collect()
            }
        };
        for (target, detail) in visits {
            books.target_changes.push((target, at, TargetState::Planned, detail));
        }
        for left in plan.left_out() {
            books.target_changes.push((left.target.clone(), at, TargetState::Skipped, left.reason.clone()));
        }
    }
}

/// Chooses a solver (or takes the wanted one), runs it within `budget` and checks its plan.
///
/// # Errors
/// A sentence when no solver serves the problem, none finds a plan, or the plan does not pass the checker.
pub fn solve(problem: Problem, wanted: Option<&str>, budget: Duration, seed: u64) -> Result<Deliberation, NoPlan> {
    let allowed = units_in(budget);
    let selection = apex_solvers::table::select_within(&problem, allowed);
    let (name, reason) = match wanted {
        Some(name) => (name.to_string(), "asked for by name".to_string()),
        None => (selection.solver, selection.reason),
    };
    let solvers = apex_solvers::solvers();
    let Some(solver) = solvers.iter().find(|solver| solver.name() == name) else {
        let names: Vec<&str> = solvers.iter().map(|solver| solver.name()).collect();
        return Err(NoPlan::Fault(format!("there is no solver `{name}`; known are {}", names.join(", "))));
    };
    if !solver.serves(&problem) {
        return Err(NoPlan::Fault(format!("the solver `{name}` does not plan for this kind of problem")));
    }
    let mut work = WorkBudget::new(allowed);
    let mut report = |_: &Plan| {};
    let mut environment = Environment { seed, budget: &mut work, report: &mut report };
    validate(&problem).map_err(NoPlan::Fault)?;
    let mut plan = solver.solve(&problem, &mut environment).map_err(NoPlan::NothingLeft)?;
    let violations = apex_solvers::checker::violations(&problem, &plan);
    if let Some(first) = violations.first() {
        return Err(NoPlan::Fault(format!(
            "the plan of `{name}` breaks {} rules and is not used; the first: {first}",
            violations.len()
        )));
    }
    apex_solvers::bound::state(&problem, &mut plan);
    Ok(Deliberation { problem, plan, reason, work: work.used })
}

/// A problem that makes no sense is a fault, not a mission with nothing left to visit.
///
/// # Errors
/// A sentence that names the target and the field.
pub fn validate(problem: &Problem) -> Result<(), String> {
    match problem {
        Problem::Surveillance(problem) => apex_solvers::validate::surveillance(problem),
        Problem::SingleVisit(problem) => apex_solvers::validate::single_visit(problem),
    }
}

/// The plan as a procedure for `goal`.
pub fn translate(solved: &Deliberation, goal: &Value, number: u32, mission: &Mission) -> PlannedProcedure {
    let (steps, repeat) = match (&solved.problem, &solved.plan) {
        (Problem::SingleVisit(problem), Plan::SingleVisit(plan)) => (single_visit_steps(problem, plan), false),
        (_, Plan::Surveillance(plan)) => surveillance_steps(plan, mission),
        (Problem::Surveillance(_), Plan::SingleVisit(_)) => (Vec::new(), false),
    };
    let name = format!("<plan {number}>");
    let procedure = apex_pdl::print_plan(goal, &steps, repeat);
    let text = format!("; {}\n; {}\n{procedure}", solved.plan.summary(), solved.reason);
    PlannedProcedure {
        solver: Symbol::new(solved.plan.solver()),
        summary: solved.plan.summary().to_string(),
        steps: steps.into_iter().map(|(tag, step)| (tag, Template::Constant(step))).collect(),
        repeat,
        source: SourceFile { name: name.into(), text: text.into() },
    }
}

/// The plan of a mission in progress for which nothing more can be planned: it ends, and the way back begins.
fn nothing_more(goal: &Value, number: u32, reason: &str) -> PlannedProcedure {
    let summary = format!("nothing more to visit. {reason}");
    let text = format!("; {summary}\n{}", apex_pdl::print_plan(goal, &[], false));
    PlannedProcedure {
        solver: Symbol::new("single-visit"),
        summary,
        steps: Vec::new(),
        repeat: false,
        source: SourceFile { name: format!("<plan {number}>").into(), text: text.into() },
    }
}

fn single_visit_steps(problem: &SingleVisitProblem, plan: &SingleVisitPlan) -> Vec<(Symbol, Value)> {
    let mut steps = Vec::new();
    let mut altitude_m = problem.vehicle.cruise_altitude_m;
    for visit in &plan.visits {
        let target = problem.targets.iter().find(|target| target.name == visit.target);
        let Some(manoeuvre) = target.and_then(|target| target.manoeuvres.get(visit.manoeuvre)) else { continue };
        detour(&mut steps, &visit.route, altitude_m);
        altitude_m = manoeuvre.altitude_m;
        let lines = manoeuvre.lines.iter().map(|(from, to)| Value::list([at(*from, altitude_m), at(*to, altitude_m)]));
        let form = Value::list([
            Value::symbol("observe"),
            Value::symbol(&visit.target),
            Value::symbol("along"),
            Value::list(lines),
            Value::symbol("due"),
            Value::Duration(Duration::from_seconds(visit.end_s.round())),
        ]);
        steps.push((Symbol::new(&format!("observe-{}", visit.target)), form));
    }
    detour(&mut steps, &plan.return_route, altitude_m);
    steps
}

/// Way points strictly between the ends of a route: the bends around airspace.
fn detour(steps: &mut Vec<(Symbol, Value)>, route: &[Position], altitude_m: f64) {
    let bends = route.len().saturating_sub(2);
    for bend in route.iter().skip(1).take(bends) {
        let tag = Symbol::new(&format!("around-{}", steps.len() + 1));
        steps.push((tag, Value::list([Value::symbol("fly"), Value::symbol("to"), at(*bend, altitude_m)])));
    }
}

fn surveillance_steps(plan: &SurveillancePlan, mission: &Mission) -> (Vec<(Symbol, Value)>, bool) {
    let repeat = !plan.cycle.is_empty();
    let order: Vec<&String> =
        if repeat { plan.cycle.iter().collect() } else { plan.visits.iter().map(|visit| &visit.target).collect() };
    let mut steps = Vec::new();
    for (index, name) in order.into_iter().enumerate() {
        let Some(target) = mission.targets.iter().find(|target| target.id == *name) else { continue };
        let super::TargetKind::Site(site) = &target.kind else { continue };
        let form = Value::list([
            Value::symbol("visit"),
            Value::symbol(name),
            Value::symbol("at"),
            at(target.position, visit_altitude_m(target)),
            Value::symbol("for"),
            Value::Duration(Duration::from_seconds(site.dwell_s)),
        ]);
        steps.push((Symbol::new(&format!("visit-{}-{name}", index + 1)), form));
    }
    (steps, repeat)
}

/// Altitude above mean sea level from which a site is looked at.
pub fn visit_altitude_m(site: &super::Target) -> f64 {
    site.elevation_m + VISIT_HEIGHT_M
}

/// A location rounded to about a metre, so that plans stay readable.
fn at(position: Position, altitude_m: f64) -> Value {
    let round = |degrees: f64| (degrees * 1e5).round() / 1e5;
    Value::list([
        Value::Real(round(position.latitude_deg)),
        Value::Real(round(position.longitude_deg)),
        Value::Real(altitude_m.round()),
    ])
}

#[cfg(test)]
mod tests {
    use super::*;
    use apex_model::problem::SingleVisitProblem;

    #[test]
    fn a_fault_of_planning_does_not_pass_for_a_mission_with_nothing_left() {
        let budget = Duration::from_seconds(1.0);
        let senseless = || Problem::SingleVisit(SingleVisitProblem::default());
        assert!(matches!(solve(senseless(), Some("no-such-solver"), budget, 1), Err(NoPlan::Fault(_))));
        assert!(matches!(solve(senseless(), Some("two-opt"), budget, 1), Err(NoPlan::Fault(_))));
        assert!(matches!(solve(senseless(), Some("single-visit"), budget, 1), Err(NoPlan::Fault(_))));
    }
}
