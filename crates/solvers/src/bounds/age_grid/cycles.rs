//! Lower bound on the cost per second of any endless flight, and a cycle whose cost is close to it.
//!
//! A cost per second is proven if each grid point can be given a value such that no visit leads to a lower value than the one it started
//! with, after that cost is subtracted for each second of the visit. A flight of any length then costs at least that much per second,
//! except for the differences of the values. Repeated sweeps over the grid find the values for a trial cost, and bisection finds the
//! cost; any values prove a valid bound. A flight that follows the values gives a cycle whose cost is close to the bound.
//! Bound: O(sweeps x points x targets x 2^targets).

use super::{Grid, LONG_S, gathered, leg_s};
use crate::bounds::least::events_per_s;
use apex_metrics::eci;
use apex_model::problem::{Plan, Problem, SurveillanceProblem, UNREACHABLE_S};
use apex_planning::meter::Meter;
use apex_planning::solver::WorkBudget;

const POINTS_MAX: usize = 56_000;
/// Points of the grid on which good values are sought first.
const POINTS_COARSE: usize = 20_000;
/// Number of trial costs, and of sweeps over the grid for each.
const TRIALS_MAX: usize = 12;
const SWEEPS_MAX: usize = 120;
/// Number of sweeps before the cost is computed.
const SWEEPS_AT_ONCE: usize = 20;
/// Relative gap up to which a trial cost counts as proven, and relative gap between bound and best cost at which trials end.
const NEAR: f64 = 1e-5;
const ENOUGH: f64 = 2e-3;
/// Number of visits in the flight that follows the values, and greatest length of a cycle sought in it.
const VISITS: usize = 900;
const CYCLE_MAX: usize = 300;
/// Number of visits at which a cycle may begin.
const BEGINNINGS: usize = 60;
/// Work of following the values and seeking cycles, in nanoseconds.
const FLOWN_NS: f64 = 1e7;
/// Least share by which a cycle must be cheaper to be reported as better.
const BETTER: f64 = 1e-3;
/// Relative amount by which the bound is lowered, so that rounding cannot lift it above the true value.
const ROUNDING: f64 = 1e-9;

/// A cycle with its cost per second and the proof of its quality.
#[derive(Clone, Debug, PartialEq)]
pub struct BestCycle {
    /// Indices of the targets in the order of their visits; the cycle is flown endlessly.
    pub cycle: Vec<usize>,
    /// Expected cost per second of the cycle.
    pub cost_per_s: f64,
    /// Lower bound on the cost per second of any endless flight that never waits.
    pub cost_per_s_bound: f64,
    /// Proof: a value for each point of the grid.
    pub proof: Vec<f64>,
}

/// Result of flying a plan's cycle endlessly.
#[derive(Clone, Debug, PartialEq)]
pub struct WithoutEnd {
    /// Expected cost per second of the plan's cycle.
    pub cost_per_s: f64,
    /// Lower bound on the cost per second of any endless flight that never waits.
    pub cost_per_s_bound: f64,
    /// Names of the targets of a cheaper cycle with its cost per second, if one is known.
    pub better: Option<(Vec<String>, f64)>,
}

/// Evaluates the plan's cycle as an endless flight, within the budget. `None` if the plan is not a cycle, or no bound exists for it.
pub fn of_plan(problem: &Problem, plan: &Plan, meter: &mut Meter<'_>) -> Option<WithoutEnd> {
    let (Problem::Surveillance(problem), Plan::Surveillance(plan)) = (problem, plan) else { return None };
    let index = |name: &String| problem.targets.iter().position(|target| target.name == *name);
    let cycle: Vec<usize> = plan.cycle.iter().map(index).collect::<Option<_>>()?;
    let own = Some(cost_per_s(problem, &cycle)).filter(|cost| cost.is_finite() && !cycle.is_empty())?;
    let best = best_within(problem, &[cycle], POINTS_MAX, meter)?;
    let name = |target: &usize| problem.targets.get(*target).map(|target| target.name.clone());
    let better = (best.cost_per_s < own * (1.0 - BETTER))
        .then(|| (best.cycle.iter().filter_map(name).collect(), best.cost_per_s));
    Some(WithoutEnd { cost_per_s: own, cost_per_s_bound: best.cost_per_s_bound, better })
}

/// Returns the best cycle found, starting with those in `known`, and the bound; `None` if there are too many targets, a cost is not
/// concave, or no cycle can be flown.
pub fn best(problem: &SurveillanceProblem, known: &[Vec<usize>]) -> Option<BestCycle> {
    best_within(problem, known, POINTS_MAX, &mut Meter::new(&mut WorkBudget::new(u64::MAX)))
}

/// Like [`best`], with a grid of another size, as far as the budget suffices: otherwise on a coarser grid, or with a bound that more
/// sweeps would raise.
pub fn best_within(
    problem: &SurveillanceProblem,
    known: &[Vec<usize>],
    points_max: usize,
    meter: &mut Meter<'_>,
) -> Option<BestCycle> {
    let coarse = fitting(problem, points_max.min(POINTS_COARSE), meter)?;
    let found = on_grid(problem, known, &coarse, None, meter)?;
    if points_max <= POINTS_COARSE || !meter.is_complete() {
        return Some(found);
    }
    let fine = Grid::new(problem, points_max, LONG_S)?;
    if sweeps_ns(&fine) > meter.left_ns() {
        meter.cut();
        return Some(found);
    }
    let known: Vec<Vec<usize>> = known.iter().cloned().chain([found.cycle.clone()]).collect();
    // The proof of the coarse grid stays valid if the fine grid proves less.
    let finer = on_grid(problem, &known, &fine, Some((&coarse, &found.proof)), meter)?;
    Some(if finer.cost_per_s_bound >= found.cost_per_s_bound {
        finer
    } else {
        BestCycle { cycle: finer.cycle, cost_per_s: finer.cost_per_s, ..found }
    })
}

/// Returns the largest grid of at most `points_max` points that the budget can sweep several times; `None` if there is none.
fn fitting(problem: &SurveillanceProblem, points_max: usize, meter: &mut Meter<'_>) -> Option<Grid> {
    let grid = Grid::new(problem, points_max, LONG_S)?;
    let share = meter.left_ns() / sweeps_ns(&grid);
    if share >= 1.0 {
        return Some(grid);
    }
    meter.cut();
    Grid::new(problem, (share * grid.size() as f64) as usize, LONG_S)
}

/// Returns the work in nanoseconds of the sweeps that a grid needs for any proof.
fn sweeps_ns(grid: &Grid) -> f64 {
    3.0 * SWEEPS_AT_ONCE as f64 * grid.visits() * grid.step_ns()
}

fn on_grid(
    problem: &SurveillanceProblem,
    known: &[Vec<usize>],
    grid: &Grid,
    coarse: Option<(&Grid, &[f64])>,
    meter: &mut Meter<'_>,
) -> Option<BestCycle> {
    let count = problem.targets.len();
    let simple = (0..count).map(|target| vec![target]).chain([(0..count).collect()]);
    let costs = known.iter().cloned().chain(simple).map(|cycle| (cost_per_s(problem, &cycle), cycle));
    let (cost_per_s, cycle) = costs.filter(|(cost, _)| cost.is_finite()).min_by(|a, b| a.0.total_cmp(&b.0))?;
    let mut best = BestCycle { cycle, cost_per_s, cost_per_s_bound: 0.0, proof: vec![0.0; grid.size()] };
    let mut values = best.proof.clone();
    if let Some((coarse, known)) = coarse {
        grid.fill(&mut values, |at, ages_s| coarse.value(at, ages_s, known));
    }
    let mut least_failed = cost_per_s;
    let mut trial = (1.0 - 0.5 * ENOUGH) * cost_per_s;
    for _ in 0..TRIALS_MAX {
        let found = sweep(grid, &mut values, trial, &mut best, meter);
        meter.spend(FLOWN_NS);
        let (cycle, cost_per_s) = flown(problem, grid, &values, trial);
        if cost_per_s < best.cost_per_s {
            (best.cycle, best.cost_per_s) = (cycle, cost_per_s);
        }
        if !found {
            least_failed = trial;
            values.copy_from_slice(&best.proof);
        }
        least_failed = least_failed.min(best.cost_per_s);
        if least_failed - best.cost_per_s_bound < ENOUGH * least_failed {
            break;
        }
        if meter.left_ns() <= 0.0 {
            meter.cut();
            break;
        }
        trial = 0.5 * (least_failed + best.cost_per_s_bound);
    }
    Some(best)
}

/// Returns the bound that the values prove, computed from the problem and the values alone: a lower bound on the expected cost per second
/// of any endless flight that never waits.
pub fn verified(problem: &SurveillanceProblem, proof: &[f64]) -> f64 {
    let grid = Grid::new(problem, proof.len(), LONG_S).filter(|grid| grid.size() == proof.len());
    grid.map_or(0.0, |grid| proven(&grid, proof))
}

/// Sweeps the grid until the trial cost is proven or the sweeps are used up; intermediate proofs are kept.
fn sweep(grid: &Grid, values: &mut [f64], trial: f64, best: &mut BestCycle, meter: &mut Meter<'_>) -> bool {
    let once_ns = grid.visits() * grid.step_ns();
    for number in 1..=SWEEPS_MAX {
        improve(grid, values, trial);
        meter.spend(once_ns);
        // The budget does not suffice for another sweep.
        let last = meter.left_ns() <= once_ns;
        if number % SWEEPS_AT_ONCE == 0 || last {
            meter.spend(once_ns);
            let bound = proven(grid, values);
            if bound > best.cost_per_s_bound {
                best.cost_per_s_bound = bound;
                best.proof.copy_from_slice(values);
            }
            if bound >= trial * (1.0 - NEAR) {
                return true;
            }
            if last {
                meter.cut();
                return false;
            }
        }
    }
    false
}

/// Updates each value from those that visits lead to, the greatest ages first, because visits lead to greater ages. Then subtracts the
/// first value from all, because only their differences count.
fn improve(grid: &Grid, values: &mut [f64], per_s: f64) {
    let length = grid.row();
    let (mut sums, mut best) = (vec![0.0; length], vec![0.0; length]);
    for (number, others) in grid.rows().iter().enumerate().rev() {
        for target in 0..grid.levels.len() {
            best.fill(f64::INFINITY);
            for step in grid.steps_from(target) {
                grid.ahead(step, others, values, &mut sums);
                let taken = per_s * step.seconds;
                best.iter_mut().zip(&sums).for_each(|(best, sum)| *best = best.min(sum - taken));
            }
            let first = grid.first(target) + number * length;
            if let Some(row) = values.get_mut(first..first + length) {
                row.copy_from_slice(&best);
            }
        }
    }
    let first = values.first().copied().unwrap_or(0.0);
    values.iter_mut().for_each(|value| *value -= first);
}

fn proven(grid: &Grid, values: &[f64]) -> f64 {
    let mut least = f64::INFINITY;
    let mut sums = vec![0.0; grid.row()];
    for step in &grid.steps {
        let own = values.get(grid.first(step.from)..).unwrap_or_default();
        for (row, others) in own.chunks(grid.row()).zip(grid.rows()) {
            grid.ahead(step, others, values, &mut sums);
            for (value, sum) in row.iter().zip(&sums) {
                let per_s = (sum - value) / step.seconds;
                // NaN proves nothing.
                least = if per_s >= least { least } else { per_s };
            }
        }
    }
    let size = values.iter().fold(0.0_f64, |size, value| size.max(value.abs()));
    let quickest_s = grid.steps.iter().map(|step| step.seconds).fold(f64::INFINITY, f64::min);
    let proven = least - ROUNDING * (least.abs() + size / quickest_s);
    if proven.is_finite() { proven.max(0.0) } else { 0.0 }
}

/// Returns the best cycle within a flight that always makes the visit of the best value.
fn flown(problem: &SurveillanceProblem, grid: &Grid, values: &[f64], per_s: f64) -> (Vec<usize>, f64) {
    let mut ages_s = vec![0.0; problem.targets.len()];
    let (mut here, mut word) = (0, Vec::new());
    for _ in 0..VISITS {
        let of = |seconds: f64, to: usize| {
            let grown = |(target, age_s): (usize, &f64)| if target == to { 0.0 } else { age_s + seconds };
            ages_s.iter().enumerate().map(grown).collect::<Vec<f64>>()
        };
        let cost = |seconds: f64| {
            let each = ages_s.iter().enumerate();
            each.map(|(target, age_s)| gathered(problem, target, *age_s, seconds)).sum::<f64>()
        };
        let steps = grid.steps_from(here).iter();
        let value =
            |seconds: f64, to: usize| cost(seconds) - per_s * seconds + grid.value(to, &of(seconds, to), values);
        let each = steps.map(|step| (value(step.seconds, step.to), step));
        let Some((_, step)) = each.min_by(|a, b| a.0.total_cmp(&b.0)) else { break };
        ages_s = of(step.seconds, step.to);
        here = step.to;
        word.push(here);
    }
    let later = VISITS / 2;
    let mut best = (Vec::new(), f64::INFINITY);
    for from in later..word.len().saturating_sub(CYCLE_MAX).min(later + BEGINNINGS) {
        for until in from + 1..from + CYCLE_MAX {
            let Some(cycle) = word.get(from..until).filter(|_| word.get(until) == word.get(from)) else { continue };
            let cost = cost_per_s(problem, cycle);
            if cost < best.1 {
                best = (cycle.to_vec(), cost);
            }
        }
    }
    best
}

/// Returns the expected cost per second of a cycle that is flown endlessly; infinite if it cannot be flown.
pub fn cost_per_s(problem: &SurveillanceProblem, cycle: &[usize]) -> f64 {
    let legs = cycle.iter().zip(cycle.iter().cycle().skip(1));
    let mut ends_s = vec![Vec::new(); problem.targets.len()];
    let mut time_s = 0.0;
    for (from, to) in legs {
        time_s += leg_s(problem, *from, *to);
        if let Some(ends_s) = ends_s.get_mut(*to) {
            ends_s.push(time_s);
        }
    }
    if time_s <= 0.0 || time_s >= UNREACHABLE_S {
        return f64::INFINITY;
    }
    let of_target = |(target, ends_s): (usize, &Vec<f64>)| match ends_s.last() {
        Some(last_s) => {
            let starts = [last_s - time_s].into_iter().chain(ends_s.iter().copied());
            let gaps = ends_s.iter().zip(starts);
            gaps.map(|(end_s, start_s)| gathered(problem, target, 0.0, end_s - start_s)).sum::<f64>() / time_s
        }
        None => problem.targets.get(target).map_or(0.0, |of| events_per_s(of) * eci::cost_at(&of.cost, f64::MAX)),
    };
    ends_s.iter().enumerate().map(of_target).sum()
}
