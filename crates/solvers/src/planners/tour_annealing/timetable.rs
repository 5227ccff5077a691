//! A tour with all data that are needed to compute the cost of a change without flying the tour again.
//!
//! For every position in the tour two rows are kept, with one number per target: the time since each target was last observed when the
//! position is left, and the time until each is next observed. The cost of a change then consists of its inserted visits and two
//! intervals per target: the one across the change and the open one at the end.
//! Bound: O(targets + inserted visits) to price a change, O(visits x targets) to carry it out.

use super::change::Change;
use super::interval::{Closing, Intervals, LANES};
use super::rows::Rows;
use apex_model::problem::UNREACHABLE_S;
use apex_planning::surveillance::scenario::Scenario;
use wide::f64x4;

/// Maximum number of row entries of one tour: 64 MB in all.
pub(super) const NUMBERS_MAX: usize = 2_000_000;

/// Work in nanoseconds: of computing the cost of a change, for each inserted visit and for each four targets; of applying a change, for
/// each row and for each four targets of a row.
const PRICE_NS: u64 = 170;
const LETTER_NS: u64 = 25;
const LANE_NS: u64 = 25;
const CHANGE_NS: u64 = 300;
const ROW_NS: u64 = 12;
const ROW_LANE_NS: u64 = 3;

/// The tour with two rows per position. A position is a gap before, between or after visits; its number is that of the visits before it.
#[derive(Clone, Debug)]
pub(super) struct Timetable<'s, 'p> {
    scenario: &'s Scenario<'p>,
    intervals: Intervals,
    tour: Vec<usize>,
    /// End of each visit.
    ends_s: Vec<f64>,
    /// Cost of the interval that each visit closes.
    costs: Vec<f64>,
    /// By position: the sum of the closed intervals before it.
    closed: Vec<f64>,
    /// Number of flown visits; the others come too late.
    flown: usize,
    /// By position: time from the end of each target's last observation to the end of the visit before the position.
    since_s: Rows<f64x4>,
    /// By position: the first visit of each target from the position on.
    ahead: Rows<Ahead>,
    scratch: Vec<f64x4>,
    /// Marks of targets: the number of the sweep that set them.
    marks: Vec<u64>,
    sweep: u64,
    /// Rows that the last change has written, of both kinds.
    rows_written: usize,
    cost: f64,
}

impl<'s, 'p> Timetable<'s, 'p> {
    /// Returns the timetable of `tour`.
    pub(super) fn new(scenario: &'s Scenario<'p>, intervals: Intervals, tour: Vec<usize>) -> Timetable<'s, 'p> {
        let count = scenario.problem().targets.len();
        let width = count.div_ceil(LANES);
        let mut table = Timetable {
            scenario,
            intervals,
            tour: Vec::new(),
            ends_s: Vec::new(),
            costs: Vec::new(),
            closed: vec![0.0],
            flown: 0,
            since_s: Rows::new(width, f64x4::ZERO),
            ahead: Rows::new(width, Ahead::NEVER),
            scratch: Vec::new(),
            marks: vec![0; count],
            sweep: 0,
            rows_written: 0,
            cost: 0.0,
        };
        table.since_s.splice(0, 0, 1);
        table.ahead.splice(0, 0, 1);
        for (index, target) in scenario.problem().targets.iter().enumerate() {
            if let Some(lanes) = table.since_s.at_mut(0).get_mut(index / LANES) {
                set(lanes, index, target.initial_age_s);
            }
        }
        table.replace(tour);
        table
    }

    /// Returns the tour, including visits beyond the flown ones.
    pub(super) fn tour(&self) -> &[usize] {
        &self.tour
    }

    /// Returns the number of flown visits.
    pub(super) fn flown(&self) -> usize {
        self.flown
    }

    /// Returns the cost of the tour.
    pub(super) fn cost(&self) -> f64 {
        self.cost
    }

    /// Returns the problem that is flown.
    pub(super) fn scenario(&self) -> &'s Scenario<'p> {
        self.scenario
    }

    /// Returns the work of pricing a change, in nanoseconds.
    pub(super) fn price_ns(&self, change: &Change) -> u64 {
        PRICE_NS + change.letters().count() as u64 * LETTER_NS + self.intervals.lanes().len() as u64 * LANE_NS
    }

    /// Returns the work of carrying out the last change, in nanoseconds.
    pub(super) fn change_ns(&self) -> u64 {
        let (rows, lanes) = (self.rows_written as u64, self.intervals.lanes().len() as u64);
        CHANGE_NS + rows * (ROW_NS + lanes * ROW_LANE_NS) + self.tour.len() as u64 * LETTER_NS / 8
    }

    /// Carries a change out.
    pub(super) fn apply(&mut self, change: &Change) {
        let until = change.until.min(self.tour.len());
        let put_in = change.letters().count();
        self.splice(change.from, until, change.letters(), put_in);
    }

    /// Takes another tour.
    pub(super) fn replace(&mut self, tour: Vec<usize>) {
        let (old, new) = (self.tour.len(), tour.len());
        self.splice(0, old, tour.into_iter(), new);
    }

    fn splice(&mut self, from: usize, until: usize, letters: impl Iterator<Item = usize>, count: usize) {
        self.tour.splice(from..until, letters);
        self.ends_s.splice(from..until, std::iter::repeat_n(0.0, count));
        self.costs.splice(from..until, std::iter::repeat_n(0.0, count));
        self.closed.resize(self.tour.len() + 1, 0.0);
        // Times since an observation belong to the positions after a visit, times until one to the positions before it.
        self.since_s.splice(from + 1, until + 1, count);
        self.ahead.splice(from, until, count);
        self.fly(from);
        let settled = self.look_back(from, from + count);
        let ahead = self.look_ahead(from, settled);
        self.rows_written = settled.saturating_sub(from) + settled.saturating_sub(ahead);
        let left_s = self.scenario.problem().horizon_s - self.end_before(self.flown);
        let left_s = f64x4::splat(left_s);
        let open = self.since_s.at(self.flown).iter().zip(self.intervals.lanes());
        let open = open.fold(f64x4::ZERO, |sum, (since_s, lane)| sum + lane.cost(*since_s + left_s));
        self.cost = self.closed.get(self.flown).copied().unwrap_or(0.0) + open.reduce_add();
    }

    fn leg_s(&self, from: Option<usize>, to: usize) -> f64 {
        let travel = &self.scenario.problem().travel;
        from.map_or_else(|| travel.start_to(to), |from| travel.between(from, to))
    }

    fn dwell_s(&self, target: usize) -> f64 {
        self.scenario.problem().targets.get(target).map_or(0.0, |target| target.dwell_s)
    }

    /// Returns the time from a target to the base; 0 if the flight may end anywhere.
    fn home_s(&self, target: usize) -> f64 {
        if self.scenario.problem().return_to_base { self.scenario.problem().travel.to_base(target) } else { 0.0 }
    }

    fn end_before(&self, place: usize) -> f64 {
        place.checked_sub(1).and_then(|last| self.ends_s.get(last)).copied().unwrap_or(0.0)
    }

    /// Computes the times of the visits from `from` on, and how many are flown.
    fn fly(&mut self, from: usize) {
        let mut place = from.checked_sub(1).and_then(|last| self.tour.get(last)).copied();
        let mut time_s = self.end_before(from);
        let mut open = self.flown >= from;
        self.flown = self.flown.min(from);
        for index in from..self.tour.len() {
            let Some(target) = self.tour.get(index).copied() else { break };
            // If no path exists, later visits are far too late, by an amount at which their times keep their digits.
            time_s += self.leg_s(place, target).min(2.0 * self.scenario.limit_s()) + self.dwell_s(target);
            place = Some(target);
            open &= time_s + self.home_s(target) <= self.scenario.limit_s();
            if open {
                self.flown = index + 1;
            }
            if let Some(end_s) = self.ends_s.get_mut(index) {
                *end_s = time_s;
            }
        }
    }

    /// Updates the times since the last observations for the positions after `from`, where a change begins whose visits end before
    /// `until`. Ends at the position before which every target has been visited since `until`: later rows do not change. Returns it.
    fn look_back(&mut self, from: usize, until: usize) -> usize {
        self.sweep += 1;
        let (mut missing, mut before_s) = (self.marks.len(), self.end_before(from));
        let mut settled = self.tour.len();
        for index in from..self.tour.len() {
            let (Some(target), Some(end_s)) = (self.tour.get(index).copied(), self.ends_s.get(index).copied()) else {
                break;
            };
            let step_s = f64x4::splat(end_s - before_s);
            self.since_s.derive(index + 1, index, |since_s| since_s + step_s);
            if let Some(lanes) = self.since_s.at_mut(index + 1).get_mut(target / LANES) {
                let since_s = lanes.as_array().get(target % LANES).copied().unwrap_or(0.0);
                set(lanes, target, 0.0);
                if let Some(cost) = self.costs.get_mut(index) {
                    *cost = self.intervals.cost(target, since_s);
                }
            }
            before_s = end_s;
            if index >= until && self.mark(target) {
                missing -= 1;
                if missing == 0 {
                    settled = index + 1;
                    break;
                }
            }
        }
        let mut sum = self.closed.get(from).copied().unwrap_or(0.0);
        let sums = self.closed.iter_mut().skip(from + 1);
        for (slot, cost) in sums.zip(self.costs.iter().skip(from)) {
            sum += cost;
            *slot = sum;
        }
        settled
    }

    /// Returns true if this sweep had not marked the target yet, and marks it.
    fn mark(&mut self, target: usize) -> bool {
        let sweep = self.sweep;
        self.marks.get_mut(target).is_some_and(|mark| std::mem::replace(mark, sweep) != sweep)
    }

    /// Updates the next visits for the positions before `settled`, back to the position from which every target is visited before a
    /// change at `from`. Returns that position.
    fn look_ahead(&mut self, from: usize, settled: usize) -> usize {
        self.sweep += 1;
        let mut missing = self.marks.len();
        for index in (0..settled).rev() {
            let Some(target) = self.tour.get(index).copied() else { continue };
            let (end_s, next_s) = (self.ends_s.get(index), self.ends_s.get(index + 1));
            let step_s = f64x4::splat(end_s.zip(next_s).map_or(0.0, |(end_s, next_s)| next_s - end_s));
            self.ahead.derive(index, index + 1, |ahead| Ahead {
                until_s: ahead.until_s + step_s,
                visits: ahead.visits + f64x4::ONE,
                cost: ahead.cost,
            });
            if let Some(ahead) = self.ahead.at_mut(index).get_mut(target / LANES) {
                set(&mut ahead.until_s, target, 0.0);
                set(&mut ahead.visits, target, 0.0);
                set(&mut ahead.cost, target, self.costs.get(index).copied().unwrap_or(0.0));
            }
            if index < from && self.mark(target) {
                missing -= 1;
                if missing == 0 {
                    return index;
                }
            }
        }
        0
    }

    /// Returns the cost of the tour with `change`, which begins among the flown visits; infinite if no path exists.
    pub(super) fn cost_with(&mut self, change: &Change) -> f64 {
        let mut scratch = std::mem::take(&mut self.scratch);
        scratch.clear();
        scratch.extend_from_slice(self.since_s.at(change.from));
        let cost = self.price(change, &mut scratch);
        self.scratch = scratch;
        cost
    }

    /// Returns the cost of a change; `since_s` holds for each target the time since its last end at the change, and is used up.
    fn price(&self, change: &Change, since_s: &mut [f64x4]) -> f64 {
        let limit_s = self.scenario.limit_s();
        let base_s = self.end_before(change.from);
        let mut place = change.from.checked_sub(1).and_then(|last| self.tour.get(last)).copied();
        let mut time_s = base_s;
        let mut closing = Closing::new();
        let mut too_late = false;
        for target in change.letters() {
            let leg_s = self.leg_s(place, target);
            let home_s = self.home_s(target);
            if leg_s >= UNREACHABLE_S || home_s >= UNREACHABLE_S {
                return f64::INFINITY;
            }
            let end_s = time_s + leg_s + self.dwell_s(target);
            too_late = end_s + home_s > limit_s;
            if too_late {
                break;
            }
            (place, time_s) = (Some(target), end_s);
            let lanes = since_s.get_mut(target / LANES).map(f64x4::as_mut_array);
            if let Some(since_s) = lanes.and_then(|lanes| lanes.get_mut(target % LANES)) {
                closing.push((target, *since_s + (time_s - base_s)));
                *since_s = base_s - time_s;
            }
        }
        let cost = self.intervals.add(self.closed.get(change.from).copied().unwrap_or(0.0), &closing);
        if too_late {
            return cost + self.open(since_s, base_s);
        }
        let Some((next, old_end_s)) = self.tour.get(change.until).zip(self.ends_s.get(change.until)) else {
            return cost + self.open(since_s, base_s);
        };
        let leg_s = self.leg_s(place, *next);
        if leg_s >= UNREACHABLE_S {
            return f64::INFINITY;
        }
        let new_end_s = time_s + leg_s + self.dwell_s(*next);
        let shift_s = new_end_s - old_end_s;
        let flown = self.flown_with(change.until, shift_s);
        if flown <= change.until {
            return cost + self.open(since_s, base_s);
        }
        let closed = |place: usize| self.closed.get(place).copied().unwrap_or(0.0);
        let after = After { place: change.until, flown, next_s: new_end_s - base_s, shift_s, base_s };
        cost + closed(flown) - closed(change.until) + self.across(since_s, &after)
    }

    /// Returns the number of flown visits if those from `place` on are shifted by `shift_s`.
    fn flown_with(&self, place: usize, shift_s: f64) -> usize {
        let limit_s = self.scenario.limit_s();
        let in_time = |index: usize| {
            let visit = self.tour.get(index).zip(self.ends_s.get(index));
            visit.is_some_and(|(target, end_s)| end_s + shift_s + self.home_s(*target) <= limit_s)
        };
        let mut flown = self.flown.max(place);
        if shift_s <= 0.0 || self.flown <= place {
            while in_time(flown) {
                flown += 1;
            }
            return flown;
        }
        if self.scenario.problem().return_to_base {
            // The way home differs between targets, so the first late visit may be at any position.
            return (place..self.flown).find(|index| !in_time(*index)).unwrap_or(self.flown);
        }
        while flown > place && !in_time(flown - 1) {
            flown -= 1;
        }
        flown
    }

    /// Returns the open intervals of all targets when nothing is flown after the change.
    fn open(&self, since_s: &[f64x4], base_s: f64) -> f64 {
        let left_s = f64x4::splat(self.scenario.problem().horizon_s - base_s);
        let open = since_s.iter().zip(self.intervals.lanes());
        open.fold(f64x4::ZERO, |sum, (since_s, lane)| sum + lane.cost(*since_s + left_s)).reduce_add()
    }

    /// Returns the cost of the intervals across the change and of the open ones at the end, less that of the intervals that the first
    /// visits after it closed before.
    fn across(&self, since_s: &[f64x4], after: &After) -> f64 {
        let horizon_s = self.scenario.problem().horizon_s;
        let alone_s = f64x4::splat(horizon_s - after.base_s);
        let left_s = f64x4::splat(horizon_s - (self.end_before(after.flown) + after.shift_s));
        let next_s = f64x4::splat(after.next_s);
        let limit = f64x4::splat((after.flown - after.place) as f64);
        let rows = since_s.iter().zip(self.ahead.at(after.place));
        let rows = rows.zip(self.since_s.at(after.flown).iter().zip(self.intervals.lanes()));
        let mut sum = f64x4::ZERO;
        for ((since_s, ahead), (last_s, lane)) in rows {
            let seen = ahead.visits.simd_lt(limit);
            let span_s = *since_s + seen.select(next_s + ahead.until_s, alone_s);
            let end_s = seen.select(*last_s + left_s, f64x4::ZERO);
            sum += lane.cost(span_s) + lane.cost(end_s) - seen.select(ahead.cost, f64x4::ZERO);
        }
        sum.reduce_add()
    }
}

/// The first visits of [`LANES`] targets from a position on.
#[derive(Clone, Copy, Debug)]
struct Ahead {
    /// Time from the end of the first visit after the position to their ends.
    until_s: f64x4,
    /// Number of visits between the position and them; infinite without a further visit.
    visits: f64x4,
    /// Cost of the intervals that they close.
    cost: f64x4,
}

impl Ahead {
    /// No further visit.
    const NEVER: Ahead =
        Ahead { until_s: f64x4::splat(f64::INFINITY), visits: f64x4::splat(f64::INFINITY), cost: f64x4::ZERO };
}

/// Sets the number of one target among its lanes.
#[inline(always)]
fn set(lanes: &mut f64x4, target: usize, number: f64) {
    if let Some(slot) = lanes.as_mut_array().get_mut(target % LANES) {
        *slot = number;
    }
}

/// The visits that follow a change.
struct After {
    /// Index of the first visit after the change, counted as before the change.
    place: usize,
    /// Visits that are flown, counted as before the change.
    flown: usize,
    /// Time from `base_s` to the end of the first visit after the change.
    next_s: f64,
    /// Delay of the visits after the change.
    shift_s: f64,
    /// End of the visit before the change.
    base_s: f64,
}

#[cfg(test)]
mod tests {
    use super::*;
    use apex_planning::examples::surveillance as examples;
    use apex_planning::random::Generator;
    use apex_planning::solver::WorkBudget;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_priced_change_costs_what_the_changed_tour_costs(
            seed in 0..1000_u64, count in 1..9_usize, length in 0..60_usize, home: bool, old in 0.0..900.0f64,
            side in 500.0..16_000.0f64,
        ) {
            let mut problem = examples::sized(count, seed, side);
            problem.return_to_base = home;
            problem.targets[0].initial_age_s = old;
            let scenario = Scenario::new(&problem).unwrap();
            let mut random = Generator::new(seed);
            let tour: Vec<usize> = (0..length).map(|_| random.below(count)).collect();
            let intervals = Intervals::of(&problem).unwrap();
            let mut table = Timetable::new(&scenario, intervals, tour);
            for _ in 0..30 {
                let from = random.below(table.flown() + 1);
                let until = (from + random.below(5)).min(table.tour().len());
                let letters = random.below(6);
                let change = Change::cut(from, until).with_all((0..letters).map(|_| random.below(count)));
                let mut changed = table.tour().to_vec();
                change.apply(&mut changed);
                let exact = scenario.cost(changed, &mut WorkBudget::new(1));
                let priced = table.cost_with(&change);
                prop_assert!((exact - priced).abs() <= 1e-8 * exact, "{exact} {priced} {change:?}");
                if random.below(3) == 0 {
                    table.apply(&change);
                    prop_assert!((exact - table.cost()).abs() <= 1e-8 * exact, "{exact} {}", table.cost());
                }
            }
        }
    }
}
