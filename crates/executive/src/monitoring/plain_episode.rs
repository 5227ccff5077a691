//! Plain episodes (M&I)
//! What: says which episodes a bank can watch in place of their monitors, puts them there and takes them out again.
//! Runs: when an episode was judged and is undecided; when its bank has decided it, or it is asked.
//! Reads: the episode part.
//! Writes: the runs of an episode part.
//! Bound: O(1).
//! PDL: `:episode` with fixed bounds, `:quality` and a least `:duration`.
//! Paper: section IV example 1.

use super::runs::with_newest;
use super::{Site, site};
use apex_model::condition::Relation;
use apex_model::episode_bank::{Band, PlainEpisode, plain_number};
use apex_model::event::StateVariable;
use apex_model::monitor::{EpisodePart, Keep, Monitor, ObjectRun, PartKind, Test};
use apex_model::quantity::Dimension;
use apex_model::time::Duration;
use apex_model::value::Value;
use std::collections::BTreeMap;

/// Does nothing but comparisons with fixed values, gaps and a least duration decide the episode of one known variable?
pub(super) fn is_plain(part: &EpisodePart, site: Site) -> bool {
    let condition = &part.condition;
    let timing = &condition.timing;
    part.variable.is_some()
        && site.keep == Keep::First
        && !part.any_pair
        && !part.at_close
        && [&condition.object, &condition.first_value, &condition.last_value].iter().all(|each| each.is_empty())
        && [&timing.start, &timing.end].iter().all(|each| each.is_empty())
        && [&condition.stats, &condition.trend].iter().all(|each| each.is_empty())
}

/// The variable of the monitor, when its condition is a plain episode: it may be in the bank of that variable.
pub(crate) fn variable(monitor: &Monitor) -> Option<&StateVariable> {
    match &monitor.root.kind {
        PartKind::Episode(leaf) if is_plain(leaf, site(&monitor.root)) => leaf.variable.as_ref(),
        _ => None,
    }
}

/// What a bank must know of the monitor, with what it has seen so far, when a bank can watch it and nothing is decided.
pub(crate) fn undecided(monitor: &Monitor) -> Option<(PlainEpisode, Option<&ObjectRun>)> {
    let PartKind::Episode(leaf) = &monitor.root.kind else { return None };
    let run = leaf.runs.values().next();
    let reached = |run: &ObjectRun| {
        with_newest(leaf, run).is_some_and(|with| with.start + leaf.duration_min <= with.last) || run.found.is_some()
    };
    let open = leaf.settled.is_empty() && leaf.runs.len() <= 1 && !run.is_some_and(reached);
    if !open || !is_plain(leaf, site(&monitor.root)) {
        return None;
    }
    let (band, dimension) = band(&leaf.tests)?;
    let wanted = PlainEpisode {
        band,
        dimension,
        gap_max: leaf.gap_max.unwrap_or(Duration::MAX),
        duration_min: leaf.duration_min,
        window_start: monitor.root.window.start,
    };
    Some((wanted, run))
}

/// The values that satisfy all tests; none when they are not those between two numbers.
fn band(tests: &[Test]) -> Option<(Band, Dimension)> {
    let mut band = Band { least: f64::NEG_INFINITY, most: f64::INFINITY };
    let mut of = None;
    for test in tests {
        let Test::Fixed { relation, right } = test else { return None };
        let (bound, dimension) = plain_number(right).filter(|(bound, _)| bound.is_finite())?;
        if *of.get_or_insert(dimension) != dimension {
            return None;
        }
        match relation {
            Relation::Greater => band.least = band.least.max(bound.next_up()),
            Relation::GreaterOrEqual => band.least = band.least.max(bound),
            Relation::Less => band.most = band.most.min(bound.next_down()),
            Relation::LessOrEqual => band.most = band.most.min(bound),
            Relation::Equal => (band.least, band.most) = (band.least.max(bound), band.most.min(bound)),
            Relation::Different => return None,
        }
    }
    Some((band, of?))
}

/// Gives the monitor back what a bank has seen in its place.
pub(crate) fn stand_up(monitor: &mut Monitor, run: Option<ObjectRun>) {
    let PartKind::Episode(leaf) = &mut monitor.root.kind else { return };
    let object = leaf.variable.as_ref().map(|variable| variable.object.clone());
    leaf.runs = object.zip(run).into_iter().collect::<BTreeMap<Value, ObjectRun>>();
}

/// A bank watches the monitor: what it has seen is there only.
pub(crate) fn lie_down(monitor: &mut Monitor) {
    if let PartKind::Episode(leaf) = &mut monitor.root.kind {
        leaf.runs = BTreeMap::new();
    }
}
