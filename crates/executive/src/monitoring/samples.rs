//! Samples (M&I)
//! What: holds functions for measurement and episode detection: which samples concern a part, and the search of remembered ones.
//! Runs: when a monitor is created, and when a late sample makes one look back again.
//! Reads: histories, evaluation context.
//! Writes: nothing.
//! Bound: O(log n) per variable plus O(k log k) for the k samples found.
//! PDL: `(ATTR OBJ)`.
//! Paper: section III, histories.

use super::constraints::{RightSide, all};
use super::pattern_matching::match_pattern;
use crate::expression::{EvalContext, EvaluationError, evaluate};
use crate::monitoring::part::PartContext;
use crate::state::bindings::Bindings;
use crate::state::histories::history::{History, Sample};
use crate::state::monitors::monitor::Window;
use apex_model::condition::{Constraint, VariablePattern};
use apex_model::event::StateVariable;
use apex_model::pattern::Pattern;
use apex_model::symbol::Symbol;
use apex_model::time::Time;
use apex_model::value::Value;

/// A sample as passed to a part.
#[derive(Clone, Copy)]
pub(crate) struct SampleView<'a> {
    pub(crate) variable: &'a StateVariable,
    pub(crate) value: &'a Value,
    pub(crate) at: Time,
    pub(crate) sequence: u64,
}

/// Returns the state variable of a pattern whose object is known now.
pub(crate) fn known_variable(pattern: &VariablePattern, context: &dyn EvalContext) -> Option<StateVariable> {
    let object = ground(&pattern.object, context)?;
    Some(StateVariable::new(pattern.attribute.clone(), object))
}

fn ground(pattern: &Pattern, context: &dyn EvalContext) -> Option<Value> {
    match pattern {
        Pattern::Literal(value) => Some(value.clone()),
        Pattern::Variable(name) | Pattern::BoundVariable(name) => context.variable(name),
        Pattern::Computed(expr) => evaluate(expr, context).ok(),
        Pattern::List(parts) => {
            parts.iter().map(|part| ground(part, context)).collect::<Option<Vec<_>>>().map(Value::list)
        }
        Pattern::Anonymous
        | Pattern::Segment { .. }
        | Pattern::Guard(_)
        | Pattern::Is { .. }
        | Pattern::And(_)
        | Pattern::Or(_)
        | Pattern::Not(_) => None,
    }
}

/// Returns true if samples of `variable` may concern a part that watches `attribute`, or only `known`.
pub(crate) fn concerns(known: Option<&StateVariable>, attribute: &Symbol, variable: &StateVariable) -> bool {
    match known {
        Some(known) => known == variable,
        None => variable.attribute == *attribute,
    }
}

/// Relation of a sample to the newest sample of its object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Arrival {
    /// The sample is too early, too late or answered already, and changes nothing.
    Nothing,
    /// The sample is older than the newest one. All samples since the window began are kept, so the part looks back again.
    Late,
    /// The sample is the next one in order of time, and the part processes it.
    Next,
}

/// Returns how `sample` relates to a part with this window and `newest` as the instant of its newest sample of the object.
pub(crate) fn arrival(
    window: Window,
    sample: SampleView<'_>,
    newest: Option<Time>,
    context: &dyn EvalContext,
) -> Arrival {
    let kept = || context.histories().get(sample.variable).is_some_and(|history| history.covers(window.start));
    match newest.is_some_and(|newest| sample.at < newest) {
        true if sample.at >= window.start && kept() => Arrival::Late,
        false if window.contains(sample.at, sample.sequence) => Arrival::Next,
        _ => Arrival::Nothing,
    }
}

/// Returns true if the object of `variable` satisfies pattern and constraints; adds their bindings.
///
/// # Errors
/// If an expression in them cannot be evaluated.
pub(crate) fn object_holds(
    pattern: &VariablePattern,
    constraints: &[Constraint],
    known: bool,
    variable: &StateVariable,
    bindings: &mut Bindings,
    site: PartContext,
    context: &dyn EvalContext,
) -> Result<bool, EvaluationError> {
    if !known && !match_pattern(&pattern.object, &variable.object, bindings, context, site.place)? {
        return Ok(false);
    }
    all(constraints, &variable.object, RightSide::Value(None), bindings, context, site.place)
}

/// Returns a remembered sample, recognised at its own instant; a replacing sample has the place of the replaced one.
pub(crate) fn seen_of<'a>(variable: &'a StateVariable, history: &History, sample: &'a Sample) -> SampleView<'a> {
    SampleView { variable, value: &sample.value, at: sample.at, sequence: history.first_arrival(sample) }
}

/// Returns the samples within the window, in order of time and arrival, of all variables that may concern the part; and true if the
/// window reaches before the oldest kept sample.
pub(crate) fn remembered<'a>(
    known: Option<&'a StateVariable>,
    attribute: &Symbol,
    site: PartContext,
    context: &'a dyn EvalContext,
) -> (Vec<SampleView<'a>>, bool) {
    let mut seen = Vec::new();
    let mut blind = false;
    let mut collect = |variable: &'a StateVariable, history: &'a History| {
        blind |= !history.covers(site.window.start);
        let kept = history.between(site.window.start, Time::END);
        seen.reserve(kept.size_hint().0);
        seen.extend(
            kept.filter(|sample| site.window.contains(sample.at, sample.sequence))
                .map(|sample| seen_of(variable, history, sample)),
        );
    };
    match known {
        Some(variable) => {
            if let Some(history) = context.histories().get(variable) {
                collect(variable, history);
            }
        }
        None => context.histories().of_attribute(attribute).for_each(|(variable, history)| collect(variable, history)),
    }
    // Samples of a single variable are in order already.
    if known.is_none() {
        seen.sort_by_key(|sample| (sample.at, sample.sequence));
    }
    (seen, blind)
}
