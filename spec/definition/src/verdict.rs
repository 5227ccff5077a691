//! The answer at an instant, and the instant since which the condition is satisfied (rules 2, 3, 21, 22).

use crate::condition::{Condition, Episode, Estimation, Kind, Measurement, Span, Time};
use crate::history::{Arrival, Past, What, known};
use crate::value::Bindings;
use crate::ways::{Interval, Runs, View, Way, ways};
use std::collections::{BTreeMap, BTreeSet};

/// A condition, the instant of its creation, and all arrivals in order of arrival.
#[derive(Clone, Debug, PartialEq)]
pub struct Question {
    /// The condition to judge.
    pub condition: Condition,
    /// The creation of the monitor.
    pub created: Time,
    /// All arrivals, including those later than any compared `now`.
    pub arrivals: Vec<Arrival>,
    /// Permitted lateness of samples by attribute.
    pub lateness: BTreeMap<String, Span>,
}

/// The truth at an instant.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    /// The condition is satisfied, by this result.
    Satisfied(Outcome),
    /// The condition has not been satisfied so far.
    NotSatisfied,
    /// The data do not decide the condition, for this reason.
    Unknown(String),
}

/// A result (rule 22).
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// First and last evidence.
    pub interval: Interval,
    /// The first instant at which the condition was satisfied.
    pub recognised_at: Time,
    /// Values of variables.
    pub variables: Bindings,
    /// Intervals of tags.
    pub tags: BTreeMap<String, Interval>,
}

impl Outcome {
    fn nothing(now: Time) -> Outcome {
        Outcome { interval: (now, now), recognised_at: now, variables: Bindings::new(), tags: BTreeMap::new() }
    }
}

/// Returns the truth at `now`, from the knowledge of that instant.
pub fn judge(question: &Question, now: Time) -> Verdict {
    let past = known(&question.arrivals, &question.lateness, now);
    let view = View { question, past: &past, created: question.created, now, runs: Runs::Begun };
    let found = ways(&question.condition, view);
    match (found.all.is_empty(), found.unknown) {
        (true, Some(reason)) => Verdict::Unknown(reason),
        (true, None) => Verdict::NotSatisfied,
        (false, _) => {
            let way = told_first(&question.condition, view);
            Verdict::Satisfied(way.map_or_else(|| Outcome::nothing(now), |way| outcome(&way, now)))
        }
    }
}

/// Returns the way to report if several are known now. For the alternatives of an outermost `:or` this is the first that is satisfied;
/// otherwise it is the way that would have been known first without late arrivals.
fn told_first(condition: &Condition, view: View<'_>) -> Option<Way> {
    let Kind::Or(parts) = &condition.kind else { return ways(condition, view).all.into_iter().next() };
    let mut way = parts.iter().find_map(|part| told_first(part, view))?;
    way.tags.extend(condition.tag.clone().zip(way.hull));
    Some(way)
}

fn outcome(way: &Way, now: Time) -> Outcome {
    Outcome {
        interval: way.hull.unwrap_or((now, now)),
        recognised_at: now,
        variables: way.bound.clone(),
        tags: way.tags.clone(),
    }
}

/// Returns the first result up to `until`: the result at the first instant at which the condition is satisfied.
pub fn first(question: &Question, until: Time) -> Option<Outcome> {
    instants(question, until).into_iter().find_map(|now| match judge(question, now) {
        Verdict::Satisfied(outcome) => Some(outcome),
        _ => None,
    })
}

/// Returns every instant from the creation up to `until` at which the truth may change: the instants of arrivals, the instants one or two
/// of the condition's spans later, and one nanosecond after each of these.
pub fn instants(question: &Question, until: Time) -> BTreeSet<Time> {
    let mut spans = Vec::new();
    spans_of(&question.condition, &mut spans);
    let one = distinct(spans);
    let mut spans: Vec<Span> = one.iter().flat_map(|first| one.iter().map(move |second| first + second)).collect();
    spans.extend(one.iter().chain(&[0]));
    let spans = distinct(spans);
    let mut begins: Vec<Time> = vec![question.created];
    for arrival in question.arrivals.iter().filter(|arrival| !matches!(arrival.what, What::Sample(_, _, None))) {
        begins.extend([arrival.at, arrival.arrives]);
    }
    begins.extend(instants_of(&question.condition));
    // The instants at which lines meet constraints, and held values limits of weighted statistics, become known as samples arrive.
    let mut lines = Vec::new();
    lines_of(&question.condition, &mut lines);
    let mut weighted = Vec::new();
    weighted_of(&question.condition, &mut weighted);
    for arrival in question.arrivals.iter().filter(|_| !lines.is_empty() || !weighted.is_empty()) {
        let past = known(&question.arrivals, &question.lateness, arrival.arrives);
        let at = arrival.arrives.max(question.created);
        let mut meets = |past: &Past, at: Time| {
            let meets = lines.iter().flat_map(|line| crate::regression::foreseen(line, question, past, at));
            let ends = weighted.iter().flat_map(|episode| crate::episode::foreseen(episode, question, past, until));
            begins.extend(meets.chain(ends).filter(|at| *at <= until));
        };
        meets(&past, at);
        // A late arrival also determines the lines at instants since it was taken.
        for then in question.arrivals.iter().map(|each| each.at).filter(|at| (arrival.at..arrival.arrives).contains(at))
        {
            meets(&past.up_to(then), then.max(question.created));
        }
    }
    let begins = distinct(begins);
    let every = begins.iter().flat_map(|begin| spans.iter().flat_map(move |span| [begin + span, begin + span + 1]));
    let all = every.chain(question.arrivals.iter().map(|arrival| arrival.arrives));
    all.filter(|at| (question.created..=until).contains(at)).collect()
}

fn distinct(mut all: Vec<i64>) -> Vec<i64> {
    all.sort_unstable();
    all.dedup();
    all
}

/// Adds to `spans` every length of time that the condition names.
fn spans_of(condition: &Condition, spans: &mut Vec<Span>) {
    if let Kind::InOrder(parts, _) = &condition.kind {
        // Delays in a row add up.
        let mut row = 0;
        for part in parts {
            row = if let Kind::Delay(least, _) = part.kind { row + least } else { 0 };
            spans.push(row);
        }
    }
    let parts = match &condition.kind {
        Kind::Measurement(measurement) => {
            match &measurement.estimation {
                Some(Estimation::Persist(timeout)) => spans.extend(timeout),
                Some(Estimation::Regression(options)) => spans.extend(options.gap_max),
                None => {}
            }
            return;
        }
        Kind::Episode(episode) => {
            spans.extend(episode.gap);
            spans.extend(episode.duration.iter().map(|(_, span)| *span));
            return;
        }
        Kind::And(parts, _) | Kind::Or(parts) | Kind::InOrder(parts, _) | Kind::Allen { parts, .. } => parts.as_slice(),
        Kind::Not(part) => std::slice::from_ref(&**part),
        Kind::Absent(part, span) => {
            // A span may begin where evidence of the part ends.
            let mut inner = vec![0];
            spans_of(part, &mut inner);
            spans.extend(inner.into_iter().map(|inner| inner + span));
            std::slice::from_ref(&**part)
        }
        Kind::Delay(least, _) => {
            spans.push(*least);
            return;
        }
        Kind::Cyclic(_)
        | Kind::Timestamp(..)
        | Kind::Event(..)
        | Kind::Function(..)
        | Kind::TaskEnded(_)
        | Kind::TaskState(..) => return,
    };
    parts.iter().for_each(|part| spans_of(part, spans));
}

/// Adds to `lines` every measurement whose values are those of a regression line.
fn lines_of<'a>(condition: &'a Condition, lines: &mut Vec<&'a Measurement>) {
    match &condition.kind {
        Kind::Measurement(measurement) => {
            lines.extend(Some(measurement).filter(|each| matches!(each.estimation, Some(Estimation::Regression(_)))));
        }
        Kind::And(parts, _) | Kind::Or(parts) | Kind::InOrder(parts, _) | Kind::Allen { parts, .. } => {
            parts.iter().for_each(|part| lines_of(part, lines));
        }
        Kind::Not(part) | Kind::Absent(part, _) => lines_of(part, lines),
        _ => {}
    }
}

/// Adds to `weighted` every episode with a statistic that is weighted by time.
fn weighted_of<'a>(condition: &'a Condition, weighted: &mut Vec<&'a Episode>) {
    match &condition.kind {
        Kind::Episode(episode) => {
            let is_weighted = episode.stats.iter().any(|(statistic, ..)| crate::statistics::is_weighted(*statistic));
            weighted.extend(Some(episode).filter(|_| is_weighted));
        }
        Kind::And(parts, _) | Kind::Or(parts) | Kind::InOrder(parts, _) | Kind::Allen { parts, .. } => {
            parts.iter().for_each(|part| weighted_of(part, weighted));
        }
        Kind::Not(part) | Kind::Absent(part, _) => weighted_of(part, weighted),
        _ => {}
    }
}

/// Returns every instant that the condition names.
fn instants_of(condition: &Condition) -> Vec<Time> {
    match &condition.kind {
        Kind::Measurement(measurement) => measurement.timestamp.iter().map(|(_, at)| *at).collect(),
        Kind::Episode(episode) => episode.start.iter().chain(&episode.end).map(|(_, at)| *at).collect(),
        Kind::Event(_, when) => when.iter().map(|(_, at)| *at).collect(),
        Kind::Timestamp(from, to) => [*from].into_iter().chain(*to).collect(),
        Kind::And(parts, _) | Kind::Or(parts) | Kind::InOrder(parts, _) | Kind::Allen { parts, .. } => {
            parts.iter().flat_map(instants_of).collect()
        }
        Kind::Not(part) | Kind::Absent(part, _) => instants_of(part),
        Kind::Cyclic(_) | Kind::Delay(..) | Kind::Function(..) | Kind::TaskEnded(_) | Kind::TaskState(..) => Vec::new(),
    }
}
