//! Episodes with statistics or trends. These are not monotone, so every end of a run is evaluated (rule 13).

use crate::condition::{Episode, Relation, Span, Time};
use crate::episode::{Run, held};
use crate::history::Sample;
use crate::statistics::finite;
use crate::value::Bindings;
use crate::ways::{View, Way};

/// Returns true if the episode constrains statistics or trends.
pub(crate) fn asked(episode: &Episode) -> bool {
    !episode.stats.is_empty() || !episode.trend.is_empty()
}

/// Returns the ways of statistics and trends. Consecutive ends of a run at which the constraints are satisfied form one result: it begins
/// where the run or the first window begins, and grows in the same way as runs of values (rules 7 and 13).
pub(crate) fn ways(episode: &Episode, run: &Run<'_>, bound: &Bindings, view: View<'_>) -> Vec<Way> {
    let mut found: Vec<Way> = Vec::new();
    let mut goes_on = false;
    for end in ends(episode, run, view) {
        let inside = inside(episode, run, end).unwrap_or_default();
        let holds = crate::statistics::hold(episode, &inside)
            && crate::trend::hold(episode, &inside)
            && crate::episode::ends_fit(episode, &inside.samples);
        let interval = inside.samples.first().zip(inside.samples.last()).map(|(first, last)| (first.at, last.at));
        match (interval.filter(|_| holds), found.last_mut()) {
            (Some((_, last)), Some(way)) if goes_on => way.hull = way.hull.map(|(first, _)| (first, last)),
            (Some(interval), _) => found.push(Way::over(interval, end, bound.clone())),
            (None, _) => {}
        }
        goes_on = interval.is_some() && holds;
    }
    if let Some(way) = found.last_mut().filter(|_| goes_on) {
        way.open = !run.closed;
    }
    found
}

/// Returns true if the episode uses a window, because no value constraint defines the run.
fn slides(episode: &Episode) -> bool {
    episode.value.is_empty() && !episode.duration.is_empty()
}

/// Returns true if it is certain that the newest end does not satisfy the condition. For a run that is too short or has too few samples
/// this is unknown.
pub(crate) fn contradicted(episode: &Episode, run: &Run<'_>, view: View<'_>) -> bool {
    if !asked(episode) {
        return false;
    }
    let newest = ends(episode, run, view).into_iter().next_back();
    let inside = newest.and_then(|end| inside(episode, run, end));
    inside.is_some_and(|inside| {
        let fails = crate::statistics::fail(episode, &inside) || crate::trend::fail(episode, &inside);
        let holds = crate::statistics::hold(episode, &inside) && crate::trend::hold(episode, &inside);
        fails || holds && slides(episode) && !crate::episode::ends_fit(episode, &inside.samples)
    })
}

/// Returns the required length: the least one of the run, or that of the window if no value constraint defines the run.
fn wanted(episode: &Episode) -> Span {
    let least = episode.duration.iter().map(|(relation, bound)| match relation {
        Relation::Greater => bound + 1,
        _ => *bound,
    });
    least.max().unwrap_or(0)
}

/// Returns the instants of all samples and, if a gap permits time to pass, the instants at which the length is reached or a sample leaves
/// the window. Between these instants the value held last gains weight, so that a statistic weighted by time may cross its limit there.
pub(crate) fn ends(episode: &Episode, run: &Run<'_>, view: View<'_>) -> Vec<Time> {
    let wanted = wanted(episode);
    let instants: Vec<Time> = run.samples.iter().map(|sample| sample.at).collect();
    let mut ends = instants.clone();
    let reached = instants.first().map(|start| start + wanted);
    let leave = instants.iter().filter(|_| slides(episode)).map(|at| at + wanted + 1);
    let by_time: Vec<Time> = reached.into_iter().chain(leave).collect();
    for (index, sample) in run.samples.iter().enumerate() {
        let next = run.samples.get(index + 1).or(run.next).map(|next| next.at);
        let licensed = sample.at..=held(episode, sample, next, view);
        ends.extend(by_time.iter().filter(|end| licensed.contains(end)));
        let weighted = episode.stats.iter().filter(|(statistic, ..)| crate::statistics::is_weighted(*statistic));
        for (statistic, _, limit) in weighted {
            // The weights of values change evenly between these instants: one gains, and one leaves the window.
            let turns = by_time.iter().flat_map(|end| [end - 1, *end]).filter(|end| licensed.contains(end));
            let mut bends: Vec<Time> = turns.chain([*licensed.start(), *licensed.end()]).collect();
            bends.sort_unstable();
            let value = |end: Time| {
                inside(episode, run, end).and_then(|inside| crate::statistics::value_of(*statistic, episode, &inside))
            };
            ends.extend(bends.windows(2).flat_map(|two| crossings((two[0], two[1]), *limit, &value)));
        }
    }
    ends.sort_unstable();
    ends.dedup();
    ends
}

/// Returns the instants at which the value begins or ceases to be above the limit, or to have a value. It rises to its greatest value,
/// if that lies inside, and then falls, or only rises or falls.
fn crossings((from, to): (Time, Time), limit: f64, value: &dyn Fn(Time) -> Option<f64>) -> Vec<Time> {
    if from >= to {
        return Vec::new();
    }
    // The first value has no weight at its own instant.
    let from = if value(from).is_none() { from + 1 } else { from };
    let (mut low, mut high) = (from, to);
    while high - low > 2 {
        let third = (high - low) / 3;
        if value(low + third) < value(high - third) { low += third } else { high -= third }
    }
    let bends = [from, low, (low + 1).min(high), high, to];
    let rising =
        bends.windows(2).filter_map(|two| first_other((two[0], two[1]), &|at| value(at).map(|value| value > limit)));
    std::iter::once(from).chain(rising).collect()
}

/// Returns the first instant of a span at which the answer differs from that at its begin, if its end differs; it changes once.
fn first_other((mut same, mut other): (Time, Time), answer: &dyn Fn(Time) -> Option<bool>) -> Option<Time> {
    let begin = answer(same);
    if same >= other || answer(other) == begin {
        return None;
    }
    while other - same > 1 {
        let middle = same + (other - same) / 2;
        if answer(middle) == begin { same = middle } else { other = middle }
    }
    Some(other)
}

/// Samples in the run, or in the window that ends at an instant.
#[derive(Default)]
pub(crate) struct Inside {
    /// The samples.
    pub(crate) samples: Vec<Sample>,
    /// Numbers, each with the seconds for which it held: until the next sample, or up to the end.
    pub(crate) held: Vec<(f64, f64)>,
}

/// Returns the samples in the run, or in the window that ends at `end`, if that is long enough.
fn inside(episode: &Episode, run: &Run<'_>, end: Time) -> Option<Inside> {
    let wanted = wanted(episode);
    let start = run.samples.first()?.at;
    let from = if slides(episode) { end - wanted } else { start };
    let samples = run.samples.iter().filter(|sample| (from..=end).contains(&sample.at)).cloned().collect();
    let mut held = Vec::new();
    for (index, sample) in run.samples.iter().enumerate() {
        let until = run.samples.get(index + 1).map_or(end, |next| next.at.min(end));
        let seconds = (until - sample.at.max(from)) as f64 / 1e9;
        held.extend(finite(std::slice::from_ref(sample)).into_iter().map(|number| (number, seconds)));
    }
    held.retain(|(_, seconds)| *seconds > 0.0);
    (end - start >= wanted).then_some(Inside { samples, held })
}
