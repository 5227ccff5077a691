//! State variables that a condition names with their objects.

use crate::condition::{Condition, ConditionKind, VariablePattern};
use crate::event::StateVariable;
use crate::pattern::Pattern;
use crate::value::Value;

impl Condition {
    /// Returns the state variables of all its parts whose objects are literals, in written order, each once.
    pub fn ground_variables(&self) -> Vec<StateVariable> {
        let mut found = Vec::new();
        collect(self, &mut found);
        found
    }
}

fn collect(condition: &Condition, found: &mut Vec<StateVariable>) {
    let mut add = |pattern: &VariablePattern| {
        if let Some(object) = ground(&pattern.object) {
            let variable = StateVariable::new(pattern.attribute.clone(), object);
            if !found.contains(&variable) {
                found.push(variable);
            }
        }
    };
    match &condition.kind {
        ConditionKind::Measurement(measurement) => add(&measurement.variable),
        ConditionKind::Episode(episode) => add(&episode.variable),
        ConditionKind::Cyclic(cyclic) => add(&cyclic.variable),
        ConditionKind::And(parts, _) | ConditionKind::Or(parts, _) | ConditionKind::InOrder(parts, _) => {
            parts.iter().for_each(|part| collect(part, found));
        }
        ConditionKind::Allen { parts, .. } => parts.iter().for_each(|part| collect(part, found)),
        ConditionKind::Not(part) | ConditionKind::Absent(part, _) => collect(part, found),
        ConditionKind::Probing { condition, .. } => collect(condition, found),
        ConditionKind::Delay(..)
        | ConditionKind::Timestamp(..)
        | ConditionKind::Event { .. }
        | ConditionKind::TaskEnded(_)
        | ConditionKind::TaskState { .. }
        | ConditionKind::Function(_) => {}
    }
}

fn ground(pattern: &Pattern) -> Option<Value> {
    match pattern {
        Pattern::Literal(value) => Some(value.clone()),
        Pattern::List(parts) => parts.iter().map(ground).collect::<Option<Vec<_>>>().map(Value::list),
        _ => None,
    }
}
