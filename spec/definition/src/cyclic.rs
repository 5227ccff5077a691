//! Values that go up and down (`docs/reference/conditions.md`, Cycles): turning points, identified from both sides.

use crate::condition::{Cyclic, Time};
use crate::history::{Sample, Series};
use crate::measurement::{heard_of, series_of};
use crate::value::{Bindings, Value, numbers};
use crate::ways::{View, Way, Ways};

/// A turning point, and the sample that proves it.
struct Turn {
    at: Time,
    value: f64,
    known: Time,
}

/// Returns the cycles of all objects.
pub(crate) fn ways(cyclic: &Cyclic, view: View<'_>) -> Ways {
    let mut found = Ways::default();
    for (series, bound) in series_of(&cyclic.variable, |_| view.created, view) {
        let samples = windowed(series, view);
        let mut contradicted = false;
        for stretch in samples.split(|sample| number(sample).is_none()) {
            let turns = turns(stretch, cyclic.hysteresis.unwrap_or(0.0));
            contradicted |= !turns.windows(3).all(|turns| fits(cyclic, turns));
            found.all.extend(runs(cyclic, &turns, &bound));
        }
        if !samples.is_empty() && !contradicted {
            found.unknown = Some("no cycle was different yet".into());
        }
    }
    if !heard_of(&cyclic.variable, view, |series| !windowed(series, view).is_empty()) {
        found.unknown = Some("nothing was ever measured".into());
    }
    found
}

fn windowed<'a>(series: &'a Series, view: View<'_>) -> &'a [Sample] {
    let first = series.samples.iter().position(|sample| sample.at >= view.created);
    first.and_then(|first| series.samples.get(first..)).unwrap_or_default()
}

fn number(sample: &Sample) -> Option<f64> {
    match sample.value {
        Value::Number(number) if number.is_finite() => Some(number),
        _ => None,
    }
}

/// Returns the turning points among samples that are all numbers: maxima and minima, in order of time.
fn turns(samples: &[Sample], hysteresis: f64) -> Vec<Turn> {
    let points: Vec<(Time, f64)> = samples.iter().filter_map(|sample| Some((sample.at, number(sample)?))).collect();
    let turned: Vec<(Time, f64)> = points.iter().map(|(at, value)| (*at, -value)).collect();
    let mut all = maxima(&points, hysteresis);
    all.extend(maxima(&turned, hysteresis).into_iter().map(|turn| Turn { value: -turn.value, ..turn }));
    all.sort_by_key(|turn| turn.at);
    all
}

/// Returns the maxima: the value rose to each by the hysteresis, and fell from it by the hysteresis; of equal values the first.
fn maxima(points: &[(Time, f64)], hysteresis: f64) -> Vec<Turn> {
    let mut found = Vec::new();
    for (index, (at, value)) in points.iter().enumerate() {
        let apart = |other: f64| value - other > 0.0 && value - other >= hysteresis;
        let came_up = points[..index].iter().rev().take_while(|(_, before)| before < value).any(|(_, v)| apart(*v));
        let after = points[index + 1..].iter().take_while(|(_, after)| after <= value);
        let back = after.into_iter().find(|(_, after)| apart(*after));
        if let Some((known, _)) = back.filter(|_| came_up) {
            found.push(Turn { at: *at, value: *value, known: *known });
        }
    }
    found
}

/// Returns true if three successive turning points make a cycle that satisfies the constraints.
fn fits(cyclic: &Cyclic, turns: &[Turn]) -> bool {
    let [first, middle, last] = turns else { return false };
    let amplitude = ((first.value + last.value) / 2.0 - middle.value).abs() / 2.0;
    cyclic.period.iter().all(|(relation, span)| numbers(*relation, last.at - first.at, *span))
        && cyclic.amplitude.iter().all(|(relation, bound)| numbers(*relation, amplitude, *bound))
}

/// For each run of cycles that satisfy the constraints, returns its first part with enough cycles. A run begins at a maximum or a minimum.
fn runs(cyclic: &Cyclic, turns: &[Turn], bound: &Bindings) -> Vec<Way> {
    let halves: Vec<&[Turn]> = turns.windows(3).collect();
    let mut found = Vec::new();
    for run in halves.split(|turns| !fits(cyclic, turns)) {
        let complete = run.iter().enumerate().filter(|(index, _)| index % 2 == 0);
        let enough = |cycles: i64| match cyclic.cycles.as_slice() {
            [] => cycles >= 2,
            tests => tests.iter().all(|(relation, number)| numbers(*relation, cycles, *number)),
        };
        let first = complete.enumerate().find(|(index, _)| enough(*index as i64 + 1));
        if let (Some((_, (_, end))), Some(start)) = (first, run.first()) {
            found.push(Way::over((start[0].at, end[2].at), end[2].known, bound.clone()));
        }
    }
    found
}
