//! Every word (sequence of visits) of a surveillance problem, by plain enumeration, with costs in separate closed forms.
//!
//! Nothing is shared with planners, metrics or checkers but the problem's data types and the table of legs in `visit_orders`.

use crate::visit_orders::leg_s;
use apex_model::problem::{CostFunction, EventRate, SurveillanceProblem, SurveillanceTarget, UNREACHABLE_S};

/// Returns the least expected cost of a flight that never waits, and of one that may also wait before a visit for each of `waits_s`.
/// Times must be kept with a reserve of `margin_s`. `None` if there are too many words to enumerate.
pub(crate) fn least_costs(problem: &SurveillanceProblem, waits_s: &[f64], margin_s: f64) -> Option<(f64, f64)> {
    let limit_s = problem.endurance_s.unwrap_or(f64::INFINITY).min(problem.horizon_s) - margin_s;
    let mut words = Words { problem, limit_s, waits_s: &[0.0], best: f64::INFINITY, left: 60_000 };
    let last_s: Vec<f64> = problem.targets.iter().map(|target| -target.initial_age_s).collect();
    words.extend(None, 0.0, &last_s, 0.0)?;
    let without = words.best;
    (words.waits_s, words.left) = (waits_s, 60_000);
    // The words enumerated before the limit was reached still count.
    words.extend(None, 0.0, &last_s, 0.0);
    Some((without, words.best))
}

/// Returns the expected cost of a plan's visits, given as targets with the ends of their observations.
pub(crate) fn cost_of(problem: &SurveillanceProblem, visits: &[(String, f64)]) -> f64 {
    let of = |target: &SurveillanceTarget| {
        let ends = visits.iter().filter(|(name, _)| *name == target.name).map(|(_, end_s)| *end_s);
        let mut last_s = -target.initial_age_s;
        let mut sum = 0.0;
        for end_s in ends.chain([problem.horizon_s]) {
            sum += gap_cost(target, last_s, end_s);
            last_s = end_s;
        }
        sum
    };
    problem.targets.iter().map(of).sum()
}

struct Words<'a> {
    problem: &'a SurveillanceProblem,
    limit_s: f64,
    waits_s: &'a [f64],
    best: f64,
    left: usize,
}

impl Words<'_> {
    /// Returns `None` if too many words have been enumerated.
    fn extend(&mut self, here: Option<usize>, ready_s: f64, last_s: &[f64], spent: f64) -> Option<()> {
        self.left = self.left.checked_sub(1)?;
        let targets = &self.problem.targets;
        let home_s = match here {
            Some(_) if self.problem.return_to_base => leg_s(&self.problem.travel, here, None, ready_s),
            _ => 0.0,
        };
        let may_end = home_s < UNREACHABLE_S && ready_s + home_s <= self.limit_s || here.is_none();
        if may_end {
            let open =
                targets.iter().zip(last_s).map(|(target, from_s)| gap_cost(target, *from_s, self.problem.horizon_s));
            self.best = self.best.min(spent + open.sum::<f64>());
        }
        for (to, target) in targets.iter().enumerate() {
            for wait_s in self.waits_s {
                let travel_s = leg_s(&self.problem.travel, here, Some(to), ready_s + wait_s);
                let end_s = ready_s + wait_s + travel_s + target.dwell_s;
                if travel_s < UNREACHABLE_S && end_s <= self.limit_s {
                    let mut seen_s = last_s.to_vec();
                    seen_s[to] = end_s;
                    self.extend(Some(to), end_s, &seen_s, spent + gap_cost(target, last_s[to], end_s))?;
                }
            }
        }
        Some(())
    }
}

/// Returns the cost of an interval without observation: the rate times the cost of each event's age at the end.
fn gap_cost(target: &SurveillanceTarget, from_s: f64, until_s: f64) -> f64 {
    let of = |from_s: f64, until_age_s: f64| integral(&target.cost, from_s) - integral(&target.cost, until_age_s);
    let pieces = pieces(&target.rate, from_s, until_s);
    pieces.into_iter().map(|(begin_s, end_s, rate)| rate * of(until_s - begin_s, until_s - end_s)).sum()
}

/// Returns the spans of constant rate between two times.
fn pieces(rate: &EventRate, from_s: f64, until_s: f64) -> Vec<(f64, f64, f64)> {
    let Some(first) = rate.steps.first() else { return Vec::new() };
    let mut pieces = Vec::new();
    let (mut begin_s, mut events_per_s) = (f64::NEG_INFINITY, first.1);
    for (at_s, next) in rate.steps.iter().copied().chain([(f64::INFINITY, 0.0)]) {
        let (low_s, high_s) = (begin_s.max(from_s), at_s.min(until_s));
        if low_s < high_s {
            pieces.push((low_s, high_s, events_per_s));
        }
        (begin_s, events_per_s) = (at_s, next);
    }
    pieces
}

/// Returns the integral of the cost over ages from 0 to `age_s`.
fn integral(cost: &CostFunction, age_s: f64) -> f64 {
    match cost {
        CostFunction::Linear { cost_per_s } => 0.5 * cost_per_s * age_s * age_s,
        CostFunction::Saturating { maximum, rate_per_s } => {
            if *rate_per_s == 0.0 {
                return 0.0;
            }
            maximum * (age_s - (1.0 - (-rate_per_s * age_s).exp()) / rate_per_s)
        }
        CostFunction::Step { deadline_s, maximum } => maximum * (age_s - deadline_s).max(0.0),
        CostFunction::Logistic { maximum, rate_per_s, midpoint_s } => {
            if *rate_per_s == 0.0 {
                return 0.5 * maximum * age_s;
            }
            let soft = |age_s: f64| (rate_per_s * (age_s - midpoint_s)).exp().ln_1p() / rate_per_s;
            maximum * (soft(age_s) - soft(0.0))
        }
        CostFunction::Delayed { response_s, cost } => integral(cost, response_s + age_s) - integral(cost, *response_s),
        CostFunction::Table { points } => table_integral(points, age_s),
    }
}

fn table_integral(points: &[(f64, f64)], age_s: f64) -> f64 {
    let (first, last) = (points[0], points[points.len() - 1]);
    let mut sum = first.1 * age_s.min(first.0) + last.1 * (age_s - last.0).max(0.0);
    for (low, high) in points.iter().zip(points.iter().skip(1)) {
        let until_s = age_s.min(high.0);
        if until_s > low.0 {
            let at_end = low.1 + (high.1 - low.1) * (until_s - low.0) / (high.0 - low.0);
            sum += 0.5 * (low.1 + at_end) * (until_s - low.0);
        }
    }
    sum
}
