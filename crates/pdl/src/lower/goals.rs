//! Service of goals: every goal of a step must have a procedure, primitive or solver that may match it.

use super::Lowering;
use crate::codes;
use crate::diagnostic::{Diagnostic, Span};
use crate::fix::Fix;
use crate::matching::{Second, View, may_match, pattern_head, second_of_goal, second_of_pattern};
use crate::read::Datum;
use apex_model::expression::Template;
use apex_model::limits::MATCH_STEPS_MAX;
use apex_model::pattern::Pattern;
use apex_model::symbol::Symbol;
use apex_model::value::Value;
use std::collections::BTreeMap;

/// A goal that some step, hook or agent pursues.
pub(crate) struct Goal {
    pub(crate) template: Template,
    /// Place of the goal, or of the form that implies it.
    pub(crate) span: Span,
}

/// A class of goals that a method serves.
pub(crate) struct Served {
    pub(crate) pattern: Pattern,
    pub(crate) span: Span,
    /// The bundle of the procedure or primitive; `None` is the default bundle.
    pub(crate) bundle: Option<Symbol>,
    /// True if a solver serves it: it is used only if no other method does.
    pub(crate) by_solver: bool,
}

impl Lowering {
    /// Lowers a goal and records that a method must serve it.
    pub(crate) fn goal(&mut self, datum: &Datum) -> Option<Template> {
        if datum.as_list().is_none_or(<[Datum]>::is_empty) {
            let mut diagnostic = Diagnostic::error(codes::MALFORMED, datum.span, "an activity is a list");
            if let Some(name) = datum.as_symbol() {
                let fix = Fix::safe(format!("write `({name})`"));
                diagnostic = diagnostic.fix(fix.insert_before(datum.span, "(").insert_after(datum.span, ")"));
            }
            return self.refuse(diagnostic);
        }
        let template = self.template(datum)?;
        self.note_words(datum);
        self.goals.push(Goal { template: template.clone(), span: datum.span });
        Some(template)
    }
}

/// Maximum number of indexes that are compared with one unserved goal.
const COMPARED_MAX: usize = 200;

/// Returns the number of words to exchange, add or leave out for the goal to match.
fn difference(goal: View<'_>, pattern: &Pattern) -> usize {
    let parts = goal.items().unwrap_or_default();
    let literals: Vec<Pattern>;
    let patterns: &[Pattern] = match pattern {
        Pattern::List(patterns) => patterns,
        Pattern::Literal(Value::List(items)) => {
            literals = items.iter().cloned().map(Pattern::Literal).collect();
            &literals
        }
        _ => &[],
    };
    let mut row: Vec<usize> = (0..=patterns.len()).collect();
    for (number, part) in parts.iter().enumerate() {
        let mut next = vec![number + 1];
        for (column, pattern) in patterns.iter().enumerate() {
            let is_same = may_match(*part, pattern, &mut { MATCH_STEPS_MAX });
            let diagonal = row.get(column).copied().unwrap_or(0) + usize::from(!is_same);
            let up = row.get(column + 1).copied().unwrap_or(0) + 1;
            let left = next.last().copied().unwrap_or(0) + 1;
            next.push(diagonal.min(up).min(left));
        }
        row = next;
    }
    row.last().copied().unwrap_or(0)
}

/// Served classes by the symbol that their goals begin with.
pub(super) struct GoalIndex<'s> {
    pub(super) by_head: BTreeMap<&'s Symbol, Vec<&'s Served>>,
    /// Served classes by the first two words, for indexes that state both.
    by_two: BTreeMap<(&'s Symbol, Second), Vec<&'s Served>>,
    /// Served classes that state only the first word.
    by_one: BTreeMap<&'s Symbol, Vec<&'s Served>>,
    open: Vec<&'s Served>,
}

impl<'s> GoalIndex<'s> {
    pub(super) fn new(served: &'s [Served]) -> GoalIndex<'s> {
        let (by_head, by_two, by_one) = (BTreeMap::new(), BTreeMap::new(), BTreeMap::new());
        let mut index = GoalIndex { by_head, by_two, by_one, open: Vec::new() };
        for each in served {
            let Some(head) = pattern_head(&each.pattern) else {
                index.open.push(each);
                continue;
            };
            index.by_head.entry(head).or_default().push(each);
            match second_of_pattern(&each.pattern) {
                Some(second) => index.by_two.entry((head, second)).or_default().push(each),
                None => index.by_one.entry(head).or_default().push(each),
            }
        }
        index
    }

    /// Returns true if a method may serve this goal.
    pub(super) fn serves(&self, goal: &Template) -> bool {
        let view = View::Template(goal);
        let Some(head) = view.head() else { return true };
        let (first, second) = match second_of_goal(view) {
            Some(second) => (self.by_one.get(head), self.by_two.get(&(head, second))),
            None => (self.by_head.get(head), None),
        };
        let mut candidates = first.into_iter().chain(second).flatten().chain(&self.open);
        candidates.any(|served| may_match(view, &served.pattern, &mut { MATCH_STEPS_MAX }))
    }

    /// Returns, of the classes with the goal's first word, the one with the fewest differences.
    pub(super) fn likest(&self, goal: &Template) -> Option<&'s Served> {
        let view = View::Template(goal);
        let same = self.by_head.get(view.head()?).into_iter().flatten().take(COMPARED_MAX);
        same.min_by_key(|served| difference(view, &served.pattern)).copied()
    }
}
