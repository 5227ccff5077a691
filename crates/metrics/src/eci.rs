//! Expected cost of ignorance (paper, section II.A): exact for the model's cost families, by quadrature for other costs.
//!
//! Between two observations at `t1` and `t2` a target costs the integral over `t` of `p(t) Cost(t2 - t)`. With piecewise constant `p`
//! this is a sum of differences of [`cost_integral`]. Each observation resets ignorance at its end, and the last interval ends at the
//! horizon. A target that is never visited has one interval up to the horizon.
//! Bound: O(visits + rate steps) per target.

use crate::quadrature;
use apex_model::problem::{CostFunction, EventRate, SurveillanceProblem, SurveillanceTarget, SurveillanceVisit};
use std::convert::Infallible;

/// Relative tolerance of quadrature for user functions.
pub const QUADRATURE_TOLERANCE: f64 = 1e-11;

/// Combination of the likelihoods of events between two observations of a target.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Likelihoods {
    /// Added up, as in the paper: events are rare, or each counts.
    #[default]
    Added,
    /// Only the first event after an observation counts ([`crate::survival`]).
    Survival,
}

/// Returns the cost of an unknown event that is `age_s` old. Events of the future cost nothing.
pub fn cost_at(cost: &CostFunction, age_s: f64) -> f64 {
    if age_s < 0.0 {
        return 0.0;
    }
    match cost {
        CostFunction::Linear { cost_per_s } => cost_per_s * age_s,
        CostFunction::Saturating { maximum, rate_per_s } => -maximum * libm::expm1(-rate_per_s * age_s),
        CostFunction::Step { deadline_s, maximum } => {
            if age_s < *deadline_s {
                0.0
            } else {
                *maximum
            }
        }
        CostFunction::Logistic { maximum, rate_per_s, midpoint_s } => {
            maximum / (1.0 + libm::exp(-rate_per_s * (age_s - midpoint_s)))
        }
        CostFunction::Delayed { response_s, cost } => cost_at(cost, age_s + response_s),
        CostFunction::Table { points } => table_at(points, age_s),
    }
}

fn table_at(points: &[(f64, f64)], age_s: f64) -> f64 {
    let later = points.partition_point(|(age, _)| *age <= age_s);
    let before = later.checked_sub(1).and_then(|last| points.get(last));
    match (before, points.get(later)) {
        (Some((age0, cost0)), Some((age, cost))) => cost0 + (cost - cost0) * (age_s - age0) / (age - age0),
        (Some((_, cost)), None) | (None, Some((_, cost))) => *cost,
        (None, None) => 0.0,
    }
}

/// Returns the integral of [`cost_at`] over ages from 0 to `age_s`: the cost of an interval of this length at a rate of one event per
/// second.
pub fn cost_integral(cost: &CostFunction, age_s: f64) -> f64 {
    if age_s <= 0.0 {
        return 0.0;
    }
    match cost {
        CostFunction::Linear { cost_per_s } => 0.5 * cost_per_s * age_s * age_s,
        CostFunction::Saturating { maximum, rate_per_s } => saturating_integral(*maximum, *rate_per_s, age_s),
        CostFunction::Step { deadline_s, maximum } => maximum * (age_s - deadline_s.max(0.0)).max(0.0),
        CostFunction::Logistic { maximum, rate_per_s, .. } if *rate_per_s == 0.0 => 0.5 * maximum * age_s,
        CostFunction::Logistic { maximum, rate_per_s, midpoint_s } => {
            let (until, from) = (rate_per_s * (age_s - midpoint_s), -rate_per_s * midpoint_s);
            maximum / rate_per_s * (softplus(until) - softplus(from))
        }
        CostFunction::Delayed { response_s, cost } => {
            cost_integral(cost, age_s + response_s) - cost_integral(cost, *response_s)
        }
        CostFunction::Table { points } => table_integral(points, age_s),
    }
}

/// Returns `m (d - (1 - exp(-r d)) / r)`; for small `r d` by its series, because the difference would lose all digits.
fn saturating_integral(maximum: f64, rate_per_s: f64, age_s: f64) -> f64 {
    let x = rate_per_s * age_s;
    if x.abs() > 0.02 {
        return maximum * (age_s + libm::expm1(-x) / rate_per_s);
    }
    let series =
        1.0 - x / 3.0 * (1.0 - x / 4.0 * (1.0 - x / 5.0 * (1.0 - x / 6.0 * (1.0 - x / 7.0 * (1.0 - x / 8.0)))));
    0.5 * maximum * x * age_s * series
}

fn softplus(x: f64) -> f64 {
    if x > 0.0 { x + libm::log1p(libm::exp(-x)) } else { libm::log1p(libm::exp(x)) }
}

fn table_integral(points: &[(f64, f64)], age_s: f64) -> f64 {
    let (mut from, mut cost_from) = (0.0, table_at(points, 0.0));
    let mut sum = 0.0;
    for (age, cost) in points.iter().filter(|(age, _)| *age > 0.0) {
        if age_s <= *age {
            // Ends before a jump at this age, if there is one.
            let cost_until = cost_from + (cost - cost_from) * (age_s - from) / (age - from);
            return sum + 0.5 * (cost_from + cost_until) * (age_s - from);
        }
        // At a jump (two points of the same age) the piece has no width, and the later cost applies from there on.
        sum += 0.5 * (cost_from + cost) * (age - from);
        (from, cost_from) = (*age, *cost);
    }
    sum + cost_from * (age_s - from)
}

/// Returns the cost of ignorance between an observation that ends at `from_s` and one that ends at `until_s`.
pub fn interval_cost(target: &SurveillanceTarget, from_s: f64, until_s: f64) -> f64 {
    if until_s <= from_s {
        return 0.0;
    }
    if let [(_, events_per_s)] = target.rate.steps.as_slice() {
        return events_per_s * cost_integral(&target.cost, until_s - from_s);
    }
    pieces(&target.rate, from_s, until_s)
        .map(|(begin_s, end_s, events_per_s)| {
            let (oldest, youngest) = (until_s - begin_s, until_s - end_s);
            events_per_s * (cost_integral(&target.cost, oldest) - cost_integral(&target.cost, youngest))
        })
        .sum()
}

/// Returns the spans of constant rate in `[from_s, until_s]`: beginning, end, events per second.
pub(crate) fn pieces(rate: &EventRate, from_s: f64, until_s: f64) -> impl Iterator<Item = (f64, f64, f64)> + '_ {
    let ends = rate.steps.iter().skip(1).map(|(time_s, _)| *time_s).chain([f64::INFINITY]);
    rate.steps.iter().zip(ends).enumerate().filter_map(move |(index, ((time_s, events_per_s), end_s))| {
        let begin_s = if index == 0 { from_s } else { time_s.max(from_s) };
        let end_s = end_s.min(until_s);
        (begin_s < end_s).then_some((begin_s, end_s, *events_per_s))
    })
}

/// Like [`interval_cost`] by quadrature, for a cost function outside the model's families. `jumps` are the known ages at which the function
/// is not smooth.
///
/// # Errors
/// An error message if the function is not finite or not integrable to the tolerance.
pub fn interval_cost_of(
    rate: &EventRate,
    cost: &mut dyn FnMut(f64) -> f64,
    jumps: &[f64],
    from_s: f64,
    until_s: f64,
) -> Result<f64, String> {
    let mut sum = 0.0;
    for (begin_s, end_s, events_per_s) in pieces(rate, from_s, until_s) {
        let (youngest, oldest) = (until_s - end_s, until_s - begin_s);
        sum += events_per_s * quadrature::integrate(cost, youngest, oldest, jumps, QUADRATURE_TOLERANCE)?;
    }
    Ok(sum)
}

/// Cost of one target over the whole mission.
#[derive(Clone, Debug, PartialEq)]
pub struct TargetCost {
    /// The target's name.
    pub target: String,
    /// Its expected cost of ignorance.
    pub expected_cost: f64,
    /// Number of observations.
    pub observations: usize,
    /// The longest span without an observation.
    pub longest_gap_s: f64,
}

/// Expected cost of ignorance of a mission, by target.
#[derive(Clone, Debug, PartialEq)]
pub struct ExpectedCost {
    /// The sum.
    pub total: f64,
    /// Each target in the problem's order.
    pub targets: Vec<TargetCost>,
}

/// Returns the cost of one target with observations that end at `ends_s`, in order of time. Observations after the horizon do not count.
pub fn target_cost(target: &SurveillanceTarget, ends_s: impl IntoIterator<Item = f64>, horizon_s: f64) -> TargetCost {
    let Ok(cost) = over_intervals(target, ends_s, horizon_s, |from_s, until_s| {
        Ok::<f64, Infallible>(interval_cost(target, from_s, until_s))
    });
    cost
}

/// Like [`target_cost`], with a function that gives the cost of an interval from its beginning and end.
pub(crate) fn over_intervals<E>(
    target: &SurveillanceTarget,
    ends_s: impl IntoIterator<Item = f64>,
    horizon_s: f64,
    mut interval: impl FnMut(f64, f64) -> Result<f64, E>,
) -> Result<TargetCost, E> {
    let mut last_s = -target.initial_age_s;
    let mut cost = TargetCost { target: target.name.clone(), expected_cost: 0.0, observations: 0, longest_gap_s: 0.0 };
    for end_s in ends_s.into_iter().filter(|end_s| *end_s <= horizon_s) {
        cost.expected_cost += interval(last_s, end_s)?;
        cost.longest_gap_s = cost.longest_gap_s.max(end_s - last_s);
        cost.observations += 1;
        last_s = last_s.max(end_s);
    }
    cost.expected_cost += interval(last_s, horizon_s)?;
    cost.longest_gap_s = cost.longest_gap_s.max(horizon_s - last_s);
    Ok(cost)
}

/// Returns the expected cost of ignorance of `visits` (in order of time), either planned or actually flown.
pub fn expected_cost(problem: &SurveillanceProblem, visits: &[SurveillanceVisit]) -> ExpectedCost {
    let cost_of = |target: &SurveillanceTarget| {
        let ends = visits.iter().filter(|visit| visit.target == target.name).map(|visit| visit.end_s);
        target_cost(target, ends, problem.horizon_s)
    };
    let targets: Vec<TargetCost> = problem.targets.iter().map(cost_of).collect();
    ExpectedCost { total: targets.iter().map(|target| target.expected_cost).sum(), targets }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use apex_model::problem::{Position, TravelTimes};
    use proptest::prelude::*;

    pub(crate) fn target(cost: CostFunction, rate: EventRate) -> SurveillanceTarget {
        SurveillanceTarget {
            name: "a".to_string(),
            position: Position::default(),
            dwell_s: 0.0,
            rate,
            cost,
            initial_age_s: 0.0,
        }
    }

    pub(crate) fn families() -> impl Strategy<Value = CostFunction> {
        let delayed =
            |(response_s, cost): (f64, CostFunction)| CostFunction::Delayed { response_s, cost: Box::new(cost) };
        prop_oneof![3 => simple_families(), 1 => (0.0..900.0f64, simple_families()).prop_map(delayed)]
    }

    fn simple_families() -> impl Strategy<Value = CostFunction> {
        prop_oneof![
            (0.0..5.0f64).prop_map(|cost_per_s| CostFunction::Linear { cost_per_s }),
            (0.1..5.0f64, 1e-7..0.1f64)
                .prop_map(|(maximum, rate_per_s)| CostFunction::Saturating { maximum, rate_per_s }),
            (0.0..2000.0f64, 0.1..5.0f64).prop_map(|(deadline_s, maximum)| CostFunction::Step { deadline_s, maximum }),
            (0.1..5.0f64, 1e-4..0.1f64, 0.0..2000.0f64).prop_map(|(maximum, rate_per_s, midpoint_s)| {
                CostFunction::Logistic { maximum, rate_per_s, midpoint_s }
            }),
            prop::collection::vec((0.0..500.0f64, 0.0..2.0f64), 1..6).prop_map(|steps| {
                let mut at = (0.0, 0.0);
                let points = steps.into_iter().map(|(age, cost)| {
                    at = (at.0 + age + 1.0, at.1 + cost);
                    at
                });
                CostFunction::Table { points: points.collect() }
            }),
        ]
    }

    pub(crate) fn jumps(cost: &CostFunction) -> Vec<f64> {
        match cost {
            CostFunction::Step { deadline_s, .. } => vec![*deadline_s],
            CostFunction::Table { points } => points.iter().map(|(age, _)| *age).collect(),
            CostFunction::Delayed { response_s, cost } => jumps(cost).into_iter().map(|age| age - response_s).collect(),
            _ => Vec::new(),
        }
    }

    proptest! {
        #[test]
        fn closed_forms_agree_with_quadrature(
            cost in families(), from in -500.0..3000.0f64, length in 0.1..4000.0f64,
            rates in prop::collection::vec((1.0..1500.0f64, 0.0..3.0f64), 1..4),
        ) {
            let mut at = -1500.0;
            let steps = rates.into_iter().map(|(gap, rate)| { at += gap; (at, rate) }).collect();
            let target = target(cost.clone(), EventRate { steps });
            let exact = interval_cost(&target, from, from + length);
            let breaks = jumps(&cost);
            let witness =
                interval_cost_of(&target.rate, &mut |age| cost_at(&cost, age), &breaks, from, from + length).unwrap();
            prop_assert!((exact - witness).abs() <= 1e-10 * witness.abs().max(1.0), "{exact} {witness}");
        }

        #[test]
        fn looking_once_more_never_costs_more(cost in families(), first in 0.0..3600.0f64, second in 0.0..3600.0f64) {
            let target = target(cost, EventRate::constant(1.0));
            let once = target_cost(&target, [first], 3600.0).expected_cost;
            let twice = target_cost(&target, [first.min(second), first.max(second)], 3600.0).expected_cost;
            prop_assert!(twice <= once * (1.0 + 1e-12) + 1e-9);
        }
    }

    #[test]
    fn an_interval_that_ends_at_a_jump_has_the_cost_before_it() {
        let table = CostFunction::Table { points: vec![(0.0, 0.0), (300.0, 20.0), (300.0, 50.0), (2_000.0, 50.0)] };
        assert_eq!(cost_integral(&table, 300.0), 3_000.0);
        assert_eq!(cost_integral(&table, 310.0), 3_500.0);
        let delayed = CostFunction::Delayed { response_s: 300.0, cost: Box::new(table) };
        assert_eq!(cost_integral(&delayed, 10.0), 500.0);
    }

    #[test]
    fn ages_and_horizon_count() {
        let mut old = target(CostFunction::Linear { cost_per_s: 2.0 }, EventRate::constant(0.5));
        assert_eq!(target_cost(&old, [], 10.0).expected_cost, 50.0);
        old.initial_age_s = 10.0;
        let never = target_cost(&old, [], 10.0);
        assert_eq!((never.expected_cost, never.longest_gap_s, never.observations), (200.0, 20.0, 0));
        let seen = target_cost(&old, [0.0, 4.0, 11.0], 10.0);
        assert_eq!((seen.expected_cost, seen.observations), (50.0 + 8.0 + 18.0, 2));
    }

    #[test]
    fn small_rates_keep_their_digits() {
        let slow = CostFunction::Saturating { maximum: 1.0, rate_per_s: 1e-12 };
        assert!((cost_integral(&slow, 10.0) / (0.5e-12 * 100.0) - 1.0).abs() < 1e-11);
    }

    #[test]
    fn a_mission_is_the_sum_of_its_targets() {
        let mut other = target(CostFunction::Linear { cost_per_s: 1.0 }, EventRate::constant(1.0));
        other.name = "b".to_string();
        let problem = SurveillanceProblem {
            targets: vec![target(CostFunction::Linear { cost_per_s: 1.0 }, EventRate::constant(1.0)), other],
            travel: TravelTimes::default(),
            horizon_s: 10.0,
            return_to_base: false,
            endurance_s: None,
        };
        let visit = |name: &str, end_s| SurveillanceVisit { target: name.to_string(), arrive_s: end_s, end_s };
        let cost = expected_cost(&problem, &[visit("a", 2.0), visit("b", 5.0)]);
        assert_eq!(cost.total, (2.0 + 32.0) + (12.5 + 12.5));
        assert_eq!(cost.targets[1].longest_gap_s, 5.0);
    }
}
