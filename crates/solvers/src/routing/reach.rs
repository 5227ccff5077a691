//! Targets that no flight can visit: by least times over any other targets.
//!
//! A vehicle that cannot fly to a target directly may reach it through another one, if given times or heights permit it. So times are
//! minima over all departures and over any detours; each target on a detour counts with its shortest observation, and order and value are
//! ignored. A target that is out of reach in these times is out of reach in every plan.
//! Bound: O(nodes^2); with more than [`NODES_MAX`] nodes no node is reported as out of reach.

use super::schedule::Schedule;
use super::travel::PointKey;

/// Ways to observe targets, of all targets together: some milliseconds for a thousand.
const NODES_MAX: usize = 2_000;
/// Tolerance of times, in seconds: they are summed in another order than those of a plan.
const SLACK_S: f64 = 1e-6;

/// One way to observe one target.
struct ReachNode {
    target: usize,
    manoeuvre: usize,
    duration_s: f64,
}

/// Returns for each target true if no plan can visit it. Examines only those in `suspects`.
pub(crate) fn out_of_reach(schedule: &mut Schedule<'_>, suspects: &[usize]) -> Vec<bool> {
    let targets = schedule.problem.targets.len();
    let nodes = nodes(schedule);
    let mut out = vec![false; targets];
    if nodes.len() > NODES_MAX {
        return out;
    }
    let ends_s = earliest_ends_s(schedule, &nodes);
    let home_s = quickest_home_s(schedule, &nodes);
    for suspect in suspects {
        let of = nodes.iter().zip(ends_s.iter().zip(&home_s)).filter(|(node, _)| node.target == *suspect);
        let possible: Vec<&ReachNode> = of
            .filter(|(_, (end_s, home_s))| *end_s + *home_s <= schedule.limit_s + SLACK_S)
            .map(|(node, _)| node)
            .collect();
        let is_free = possible.into_iter().any(|node| lines_are_ever_free(schedule, node));
        if let Some(slot) = out.get_mut(*suspect) {
            *slot = !is_free;
        }
    }
    out
}

fn nodes(schedule: &Schedule<'_>) -> Vec<ReachNode> {
    let of = |(target, data): (usize, &apex_model::problem::SingleVisitTarget)| {
        let durations = data.manoeuvres.iter().map(|manoeuvre| manoeuvre.duration_s).enumerate();
        durations.map(|(manoeuvre, duration_s)| ReachNode { target, manoeuvre, duration_s }).collect::<Vec<ReachNode>>()
    };
    schedule.problem.targets.iter().enumerate().flat_map(of).collect()
}

fn least_s(schedule: &Schedule<'_>, from: Option<&ReachNode>, to: &ReachNode) -> f64 {
    if from.is_some_and(|from| from.target == to.target) {
        return f64::INFINITY;
    }
    let leaves = from.map_or(PointKey::Start, |from| PointKey::Exit(from.target, from.manoeuvre));
    schedule.travel.time_s_min(leaves, PointKey::Entry(to.target, to.manoeuvre))
}

/// Returns the earliest end of the observation of each node; infinite if its windows are over before (Dijkstra).
fn earliest_ends_s(schedule: &Schedule<'_>, nodes: &[ReachNode]) -> Vec<f64> {
    let end_s = |node: &ReachNode, arrive_s: f64| {
        let open = schedule.windows(node.target, node.manoeuvre).iter().find(|it| arrive_s <= it.until_s + SLACK_S);
        open.map_or(f64::INFINITY, |window| window.from_s.max(arrive_s) + node.duration_s)
    };
    let start_s = schedule.problem.start_s;
    let mut ends_s: Vec<f64> = nodes.iter().map(|node| end_s(node, start_s + least_s(schedule, None, node))).collect();
    settle(&mut ends_s, |from, ready_s, to| {
        let (from, to) = (nodes.get(from), nodes.get(to));
        to.zip(from).map_or(f64::INFINITY, |(to, from)| end_s(to, ready_s + least_s(schedule, Some(from), to)))
    });
    ends_s
}

/// Returns the least time from the end of each node's observation to the end of the flight.
fn quickest_home_s(schedule: &Schedule<'_>, nodes: &[ReachNode]) -> Vec<f64> {
    let direct_s = |node: &ReachNode| match schedule.problem.base {
        Some(_) => schedule.travel.time_s_min(PointKey::Exit(node.target, node.manoeuvre), PointKey::Base),
        None => 0.0,
    };
    let mut home_s: Vec<f64> = nodes.iter().map(direct_s).collect();
    settle(&mut home_s, |next, rest_s, here| {
        let (next, here) = (nodes.get(next), nodes.get(here));
        next.zip(here)
            .map_or(f64::INFINITY, |(next, here)| least_s(schedule, Some(here), next) + next.duration_s + rest_s)
    });
    home_s
}

/// Computes least values in the manner of Dijkstra: makes the least one final, lets it lower the others, and repeats. `over(a, value, b)`
/// is the value of `b` through `a`, which has `value`.
fn settle(least: &mut [f64], over: impl Fn(usize, f64, usize) -> f64) {
    let mut open: Vec<usize> = (0..least.len()).collect();
    let at = |least: &[f64], node: usize| least.get(node).copied().unwrap_or(f64::INFINITY);
    while let Some(slot) =
        (0..open.len()).min_by(|a, b| at_slot(least, &open, *a).total_cmp(&at_slot(least, &open, *b)))
    {
        let here = open.swap_remove(slot);
        let own = at(least, here);
        if !own.is_finite() {
            return;
        }
        for there in open.iter().copied() {
            let lower = over(here, own, there);
            if let Some(known) = least.get_mut(there) {
                *known = known.min(lower);
            }
        }
    }
}

fn at_slot(least: &[f64], open: &[usize], slot: usize) -> f64 {
    open.get(slot).and_then(|node| least.get(*node)).copied().unwrap_or(f64::INFINITY)
}

/// Returns true if the lines of a manoeuvre are allowed at some time of the flight. That changes only when wind or zones do.
fn lines_are_ever_free(schedule: &mut Schedule<'_>, node: &ReachNode) -> bool {
    let problem = schedule.problem;
    if problem.travel.is_some() || (problem.zones.is_empty() && problem.landing_distance_m_max.is_none()) {
        return true;
    }
    let changes_s = schedule.travel.changes_s();
    let limit_s = schedule.limit_s;
    let mut times_s = [problem.start_s].into_iter().chain(changes_s).filter(|time_s| *time_s <= limit_s);
    times_s.any(|time_s| schedule.travel.lines_trouble(node.target, node.manoeuvre, time_s, time_s).is_none())
}
