//! Lower bound on the cost of any flight over the horizon that never waits: dynamic programming backwards in time over the grid of ages.
//!
//! Time advances in equal ticks. A visit that ends between two ticks leaves the remaining whole ticks; the rest of its tick costs at
//! least what all targets accumulate while all but one have at least the least age of the grid. This is valid because a
//! vehicle with less time could fly the same visits, cut off earlier. Endurance and the way back are ignored, because neither makes a
//! flight cheaper.
//! Bound: O(ticks x points x targets x 2^targets), limited by [`GridResolution::steps`].

use super::{Grid, first_leg_s, gathered, leg_s};
use crate::bounds::least::events_per_s;
use apex_metrics::eci;
use apex_model::problem::{SurveillanceProblem, UNREACHABLE_S};
use apex_planning::meter::Meter;

/// Ticks for the shortest leg to another target.
const TICKS_PER_LEG: f64 = 24.0;
/// Least product of ticks and visits between points that gives a useful bound.
const STEPS_MIN: f64 = 1e5;
/// Share of the remaining budget that may be used: cycles need their bound too.
const LEFT_SHARE: f64 = 0.5;
/// If the budget suffices only for a share of the finest grid's work, the grid has this power of the share as its share of the points.
const POINTS_POWER: f64 = 0.5;
/// Relative amount by which the bound is lowered, so that rounding cannot lift it above the true value.
const ROUNDING: f64 = 3e-9;
/// A number this little above a whole number of ticks counts as whole.
const WHOLE: f64 = 1e-9;

/// Resolution of the grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridResolution {
    /// Maximum number of points of the grid of ages.
    pub points: usize,
    /// Maximum product of ticks and visits between points.
    pub steps: f64,
}

impl GridResolution {
    /// The finest resolution: a finer one raises the bound by less than its work is worth.
    pub const CLOSEST: GridResolution = GridResolution { points: 9_000, steps: 4e8 };
}

/// Returns the bound on the finest grid that the budget permits; `None` if there are too many targets, a cost is not concave, no target
/// can be reached, or the budget is too small for any grid.
pub fn expected_cost(problem: &SurveillanceProblem, meter: &mut Meter<'_>) -> Option<(f64, GridResolution)> {
    let (grid, time) = prepared(problem, GridResolution::CLOSEST)?;
    let (left_ns, wanted_ns) = (LEFT_SHARE * meter.left_ns(), time.steps(&grid) * grid.step_ns());
    if wanted_ns <= left_ns {
        meter.spend(wanted_ns);
        return Some((value(problem, &grid, &time)?, GridResolution::CLOSEST));
    }
    meter.cut();
    let share = libm::pow(left_ns / wanted_ns, POINTS_POWER);
    let look = GridResolution {
        points: (share * GridResolution::CLOSEST.points as f64) as usize,
        steps: left_ns / grid.step_ns(),
    };
    if look.steps < STEPS_MIN {
        return None;
    }
    let (grid, time) = prepared(problem, look)?;
    meter.spend(time.steps(&grid) * grid.step_ns());
    Some((value(problem, &grid, &time)?, look))
}

/// Returns the bound with this resolution; `None` as [`expected_cost`].
pub fn expected_cost_at(problem: &SurveillanceProblem, look: GridResolution) -> Option<f64> {
    let (grid, time) = prepared(problem, look)?;
    value(problem, &grid, &time)
}

fn prepared(problem: &SurveillanceProblem, look: GridResolution) -> Option<(Grid, Time)> {
    let grid = Grid::new(problem, look.points, problem.horizon_s)?;
    let time = Time::new(problem, &grid, look.steps)?;
    Some((grid, time))
}

fn value(problem: &SurveillanceProblem, grid: &Grid, time: &Time) -> Option<f64> {
    let targets = || problem.targets.iter().enumerate();
    let before: f64 = targets().map(|(target, of)| gathered(problem, target, 0.0, of.initial_age_s)).sum();
    let layers = backwards(problem, grid, time)?;
    let first = |to: usize| {
        let seconds = first_leg_s(problem, to);
        let ticks = time.ticks_of(seconds);
        let values = layers.at(time.ticks.checked_sub(ticks).filter(|_| seconds < UNREACHABLE_S)?)?;
        let cost: f64 = targets().map(|(target, of)| gathered(problem, target, of.initial_age_s, seconds)).sum();
        let ages_s: Vec<f64> = problem.targets.iter().map(|of| of.initial_age_s + seconds).collect();
        Some(cost + time.of_rest(ticks, seconds) + grid.value(to, &ages_s, values))
    };
    let at_home: f64 =
        targets().map(|(target, of)| gathered(problem, target, of.initial_age_s, problem.horizon_s)).sum();
    let broken = time.least_per_s * (problem.horizon_s - time.ticks as f64 * time.tick_s).max(0.0);
    // The cost of staying at home includes the last, broken tick.
    let flights = (0..problem.targets.len()).filter_map(first).map(|cost| cost + broken);
    let value = before + flights.fold(at_home, f64::min);
    Some(value - ROUNDING * value.abs())
}

/// Division of the horizon into ticks.
struct Time {
    ticks: usize,
    tick_s: f64,
    /// Least cost that all targets accumulate per second when one has just been visited.
    least_per_s: f64,
}

impl Time {
    fn new(problem: &SurveillanceProblem, grid: &Grid, steps_max: f64) -> Option<Time> {
        let count = problem.targets.len();
        let ways = (0..count).flat_map(|from| (0..count).filter(move |to| *to != from).map(move |to| (from, to)));
        let alone = (0..count).map(|to| leg_s(problem, to, to)).filter(|_| count == 1);
        let legs = ways.map(|(from, to)| leg_s(problem, from, to)).chain(alone);
        let is_leg = |leg_s: &f64| *leg_s > 0.0 && *leg_s < UNREACHABLE_S;
        let quickest_s = legs.filter(is_leg).fold(f64::INFINITY, f64::min);
        let most = libm::floor(steps_max / grid.visits().max(1.0));
        let wanted_s = (quickest_s / TICKS_PER_LEG).max(problem.horizon_s / most);
        if !(problem.horizon_s > 0.0 && wanted_s.is_finite() && wanted_s > 0.0) {
            return None;
        }
        // The shortest stay at a target takes whole ticks: with partial ticks repeated stays would be too cheap.
        let stays = (0..count).map(|target| leg_s(problem, target, target)).filter(is_leg);
        let stay_s = stays.fold(f64::INFINITY, f64::min);
        let tick_s = if stay_s.is_finite() { stay_s / libm::ceil(stay_s / wanted_s) } else { wanted_s };
        // A longer tick would not fit into the horizon.
        let tick_s = tick_s.min(problem.horizon_s);
        let ticks = libm::floor(problem.horizon_s / tick_s).max(1.0);
        Some(Time { ticks: ticks as usize, tick_s, least_per_s: least_per_s(problem, grid, tick_s) })
    }

    /// Returns the product of ticks and visits between points.
    fn steps(&self, grid: &Grid) -> f64 {
        self.ticks as f64 * grid.visits()
    }

    /// Returns the ticks that `seconds` use, including a partial one.
    fn ticks_of(&self, seconds: f64) -> usize {
        libm::ceil(seconds / self.tick_s - WHOLE) as usize
    }

    /// Returns the cost that accumulates in the remainder of a visit's last tick.
    fn of_rest(&self, ticks: usize, seconds: f64) -> f64 {
        self.least_per_s * (ticks as f64 * self.tick_s - seconds).max(0.0)
    }
}

/// Returns the least cost that all targets accumulate per second at any instant of the last tick: all but one have at least the first age
/// of the grid, or the age after the whole flight.
fn least_per_s(problem: &SurveillanceProblem, grid: &Grid, tick_s: f64) -> f64 {
    let at = |target: usize| {
        let of = problem.targets.get(target)?;
        let never_s = of.initial_age_s + problem.horizon_s - tick_s;
        let age_s = grid.levels.get(target)?.first()?.min(never_s);
        Some(events_per_s(of) * eci::cost_at(&of.cost, age_s))
    };
    let all: Vec<f64> = (0..problem.targets.len()).filter_map(at).collect();
    let greatest = all.iter().copied().fold(0.0, f64::max);
    (all.iter().sum::<f64>() - greatest).max(0.0)
}

/// Values by the number of remaining ticks, as a ring buffer: only as many layers as the longest visit has ticks.
struct Layers {
    kept: Vec<Vec<f64>>,
}

impl Layers {
    fn at(&self, left: usize) -> Option<&[f64]> {
        self.kept.get(left % self.kept.len().max(1)).map(Vec::as_slice)
    }
}

/// Returns the least cost from every point on, by number of remaining ticks.
fn backwards(problem: &SurveillanceProblem, grid: &Grid, time: &Time) -> Option<Layers> {
    let ticks: Vec<usize> = grid.steps.iter().map(|step| time.ticks_of(step.seconds)).collect();
    let firsts = (0..problem.targets.len()).map(|to| first_leg_s(problem, to)).filter(|leg_s| *leg_s < UNREACHABLE_S);
    let longest = ticks.iter().copied().chain(firsts.map(|leg_s| time.ticks_of(leg_s))).max()?.min(time.ticks);
    let mut layers = Layers { kept: vec![vec![0.0; grid.size()]; longest + 1] };
    let mut layer = vec![0.0; grid.size()];
    let mut sums = vec![0.0; grid.row()];
    for left in 0..=time.ticks {
        layer.fill(f64::INFINITY);
        for (step, ticks) in grid.steps.iter().zip(&ticks).filter(|(_, ticks)| **ticks <= left) {
            let values = layers.at(left - ticks)?;
            let rest = time.of_rest(*ticks, step.seconds);
            let own = layer.get_mut(grid.first(step.from)..)?;
            for (row, others) in own.chunks_mut(grid.row()).zip(grid.rows()) {
                grid.ahead(step, others, values, &mut sums);
                row.iter_mut().zip(&sums).for_each(|(value, sum)| *value = value.min(sum + rest));
            }
        }
        stop(problem, grid, &mut layer, left as f64 * time.tick_s);
        let place = left % (longest + 1);
        std::mem::swap(layers.kept.get_mut(place)?, &mut layer);
    }
    Some(layers)
}

/// Adds the costs up to the end where no further visit is possible; where a visit is possible, this changes nothing.
fn stop(problem: &SurveillanceProblem, grid: &Grid, layer: &mut [f64], left_s: f64) {
    for target in 0..problem.targets.len() {
        let Some(own) = layer.get_mut(grid.first(target)..) else { return };
        for (row, digits) in own.chunks_mut(grid.row()).zip(grid.rows()) {
            for (first, value) in row.iter_mut().enumerate().filter(|(_, value)| **value == f64::INFINITY) {
                let digits = [first].into_iter().chain(digits.iter().map(|digit| usize::from(*digit)));
                let others = grid.levels.iter().enumerate().filter(|(other, _)| *other != target).zip(digits);
                let each = others.filter_map(|((other, levels), digit)| {
                    levels.get(digit).map(|age_s| gathered(problem, other, *age_s, left_s))
                });
                *value = gathered(problem, target, 0.0, left_s) + each.sum::<f64>();
            }
        }
    }
}
