//! Loose pieces: in a fragment, clauses may occur outside of a procedure and conditions outside of a `waitfor`, as in articles and
//! manuals. They are wrapped into procedures here, so that all later stages check them as usual.

use crate::diagnostic::Span;
use crate::read::{Datum, DatumKind};
use crate::vocabulary::{ACTIVITIES, PROCEDURE_CLAUSES};
use apex_model::symbol::Symbol;

/// Returns true if this clause of a procedure may occur alone in a fragment; false if its short spelling is also an activity.
fn is_clause(word: &str) -> bool {
    PROCEDURE_CLAUSES.contains(&word) && !ACTIVITIES.contains(&word)
}

/// Relations that make a list `(ATTRIBUTE OBJECT RELATION VALUE ..)` a measurement.
const RELATIONS: &[&str] = &["=", "<", "<=", ">", ">="];

/// Wraps runs of loose clauses, and each loose condition, into a separate procedure; other forms are unchanged.
pub(crate) fn gather(forms: Vec<Datum>) -> Vec<Datum> {
    let mut gathered = Vec::new();
    let mut run: Vec<Datum> = Vec::new();
    let mut number = 0;
    for form in forms {
        let clause = is_clause(form.head_name());
        let next_index = form.head_name() == "index" && run.iter().any(|each| each.head_name() == "index");
        if !clause || next_index {
            gathered.extend(procedure(std::mem::take(&mut run), &mut number));
        }
        if clause {
            run.push(form);
        } else if is_condition(&form) {
            let step = waiting_step(form);
            gathered.extend(procedure(vec![step], &mut number));
        } else {
            gathered.push(form);
        }
    }
    gathered.extend(procedure(run, &mut number));
    gathered
}

/// Returns true for `(waitfor ..)`, a form headed by a keyword, or a measurement.
fn is_condition(form: &Datum) -> bool {
    let items = form.as_list().unwrap_or_default();
    let headed = items.first().is_some_and(|head| head.keyword().is_some());
    let measured = items.len() >= 4 && items.get(2).is_some_and(|third| RELATIONS.iter().any(|each| third.is(each)));
    headed || measured || form.head_name() == "waitfor"
}

/// Returns a step that does nothing but wait for the condition.
fn waiting_step(condition: Datum) -> Datum {
    let span = condition.span;
    let waitfor = if condition.head_name() == "waitfor" {
        condition
    } else {
        list(span, vec![symbol(span, "waitfor"), condition])
    };
    list(span, vec![symbol(span, "step"), list(span, vec![symbol(span, "terminate")]), waitfor])
}

/// Returns the procedure to which the clauses of `run` may belong; `None` without clauses. Added parts have empty spans before and after
/// them, because the front end takes equal spans for the same clause.
fn procedure(run: Vec<Datum>, number: &mut i64) -> Option<Datum> {
    let (first, last) = (run.first()?.span, run.last()?.span);
    let before = Span { end: first.start, ..first };
    let after = Span { start: last.end, ..last };
    let mut items = vec![symbol(before, "procedure")];
    if !run.iter().any(|clause| clause.head_name() == "index") {
        *number += 1;
        let goal = vec![symbol(before, "fragment"), Datum { kind: DatumKind::Integer(*number), span: before }];
        items.push(list(before, vec![symbol(before, "index"), list(before, goal)]));
    }
    let ends = run.iter().any(|clause| clause.head_name() == "end-when");
    items.extend(run);
    if !ends {
        // The end of the procedure is not part of the fragment; without this the checker would report a missing end.
        let end = list(after, vec![symbol(after, "fragment-ends")]);
        items.push(list(after, vec![symbol(after, "end-when"), end]));
    }
    Some(list(Span { end: last.end, ..first }, items))
}

fn symbol(span: Span, name: &str) -> Datum {
    Datum { kind: DatumKind::Symbol(Symbol::new(name)), span }
}

fn list(span: Span, items: Vec<Datum>) -> Datum {
    Datum { kind: DatumKind::List(items), span }
}
