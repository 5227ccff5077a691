//! Procedures that compete for the same goals: an error if nothing distinguishes them, a warning if specificity does not.

use super::{Lowering, Served};
use crate::codes;
use crate::diagnostic::{Diagnostic, Severity, Span};
use crate::lookup::Lookup;
use crate::matching::{covers, specificity};
use crate::print::pattern_text;
use apex_model::pattern::Pattern;
use apex_model::symbol::Symbol;
use apex_model::value::Value;
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// Maximum number of indexes with one first symbol that are compared pairwise; with more, only equal shapes are found.
const COMPARED_MAX: usize = 100;

impl Lowering {
    /// Reports procedures and primitives of one bundle that nothing, or only their order, distinguishes.
    pub(crate) fn report_same_indexes(&mut self) {
        let served = std::mem::take(&mut self.served);
        let mut taken: Lookup<(Option<Symbol>, String), Span> = Lookup::default();
        let mut distinct: BTreeMap<String, Vec<&Served>> = BTreeMap::new();
        for each in served.iter().filter(|each| !each.by_solver) {
            self.report_built_in(each);
            let key = (each.bundle.clone(), shape(&each.pattern));
            if let Some(first) = taken.get(&key).copied() {
                let text = pattern_text(&each.pattern);
                let message = format!("`{text}` is served twice in one bundle");
                let diagnostic = Diagnostic::error(codes::DUPLICATE_INDEX, each.span, message)
                    .label(first, "the same goals are served here")
                    .reason("the executive could not decide which of the two to choose")
                    .help("remove one, make its index more specific, or put it into another bundle");
                self.report(diagnostic);
                continue;
            }
            taken.insert(key, each.span);
            distinct.entry(first_symbol(&each.pattern)).or_default().push(each);
        }
        for group in distinct.values() {
            self.report_ties(group.get(..COMPARED_MAX).unwrap_or(group));
        }
        self.served = served;
    }

    /// Reports an index for goals that a built-in activity serves: it would never be chosen.
    fn report_built_in(&mut self, each: &Served) {
        let Some(word) = built_in_that_serves(&each.pattern) else { return };
        let text = pattern_text(&each.pattern);
        let message = format!("`{text}` is never chosen: the built-in activity `{word}` serves all goals of this form");
        let diagnostic = Diagnostic::error(codes::DUPLICATE_INDEX, each.span, message)
            .reason("built-in activities come before procedures, primitives and solvers, however specific an index is")
            .help(format!("begin the index, and the goals that it serves, with another word than `{word}`"));
        self.report(diagnostic);
    }

    fn report_ties(&mut self, group: &[&Served]) {
        let known: Vec<_> = group.iter().map(|each| (specificity(&each.pattern), shape(&each.pattern))).collect();
        for (number, (one, (specific, shape))) in group.iter().zip(&known).enumerate() {
            for (other, (other_specific, other_shape)) in group.iter().zip(&known).take(number) {
                if specific != other_specific || !overlap(&one.pattern, &other.pattern) {
                    continue;
                }
                // A separate message reports that the later one is never chosen.
                if covers(&other.pattern, &one.pattern) || other_shape == shape {
                    continue;
                }
                let (text, earlier) = (pattern_text(&one.pattern), pattern_text(&other.pattern));
                let message = format!("`{text}` and `{earlier}` are equally specific and serve some goals in common");
                let diagnostic = Diagnostic::new(Severity::Warning, codes::AMBIGUOUS_CHOICE, one.span, message)
                    .label(other.span, "this one is chosen, because it comes first")
                    .help("make one of them more specific");
                self.report(diagnostic);
            }
        }
    }
}

/// Returns the built-in activity that serves all goals that the pattern matches.
fn built_in_that_serves(pattern: &Pattern) -> Option<&'static str> {
    const ALWAYS: [&str; 6] = ["terminate", "cogevent", "inform", "print", "hold-resource", "release-resource"];
    const OF_TASKS: [&str; 5] = ["reset", "suspend", "resume", "reprioritize", "plan"];
    let parts: Vec<Pattern> = match pattern {
        Pattern::Literal(Value::List(items)) => items.iter().cloned().map(Pattern::Literal).collect(),
        Pattern::List(parts) => parts.clone(),
        _ => return None,
    };
    let is = |part: &Pattern, word: &str| match part {
        Pattern::Literal(Value::Symbol(name)) => name.is(word),
        _ => false,
    };
    let (head, rest) = parts.split_first()?;
    if let Some(word) = ALWAYS.into_iter().find(|word| is(head, word)) {
        return Some(word);
    }
    match rest {
        [] | [_] if is(head, "end-application") => Some("end-application"),
        [second, ..] if is(head, "ask") && is(second, "operator") => Some("ask operator"),
        [Pattern::List(_) | Pattern::Literal(Value::List(_)), ..] if is(head, "plan") => Some("plan"),
        // With a variable these goals are activities on a task or a plan, whatever value the variable has.
        [Pattern::Variable(_) | Pattern::Anonymous | Pattern::Is { .. }] => {
            OF_TASKS.into_iter().find(|word| is(head, word))
        }
        _ => None,
    }
}

/// Returns the pattern with its variables numbered: equal for patterns that match the same values.
pub(crate) fn shape(pattern: &Pattern) -> String {
    let mut names: BTreeMap<Symbol, usize> = BTreeMap::new();
    let mut text = String::new();
    write_shape(pattern, &mut names, &mut text);
    if text.bytes().all(|byte| byte.is_ascii() && !byte.is_ascii_uppercase()) { text } else { text.to_lowercase() }
}

fn write_shape(pattern: &Pattern, names: &mut BTreeMap<Symbol, usize>, text: &mut String) {
    let mut number = |name: &Symbol| {
        let next = names.len();
        *names.entry(name.clone()).or_insert(next)
    };
    match pattern {
        Pattern::Variable(name) => drop(write!(text, "?{}", number(name))),
        Pattern::Is { variable, predicate } => {
            let variable = number(variable);
            text.push_str(&format!("(?is ?{variable} {predicate})"));
        }
        Pattern::Segment { variable, minimum, maximum } => {
            let variable = variable.as_ref().map(number);
            text.push_str(&format!("(?{minimum}-{maximum:?} {variable:?})"));
        }
        Pattern::List(parts) | Pattern::And(parts) | Pattern::Or(parts) => {
            text.push_str(match pattern {
                Pattern::And(_) => "(?and",
                Pattern::Or(_) => "(?or",
                _ => "(",
            });
            for part in parts {
                text.push(' ');
                write_shape(part, names, text);
            }
            text.push(')');
        }
        Pattern::Not(part) => {
            text.push_str("(?not ");
            write_shape(part, names, text);
            text.push(')');
        }
        Pattern::Literal(Value::Symbol(name)) if name.folded().starts_with(|first: char| first.is_alphanumeric()) => {
            text.push_str(name.folded());
        }
        other => text.push_str(&pattern_text(other)),
    }
}

fn first_symbol(pattern: &Pattern) -> String {
    let first = match pattern {
        Pattern::Literal(Value::List(items)) => items.first().cloned(),
        Pattern::List(parts) => match parts.first() {
            Some(Pattern::Literal(value)) => Some(value.clone()),
            _ => None,
        },
        _ => None,
    };
    first.map_or(String::new(), |value| value.to_string().to_lowercase())
}

/// Returns true when some value provably matches both patterns; guards and segments are not looked into.
fn overlap(a: &Pattern, b: &Pattern) -> bool {
    match (a, b) {
        (Pattern::Literal(a), Pattern::Literal(b)) => a.matches(b),
        (Pattern::Variable(_) | Pattern::Anonymous, other) | (other, Pattern::Variable(_) | Pattern::Anonymous) => {
            matches!(other, Pattern::Variable(_) | Pattern::Anonymous | Pattern::Literal(_) | Pattern::List(_))
        }
        (Pattern::List(a), Pattern::List(b)) => a.len() == b.len() && a.iter().zip(b).all(|(a, b)| overlap(a, b)),
        (Pattern::List(parts), Pattern::Literal(Value::List(items)))
        | (Pattern::Literal(Value::List(items)), Pattern::List(parts)) => {
            parts.len() == items.len()
                && parts.iter().zip(items.iter()).all(|(part, item)| overlap(part, &Pattern::Literal(item.clone())))
        }
        _ => false,
    }
}
