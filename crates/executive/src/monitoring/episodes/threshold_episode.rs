//! Threshold episodes (M&I)
//! What: decides which episodes an episode index can watch in place of their monitors, and moves them there and back.
//! Runs: when an episode was judged and is undecided; when the index has decided it, or a verdict is requested.
//! Reads: the episode part.
//! Writes: the runs of an episode part.
//! Bound: O(1).
//! PDL: `:episode` with fixed bounds, `:quality` and a least `:duration`.
//! Paper: section IV example 1.

use crate::expression::declared_unit::unit_of;
use crate::expression::{EvalContext, evaluate};
use crate::monitoring::constraints::{RightSide, never_changes, read};
use crate::monitoring::episodes::run_update::{advance_run, result, with_newest};
use crate::monitoring::part::{ConditionFaults, site};
use crate::state::bindings::Bindings;
use crate::state::episode_index::{
    EpisodeUpdate, IndexedRun, OpenResult, ThresholdBounds, ThresholdEpisode, plain_number,
};
use crate::state::monitors::monitor::{EpisodePart, Keep, Monitor, ObjectRun, Part, PartKind, Run, Satisfaction, Test};
use apex_model::condition::{Constraint, Relation};
use apex_model::event::StateVariable;
use apex_model::quantity::Dimension;
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
use std::collections::BTreeMap;

/// Returns true if an episode of one known variable depends only on comparisons with fixed values, gaps and a least duration.
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

/// Returns the variable of the monitor if its condition is a threshold episode, which the episode index of that variable may watch.
pub(crate) fn variable(monitor: &Monitor) -> Option<&StateVariable> {
    match &monitor.root.kind {
        PartKind::Episode(leaf) if is_plain(leaf) => leaf.variable.as_ref(),
        _ => None,
    }
}

/// Returns the state of the monitor with its samples until now, if an episode index can watch it: a task's monitor while it is undecided,
/// or one whose results were all reported.
pub(crate) fn bankable<'a>(
    monitor: &'a Monitor,
    context: &dyn EvalContext,
) -> Option<(ThresholdEpisode, Option<&'a ObjectRun>)> {
    let PartKind::Episode(leaf) = &monitor.root.kind else { return None };
    let bankable = of_part(&monitor.root, context).filter(|_| monitor.root.tag.is_none())?;
    // A task needs one result: a monitor that has it need not watch further.
    let decided = !leaf.settled.is_empty() || bankable.over.is_some() || bankable.wanted.open.is_some();
    let more = !decided || monitor.root.keep == Keep::Every;
    more.then_some((bankable.wanted, bankable.run))
}

/// An episode that an episode index can watch.
pub(crate) struct Bankable<'a> {
    /// The episode to watch.
    pub(crate) wanted: ThresholdEpisode,
    /// Its run until now.
    pub(crate) run: Option<&'a ObjectRun>,
    /// The result of the run that the newest sample has ended.
    pub(crate) over: Option<Satisfaction>,
}

/// Returns the state of the episode `part` for an episode index; `None` if no episode index can watch it.
pub(crate) fn of_part<'a>(part: &'a Part, context: &dyn EvalContext) -> Option<Bankable<'a>> {
    let PartKind::Episode(leaf) = &part.kind else { return None };
    if !is_plain(leaf) || leaf.runs.len() > 1 {
        return None;
    }
    let (band, dimension) = band(leaf, context)?;
    let run = leaf.runs.iter().next();
    let judged = run.map(|(object, run)| {
        advance_run(leaf, site(part), object, run, context.now(), context, &mut ConditionFaults::none(context))
    });
    let (found, over) = judged.map(|judged| (judged.found, judged.over)).unwrap_or_default();
    let run = run.map(|(_, run)| run);
    let newest = match run {
        Some(ObjectRun { found: Some(_), run: Some(before), .. }) if over.is_empty() => before.last,
        Some(run) => run.newest.at,
        None => Time::BEGINNING,
    };
    let open = found.map(|found| OpenResult { recognised_at: found.recognised_at, newest });
    let wanted = ThresholdEpisode {
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

/// Returns the values that satisfy all tests; `None` if they are not an interval between two numbers.
pub(crate) fn band(leaf: &EpisodePart, context: &dyn EvalContext) -> Option<(ThresholdBounds, Dimension)> {
    let mut band = ThresholdBounds { least: f64::NEG_INFINITY, most: f64::INFINITY };
    let mut of = None;
    for test in &leaf.tests {
        let limits = match test {
            Test::Fixed { relation, right } => vec![(*relation, right.clone())],
            Test::General(index) => range(leaf.condition.value.get(*index as usize)?, leaf, context)?,
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

/// Returns the limits of a range that never change.
fn range(constraint: &Constraint, leaf: &EpisodePart, context: &dyn EvalContext) -> Option<Vec<(Relation, Value)>> {
    let Constraint::Range(least, most) = constraint else { return None };
    let unit = unit_of(&leaf.condition.variable.attribute, context.library());
    let mut limits = Vec::new();
    for (relation, limit) in [(Relation::GreaterOrEqual, least), (Relation::LessOrEqual, most)] {
        let Some(expr) = limit else { continue };
        if !never_changes(expr, context.library(), 8) {
            return None;
        }
        let value = evaluate(expr, context).and_then(|value| read(value, RightSide::Value(unit), expr.place)).ok()?;
        limits.push((relation, value));
    }
    Some(limits)
}

/// Moves the state that an episode index has kept back into the monitor.
pub(crate) fn stand_up(monitor: &mut Monitor, seen: Option<IndexedRun>) {
    if let PartKind::Episode(leaf) = &mut monitor.root.kind {
        give_back(leaf, seen);
    }
}

/// Moves the state that an episode index has kept back into the episode.
pub(crate) fn give_back(leaf: &mut EpisodePart, seen: Option<IndexedRun>) {
    let object = leaf.variable.as_ref().map(|variable| variable.object.clone());
    let runs = object.zip(seen).map(|(object, IndexedRun { mut run, found_at, .. })| {
        let with_result = run.run.as_ref().zip(found_at);
        run.found = with_result.map(|(before, found_at)| result(leaf, &object, before, found_at));
        (object, run)
    });
    leaf.runs = runs.into_iter().collect::<BTreeMap<Value, ObjectRun>>();
}

/// Returns the result that an episode index reported of the monitor.
pub(crate) fn told_result(monitor: &Monitor, told: &EpisodeUpdate) -> Option<Satisfaction> {
    match &monitor.root.kind {
        PartKind::Episode(leaf) => told_of(leaf, told),
        _ => None,
    }
}

/// Returns the result that an episode index reported of the episode.
pub(crate) fn told_of(leaf: &EpisodePart, told: &EpisodeUpdate) -> Option<Satisfaction> {
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

/// Returns the reported results of a monitor that an episode index has watched: of the run before the newest sample, and, if it was
/// recognised at `open_at`, of the run that contains the newest sample.
pub(crate) fn told(monitor: &Monitor, open_at: Option<Time>) -> crate::monitoring::reported_results::ReportedResults {
    let PartKind::Episode(leaf) = &monitor.root.kind else {
        return crate::monitoring::reported_results::ReportedResults::default();
    };
    let run = leaf.runs.iter().next();
    let before = run.and_then(|(_, run)| run.found.as_ref());
    let open = run
        .zip(open_at)
        .and_then(|((object, run), open_at)| with_newest(leaf, run).map(|with| result(leaf, object, &with, open_at)));
    crate::monitoring::reported_results::ReportedResults::by_bank(&monitor.root, before, open.as_ref())
}

/// Moves the state of the monitor into the episode index that watches it.
pub(crate) fn lie_down(monitor: &mut Monitor) {
    if let PartKind::Episode(leaf) = &mut monitor.root.kind {
        leaf.runs = BTreeMap::new();
        leaf.settled.clear();
    }
}
