//! The reason against one more visit, over all orders of a plan's visits and this one.
//!
//! In the order of the plan, with its manoeuvres, a visit may need much more time than in the best order.
//! Bound: [`TARGETS_MAX`] targets, and [`UNITS_MAX`] units of work for all reasons of a plan; beyond that, reasons state the planned order.

use super::choices::choices;
use super::exhaust::{FlightEnd, visiting_all};
use crate::routing::schedule::{Choice, Infeasibility, Judged, Schedule};
use apex_model::problem::Obstacle;
use apex_planning::obstacle::LeftOutReason;
use apex_planning::solver::WorkBudget;

/// Largest number of targets, that of the reason included, whose orders are compared.
const TARGETS_MAX: usize = 8;
/// Work for all reasons of a plan: a tenth of a second.
const UNITS_MAX: u64 = 100_000;

/// Returns the budget for the reasons of a plan.
pub(super) fn budget() -> WorkBudget {
    WorkBudget::new(UNITS_MAX)
}

/// Returns the ends of the flights that visit the targets of `order` and `target` in any order and by any manoeuvres, without limits;
/// `None` if they are too many.
pub(super) fn ends_with(
    endless: &mut Schedule<'_>,
    order: &[Choice],
    target: usize,
    budget: &mut WorkBudget,
) -> Option<Vec<FlightEnd>> {
    if order.len() >= TARGETS_MAX {
        return None;
    }
    let all: Vec<usize> = order.iter().map(|choice| choice.target).chain([target]).collect();
    let problem = endless.problem;
    visiting_all(endless, &all, &|target| choices(problem, target), budget)
}

/// Returns the reason against a target by the `ends` of all flights that visit it and the targets of the plan; `None` if there is none. The
/// value of a target with a timing may be greater between the instants that are tried, so that its score is not known.
pub(super) fn reason_in_any_order(
    schedule: &Schedule<'_>,
    order: &[Choice],
    judged: &Judged,
    (target, ends): (usize, &[FlightEnd]),
) -> Option<LeftOutReason> {
    let missing = |earlier: &usize| !order.iter().any(|choice| choice.target == *earlier);
    if schedule.earlier(target).iter().any(missing) {
        return None;
    }
    let over_of = |(_, end_s, extra_s): &FlightEnd| over(schedule, *end_s, *extra_s);
    let best = |ends: &mut dyn Iterator<Item = &FlightEnd>| ends.map(|(score, ..)| *score).reduce(f64::max);
    let is_timed = |target: usize| schedule.problem.targets.get(target).is_some_and(|it| !it.timing.is_empty());
    let is_scored = !is_timed(target) && !order.iter().any(|choice| is_timed(choice.target));
    let within = best(&mut ends.iter().filter(|end| over_of(end).is_none()));
    // More time would not make the visit pay if even the best flight without limits scores less.
    let loss = judged.score - within.or_else(|| best(&mut ends.iter()))?;
    match within {
        Some(_) if loss < 0.0 => Some("was not reached within the planning budget".into()),
        Some(_) if loss == 0.0 => Some("would not raise the score".into()),
        _ if loss > 0.0 => is_scored.then(|| Obstacle::Score { loss }.into()),
        _ => {
            let least = ends.iter().filter_map(over_of).min_by(|(a_s, _), (b_s, _)| a_s.total_cmp(b_s))?;
            Some(late_text(schedule, least, false))
        }
    }
}

/// Returns a reason that holds for the planned order of the other visits.
pub(super) fn in_planned_order(reason: LeftOutReason, order: &[Choice]) -> LeftOutReason {
    match order.is_empty() {
        true => reason,
        false => LeftOutReason { text: format!("{}, in the planned order", reason.text), ..reason },
    }
}

/// Seconds by which a flight would end too late, and true if that is after the limit of the energy.
pub(super) type Over = (f64, bool);

/// Returns by how much a flight ends too late, if it does.
pub(super) fn over(schedule: &Schedule<'_>, end_s: f64, extra_s: f64) -> Option<Over> {
    match schedule.late(end_s, extra_s) {
        Some(Infeasibility::TooLate { over_s, is_energy }) => Some((over_s, is_energy)),
        _ => None,
    }
}

/// Returns the reason for a visit after which the flight ends `over_s` seconds later than its limit allows.
pub(super) fn late_text(schedule: &Schedule<'_>, (over_s, is_energy): Over, alone: bool) -> LeftOutReason {
    Obstacle::Late { over_s, limit: schedule.limit_of(is_energy).of_visit(), alone }.into()
}
