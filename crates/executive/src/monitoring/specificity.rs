//! Specificity (M&I)
//! What: decides which of two matching patterns is more specific, and which variables a pattern can bind.
//! Runs: at procedure selection, at monitor creation.
//! Reads: the pattern.
//! Writes: nothing.
//! Bound: linear in the pattern.
//! PDL: section 2, selection among matching procedures.
//! Paper: section III, procedure selection.

use apex_model::pattern::Pattern;
use apex_model::symbol::Symbol;
use apex_model::value::Value;
use std::cmp::Reverse;
use std::collections::BTreeSet;

/// Specificity of a pattern. Orders from general to specific: the greatest is chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Specificity {
    variables: Reverse<usize>,
    constant_prefix: usize,
    segments: Reverse<usize>,
}

/// Returns the specificity of a pattern: fewer variables are more specific, then a longer constant prefix, then fewer segments.
pub(crate) fn specificity(pattern: &Pattern) -> Specificity {
    let mut count = Count::default();
    count.add(pattern);
    Specificity {
        variables: Reverse(count.named.len() + count.nameless),
        constant_prefix: constant_prefix(pattern),
        segments: Reverse(count.segments),
    }
}

/// Returns the reason for which a pattern with specificity `first` precedes one with `other`, as a statement about the other pattern.
pub(crate) fn why_before(first: Specificity, other: Specificity) -> String {
    if first.variables != other.variables {
        return format!(
            "it is less specific: it binds {} variables, the first {}",
            other.variables.0, first.variables.0
        );
    }
    if first.constant_prefix != other.constant_prefix {
        let (own, best) = (other.constant_prefix, first.constant_prefix);
        return format!("it is less specific: it begins with {own} fixed words, the first with {best}");
    }
    if first.segments != other.segments {
        return "it is less specific: it has more segments than the first".into();
    }
    "it is equally specific, and comes later in the library".into()
}

/// Returns the variables that `pattern` can bind, in order of name.
pub(crate) fn variables(pattern: &Pattern) -> BTreeSet<&Symbol> {
    let mut count = Count::default();
    count.add(pattern);
    count.named
}

#[derive(Default)]
struct Count<'a> {
    named: BTreeSet<&'a Symbol>,
    nameless: usize,
    segments: usize,
}

impl<'a> Count<'a> {
    fn add(&mut self, pattern: &'a Pattern) {
        match pattern {
            Pattern::Literal(_) | Pattern::BoundVariable(_) | Pattern::Computed(_) | Pattern::Guard(_) => {}
            Pattern::Variable(name) | Pattern::Is { variable: name, .. } => {
                self.named.insert(name);
            }
            Pattern::Anonymous => self.nameless += 1,
            Pattern::Segment { variable, .. } => {
                self.segments += 1;
                match variable {
                    Some(name) => {
                        self.named.insert(name);
                    }
                    None => self.nameless += 1,
                }
            }
            Pattern::List(parts) | Pattern::And(parts) | Pattern::Or(parts) => {
                parts.iter().for_each(|part| self.add(part));
            }
            Pattern::Not(_) => {}
        }
    }
}

fn constant_prefix(pattern: &Pattern) -> usize {
    match pattern {
        Pattern::List(parts) => parts.iter().take_while(|part| matches!(part, Pattern::Literal(_))).count(),
        Pattern::Literal(Value::List(items)) => items.len(),
        Pattern::Literal(_) => 1,
        _ => 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn variable(name: &str) -> Pattern {
        Pattern::Variable(Symbol::new(name))
    }

    fn literal(name: &str) -> Pattern {
        Pattern::Literal(Value::symbol(name))
    }

    fn segment(name: &str, minimum: u8, maximum: Option<u8>) -> Pattern {
        Pattern::Segment { variable: Some(Symbol::new(name)), minimum, maximum }
    }

    #[test]
    fn the_more_specific_index_is_greater() {
        let goal = |parts: Vec<Pattern>| specificity(&Pattern::List(parts));
        let both = goal(vec![literal("move"), variable("x"), variable("y")]);
        let one = goal(vec![literal("move"), variable("x"), literal("home")]);
        let prefix = goal(vec![literal("move"), literal("home"), variable("x")]);
        let segment = goal(vec![literal("move"), literal("home"), segment("x", 0, None)]);
        assert!(prefix > one && one > both && prefix > segment);
    }
}
