//! The plan in execution when the mission plans again: planners start from it.
//!
//! It is the last plan that the executive adopted; an answer that was not adopted does not count. Before the first adoption, it is the
//! stored procedure chosen for the goal, in the form that `apex plan --format pdl` prints: its known steps are read back, and its other
//! steps are ignored.

use crate::Mission;
use crate::situation::{MadePlan, Situation};
use apex_metrics::eci;
use apex_model::expression::Template;
use apex_model::planned::{Location, PlannedActivity};
use apex_model::problem::{
    Manoeuvre, Plan, PlannedVisit, Position, Problem, SingleVisitPlan, SingleVisitProblem, SurveillancePlan,
    SurveillanceProblem, SurveillanceVisit, UNREACHABLE_S,
};
use apex_model::procedure::{Activity, Procedure};
use apex_model::source::Place;
use apex_model::time::{Duration, Time};
use apex_model::value::Value;

/// Solver name of a plan that is read from a stored procedure.
const STORED: &str = "stored";
/// Maximum number of visits of such a plan.
const VISITS_MAX: usize = 10_000;

/// Returns the rest at `at` of the plan in execution for the goal, and its origin as text.
pub(super) fn current_plan(
    mission: &Mission,
    situation: &Situation,
    goal: &Value,
    problem: &Problem,
    at: Time,
) -> Option<(Plan, &'static str)> {
    match &situation.plan {
        Some(MadePlan { plan, made }) => Some((ahead(plan.clone(), at - *made), "the plan that is flown")),
        None => Some((stored(mission, situation, goal, problem)?, "the stored plan that is flown")),
    }
}

/// Returns the remainder of a plan `elapsed` after it was made. Surveillance problems begin at their own present, others at the mission's
/// beginning.
fn ahead(plan: Plan, elapsed: Duration) -> Plan {
    match plan {
        Plan::SingleVisit(plan) => Plan::SingleVisit(plan),
        Plan::Surveillance(mut plan) => {
            plan.visits.retain(|visit| visit.end_s > elapsed.seconds());
            Plan::Surveillance(plan)
        }
    }
}

/// Returns the rest of the stored procedure that was chosen for the goal, as a plan for the present problem.
fn stored(mission: &Mission, situation: &Situation, goal: &Value, problem: &Problem) -> Option<Plan> {
    let lap = Value::list([Value::symbol("one-cycle-of"), goal.clone()]);
    let chosen = |goal: &Value| {
        situation.chosen.get(&goal.to_string()).and_then(|chosen| Some((chosen, procedure(mission, chosen.place)?)))
    };
    let (chosen, procedure, repeat) = match chosen(&lap) {
        Some((chosen, procedure)) => (chosen, procedure, true),
        None => chosen(goal).map(|(chosen, procedure)| (chosen, procedure, false))?,
    };
    let steps: Vec<PlannedActivity> = procedure.steps.iter().filter_map(|step| visit(&step.activity)).collect();
    // Counts the visits since the choice that observe the procedure's next target.
    let mut done = 0;
    for seen in situation.observed().filter(|visit| visit.begin >= chosen.since) {
        let next = if repeat { steps.get(done % steps.len().max(1)) } else { steps.get(done) };
        done += usize::from(next.and_then(PlannedActivity::target).is_some_and(|target| target == seen.target));
    }
    match problem {
        Problem::Surveillance(problem) => watched(problem, &steps, done, repeat).map(Plan::Surveillance),
        Problem::SingleVisit(problem) => visited(problem, steps.get(done..)?).map(Plan::SingleVisit),
    }
}

fn procedure(mission: &Mission, place: Place) -> Option<&Procedure> {
    mission.library.procedures.iter().map(AsRef::as_ref).find(|procedure| procedure.place == place)
}

/// Returns a step that observes a target: `(observe TARGET ..)` or `(visit TARGET ..)` without variables.
fn visit(activity: &Activity) -> Option<PlannedActivity> {
    let Activity::Goal(Template::Constant(form)) = activity else { return None };
    let activity = PlannedActivity::from_goal(form);
    activity.target().is_some().then_some(activity)
}

/// Returns the visits from `done` on with their times counted from now, up to the horizon if they are repeated.
fn watched(
    problem: &SurveillanceProblem,
    steps: &[PlannedActivity],
    done: usize,
    repeat: bool,
) -> Option<SurveillancePlan> {
    let index = |step: &PlannedActivity| {
        let name = step.target()?;
        problem.targets.iter().position(|target| target.name == name)
    };
    let done = if repeat { done % steps.len().max(1) } else { done };
    let known = |steps: &[PlannedActivity]| steps.iter().filter_map(index).collect::<Vec<usize>>();
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

/// Returns the observations at their expected times, each by the manoeuvre whose lines the step flies.
fn visited(problem: &SingleVisitProblem, steps: &[PlannedActivity]) -> Option<SingleVisitPlan> {
    let mut visits = Vec::new();
    let mut ready_s = problem.start_s;
    for step in steps {
        let Some(of) = problem.targets.iter().find(|target| Some(target.name.as_str()) == step.target()) else {
            continue;
        };
        let (lines, due) = match step {
            PlannedActivity::Observe { lines, due, .. } => (lines.as_slice(), *due),
            PlannedActivity::Perform { due, .. } => (&[][..], Some(*due)),
            _ => (&[][..], None),
        };
        let is_flown = |manoeuvre: &Manoeuvre| match step {
            PlannedActivity::Perform { form, .. } => {
                manoeuvre.pictures.as_ref().is_some_and(|work| work.form.as_ref() == Some(form))
            }
            _ => observed_lines(manoeuvre) == lines,
        };
        let number = of.manoeuvres.iter().position(is_flown).unwrap_or(0);
        let Some(manoeuvre) = of.manoeuvres.get(number) else { continue };
        let end_s = due.map_or(ready_s + manoeuvre.duration_s, Duration::seconds);
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
            quality: Some(manoeuvre.quality.clone()),
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

/// Returns the lines that an observation flies, as stated in its step: rounded to about a metre.
pub(super) fn observed_lines(manoeuvre: &Manoeuvre) -> Vec<(Location, Location)> {
    let end = |position| Location { position, altitude_m: manoeuvre.altitude_m };
    manoeuvre.lines.iter().map(|(from, to)| (rounded(end(*from)), rounded(end(*to)))).collect()
}

/// Returns a location rounded to about a metre, so that plans stay readable.
pub(super) fn rounded(location: Location) -> Location {
    let round = |degrees: f64| (degrees * 1e5).round() / 1e5;
    let position = Position::new(round(location.position.latitude_deg), round(location.position.longitude_deg));
    Location { position, altitude_m: location.altitude_m.round() }
}

#[cfg(test)]
mod tests;
