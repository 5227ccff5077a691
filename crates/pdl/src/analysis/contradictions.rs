//! Parts of a condition that exclude each other: two outcomes of one step, and, where all parts are judged at one instant, limits on one
//! state variable.

use super::impossible::contradiction;
use apex_model::condition::{Condition, ConditionKind, Constraint};
use apex_model::expression::ExprKind;
use apex_model::library::Library;
use apex_model::pattern::Pattern;
use apex_model::procedure::Procedure;
use apex_model::source::Place;
use apex_model::symbol::Symbol;
use apex_model::task::{FAILURE_STATES, OUTCOME_STATES};
use apex_model::value::Value;
use std::collections::BTreeMap;

/// Returns the place of the second of two outcomes of one step that all of `parts` require, and the reason.
pub(super) fn outcomes(parts: &[&Condition], procedure: &Procedure) -> Option<(Place, String)> {
    let mut known: Vec<(&Symbol, &Symbol)> = Vec::new();
    for part in parts {
        let Some((tag, word)) = outcome(part) else { continue };
        let step = procedure.steps.iter().find(|step| step.tag == *tag);
        // Each task of a responding step has an outcome.
        if step.is_none_or(|step| step.responding.is_some()) {
            continue;
        }
        if let Some((_, other)) = known.iter().find(|(of, other)| *of == tag && exclude(other, word)) {
            let reason = format!("`{tag}` has one outcome, and `{other}` excludes `{word}`");
            return Some((part.place, reason));
        }
        known.push((tag, word));
    }
    None
}

fn outcome(condition: &Condition) -> Option<(&Symbol, &Symbol)> {
    let ConditionKind::TaskState { task, state: Pattern::Literal(Value::Symbol(word)) } = &condition.kind else {
        return None;
    };
    match &task.kind {
        ExprKind::Variable { name, .. } if OUTCOME_STATES.contains(&word.folded()) => Some((name, word)),
        _ => None,
    }
}

fn exclude(one: &Symbol, other: &Symbol) -> bool {
    let is_kind =
        |general: &Symbol, special: &Symbol| general.is("failed") && FAILURE_STATES.contains(&special.folded());
    one != other && !is_kind(one, other) && !is_kind(other, one)
}

/// Returns the place of the last of the parts that limit one state variable so that no value meets all limits, and the reason. All parts
/// must hold of the newest sample.
pub(super) fn limits(parts: &[&Condition], library: &Library) -> Option<(Place, String)> {
    let mut known: BTreeMap<(&Symbol, String), Vec<Constraint>> = BTreeMap::new();
    for part in parts {
        let ConditionKind::Measurement(measurement) = &part.kind else { continue };
        let Pattern::Literal(object) = &measurement.variable.object else { continue };
        let key = (&measurement.variable.attribute, object.to_string());
        let all = known.entry(key).or_default();
        let before = contradiction(all, library).is_some();
        all.extend(measurement.value.iter().cloned());
        let alone = contradiction(&measurement.value, library).is_some();
        if let Some(reason) = contradiction(all, library).filter(|_| !before && !alone) {
            let variable = &measurement.variable.attribute;
            return Some((part.place, format!("`({variable} {object})` has one newest value, which {reason}")));
        }
    }
    None
}

/// Returns the conditions that must all hold: the parts of conjunctions, through all levels.
pub(super) fn conjuncts<'c>(condition: &'c Condition, found: &mut Vec<&'c Condition>) {
    match &condition.kind {
        ConditionKind::And(parts, _) | ConditionKind::InOrder(parts, _) => {
            parts.iter().for_each(|part| conjuncts(part, found));
        }
        _ => found.push(condition),
    }
}
