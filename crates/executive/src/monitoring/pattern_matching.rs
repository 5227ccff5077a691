//! Pattern matching (M&I)
//! What: matches a value against a pattern with variables, segments and guards.
//! Runs: on messages, at procedure selection. Reads: Surroundings. Writes: bindings.
//! Bound: `MATCH_STEPS_MAX` steps. PDL: section 2. Paper: section III, pattern matching.

use crate::expression::{EvaluationError, Surroundings};
use apex_model::bindings::Bindings;
use apex_model::pattern::Pattern;
use apex_model::source::Place;
use apex_model::value::Value;

/// Does `value` match `pattern`? Variables already bound, in `bindings` or in `surroundings`, must match what they
/// are bound to; others are added to `bindings`. Without a match `bindings` is as before.
///
/// # Errors
/// When a computed part, guard or predicate fails, a `<?x>` is unbound, or the match takes too many steps.
pub fn match_pattern(
    pattern: &Pattern,
    value: &Value,
    bindings: &mut Bindings,
    surroundings: &dyn Surroundings,
    place: Place,
) -> Result<bool, EvaluationError> {
    let _ = (pattern, value, bindings, surroundings, place);
    Ok(false)
}

/// How specific a pattern is. Orders from general to specific: the greatest is chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Specificity {
    variables: std::cmp::Reverse<usize>,
    constant_prefix: usize,
}

/// Fewest variables first, then the longest constant prefix.
pub fn specificity(pattern: &Pattern) -> Specificity {
    let _ = pattern;
    Specificity { variables: std::cmp::Reverse(0), constant_prefix: 0 }
}
