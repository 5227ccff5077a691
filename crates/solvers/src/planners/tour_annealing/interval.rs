//! Fast evaluation of the cost of one interval without observation, for millions of moves.
//!
//! Linear and saturating costs at a constant rate are one formula, `a d + b d^2 + c (exp(-r d) - 1)` for an interval of
//! length `d`; its exponential is a polynomial that the compiler turns into vector code. Plans are priced by the exact
//! metric in the end, so the small error here (below 1e-10 of the exponential) only ranks moves.

use super::change::LETTERS_MAX;
use apex_model::problem::{CostFunction, SurveillanceProblem, SurveillanceTarget};
use smallvec::SmallVec;
use wide::f64x4;

/// Targets that are computed at once.
pub(super) const LANES: usize = 4;

/// Coefficients of [`LANES`] targets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Coefficients {
    linear: f64x4,
    square: f64x4,
    decay: f64x4,
    rate_per_s: f64x4,
}

impl Coefficients {
    /// Returns the cost of intervals of these lengths.
    #[inline(always)]
    pub(super) fn cost(&self, length_s: f64x4) -> f64x4 {
        let decayed = exponential(f64x4::ZERO - self.rate_per_s * length_s) - f64x4::ONE;
        length_s * (self.linear + self.square * length_s) + self.decay * decayed
    }
}

/// Coefficients of every target; those of padding lanes are 0.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Intervals {
    lanes: Vec<Coefficients>,
    /// The same coefficients by target, so that any four targets can be combined.
    by_target: Vec<[f64; 4]>,
}

/// Intervals that close in sequence: targets and lengths in seconds.
pub(super) type Closing = SmallVec<[(usize, f64); LETTERS_MAX]>;

impl Intervals {
    /// Returns the coefficients of a problem; `None` if a target's cost or rate is of another family.
    pub(super) fn of(problem: &SurveillanceProblem) -> Option<Intervals> {
        let by_target: Vec<[f64; 4]> = problem.targets.iter().map(coefficients).collect::<Option<_>>()?;
        let lanes = by_target.chunks(LANES).map(|targets| side_by_side(targets.iter().copied())).collect();
        Some(Intervals { lanes, by_target })
    }

    /// Returns the coefficients, lanes by lanes.
    pub(super) fn lanes(&self) -> &[Coefficients] {
        &self.lanes
    }

    /// Returns `sum` plus the costs of all closing intervals, added in order; targets that do not exist cost 0.
    pub(super) fn add(&self, mut sum: f64, closing: &Closing) -> f64 {
        for few in closing.chunks(LANES) {
            let of = |(target, _): &(usize, f64)| self.by_target.get(*target).copied().unwrap_or_default();
            let mut lengths_s = [0.0; LANES];
            lengths_s.iter_mut().zip(few).for_each(|(slot, (_, length_s))| *slot = *length_s);
            let costs = side_by_side(few.iter().map(of)).cost(f64x4::new(lengths_s)).to_array();
            sum = costs.iter().take(few.len()).fold(sum, |sum, cost| sum + cost);
        }
        sum
    }

    /// Returns the cost of an interval of `length_s` of one target; 0 for a target that does not exist.
    pub(super) fn cost(&self, target: usize, length_s: f64) -> f64 {
        let costs = self.lanes.get(target / LANES).map(|coefficients| coefficients.cost(f64x4::splat(length_s)));
        costs.and_then(|costs| costs.to_array().get(target % LANES).copied()).unwrap_or(0.0)
    }
}

/// Returns the coefficients of at most four targets, lane by lane.
#[inline(always)]
fn side_by_side(targets: impl Iterator<Item = [f64; 4]>) -> Coefficients {
    let mut numbers = [[0.0; LANES]; 4];
    for (lane, target) in targets.enumerate() {
        for (row, number) in numbers.iter_mut().zip(target) {
            if let Some(slot) = row.get_mut(lane) {
                *slot = number;
            }
        }
    }
    let [linear, square, decay, rate_per_s] = numbers.map(f64x4::new);
    Coefficients { linear, square, decay, rate_per_s }
}

fn coefficients(target: &SurveillanceTarget) -> Option<[f64; 4]> {
    let events_per_s = match target.rate.steps.as_slice() {
        [] => 0.0,
        [(_, events_per_s)] => *events_per_s,
        _ => return None,
    };
    of_family(&target.cost, 0.0).map(|[linear, square, decay, rate_per_s]| {
        [events_per_s * linear, events_per_s * square, events_per_s * decay, rate_per_s]
    })
}

fn of_family(cost: &CostFunction, response_s: f64) -> Option<[f64; 4]> {
    match cost {
        CostFunction::Linear { cost_per_s } => Some([cost_per_s * response_s, 0.5 * cost_per_s, 0.0, 0.0]),
        CostFunction::Saturating { maximum, rate_per_s } if *rate_per_s > 0.0 => {
            let already = libm::exp(-rate_per_s * response_s);
            Some([*maximum, 0.0, maximum * already / rate_per_s, *rate_per_s])
        }
        CostFunction::Saturating { .. } => Some([0.0; 4]),
        CostFunction::Delayed { response_s: more_s, cost } => of_family(cost, response_s + more_s),
        CostFunction::Step { .. } | CostFunction::Logistic { .. } | CostFunction::Table { .. } => None,
    }
}

/// Returns `exp(x)` for `x <= 0` as `2^k` times a polynomial in the remainder, which is at most half of `ln 2` in size. Below -600 the
/// result is that of -600.
///
/// Uses only sums and products, so that the result is equal on processors with and without fused operations.
#[inline(always)]
fn exponential(x: f64x4) -> f64x4 {
    // Adding and subtracting this number rounds to an integer, which the last bits of the sum hold.
    let round = f64x4::splat(6_755_399_441_055_744.0);
    // ln 2 split into a short number and a rest, so that the remainder is exact.
    let (log_2_high, log_2_low) = (f64x4::splat(0.693_147_180_369_123_8), f64x4::splat(1.908_214_929_270_587_7e-10));
    let least = f64x4::splat(-600.0);
    let x = x.simd_gt(least).select(x, least);
    let shifted = x * f64x4::splat(std::f64::consts::LOG2_E) + round;
    let whole = shifted - round;
    let rest = (x - whole * log_2_high) - whole * log_2_low;
    let term = |number: f64| f64x4::splat(number);
    let tail = term(1.0 / 5_040.0) + rest * (term(1.0 / 40_320.0) + rest * term(1.0 / 362_880.0));
    let tail = term(1.0 / 24.0) + rest * (term(1.0 / 120.0) + rest * (term(1.0 / 720.0) + rest * tail));
    let small = f64x4::ONE + rest * (f64x4::ONE + rest * (f64x4::HALF + rest * (term(1.0 / 6.0) + rest * tail)));
    let power = |shifted: f64| f64::from_bits(shifted.to_bits().wrapping_add(1023) << 52);
    let [a, b, c, d] = shifted.to_array();
    small * f64x4::new([power(a), power(b), power(c), power(d)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use apex_metrics::eci;
    use apex_model::problem::{EventRate, Position};
    use proptest::prelude::*;

    fn at(x: f64) -> f64 {
        exponential(f64x4::splat(x)).to_array()[0]
    }

    fn families() -> impl Strategy<Value = CostFunction> {
        let simple = prop_oneof![
            (0.0..5.0f64).prop_map(|cost_per_s| CostFunction::Linear { cost_per_s }),
            (0.1..5.0f64, 1e-5..0.1f64)
                .prop_map(|(maximum, rate_per_s)| CostFunction::Saturating { maximum, rate_per_s }),
        ];
        (0.0..900.0f64, simple)
            .prop_map(|(response_s, cost)| CostFunction::Delayed { response_s, cost: Box::new(cost) })
    }

    proptest! {
        #[test]
        fn the_fast_formula_is_the_metric(cost in families(), events in 0.0..3.0f64, length in 1.0..20_000.0f64) {
            let target = SurveillanceTarget {
                name: String::new(), position: Position::default(), dwell_s: 0.0,
                rate: EventRate::constant(events), cost, initial_age_s: 0.0,
            };
            let decay = coefficients(&target).unwrap()[2];
            let exact = eci::interval_cost(&target, 0.0, length);
            let problem = SurveillanceProblem { targets: vec![target], ..apex_planning::examples::surveillance::random(1, 1) };
            let quick = Intervals::of(&problem).unwrap().cost(0, length);
            prop_assert!((exact - quick).abs() <= 1e-9 * exact.abs().max(decay.abs()), "{exact} {quick}");
        }

        #[test]
        fn the_exponential_is_close(x in -700.0..0.0f64) {
            let exact = libm::exp(x.max(-600.0));
            prop_assert!((at(x) - exact).abs() <= 1e-10 * exact, "{x}");
        }
    }

    #[test]
    fn ends_of_the_exponential() {
        assert_eq!(at(0.0), 1.0);
        assert!(at(f64::NEG_INFINITY) < 1e-250);
    }
}
