//! Conditions on state variables that lack a part: `(roll > 15)` its object, `(roll uav 15)` its relation. As they stand, no sample and no
//! message satisfies them.

use super::Lowering;
use super::constraint::relation_named;
use super::slips_of_tasks::AS_WRITTEN;
use crate::codes;
use crate::diagnostic::Diagnostic;
use crate::fix::Fix;
use crate::read::{Datum, DatumKind};

/// Words for how a value changes, with a condition that says it.
const CHANGES: &[(&[&str], &str)] = &[
    (
        &["changed", "changes", "changing"],
        "derive a variable that says it: `(state-variable (moved ?a) :derived (changed (ATTRIBUTE ?a)))`",
    ),
    (
        &["increasing", "increases", "rising", "rises", "climbing", "decreasing", "decreases", "falling", "falls"],
        "write `(:episode (ATTRIBUTE OBJECT) :quality (:no-constraints) :trend (:rate :increasing))`",
    ),
];

impl Lowering {
    /// Reports a comparison without an object, or a state variable without a comparison; true if it did.
    pub(super) fn report_slip_of_variable(&mut self, items: &[Datum]) -> bool {
        self.report_missing_object(items) || self.report_missing_relation(items)
    }

    /// Reports `(roll > 15)`; true if it did.
    fn report_missing_object(&mut self, items: &[Datum]) -> bool {
        let [head, relation, _, ..] = items else { return false };
        let Some(name) = head.as_symbol().filter(|_| head.keyword().is_none()) else { return false };
        if relation_named(relation).is_none() {
            return false;
        }
        let last = items.last().map_or(relation.span, |last| last.span);
        let compared = self.text_at(relation.span.to(last)).unwrap_or("REL VALUE").to_string();
        let message = format!("this comparison of `{name}` has no object");
        let fix = Fix::look(format!("write `({name} ? {compared})` for any object")).insert_after(head.span, " ?");
        let diagnostic = Diagnostic::error(codes::MALFORMED_CONDITION, relation.span, message)
            .reason("a state variable is an attribute of an object, so no sample satisfies this")
            .help(format!("name the object: `({name} OBJECT {compared})`"));
        self.report(diagnostic.fix(fix));
        true
    }

    /// Reports `(roll uav 15)` and `(roll uav changed)`, where `roll` is a declared state variable; true if it did.
    fn report_missing_relation(&mut self, items: &[Datum]) -> bool {
        let [head, object, rest @ ..] = items else { return false };
        let Some(name) = head.as_symbol().filter(|name| self.names.state_variables.contains_key(*name)) else {
            return false;
        };
        let is_compared = items.iter().any(|item| relation_named(item).is_some());
        if rest.is_empty() || is_compared || object.as_list().is_some() {
            return false;
        }
        let message = format!("`{name}` is a state variable, and this does not compare it");
        let object = self.text_at(object.span).unwrap_or("OBJECT").to_string();
        let last = rest.last().map_or(head.span, |last| last.span);
        let diagnostic = Diagnostic::error(codes::MALFORMED_CONDITION, head.span.to(last), message).reason(AS_WRITTEN);
        let change =
            rest.first().and_then(|word| CHANGES.iter().find(|(words, _)| words.iter().any(|each| word.is(each))));
        let diagnostic = match (rest, change) {
            (_, Some((_, help))) => diagnostic.help(*help),
            ([value], None) if is_value(value) => {
                diagnostic.fix(Fix::look("write `=` before the value").insert_before(value.span, "= "))
            }
            _ => diagnostic
                .help(format!("write `({name} {object} REL VALUE)`, for example `({name} {object} >= LOW <= HIGH)`")),
        };
        self.report(diagnostic);
        true
    }
}

fn is_value(datum: &Datum) -> bool {
    !matches!(datum.kind, DatumKind::List(_) | DatumKind::Variable(_))
}
