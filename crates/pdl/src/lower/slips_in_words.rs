//! Comparisons written as words: `(roll uav above 15)`, `(roll uav greater than 15)`, `(roll uav between 5 and 15)`. As they stand, they
//! would be messages that never come.

use super::Lowering;
use super::slips_of_tasks::AS_WRITTEN;
use crate::codes;
use crate::diagnostic::{Diagnostic, Span};
use crate::fix::Fix;
use crate::read::{Datum, DatumKind};

/// Words between an object and a number, with the relation that they mean.
const WORDS: &[(&str, &str)] = &[
    ("above", ">"),
    ("over", ">"),
    ("beyond", ">"),
    ("greater", ">"),
    ("more", ">"),
    ("higher", ">"),
    ("below", "<"),
    ("under", "<"),
    ("less", "<"),
    ("lower", "<"),
    ("is", "="),
    ("not", "/="),
    ("~=", "/="),
];

impl Lowering {
    /// Reports a worded comparison of an attribute and an object with numbers; true if it did.
    pub(super) fn report_worded_relation(&mut self, items: &[Datum]) -> bool {
        let [_, object, words @ ..] = items else { return false };
        if object.as_list().is_some() || !words.iter().any(|word| is_figure(word) || word.as_list().is_some()) {
            return false;
        }
        match words {
            [word, first, second] if word.is("between") && is_figure(first) && is_figure(second) => {
                let at = Span { end: second.span.start, start: second.span.start, ..second.span };
                self.range(word, |fix| fix.insert_before(at, "<= "))
            }
            [word, first, and, second] if is_between(word, and) && is_figure(first) && is_figure(second) => {
                self.range(word, |fix| fix.replace(and.span, "<="))
            }
            [word, Datum { kind: DatumKind::List(figures), span }]
                if word.is("in")
                    && matches!(figures.as_slice(), [first, second] if is_figure(first) && is_figure(second)) =>
            {
                let [opening, closing] = [span.start, span.end.saturating_sub(1)];
                let mark = |start: u32| Span { start, end: start.saturating_add(1), ..*span };
                let second = figures.last().map_or(*span, |second| Span { end: second.span.start, ..second.span });
                self.range(word, |fix| {
                    fix.replace(mark(opening), "").insert_before(second, "<= ").replace(mark(closing), "")
                })
            }
            [word, than, figure] if than.is("than") && is_figure(figure) => {
                self.worded(word, Span { end: than.span.end, ..word.span })
            }
            [word, figure] if is_figure(figure) => self.worded(word, word.span),
            _ => false,
        }
    }

    fn worded(&mut self, word: &Datum, span: Span) -> bool {
        let Some((_, own)) = WORDS.iter().find(|(name, _)| word.is(name)) else { return false };
        let fix = Fix::safe(format!("replace it by `{own}`")).replace(span, *own);
        let message = "a comparison takes a sign, not a word";
        self.report(Diagnostic::error(codes::MALFORMED_CONDITION, span, message).reason(AS_WRITTEN).fix(fix));
        true
    }

    /// Reports a comparison with two limits; `rest` replaces what follows the first one.
    fn range(&mut self, word: &Datum, rest: impl FnOnce(Fix) -> Fix) -> bool {
        let fix = rest(Fix::safe("write `>= LOW <= HIGH`").replace(word.span, ">="));
        let message = format!("no relation is called `{}`", word.as_symbol().map_or("", |word| word.printed()));
        self.report(Diagnostic::error(codes::MALFORMED_CONDITION, word.span, message).reason(AS_WRITTEN).fix(fix));
        true
    }
}

fn is_between(word: &Datum, and: &Datum) -> bool {
    word.is("between") && and.is("and") || word.is("from") && and.is("to")
}

/// Returns true for a number, a quantity or a span of time as it is written.
fn is_figure(datum: &Datum) -> bool {
    matches!(datum.kind, DatumKind::Integer(_) | DatumKind::Real(_) | DatumKind::Quantity(_) | DatumKind::Duration(_))
}
