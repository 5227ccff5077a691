//! Naive definition of episodes as runs of samples (rules 5, 6, 7, 8, 13).

use crate::aggregate;
use crate::condition::{Episode, Relation, Time};
use crate::history::{Past, Sample, Series};
use crate::measurement::{heard_of, in_window, series_of};
use crate::value::{Bindings, fits, numbers};
use crate::verdict::Question;
use crate::ways::{Runs, View, Way, Ways, instant_fits};

/// A run: consecutive samples without a gap that all satisfy the constraints, as far as known.
pub(crate) struct Run<'a> {
    pub(crate) samples: &'a [Sample],
    /// True if the sample before the run does not satisfy the constraints, and no gap follows it.
    begins: bool,
    /// The first sample after the run.
    pub(crate) next: Option<&'a Sample>,
    /// True if the run cannot continue.
    pub(crate) closed: bool,
}

/// Returns every interval of a run that satisfies the condition.
pub(crate) fn ways(episode: &Episode, view: View<'_>) -> Ways {
    let mut found = Ways::default();
    let timed = !episode.start.is_empty() || !episode.end.is_empty();
    let all = series_of(&episode.variable, |_| if timed { Time::MIN } else { view.created }, view);
    for (series, bound) in &all {
        let samples = windowed(episode, series, view);
        let runs = runs(episode, samples, view);
        // Rule 3: a run with an unknown beginning, or one that may continue, may still satisfy the condition.
        let decided = |run: &Run<'_>| !run.closed && aggregate::contradicted(episode, run, view);
        let newest = runs.last().filter(|run| run.next.is_none() && (!run.begins || run.closed) && !decided(run));
        if let Some(run) = newest {
            let why = if run.closed { "no sample for too long" } else { "unknown for how long" };
            found.unknown = Some(why.into());
        }
        // A continuing run that satisfies the condition leaves nothing unknown; two samples from a run do not exclude other pairs.
        let mut found_before = found.all.len();
        for run in &runs {
            found_before = found.all.len();
            match if episode.any { Runs::Any } else { view.runs } {
                _ if aggregate::asked(episode) => found.all.extend(aggregate::ways(episode, run, bound, view)),
                Runs::Begun => found.all.extend(begun(episode, run, bound, view)),
                Runs::Any => found.all.extend(any(episode, run, bound)),
                Runs::Whole => found.all.extend(whole(episode, run, bound, view)),
            }
        }
        let mut of_newest = found.all.iter().skip(found_before);
        let whole = !episode.any && view.runs != Runs::Any;
        let is_result =
            |run: &Run<'_>| !run.closed && whole && of_newest.any(|way| way.open || !aggregate::asked(episode));
        found.doubt |= !newest.is_none_or(is_result);
    }
    let silent = |series: &Series| {
        let newest = windowed(episode, series, view).last().map(|newest| newest.at);
        newest.zip(episode.gap).is_some_and(|(newest, gap)| view.now - newest > gap)
    };
    if heard_of(&episode.variable, view, silent) {
        found.unknown = Some("no sample for too long".into());
        found.doubt = true;
    }
    if !heard_of(&episode.variable, view, |series| !windowed(episode, series, view).is_empty()) {
        found.unknown = Some("nothing was ever measured".into());
        found.doubt = true;
    }
    found
}

/// Returns the instants at which statistics are judged, up to `until` and by the knowledge of `past`: among them those at which values
/// that are held cross the limits of statistics weighted by time.
pub(crate) fn foreseen(episode: &Episode, question: &Question, past: &Past, until: Time) -> Vec<Time> {
    let view = View { question, past, created: question.created, now: until, runs: Runs::Begun };
    let timed = !episode.start.is_empty() || !episode.end.is_empty();
    let all = series_of(&episode.variable, |_| if timed { Time::MIN } else { view.created }, view);
    let of_series = |series: &Series| {
        let runs = runs(episode, windowed(episode, series, view), view);
        runs.iter().flat_map(|run| aggregate::ends(episode, run, view)).collect::<Vec<Time>>()
    };
    all.iter().flat_map(|(series, _)| of_series(series)).collect()
}

/// Returns the samples that count: from the creation on, unless the condition constrains the start or end of the episode (rule 2).
fn windowed<'a>(episode: &Episode, series: &'a Series, view: View<'_>) -> &'a [Sample] {
    let timed = !episode.start.is_empty() || !episode.end.is_empty();
    let first = series.samples.iter().position(|sample| timed || in_window(sample.at, &[], view));
    first.and_then(|first| series.samples.get(first..)).unwrap_or_default()
}

/// Returns the maximal runs (rules 7 and 8): a run ends at a sample that violates the constraints, or at a gap, even if the gap extends
/// up to now.
fn runs<'a>(episode: &Episode, samples: &'a [Sample], view: View<'_>) -> Vec<Run<'a>> {
    let fitting = |sample: &Sample| fits(&sample.value, &episode.value, &mut Bindings::new());
    let apart = |from: Time, to: Time| episode.gap.is_some_and(|gap| to - from > gap);
    let mut found = Vec::new();
    let mut start = 0;
    while start < samples.len() {
        if !fitting(&samples[start]) {
            start += 1;
            continue;
        }
        let mut end = start + 1;
        while end < samples.len() && fitting(&samples[end]) && !apart(samples[end - 1].at, samples[end].at) {
            end += 1;
        }
        let next = samples.get(end);
        let closed = next.is_some() || apart(samples[end - 1].at, view.now);
        let begins = start > 0 && !fitting(&samples[start - 1]) && !apart(samples[start - 1].at, samples[start].at);
        found.push(Run { samples: &samples[start..end], begins, next, closed });
        start = end;
    }
    found
}

/// Returns the result from the first instant at which it is decided that the run satisfies the condition.
fn begun(episode: &Episode, run: &Run<'_>, bound: &Bindings, view: View<'_>) -> Option<Way> {
    let parts = (1..=run.samples.len()).filter_map(|length| going_on(episode, run, length, bound, view));
    parts.min_by_key(|way| way.known).or_else(|| over(episode, run, bound))
}

/// Returns the run if its first samples decide that it satisfies the condition regardless of its continuation, which only lower bounds
/// can decide. The interval is that of the whole run, as far as known.
fn going_on(episode: &Episode, run: &Run<'_>, length: usize, bound: &Bindings, view: View<'_>) -> Option<Way> {
    let samples = run.samples.get(..length)?;
    let (first, last) = (samples.first()?, samples.last()?);
    let next = run.samples.get(length).or(run.next).map(|sample| sample.at);
    let longest = held(episode, last, next, view) - first.at;
    let least = episode.duration.iter().map(|(relation, bound)| lower(*relation, *bound));
    let earliest = episode.end.iter().map(|(relation, bound)| lower(*relation, *bound));
    let least = least.collect::<Option<Vec<_>>>()?.into_iter().max().unwrap_or(0);
    let earliest = earliest.collect::<Option<Vec<_>>>()?.into_iter().max().unwrap_or(last.at);
    let needed = least.max(last.at - first.at);
    let fitting = needed <= longest && last.at >= earliest && fits_values(episode, samples);
    fitting.then(|| way(run.samples, bound, first.at + needed))
}

/// Returns the least permitted instant or span, if the relation permits all greater ones.
fn lower(relation: Relation, bound: i64) -> Option<i64> {
    match relation {
        Relation::GreaterOrEqual => Some(bound),
        Relation::Greater => Some(bound + 1),
        Relation::Different | Relation::Equal | Relation::Less | Relation::LessOrEqual => None,
    }
}

/// Returns the run if it is over and satisfied the condition, and only its end could decide that.
fn over(episode: &Episode, run: &Run<'_>, bound: &Bindings) -> Option<Way> {
    let bounded = |relation: &Relation| lower(*relation, 0).is_none();
    let until_the_end = episode.duration.iter().any(|(relation, _)| bounded(relation))
        || episode.end.iter().any(|(relation, _)| bounded(relation));
    when_over(episode, run, bound).filter(|_| until_the_end)
}

/// Returns the run if it is over and satisfied the condition. All bounds count between the first and the last sample, as in the reported
/// result.
fn when_over(episode: &Episode, run: &Run<'_>, bound: &Bindings) -> Option<Way> {
    let (first, last) = (run.samples.first()?, run.samples.last()?);
    let fitting = run.closed
        && episode.duration.iter().all(|(relation, bound)| numbers(*relation, last.at - first.at, *bound))
        && instant_fits(last.at, &episode.end)
        && fits_values(episode, run.samples);
    let expires = episode.gap.map_or(Time::MAX, |gap| last.at + gap + 1);
    let ended = run.next.map_or(Time::MAX, |next| next.at).min(expires);
    fitting.then(|| way(run.samples, bound, ended))
}

/// Returns the instant up to which the last value counts as held (rule 5): its own instant, or the end of the permitted gap, but before
/// the instant of the next sample.
pub(crate) fn held(episode: &Episode, last: &Sample, next: Option<Time>, view: View<'_>) -> Time {
    let until = next.map_or(view.now, |next| next - 1).min(view.now);
    episode.gap.map_or(last.at, |gap| (last.at + gap).min(until)).max(last.at)
}

/// Returns true if the first and the last value satisfy their constraints.
pub(crate) fn ends_fit(episode: &Episode, samples: &[Sample]) -> bool {
    let fit = |sample: Option<&Sample>, constraints| {
        sample.is_some_and(|sample| fits(&sample.value, constraints, &mut Bindings::new()))
    };
    fit(samples.first(), &episode.first_value) && fit(samples.last(), &episode.last_value)
}

fn fits_values(episode: &Episode, samples: &[Sample]) -> bool {
    ends_fit(episode, samples) && samples.first().is_some_and(|first| instant_fits(first.at, &episode.start))
}

fn way(samples: &[Sample], bound: &Bindings, known: Time) -> Way {
    let interval = samples.first().zip(samples.last()).map(|(first, last)| (first.at, last.at)).unwrap_or_default();
    Way::over(interval, known, bound.clone())
}

/// Returns the intervals between all pairs of samples of the run; held values after the last sample do not count.
fn any(episode: &Episode, run: &Run<'_>, bound: &Bindings) -> Vec<Way> {
    let mut found = Vec::new();
    for end in 1..=run.samples.len() {
        for start in 0..end {
            let samples = &run.samples[start..end];
            let length = run.samples[end - 1].at - run.samples[start].at;
            let fitting = episode.duration.iter().all(|(relation, bound)| numbers(*relation, length, *bound))
                && instant_fits(run.samples[end - 1].at, &episode.end)
                && fits_values(episode, samples);
            if fitting {
                found.push(way(samples, bound, run.samples[end - 1].at));
            }
        }
    }
    found
}

/// Returns the run as far as known. Its last value is known once it is over.
fn whole(episode: &Episode, run: &Run<'_>, bound: &Bindings, view: View<'_>) -> Option<Way> {
    if !episode.last_value.is_empty() {
        return when_over(episode, run, bound);
    }
    Some(Way { open: !run.closed, ..begun(episode, run, bound, view)? })
}
