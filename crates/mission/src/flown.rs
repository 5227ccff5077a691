//! The plan that is flown when the mission plans again: where planners begin.
//!
//! It is the last plan that the executive took; an answer that nobody wanted any more is none. Before the first, it is the stored
//! procedure that was chosen for the goal, as `apex plan --format pdl` prints one: its steps are read back, others of its
//! steps do not count.

use super::Mission;
use super::bookkeeping::Bookkeeping;
use super::steps::observed_lines;
use apex_metrics::eci;
use apex_model::effect::{SolveRequest, SolveRequestId};
use apex_model::expression::Template;
use apex_model::limits::SOLVE_REQUESTS_MAX;
use apex_model::problem::{
    Plan, PlannedVisit, Problem, SingleVisitPlan, SingleVisitProblem, SurveillancePlan, SurveillanceProblem,
    SurveillanceVisit, UNREACHABLE_S,
};
use apex_model::procedure::{Activity, Procedure};
use apex_model::source::Place;
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
use std::collections::BTreeMap;

/// Who made a plan that is read from a stored procedure.
const STORED: &str = "stored";
/// Visits of such a plan at most.
const VISITS_MAX: usize = 10_000;

/// Plans that were made, and the one that is flown.
#[derive(Debug, Default)]
pub(super) struct Flown {
    /// Answers of which it is not known whether the executive takes them.
    answers: BTreeMap<SolveRequestId, (Plan, Time)>,
    /// The last one taken, and when it was made.
    taken: Option<(Plan, Time)>,
}

impl Flown {
    /// A request made at `at` is answered by this plan.
    pub(super) fn answered(&mut self, request: SolveRequestId, plan: Plan, at: Time) {
        self.answers.insert(request, (plan, at));
        // Those of which nothing was heard for long will not be taken.
        while self.answers.len() > SOLVE_REQUESTS_MAX {
            self.answers.pop_first();
        }
    }

    /// What is left at `at` of the plan that is flown for the request's goal, and how it came to be.
    pub(super) fn plan(
        &mut self,
        (mission, books): (&Mission, &Bookkeeping),
        request: &SolveRequest,
        problem: &Problem,
        at: Time,
    ) -> Option<(Plan, &'static str)> {
        if let Some(taken) = books.plan_taken.and_then(|taken| self.answers.remove(&taken)) {
            self.taken = Some(taken);
        }
        let made = self.taken.clone().map(|(plan, made)| (ahead(plan, at - made), "the plan that is flown"));
        made.or_else(|| Some((stored(mission, books, &request.goal, problem)?, "the stored plan that is flown")))
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

/// What is left of the stored procedure that was chosen for the goal, as a plan for the problem as it is now.
fn stored(mission: &Mission, books: &Bookkeeping, goal: &Value, problem: &Problem) -> Option<Plan> {
    let lap = Value::list([Value::symbol("one-cycle-of"), goal.clone()]);
    let chosen = |goal: &Value| {
        books.chosen.get(&goal.to_string()).and_then(|chosen| Some((chosen, procedure(mission, chosen.place)?)))
    };
    let (chosen, procedure, repeat) = match chosen(&lap) {
        Some((chosen, procedure)) => (chosen, procedure, true),
        None => chosen(goal).map(|(chosen, procedure)| (chosen, procedure, false))?,
    };
    let steps: Vec<Value> = procedure.steps.iter().filter_map(|step| visit(&step.activity)).collect();
    // Visits since then, as far as they are the procedure's.
    let mut done = 0;
    for seen in books.observed().filter(|visit| visit.begin >= chosen.since) {
        let next = if repeat { steps.get(done % steps.len().max(1)) } else { steps.get(done) };
        done += usize::from(next.and_then(target).is_some_and(|target| target == seen.target));
    }
    match problem {
        Problem::Surveillance(problem) => watched(problem, &steps, done, repeat).map(Plan::Surveillance),
        Problem::SingleVisit(problem) => visited(problem, steps.get(done..)?).map(Plan::SingleVisit),
    }
}

fn procedure(mission: &Mission, place: Place) -> Option<&Procedure> {
    mission.library.procedures.iter().map(AsRef::as_ref).find(|procedure| procedure.place == place)
}

/// The form of a step that visits a target: `(observe TARGET ..)` or `(visit TARGET ..)` without variables.
fn visit(activity: &Activity) -> Option<Value> {
    let Activity::Goal(Template::Constant(form)) = activity else { return None };
    let head = form.as_list()?.first()?.as_symbol()?;
    (head.is("observe") || head.is("visit")).then(|| form.clone())
}

fn target(form: &Value) -> Option<String> {
    form.as_list()?.get(1).map(ToString::to_string)
}

/// The visits from `done` on with their times from now on, until the horizon where they are repeated.
fn watched(problem: &SurveillanceProblem, steps: &[Value], done: usize, repeat: bool) -> Option<SurveillancePlan> {
    let index = |form: &Value| {
        let name = target(form)?;
        problem.targets.iter().position(|target| target.name == name)
    };
    let done = if repeat { done % steps.len().max(1) } else { done };
    let known = |steps: &[Value]| steps.iter().filter_map(index).collect::<Vec<usize>>();
    let (ahead, behind) = (known(steps.get(done..)?), known(steps.get(..done)?));
    let cycle: Vec<usize> = if repeat { ahead.iter().chain(&behind).copied().collect() } else { Vec::new() };
    let order = if repeat { cycle.iter().cycle().take(VISITS_MAX) } else { ahead.iter().cycle().take(ahead.len()) };
    let (mut visits, mut place, mut time_s) = (Vec::new(), None, 0.0);
    for target in order {
        let data = problem.targets.get(*target)?;
        let from_start = || problem.travel.start_to_at(*target, time_s);
        let travel_s = place.map_or_else(from_start, |from| problem.travel.between_at(from, *target, time_s));
        let arrive_s = time_s + travel_s;
        (place, time_s) = (Some(*target), arrive_s + data.dwell_s);
        if travel_s >= UNREACHABLE_S || time_s > problem.horizon_s {
            break;
        }
        visits.push(SurveillanceVisit { target: data.name.clone(), arrive_s, end_s: time_s });
    }
    let name = |target: &usize| problem.targets.get(*target).map(|target| target.name.clone());
    let cycle: Vec<String> = cycle.iter().filter_map(name).collect();
    (!visits.is_empty()).then(|| SurveillancePlan {
        solver: STORED.to_string(),
        cycle,
        return_s: None,
        expected_cost: eci::expected_cost(problem, &visits).total,
        expected_cost_bound: None,
        left_out: Vec::new(),
        summary: String::new(),
        visits,
    })
}

/// The observations, each in the manoeuvre whose lines the step flies, when the step expects it.
fn visited(problem: &SingleVisitProblem, steps: &[Value]) -> Option<SingleVisitPlan> {
    let mut visits = Vec::new();
    let mut ready_s = problem.start_s;
    for form in steps {
        let name = target(form);
        let Some(of) = problem.targets.iter().find(|target| Some(&target.name) == name.as_ref()) else { continue };
        let flies = |manoeuvre: &&apex_model::problem::Manoeuvre| {
            form.as_list()?.get(3).map(|lines| *lines == observed_lines(manoeuvre))
        };
        let number = of.manoeuvres.iter().position(|manoeuvre| flies(&manoeuvre) == Some(true)).unwrap_or(0);
        let Some(manoeuvre) = of.manoeuvres.get(number) else { continue };
        let due_s = form.as_list().and_then(|form| match form.get(5) {
            Some(Value::Duration(due)) => Some(due.seconds()),
            _ => None,
        });
        let end_s = due_s.unwrap_or(ready_s + manoeuvre.duration_s);
        let begin_s = end_s - manoeuvre.duration_s;
        let timing = of.timing_at(begin_s);
        visits.push(PlannedVisit {
            target: of.name.clone(),
            manoeuvre: number,
            route: Vec::new(),
            path: Vec::new(),
            depart_s: ready_s,
            arrive_s: begin_s,
            begin_s,
            end_s,
            timing,
            worth: of.value * manoeuvre.quality.product() * timing,
        });
        ready_s = end_s;
    }
    let benefits = visits.iter().map(|visit| visit.worth).sum();
    (!visits.is_empty()).then(|| SingleVisitPlan {
        solver: STORED.to_string(),
        visits,
        return_route: Vec::new(),
        return_path: Vec::new(),
        return_depart_s: ready_s,
        end_s: ready_s,
        fuel_used_kg: 0.0,
        benefits,
        costs: 0.0,
        score: benefits,
        benefits_bound: None,
        left_out: Vec::new(),
        summary: String::new(),
    })
}

#[cfg(test)]
mod tests;
