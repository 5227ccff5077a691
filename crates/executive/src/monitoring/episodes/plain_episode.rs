//! Plain episodes (M&I)
//! What: says which episodes a bank can watch in place of their monitors, puts them there and takes them out again.
//! Runs: when an episode was judged and is undecided; when its bank has decided it, or it is asked.
//! Reads: the episode part.
//! Writes: the runs of an episode part.
//! Bound: O(1).
//! PDL: `:episode` with fixed bounds, `:quality` and a least `:duration`.
//! Paper: section IV example 1.

use crate::expression::{Surroundings, evaluate};
use crate::monitoring::constraints::{Reading, never_changes, read, unit_of};
use crate::monitoring::episodes::runs::{advance_run, result, with_newest};
use crate::monitoring::part::{Troubles, site};
use crate::state::bindings::Bindings;
use crate::state::episode_bank::{Band, Open, PlainEpisode, Seen, Told, plain_number};
use crate::state::monitors::monitor::{EpisodePart, Keep, Monitor, ObjectRun, Part, PartKind, Run, Satisfaction, Test};
use apex_model::condition::{Constraint, Relation};
use apex_model::event::StateVariable;
use apex_model::quantity::Dimension;
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
use std::collections::BTreeMap;

/// Does nothing but comparisons with fixed values, gaps and a least duration decide the episode of one known variable?
pub(crate) fn is_plain(part: &EpisodePart) -> bool {
    let condition = &part.condition;
    let timing = &condition.timing;
    part.variable.is_some()
        && !part.any_pair
        && !part.at_close
        && [&condition.object, &condition.first_value, &condition.last_value].iter().all(|each| each.is_empty())
        && [&timing.start, &timing.end].iter().all(|each| each.is_empty())
        && [&condition.stats, &condition.trend].iter().all(|each| each.is_empty())
}

/// The variable of the monitor, when its condition is a plain episode: it may be in the bank of that variable.
pub(crate) fn variable(monitor: &Monitor) -> Option<&StateVariable> {
    match &monitor.root.kind {
        PartKind::Episode(leaf) if is_plain(leaf) => leaf.variable.as_ref(),
        _ => None,
    }
}

/// What a bank must know of the monitor, with what it has seen so far, when a bank can watch it: a task's while nothing is
/// decided, one that is harvested after all that it knows was told.
pub(crate) fn bankable<'a>(
    monitor: &'a Monitor,
    surroundings: &dyn Surroundings,
) -> Option<(PlainEpisode, Option<&'a ObjectRun>)> {
    let PartKind::Episode(leaf) = &monitor.root.kind else { return None };
    let bankable = of_part(&monitor.root, surroundings).filter(|_| monitor.root.tag.is_none())?;
    // One result is enough for a task: its monitor has nothing more to watch for.
    let decided = !leaf.settled.is_empty() || bankable.over.is_some() || bankable.wanted.open.is_some();
    let more = !decided || monitor.root.keep == Keep::Every;
    more.then_some((bankable.wanted, bankable.run))
}

/// An episode that a bank can watch.
pub(crate) struct Bankable<'a> {
    /// What the bank must know of it.
    pub(crate) wanted: PlainEpisode,
    /// What it has seen.
    pub(crate) run: Option<&'a ObjectRun>,
    /// The result of the run that the newest sample has ended.
    pub(crate) over: Option<Satisfaction>,
}

/// The episode `part` as a bank can watch it; none when no bank can.
pub(crate) fn of_part<'a>(part: &'a Part, surroundings: &dyn Surroundings) -> Option<Bankable<'a>> {
    let PartKind::Episode(leaf) = &part.kind else { return None };
    if !is_plain(leaf) || leaf.runs.len() > 1 {
        return None;
    }
    let (band, dimension) = band(leaf, surroundings)?;
    let run = leaf.runs.iter().next();
    let judged = run.map(|(object, run)| {
        advance_run(leaf, site(part), object, run, surroundings.now(), surroundings, &mut Troubles::default())
    });
    let (found, over) = judged.map(|judged| (judged.found, judged.over)).unwrap_or_default();
    let run = run.map(|(_, run)| run);
    let newest = match run {
        Some(ObjectRun { found: Some(_), run: Some(before), .. }) if over.is_empty() => before.last,
        Some(run) => run.newest.at,
        None => Time::BEGINNING,
    };
    let open = found.map(|found| Open { recognised_at: found.recognised_at, newest });
    let wanted = PlainEpisode {
        band,
        dimension,
        gap_max: leaf.gap_max.unwrap_or(Duration::MAX),
        duration_min: leaf.duration_min,
        window_start: part.window.start,
        open,
        negated: false,
    };
    Some(Bankable { wanted, run, over: over.into_iter().next() })
}

/// The values that satisfy all tests; none when they are not those between two numbers.
pub(crate) fn band(leaf: &EpisodePart, surroundings: &dyn Surroundings) -> Option<(Band, Dimension)> {
    let mut band = Band { least: f64::NEG_INFINITY, most: f64::INFINITY };
    let mut of = None;
    for test in &leaf.tests {
        let limits = match test {
            Test::Fixed { relation, right } => vec![(*relation, right.clone())],
            Test::General(index) => range(leaf.condition.value.get(*index as usize)?, leaf, surroundings)?,
        };
        for (relation, right) in limits {
            let (bound, dimension) = plain_number(&right).filter(|(bound, _)| bound.is_finite())?;
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
    }
    Some((band, of?))
}

/// The limits of a range that never change.
fn range(
    constraint: &Constraint,
    leaf: &EpisodePart,
    surroundings: &dyn Surroundings,
) -> Option<Vec<(Relation, Value)>> {
    let Constraint::Range(least, most) = constraint else { return None };
    let unit = unit_of(&leaf.condition.variable.attribute, surroundings.library());
    let mut limits = Vec::new();
    for (relation, limit) in [(Relation::GreaterOrEqual, least), (Relation::LessOrEqual, most)] {
        let Some(expr) = limit else { continue };
        if !never_changes(expr, surroundings.library(), 8) {
            return None;
        }
        let value =
            evaluate(expr, surroundings).and_then(|value| read(value, Reading::Value(unit), expr.place)).ok()?;
        limits.push((relation, value));
    }
    Some(limits)
}

/// Gives the monitor back what a bank has seen in its place.
pub(crate) fn stand_up(monitor: &mut Monitor, seen: Option<Seen>) {
    if let PartKind::Episode(leaf) = &mut monitor.root.kind {
        give_back(leaf, seen);
    }
}

/// Gives the episode back what a bank has seen in its place.
pub(crate) fn give_back(leaf: &mut EpisodePart, seen: Option<Seen>) {
    let object = leaf.variable.as_ref().map(|variable| variable.object.clone());
    let runs = object.zip(seen).map(|(object, Seen { mut run, found_at, .. })| {
        let with_result = run.run.as_ref().zip(found_at);
        run.found = with_result.map(|(before, found_at)| result(leaf, &object, before, found_at));
        (object, run)
    });
    leaf.runs = runs.into_iter().collect::<BTreeMap<Value, ObjectRun>>();
}

/// What a bank told of the monitor, as a result.
pub(crate) fn told_result(monitor: &Monitor, told: &Told) -> Option<Satisfaction> {
    match &monitor.root.kind {
        PartKind::Episode(leaf) => told_of(leaf, told),
        _ => None,
    }
}

/// What a bank told of the episode, as a result.
pub(crate) fn told_of(leaf: &EpisodePart, told: &Told) -> Option<Satisfaction> {
    let run = Run {
        start: told.start,
        last: told.last,
        samples: told.samples,
        bindings: Bindings::new(),
        first_holds: true,
        last_holds: true,
        instants: Vec::new(),
    };
    Some(result(leaf, &leaf.variable.as_ref()?.object, &run, told.recognised_at))
}

/// What was told of a monitor that a bank has watched: of the run before the newest sample what stands in it, and of the
/// run with the newest sample the result that was recognised at `open_at`.
pub(crate) fn told(monitor: &Monitor, open_at: Option<Time>) -> crate::monitoring::told::Told {
    let PartKind::Episode(leaf) = &monitor.root.kind else { return crate::monitoring::told::Told::default() };
    let run = leaf.runs.iter().next();
    let before = run.and_then(|(_, run)| run.found.as_ref());
    let open = run
        .zip(open_at)
        .and_then(|((object, run), open_at)| with_newest(leaf, run).map(|with| result(leaf, object, &with, open_at)));
    crate::monitoring::told::Told::by_bank(&monitor.root, before, open.as_ref())
}

/// A bank watches the monitor: what it has seen is there only.
pub(crate) fn lie_down(monitor: &mut Monitor) {
    if let PartKind::Episode(leaf) = &mut monitor.root.kind {
        leaf.runs = BTreeMap::new();
        leaf.settled.clear();
    }
}
