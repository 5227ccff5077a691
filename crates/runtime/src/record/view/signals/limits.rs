//! Limits of a signal: the comparisons with fixed figures in the conditions that the mission's PDL watches, and the excursions of samples
//! beyond them.
//!
//! Comparisons are read from the checked program. A condition of a step that repeats or responds is a limit, because such a step answers
//! each excursion; other comparisons are thresholds. Figures that depend on a task's variables are unknown without the task and give no
//! limit.

use super::sample::StoredSample;
use crate::error::RecordError;
use crate::record::reader::RecordReader;
use crate::record::{EffectKind, EffectNeed};
use apex_forms::print::Style;
use apex_model::condition::{Condition, ConditionKind, Constraint, Relation, VariablePattern};
use apex_model::effect::Effect;
use apex_model::event::StateVariable;
use apex_model::expression::{Expr, ExprKind};
use apex_model::library::Library;
use apex_model::pattern::Pattern;
use apex_model::symbol::Symbol;
use apex_model::time::Time;
use apex_model::value::Value;
use serde::Serialize;
use std::collections::BTreeMap;

/// Maximum number of excursions in an answer; those that the executive answered and the longest are kept.
const EXCURSIONS_MAX: usize = 300;
/// Maximum depth of references between indexicals and functions.
const DEPTH_MAX: usize = 16;

/// A limit or threshold of a signal. Values beyond it satisfy the condition.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct SignalLimit {
    /// Values below this one are beyond the limit, in the signal's unit; `None` if low values are within.
    pub low: Option<f64>,
    /// Values above this one are beyond the limit, in the signal's unit; `None` if high values are within.
    pub high: Option<f64>,
    /// Seconds for which values must be beyond it; `None` if one sample suffices.
    pub duration_s: Option<f64>,
    /// Further conditions as PDL text; empty if there are none.
    pub also: String,
    /// True if a step that repeats or responds watches it; false for a threshold that a step awaits once.
    pub guarded: bool,
    /// The step that its condition starts, by its tag.
    pub step: String,
    /// `file:line:column` of the condition.
    pub place: String,
}

/// A stretch of time in which all samples were beyond a limit.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Excursion {
    /// The limit's place in the list of limits.
    pub limit: usize,
    /// Mission time in nanoseconds of the first sample beyond it.
    pub from_ns: i64,
    /// Mission time in nanoseconds of the last sample beyond it.
    pub to_ns: i64,
    /// The value farthest beyond it.
    pub peak: f64,
    /// Number of samples.
    pub samples: usize,
    /// Instant at which the executive found the condition satisfied by the excursion, nanoseconds of mission time. `None` if it did not:
    /// the excursion was too short, the condition was not watched, or another part did not hold.
    pub raised_ns: Option<i64>,
}

impl SignalLimit {
    fn is_beyond(&self, value: f64) -> bool {
        self.low.is_some_and(|low| value < low) || self.high.is_some_and(|high| value > high)
    }

    fn distance(&self, value: f64) -> f64 {
        let below = self.low.map_or(f64::NEG_INFINITY, |low| low - value);
        below.max(self.high.map_or(f64::NEG_INFINITY, |high| value - high))
    }
}

/// Returns the limits of `variable` in the program's procedures, in units of `factor` SI units.
pub(in crate::record::view) fn limits_of(library: &Library, variable: &StateVariable, factor: f64) -> Vec<SignalLimit> {
    let mut found = Vec::new();
    for step in library.procedures.iter().flat_map(|procedure| &procedure.steps) {
        let guarded = step.repeating.is_some() || step.responding.is_some();
        for condition in &step.waitfor {
            parts(condition, &mut |part| {
                let Some((pattern, value, duration)) = compared(part) else { return };
                if !is_about(pattern, variable) {
                    return;
                }
                let mut bounds = Bounds::default();
                value.iter().for_each(|constraint| bounds.take(library, constraint));
                if bounds.low.is_none() && bounds.high.is_none() {
                    return;
                }
                found.push(SignalLimit {
                    low: bounds.low.map(|si| si / factor),
                    high: bounds.high.map(|si| si / factor),
                    duration_s: duration.iter().find_map(|constraint| least(library, constraint)),
                    also: bounds.also.join(" and "),
                    guarded,
                    step: step.tag.to_string(),
                    place: library.describe_place(part.place),
                });
            });
        }
    }
    found
}

/// Calls `visit` with the conditions of single variables within `condition`.
fn parts(condition: &Condition, visit: &mut impl FnMut(&Condition)) {
    match &condition.kind {
        ConditionKind::Measurement(_) | ConditionKind::Episode(_) => visit(condition),
        ConditionKind::And(list, _) | ConditionKind::Or(list, _) | ConditionKind::InOrder(list, _) => {
            list.iter().for_each(|part| parts(part, visit));
        }
        ConditionKind::Allen { parts: list, .. } => list.iter().for_each(|part| parts(part, visit)),
        ConditionKind::Probing { condition, .. } => parts(condition, visit),
        // A negated comparison is not a limit, and the others compare no samples.
        _ => {}
    }
}

/// Returns the variable, the constraints on its values and those on the duration of their run.
fn compared(condition: &Condition) -> Option<(&VariablePattern, &[Constraint], &[Constraint])> {
    match &condition.kind {
        ConditionKind::Measurement(one) => Some((&one.variable, &one.value, &[])),
        ConditionKind::Episode(run) => Some((&run.variable, &run.value, &run.timing.duration)),
        _ => None,
    }
}

fn is_about(pattern: &VariablePattern, variable: &StateVariable) -> bool {
    pattern.attribute == variable.attribute
        && match &pattern.object {
            Pattern::Literal(object) => object.matches(&variable.object),
            // A variable or an indexical: any object of this attribute.
            _ => true,
        }
}

/// Bounds of a value by its constraints, in SI.
#[derive(Default)]
struct Bounds {
    low: Option<f64>,
    high: Option<f64>,
    also: Vec<String>,
}

impl Bounds {
    fn take(&mut self, library: &Library, constraint: &Constraint) {
        let known = match constraint {
            Constraint::Compare { relation, right, tolerance: None } => {
                number(library, right, &BTreeMap::new(), 0).is_some_and(|figure| self.beyond(*relation, figure, false))
            }
            Constraint::Predicate(name, arguments) => self.predicate(library, name, arguments),
            _ => false,
        };
        if !known {
            self.also.push(Style::Brief.constraint(constraint));
        }
    }

    /// Extends the bounds by a comparison: values in `relation` to `figure` are beyond the limit, or, if `of_magnitude`, values whose
    /// magnitude is. Returns false, and changes nothing, for a comparison that is not a bound.
    fn beyond(&mut self, relation: Relation, figure: f64, of_magnitude: bool) -> bool {
        match relation {
            Relation::Greater | Relation::GreaterOrEqual => {
                self.high = Some(self.high.map_or(figure, |high| high.max(figure)));
                if of_magnitude {
                    self.low = Some(self.low.map_or(-figure, |low| low.min(-figure)));
                }
                true
            }
            Relation::Less | Relation::LessOrEqual if !of_magnitude => {
                self.low = Some(self.low.map_or(figure, |low| low.min(figure)));
                true
            }
            _ => false,
        }
    }

    /// Recognises `(PREDICATE argument ..)` of a function whose body is a comparison of its first parameter, or an `and` with such
    /// comparisons. Returns true if it did.
    fn predicate(&mut self, library: &Library, name: &Symbol, arguments: &[Expr]) -> bool {
        let Some(function) = library.functions.get(name) else { return false };
        let ([value, others @ ..], [body]) = (&*function.parameters.required, &*function.body) else { return false };
        let figures: BTreeMap<&Symbol, f64> = others
            .iter()
            .zip(arguments)
            .filter_map(|(name, argument)| Some((name, number(library, argument, &BTreeMap::new(), 0)?)))
            .collect();
        let tests = match &body.kind {
            ExprKind::And(tests) => tests.as_slice(),
            _ => std::slice::from_ref(body),
        };
        let mut found = false;
        let mut others = Vec::new();
        for test in tests {
            if self.comparison(library, test, value, &figures) {
                found = true;
            } else {
                others.push(Style::Brief.expression(test));
            }
        }
        if found {
            self.also.extend(others);
        }
        found
    }

    /// Recognises `(> value figure)` or `(> (abs value) figure)`; true if it did.
    fn comparison(&mut self, library: &Library, test: &Expr, value: &Symbol, figures: &BTreeMap<&Symbol, f64>) -> bool {
        let ExprKind::Call { function, arguments } = &test.kind else { return false };
        let relation = match function.folded() {
            ">" => Relation::Greater,
            ">=" => Relation::GreaterOrEqual,
            "<" => Relation::Less,
            "<=" => Relation::LessOrEqual,
            _ => return false,
        };
        let [left, right] = arguments.as_slice() else { return false };
        let of_magnitude = match &left.kind {
            ExprKind::Local(name) if name == value => false,
            ExprKind::Call { function, arguments } if function.folded() == "abs" => {
                match arguments.first().map(|argument| &argument.kind) {
                    Some(ExprKind::Local(name)) if name == value => true,
                    _ => return false,
                }
            }
            _ => return false,
        };
        number(library, right, figures, 0).is_some_and(|figure| self.beyond(relation, figure, of_magnitude))
    }
}

/// Returns the least length of a run in seconds.
fn least(library: &Library, constraint: &Constraint) -> Option<f64> {
    match constraint {
        Constraint::Compare { relation: Relation::Greater | Relation::GreaterOrEqual, right, .. } => {
            number(library, right, &BTreeMap::new(), 0)
        }
        _ => None,
    }
}

/// Returns the value in SI of an expression whose value never changes.
fn number(library: &Library, expr: &Expr, locals: &BTreeMap<&Symbol, f64>, depth: usize) -> Option<f64> {
    if depth > DEPTH_MAX {
        return None;
    }
    let of = |expr: &Expr| number(library, expr, locals, depth + 1);
    match &expr.kind {
        ExprKind::Constant(value) => si(value),
        ExprKind::Local(name) => locals.get(name).copied(),
        ExprKind::Indexical(name) => library.indexicals.get(name).and_then(of),
        ExprKind::Named(name) => library.constants.get(name).and_then(of),
        ExprKind::Call { function, arguments } => match (function.folded(), arguments.as_slice()) {
            ("-", [one]) => of(one).map(|value| -value),
            _ => None,
        },
        _ => None,
    }
}

fn si(value: &Value) -> Option<f64> {
    value.as_number().map(|(si, _)| si).filter(|si| si.is_finite())
}

/// Instants at which the executive found the conditions of limits satisfied, by the place of the condition.
#[derive(Default)]
pub(in crate::record::view) struct Raised(BTreeMap<String, Vec<i64>>);

impl Raised {
    /// Returns the alarms up to `at_ns`.
    pub(in crate::record::view) fn read(
        reader: &RecordReader,
        limits: &[SignalLimit],
        at_ns: i64,
    ) -> Result<Raised, RecordError> {
        let mut raised = Raised::default();
        for limit in limits {
            raised.0.insert(limit.place.clone(), Vec::new());
        }
        if limits.is_empty() {
            return Ok(raised);
        }
        let effects = reader.effects()?;
        let places = 0..effects.table.place_later(Time(at_ns));
        let satisfied =
            |kind: &EffectKind| if kind.word == "satisfied" { EffectNeed::Effect } else { EffectNeed::Nothing };
        effects.scan(places, satisfied, |found| {
            if let Some(Effect::Decided(decision)) = &found.effect
                && let Some(place) = effects.place(decision)
                && let Some(times) = raised.0.get_mut(&place)
            {
                times.push(found.at.0);
            }
            Ok(())
        })?;
        Ok(raised)
    }

    /// Returns the first instant in `from..=to` at which the condition at `place` was satisfied.
    fn within(&self, place: &str, from: i64, to: i64) -> Option<i64> {
        self.0.get(place)?.iter().copied().find(|at| (from..=to).contains(at))
    }
}

/// Returns the excursions that touch the window, in order of time, and the number of shorter ones that are left out.
pub(in crate::record::view) fn excursions(
    limits: &[SignalLimit],
    samples: &[StoredSample],
    (from, to): (i64, i64),
    raised: &Raised,
) -> (Vec<Excursion>, usize) {
    let mut found = Vec::new();
    for (index, limit) in limits.iter().enumerate() {
        let mut end = 0;
        for run in samples.chunk_by(|a, b| limit.is_beyond(a.value) == limit.is_beyond(b.value)) {
            end += run.len();
            let (Some(first), Some(last)) = (run.first(), run.last()) else { continue };
            if !limit.is_beyond(first.value) || last.at_ns < from || first.at_ns > to {
                continue;
            }
            let farthest = |a: f64, b: f64| if limit.distance(b) > limit.distance(a) { b } else { a };
            let peak = run.iter().map(|sample| sample.value).fold(first.value, farthest);
            // The executive may recognise the excursion with the next sample, which is back inside.
            let until = samples.get(end).map_or(i64::MAX, |next| next.arrived_ns);
            found.push(Excursion {
                limit: index,
                from_ns: first.at_ns,
                to_ns: last.at_ns,
                peak,
                samples: run.len(),
                raised_ns: raised.within(&limit.place, first.at_ns, until),
            });
        }
    }
    found.sort_by_key(|one| (one.raised_ns.is_none(), one.from_ns - one.to_ns, one.from_ns));
    let left_out = found.len().saturating_sub(EXCURSIONS_MAX);
    found.truncate(EXCURSIONS_MAX);
    found.sort_by_key(|one| (one.from_ns, one.limit));
    (found, left_out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stretch_beyond_a_limit_ends_with_the_last_sample_beyond_it() {
        let limit = SignalLimit {
            low: Some(-3.0),
            high: Some(3.0),
            duration_s: None,
            also: String::new(),
            guarded: true,
            step: "weigh".into(),
            place: "a.pdl:1:1".into(),
        };
        let sample = |(index, value): (usize, &f64)| {
            let at_ns = index as i64;
            StoredSample { at_ns, arrived_ns: at_ns, value: *value }
        };
        let samples: Vec<StoredSample> = [0.0, 4.0, -5.0, 3.0, 6.0].iter().enumerate().map(sample).collect();
        let raised = Raised(BTreeMap::from([("a.pdl:1:1".to_owned(), vec![2])]));
        let (found, left_out) = excursions(&[limit], &samples, (0, 9), &raised);
        let one =
            |from_ns, to_ns, peak, samples, raised_ns| Excursion { limit: 0, from_ns, to_ns, peak, samples, raised_ns };
        assert_eq!(found, [one(1, 2, -5.0, 2, Some(2)), one(4, 4, 6.0, 1, None)]);
        assert_eq!(left_out, 0);
    }

    #[test]
    fn an_answered_excursion_is_never_left_out() {
        let limit = SignalLimit {
            low: None,
            high: Some(3.0),
            duration_s: None,
            also: String::new(),
            guarded: true,
            step: "weigh".into(),
            place: "a.pdl:1:1".into(),
        };
        let sample =
            |at_ns: i64| StoredSample { at_ns, arrived_ns: at_ns, value: if at_ns % 2 == 0 { 9.0 } else { 0.0 } };
        let samples: Vec<StoredSample> = (0..2_000).map(sample).collect();
        let raised = Raised(BTreeMap::from([("a.pdl:1:1".to_owned(), vec![1_700])]));
        let (found, left_out) = excursions(&[limit], &samples, (0, 2_000), &raised);
        assert_eq!((found.len(), left_out), (EXCURSIONS_MAX, 1_000 - EXCURSIONS_MAX));
        assert!(found.iter().any(|one| one.from_ns == 1_700 && one.raised_ns == Some(1_700)));
    }
}
