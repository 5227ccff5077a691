//! Static comparison of patterns and goals: whether a goal may or must match, whether one pattern covers another one, and which of two is
//! more specific.

use apex_model::expression::Template;
use apex_model::pattern::Pattern;
use apex_model::symbol::Symbol;
use apex_model::value::Value;
use std::cmp::Reverse;
use std::collections::BTreeSet;

/// Returns the symbol with which every value that matches `pattern` begins, if there is one.
pub(crate) fn pattern_head(pattern: &Pattern) -> Option<&Symbol> {
    match pattern {
        Pattern::Literal(Value::List(items)) => items.first().and_then(Value::as_symbol),
        Pattern::List(items) => match items.first() {
            Some(Pattern::Literal(Value::Symbol(symbol))) => Some(symbol),
            _ => None,
        },
        _ => None,
    }
}

/// The second word of an index or goal, if it is a symbol or a number.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Second {
    /// A symbol; upper and lower case are equal.
    Symbol(Symbol),
    /// A number, as the bits of its value.
    Number(u64),
}

fn second_of_value(value: &Value) -> Option<Second> {
    match value {
        Value::Symbol(symbol) => Some(Second::Symbol(symbol.clone())),
        Value::Integer(_) | Value::Real(_) => {
            let (number, _) = value.as_number()?;
            // Positive and negative zero are the same value.
            Some(Second::Number((number + 0.0).to_bits()))
        }
        _ => None,
    }
}

/// Returns the second word that every value matching `index` has, if there is one.
pub(crate) fn second_of_pattern(index: &Pattern) -> Option<Second> {
    match index {
        Pattern::Literal(Value::List(items)) => items.get(1).and_then(second_of_value),
        Pattern::List(parts) => match parts.get(1) {
            Some(Pattern::Literal(value)) => second_of_value(value),
            _ => None,
        },
        _ => None,
    }
}

/// Returns the second word of the goal, if it is constant.
pub(crate) fn second_of_goal(goal: View<'_>) -> Option<Second> {
    goal.item(1)?.value().and_then(second_of_value)
}

/// A part of a goal: still a template, or already a value.
#[derive(Clone, Copy)]
pub(crate) enum View<'t> {
    /// A template, whose holes get their values later.
    Template(&'t Template),
    /// A known value.
    Value(&'t Value),
}

impl<'t> View<'t> {
    /// Returns the value, if it has no holes.
    pub(crate) fn value(self) -> Option<&'t Value> {
        match self {
            View::Template(Template::Constant(value)) | View::Value(value) => Some(value),
            View::Template(_) => None,
        }
    }

    /// Returns the parts of a list; `None` if this is not a list, or when a splice makes its length unknown.
    pub(crate) fn items(self) -> Option<Vec<View<'t>>> {
        match (self, self.value()) {
            (_, Some(Value::List(items))) => Some(items.iter().map(View::Value).collect()),
            (View::Template(Template::List(parts)), _)
                if !parts.iter().any(|part| matches!(part, Template::Splice(_))) =>
            {
                Some(parts.iter().map(View::Template).collect())
            }
            _ => None,
        }
    }

    /// Returns the part with this number of a list; `None` as for `items`.
    pub(crate) fn item(self, number: usize) -> Option<View<'t>> {
        match (self, self.value()) {
            (_, Some(Value::List(items))) => items.get(number).map(View::Value),
            (View::Template(Template::List(parts)), _)
                if !parts.iter().any(|part| matches!(part, Template::Splice(_))) =>
            {
                parts.get(number).map(View::Template)
            }
            _ => None,
        }
    }

    /// Returns the symbol that the goal begins with.
    pub(crate) fn head(self) -> Option<&'t Symbol> {
        match (self, self.value()) {
            (_, Some(Value::List(items))) => items.first().and_then(Value::as_symbol),
            (View::Template(Template::List(parts)), _) => match parts.first() {
                Some(Template::Constant(Value::Symbol(symbol))) => Some(symbol),
                _ => None,
            },
            _ => None,
        }
    }
}

/// Returns false only if the goal provably does not match. Running out of steps counts as a match.
pub(crate) fn may_match(goal: View<'_>, pattern: &Pattern, steps: &mut u64) -> bool {
    *steps = steps.saturating_sub(1);
    if *steps == 0 || matches!(goal, View::Template(Template::Hole(_) | Template::Splice(_))) {
        return true;
    }
    match pattern {
        Pattern::Literal(value) => may_be(goal, value, steps),
        Pattern::List(patterns) => match goal.items() {
            Some(parts) => list_may_match(&parts, patterns, steps),
            None => goal.value().is_none(),
        },
        Pattern::And(patterns) => patterns.iter().all(|pattern| may_match(goal, pattern, steps)),
        Pattern::Or(patterns) => patterns.iter().any(|pattern| may_match(goal, pattern, steps)),
        Pattern::Variable(_)
        | Pattern::BoundVariable(_)
        | Pattern::Anonymous
        | Pattern::Computed(_)
        | Pattern::Segment { .. }
        | Pattern::Guard(_)
        | Pattern::Is { .. }
        | Pattern::Not(_) => true,
    }
}

/// Like `may_match`, for a pattern that is a value.
fn may_be(goal: View<'_>, value: &Value, steps: &mut u64) -> bool {
    let Value::List(items) = value else {
        return goal.value().is_some_and(|found| found.matches(value));
    };
    let Some(parts) = goal.items() else { return goal.value().is_none() };
    let mut may_be_item = |part: View<'_>, item: &Value| {
        *steps = steps.saturating_sub(1);
        *steps == 0
            || matches!(part, View::Template(Template::Hole(_) | Template::Splice(_)))
            || may_be(part, item, steps)
    };
    parts.len() == items.len() && parts.iter().zip(items.iter()).all(|(part, item)| may_be_item(*part, item))
}

fn list_may_match(parts: &[View<'_>], patterns: &[Pattern], steps: &mut u64) -> bool {
    *steps = steps.saturating_sub(1);
    if *steps == 0 {
        return true;
    }
    let Some((pattern, rest)) = patterns.split_first() else { return parts.is_empty() };
    match pattern {
        Pattern::Guard(_) => list_may_match(parts, rest, steps),
        Pattern::Segment { minimum, maximum, .. } => {
            let most = maximum.map_or(parts.len(), usize::from).min(parts.len());
            (usize::from(*minimum)..=most)
                .any(|count| parts.get(count..).is_some_and(|left| list_may_match(left, rest, steps)))
        }
        _ => match parts.split_first() {
            Some((part, left)) => may_match(*part, pattern, steps) && list_may_match(left, rest, steps),
            None => false,
        },
    }
}

/// Returns true only if the goal provably matches, whatever values its holes get.
pub(crate) fn must_match(goal: View<'_>, pattern: &Pattern) -> bool {
    must(goal, pattern) && is_linear(pattern, &mut BTreeSet::new())
}

fn must(goal: View<'_>, pattern: &Pattern) -> bool {
    match pattern {
        Pattern::Variable(_) | Pattern::Anonymous => true,
        Pattern::Literal(value) => goal.value().is_some_and(|found| found.matches(value)),
        Pattern::List(patterns) => goal.items().is_some_and(|parts| list_must(&parts, patterns)),
        Pattern::And(patterns) => patterns.iter().all(|pattern| must(goal, pattern)),
        Pattern::Or(patterns) => patterns.iter().any(|pattern| must(goal, pattern)),
        _ => false,
    }
}

fn list_must(parts: &[View<'_>], patterns: &[Pattern]) -> bool {
    match (patterns.split_first(), parts.split_first()) {
        (None, rest) => rest.is_none(),
        (Some((Pattern::Segment { minimum, maximum: None, .. }, [])), _) => parts.len() >= usize::from(*minimum),
        (Some((Pattern::Segment { .. }, _)), _) | (Some(_), None) => false,
        (Some((pattern, patterns)), Some((part, parts))) => must(*part, pattern) && list_must(parts, patterns),
    }
}

/// Returns true if no variable occurs twice: a second occurrence would have to match an equal value.
fn is_linear<'p>(pattern: &'p Pattern, seen: &mut BTreeSet<&'p Symbol>) -> bool {
    match pattern {
        Pattern::Variable(name)
        | Pattern::Is { variable: name, .. }
        | Pattern::Segment { variable: Some(name), .. } => seen.insert(name),
        Pattern::List(parts) | Pattern::And(parts) | Pattern::Or(parts) => {
            parts.iter().all(|part| is_linear(part, seen))
        }
        _ => true,
    }
}

/// Returns true when `general` provably matches everything that `special` matches.
pub(crate) fn covers(general: &Pattern, special: &Pattern) -> bool {
    let mut seen = BTreeSet::new();
    is_linear(general, &mut seen) && cover(general, special)
}

fn cover(general: &Pattern, special: &Pattern) -> bool {
    match (general, special) {
        (_, Pattern::Segment { .. }) => false,
        (Pattern::Variable(_) | Pattern::Anonymous, _) => true,
        (Pattern::And(parts), _) => parts.iter().all(|part| cover(part, special)),
        (_, Pattern::Or(parts)) => parts.iter().all(|part| cover(general, part)),
        (_, Pattern::And(parts)) => parts.iter().any(|part| cover(general, part)),
        (Pattern::Or(parts), _) => parts.iter().any(|part| cover(part, special)),
        (Pattern::Literal(general), Pattern::Literal(special)) => special.matches(general),
        (Pattern::List(general), Pattern::List(special)) => list_cover(general, &special.iter().collect::<Vec<_>>()),
        (Pattern::List(general), Pattern::Literal(Value::List(items))) => {
            let special: Vec<Pattern> = items.iter().cloned().map(Pattern::Literal).collect();
            list_cover(general, &special.iter().collect::<Vec<_>>())
        }
        _ => false,
    }
}

fn list_cover(general: &[Pattern], special: &[&Pattern]) -> bool {
    match (general.split_first(), special.split_first()) {
        (None, rest) => rest.is_none(),
        (Some((Pattern::Segment { minimum, maximum: None, .. }, [])), _) => {
            let least = |part: &&Pattern| match part {
                Pattern::Segment { minimum, .. } => usize::from(*minimum),
                Pattern::Guard(_) => 0,
                _ => 1,
            };
            special.iter().map(least).sum::<usize>() >= usize::from(*minimum)
        }
        (Some((Pattern::Segment { .. }, _)), _) | (Some(_), None) => false,
        (Some(_), Some((Pattern::Guard(_), special))) => list_cover(general, special),
        (Some((first, general)), Some((part, special))) => cover(first, part) && list_cover(general, special),
    }
}

/// Specificity of a pattern, as selection orders procedures: the greatest is chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Specificity {
    variables: Reverse<usize>,
    constant_prefix: usize,
    segments: Reverse<usize>,
}

/// Returns the specificity: fewer variables are more specific, then a longer constant prefix, then fewer segments.
pub(crate) fn specificity(pattern: &Pattern) -> Specificity {
    let (mut named, mut nameless, mut segments) = (BTreeSet::new(), 0, 0);
    count(pattern, &mut named, &mut nameless, &mut segments);
    let constant_prefix = match pattern {
        Pattern::List(parts) => parts.iter().take_while(|part| matches!(part, Pattern::Literal(_))).count(),
        Pattern::Literal(Value::List(items)) => items.len(),
        Pattern::Literal(_) => 1,
        _ => 0,
    };
    Specificity { variables: Reverse(named.len() + nameless), constant_prefix, segments: Reverse(segments) }
}

fn count<'p>(pattern: &'p Pattern, named: &mut BTreeSet<&'p Symbol>, nameless: &mut usize, segments: &mut usize) {
    match pattern {
        Pattern::Variable(name) | Pattern::Is { variable: name, .. } => {
            named.insert(name);
        }
        Pattern::Anonymous => *nameless += 1,
        Pattern::Segment { variable, .. } => {
            *segments += 1;
            match variable {
                Some(name) => {
                    named.insert(name);
                }
                None => *nameless += 1,
            }
        }
        Pattern::List(parts) | Pattern::And(parts) | Pattern::Or(parts) => {
            parts.iter().for_each(|part| count(part, named, nameless, segments));
        }
        _ => {}
    }
}
