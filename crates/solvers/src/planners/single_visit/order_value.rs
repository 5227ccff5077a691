//! Value of visits in a given order, and the visits to leave out if not all are feasible. The cost of a delay is the difference
//! of two such values.

use crate::routing::schedule::{Choice, Schedule};
use apex_model::problem::SingleVisitProblem;
use apex_planning::solver::WorkBudget;

/// A visit of an order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrderedVisit {
    /// Index of the target.
    pub target: usize,
    /// Index of its manoeuvre.
    pub manoeuvre: usize,
    /// Earliest begin of the observation, seconds into the plan; negative infinity if unconstrained.
    pub not_before_s: f64,
}

/// The value of an order.
#[derive(Clone, Debug, PartialEq)]
pub struct OrderValue {
    /// Benefits less costs.
    pub score: f64,
    /// Indices of the targets that are visited, in order.
    pub visited: Vec<usize>,
}

/// Returns the value of `visits` in their order. If not all are feasible, it leaves out the visit whose removal gives the highest
/// score. If removing any single visit is not enough, it first removes the least valuable ones.
///
/// # Errors
/// An error message if the problem is invalid, or if the vehicle cannot return to the base in time even without a visit.
pub fn order_value(problem: &SingleVisitProblem, visits: &[OrderedVisit]) -> Result<OrderValue, String> {
    let mut schedule = Schedule::new(problem)?;
    let mut free = WorkBudget::new(u64::MAX);
    let mut order: Vec<Choice> = visits
        .iter()
        .map(|visit| Choice { target: visit.target, manoeuvre: visit.manoeuvre, not_before_s: visit.not_before_s })
        .collect();
    let value =
        |order: &[Choice], score: f64| OrderValue { score, visited: order.iter().map(|it| it.target).collect() };
    while !order.is_empty() {
        if let Ok(judged) = schedule.judge(&order, &mut free) {
            return Ok(value(&order, judged.score));
        }
        let mut best: Option<OrderValue> = None;
        for at in 0..order.len() {
            let mut shorter = order.clone();
            shorter.remove(at);
            let Ok(judged) = schedule.judge(&shorter, &mut free) else { continue };
            if best.as_ref().is_none_or(|best| judged.score > best.score) && !shorter.is_empty() {
                best = Some(value(&shorter, judged.score));
            }
        }
        if let Some(best) = best {
            return Ok(best);
        }
        let worth = |choice: &Choice| {
            let target = problem.targets.get(choice.target);
            let manoeuvre = target.and_then(|target| target.manoeuvres.get(choice.manoeuvre));
            target.zip(manoeuvre).map_or(0.0, |(target, manoeuvre)| target.gain(manoeuvre.quality.product()))
        };
        let least = order.iter().enumerate().min_by(|(_, a), (_, b)| worth(a).total_cmp(&worth(b)));
        let Some((least, _)) = least else { break };
        order.remove(least);
    }
    match schedule.idle() {
        Ok(judged) => Ok(value(&[], judged.score)),
        Err(none) => Err(schedule.no_plan(&none)),
    }
}
