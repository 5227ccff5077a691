//! Conditions composed of conditions: logic, order, Allen relations, absence (`conditions.md`).

use super::Lowering;
use super::clauses::groups;
use crate::codes;
use crate::diagnostic::Diagnostic;
use crate::read::{Datum, DatumKind};
use apex_model::condition::{AllenRelation, Condition, ConditionKind};
use apex_model::expression::{Expr, ExprKind};
use apex_model::symbol::Symbol;
use apex_model::time::Duration;
use apex_model::value::Value;
use std::sync::Arc;

/// Every spelling of an Allen relation; the first spelling of each is printed.
const ALLEN: &[(&str, AllenRelation)] = &[
    ("before", AllenRelation::Before),
    ("after", AllenRelation::After),
    ("meets", AllenRelation::Meets),
    ("met-by", AllenRelation::MetBy),
    ("met", AllenRelation::MetBy),
    ("overlaps", AllenRelation::Overlaps),
    ("overlapped-by", AllenRelation::OverlappedBy),
    ("overlapped", AllenRelation::OverlappedBy),
    ("starts", AllenRelation::Starts),
    ("started-by", AllenRelation::StartedBy),
    ("started", AllenRelation::StartedBy),
    ("finishes", AllenRelation::Finishes),
    ("finished-by", AllenRelation::FinishedBy),
    ("finished", AllenRelation::FinishedBy),
    ("during", AllenRelation::During),
    ("contains", AllenRelation::Contains),
    ("cotemporal", AllenRelation::Cotemporal),
];

fn allen(keyword: &str) -> Option<AllenRelation> {
    ALLEN.iter().find(|(name, _)| *name == keyword).map(|(_, relation)| *relation)
}

/// Applies `:any` of a relation to an episode that it relates.
fn bound_by_any_samples(part: &mut Condition) {
    match &mut part.kind {
        ConditionKind::Episode(episode) => Arc::make_mut(episode).any = true,
        ConditionKind::Probing { condition, .. } => bound_by_any_samples(condition),
        _ => {}
    }
}

impl Lowering {
    pub(crate) fn is_composite(&self, keyword: &str) -> bool {
        matches!(keyword, "and" | "or" | "not" | "absent" | "in-order") || allen(keyword).is_some()
    }

    /// Lowers `(:and [tag] C.. [:constraint E..])` and its relatives.
    pub(crate) fn composite(&mut self, datum: &Datum, keyword: &str, items: &[Datum]) -> Option<Condition> {
        let (any, items) = match allen(keyword) {
            Some(_) => self.without_any(items),
            None => (false, items.to_vec()),
        };
        let (tag, items) = self.composite_tag(&items);
        // `:quality` after an episode belongs to the parts, every other keyword to the whole.
        let split = items
            .iter()
            .enumerate()
            .position(|(index, item)| {
                item.keyword().is_some_and(|name| name != "quality")
                    && !(index > 0 && items.get(index - 1).is_some_and(|before| before.is(":quality")))
            })
            .unwrap_or(items.len());
        let (parts, options) = items.split_at_checked(split).unwrap_or((items, &[]));
        let (_, options) = groups(options);
        let known: &[&str] = match keyword {
            "and" | "or" | "in-order" => &["constraint", "constraints"],
            "not" => &[],
            "absent" => &["for"],
            _ => &["constraint", "constraints", "tolerance"],
        };
        self.check_groups(&options, known, &format!("`:{keyword}`"))?;
        let parts = self.conditions(parts);
        let mut constraints = Some(Vec::new());
        for group in options.iter().filter(|group| group.name.starts_with("constraint")) {
            let lowered = self.body(group.values);
            constraints = constraints.zip(lowered).map(|(mut all, more)| {
                all.extend(more);
                all
            });
        }
        let duration = |lowering: &mut Lowering, datum: &Datum| lowering.span_of_time(datum);
        let tolerance = self.optional(&options, "tolerance", duration);
        let window = self.optional(&options, "for", duration);
        let (mut parts, mut constraints, tolerance, window) = (parts?, constraints?, tolerance?, window?);
        if let Some(window) = &window {
            self.refuse_empty_absence(datum, window)?;
        }
        if any {
            parts.iter_mut().for_each(bound_by_any_samples);
        }
        if matches!(keyword, "and" | "in-order") || allen(keyword).is_some() {
            constraints.extend(super::joined::join(&mut parts));
        }
        let count = parts.len();
        let single = match <[Condition; 1]>::try_from(parts.clone()) {
            Ok([part]) => Some(Box::new(part)),
            Err(_) => None,
        };
        let kind = match (keyword, single, window) {
            ("and", ..) if count > 0 => ConditionKind::And(parts, constraints),
            ("or", ..) if count > 0 => ConditionKind::Or(parts, constraints),
            ("in-order", ..) if count > 0 => ConditionKind::InOrder(parts, constraints),
            ("not", Some(part), _) => ConditionKind::Not(part),
            ("absent", Some(part), Some(window)) => ConditionKind::Absent(part, window),
            _ => match allen(keyword).filter(|_| count >= 2) {
                Some(relation) => ConditionKind::Allen { relation, parts, tolerance, constraints },
                None => return self.malformed_composite(datum, keyword),
            },
        };
        Some(Condition { tag, kind, place: datum.span.place() })
    }

    /// Rejects an absence that lasts no time: it would hold between any two results of its condition.
    fn refuse_empty_absence(&mut self, datum: &Datum, window: &Expr) -> Option<()> {
        let ExprKind::Constant(Value::Duration(length)) = &window.kind else { return Some(()) };
        if *length > Duration::ZERO {
            return Some(());
        }
        let message = format!("an absence of {length} requires nothing");
        let diagnostic = Diagnostic::error(codes::MALFORMED_CONDITION, datum.span, message)
            .reason("it would hold at every instant without a result, and between any two of them")
            .help("write the time for which the condition must not hold, such as `:for 10s`, or `(:not C)` for this instant");
        self.refuse(diagnostic)
    }

    /// Splits off the tag before composite parts: a plain symbol, because a variable there is the end of a step.
    fn composite_tag<'d>(&mut self, items: &'d [Datum]) -> (Option<Symbol>, &'d [Datum]) {
        match items.split_first() {
            Some((Datum { kind: DatumKind::Symbol(name), span }, rest)) if !name.folded().starts_with(':') => {
                self.scope.bind(name, *span);
                (Some(name.clone()), rest)
            }
            _ => (None, items),
        }
    }

    fn malformed_composite<T>(&mut self, datum: &Datum, keyword: &str) -> Option<T> {
        let shape = match keyword {
            "and" | "or" | "in-order" => format!("(:{keyword} [tag] CONDITION.. [:constraint EXPR..])"),
            "not" => "(:not CONDITION)".to_string(),
            "absent" => "(:absent CONDITION :for DURATION)".to_string(),
            _ => format!("(:{keyword} [tag] CONDITION CONDITION.. [:any] [:tolerance DURATION] [:constraint EXPR..])"),
        };
        let message = format!("this `:{keyword}` condition has the wrong parts");
        let diagnostic =
            Diagnostic::error(codes::MALFORMED_CONDITION, datum.span, message).help(format!("its shape is `{shape}`"));
        self.refuse(diagnostic)
    }
}
