//! Measurements: one sample, or one estimated value (rules 2, 9, 10, 18, 19).

use crate::condition::{Estimation, Measurement, Relation, Time, Variable};
use crate::history::Series;
use crate::value::{Bindings, Value, fits, matches};
use crate::ways::{View, Way, Ways, instant_fits};

/// Returns the series that match the variable, each with the resulting bindings, in the order of arrival of the first sample that counts
/// (rule 19). `from` gives the instant from which samples of a series count.
pub(crate) fn series_of<'a>(
    variable: &Variable,
    from: impl Fn(&Series) -> Time,
    view: View<'a>,
) -> Vec<(&'a Series, Bindings)> {
    let mut found = Vec::new();
    for series in view.past.variables.iter().filter(|series| series.attribute == variable.attribute) {
        let mut bound = Bindings::new();
        let object = Value::symbol(&series.object);
        if matches(&variable.object, &object, &mut bound) && fits(&object, &variable.tests, &mut bound) {
            found.push((series, bound));
        }
    }
    found.sort_by_key(|(series, _)| {
        let counting = series.appearances.iter().filter(|(at, _)| *at >= from(series));
        counting.map(|(_, number)| *number).min().unwrap_or(usize::MAX)
    });
    found
}

/// Returns the instant from which samples count: the creation, the last sample before it if that may still be valid, or the earliest
/// instant.
fn counting(measurement: &Measurement, series: &Series, view: View<'_>) -> Time {
    if !measurement.timestamp.is_empty() {
        return Time::MIN;
    }
    let before = series.samples.iter().rev().find(|sample| sample.at < view.created);
    match (&measurement.estimation, before) {
        (Some(Estimation::Persist(_)), Some(before)) => before.at,
        _ => view.created,
    }
}

/// Returns true if there is a sample that matches the variable and that `counts`, regardless of constraints on its object.
pub(crate) fn heard_of(variable: &Variable, view: View<'_>, counts: impl Fn(&Series) -> bool) -> bool {
    let mut series = view.past.variables.iter().filter(|series| series.attribute == variable.attribute);
    series
        .any(|series| matches(&variable.object, &Value::symbol(&series.object), &mut Bindings::new()) && counts(series))
}

/// Rule 2: returns true if the instant is in the window, which begins with the creation unless the condition constrains the instants.
pub(crate) fn in_window(at: Time, tests: &[(Relation, Time)], view: View<'_>) -> bool {
    if tests.is_empty() { at >= view.created } else { instant_fits(at, tests) }
}

/// Returns every sample, or every estimate, that fits.
pub(crate) fn ways(measurement: &Measurement, view: View<'_>) -> Ways {
    if let Some(Estimation::Regression(options)) = &measurement.estimation {
        return crate::regression::ways(measurement, options, view);
    }
    let mut found = Ways::default();
    for (series, bound) in series_of(&measurement.variable, |series| counting(measurement, series, view), view) {
        match &measurement.estimation {
            Some(Estimation::Regression(_)) | None => found.all.extend(sampled(measurement, series, &bound, view)),
            Some(Estimation::Persist(timeout)) => {
                found.all.extend(persisted(measurement, *timeout, series, &bound, view));
            }
        }
    }
    // If no sample is valid any longer the value is unknown.
    if let Some(Estimation::Persist(timeout)) = &measurement.estimation {
        let valid = |series: &Series| {
            series.samples.last().is_some_and(|newest| timeout.is_none_or(|timeout| view.now - newest.at <= timeout))
        };
        if !heard_of(&measurement.variable, view, valid) {
            found.unknown = Some("no sample is valid".into());
        }
    }
    found
}

fn sampled(measurement: &Measurement, series: &Series, bound: &Bindings, view: View<'_>) -> Vec<Way> {
    let mut found = Vec::new();
    for sample in series.samples.iter().filter(|sample| in_window(sample.at, &measurement.timestamp, view)) {
        let mut bound = bound.clone();
        if fits(&sample.value, &measurement.value, &mut bound) {
            found.push(Way::over((sample.at, sample.at), sample.at, bound));
        }
    }
    found
}

/// Rule 9: a sample is valid from its instant on, for at most the timeout, and until the next sample. The condition is satisfied at the
/// first instant of the window at which a matching value is valid.
fn persisted(
    measurement: &Measurement,
    timeout: Option<i64>,
    series: &Series,
    bound: &Bindings,
    view: View<'_>,
) -> Vec<Way> {
    let mut found = Vec::new();
    for (index, sample) in series.samples.iter().enumerate() {
        let next = series.samples.get(index + 1).map_or(Time::MAX, |next| next.at - 1);
        let expires = timeout.map_or(Time::MAX, |timeout| sample.at + timeout);
        let last = next.min(expires).min(view.now);
        // The first and last instant of the window within [sample, last] are among these, because windows are defined by bounds.
        let bounds = measurement.timestamp.iter().map(|(_, bound)| *bound);
        let mut instants: Vec<Time> = bounds.flat_map(|bound| [bound - 1, bound, bound + 1]).collect();
        instants.extend([sample.at, view.created, last]);
        instants.retain(|at| (sample.at..=last).contains(at) && in_window(*at, &measurement.timestamp, view));
        let fitting = instants.iter().min().copied();
        let mut bound = bound.clone();
        if let Some(at) = fitting
            && fits(&sample.value, &measurement.value, &mut bound)
        {
            let lasts = instants.iter().max().copied();
            found.push(Way { lasts, ..Way::over((sample.at, sample.at), at, bound) });
        }
    }
    found
}
