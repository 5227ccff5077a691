//! Function conditions (M&I)
//! What: detects that an expression without effects is true.
//! Runs: at every instant at which anything happens to the agent: what an expression reads (histories, tasks, time,
//! host functions) cannot be derived from its text in all cases, and a missed change would be worse than an evaluation.
//! Reads: evaluation context.
//! Writes: the function part of a monitor.
//! Bound: one bounded evaluation per instant.
//! PDL: `(:function EXPR)`.
//! Paper: Appendix B, user-defined constraints.

use crate::expression::{EvalContext, evaluate};
use crate::monitoring::part::ConditionFaults;
use crate::state::bindings::Bindings;
use crate::state::monitors::monitor::{FunctionPart, Satisfaction};
use apex_forms::print::Style::Brief;
use apex_model::because::Evidence;
use apex_model::evidence_list::EvidenceList;

/// Evaluates the expression again: only its value at this instant counts.
pub(crate) fn advance(part: &mut FunctionPart, context: &dyn EvalContext, troubles: &mut ConditionFaults) {
    part.holds = None;
    match evaluate(&part.expression, context) {
        Ok(value) => {
            if value.is_true() {
                let (at, what) = (context.now(), Brief.expression(&part.expression));
                let evidence = EvidenceList::one(Evidence::Function { what, value: value.clone(), at });
                let bindings = Bindings::new();
                part.holds = Some(Satisfaction { interval: (at, at), recognised_at: at, bindings, evidence });
            }
            part.value = Some(value.to_string());
        }
        Err(error) => {
            part.value = None;
            troubles.add(error);
        }
    }
}
