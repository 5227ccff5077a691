//! Conditions on tasks and state variables that are written nearly right: as they stand, they would be messages that never come.

use super::Lowering;
use super::slips::{OUTCOME_WORDS, RELATION_SIGNS};
use crate::codes;
use crate::diagnostic::{Diagnostic, Span};
use crate::fix::Fix;
use crate::read::{Datum, DatumKind};
use apex_model::task::OUTCOME_STATES;

/// States of tasks while they are not at their end.
const STATES: &[&str] = &["pending", "enabled", "ongoing", "interrupted", "suspended", "terminated", "resumed"];
/// States of the command of a task.
const COMMAND_STATES: &[&str] = &["sent", "accepted", "in-progress", "done", "failed", "timed-out", "withdrawn"];
/// Relations in time between conditions; without a colon they are words.
const TIME_RELATIONS: &[&str] = &[
    "after",
    "before",
    "contains",
    "cotemporal",
    "during",
    "finished-by",
    "finishes",
    "meets",
    "met-by",
    "overlapped-by",
    "overlaps",
    "started-by",
    "starts",
];
/// Words for the start of a task.
const STARTED: &[&str] = &["start", "started", "starts", "begin", "begun", "began", "running", "active"];
/// Verbs before a relation: `(altitude uav is > 100m)`.
const FILLERS: &[&str] = &["is", "are", "was", "gets", "becomes"];
pub(super) const AS_WRITTEN: &str = "as written, this is an event with these words, which never occurs";

impl Lowering {
    /// Reports a condition on a task, a time or a comparison whose form is nearly right; true if it did.
    pub(super) fn report_near_condition(&mut self, datum: &Datum) -> bool {
        let items = datum.as_list().unwrap_or_default();
        self.report_word_for_step(items)
            || self.report_state_without_relation(items)
            || self.report_step_as_head(datum, items)
            || self.report_unknown_command_state(items)
            || self.report_bare_time(datum, items)
            || self.report_marked_relation(items)
            || self.report_worded_relation(items)
            || self.report_slip_of_variable(items)
            || self.report_odd_step(datum, items)
    }

    fn is_tag_word(&self, datum: &Datum) -> bool {
        datum.as_symbol().is_some_and(|tag| self.scope.tags.contains(tag))
    }

    fn is_tag_variable(&self, datum: &Datum) -> bool {
        datum.as_variable().is_some_and(|tag| self.scope.tags.contains(tag))
    }

    fn slip(&mut self, span: Span, message: String, fix: Fix) -> bool {
        self.report(Diagnostic::error(codes::MALFORMED_CONDITION, span, message).reason(AS_WRITTEN).fix(fix));
        true
    }

    /// Reports `(failed a)`, `(state a = failed)` and `(command-state a = done)` for the step `a`; true if it did.
    fn report_word_for_step(&mut self, items: &[Datum]) -> bool {
        let step = match items {
            [head, step] if OUTCOME_WORDS.iter().any(|word| head.is(word)) => step,
            [head, step, relation, state]
                if relation.is("=")
                    && (head.is("state") && is_state(state)
                        || head.is("command-state") && is_one(state, COMMAND_STATES)) =>
            {
                step
            }
            _ => return false,
        };
        let Some(tag) = step.as_symbol().filter(|_| self.is_tag_word(step)) else { return false };
        let fix = Fix::safe(format!("write `?{tag}`")).insert_before(start(step.span), "?");
        self.slip(step.span, format!("`{tag}` is a word here, not the step"), fix)
    }

    /// Reports `(state ?a failed)` and `(command-state ?a done)`; true if it did.
    fn report_state_without_relation(&mut self, items: &[Datum]) -> bool {
        let [head, step, state] = items else { return false };
        let is_condition = head.is("state") && is_state(state)
            || head.is("task-state") && is_state(state)
            || head.is("command-state") && is_one(state, COMMAND_STATES);
        if !is_condition || !(self.is_tag_variable(step) || self.is_tag_word(step)) {
            return false;
        }
        let message =
            format!("`{}` is compared without a relation", head.as_symbol().map_or("state", |name| name.printed()));
        self.slip(state.span, message, Fix::safe("write `=` before it").insert_before(start(state.span), "= "))
    }

    /// Reports `(?a failed)` and `(?a = failed)`; true if it did.
    fn report_step_as_head(&mut self, datum: &Datum, items: &[Datum]) -> bool {
        let (step, state) = match items {
            [step, state] => (step, state),
            [step, relation, state] if relation.is("=") => (step, state),
            _ => return false,
        };
        let Some(tag) = step.as_variable().filter(|_| self.is_tag_variable(step) && is_state(state)) else {
            return false;
        };
        let state = state.as_symbol().map_or("terminated", |name| name.printed());
        let text = format!("(state ?{tag} = {state})");
        let fix = Fix::safe(format!("write `{text}`")).replace(datum.span, text);
        self.slip(datum.span, "a condition does not begin with a step".to_string(), fix)
    }

    /// Reports `(?a)`, `(started ?a)` and `(failed ?a ?b)`; true if it did.
    fn report_odd_step(&mut self, datum: &Datum, items: &[Datum]) -> bool {
        match items {
            [step] if self.is_tag_variable(step) => {
                let tag = step.as_variable().map_or("", |tag| tag.printed());
                let fix = Fix::safe(format!("write `?{tag}`")).replace(datum.span, format!("?{tag}"));
                self.slip(datum.span, "the end of a step is not written in brackets".to_string(), fix)
            }
            [head, step] if is_one(head, STARTED) && self.is_tag_variable(step) => {
                let tag = step.as_variable().map_or("", |tag| tag.printed());
                let text = format!("(state ?{tag} = ongoing)");
                let fix = Fix::safe(format!("write `{text}`")).replace(datum.span, text);
                self.slip(datum.span, "the start of a step is a state of its task".to_string(), fix)
            }
            [head, steps @ ..]
                if is_one(head, OUTCOME_WORDS)
                    && steps.len() > 1
                    && steps.iter().all(|step| self.is_tag_variable(step)) =>
            {
                let word = head.as_symbol().map_or("failed", |word| word.printed());
                let message = format!("`{word}` takes one step");
                let diagnostic = Diagnostic::error(codes::MALFORMED_CONDITION, datum.span, message).reason(AS_WRITTEN);
                self.report(diagnostic.help(format!("write `(:or ({word} ?a) ({word} ?b))`, or `:and`")));
                true
            }
            _ => false,
        }
    }

    /// Reports `(command-state ?a = finished)`; true if it did.
    fn report_unknown_command_state(&mut self, items: &[Datum]) -> bool {
        let [head, step, relation, state] = items else { return false };
        let is_compared = relation.is("=") || relation.is("/=");
        if !head.is("command-state") || !is_compared || !self.is_tag_variable(step) || is_one(state, COMMAND_STATES) {
            return false;
        }
        let Some(name) = state.as_symbol() else { return false };
        let message = format!("a command is never in state `{name}`");
        let fixes = crate::suggest::renames(state.span, name.printed(), COMMAND_STATES.iter().copied());
        let diagnostic = Diagnostic::error(codes::MALFORMED_CONDITION, state.span, message);
        self.report(diagnostic.fixes_or_help(fixes, || format!("its states are {}", COMMAND_STATES.join(" "))));
        true
    }

    /// Reports `(delay 5s)`, `(absent (x) :for 5s)`, `(before (x) (y))`, `(timestamp +now+)`: the colon is missing. Returns true if it did.
    fn report_bare_time(&mut self, datum: &Datum, items: &[Datum]) -> bool {
        let Some((head, rest)) = items.split_first() else { return false };
        let Some(name) = head.as_symbol().map(|name| name.folded()) else { return false };
        let is_meant = match (name, rest) {
            ("delay", [least, most @ ..]) => most.len() <= 1 && rest.iter().all(is_span) && is_span(least),
            ("absent", [condition, mark, _]) => condition.as_list().is_some() && mark.is(":for"),
            ("timestamp", [_] | [_, _]) => rest.iter().any(|item| matches!(item.kind, DatumKind::Indexical(_))),
            ("function", [form]) => form.as_list().is_some(),
            (_, [_, _, ..]) if TIME_RELATIONS.contains(&name) => {
                rest.iter().all(|item| item.as_list().is_some() || self.is_tag_variable(item))
            }
            _ => false,
        };
        if !is_meant {
            return false;
        }
        let message = format!("condition `{name}` lacks its colon");
        let diagnostic = Diagnostic::error(codes::UNKNOWN_CONDITION, datum.head_span(), message);
        self.report(diagnostic.fix(super::slips::colon(name, datum.head_span())));
        true
    }

    /// Reports `(roll uav ">" 15)`, `(roll uav :> 15)` and `(roll uav is > 15)`; true if it did.
    fn report_marked_relation(&mut self, items: &[Datum]) -> bool {
        for pair in items.get(2..).unwrap_or_default().windows(2) {
            let [item, next] = pair else { continue };
            let written = match &item.kind {
                DatumKind::Text(text) => Some(text.to_string()),
                _ => item.keyword().map(str::to_string),
            };
            let sign = written.and_then(|written| RELATION_SIGNS.iter().find(|(sign, _)| *sign == written));
            if let Some((_, own)) = sign {
                let fix = Fix::safe(format!("write `{own}`")).replace(item.span, *own);
                return self.slip(item.span, format!("the relation `{own}` is a word without marks"), fix);
            }
            if FILLERS.iter().any(|filler| item.is(filler))
                && let Some(relation) = super::constraint::relation_named(next).and(next.as_symbol())
            {
                let filler = Span { end: next.span.start, ..item.span };
                let fix = Fix::safe("remove the word before it").replace(filler, "");
                return self.slip(item.span, format!("a word is between the object and `{relation}`"), fix);
            }
        }
        false
    }
}

fn is_one(datum: &Datum, words: &[&str]) -> bool {
    words.iter().any(|word| datum.is(word))
}

fn is_state(datum: &Datum) -> bool {
    is_one(datum, STATES) || is_one(datum, OUTCOME_STATES)
}

fn is_span(datum: &Datum) -> bool {
    matches!(datum.kind, DatumKind::Duration(_))
}

fn start(span: Span) -> Span {
    Span { end: span.start, ..span }
}
