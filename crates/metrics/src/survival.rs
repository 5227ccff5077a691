//! Expected cost of ignorance for events that are not rare: only the first event after an observation counts.
//!
//! The paper adds up likelihoods (section II.A), which is right as long as two events between two observations are very unlikely. Here a
//! target *survives* until its first event: between observations at `t1` and `t2` it costs the integral over `t` of `p(t) exp(-h(t))
//! Cost(t2 - t)`, where `h(t)` is the integral of `p` from `t1` to `t`. That is never more than the result of [`eci`], and equal to it
//! for rare events. This cost scores plans; planners and bounds add up likelihoods.
//! Bound: O(visits + rate steps) per target, with quadrature for logistic costs, and for saturating costs of young ages (`BEGUN`).

use crate::eci::{self, ExpectedCost, QUADRATURE_TOLERANCE, TargetCost};
use crate::quadrature;
use apex_model::problem::{CostFunction, EventRate, SurveillanceProblem, SurveillanceTarget, SurveillanceVisit};

/// Up to ages of this share of its time constant, a saturating cost is integrated by quadrature: its closed form loses digits.
const BEGUN: f64 = 0.02;

/// Returns the cost of ignorance from the first event between an observation that ends at `from_s` and one that ends at `until_s`.
///
/// # Errors
/// An error message if quadrature does not converge.
pub fn interval_cost(target: &SurveillanceTarget, from_s: f64, until_s: f64) -> Result<f64, String> {
    over_pieces(&target.rate, from_s, until_s, |span| weighted_integral(&target.cost, span))
}

/// Like [`interval_cost`], for a cost that is not of the model's families, as [`eci::interval_cost_of`].
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
    over_pieces(rate, from_s, until_s, |span| by_quadrature(cost, jumps, span))
}

/// Returns the expected cost of ignorance of flying `visits` (in order of time), if only the first event after an observation counts.
///
/// # Errors
/// Like [`interval_cost`].
pub fn expected_cost(problem: &SurveillanceProblem, visits: &[SurveillanceVisit]) -> Result<ExpectedCost, String> {
    let cost_of = |target: &SurveillanceTarget| {
        let ends = visits.iter().filter(|visit| visit.target == target.name).map(|visit| visit.end_s);
        eci::over_intervals(target, ends, problem.horizon_s, |from_s, until_s| interval_cost(target, from_s, until_s))
    };
    let targets = problem.targets.iter().map(cost_of).collect::<Result<Vec<TargetCost>, String>>()?;
    Ok(ExpectedCost { total: targets.iter().map(|target| target.expected_cost).sum(), targets })
}

/// A period of constant likelihood. At the next observation its events have ages from `oldest_s` down to `oldest_s - length_s`.
#[derive(Clone, Copy, Debug)]
struct LikelihoodPeriod {
    events_per_s: f64,
    oldest_s: f64,
    length_s: f64,
}

/// Returns the sum over the periods of constant rate of `integral`, weighted by the rate and by the probability that the target survives
/// until the period begins.
fn over_pieces(
    rate: &EventRate,
    from_s: f64,
    until_s: f64,
    mut integral: impl FnMut(LikelihoodPeriod) -> Result<f64, String>,
) -> Result<f64, String> {
    let (mut sum, mut expected) = (0.0, 0.0);
    for (begin_s, end_s, events_per_s) in eci::pieces(rate, from_s, until_s) {
        let span = LikelihoodPeriod { events_per_s, oldest_s: until_s - begin_s, length_s: end_s - begin_s };
        if events_per_s > 0.0 {
            sum += events_per_s * libm::exp(-expected) * integral(span)?;
        }
        expected += events_per_s * span.length_s;
    }
    Ok(sum)
}

/// Returns the integral over the time `s` since the span began of `exp(-p s) Cost(oldest - s)`.
fn weighted_integral(cost: &CostFunction, span: LikelihoodPeriod) -> Result<f64, String> {
    let LikelihoodPeriod { events_per_s: rate, oldest_s, length_s } = span;
    Ok(match cost {
        CostFunction::Linear { cost_per_s } => {
            cost_per_s * (oldest_s * weight(rate, length_s) - first_moment(rate, length_s))
        }
        CostFunction::Step { deadline_s, maximum } => {
            maximum * weight(rate, (oldest_s - deadline_s.max(0.0)).clamp(0.0, length_s))
        }
        CostFunction::Saturating { maximum, rate_per_s } if rate_per_s * oldest_s > BEGUN => {
            maximum * (weight(rate, length_s) - not_yet(rate, *rate_per_s, span))
        }
        CostFunction::Delayed { response_s, cost } => {
            return weighted_integral(cost, LikelihoodPeriod { oldest_s: oldest_s + response_s, ..span });
        }
        CostFunction::Table { points } => of_table(points, span),
        CostFunction::Saturating { .. } | CostFunction::Logistic { .. } => {
            return by_quadrature(&mut |age_s| eci::cost_at(cost, age_s), &[], span);
        }
    })
}

/// Returns the value of [`weighted_integral`] by quadrature.
fn by_quadrature(cost: &mut dyn FnMut(f64) -> f64, jumps: &[f64], span: LikelihoodPeriod) -> Result<f64, String> {
    let LikelihoodPeriod { events_per_s, oldest_s, length_s } = span;
    let mut weighted = |age_s: f64| libm::exp(-events_per_s * (oldest_s - age_s)) * cost(age_s);
    quadrature::integrate(&mut weighted, oldest_s - length_s, oldest_s, jumps, QUADRATURE_TOLERANCE)
}

/// Returns the integral of `exp(-q s)` over `s` from 0 to `length_s`; `q` may be negative.
fn weight(q: f64, length_s: f64) -> f64 {
    if q == 0.0 { length_s } else { -libm::expm1(-q * length_s) / q }
}

/// Returns the integral of `s exp(-q s)` over `s` from 0 to `length_s`, for `q` not negative. For few events it uses the series, because
/// the difference would lose all digits.
fn first_moment(q: f64, length_s: f64) -> f64 {
    let x = q * length_s;
    if x > 0.1 {
        return (1.0 - (1.0 + x) * libm::exp(-x)) / (q * q);
    }
    // The sum of (-x)^k / (k! (k + 2)).
    let (mut term, mut sum) = (1.0, 0.0);
    for k in 0..10 {
        let k = f64::from(k);
        sum += term / (k + 2.0);
        term *= -x / (k + 1.0);
    }
    length_s * length_s * sum
}

/// Returns the integral of `exp(-p s) exp(-r (oldest - s))`: the part by which a saturating cost falls short of its limit.
fn not_yet(p: f64, r: f64, LikelihoodPeriod { oldest_s, length_s, .. }: LikelihoodPeriod) -> f64 {
    let q = p - r;
    if q * length_s > -1.0 {
        return libm::exp(-r * oldest_s) * weight(q, length_s);
    }
    // A growing exponential is never computed separately, because it may overflow.
    (libm::exp(-r * oldest_s - q * length_s) - libm::exp(-r * oldest_s)) / -q
}

/// Returns [`weighted_integral`] of a table: linear between points, constant before the first and after the last.
fn of_table(points: &[(f64, f64)], span: LikelihoodPeriod) -> f64 {
    let Some(((first_s, first), (last_s, last))) = points.first().zip(points.last()) else { return 0.0 };
    let constant = |cost: f64, from_s: f64, until_s: f64| of_line((from_s, cost), (until_s, cost), span);
    let lines = points.iter().zip(points.iter().skip(1)).map(|(from, until)| of_line(*from, *until, span));
    let youngest_s = span.oldest_s - span.length_s;
    constant(*first, youngest_s.min(*first_s), *first_s) + lines.sum::<f64>() + constant(*last, *last_s, span.oldest_s)
}

/// Returns the share of one straight line between two ages.
fn of_line((from_s, cost_from): (f64, f64), (until_s, cost_until): (f64, f64), span: LikelihoodPeriod) -> f64 {
    let LikelihoodPeriod { events_per_s, oldest_s, length_s } = span;
    let (young_s, old_s) = (from_s.max(oldest_s - length_s), until_s.min(oldest_s));
    if young_s >= old_s {
        return 0.0;
    }
    let slope = (cost_until - cost_from) / (until_s - from_s);
    let cost_old = cost_from + slope * (old_s - from_s);
    let within_s = old_s - young_s;
    let line = cost_old * weight(events_per_s, within_s) - slope * first_moment(events_per_s, within_s);
    libm::exp(-events_per_s * (oldest_s - old_s)) * line
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::eci::tests::{families, jumps, target};
    use proptest::prelude::*;

    fn rates() -> impl Strategy<Value = EventRate> {
        prop::collection::vec((1.0..1500.0f64, prop_oneof![Just(0.0), 0.0..1e-3f64, 0.0..0.3f64]), 1..4).prop_map(
            |rates| {
                let mut at = -1500.0;
                let step = |(gap, rate)| {
                    at += gap;
                    (at, rate)
                };
                EventRate { steps: rates.into_iter().map(step).collect() }
            },
        )
    }

    proptest! {
        #[test]
        fn closed_forms_agree_with_quadrature(
            cost in families(), rate in rates(), from in -500.0..3000.0f64, length in 0.1..4000.0f64,
        ) {
            let target = target(cost.clone(), rate);
            let exact = interval_cost(&target, from, from + length).unwrap();
            let breaks = jumps(&cost);
            let mut asked = |age: f64| eci::cost_at(&cost, age);
            let witness = interval_cost_of(&target.rate, &mut asked, &breaks, from, from + length).unwrap();
            prop_assert!((exact - witness).abs() <= 1e-10 * witness.abs().max(1.0), "{exact} {witness}");
        }

        #[test]
        fn never_more_than_all_events_and_the_same_for_rare_ones(
            cost in families(), rate in rates(), from in 0.0..3000.0f64, length in 0.1..4000.0f64,
        ) {
            let often = target(cost.clone(), rate.clone());
            let (first, all) = (interval_cost(&often, from, from + length).unwrap(), eci::interval_cost(&often, from, from + length));
            prop_assert!(first <= all * (1.0 + 1e-9) + 1e-9, "{first} {all}");
            let steps = rate.steps.iter().map(|(at, rate)| (*at, 1e-9 * rate)).collect();
            let seldom = target(cost, EventRate { steps });
            let (first, all) = (interval_cost(&seldom, from, from + length).unwrap(), eci::interval_cost(&seldom, from, from + length));
            // At most 0.3e-9 x 4,000 events are expected.
            prop_assert!((first - all).abs() <= 1.3e-6 * all + 1e-18, "{first} {all}");
        }
    }

    /// The same, computed by time steps: in each step the remaining probability of the target, times its rate.
    #[test]
    fn steps_of_time_come_to_the_same() {
        let rate = EventRate { steps: vec![(0.0, 0.004), (100.0, 0.0), (150.0, 0.02)] };
        let target = target(CostFunction::Saturating { maximum: 3.0, rate_per_s: 0.01 }, rate);
        let (mut alive, mut sum) = (1.0, 0.0);
        let steps = 300_000;
        for step in 0..steps {
            let time_s = 300.0 * (f64::from(step) + 0.5) / f64::from(steps);
            let happens = alive * target.rate.at(time_s) * 300.0 / f64::from(steps);
            sum += happens * eci::cost_at(&target.cost, 300.0 - time_s);
            alive -= happens;
        }
        let exact = interval_cost(&target, 0.0, 300.0).unwrap();
        assert!((exact / sum - 1.0).abs() < 1e-5, "{exact} {sum}");
        assert!(exact < 0.8 * eci::interval_cost(&target, 0.0, 300.0));
    }

    #[test]
    fn costs_that_hardly_begin_keep_their_digits() {
        // A cost that grows this slowly is practically a line.
        let cost = |cost| interval_cost(&target(cost, EventRate::constant(0.01)), 0.0, 100.0).unwrap();
        let slow = cost(CostFunction::Saturating { maximum: 3.0, rate_per_s: 1e-12 });
        let line = cost(CostFunction::Linear { cost_per_s: 3e-12 });
        assert!((slow / line - 1.0).abs() < 1e-9, "{slow} {line}");
    }

    #[test]
    fn certain_events_cost_what_the_oldest_does() {
        let slow = target(CostFunction::Linear { cost_per_s: 2.0 }, EventRate::constant(1e6));
        assert!((interval_cost(&slow, 0.0, 50.0).unwrap() - 100.0).abs() < 1e-4);
        let quick = CostFunction::Saturating { maximum: 5.0, rate_per_s: 10.0 };
        let quick = target(quick, EventRate::constant(0.01));
        let cost = interval_cost(&quick, 0.0, 1e5).unwrap();
        assert!((cost - 5.0).abs() < 1e-6, "{cost}");
    }
}
