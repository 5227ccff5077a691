//! What the executive cannot do yet: the checker refuses it with a clear message, nothing is ignored silently.
//!
//! Each function answers with the name of the unsupported construct as its author writes it.

use crate::condition::{Condition, ConditionKind};

/// The first construct of `condition` (its parts included) that the executive cannot evaluate.
pub fn unsupported_condition(condition: &Condition) -> Option<&'static str> {
    match &condition.kind {
        ConditionKind::And(parts, _) | ConditionKind::Or(parts, _) | ConditionKind::InOrder(parts, _) => {
            parts.iter().find_map(unsupported_condition)
        }
        ConditionKind::Allen { parts, .. } => parts.iter().find_map(unsupported_condition),
        ConditionKind::Not(part) | ConditionKind::Absent(part, _) | ConditionKind::Probing { condition: part, .. } => {
            unsupported_condition(part)
        }
        ConditionKind::Measurement(_)
        | ConditionKind::Episode(_)
        | ConditionKind::Cyclic { .. }
        | ConditionKind::Delay(..)
        | ConditionKind::Timestamp(..)
        | ConditionKind::Event { .. }
        | ConditionKind::TaskEnded(_)
        | ConditionKind::TaskState { .. }
        | ConditionKind::Function(_) => None,
    }
}
