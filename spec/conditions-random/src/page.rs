//! A question that is answered differently, as a page of the specification that can be read, corrected and kept.

use crate::compare::{Finding, compare};
use crate::generate::UNTIL;
use crate::print;
use apex_definition::Question;
use std::fmt::Write;

/// Returns the page of a question. Its trace is empty: `UPDATE=1` fills it, and a reader must judge it.
pub fn of(seed: u64, question: &Question) -> String {
    let condition = print::condition(&question.condition);
    let found = match &question.condition.tag {
        Some(tag) => format!("(print (start-of ?{tag}) (end-of ?{tag}))"),
        None => "(print found)".into(),
    };
    let mut page = format!("# Random question {seed}\n\n```pdl\n{}", print::declarations(question));
    let waiting = format!("{found}\n    (waitfor {condition})");
    let _ = if question.created == 0 {
        writeln!(page, "(procedure (index (do-domain))\n  (step a {waiting}))")
    } else {
        let created = print::span(question.created);
        writeln!(
            page,
            "(procedure :sequential (index (do-domain))\n  (step first (work {created}))\n  (step second (look)))\n\
             (procedure (index (look))\n  (step a {waiting}))\n(primitive (index (work ?time)) (duration ?time))"
        )
    };
    page.push_str("```\n");
    if !question.arrivals.is_empty() {
        let _ = write!(page, "\n```inputs\n{}```\n", print::inputs(question));
    }
    let _ = write!(page, "\n```options\nuntil {}\nshow print\n```\n\n```trace\n```\n", print::span(UNTIL));
    if let Finding::Different(difference) = compare(question) {
        let _ = write!(page, "\n<!--\n{difference}-->\n");
    }
    page
}
