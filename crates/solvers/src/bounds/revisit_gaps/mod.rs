//! A bound by the number of times that legs are flown, and the time that groups of targets are without a visit.
//!
//! The linear program represents a plan by the number of times each leg is flown (time and flow are conserved), and by the gaps between
//! observations of each target: `visits + 1` gaps, which fill the horizon plus the target's age. While the vehicle is away from a group
//! of targets, all of them have a gap. A group that is entered `f` times has `f + 1` such absences (`f` if the flight ends in it), and
//! they last as long as the legs within the group leave over. Each target has a chain of growing groups, and each of its gaps a level:
//! the greatest group of the chain whose absence the gap contains. So at most `f + 1` gaps have a group's level or a higher one, and
//! together they last at least as long as its absences. They are longer by the ways between the target and the points where the group is
//! left and entered, except for stays that do not visit the target; there are at most `f + 1` less these gaps of such stays. The cost of the gaps
//! of one level is jointly convex in their number and total length; tangents bound it from below, and further tangents are added where
//! the optimum needs them.
//! Bound: O(targets^2 + targets x levels x tangents) rows, [`ROUNDS_MAX`] programs.

mod groups;
mod program;

use super::least::{events_per_s, ways};
use apex_metrics::eci;
use apex_model::problem::{SurveillanceProblem, SurveillanceTarget, UNREACHABLE_S};
use apex_planning::meter::Meter;
use program::{LinearProgram, STEPS_MAX};

/// With more targets the program has too many legs, and no bound is sought in this way.
pub const TARGETS_MAX: usize = 48;
/// Number of programs solved; each adds tangents where the previous solution needed them.
pub const ROUNDS_MAX: usize = 4;
/// Number of tangents of each level in the first program, at gap lengths in geometric progression.
const TANGENTS: usize = 12;
/// Number of chords that bound the cost of a target from below, each between successive numbers of visits: only integers occur.
const CHORDS: u32 = 12;
/// Tangents are added where the cost is understated by more than this share of all cost.
const UNDERSTATED: f64 = 1e-5;
/// More visits than any plan has.
const VISITS_MAX: f64 = 1e5;

/// Expected number of steps of the solver.
const STEPS_USUAL: f64 = 40.0;
/// Numbers of groups of a target, if the budget is too small for the whole chain: as many as fit.
const GROUPS: [usize; 9] = [0, 1, 2, 4, 6, 8, 12, 16, 24];
/// Work of making an entry of a program, in nanoseconds.
const MADE_ENTRY_NS: f64 = 60.0;

/// Proof of a bound by revisit gaps: the tangents that were added, and a multiplier for each row.
#[derive(Clone, Debug, PartialEq)]
pub struct Multipliers {
    /// Greatest number of groups of each target.
    groups_max: usize,
    /// Index of the level of each added tangent, and the gap at which it touches the cost, as a share of the horizon.
    tangents: Vec<(usize, f64)>,
    of_rows: Vec<f64>,
}

/// Returns the best bound found with its certificate; `None` if there are too many targets, the solver fails, or the budget is too small
/// for the smallest program.
pub fn expected_cost(problem: &SurveillanceProblem, meter: &mut Meter<'_>) -> Option<(f64, Multipliers)> {
    if problem.targets.len() > TARGETS_MAX {
        return None;
    }
    let (mut model, groups_max) = fitting(problem, meter)?;
    let mut tangents = Vec::new();
    let mut best: Option<(f64, Multipliers)> = None;
    for round in 0..ROUNDS_MAX {
        let step_ns = model.program.step_ns();
        let steps_max = (meter.left_ns() / step_ns).min(f64::from(STEPS_MAX)) as u32;
        // A program that is interrupted far from its optimum proves next to nothing.
        if round > 0 && f64::from(steps_max) < STEPS_USUAL {
            meter.cut();
            break;
        }
        let Some(answer) = model.program.solve(steps_max) else { break };
        meter.spend(f64::from(answer.steps + 1) * step_ns);
        if answer.steps >= steps_max && steps_max < STEPS_MAX {
            meter.cut();
        }
        let value = model.program.proven(&answer.multipliers) * model.cost_unit;
        if best.as_ref().is_none_or(|(before, _)| value > *before) {
            best = Some((value, Multipliers { groups_max, tangents: tangents.clone(), of_rows: answer.multipliers }));
        }
        let wanted = model.understated(&answer.columns);
        if wanted.is_empty() {
            break;
        }
        wanted.iter().for_each(|(level, at)| model.tangent(*level, *at));
        tangents.extend(wanted);
    }
    best
}

/// Returns the largest program that the budget permits, and the number of groups of each target in it.
fn fitting<'a>(problem: &'a SurveillanceProblem, meter: &mut Meter<'_>) -> Option<(Model<'a>, usize)> {
    let mut greatest = None;
    let fewer = GROUPS.into_iter().filter(|groups| groups + 1 < problem.targets.len());
    for groups_max in fewer.chain([usize::MAX]) {
        let model = Model::new(problem, groups_max)?;
        meter.spend(MADE_ENTRY_NS * model.program.entries());
        if STEPS_USUAL * model.program.step_ns() > meter.left_ns() {
            meter.cut();
            break;
        }
        greatest = Some((model, groups_max));
    }
    greatest
}

/// Returns the bound that the multipliers prove, computed from the problem and the multipliers alone.
pub fn verified(problem: &SurveillanceProblem, multipliers: &Multipliers) -> f64 {
    let Some(mut model) = Model::new(problem, multipliers.groups_max) else { return 0.0 };
    multipliers.tangents.iter().for_each(|(level, at)| model.tangent(*level, *at));
    (model.program.proven(&multipliers.of_rows) * model.cost_unit).max(0.0)
}

/// The gaps of one level of one target: their number, total length and cost.
struct Level {
    target: usize,
    /// The column of their number, and the constant added to it.
    count: (usize, f64),
    /// The column of their length; `None` if it is the whole time of the target.
    length: Option<usize>,
    cost: usize,
}

/// The program of a problem. Times are relative to the horizon, costs relative to the cost of staying at home.
struct Model<'a> {
    problem: &'a SurveillanceProblem,
    program: LinearProgram,
    cost_unit: f64,
    legs: Vec<(usize, usize, usize, f64)>,
    first_legs: Vec<(usize, usize, f64)>,
    visits: Vec<usize>,
    ends: Vec<usize>,
    waits: Vec<usize>,
    levels: Vec<Level>,
    /// Shortest time from the end of one target's observation to that of another's, with detours over other targets.
    ways: Vec<Vec<f64>>,
}

impl<'a> Model<'a> {
    fn new(problem: &'a SurveillanceProblem, groups_max: usize) -> Option<Model<'a>> {
        let at_home = problem.targets.iter().map(|target| gathered(target, span_s(problem, target)));
        let cost_unit: f64 = at_home.sum();
        if !(cost_unit > 0.0 && cost_unit.is_finite() && problem.horizon_s > 0.0) {
            return None;
        }
        let (legs, first_legs, visits, ends) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let (program, waits, levels) = (LinearProgram::default(), Vec::new(), Vec::new());
        let ways = ways(problem);
        let mut model = Model { problem, program, cost_unit, legs, first_legs, visits, ends, waits, levels, ways };
        model.flight();
        for target in 0..problem.targets.len() {
            model.whole(target);
        }
        let between = |from: usize, to: usize| problem.travel.between(from, to);
        let chains = groups::chains(problem.targets.len(), between, UNREACHABLE_S);
        for (target, chain) in chains.iter().enumerate() {
            model.chain(target, &groups::thinned(chain, groups_max));
        }
        let first = 0.25 / (problem.targets.len() as f64 * TANGENTS as f64);
        for level in 0..model.levels.len() {
            for number in 0..TANGENTS {
                model.tangent(level, libm::pow(first, number as f64 / (TANGENTS - 1) as f64));
            }
        }
        Some(model)
    }

    /// Adds the columns of the legs, and the rows of their flow through each target and their total time.
    fn flight(&mut self) {
        let (problem, horizon_s) = (self.problem, self.problem.horizon_s);
        let travel = &problem.travel;
        let limit_s = problem.endurance_s.unwrap_or(horizon_s).min(horizon_s);
        let mut flown = Vec::new();
        let mut home = Vec::new();
        for (to, target) in problem.targets.iter().enumerate() {
            let ends_s = if problem.return_to_base { travel.to_base(to) } else { 0.0 };
            let wait = self.program.column(0.0, 1.0);
            self.visits.push(self.program.column(0.0, visits_max(problem, target.dwell_s)));
            self.ends.push(self.program.column(0.0, 1.0));
            self.waits.push(wait);
            home.push((to, ends_s));
            let start_s = travel.start_to(to);
            if start_s < UNREACHABLE_S {
                let leg_s = start_s + target.dwell_s;
                let column = self.program.column(0.0, 1.0);
                self.first_legs.push((to, column, leg_s / horizon_s));
                flown.push((column, leg_s / horizon_s));
            }
            for from in 0..problem.targets.len() {
                let leg_s = travel.between(from, to) + target.dwell_s;
                if leg_s < UNREACHABLE_S {
                    let column = self.program.column(0.0, visits_max(problem, leg_s));
                    self.legs.push((from, to, column, leg_s / horizon_s));
                    flown.push((column, leg_s / horizon_s));
                }
            }
        }
        let waited = self.waits.iter().map(|wait| (*wait, 1.0));
        self.program.at_most(flown.iter().copied().chain(waited).collect(), 1.0);
        let homeward =
            home.iter().zip(&self.ends).map(|((_, home_s), end)| (*end, home_s.min(2.0 * limit_s) / horizon_s));
        self.program.at_most(flown.into_iter().chain(homeward).collect(), limit_s / horizon_s);
        self.program.at_most(self.first_legs.iter().map(|(_, column, _)| (*column, 1.0)).collect(), 1.0);
        for (target, (visits, end)) in self.visits.iter().zip(&self.ends).enumerate() {
            let into = self.legs.iter().filter(|(_, to, ..)| *to == target).map(|(_, _, column, _)| *column);
            let first = self.first_legs.iter().filter(|(to, ..)| *to == target).map(|(_, column, _)| *column);
            let arrivals = into.chain(first).map(|column| (column, 1.0)).chain([(*visits, -1.0)]);
            self.program.equal(arrivals.collect(), 0.0);
            let out = self.legs.iter().filter(|(from, ..)| *from == target).map(|(_, _, column, _)| (*column, 1.0));
            self.program.equal(out.chain([(*end, 1.0), (*visits, -1.0)]).collect(), 0.0);
        }
    }

    fn target(&self, target: usize) -> Option<(&'a SurveillanceTarget, usize)> {
        Some((self.problem.targets.get(target)?, *self.visits.get(target)?))
    }

    /// Adds the target's cost, which is never below that of equal gaps.
    fn whole(&mut self, target: usize) {
        let Some((of, visits)) = self.target(target) else { return };
        let span_s = span_s(self.problem, of);
        let most = gathered(of, span_s) / self.cost_unit;
        let cost = self.program.column(1.0, most);
        self.levels.push(Level { target, count: (visits, 1.0), length: None, cost });
        let in_parts = |parts: f64| parts * gathered(of, span_s / parts) / self.cost_unit;
        for number in 0..CHORDS {
            let (number, here) = (f64::from(number), in_parts(f64::from(number) + 1.0));
            let slope = in_parts(number + 2.0) - here;
            self.program.at_most(vec![(visits, slope), (cost, -1.0)], slope * number - here);
        }
    }

    /// Adds the target's gaps by their levels in a chain of groups, which begins with the target alone.
    fn chain(&mut self, target: usize, chain: &[Vec<usize>]) {
        let (Some((of, visits)), Some(whole)) = (self.target(target), self.levels.get(target)) else { return };
        let (span, whole) = (span_s(self.problem, of) / self.problem.horizon_s, whole.cost);
        let most = gathered(of, span * self.problem.horizon_s) / self.cost_unit;
        let mut columns = Vec::new();
        let gaps_max = visits_max(self.problem, of.dwell_s) + 1.0;
        for _ in 0..=chain.len() {
            let (count, length) = (self.program.column(0.0, gaps_max), self.program.column(0.0, span));
            let cost = self.program.column(0.0, most);
            columns.push((count, length, cost));
            self.levels.push(Level { target, count: (count, 0.0), length: Some(length), cost });
        }
        let counts = columns.iter().map(|(count, ..)| (*count, 1.0));
        self.program.equal(counts.chain([(visits, -1.0)]).collect(), 1.0);
        self.program.equal(columns.iter().map(|(_, length, _)| (*length, 1.0)).collect(), span);
        let costs = columns.iter().map(|(.., cost)| (*cost, 1.0));
        self.program.at_most(costs.chain([(whole, -1.0)]).collect(), 0.0);
        for (below, group) in chain.iter().enumerate() {
            let above = columns.iter().skip(below + 1);
            let counts: Vec<usize> = above.clone().map(|(count, ..)| *count).collect();
            let lengths: Vec<usize> = above.map(|(_, length, _)| *length).collect();
            self.absences(target, group, &counts, &lengths);
        }
    }

    /// Bounds the gaps that hold absences of the group: their greatest number and their least total duration.
    fn absences(&mut self, target: usize, group: &[usize], counts: &[usize], lengths: &[usize]) {
        let inside = |place: usize| group.binary_search(&place).is_ok();
        let way = |from: usize, to: usize| {
            self.ways.get(from).and_then(|ways| ways.get(to)).copied().unwrap_or(0.0) / self.problem.horizon_s
        };
        let longest = |ways: &mut dyn Iterator<Item = f64>| ways.fold(0.0, f64::max);
        let detour = longest(&mut group.iter().map(|from| way(*from, target)))
            + longest(&mut group.iter().map(|to| way(target, *to)));
        let first = self.first_legs.iter().filter(|(to, ..)| inside(*to)).map(|(to, column, _)| (*to, *column));
        let later = self.legs.iter().filter(|(from, to, ..)| inside(*to) && !inside(*from));
        let entries: Vec<(usize, usize)> = first.chain(later.map(|(_, to, column, _)| (*to, *column))).collect();
        let ends = self.ends.iter().enumerate().filter(|(place, _)| inside(*place)).map(|(_, end)| (*end, 1.0));
        let counted = counts.iter().map(|count| (*count, 1.0));
        let entered = entries.iter().map(|(_, column)| (*column, -1.0));
        self.program.at_most(counted.chain(entered).chain(ends).collect(), 1.0);

        let within = self.legs.iter().filter(|(from, to, ..)| inside(*from) && inside(*to));
        let within = within.map(|(.., column, leg)| (*column, -leg));
        let waited = self.waits.iter().enumerate().filter(|(place, _)| inside(*place)).map(|(_, wait)| (*wait, -1.0));
        let lasting = lengths.iter().map(|length| (*length, -1.0));
        let mut terms: Vec<(usize, f64)> = lasting.chain(within).chain(waited).collect();
        self.program.at_most(terms.clone(), -1.0);
        if detour > 0.0 {
            let exits = self.legs.iter().filter(|(from, to, ..)| inside(*from) && !inside(*to));
            terms.extend(exits.map(|(from, _, column, _)| (*column, way(target, *from))));
            terms.extend(entries.iter().map(|(to, column)| (*column, way(*to, target) - detour)));
            terms.extend(counts.iter().map(|count| (*count, detour)));
            self.program.at_most(terms, detour - 1.0);
        }
    }

    /// Adds a tangent to the cost of the level's gaps, at gaps of this share of the horizon.
    fn tangent(&mut self, level: usize, at: f64) {
        let Some(Level { target, count, length, cost }) = self.levels.get(level) else { return };
        let Some(of) = self.problem.targets.get(*target) else { return };
        let at_s = at * self.problem.horizon_s;
        let each_s = events_per_s(of) * eci::cost_at(&of.cost, at_s);
        let slope = each_s * self.problem.horizon_s / self.cost_unit;
        let base = (gathered(of, at_s) - each_s * at_s) / self.cost_unit;
        let mut terms = vec![(count.0, base), (*cost, -1.0)];
        let mut limit = -base * count.1;
        match length {
            Some(length) => terms.push((*length, slope)),
            None => limit -= slope * span_s(self.problem, of) / self.problem.horizon_s,
        }
        self.program.at_most(terms, limit);
    }

    /// Returns the levels whose cost the tangents underestimate in this solution, each with its gap as a share of the horizon.
    fn understated(&self, columns: &[f64]) -> Vec<(usize, f64)> {
        let value = |column: usize| columns.get(column).copied().unwrap_or(0.0);
        let understated = |(number, level): (usize, &Level)| {
            let of = self.problem.targets.get(level.target)?;
            let count = value(level.count.0) + level.count.1;
            let whole = span_s(self.problem, of) / self.problem.horizon_s;
            let at = level.length.map_or(whole, value) / count.max(1e-6);
            let truth = count * gathered(of, at * self.problem.horizon_s) / self.cost_unit;
            (at > 0.0 && at <= whole && truth - value(level.cost) > UNDERSTATED).then_some((number, at))
        };
        self.levels.iter().enumerate().filter_map(understated).collect()
    }
}

/// Returns more visits than any plan has, if each takes `each_s`.
fn visits_max(problem: &SurveillanceProblem, each_s: f64) -> f64 {
    (problem.horizon_s / each_s.max(problem.horizon_s / VISITS_MAX)).min(VISITS_MAX) + 1.0
}

/// Returns the least cost that a gap of that length accumulates.
fn gathered(target: &SurveillanceTarget, gap_s: f64) -> f64 {
    events_per_s(target) * eci::cost_integral(&target.cost, gap_s)
}

/// Returns the time over which the target costs: the horizon and its age at the start.
fn span_s(problem: &SurveillanceProblem, target: &SurveillanceTarget) -> f64 {
    problem.horizon_s + target.initial_age_s
}

#[cfg(test)]
mod tests;
