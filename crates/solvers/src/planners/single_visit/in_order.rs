//! Visits in a given order: each first in the way that ends first, then in the way with the highest value, given the others.

use super::explain::{self, Troubles};
use super::plan;
use super::search::{Candidate, inserted};
use crate::routing::schedule::{Choice, Infeasibility, Schedule};
use apex_model::problem::{SingleVisitPlan, SingleVisitProblem};
use apex_planning::solver::{Budget, Environment};

/// Iterations over all visits in which better choices are sought.
const PASSES_MAX: usize = 8;

/// Fault of an order of visits.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OrderFault {
    /// The visit that cannot be made, by its place from 0; `None` if the fault is not that of one visit.
    pub visit: Option<usize>,
    /// Reason, which names the visit.
    pub reason: String,
}

impl From<String> for OrderFault {
    fn from(reason: String) -> OrderFault {
        OrderFault { visit: None, reason }
    }
}

impl From<&str> for OrderFault {
    fn from(reason: &str) -> OrderFault {
        reason.to_string().into()
    }
}

/// Returns the plan that visits these targets, by index, in this order; `solver` is its planner. A target with a given manoeuvre is
/// observed by that manoeuvre at once, the others in the way with the highest value.
///
/// # Errors
/// The first visit that cannot be made, and why.
pub fn in_order(
    problem: &SingleVisitProblem,
    solver: &str,
    targets: &[(usize, Option<usize>)],
    environment: &mut Environment<'_>,
) -> Result<SingleVisitPlan, OrderFault> {
    let mut schedule = Schedule::new(problem)?;
    let troubles = Troubles::new(&mut schedule);
    let mut best: Option<Candidate> = None;
    for (at, (target, manoeuvre)) in targets.iter().enumerate() {
        let data = problem.targets.get(*target).ok_or("a visit names no target")?;
        let refused = |why: &str| OrderFault {
            visit: Some(at),
            reason: format!("visit {}, of {}, cannot be made: {why}", at + 1, data.name),
        };
        if targets.get(..at).is_some_and(|before| before.iter().any(|(before, _)| before == target)) {
            return Err(refused("it has been visited before"));
        }
        let is_last = at + 1 == targets.len();
        let with = added(&mut schedule, best.as_ref(), ((*target, *manoeuvre), is_last), environment.budget);
        // The reason against the target as the only visit is more specific than the reason against it in the plan.
        let alone = troubles.of_impossible(*target).map(|reason| &reason.text);
        best = Some(with.map_err(|why| refused(alone.unwrap_or(&why)))?);
    }
    let best = improved(&mut schedule, best.ok_or("no visits are given")?, targets, environment.budget);
    Ok(plan::plan_of(&mut schedule, solver, &best, &troubles, explain::left_out_quickly)?)
}

/// Returns all ways to observe `target`: by the given manoeuvre at once; otherwise by each manoeuvre, at once or from each corner of its
/// timing on.
fn ways(problem: &SingleVisitProblem, (target, manoeuvre): (usize, Option<usize>)) -> Vec<Choice> {
    let Some(data) = problem.targets.get(target) else { return Vec::new() };
    if let Some(manoeuvre) = manoeuvre {
        return vec![Choice { target, manoeuvre, not_before_s: f64::NEG_INFINITY }];
    }
    let starts = || [f64::NEG_INFINITY].into_iter().chain(data.timing.iter().map(|(time_s, _)| *time_s));
    let way = |manoeuvre| starts().map(move |not_before_s| Choice { target, manoeuvre, not_before_s });
    (0..data.manoeuvres.len()).flat_map(way).collect()
}

/// Returns `before` extended by the visit of the target that ends first, or the reason for which it is impossible. Only the last target
/// needs a path to the base.
fn added(
    schedule: &mut Schedule<'_>,
    before: Option<&Candidate>,
    (target, is_last): ((usize, Option<usize>), bool),
    budget: &mut dyn Budget,
) -> Result<Candidate, String> {
    let (order, known) = before.map_or((&[][..], &[][..]), |it| (it.order.as_slice(), it.judged.visits.as_slice()));
    let end_s = |it: &Candidate| it.judged.visits.last().map_or(f64::INFINITY, |visit| visit.end_s);
    let mut first: Option<Candidate> = None;
    let mut trouble = "it has no manoeuvre".to_string();
    for choice in ways(schedule.problem, target) {
        let order = inserted(order, order.len(), choice);
        let judged = match is_last {
            true => schedule.judge_after(known, &order, budget),
            false => schedule.judge_part(known, &order, budget),
        };
        match judged {
            Ok(judged) => {
                let found = Candidate { order, judged };
                if first.as_ref().is_none_or(|first| end_s(&found) < end_s(first)) {
                    first = Some(found);
                }
            }
            Err(Infeasibility::TooLate { over_s }) => {
                trouble = format!("the flight would end {over_s:.0} s after what {} allows", schedule.limit);
            }
            Err(Infeasibility::Impossible(why)) => trouble = why,
            Err(Infeasibility::Closed { target }) => trouble = schedule.closed_window(target),
            Err(Infeasibility::Order) => trouble = "another target must be visited before it".to_string(),
        }
    }
    first.ok_or(trouble)
}

/// Returns the same order with each visit in another way, if that has a higher value and the other visits remain feasible.
fn improved(
    schedule: &mut Schedule<'_>,
    mut best: Candidate,
    targets: &[(usize, Option<usize>)],
    budget: &mut dyn Budget,
) -> Candidate {
    for _ in 0..PASSES_MAX {
        let mut better = false;
        for (at, target) in targets.iter().enumerate() {
            for choice in ways(schedule.problem, *target) {
                let mut order = best.order.clone();
                if let Some(slot) = order.get_mut(at) {
                    *slot = choice;
                }
                let known = best.judged.visits.get(..at).unwrap_or(&[]);
                if let Ok(judged) = schedule.judge_after(known, &order, budget)
                    && judged.beats(&best.judged)
                {
                    (best, better) = (Candidate { order, judged }, true);
                }
            }
        }
        if !better || budget.exhausted() {
            break;
        }
    }
    best
}
