//! Every order of visits of a single-visit problem with given travel times, by plain enumeration.
//!
//! It shares only the problem's data types with planners and checkers: legs, windows, order, limits and values are computed here, as
//! `docs/reference/planning-problems.md` defines them.

use apex_model::problem::{SingleVisitProblem, SingleVisitTarget, TravelTimes, UNREACHABLE_S};

/// Returns the greatest sum of values of any plan, less the costs of missed targets that must be observed. Times must be kept with a reserve of `margin_s`; a negative margin is a tolerance.
pub(crate) fn greatest_benefits(problem: &SingleVisitProblem, margin_s: f64) -> f64 {
    let worth_max = problem
        .targets
        .iter()
        .map(|target| {
            let quality = target.manoeuvres.iter().map(quality).fold(0.0, f64::max);
            let timing = target.timing.iter().map(|(_, factor)| *factor).fold(0.0, f64::max);
            let cost = target.must.map_or(0.0, |must| must.cost);
            target.value * quality * if target.timing.is_empty() { 1.0 } else { timing } + cost
        })
        .collect();
    let earlier = (0..problem.targets.len()).map(|later| earlier_of(problem, later)).collect();
    let idle = -all_missed(problem);
    let mut orders = Orders { problem, margin_s, limit_s: limit_s(problem), worth_max, earlier, best: idle };
    orders.extend(None, problem.start_s, 0, idle);
    orders.best
}

/// Returns the costs of missing all targets that must be observed.
pub(crate) fn all_missed(problem: &SingleVisitProblem) -> f64 {
    problem.targets.iter().filter_map(|target| target.must).map(|must| must.cost).sum()
}

/// Returns the value of an observation, and the cost that it avoids.
fn gained_by(target: &SingleVisitTarget, factor: f64) -> f64 {
    let avoided = target.must.filter(|must| factor > must.factor_min).map_or(0.0, |must| must.cost);
    target.value * factor + avoided
}

/// Returns the sum of values of the visits in a plan, at their stated beginnings, less the costs of missed targets.
pub(crate) fn worth_of(problem: &SingleVisitProblem, visits: &[(String, usize, f64)]) -> f64 {
    let worth = |(name, manoeuvre, begin_s): &(String, usize, f64)| {
        let target = problem.targets.iter().find(|target| target.name == *name).expect("a target of the problem");
        gained_by(target, quality(&target.manoeuvres[*manoeuvre]) * timing(&target.timing, *begin_s))
    };
    visits.iter().map(worth).sum::<f64>() - all_missed(problem)
}

/// Returns the time from one target (`None`: the start) to another (`None`: the base) for a departure at `depart_s`.
pub(crate) fn leg_s(travel: &TravelTimes, from: Option<usize>, to: Option<usize>, depart_s: f64) -> f64 {
    let of = |start: &[f64], between: &[Vec<f64>], base: &[f64]| match (from, to) {
        (Some(from), Some(to)) => between[from][to],
        (Some(from), None) => base[from],
        (None, Some(to)) => start[to],
        (None, None) => UNREACHABLE_S,
    };
    let mut known = vec![(0.0, of(&travel.from_start_s, &travel.between_s, &travel.to_base_s))];
    known.extend(travel.later.iter().map(|at| (at.depart_s, of(&at.from_start_s, &at.between_s, &at.to_base_s))));
    let after = known.iter().position(|(at_s, _)| *at_s > depart_s);
    let (before, next) = match after {
        None => return known[known.len() - 1].1,
        Some(0) => return known[0].1,
        Some(after) => (known[after - 1], known[after]),
    };
    if depart_s > before.0 && before.1.max(next.1) >= UNREACHABLE_S {
        return UNREACHABLE_S;
    }
    before.1 + (next.1 - before.1) * ((depart_s - before.0) / (next.0 - before.0))
}

fn quality(manoeuvre: &apex_model::problem::Manoeuvre) -> f64 {
    let quality = &manoeuvre.quality;
    quality.coverage.factor * quality.resolution.factor * quality.clarity.factor
}

/// Returns the timing factor: linear between the points, constant outside; 1 without points.
fn timing(points: &[(f64, f64)], at_s: f64) -> f64 {
    let Some(after) = points.iter().position(|(time_s, _)| *time_s > at_s) else {
        return points.last().map_or(1.0, |(_, factor)| *factor);
    };
    let next = points[after];
    match after.checked_sub(1).map(|before| points[before]) {
        Some(before) => before.1 + (next.1 - before.1) * (at_s - before.0) / (next.0 - before.0),
        None => next.1,
    }
}

fn earlier_of(problem: &SingleVisitProblem, later: usize) -> Vec<usize> {
    let name = &problem.targets[later].name;
    let index = |name: &String| problem.targets.iter().position(|target| target.name == *name).expect("a target");
    problem.precedence.iter().filter(|(_, after)| after == name).map(|(before, _)| index(before)).collect()
}

fn limit_s(problem: &SingleVisitProblem) -> f64 {
    let vehicle = &problem.vehicle;
    let mut limit_s = problem.start_s + vehicle.endurance_s - vehicle.endurance_reserve_s;
    if vehicle.fuel_flow_kg_per_s > 0.0 {
        let burn_s = (vehicle.fuel_kg - vehicle.fuel_reserve_kg) / vehicle.fuel_flow_kg_per_s;
        limit_s = limit_s.min(problem.start_s + burn_s);
    }
    limit_s.min(problem.end_s.unwrap_or(f64::INFINITY))
}

struct Orders<'a> {
    problem: &'a SingleVisitProblem,
    margin_s: f64,
    limit_s: f64,
    worth_max: Vec<f64>,
    earlier: Vec<Vec<usize>>,
    best: f64,
}

impl Orders<'_> {
    fn extend(&mut self, here: Option<usize>, ready_s: f64, seen: usize, gained: f64) {
        let travel = self.problem.travel.as_ref().expect("given times");
        let home_s = match (here, self.problem.base) {
            (Some(_), Some(_)) => leg_s(travel, here, None, ready_s),
            _ => 0.0,
        };
        if home_s < UNREACHABLE_S && ready_s + home_s <= self.limit_s - self.margin_s {
            self.best = self.best.max(gained);
        }
        let open: Vec<usize> = (0..self.worth_max.len()).filter(|target| seen & (1 << target) == 0).collect();
        let hoped: f64 = open.iter().map(|target| self.worth_max[*target]).sum();
        if gained + hoped <= self.best {
            return;
        }
        for target in open {
            if self.earlier[target].iter().any(|before| seen & (1 << before) == 0) {
                continue;
            }
            let travel_s = leg_s(travel, here, Some(target), ready_s);
            if travel_s >= UNREACHABLE_S {
                continue;
            }
            let data = &self.problem.targets[target];
            for manoeuvre in &data.manoeuvres {
                for begin_s in self.begins_s(target, ready_s + travel_s, manoeuvre.duration_s) {
                    let end_s = begin_s + manoeuvre.duration_s;
                    if end_s <= self.limit_s - self.margin_s {
                        let worth = gained_by(data, quality(manoeuvre) * timing(&data.timing, begin_s));
                        self.extend(Some(target), end_s, seen | 1 << target, gained + worth);
                    }
                }
            }
        }
    }

    /// Returns the instants at which an observation may begin after an arrival: as early as possible, because a later departure never
    /// arrives earlier; for values that change with time also the corners of the timing, the ends of windows, and the latest beginning of an
    /// observation of `duration_s` that leaves time for the way home.
    fn begins_s(&self, target: usize, arrive_s: f64, duration_s: f64) -> Vec<f64> {
        let data = &self.problem.targets[target];
        let always = [(f64::NEG_INFINITY, f64::INFINITY)];
        let given: Vec<(f64, f64)> =
            data.windows.iter().map(|window| (window.from_s, window.until_s - self.margin_s)).collect();
        let windows = if given.is_empty() { &always[..] } else { &given[..] };
        let firsts = windows.iter().map(|(from_s, until_s)| (arrive_s.max(*from_s), *until_s));
        let firsts: Vec<f64> =
            firsts.filter(|(begin_s, until_s)| begin_s <= until_s).map(|(begin_s, _)| begin_s).collect();
        if data.timing.is_empty() {
            return firsts.into_iter().reduce(f64::min).into_iter().collect();
        }
        let corners = data.timing.iter().map(|(time_s, _)| *time_s).chain(windows.iter().map(|(_, until_s)| *until_s));
        let corners = corners.chain([self.latest_begin_s(target, arrive_s, duration_s)]);
        let inside = |time_s: &f64| {
            *time_s >= arrive_s && windows.iter().any(|(from_s, until_s)| from_s <= time_s && time_s <= until_s)
        };
        let corners: Vec<f64> = corners.filter(|time_s| time_s.is_finite() && inside(time_s)).collect();
        firsts.into_iter().chain(corners).collect()
    }

    /// Returns the latest beginning from `from_s` on after which the flight still ends in time, by bisection: a vehicle that leaves later
    /// is not at home earlier.
    fn latest_begin_s(&self, target: usize, from_s: f64, duration_s: f64) -> f64 {
        let travel = self.problem.travel.as_ref().expect("given times");
        let is_in_time = |begin_s: f64| {
            let end_s = begin_s + duration_s;
            let home_s = if self.problem.base.is_some() { leg_s(travel, Some(target), None, end_s) } else { 0.0 };
            end_s + home_s <= self.limit_s - self.margin_s
        };
        let (mut early_s, mut late_s) = (from_s, self.limit_s.max(from_s) + 1.0);
        for _ in 0..80 {
            let middle_s = 0.5 * (early_s + late_s);
            if is_in_time(middle_s) {
                early_s = middle_s;
            } else {
                late_s = middle_s;
            }
        }
        early_s
    }
}
