//! Deliberation for a mission: pose the problem, choose and run a solver, check its plan, translate it into PDL.

use super::bookkeeping::{SharedBookkeeping, lock};
pub use super::problem::visit_altitude_m;
use super::problem::{NoPlan, here, pose, survey};
use super::{Mission, people};
use apex_model::effect::SolveRequest;
use apex_model::event::PlannedProcedure;
use apex_model::expression::Template;
use apex_model::problem::{Plan, Position, Problem, SingleVisitPlan, SingleVisitProblem, SurveillancePlan};
use apex_model::solver::{time_of, units_in};
use apex_model::source::SourceFile;
use apex_model::symbol::Symbol;
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
use apex_runtime::invocation::{Invocations, Limits};
use apex_runtime::limits::{SOLVER_MEMORY_BYTES, SOLVER_PATIENCE};
use apex_runtime::ports::{Deliberator, SolverAnswer, Withdrawal};
use apex_runtime::record::TargetState;
use apex_sim::Airframe;
use apex_solvers::{ProfileTable, Registry, Selection};
use std::sync::Arc;

/// Deliberation time where neither the mission nor the request says one.
const BUDGET_DEFAULT: Duration = Duration(10_000_000_000);

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
    /// Processor seconds; none where the system does not tell.
    pub cpu_s: Option<f64>,
    /// Where and when the plan begins; none for the mission's start.
    pub from: Option<(Position, Time)>,
    /// People plan such missions better, says the profile table.
    pub people_plan_better: bool,
}

/// Plans for one mission.
pub struct MissionDeliberator {
    mission: Arc<Mission>,
    books: SharedBookkeeping,
    means: Means,
    invocations: Invocations,
    /// The plan that is flown now, and when it was made.
    flown: Option<(Plan, Time)>,
    made: u32,
}

impl MissionDeliberator {
    /// A deliberator that knows the mission and, through the books, what has been achieved.
    pub fn new(mission: Arc<Mission>, books: SharedBookkeeping, means: Means) -> MissionDeliberator {
        MissionDeliberator { mission, books, means, invocations: Invocations::new(), flown: None, made: 0 }
    }
}

impl Deliberator for MissionDeliberator {
    fn deliberate(&mut self, request: &SolveRequest, at: Time, withdrawal: &Withdrawal) -> SolverAnswer {
        let budget = request.budget.unwrap_or(BUDGET_DEFAULT);
        let wanted = (!request.solver.is("auto")).then(|| request.solver.folded().to_string());
        // A copy: whoever flies writes into the books while the problem is posed.
        let books = lock(&self.books).clone();
        let believed = books.news.believed(&self.mission);
        let (posed, start) = (pose(&self.mission, &books, at), here(&self.mission, &books));
        for unknown in books.news.unknown(&self.mission) {
            lock(&self.books).note_once(at, &unknown);
        }
        let solved = posed.and_then(|problem| {
            let previous = self.flown.clone().map(|(plan, made)| ahead(plan, at - made));
            let (solver, seed) = (wanted.as_deref(), self.mission.settings.seed);
            let means = people::means(&self.means, solver, &books.news).map_err(NoPlan::Fault)?;
            let wish = Wish { means: &means, solver, budget, seed, previous };
            solve(problem, wish, &mut self.invocations, withdrawal)
        });
        match solved {
            Err(NoPlan::NothingLeft(reason)) if lock(&self.books).observed().next().is_some() => {
                self.made += 1;
                SolverAnswer { result: Ok(nothing_more(&request.goal, self.made, &reason)), charged: Duration::ZERO }
            }
            Err(none) => SolverAnswer { result: Err(none.to_string()), charged: Duration::ZERO },
            Ok(mut solved) => {
                solved.from = Some((start, at));
                name_obstacles(&believed, &mut solved);
                self.made += 1;
                if !withdrawal.is_withdrawn() {
                    self.tell_targets(&solved.plan, at);
                    self.flown = Some((solved.plan.clone(), at));
                }
                let charged = time_of(solved.work);
                let result = translate(&solved, &request.goal, self.made, &believed);
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

/// What is left of a plan `elapsed` after it was made. Problems of surveillance begin at their own now, the others at the mission's.
fn ahead(plan: Plan, elapsed: Duration) -> Plan {
    match plan {
        Plan::SingleVisit(plan) => Plan::SingleVisit(plan),
        Plan::Surveillance(mut plan) => {
            plan.visits.retain(|visit| visit.end_s > elapsed.seconds());
            Plan::Surveillance(plan)
        }
    }
}

/// Who may plan, and what they may take of the machine.
#[derive(Clone)]
pub struct Means {
    /// The planners that there are.
    pub planners: Arc<Registry>,
    /// By which one is chosen; none is the table that ships.
    pub table: Option<Arc<ProfileTable>>,
    /// Wall time until a solver is given up.
    pub patience: std::time::Duration,
    /// Bytes by which the program may grow while a solver works.
    pub memory_bytes: u64,
}

impl Means {
    /// These planners, with the limits where nobody sets others.
    pub fn of(planners: &Arc<Registry>) -> Means {
        Means {
            planners: Arc::clone(planners),
            table: None,
            patience: SOLVER_PATIENCE,
            memory_bytes: SOLVER_MEMORY_BYTES,
        }
    }
}

/// How a problem shall be solved.
pub struct Wish<'a> {
    /// By whom, and by what means.
    pub means: &'a Means,
    /// One of them; none lets the profile table choose.
    pub solver: Option<&'a str>,
    /// How long it may take.
    pub budget: Duration,
    /// Seed of its chance.
    pub seed: u64,
    /// The plan that is flown now.
    pub previous: Option<Plan>,
}

/// Chooses a solver (or takes the wanted one), runs it contained and within its budget, and checks its plan.
///
/// # Errors
/// A sentence when no solver serves the problem, none finds a plan, or the plan does not pass the checker.
pub fn solve(
    problem: Problem,
    wish: Wish<'_>,
    invocations: &mut Invocations,
    withdrawal: &Withdrawal,
) -> Result<Deliberation, NoPlan> {
    let units = units_in(wish.budget);
    let Selection { solver: name, mut reason, people_plan_better } = match (wish.solver, &wish.means.table) {
        (Some(name), _) => {
            Selection { solver: name.to_string(), reason: "asked for by name".to_string(), people_plan_better: false }
        }
        (None, Some(table)) => table.select(&problem, units),
        (None, None) => apex_solvers::select_within(&problem, units),
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
    let limits = Limits { units, patience: wish.means.patience, memory_bytes: wish.means.memory_bytes };
    let answer = invocations.solve(solver, &problem, wish.previous, wish.seed, limits, withdrawal);
    // Who misbehaves and has no plan does not say that nothing is left.
    let misconduct = answer.misconduct;
    let no_plan = |why| if misconduct.is_some() { NoPlan::Fault(why) } else { NoPlan::NothingLeft(why) };
    let mut plan = answer.plan.map_err(no_plan)?;
    usable(&name, &problem, &plan).map_err(NoPlan::Fault)?;
    if let Some(misconduct) = misconduct {
        reason = format!("{reason}; {misconduct}, and its best plan until then is used");
    }
    apex_solvers::bound::state(&problem, &mut plan);
    let problem = Arc::unwrap_or_clone(problem);
    let (work, cpu_s) = (answer.used.min(units), answer.cpu_s);
    Ok(Deliberation { problem, plan, reason, work, cpu_s, from: None, people_plan_better })
}

/// Visits of a plan that are looked at: more than any mission has room for. Without a limit, checking nonsense could take as long
/// as whoever made it likes.
pub(crate) const PLAN_VISITS_MAX: usize = 100_000;

/// The checker's word.
fn usable(name: &str, problem: &Problem, plan: &Plan) -> Result<(), String> {
    let visits = plan.targets().len();
    if visits > PLAN_VISITS_MAX {
        return Err(format!("the plan of `{name}` has {visits} visits, more than {PLAN_VISITS_MAX}, and is not used"));
    }
    let violations = apex_solvers::checker::violations(problem, plan);
    match violations.first() {
        None => Ok(()),
        Some(first) => Err(format!(
            "the plan of `{name}` breaks {} rule{} and is not used; the first: it {first}",
            violations.len(),
            if violations.len() == 1 { "" } else { "s" }
        )),
    }
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

/// Says of sites left out because they lie in a restricted area, in which.
pub fn name_obstacles(mission: &Mission, solved: &mut Deliberation) {
    let Plan::Surveillance(plan) = &mut solved.plan else { return };
    let sites: Vec<&super::Target> =
        mission.targets.iter().filter(|target| matches!(target.kind, super::TargetKind::Site(_))).collect();
    let positions: Vec<Position> = sites.iter().map(|target| target.position).collect();
    let (start, begin) = solved.from.unwrap_or((mission.start, Time::ZERO));
    let Ok(ways) = survey(mission, &positions, start, begin.seconds()) else { return };
    for left_out in &mut plan.left_out {
        let site = sites.iter().position(|target| target.id == left_out.target);
        if let Some(trouble) = site.and_then(|site| ways.trouble(site)) {
            left_out.reason = trouble.to_string();
        }
    }
}

/// The plan as a procedure for `goal`.
pub fn translate(solved: &Deliberation, goal: &Value, number: u32, mission: &Mission) -> PlannedProcedure {
    let (mut steps, repeat) = match (&solved.problem, &solved.plan) {
        (Problem::SingleVisit(problem), Plan::SingleVisit(plan)) => (single_visit_steps(problem, plan), false),
        (_, Plan::Surveillance(plan)) => surveillance_steps(plan, mission, solved.from),
        (Problem::Surveillance(_), Plan::SingleVisit(_)) => (Vec::new(), false),
    };
    if solved.people_plan_better {
        steps.insert(0, people::step(goal, solved.plan.summary()));
    }
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
    let mut ready_s = problem.start_s;
    for visit in &plan.visits {
        let target = problem.targets.iter().find(|target| target.name == visit.target);
        let Some(manoeuvre) = target.and_then(|target| target.manoeuvres.get(visit.manoeuvre)) else { continue };
        hold(&mut steps, &visit.route, altitude_m, visit.depart_s - ready_s);
        ready_s = visit.end_s;
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
    hold(&mut steps, &plan.return_route, altitude_m, plan.return_depart_s - ready_s);
    detour(&mut steps, &plan.return_route, altitude_m);
    steps
}

/// Staying where a route begins until it is open; nothing for less than a second.
fn hold(steps: &mut Vec<(Symbol, Value)>, route: &[Position], altitude_m: f64, seconds: f64) {
    let Some(here) = route.first().filter(|_| seconds >= 1.0) else { return };
    let tag = Symbol::new(&format!("hold-{}", steps.len() + 1));
    let time = Value::Duration(Duration::from_seconds(seconds.round()));
    let words = [Value::symbol("loiter"), Value::symbol("at"), at(*here, altitude_m), Value::symbol("for"), time];
    steps.push((tag, Value::list(words)));
}

/// Way points strictly between the ends of a route: the bends around airspace.
fn detour(steps: &mut Vec<(Symbol, Value)>, route: &[Position], altitude_m: f64) {
    let bends = route.len().saturating_sub(2);
    for bend in route.iter().skip(1).take(bends) {
        let tag = Symbol::new(&format!("around-{}", steps.len() + 1));
        steps.push((tag, Value::list([Value::symbol("fly"), Value::symbol("to"), at(*bend, altitude_m)])));
    }
}

fn surveillance_steps(
    plan: &SurveillancePlan,
    mission: &Mission,
    from: Option<(Position, Time)>,
) -> (Vec<(Symbol, Value)>, bool) {
    let repeat = !plan.cycle.is_empty();
    let order: Vec<&String> =
        if repeat { plan.cycle.iter().collect() } else { plan.visits.iter().map(|visit| &visit.target).collect() };
    let site = |target: &super::Target| match &target.kind {
        super::TargetKind::Site(site) => Some((target.clone(), site.dwell_s)),
        _ => None,
    };
    let sites: Vec<(super::Target, f64)> = mission.targets.iter().filter_map(site).collect();
    let positions: Vec<Position> = sites.iter().map(|(target, _)| target.position).collect();
    let (start, begin) = from.unwrap_or((mission.start, Time::ZERO));
    let mut ways = survey(mission, &positions, start, begin.seconds()).ok();
    // A cycle is flown again and again by the ways of its first lap.
    let mut departs_s = vec![0.0];
    departs_s.extend(plan.visits.iter().map(|visit| visit.end_s));
    let mut route = |from: Option<usize>, to: usize, number: usize| {
        let depart_s = departs_s.get(number).or(departs_s.last()).copied().unwrap_or(0.0);
        ways.as_mut().map_or_else(Vec::new, |ways| ways.route(from, to, depart_s))
    };
    let mut order: Vec<usize> =
        order.iter().filter_map(|name| sites.iter().position(|(target, _)| target.id == **name)).collect();
    if repeat {
        // A cycle is flown again from its first site, so the way from the start is better one without bends.
        let open = order.iter().position(|site| route(None, *site, 0).len() == 2);
        order.rotate_left(open.unwrap_or(0));
    }
    // Who cannot hover looks from a circle around the site.
    let circles = mission.model.airframe == Airframe::FixedWing;
    let mut steps = Vec::new();
    let mut before = None;
    for (index, number) in order.iter().enumerate() {
        let Some((target, dwell_s)) = sites.get(*number) else { continue };
        let altitude_m = visit_altitude_m(mission, target);
        if before.is_some() || !repeat {
            detour(&mut steps, &route(before, *number, index), altitude_m);
        }
        before = Some(*number);
        let form = Value::list([
            Value::symbol("visit"),
            Value::symbol(&target.id),
            Value::symbol(if circles { "around" } else { "at" }),
            at(target.position, altitude_m),
            Value::symbol("for"),
            Value::Duration(Duration::from_seconds(*dwell_s)),
        ]);
        steps.push((Symbol::new(&format!("visit-{}-{}", index + 1, target.id)), form));
    }
    if let (true, Some(first), Some(last)) = (repeat, order.first(), order.last()) {
        let altitude_m = sites.get(*first).map_or(0.0, |(target, _)| visit_altitude_m(mission, target));
        detour(&mut steps, &route(Some(*last), *first, order.len()), altitude_m);
    }
    (steps, repeat)
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
    fn a_way_that_opens_later_is_waited_for_where_it_begins() {
        let here = Position::new(40.0, -120.0);
        let mut steps = Vec::new();
        hold(&mut steps, &[here, here], 7000.0, 0.5);
        assert_eq!(steps, []);
        hold(&mut steps, &[here, here], 7000.0, 90.2);
        let printed = apex_pdl::print_plan(&Value::symbol("go"), &steps, false);
        assert!(printed.contains("(step hold-1 (loiter at (40.0 -120.0 7000.0) for P1M30S))"), "{printed}");
    }

    #[test]
    fn a_fault_of_planning_does_not_pass_for_a_mission_with_nothing_left() {
        let means = Means::of(&Arc::new(Registry::shipped()));
        for solver in ["no-such-solver", "two-opt", "single-visit"] {
            let problem = Problem::SingleVisit(SingleVisitProblem::default());
            let budget = Duration::from_seconds(1.0);
            let wish = Wish { means: &means, solver: Some(solver), budget, seed: 1, previous: None };
            let solved = solve(problem, wish, &mut Invocations::new(), &Withdrawal::new());
            assert!(matches!(solved, Err(NoPlan::Fault(_))), "{solver}");
        }
    }
}
