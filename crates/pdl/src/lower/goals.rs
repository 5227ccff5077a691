//! Who serves which goal: every goal of a step must have a procedure, primitive or solver that may match it.

use super::Lowering;
use crate::codes;
use crate::diagnostic::{Diagnostic, Span};
use crate::fix::Fix;
use crate::matching::{View, may_match, pattern_head};
use crate::print::{pattern_text, template_text};
use crate::read::Datum;
use crate::suggest::{nearest, renames};
use apex_model::expression::Template;
use apex_model::limits::MATCH_STEPS_MAX;
use apex_model::pattern::Pattern;
use apex_model::symbol::Symbol;
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
                Some(Near::Shape(other)) => diagnostic.help(format!(
                    "`{}` is defined at {}, but has another shape",
                    pattern_text(&other.pattern),
                    describe(other.span)
                )),
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

/// Served classes by the symbol that their goals begin with.
struct GoalIndex<'s> {
    by_head: BTreeMap<&'s Symbol, Vec<&'s Served>>,
    open: Vec<&'s Served>,
}

enum Near<'s> {
    Shape(&'s Served),
    /// Goals that begin with another word are served; this is the word that begins this one.
    Name(&'s str),
}

impl<'s> GoalIndex<'s> {
    fn new(served: &'s [Served]) -> GoalIndex<'s> {
        let mut index = GoalIndex { by_head: BTreeMap::new(), open: Vec::new() };
        for each in served {
            match pattern_head(&each.pattern) {
                Some(head) => index.by_head.entry(head).or_default().push(each),
                None => index.open.push(each),
            }
        }
        index
    }

    /// May anything serve this goal?
    fn serves(&self, goal: &Template) -> bool {
        let view = View::Template(goal);
        let Some(head) = view.head() else { return true };
        let candidates = self.by_head.get(head).into_iter().flatten().chain(&self.open);
        candidates.into_iter().any(|served| may_match(view, &served.pattern, &mut { MATCH_STEPS_MAX }))
    }

    fn nearest<'g: 's>(&self, goal: &'g Template) -> Option<Near<'s>> {
        let head = View::Template(goal).head()?;
        if let Some(same) = self.by_head.get(head).and_then(|list| list.first()) {
            return Some(Near::Shape(same));
        }
        let name = head.printed();
        nearest(name, self.by_head.keys().map(|head| head.printed())).map(|_| Near::Name(name))
    }
}
