//! Timing of episodes and events: start, end, duration, and the older words for earliest and latest times (`conditions.md`, T).

use super::Lowering;
use super::expected::{Expected, ExpectedKind};
use crate::codes;
use crate::diagnostic::Diagnostic;
use crate::read::{Datum, DatumKind};
use crate::suggest::renames_marked;
use apex_model::condition::{Constraint, Relation, Timing};

const WORDS: &[&str] = &[
    "start",
    "end",
    "duration",
    "es",
    "ls",
    "ee",
    "le",
    "earliest-start",
    "latest-start",
    "earliest-end",
    "latest-end",
];

/// Returns true for `:start`, `:end` and the other words of timing.
fn is_word(item: &Datum) -> bool {
    item.keyword().is_some_and(|name| WORDS.contains(&name))
}

impl Lowering {
    /// Lowers the values of `:timing`. An event's time may be constrained directly, as in Table 1 of the paper.
    pub(crate) fn timing(&mut self, items: &[Datum], is_event: bool) -> Option<Timing> {
        let mut timing = Timing::default();
        let mut complete = true;
        for item in items {
            if let [first, rest @ ..] = item.as_list().unwrap_or_default()
                && is_word(first)
                && rest.iter().any(is_word)
            {
                complete &= self.timing_in_one_list(item, is_event, &mut timing).is_some();
                continue;
            }
            let done = if Lowering::is_nested(item) {
                item.as_list()
                    .unwrap_or_default()
                    .iter()
                    .all(|inner| self.timing_group(inner, is_event, &mut timing).is_some())
            } else {
                self.timing_group(item, is_event, &mut timing).is_some()
            };
            complete &= done;
        }
        complete.then_some(timing)
    }

    /// Lowers `(:start CONSTRAINT.. :end CONSTRAINT..)`, an older spelling.
    fn timing_in_one_list(&mut self, item: &Datum, is_event: bool, timing: &mut Timing) -> Option<()> {
        let mut complete = true;
        let mut rest = item.as_list().unwrap_or_default();
        while let Some((_, after)) = rest.split_first() {
            let length = 1 + after.iter().position(is_word).unwrap_or(after.len());
            let (part, next) = rest.split_at_checked(length).unwrap_or((rest, &[]));
            let part = Datum { kind: DatumKind::List(part.to_vec()), span: super::span_of(part, item.span) };
            complete &= self.timing_group(&part, is_event, timing).is_some();
            rest = next;
        }
        complete.then_some(())
    }

    fn timing_group(&mut self, item: &Datum, is_event: bool, timing: &mut Timing) -> Option<()> {
        let instant = Expected::plain("this time", ExpectedKind::Instant);
        let word = item.as_list().and_then(<[Datum]>::first).and_then(Datum::keyword);
        if let Some(name) = WORDS.iter().find(|name| item.head().is_some_and(|head| head.is(name))) {
            let diagnostic =
                Diagnostic::error(codes::MALFORMED_CONDITION, item.head_span(), format!("`{name}` lacks its colon"));
            return self.refuse(diagnostic.fix(super::slips::colon(name, item.head_span())));
        }
        match word {
            Some("start") => timing.start.extend(self.constraints(item.tail(), &instant)?),
            Some("end") => timing.end.extend(self.constraints(item.tail(), &instant)?),
            Some("duration") => {
                let duration = Expected::plain("the duration", ExpectedKind::Duration);
                timing.duration.extend(self.constraints(item.tail(), &duration)?);
            }
            Some("es" | "earliest-start") => timing.start.push(self.limit(item, Relation::GreaterOrEqual)?),
            Some("ls" | "latest-start") => timing.start.push(self.limit(item, Relation::LessOrEqual)?),
            Some("ee" | "earliest-end") => timing.end.push(self.limit(item, Relation::GreaterOrEqual)?),
            Some("le" | "latest-end") => timing.end.push(self.limit(item, Relation::LessOrEqual)?),
            None if is_event && item.head().is_some() => {
                timing.start.extend(self.constraints(std::slice::from_ref(item), &instant)?);
            }
            _ => {
                let diagnostic =
                    Diagnostic::error(codes::MALFORMED_CONDITION, item.span, "this is not a timing constraint");
                let span = item.head_span();
                let mark = |name: &str| format!(":{name}");
                let fixes = renames_marked(span, word.unwrap_or_default(), WORDS.iter().copied(), mark);
                return self.refuse(diagnostic.fixes_or_help(fixes, || {
                    "write `(:start CONSTRAINT..)`, `(:end CONSTRAINT..)` or `(:duration CONSTRAINT..)`".to_string()
                }));
            }
        }
        Some(())
    }

    fn limit(&mut self, item: &Datum, relation: Relation) -> Option<Constraint> {
        let datum = self.only("an earliest or latest time", item.tail(), item.span)?;
        let instant = Expected::plain("this time", ExpectedKind::Instant);
        let right = self.pure_expression(datum, "a condition")?;
        let right = self.conform(right, datum.span, &instant)?;
        Some(Constraint::Compare { relation, right, tolerance: None })
    }
}
