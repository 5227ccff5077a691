//! Names in conditions (M&I)
//! What: collects the pattern variables of a condition.
//! Runs: when a monitor is made.
//! Reads: the condition.
//! Writes: nothing.
//! Bound: linear in the condition.
//! PDL: all conditions.
//! Paper: Appendix B, variables in patterns.

use crate::monitoring::specificity::variables;
use apex_model::condition::{Condition, ConditionKind, Constraint, Relation, VariablePattern};
use apex_model::expression::ExprKind;
use apex_model::symbol::Symbol;
use std::collections::BTreeSet;

/// Adds the names of the variables that the condition may bind.
pub(crate) fn collect<'a>(condition: &'a Condition, names: &mut BTreeSet<&'a Symbol>) {
    match &condition.kind {
        ConditionKind::Measurement(measurement) => {
            of_variable(&measurement.variable, names);
            for constraints in [&measurement.value, &measurement.object, &measurement.timestamp] {
                of_constraints(constraints, names);
            }
        }
        ConditionKind::Episode(episode) => {
            of_variable(&episode.variable, names);
            for constraints in [&episode.value, &episode.first_value, &episode.last_value, &episode.object] {
                of_constraints(constraints, names);
            }
        }
        ConditionKind::Event { pattern, .. } => names.extend(variables(pattern)),
        ConditionKind::TaskState { state, .. } => names.extend(variables(state)),
        ConditionKind::And(parts, _) | ConditionKind::Or(parts, _) | ConditionKind::InOrder(parts, _) => {
            parts.iter().for_each(|part| collect(part, names));
        }
        ConditionKind::Not(part) | ConditionKind::Absent(part, _) => collect(part, names),
        ConditionKind::Allen { parts, .. } => parts.iter().for_each(|part| collect(part, names)),
        ConditionKind::Probing { condition, .. } => collect(condition, names),
        ConditionKind::Cyclic(cyclic) => of_variable(&cyclic.variable, names),
        ConditionKind::Delay(..)
        | ConditionKind::Timestamp(..)
        | ConditionKind::TaskEnded(_)
        | ConditionKind::Function(_) => {}
    }
}

fn of_variable<'a>(variable: &'a VariablePattern, names: &mut BTreeSet<&'a Symbol>) {
    names.extend(variables(&variable.object));
}

fn of_constraints<'a>(constraints: &'a [Constraint], names: &mut BTreeSet<&'a Symbol>) {
    for constraint in constraints {
        match constraint {
            Constraint::Matches(pattern) => names.extend(variables(pattern)),
            Constraint::Compare { relation: Relation::Equal, right, tolerance: None } => {
                if let ExprKind::Variable { name, must_be_bound: false } = &right.kind {
                    names.insert(name);
                }
            }
            Constraint::Compare { .. } | Constraint::Predicate(..) | Constraint::Range(..) => {}
        }
    }
}
