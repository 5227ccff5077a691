//! Visits in an order that is given: each in the way that is best after those before it.

use super::schedule::{Choice, Judged, Refusal, Schedule};
use super::search::{Candidate, inserted};
use super::{explain, plan};
use apex_model::problem::{SingleVisitPlan, SingleVisitProblem};
use apex_model::solver::{Budget, Environment};

/// The plan of visiting these targets, by index, in this order; it is by `solver`.
///
/// # Errors
/// The first visit that cannot be made, and why.
pub fn in_order(
    problem: &SingleVisitProblem,
    solver: &str,
    targets: &[usize],
    environment: &mut Environment<'_>,
) -> Result<SingleVisitPlan, String> {
    let mut schedule = Schedule::new(problem)?;
    let troubles = explain::alone(&mut schedule);
    let mut best: Option<Candidate> = None;
    for (at, target) in targets.iter().enumerate() {
        let data = problem.targets.get(*target).ok_or("a visit names no target")?;
        let refused = |why: &str| format!("visit {}, of {}, cannot be made: {why}", at + 1, data.name);
        if targets.get(..at).is_some_and(|before| before.contains(target)) {
            return Err(refused("it has been visited before"));
        }
        if let Some(trouble) = troubles.get(*target).and_then(Option::as_ref) {
            return Err(refused(trouble));
        }
        best = Some(added(&mut schedule, best.as_ref(), *target, environment.budget).map_err(|why| refused(&why))?);
    }
    let best = best.ok_or("no visit is asked for")?;
    plan::plan_of(&mut schedule, solver, &best, &troubles, explain::left_out_quickly)
}

/// `before` with a visit of the target at its end, in the best way; else why there is none.
fn added(
    schedule: &mut Schedule<'_>,
    before: Option<&Candidate>,
    target: usize,
    budget: &mut dyn Budget,
) -> Result<Candidate, String> {
    let (order, known) = before.map_or((&[][..], &[][..]), |it| (it.order.as_slice(), it.judged.visits.as_slice()));
    let data = schedule.problem.targets.get(target);
    let corners = data.map(|data| data.timing.iter().map(|(time_s, _)| *time_s).collect::<Vec<f64>>());
    let starts: Vec<f64> = [f64::NEG_INFINITY].into_iter().chain(corners.unwrap_or_default()).collect();
    let mut best: Option<Candidate> = None;
    let mut trouble = "it has no manoeuvre".to_string();
    for manoeuvre in 0..data.map_or(0, |data| data.manoeuvres.len()) {
        for not_before_s in &starts {
            let choice = Choice { target, manoeuvre, not_before_s: *not_before_s };
            let order = inserted(order, order.len(), choice);
            match schedule.judge_after(known, &order, budget) {
                Ok(judged) if best.as_ref().is_none_or(|best| Judged::beats(&judged, &best.judged)) => {
                    best = Some(Candidate { order, judged });
                }
                Ok(_) => {}
                Err(Refusal::TooLate { over_s }) => {
                    trouble = format!("the flight would end {over_s:.0} s after what {} allows", schedule.limit_name);
                }
                Err(Refusal::Impossible(why)) => trouble = why,
                Err(Refusal::Order) => trouble = "another target must be visited before it".to_string(),
            }
        }
    }
    best.ok_or(trouble)
}
