//! The line through samples (rule 10; decision 0026), in seconds since the first of them.

use crate::condition::{Constraint, Estimation, Measurement, Regression, Relation, Time};
use crate::history::{Past, Sample, Series};
use crate::measurement::{heard_of, series_of};
use crate::statistics::finite;
use crate::trend::{line, points};
use crate::value::{Bindings, Value};
use crate::verdict::Question;
use crate::ways::{View, Way, Ways};

/// A crossing nearer to an instant than this, in nanoseconds, is at that instant: rounding can be as large.
const ROUNDING_NS: f64 = 1e-3;

/// Farthest predicted instant. The slope of a line that is level except for rounding counts as zero.
const FARTHEST: Time = Time::MAX / 2;

/// Result of fitting a line.
enum Saying {
    /// The line meets the constraints, according to the knowledge at that time.
    Meets(Way),
    /// The line does not satisfy them.
    Fails,
    /// No line can be fitted, or its criteria reject it.
    Unknown,
}

/// Returns the lines of all objects.
pub(crate) fn ways(measurement: &Measurement, options: &Regression, view: View<'_>) -> Ways {
    let mut found = Ways::default();
    let on_line = |series: &Series| !fitted(measurement, options, series, view).is_empty();
    for (series, bound) in series_of(&measurement.variable, |_| fit_start(measurement, options, view), view) {
        match says(measurement, options, series, &bound, view) {
            _ if !on_line(series) => {}
            Saying::Meets(way) if way.known <= view.now => found.all.push(way),
            Saying::Meets(_) | Saying::Fails => {}
            Saying::Unknown => found.unknown = Some("there is no line".into()),
        }
    }
    if !heard_of(&measurement.variable, view, on_line) {
        found.unknown = Some("nothing was ever measured".into());
    }
    found
}

/// Returns the instants at which the lines satisfy the constraints, as far as they lie ahead.
pub(crate) fn foreseen(measurement: &Measurement, question: &Question, past: &Past, now: Time) -> Vec<Time> {
    let Some(Estimation::Regression(options)) = &measurement.estimation else { return Vec::new() };
    let view = View { question, past, created: question.created, now, runs: crate::ways::Runs::Begun };
    let all = series_of(&measurement.variable, |_| Time::MIN, view).into_iter();
    let sayings = all.map(|(series, bound)| says(measurement, options, series, &bound, view));
    sayings.filter_map(|saying| if let Saying::Meets(way) = saying { Some(way.known) } else { None }).collect()
}

fn fit_start(measurement: &Measurement, options: &Regression, view: View<'_>) -> Time {
    options.start.unwrap_or(if measurement.timestamp.is_empty() { view.created } else { Time::MIN })
}

/// Returns the samples of the fit interval that are finite numbers; without an interval, of the window.
fn fitted(measurement: &Measurement, options: &Regression, series: &Series, view: View<'_>) -> Vec<Sample> {
    let within = fit_start(measurement, options, view)..=options.end.unwrap_or(Time::MAX);
    let number = |sample: &&Sample| !finite(std::slice::from_ref(*sample)).is_empty();
    series.samples.iter().filter(|sample| within.contains(&sample.at)).filter(number).cloned().collect()
}

fn says(measurement: &Measurement, options: &Regression, series: &Series, bound: &Bindings, view: View<'_>) -> Saying {
    let samples = fitted(measurement, options, series, view);
    let (Some(first), Some(last)) = (samples.first(), samples.last()) else { return Saying::Unknown };
    let values = points(&samples);
    let Some((mean_t, mean_v, slope)) = line(&values) else { return Saying::Unknown };
    let value_at = |at: Time| mean_v + slope * ((at - first.at) as f64 / 1e9 - mean_t);
    let squares: f64 = values.iter().map(|(t, v)| (v - mean_v - slope * (t - mean_t)).powi(2)).sum();
    let widest = samples.windows(2).map(|pair| pair[1].at - pair[0].at).max().unwrap_or(0);
    if samples.len() < options.points_min.unwrap_or(2)
        || options.gap_max.is_some_and(|most| widest > most)
        || options.error_max.is_some_and(|most| (squares / samples.len() as f64).sqrt() > most)
    {
        return Saying::Unknown;
    }
    // The window: from the creation on, or according to its bounds; later instants within the bounds are predicted.
    let (least, most) = window(&measurement.timestamp);
    let from = least.unwrap_or(if measurement.timestamp.is_empty() { view.created } else { first.at });
    let reaches = |value: f64| (mean_t + (value - mean_v) / slope) * 1e9 + first.at as f64;
    let unmet = || {
        let silence = view.now.min(options.end.unwrap_or(Time::MAX)) - last.at;
        if options.gap_max.is_some_and(|most| silence > most) { Saying::Unknown } else { Saying::Fails }
    };
    let Some(at) = earliest(&measurement.value, from, value_at, reaches, slope) else { return unmet() };
    if most.is_some_and(|most| at > most) {
        return unmet();
    }
    let nearest = if at < first.at { &values[0] } else { &values[values.len() - 1] };
    let outside = at < first.at || at > last.at;
    if outside && options.difference_max.is_some_and(|most| (value_at(at) - nearest.1).abs() > most) {
        return Saying::Unknown;
    }
    let known = if most.is_some() || at == from { last.at } else { last.at.max(at) };
    if options.gap_max.is_some_and(|most| known - last.at > most) {
        return unmet();
    }
    // The result exists for as long as the line predicts it.
    let way = Way::over((first.at, last.at), known.max(view.created), bound.clone());
    Saying::Meets(Way { instant: true, ..way })
}

/// Returns the first and last instant that the tests permit.
fn window(tests: &[(Relation, Time)]) -> (Option<Time>, Option<Time>) {
    let least = tests.iter().filter_map(|(relation, at)| match relation {
        Relation::Greater => Some(at + 1),
        Relation::GreaterOrEqual | Relation::Equal => Some(*at),
        _ => None,
    });
    let most = tests.iter().filter_map(|(relation, at)| match relation {
        Relation::Less => Some(at - 1),
        Relation::LessOrEqual | Relation::Equal => Some(*at),
        _ => None,
    });
    (least.max(), most.min())
}

/// Returns the first instant from `from` on at which the line satisfies all constraints: `from`, or the instant at which it crosses a
/// bound.
fn earliest(
    constraints: &[Constraint],
    from: Time,
    value_at: impl Fn(Time) -> f64,
    reaches: impl Fn(f64) -> f64,
    slope: f64,
) -> Option<Time> {
    let mut candidates = vec![from];
    if slope != 0.0 {
        for bound in constraints.iter().flat_map(bounds) {
            let crossing = reaches(bound);
            candidates
                .extend([(crossing - ROUNDING_NS).ceil() as Time, (crossing + ROUNDING_NS + 1.0).floor() as Time]);
        }
    }
    candidates.retain(|at| (from..=FARTHEST).contains(at));
    candidates.sort_unstable();
    let near = slope.abs() * ROUNDING_NS / 1e9;
    candidates.into_iter().find(|at| constraints.iter().all(|each| satisfied(each, value_at(*at), near)))
}

fn bounds(constraint: &Constraint) -> Vec<f64> {
    match constraint {
        Constraint::Compare(_, Value::Number(number), None) => vec![*number],
        Constraint::Compare(_, Value::Number(number), Some(around)) => vec![number - around, number + around],
        Constraint::Range(least, most) => least.iter().chain(most).copied().collect(),
        _ => Vec::new(),
    }
}

/// Returns true if the value satisfies the constraint. A value within `near` of a bound, the size of rounding errors, counts as equal to
/// it.
fn satisfied(constraint: &Constraint, value: f64, near: f64) -> bool {
    let below = |bound: f64| value < bound - near;
    let above = |bound: f64| value > bound + near;
    match constraint {
        Constraint::Compare(relation, Value::Number(number), tolerance) => match relation {
            Relation::Less => below(*number),
            Relation::LessOrEqual => !above(*number),
            Relation::Greater => above(*number),
            Relation::GreaterOrEqual => !below(*number),
            Relation::Equal => {
                let around = tolerance.unwrap_or(0.0);
                !below(number - around) && !above(number + around)
            }
            Relation::Different => below(*number) || above(*number),
        },
        Constraint::Range(least, most) => !least.is_some_and(below) && !most.is_some_and(above),
        _ => false,
    }
}
