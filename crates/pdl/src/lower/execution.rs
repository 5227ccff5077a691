//! Lowers `precondition` and `invariant`: conditions that are judged at instants.

use super::Lowering;
use crate::codes;
use crate::diagnostic::Diagnostic;
use crate::read::Datum;
use apex_model::condition::{Condition, ConditionKind, Constraint, Relation};
use apex_model::expression::ExprKind;
use apex_model::pattern::Pattern;
use apex_model::procedure::Transitions;
use apex_model::value::Value;

impl Lowering {
    /// Lowers `(precondition C..)` and `(invariant C..)`: all conditions must hold at an instant.
    pub(crate) fn execution_condition(&mut self, clause: &Datum, transitions: &mut Transitions) -> Option<()> {
        let (name, items) = (clause.head_name(), clause.tail());
        if items.is_empty() {
            let shape = format!("({name} CONDITION..)");
            return self.missing_part(clause.span, &format!("this `{name}` has no condition"), &shape);
        }
        let mut parts = Vec::new();
        for item in items {
            let lowered = self.conditions(std::slice::from_ref(item))?;
            for condition in &lowered {
                self.check_present(name, condition, item)?;
            }
            parts.extend(self.clause_conditions(lowered, clause.span));
        }
        let place = parts.first().map_or(clause.span.place(), |part| part.place);
        let condition = match <[Condition; 1]>::try_from(parts) {
            Ok([one]) => one,
            Err(parts) => Condition { tag: None, kind: ConditionKind::And(parts, Vec::new()), place },
        };
        let slot = if name == "precondition" { &mut transitions.precondition } else { &mut transitions.invariant };
        *slot = Some(Box::new(condition));
        Some(())
    }

    /// Refuses a condition that cannot be judged true or false at a single instant.
    fn check_present(&mut self, clause: &str, condition: &Condition, datum: &Datum) -> Option<()> {
        let (reason, help) = match &condition.kind {
            ConditionKind::Function(_) | ConditionKind::TaskEnded(_) => return Some(()),
            ConditionKind::TaskState { state, .. } => match state {
                Pattern::Literal(Value::Symbol(word)) if word.is("resumed") => {
                    ("`resumed` is a change of state without a duration", "write the state: `ongoing`")
                }
                _ => return Some(()),
            },
            ConditionKind::Measurement(measurement) => {
                let binds = |constraint: &Constraint| match constraint {
                    Constraint::Compare { relation: Relation::Equal, right, tolerance: None } => {
                        matches!(&right.kind, ExprKind::Variable { name, must_be_bound: false } if !self.scope.is_bound_everywhere(name))
                    }
                    Constraint::Matches(Pattern::Variable(name)) => !self.scope.is_bound_everywhere(name),
                    _ => false,
                };
                if !measurement.timestamp.is_empty() || measurement.estimation.is_some() {
                    ("it is judged by the newest sample, however old", "leave out `:timestamp` and `:estimation`")
                } else if measurement.value.iter().chain(&measurement.object).any(binds) {
                    ("it binds no variables", "compare with a value, or with a variable that has one")
                } else {
                    return Some(());
                }
            }
            ConditionKind::And(parts, constraints) | ConditionKind::Or(parts, constraints)
                if constraints.is_empty() =>
            {
                return parts.iter().try_for_each(|part| self.check_present(clause, part, datum));
            }
            ConditionKind::Not(part) => return self.check_present(clause, part, datum),
            _ => (
                "the clause is judged at single instants; a message has no duration, and an episode needs several samples",
                "write a measurement, a state of a step, `(:function ..)`, or these with `:and`, `:or`, `:not`; to end when \
                 something happens write `exit-when` or `end-when`",
            ),
        };
        let message = format!("`{clause}` cannot be judged at an instant");
        self.refuse(Diagnostic::error(codes::MALFORMED_CONDITION, datum.span, message).reason(reason).help(help))
    }
}
