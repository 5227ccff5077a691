//! Conditions that can never hold: limits that exclude each other, tests that are false as written.

use super::endings::known_truth;
use super::kinds::{Kind, Kinds};
use super::walk::{self, sides};
use apex_model::condition::{Condition, ConditionKind, Constraint, Relation, Timing};
use apex_model::expression::{Expr, ExprKind};
use apex_model::library::{Library, RESOURCE_LEVEL, ResourceKind};
use apex_model::pattern::Pattern;
use apex_model::quantity::Dimension;
use apex_model::source::Place;
use apex_model::symbol::Symbol;
use apex_model::value::Value;

/// Reason for which a condition cannot hold.
pub(crate) struct Impossible {
    /// Place of the fault.
    pub(crate) place: Place,
    /// Text that follows "this condition can never hold:".
    pub(crate) reason: String,
    /// The remedy.
    pub(crate) help: &'static str,
}

/// Remedy for limits that exclude each other.
const LIMITS: &str = "exchange the limits, or join two conditions with `(:or ..)`";

/// Returns the reason for which the condition itself, not one of its parts, can never hold; `None` if that is undecided.
pub(crate) fn impossible(condition: &Condition, library: &Library) -> Option<Impossible> {
    let within = |what: &str, constraints: &[Constraint]| {
        let reason = contradiction(constraints, library)?;
        let place = last_limit(constraints).unwrap_or(condition.place);
        Some(Impossible { place, reason: format!("{what} {reason}"), help: LIMITS })
    };
    if let Some(found) = level(condition, library) {
        return Some(found);
    }
    match &condition.kind {
        ConditionKind::Measurement(measurement) => {
            let is_declared = library.state_variables.contains_key(&measurement.variable.attribute);
            // A declared variable has a type, which is compared with that of the value.
            within("the value", &measurement.value)
                .or_else(|| if is_declared { None } else { order_of_names(&measurement.value) })
        }
        ConditionKind::Episode(episode) => within("the value", &episode.value)
            .or_else(|| within("the first value", &[&*episode.value, &*episode.first_value].concat()))
            .or_else(|| within("the last value", &[&*episode.value, &*episode.last_value].concat()))
            .or_else(|| duration(&episode.timing, condition.place, library))
            .or_else(|| statistic(&episode.stats, condition.place, library))
            .or_else(|| trend(&episode.trend, condition.place, library)),
        ConditionKind::Event { timing, .. } => duration(timing, condition.place, library),
        ConditionKind::Delay(least, Some(most)) => {
            let (from, to) = (number(least, library)?, number(most, library)?);
            (from > to).then(|| Impossible {
                place: condition.place,
                reason: "its least delay is longer than its greatest delay".to_string(),
                help: LIMITS,
            })
        }
        ConditionKind::Function(test) if known_truth(Some(test)) == Some(false) => {
            Some(Impossible { place: test.place, reason: "its expression is always nil".to_string(), help: LIMITS })
        }
        ConditionKind::Timestamp(from, _) if is_after_now(from) => {
            let reason = "`+now+` is read again at each instant, so the instant stays in the future".to_string();
            let help =
                "write `(:delay D)` for the time since the creation of the task, or `(+ (start-of +this-task+) D)`";
            Some(Impossible { place: from.place, reason, help })
        }
        kind => walk::options(kind)
            .iter()
            .find_map(|(name, constraints)| never(name, constraints, Some(0.0), condition.place, library)),
    }
}

/// Returns the place of the last limit that is compared with; `None` without one. The form of a condition may span many lines.
fn last_limit(constraints: &[Constraint]) -> Option<Place> {
    constraints.iter().rev().find_map(|constraint| match constraint {
        Constraint::Compare { right, .. } => Some(right.place),
        _ => None,
    })
}

/// Returns the reason for which the level of a resource is never compared: the resource has none, or an amount of another dimension.
fn level(condition: &Condition, library: &Library) -> Option<Impossible> {
    let (variable, constraints) = match &condition.kind {
        ConditionKind::Measurement(each) => (&each.variable, vec![&each.value]),
        ConditionKind::Episode(each) => (&each.variable, vec![&each.value, &each.first_value, &each.last_value]),
        _ => return None,
    };
    let Pattern::Literal(Value::Symbol(name)) = &variable.object else { return None };
    if !variable.attribute.is(RESOURCE_LEVEL) || library.resources.is_empty() {
        return None;
    }
    let without = |reason: String, help| Some(Impossible { place: condition.place, reason, help });
    let Some(resource) = library.resources.get(name) else {
        return without(format!("no resource `{name}` is declared"), "declare it: `(resource NAME :renewable AMOUNT)`");
    };
    let ResourceKind::Renewable(amount) = &resource.kind else {
        let reason = format!("the resource `{name}` is not `:renewable`, and only renewable resources have a level");
        return without(reason, "declare it as `(resource NAME :renewable AMOUNT)`");
    };
    let dimension = amount.as_number().map(|(_, dimension)| dimension)?;
    let mut sides = constraints.into_iter().flatten().flat_map(sides);
    let other = |right: &&Expr| match Kinds::of(library, right) {
        Kind::Number(found) => found != dimension,
        _ => false,
    };
    let wrong = sides.find(other)?;
    let (level, found) = (Kind::Number(dimension).words(), Kinds::of(library, wrong).words());
    let reason = format!("the level of `{name}` is {level}, as declared, and it is compared with {found}");
    Some(Impossible {
        place: wrong.place,
        reason,
        help: "write the amount with the unit of the resource, such as `5kg`",
    })
}

/// Returns true for `+now+` plus durations that are written out and greater than zero.
fn is_after_now(expr: &Expr) -> bool {
    let ExprKind::Call { function, arguments } = &expr.kind else { return false };
    let now = |part: &Expr| matches!(&part.kind, ExprKind::Indexical(name) if name.is("now"));
    let span = |part: &Expr| match &part.kind {
        ExprKind::Constant(Value::Duration(span)) => Some(*span),
        _ => None,
    };
    let later: Option<Vec<_>> = arguments.iter().filter(|part| !now(part)).map(span).collect();
    function.is("+")
        && arguments.iter().filter(|part| now(part)).count() == 1
        && later.is_some_and(|spans| spans.iter().any(|span| span.0 > 0) && spans.iter().all(|span| span.0 >= 0))
}

/// Names are equal or different, and none is greater than another: `(mode uav > auto)`.
fn order_of_names(constraints: &[Constraint]) -> Option<Impossible> {
    constraints.iter().find_map(|constraint| {
        let Constraint::Compare { relation, right, .. } = constraint else { return None };
        let ExprKind::Constant(Value::Symbol(name)) = &right.kind else { return None };
        // A name that begins like a number, `35knt`, has a warning that says what was meant.
        let is_ordered = !matches!(relation, Relation::Equal | Relation::Different);
        let reason = format!("`{name}` is a name, and no value is greater or less than a name");
        let help = "compare with a number or a constant, `(defconstant NAME VALUE)`, or write `=`";
        let is_name = !name.printed().starts_with(|first: char| first.is_ascii_digit());
        (is_ordered && is_name).then_some(Impossible { place: right.place, reason, help })
    })
}

fn duration(timing: &Timing, place: Place, library: &Library) -> Option<Impossible> {
    let zero = Expr { kind: ExprKind::Constant(Value::measured(0.0, Dimension::TIME)), place };
    let positive = Constraint::Compare { relation: Relation::GreaterOrEqual, right: zero, tolerance: None };
    let all = [timing.duration.as_slice(), &[positive]].concat();
    let reason = contradiction(&all, library).filter(|_| !timing.duration.is_empty())?;
    let place = last_limit(&timing.duration).unwrap_or(place);
    if contradiction(&timing.duration, library).is_none() {
        let help = "write a limit above zero, such as `(< 5s)`";
        return Some(Impossible { place, reason: "a duration is never negative".to_string(), help });
    }
    Some(Impossible { place, reason: format!("the duration {reason}"), help: LIMITS })
}

/// Statistics that are never below zero, and the count, which is never below one because no verdict is given without samples.
fn statistic(groups: &[(Symbol, Vec<Constraint>)], place: Place, library: &Library) -> Option<Impossible> {
    groups.iter().find_map(|(name, constraints)| {
        let least = match name.folded() {
            "count" => Some(1.0),
            "stddev" | "variance" | "difference" | "time-weighted-stddev" | "time-weighted-variance" => Some(0.0),
            _ => None,
        };
        never(name, constraints, least, place, library)
    })
}

/// Limits on a trend: a frequency and a level of significance are positive, and a level of one requires nothing.
fn trend(groups: &[(Symbol, Vec<Constraint>)], place: Place, library: &Library) -> Option<Impossible> {
    groups.iter().find_map(|(name, constraints)| match (name.folded(), constraints.as_slice()) {
        ("significance", [Constraint::Compare { right, .. }]) => {
            let level = number(right, library).filter(|level| !(*level > 0.0 && *level < 1.0))?;
            let reason = format!("a significance of {level} is not a probability between 0 and 1");
            Some(Impossible { place: right.place, reason, help: LIMITS })
        }
        ("frequency", _) => never(name, constraints, Some(0.0), place, library),
        _ => never(name, constraints, None, place, library),
    })
}

fn never(
    name: &Symbol,
    constraints: &[Constraint],
    least: Option<f64>,
    place: Place,
    library: &Library,
) -> Option<Impossible> {
    let mut all = constraints.to_vec();
    all.extend(least.map(|least| {
        let right = Expr { kind: ExprKind::Constant(Value::Real(least)), place };
        Constraint::Compare { relation: Relation::GreaterOrEqual, right, tolerance: None }
    }));
    let reason = match (contradiction(constraints, library), contradiction(&all, library), least) {
        (None, Some(_), Some(1.0)) => "is never below 1: without a sample the condition is unknown".to_string(),
        (None, Some(_), _) => "is never negative".to_string(),
        (found, ..) => found?,
    };
    let help =
        if contradiction(constraints, library).is_some() { LIMITS } else { "write a limit that a value can meet" };
    let place = last_limit(constraints).unwrap_or(place);
    Some(Impossible { place, reason: format!("the {} {reason}", name.folded()), help })
}

/// Returns the number that an expression always is, in SI units.
pub(super) fn number(expr: &Expr, library: &Library) -> Option<f64> {
    match &expr.kind {
        ExprKind::Constant(value) => value.as_number().map(|(number, _)| number),
        // An indexical defined as a literal is resolved, one step only, so that circular definitions are harmless.
        ExprKind::Indexical(name) => match &library.indexicals.get(name)?.kind {
            ExprKind::Constant(value) => value.as_number().map(|(number, _)| number),
            _ => None,
        },
        _ => None,
    }
}

/// Range that the constant limits permit.
struct Range {
    low: f64,
    low_included: bool,
    high: f64,
    high_included: bool,
}

impl Range {
    fn at_least(&mut self, limit: f64, included: bool) {
        if limit > self.low {
            (self.low, self.low_included) = (limit, included);
        } else if limit == self.low {
            self.low_included &= included;
        }
    }

    fn at_most(&mut self, limit: f64, included: bool) {
        if limit < self.high {
            (self.high, self.high_included) = (limit, included);
        } else if limit == self.high {
            self.high_included &= included;
        }
    }

    fn is_empty(&self) -> bool {
        self.low > self.high || self.low == self.high && !(self.low_included && self.high_included)
    }
}

/// Returns the reason for which no number meets all constraints.
pub(super) fn contradiction(constraints: &[Constraint], library: &Library) -> Option<String> {
    let mut range = Range { low: f64::NEG_INFINITY, low_included: true, high: f64::INFINITY, high_included: true };
    for constraint in constraints {
        match constraint {
            Constraint::Compare { relation, right, tolerance } => {
                let Some(limit) = number(right, library) else { continue };
                match relation {
                    Relation::Less => range.at_most(limit, false),
                    Relation::LessOrEqual => range.at_most(limit, true),
                    Relation::Greater => range.at_least(limit, false),
                    Relation::GreaterOrEqual => range.at_least(limit, true),
                    Relation::Equal => {
                        let width = tolerance.as_ref().map_or(Some(0.0), |tolerance| number(tolerance, library));
                        if let Some(width) = width {
                            range.at_least(limit - width, true);
                            range.at_most(limit + width, true);
                        }
                    }
                    Relation::Different => {}
                }
            }
            Constraint::Range(low, high) => {
                if let Some(low) = low.as_ref().and_then(|low| number(low, library)) {
                    range.at_least(low, true);
                }
                if let Some(high) = high.as_ref().and_then(|high| number(high, library)) {
                    range.at_most(high, true);
                }
            }
            Constraint::Matches(_) | Constraint::Predicate(..) => {}
        }
    }
    range.is_empty().then(|| "cannot be on both sides of these limits".to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn compare((relation, limit): (Relation, i8)) -> Constraint {
        let right = Expr { kind: ExprKind::Constant(Value::Integer(i64::from(limit))), place: Place::default() };
        Constraint::Compare { relation, right, tolerance: None }
    }

    fn meets(value: f64, (relation, limit): (Relation, i8)) -> bool {
        let limit = f64::from(limit);
        match relation {
            Relation::Less => value < limit,
            Relation::LessOrEqual => value <= limit,
            Relation::Greater => value > limit,
            Relation::GreaterOrEqual => value >= limit,
            Relation::Equal => value == limit,
            Relation::Different => value != limit,
        }
    }

    proptest! {
        #[test]
        fn limits_exclude_each_other_when_no_number_meets_them(
            limits in prop::collection::vec((prop::sample::select(vec![
                Relation::Less, Relation::LessOrEqual, Relation::Greater, Relation::GreaterOrEqual, Relation::Equal,
            ]), -3i8..4), 0..5),
        ) {
            let constraints: Vec<Constraint> = limits.iter().copied().map(compare).collect();
            let found = contradiction(&constraints, &Library::default()).is_some();
            // Between whole limits, halves are all that need be tried.
            let possible = (-10..=10).any(|half| limits.iter().all(|limit| meets(f64::from(half) / 2.0, *limit)));
            prop_assert_eq!(found, !possible);
        }
    }
}
