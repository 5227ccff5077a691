//! A bound by a price on time (a Lagrange multiplier).
//!
//! The cost of an interval without observation is convex in its length, because the cost of an event never falls with its age. So a
//! target at which the vehicle stays `k` times, `e` seconds longer in total than one observation each, costs at least `(k + 1) G((T - e)
//! / (k + 1))`: the remaining time in equal parts, and no cost during stays. Each stay takes one observation, half of the shortest way to
//! the target and half of the shortest way from it. All stays must fit into the flight; a multiplier relaxes this constraint, and for any
//! multiplier the targets' cheapest responses bound every plan. Travel between distant groups of targets is not counted, so the bound is
//! weak for clusters.
//! Bound: O(prices x targets x visits that fit), with [`PRICES_MAX`] prices.

use apex_metrics::eci;
use apex_model::problem::{SurveillanceProblem, SurveillanceTarget, UNREACHABLE_S};

/// Maximum number of prices that are tried.
pub const PRICES_MAX: usize = 48;
/// Work per target for all prices together, in nanoseconds.
pub(super) const TARGET_NS: f64 = 2e5;
/// Relative amount by which a bound is lowered, so that rounding cannot lift it above the true value.
const ROUNDING: f64 = 1e-9;
/// Bisection steps in the search for the interval that a price is worth: enough for the last bit.
const HALVINGS: usize = 64;

/// A bound with the price of a second as its certificate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PriceBound {
    /// No plan costs less.
    pub expected_cost: f64,
    /// Least expected cost that one more second of flight would save.
    pub price_per_s: f64,
}

/// Returns the best bound found. `problem` must be valid (`validate::surveillance`).
pub fn expected_cost(problem: &SurveillanceProblem) -> PriceBound {
    let targets = prepared(problem);
    let value = |price: f64| PriceBound { expected_cost: of_targets(problem, &targets, price), price_per_s: price };
    // The bound is concave in the price: golden-section search over the logarithm of the price, up to the greatest value of any second.
    let highest = targets.iter().map(|target| target.cost_at(target.span_s)).fold(0.0, f64::max);
    let mut best = value(0.0);
    if highest <= 0.0 || !highest.is_finite() {
        return best;
    }
    let golden = 0.5 * (libm::sqrt(5.0) - 1.0);
    let at = |share: f64| value(highest * libm::pow(10.0, 6.0 * (share - 1.0)));
    let (mut low, mut high) = (0.0, 1.0);
    let (mut left, mut right) = (high - golden * (high - low), low + golden * (high - low));
    let (mut at_left, mut at_right) = (at(left), at(right));
    for _ in 0..PRICES_MAX {
        for found in [at_left, at_right] {
            if found.expected_cost > best.expected_cost {
                best = found;
            }
        }
        if at_left.expected_cost < at_right.expected_cost {
            (low, left, at_left) = (left, right, at_right);
            right = low + golden * (high - low);
            at_right = at(right);
        } else {
            (high, right, at_right) = (right, left, at_left);
            left = high - golden * (high - low);
            at_left = at(left);
        }
    }
    best
}

/// Returns the bound that one price proves; verification of a certificate calls this too.
pub fn at_price(problem: &SurveillanceProblem, price_per_s: f64) -> f64 {
    of_targets(problem, &prepared(problem), price_per_s.max(0.0))
}

fn of_targets(problem: &SurveillanceProblem, targets: &[PricedTarget<'_>], price: f64) -> f64 {
    let limit_s = problem.endurance_s.unwrap_or(problem.horizon_s).min(problem.horizon_s);
    // If the mission may end anywhere, no leg follows the last visit; each stay was charged half of a leg from its target.
    let spared_s = if problem.return_to_base {
        0.0
    } else {
        targets.iter().map(|target| target.half_out_s).filter(|half_s| *half_s < UNREACHABLE_S).fold(0.0, f64::max)
    };
    let bound = targets.iter().map(|target| target.cheapest(price)).sum::<f64>() - price * (limit_s + spared_s);
    bound - ROUNDING * bound.abs()
}

/// Data of a target for the bound.
struct PricedTarget<'a> {
    target: &'a SurveillanceTarget,
    /// Least events per second at any time.
    events_per_s: f64,
    /// The time that its cost covers: the horizon plus its age at the start.
    span_s: f64,
    /// Least duration of a stay: one observation and half of the shortest paths to the target and from it.
    stay_s: f64,
    /// Half of the shortest way from the target.
    half_out_s: f64,
    /// Maximum number of stays that fit into the flight.
    stays_max: u32,
}

fn prepared(problem: &SurveillanceProblem) -> Vec<PricedTarget<'_>> {
    problem.targets.iter().enumerate().map(|(index, target)| prepare(problem, index, target)).collect()
}

fn prepare<'a>(problem: &SurveillanceProblem, index: usize, target: &'a SurveillanceTarget) -> PricedTarget<'a> {
    let travel = &problem.travel;
    let limit_s = problem.endurance_s.unwrap_or(problem.horizon_s).min(problem.horizon_s);
    let others = || (0..problem.targets.len()).filter(|other| *other != index);
    let into_s = others().map(|from| travel.between(from, index)).fold(travel.start_to(index), f64::min);
    let home_s = if problem.return_to_base { travel.to_base(index) } else { UNREACHABLE_S };
    let out_s = others().map(|to| travel.between(index, to)).fold(home_s, f64::min);
    let (half_in_s, half_out_s) = (0.5 * into_s, if out_s < UNREACHABLE_S { 0.5 * out_s } else { 0.0 });
    let stay_s = target.dwell_s + half_in_s + half_out_s;
    let fits = (limit_s + half_out_s) / stay_s.max(1e-3);
    let rates = target.rate.steps.iter().map(|(_, events_per_s)| *events_per_s);
    PricedTarget {
        target,
        events_per_s: rates.reduce(f64::min).unwrap_or(0.0),
        span_s: problem.horizon_s + target.initial_age_s,
        stay_s,
        half_out_s,
        stays_max: if into_s < UNREACHABLE_S { fits.min(1e6) as u32 } else { 0 },
    }
}

impl PricedTarget<'_> {
    /// Returns the cost gathered per second after `span_s` without observation.
    fn cost_at(&self, span_s: f64) -> f64 {
        self.events_per_s * eci::cost_at(&self.target.cost, span_s)
    }

    /// Returns the least cost of the target when a second of flight costs `price`.
    fn cheapest(&self, price: f64) -> f64 {
        let worth_s = self.span_worth(price);
        let mut least = f64::INFINITY;
        let mut before = f64::INFINITY;
        for stays in 0..=self.stays_max {
            let cost = self.with_stays(stays, price, worth_s);
            least = least.min(cost);
            // The cost is convex in the number of stays: once it rises, it keeps rising.
            if cost > before {
                break;
            }
            before = cost;
        }
        least
    }

    fn with_stays(&self, stays: u32, price: f64, worth_s: f64) -> f64 {
        let stays = f64::from(stays);
        let parts = stays + 1.0;
        // Without a stay there is no stay to extend.
        let part_s = if stays == 0.0 { self.span_s } else { worth_s.min(self.span_s / parts) };
        let longer_s = (self.span_s - parts * part_s).max(0.0);
        let gathered = self.events_per_s * eci::cost_integral(&self.target.cost, part_s);
        parts * gathered + price * (longer_s + stays * self.stay_s)
    }

    /// Returns the length of interval at whose end a second costs as much as the price: longer intervals are worth shortening. Rounding
    /// by a last bit does not matter, because the cost is flat there.
    fn span_worth(&self, price: f64) -> f64 {
        if self.cost_at(self.span_s) <= price {
            return self.span_s;
        }
        let (mut low, mut high) = (0.0, self.span_s);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if self.cost_at(middle) <= price {
                low = middle;
            } else {
                high = middle;
            }
        }
        low
    }
}
