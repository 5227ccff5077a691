//! Clauses outside of their step, and steps inside of another step: the parentheses balance, but one is misplaced.

use super::Lowering;
use crate::codes;
use crate::diagnostic::{Diagnostic, Span};
use crate::fix::Fix;
use crate::read::Datum;

/// Clauses that a procedure does not have.
const OF_STEPS_ONLY: &[&str] = &["waitfor", "forall", "priority", "rank", "repeating", "responding", "on-failure"];

impl Lowering {
    /// Reports misplaced clauses and steps of a procedure; true if there are any.
    pub(crate) fn report_misplaced(&mut self, procedure: &Datum) -> bool {
        let mut found = false;
        let mut items = procedure.tail();
        while let Some((item, rest)) = items.split_first() {
            items = rest;
            if item.head_name() != "step" {
                continue;
            }
            found |= self.report_nested_step(item);
            let count = left_the_step(item, rest);
            let (outside, after) = rest.split_at_checked(count).unwrap_or((&[], rest));
            if let (Some(first), Some(last)) = (outside.first(), outside.last()) {
                found = true;
                items = after;
                let message = format!("`{}` is outside of its step", first.head_name());
                let fix = Fix::safe("close the step after it").replace(closer(item), "").insert_after(last.span, ")");
                let diagnostic = Diagnostic::error(codes::UNKNOWN_CLAUSE, first.span, message)
                    .label(item.head_span(), "this step ends before it")
                    .reason("a procedure has no such clause")
                    .fix(fix);
                self.report(diagnostic);
            }
        }
        found
    }

    /// Reports a step inside of another one, whose list was closed too late; true if there is one.
    fn report_nested_step(&mut self, step: &Datum) -> bool {
        let items = step.as_list().unwrap_or_default();
        let Some(at) = items.iter().position(|item| item.head_name() == "step") else { return false };
        let (Some(nested), Some(before)) = (items.get(at), at.checked_sub(1).and_then(|at| items.get(at))) else {
            return false;
        };
        if at < 2 {
            return false;
        }
        let diagnostic = Diagnostic::error(codes::UNKNOWN_CLAUSE, nested.span, "this step is inside another one")
            .label(step.head_span(), "the other step, which ends only after it")
            .reason("the steps of a procedure are siblings")
            .fix(Fix::safe("close the other step before it").insert_after(before.span, ")").replace(closer(step), ""));
        self.report(diagnostic);
        true
    }
}

/// Returns the number of items after a step that belong to it: clauses that only steps have, and items after them with the same
/// indentation.
fn left_the_step(step: &Datum, rest: &[Datum]) -> usize {
    let certain = rest.iter().take_while(|next| OF_STEPS_ONLY.contains(&next.head_name())).count();
    let column = rest.first().map_or(0, |first| first.span.column);
    let indented = |next: &&Datum| {
        next.span.column == column
            && column > step.span.column
            && next.as_list().is_some()
            && next.head_name() != "step"
    };
    if certain == 0 { 0 } else { certain + rest.iter().skip(certain).take_while(indented).count() }
}

/// Returns the `)` of a list.
fn closer(list: &Datum) -> Span {
    Span { start: list.span.end.saturating_sub(1).max(list.span.start), ..list.span }
}
