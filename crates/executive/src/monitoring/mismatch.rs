//! Mismatches (M&I)
//! What: finds the first position at which a form does not match a pattern.
//! Runs: when a condition or a method is explained.
//! Reads: evaluation context.
//! Writes: nothing.
//! Bound: O(size of the pattern).
//! PDL: patterns, section 2.
//! Paper: section V, explanation of behaviour.

use crate::expression::EvalContext;
use crate::state::bindings::Bindings;
use apex_forms::print::Style::Brief;
use apex_model::pattern::Pattern;
use apex_model::value::Value;

/// Returns the first place where `value` does not fit `pattern`, as words after the name of the value: `has 3 parts instead of 2`.
/// `None` if the mismatch has no single place.
pub(crate) fn first_mismatch(pattern: &Pattern, value: &Value, context: &dyn EvalContext) -> Option<String> {
    find(pattern, value, context, &mut Bindings::new())
}

fn find(pattern: &Pattern, value: &Value, context: &dyn EvalContext, bound: &mut Bindings) -> Option<String> {
    let instead = |wanted: String| Some(format!("has {value} instead of {wanted}"));
    match pattern {
        Pattern::Literal(literal) if literal.matches(value) => None,
        Pattern::Literal(literal) => match (literal.as_list(), value.as_list()) {
            (Some(wanted), Some(items)) => of_literals(wanted, items),
            _ => instead(literal.to_string()),
        },
        Pattern::Variable(name) | Pattern::BoundVariable(name) => {
            let known = bound.get(name).cloned().or_else(|| context.variable(name));
            match known {
                Some(known) if known.matches(value) => None,
                Some(known) => instead(format!("?{name} = {known}")),
                None => {
                    bound.set(name.clone(), value.clone());
                    None
                }
            }
        }
        Pattern::List(parts) => of_list(pattern, parts, value, context, bound),
        Pattern::And(parts) => parts.iter().find_map(|part| find(part, value, context, bound)),
        Pattern::Anonymous => None,
        Pattern::Computed(_)
        | Pattern::Segment { .. }
        | Pattern::Guard(_)
        | Pattern::Is { .. }
        | Pattern::Or(_)
        | Pattern::Not(_) => None,
    }
}

fn of_literals(wanted: &[Value], items: &[Value]) -> Option<String> {
    let differs = wanted.iter().zip(items).find(|(wanted, item)| !wanted.matches(item));
    match differs {
        Some((wanted, item)) => match (wanted.as_list(), item.as_list()) {
            (Some(wanted), Some(items)) => of_literals(wanted, items),
            _ => Some(format!("has {item} instead of {wanted}")),
        },
        None => Some(format!("has {} parts instead of {}", items.len(), wanted.len())),
    }
}

fn of_list(
    pattern: &Pattern,
    parts: &[Pattern],
    value: &Value,
    context: &dyn EvalContext,
    bound: &mut Bindings,
) -> Option<String> {
    let Some(items) = value.as_list() else {
        return Some(format!("is {value} instead of {}", Brief.pattern(pattern)));
    };
    for (part, item) in parts.iter().zip(items) {
        if let Pattern::Segment { .. } = part {
            return None;
        }
        if let Some(text) = find(part, item, context, bound) {
            return Some(text);
        }
    }
    let open = parts.iter().any(|part| matches!(part, Pattern::Segment { .. } | Pattern::Guard(_)));
    let differ = !open && parts.len() != items.len();
    differ.then(|| format!("has {} parts instead of {}", items.len(), parts.len()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_support::TestView;
    use apex_model::symbol::Symbol;

    fn word(name: &str) -> Pattern {
        Pattern::Literal(Value::symbol(name))
    }

    fn form(words: &[&str]) -> Value {
        Value::list(words.iter().map(|word| Value::symbol(word)))
    }

    #[test]
    fn the_first_part_that_differs_is_named() {
        let pattern = Pattern::List(vec![word("ready"), word("camera-1")]);
        let told = |value: &Value| first_mismatch(&pattern, value, &TestView::default()).unwrap_or_default();
        assert_eq!(told(&form(&["ready", "camera-2"])), "has camera-2 instead of camera-1");
        assert_eq!(told(&form(&["ready", "camera-1", "now"])), "has 3 parts instead of 2");
        assert_eq!(told(&Value::Integer(3)), "is 3 instead of (ready camera-1)");
        assert_eq!(told(&form(&["ready", "camera-1"])), "");
    }

    #[test]
    fn a_repeated_variable_wants_the_same_again() {
        let variable = || Pattern::Variable(Symbol::new("x"));
        let pattern = Pattern::List(vec![variable(), variable()]);
        let told = first_mismatch(&pattern, &form(&["a", "b"]), &TestView::default());
        assert_eq!(told.as_deref(), Some("has b instead of ?x = a"));
    }
}
