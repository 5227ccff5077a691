//! Bounds for few targets by the ages of all of them: for one horizon, and for endless flights.
//!
//! After a visit the vehicle is at a target of age zero, and the cost of the rest of the flight depends only on the ages of the others.
//! It is concave in them if the cost of an age is concave: any flight accumulates a concave cost from each target, and the best flight is
//! the minimum over all flights. So values at grid points that are lower bounds stay lower bounds when interpolated linearly in each age,
//! and values of the rest of a flight give values of a flight that is one visit longer. Ages beyond the grid count as the last age of the
//! grid, which is not more expensive. The bounds hold only for flights that never wait.
//! Bound: O(targets x points x 2^targets) for all visits once.

pub mod cycles;
pub mod horizon;

use crate::bounds::least::events_per_s;
use apex_metrics::eci;
use apex_model::problem::{CostFunction, SurveillanceProblem, UNREACHABLE_S};

/// With more targets the grid is too coarse.
pub const TARGETS_MAX: usize = 5;
/// Maximum number of corners of a cell of the grid.
const CORNERS_MAX: usize = 1 << (TARGETS_MAX - 1);
/// Maximum number of ages of a target on the grid.
const LEVELS_MAX: usize = 48;
/// Share of the greatest cost at which the grid ends.
const SATURATED: f64 = 0.995;
/// No cost grows beyond this age.
const LONG_S: f64 = 1e7;
/// Length of the grid where a cost grows without limit, in tours through all targets.
const TOURS: f64 = 20.0;
/// Work of a visit from a point, for each corner of the grid cell, in nanoseconds. Measured over a horizon: 2.0 with 3 targets, 2.1 with
/// 4 and 2.4 with 5; about the same in sweeps.
const STEP_CORNER_NS: f64 = 2.3;
/// Number of bisection steps in the search for an age.
const HALVINGS: usize = 60;

/// A visit from one target to another, for every point of the grid.
#[derive(Debug)]
pub(super) struct GridVisit {
    pub(super) from: usize,
    pub(super) to: usize,
    pub(super) seconds: f64,
    /// Cost that target `from` accumulates during the visit.
    user_cost: f64,
    /// Position of the age of target `from` after the visit, on the grid of target `to`.
    own: Option<GridInterpolation>,
    /// For each age of a point: its position after the visit, and the cost that its target accumulates during it.
    others: Vec<Vec<(Option<GridInterpolation>, f64)>>,
}

/// Position of an age on a grid: the offset of its grid point, its share of the distance to the next point, and the offset of that next
/// point.
#[derive(Clone, Copy, Debug)]
struct GridInterpolation {
    offset: u32,
    share: f64,
    next: u32,
}

/// The grid ages, and all visits between grid points.
#[derive(Debug)]
pub(super) struct Grid {
    levels: Vec<Vec<f64>>,
    /// Visits in the order of the targets from which they depart.
    pub(super) steps: Vec<GridVisit>,
    /// For each row of points the numbers of their ages, except for the first, which is distinguished within the row.
    rows: Vec<Vec<u8>>,
}

impl Grid {
    /// Returns a grid of at most `points_max` points, with ages up to `longest_s` beyond those at the start; `None` if there are too many
    /// targets, a cost is not concave, or travel times depend on the departure.
    pub(super) fn new(problem: &SurveillanceProblem, points_max: usize, longest_s: f64) -> Option<Grid> {
        let count = problem.targets.len();
        let concave = problem.targets.iter().all(|target| is_concave(&target.cost));
        // With travel times that depend on the departure, a slow leg is a fast one followed by a wait, and flights must not wait.
        if count == 0 || count > TARGETS_MAX || !concave || !problem.travel.is_constant() {
            return None;
        }
        let points = |levels: &usize| count * levels.pow(count as u32 - 1);
        let number = (3..=LEVELS_MAX).rev().find(|levels| points(levels) <= points_max)?;
        let levels: Vec<Vec<f64>> = (0..count).map(|target| levels(problem, target, number, longest_s)).collect();
        let digit = |row: usize, place: u32| (row / number.pow(place) % number) as u8;
        let digits = (count as u32).saturating_sub(2);
        let rows = (0..number.pow(digits)).map(|row| (0..digits).map(|place| digit(row, place)).collect()).collect();
        let mut grid = Grid { levels, steps: Vec::new(), rows };
        for from in 0..count {
            let steps = (0..count).filter_map(|to| grid.step(problem, from, to));
            let steps: Vec<GridVisit> = steps.collect();
            grid.steps.extend(steps);
        }
        Some(grid)
    }

    /// Returns the number of points of all targets.
    pub(super) fn size(&self) -> usize {
        self.levels.len() * self.rows.len() * self.row()
    }

    /// Returns the number of visits from all points.
    pub(super) fn visits(&self) -> f64 {
        (self.steps.len() * self.size() / self.levels.len().max(1)) as f64
    }

    /// Returns the work of one visit from one point, in nanoseconds.
    pub(super) fn step_ns(&self) -> f64 {
        STEP_CORNER_NS * libm::exp2(self.levels.len().saturating_sub(2) as f64)
    }

    /// Returns the rows of the points of a target.
    pub(super) fn rows(&self) -> &[Vec<u8>] {
        &self.rows
    }

    /// Sets the value of each point from its target and the ages of all.
    pub(super) fn fill(&self, values: &mut [f64], of: impl Fn(usize, &[f64]) -> f64) {
        let mut ages_s = vec![0.0; self.levels.len()];
        for target in 0..self.levels.len() {
            let own = values.iter_mut().skip(self.first(target));
            let points = self.rows.iter().flat_map(|row| (0..self.row()).map(move |first| (first, row)));
            for (value, (first, row)) in own.zip(points) {
                let digits = [first].into_iter().chain(row.iter().map(|digit| usize::from(*digit)));
                let others =
                    self.levels.iter().zip(ages_s.iter_mut()).enumerate().filter(|(other, _)| *other != target);
                for ((_, (levels, age_s)), digit) in others.zip(digits) {
                    *age_s = levels.get(digit).copied().unwrap_or(0.0);
                }
                *value = of(target, &ages_s);
            }
        }
    }

    /// Returns the visits that follow a visit of this target.
    pub(super) fn steps_from(&self, target: usize) -> &[GridVisit] {
        let begin = self.steps.partition_point(|step| step.from < target);
        let end = self.steps.partition_point(|step| step.from <= target);
        self.steps.get(begin..end).unwrap_or_default()
    }

    /// Returns the index of the first point at a target.
    pub(super) fn first(&self, target: usize) -> usize {
        target * self.rows.len() * self.row()
    }

    fn step(&self, problem: &SurveillanceProblem, from: usize, to: usize) -> Option<GridVisit> {
        let seconds = leg_s(problem, from, to);
        if seconds >= UNREACHABLE_S || seconds <= 0.0 {
            return None;
        }
        let row = |target: usize, levels: &Vec<f64>| {
            let after =
                |age_s: &f64| (self.place(to, target, age_s + seconds), gathered(problem, target, *age_s, seconds));
            levels.iter().map(after).collect()
        };
        let others = self.levels.iter().enumerate().filter(|(target, _)| *target != from);
        Some(GridVisit {
            from,
            to,
            seconds,
            user_cost: gathered(problem, from, 0.0, seconds),
            own: self.place(to, from, seconds),
            others: others.map(|(target, levels)| row(target, levels)).collect(),
        })
    }

    /// Returns the position of an age of `target` among the points at `at`; `None` if `target` is the one just visited, whose age is
    /// zero.
    fn place(&self, at: usize, target: usize, age_s: f64) -> Option<GridInterpolation> {
        let levels = self.levels.get(target).filter(|_| at != target)?;
        let position = if target < at { target } else { target - 1 };
        let distance = levels.len().pow(position as u32);
        let last = levels.len() - 1;
        let below = levels.partition_point(|level| *level <= age_s).saturating_sub(1).min(last - 1);
        let (low, high) = (*levels.get(below)?, *levels.get(below + 1)?);
        let share = ((age_s - low) / (high - low)).clamp(0.0, 1.0);
        Some(GridInterpolation { offset: (below * distance) as u32, share, next: distance as u32 })
    }

    /// Returns the number of ages of the first of the other targets: grid points are stored in rows of this length.
    pub(super) fn row(&self) -> usize {
        if self.levels.len() > 1 { self.levels.first().map_or(1, Vec::len) } else { 1 }
    }

    /// For all points of a row, with these ages of the other targets, computes the cost of a visit plus the value of its destination.
    pub(super) fn ahead(&self, step: &GridVisit, others: &[u8], values: &[f64], sums: &mut [f64]) {
        let mut corners = Corners::new(self.first(step.to));
        let mut cost = step.user_cost;
        corners.split(step.own);
        let mut rows = step.others.iter();
        let first = rows.next();
        for (digit, row) in others.iter().zip(rows) {
            if let Some((place, gathered)) = row.get(usize::from(*digit)) {
                cost += gathered;
                corners.split(*place);
            }
        }
        let Some(first) = first else {
            sums.fill(cost + corners.value(values));
            return;
        };
        let Some(next) = first.first().and_then(|(place, _)| *place).map(|place| place.next as usize) else {
            // The visited target is the first of the other targets: its age before the visit no longer matters.
            let value = cost + corners.value(values);
            sums.iter_mut().zip(first).for_each(|(sum, (_, gathered))| *sum = value + gathered);
            return;
        };
        let mut joined = [0.0; LEVELS_MAX];
        let count = first.len();
        for (at, share) in corners.all.iter().take(corners.count) {
            let values = values.get(*at as usize..).unwrap_or_default().iter().step_by(next);
            joined.iter_mut().take(count).zip(values).for_each(|(joined, value)| *joined += share * value);
        }
        for (sum, (place, gathered)) in sums.iter_mut().zip(first) {
            let Some(place) = place else { continue };
            let low = place.offset as usize / next;
            let pair = joined.get(low).zip(joined.get(low + 1));
            let value = pair.map_or(f64::NAN, |(low, high)| low + place.share * (high - low));
            *sum = cost + gathered + value;
        }
    }

    /// Returns the value of being at a target with these ages of all.
    pub(super) fn value(&self, at: usize, ages_s: &[f64], values: &[f64]) -> f64 {
        let mut corners = Corners::new(self.first(at));
        for (target, age_s) in ages_s.iter().enumerate() {
            corners.split(self.place(at, target, *age_s));
        }
        corners.value(values)
    }
}

/// Corners of the cell in which a point lies, with their shares.
struct Corners {
    all: [(u32, f64); CORNERS_MAX],
    count: usize,
}

impl Corners {
    fn new(first: usize) -> Corners {
        let mut all = [(0, 0.0); CORNERS_MAX];
        if let Some(corner) = all.first_mut() {
            *corner = (first as u32, 1.0);
        }
        Corners { all, count: 1 }
    }

    fn split(&mut self, place: Option<GridInterpolation>) {
        let Some(place) = place else { return };
        let Some((lower, upper)) = self.all.split_at_mut_checked(self.count) else { return };
        for (low, high) in lower.iter_mut().zip(upper) {
            low.0 += place.offset;
            *high = (low.0 + place.next, low.1 * place.share);
            low.1 *= 1.0 - place.share;
        }
        self.count *= 2;
    }

    fn value(&self, values: &[f64]) -> f64 {
        let corners = self.all.iter().take(self.count);
        corners.map(|(at, share)| share * values.get(*at as usize).copied().unwrap_or(f64::NAN)).sum()
    }
}

/// Returns true if the cost of an age grows ever more slowly.
fn is_concave(cost: &CostFunction) -> bool {
    match cost {
        CostFunction::Linear { .. } | CostFunction::Saturating { .. } => true,
        CostFunction::Delayed { cost, .. } => is_concave(cost),
        CostFunction::Step { .. } | CostFunction::Logistic { .. } | CostFunction::Table { .. } => false,
    }
}

/// Returns the ages of the grid: from the least age that a target has when another was just visited, in increasing distances.
fn levels(problem: &SurveillanceProblem, target: usize, number: usize, longest_s: f64) -> Vec<f64> {
    let Some(of) = problem.targets.get(target) else { return Vec::new() };
    let count = problem.targets.len();
    let onward = (0..count).filter(|to| *to != target).map(|to| leg_s(problem, target, to));
    let begun = (0..count).filter(|to| *to != target).map(|to| of.initial_age_s + first_leg_s(problem, to));
    let least_s = onward.chain(begun).fold(LONG_S, f64::min);
    let reached = |age_s: f64| eci::cost_at(&of.cost, age_s);
    let (mut low_s, mut high_s) = (0.0, LONG_S);
    for _ in 0..HALVINGS {
        let middle_s = 0.5 * (low_s + high_s);
        if reached(middle_s) < SATURATED * reached(LONG_S) {
            low_s = middle_s;
        } else {
            high_s = middle_s;
        }
    }
    let grows_without_limit = low_s > 0.5 * LONG_S;
    let last_s = if grows_without_limit { TOURS * tour_s(problem) } else { low_s };
    let span_s = (last_s.min(longest_s + of.initial_age_s) - least_s).max(least_s).max(1.0);
    let share = |level: usize| level as f64 / (number - 1) as f64;
    (0..number).map(|level| least_s + span_s * share(level) * share(level)).collect()
}

fn leg_s(problem: &SurveillanceProblem, from: usize, to: usize) -> f64 {
    problem.travel.between(from, to) + problem.targets.get(to).map_or(0.0, |target| target.dwell_s)
}

fn first_leg_s(problem: &SurveillanceProblem, to: usize) -> f64 {
    problem.travel.start_to(to) + problem.targets.get(to).map_or(0.0, |target| target.dwell_s)
}

/// Returns the time of a tour through all targets in their order, in seconds.
fn tour_s(problem: &SurveillanceProblem) -> f64 {
    let count = problem.targets.len();
    let legs = (0..count).map(|from| leg_s(problem, from, (from + 1) % count));
    legs.filter(|leg_s| *leg_s < UNREACHABLE_S).sum()
}

/// Returns the least cost that a target accumulates while its age grows from `age_s` by `seconds`.
fn gathered(problem: &SurveillanceProblem, target: usize, age_s: f64, seconds: f64) -> f64 {
    let Some(of) = problem.targets.get(target) else { return 0.0 };
    let integral = |age_s: f64| eci::cost_integral(&of.cost, age_s);
    events_per_s(of) * (integral(age_s + seconds) - integral(age_s)).max(0.0)
}

#[cfg(test)]
mod tests;
