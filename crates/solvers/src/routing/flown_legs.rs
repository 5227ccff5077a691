//! The table of legs of a problem with flown paths: around zones and through wind.
//!
//! If nothing changes with time, a leg takes its present time. Otherwise the least time over all departures is bounded from below: a
//! later departure never arrives earlier, so between two departures no vehicle is faster than one that arrives with the first and has
//! left with the second.
//! Bound: O(nodes^2) paths, times the examined departures, [`DEPARTURES_MAX`] for each path.

use super::network::{END, FIRST, NO_WAY, Node, START, ceil_ticks, floor_ticks};
use super::schedule::Schedule;
use super::travel::PointKey;
use apex_planning::solver::Budget;

/// Time of a leg that counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Times {
    /// The time of a departure when the plan begins, rounded up.
    Now,
    /// The least over all departures, rounded down.
    Least,
}

/// Departures of one path that are examined for its least time.
const DEPARTURES_MAX: usize = 48;
/// The least time is known to this share.
const EXACT: f64 = 0.01;

/// Returns the ticks from the beginning of each node's visit to the arrival at each other one; `None` if the paths use up the budget, or
/// those of the first nodes show that present times would take more than half of it: a search needs the rest.
pub(crate) fn legs(
    schedule: &mut Schedule<'_>,
    nodes: &[Node],
    tick_s: f64,
    times: Times,
    budget: &mut dyn Budget,
) -> Option<Vec<i32>> {
    let problem = schedule.problem;
    let count = nodes.len();
    let changes_s = schedule.travel.changes_s();
    let mut legs = vec![NO_WAY; count * count];
    let (before, left) = (budget.used(), budget.left());
    let mut done = 0;
    for (from, data) in nodes.iter().enumerate().filter(|(from, _)| *from != END as usize) {
        let stay_s = match from as u32 {
            START => 0.0,
            _ => duration_s(schedule, data),
        };
        let leaves = if from as u32 == START {
            PointKey::Start
        } else {
            PointKey::Exit(data.target as usize, data.manoeuvre as usize)
        };
        for (to, there) in nodes.iter().enumerate().filter(|(to, _)| *to != START as usize && *to != from) {
            let same = from as u32 >= FIRST && to as u32 >= FIRST && there.target == data.target;
            if same {
                continue;
            }
            let ends = match to as u32 {
                END => problem.base.filter(|_| from as u32 != START).map(|_| PointKey::Base),
                _ => Some(PointKey::Entry(there.target as usize, there.manoeuvre as usize)),
            };
            let time_s = match (ends, times) {
                (None, _) => Some(0.0),
                (Some(ends), Times::Now) => schedule.travel.time_s(leaves, ends, problem.start_s),
                (Some(ends), Times::Least) => Some(least_s(schedule, (leaves, ends), &changes_s)),
            };
            let Some(slot) = legs.get_mut(from * count + to) else { continue };
            match (time_s, times) {
                (Some(time_s), Times::Now) => *slot = ceil_ticks(stay_s + time_s, tick_s),
                (Some(time_s), Times::Least) if time_s.is_finite() => {
                    *slot = floor_ticks(stay_s + time_s, tick_s).saturating_sub(1).max(0);
                }
                _ => {}
            }
        }
        budget.charge(1 + schedule.travel.take_work());
        done += 1;
        let expected = (budget.used() - before).saturating_mul(count as u64) / done;
        let is_too_much = match times {
            Times::Now => left.is_some_and(|left| expected > left / 2),
            Times::Least => false,
        };
        if is_too_much || budget.exhausted() {
            return None;
        }
    }
    Some(legs)
}

fn duration_s(schedule: &Schedule<'_>, node: &Node) -> f64 {
    let target = schedule.problem.targets.get(node.target as usize);
    let manoeuvre = target.and_then(|target| target.manoeuvres.get(node.manoeuvre as usize));
    manoeuvre.map_or(0.0, |manoeuvre| manoeuvre.duration_s)
}

/// Returns a time below which the path does not fall for any departure of the flight.
fn least_s(schedule: &mut Schedule<'_>, (from, to): (PointKey, PointKey), changes_s: &[f64]) -> f64 {
    let (begin_s, end_s) = (schedule.problem.start_s, schedule.limit_s);
    let nobody_s = schedule.travel.time_s_min(from, to);
    if schedule.problem.travel.is_some() {
        return nobody_s;
    }
    let mut time_s = |depart_s: f64| schedule.travel.time_s(from, to, depart_s).unwrap_or(f64::INFINITY);
    let mut at_s: Vec<f64> = changes_s.iter().copied().filter(|at_s| begin_s < *at_s && *at_s < end_s).collect();
    at_s.extend([begin_s, end_s]);
    at_s.sort_by(f64::total_cmp);
    let known: Vec<(f64, f64)> = at_s.into_iter().map(|depart_s| (depart_s, time_s(depart_s))).collect();
    let mut least_s = known.iter().map(|(_, taken_s)| *taken_s).fold(f64::INFINITY, f64::min);
    let mut quickest_s = least_s;
    let mut open: Vec<((f64, f64), f64)> = Vec::new();
    for ((depart_s, taken_s), (next_s, _)) in known.iter().zip(known.iter().skip(1)) {
        // A vehicle that arrives before the next change takes as long as the first one: only later departures are examined.
        let quiet_s = if taken_s.is_finite() { next_s - taken_s } else { *depart_s };
        open.push(((depart_s.max(quiet_s), *taken_s), *next_s));
    }
    let mut looked = 0;
    while let Some(((depart_s, taken_s), until_s)) = open.pop() {
        // If holding is not permitted, a later departure may be the first possible one.
        let no_less_s = if taken_s.is_finite() { nobody_s.max(depart_s + taken_s - until_s) } else { nobody_s };
        if no_less_s >= quickest_s * (1.0 - EXACT) || looked >= DEPARTURES_MAX {
            least_s = least_s.min(no_less_s);
            continue;
        }
        let middle_s = 0.5 * (depart_s + until_s);
        let middle = (middle_s, time_s(middle_s));
        looked += 1;
        quickest_s = quickest_s.min(middle.1);
        open.push(((depart_s, taken_s), middle_s));
        open.push((middle, until_s));
    }
    least_s.min(quickest_s)
}

#[cfg(test)]
mod tests {
    use super::*;
    use apex_planning::examples::single_visit as examples;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(12))]
        #[test]
        fn no_departure_is_faster_than_the_least(seed in 0..10_000u64, shares in prop::collection::vec(0.0..1.0f64, 24)) {
            // Zones with active times, landing places and a wind that changes.
            let problem = examples::random(4, seed);
            let mut schedule = Schedule::new(&problem).unwrap();
            let changes_s = schedule.travel.changes_s();
            prop_assert!(!changes_s.is_empty());
            let (begin_s, end_s) = (problem.start_s, schedule.limit_s);
            for (from, to) in [(0, 1), (1, 2), (2, 3), (3, 0)] {
                let leg = (PointKey::Exit(from, 0), PointKey::Entry(to, 1));
                let least_s = least_s(&mut schedule, leg, &changes_s);
                let mut quickest_s = f64::INFINITY;
                for share in &shares {
                    let depart_s = begin_s + share * (end_s - begin_s);
                    quickest_s = quickest_s.min(schedule.travel.time_s(leg.0, leg.1, depart_s).unwrap_or(f64::INFINITY));
                }
                prop_assert!(least_s <= quickest_s + 1e-6, "{least_s} {quickest_s}");
                prop_assert!(least_s >= schedule.travel.time_s_min(leg.0, leg.1));
            }
        }
    }
}
