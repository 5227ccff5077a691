//! Who serves which goal: every goal of a step must have a procedure, primitive or solver that may match it.

use super::Lowering;
use crate::codes;
use crate::diagnostic::{Diagnostic, Span};
use crate::fix::Fix;
use crate::matching::{Second, View, may_match, pattern_head, second_of_goal, second_of_pattern};
use crate::print::{pattern_text, template_text};
use crate::read::Datum;
use crate::suggest::{nearest, renames};
use apex_model::expression::Template;
use apex_model::limits::MATCH_STEPS_MAX;
use apex_model::pattern::Pattern;
use apex_model::symbol::Symbol;
use apex_model::value::Value;
use std::collections::BTreeMap;

/// A goal that some step, hook or agent pursues.
pub(crate) struct Goal {
    pub(crate) template: Template,
    /// The text of the goal; of something that implies a goal, if it is written nowhere.
    pub(crate) source: Datum,
}

/// A class of goals that something serves.
pub(crate) struct Served {
    pub(crate) pattern: Pattern,
    pub(crate) span: Span,
    /// The bundle of the procedure or primitive; none is the default bundle.
    pub(crate) bundle: Option<Symbol>,
    /// A solver serves it: it is asked only where nothing else does.
    pub(crate) by_solver: bool,
}

impl Lowering {
    /// Lowers a goal and remembers that something must serve it.
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
        self.goals.push(Goal { template: template.clone(), source: datum.clone() });
        Some(template)
    }

    /// Reports goals that nothing serves. `describe` names the place of a span for the reader.
    pub(crate) fn report_unserved_goals(&mut self, describe: &dyn Fn(Span) -> String) {
        let goals = std::mem::take(&mut self.goals);
        let served = std::mem::take(&mut self.served);
        let index = GoalIndex::new(&served);
        let severity = self.undefined();
        let mut reported: Vec<String> = Vec::new();
        for goal in goals.iter().filter(|goal| !index.serves(&goal.template)) {
            let text = template_text(&goal.template);
            if reported.contains(&text) {
                continue;
            }
            let message = format!("no procedure, primitive or solver serves `{text}`");
            let mut diagnostic = Diagnostic::new(severity, codes::UNSERVED_GOAL, goal.source.span, message);
            diagnostic = match index.nearest(&goal.template) {
                Some(Near::Shape(other)) => {
                    let index = pattern_text(&other.pattern);
                    diagnostic = match wrong_word(goal, &other.pattern) {
                        Some((word, right)) => {
                            let title = format!("replace `{}` by `{right}`", word.to_value());
                            diagnostic.fix(Fix::look(title).replace(word.span, right))
                        }
                        None => diagnostic,
                    };
                    diagnostic.help(format!("`{index}` is defined at {}, but has another shape", describe(other.span)))
                }
                Some(Near::Name(head)) => {
                    let heads = index.by_head.keys().map(|head| head.printed());
                    diagnostic.fixes(renames(goal.source.head_span(), head, heads))
                }
                None => diagnostic.help(format!("write a procedure for it: `(procedure (index {text}) ..)`")),
            };
            self.report(diagnostic);
            reported.push(text);
            if reported.len() >= UNSERVED_MAX {
                break;
            }
        }
        self.served = served;
    }
}

/// Unserved goals reported; each costs a search for what was meant.
const UNSERVED_MAX: usize = 100;

/// Indexes that are compared with one unserved goal.
const COMPARED_MAX: usize = 200;

/// How many words must be exchanged, added or left out for the goal to match.
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

/// The one word of the goal that keeps it from matching, and the word that the index has there.
fn wrong_word<'g>(goal: &'g Goal, pattern: &Pattern) -> Option<(&'g Datum, String)> {
    let Pattern::List(patterns) = pattern else { return None };
    let view = View::Template(&goal.template);
    let (parts, words) = (view.items()?, goal.source.as_list()?);
    if parts.len() != patterns.len() || parts.len() != words.len() {
        return None;
    }
    let differs = |(part, pattern): (&View<'_>, &Pattern)| !may_match(*part, pattern, &mut { MATCH_STEPS_MAX });
    let mut wrong = parts.iter().zip(patterns).enumerate().filter(|(_, pair)| differs(*pair));
    let (Some((position, (_, Pattern::Literal(Value::Symbol(right))))), None) = (wrong.next(), wrong.next()) else {
        return None;
    };
    let word = words.get(position).filter(|word| word.as_symbol().is_some())?;
    Some((word, right.printed().to_string()))
}

/// Served classes by the symbol that their goals begin with.
struct GoalIndex<'s> {
    by_head: BTreeMap<&'s Symbol, Vec<&'s Served>>,
    /// The same by the first two words, where an index says both.
    by_two: BTreeMap<(&'s Symbol, Second), Vec<&'s Served>>,
    /// Those that say the first only.
    by_one: BTreeMap<&'s Symbol, Vec<&'s Served>>,
    open: Vec<&'s Served>,
}

enum Near<'s> {
    Shape(&'s Served),
    /// Goals that begin with another word are served; this is the word that begins this one.
    Name(&'s str),
}

impl<'s> GoalIndex<'s> {
    fn new(served: &'s [Served]) -> GoalIndex<'s> {
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

    /// May anything serve this goal?
    fn serves(&self, goal: &Template) -> bool {
        let view = View::Template(goal);
        let Some(head) = view.head() else { return true };
        let (first, second) = match second_of_goal(view) {
            Some(second) => (self.by_one.get(head), self.by_two.get(&(head, second))),
            None => (self.by_head.get(head), None),
        };
        let mut candidates = first.into_iter().chain(second).flatten().chain(&self.open);
        candidates.any(|served| may_match(view, &served.pattern, &mut { MATCH_STEPS_MAX }))
    }

    fn nearest<'g: 's>(&self, goal: &'g Template) -> Option<Near<'s>> {
        let head = View::Template(goal).head()?;
        let view = View::Template(goal);
        let same = self.by_head.get(head).into_iter().flatten().take(COMPARED_MAX);
        if let Some(same) = same.min_by_key(|served| difference(view, &served.pattern)) {
            return Some(Near::Shape(same));
        }
        let name = head.printed();
        nearest(name, self.by_head.keys().map(|head| head.printed())).map(|_| Near::Name(name))
    }
}
