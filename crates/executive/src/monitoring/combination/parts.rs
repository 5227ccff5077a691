//! Parts of conditions (M&I)
//! What: decides whether one part of a condition holds, if that follows from the part alone.
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

/// Returns true if the part written at `place` holds. A part whose results count only together with those of others (order, shared
/// variables, constraints) does not hold before the whole condition does.
pub(crate) fn holds(monitor: &Monitor, place: Place, context: &dyn EvalContext) -> bool {
    let part = find(&monitor.root, place);
    part.is_some_and(|part| logic::truth(part, &mut VerdictQuery::new(context)) == Truth::True)
}

fn find(part: &Part, place: Place) -> Option<&Part> {
    // A `waitfor` of several conditions has the place of its first condition.
    let inside = match &part.kind {
        PartKind::And(composite) | PartKind::Or(composite) if !composite.combines => {
            composite.parts.iter().find_map(|part| find(part, place))
        }
        _ => None,
    };
    inside.or_else(|| (part.place == place).then_some(part))
}
