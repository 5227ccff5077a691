//! Parts of conditions (M&I)
//! What: whether one part of a condition holds, where that follows from the part alone.
//! Runs: when a condition with `:probing` was judged.
//! Reads: the monitor, evaluation context.
//! Writes: nothing.
//! Bound: linear in the condition.
//! PDL: `:probing`.
//! Paper: section IV, sources of information for monitors.

use crate::expression::EvalContext;
use crate::monitoring::combination::logic;
use crate::monitoring::part::Truth;
use crate::monitoring::verdict_query::VerdictQuery;
use crate::state::monitors::monitor::{Monitor, Part, PartKind};
use apex_model::source::Place;

/// Does the part that is written at `place` hold? A part whose results count only together with those of others, by order,
/// shared variables or constraints, does not hold before the whole does.
pub(crate) fn holds(monitor: &Monitor, place: Place, context: &dyn EvalContext) -> bool {
    let part = find(&monitor.root, place);
    part.is_some_and(|part| logic::truth(part, &mut VerdictQuery::new(context)) == Truth::True)
}

fn find(part: &Part, place: Place) -> Option<&Part> {
    // A `waitfor` of several conditions stands where its first one does.
    let inside = match &part.kind {
        PartKind::And(composite) | PartKind::Or(composite) if !composite.combines => {
            composite.parts.iter().find_map(|part| find(part, place))
        }
        _ => None,
    };
    inside.or_else(|| (part.place == place).then_some(part))
}
