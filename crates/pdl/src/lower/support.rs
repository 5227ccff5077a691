//! Refuses what the executive cannot do yet: nothing is ignored silently.

use super::Lowering;
use crate::codes;
use crate::diagnostic::{Diagnostic, Span};
use crate::read::Datum;
use apex_model::condition::{Condition, ConditionKind};
use apex_model::source::Place;
use apex_model::support::unsupported_condition;

impl Lowering {
    /// Refuses a condition that the executive cannot evaluate; a note in a fragment. `source` holds its text.
    pub(crate) fn check_condition_support(&mut self, condition: &Condition, source: &Datum) -> Option<()> {
        let Some(what) = unsupported_condition(condition) else { return Some(()) };
        let place = innermost_unsupported(condition).place;
        let span = span_at(source, place).unwrap_or(source.span);
        self.unsupported(what, span)
    }

    fn unsupported(&mut self, what: &str, span: Span) -> Option<()> {
        let message = format!("{what} is not yet supported");
        let severity = self.undefined();
        let diagnostic = Diagnostic::new(severity, codes::NOT_SUPPORTED, span, message)
            .reason("the text is correct, but the executive cannot carry it out; it is refused rather than ignored");
        self.report(diagnostic);
        self.fragment.then_some(())
    }
}

/// The smallest part of `condition` that is unsupported.
fn innermost_unsupported(condition: &Condition) -> &Condition {
    let parts: &[Condition] = match &condition.kind {
        ConditionKind::And(parts, _)
        | ConditionKind::Or(parts, _)
        | ConditionKind::InOrder(parts, _)
        | ConditionKind::Allen { parts, .. } => parts,
        ConditionKind::Not(part) | ConditionKind::Absent(part, _) => std::slice::from_ref(part),
        _ => &[],
    };
    match parts.iter().find(|part| unsupported_condition(part).is_some()) {
        Some(part) => innermost_unsupported(part),
        None => condition,
    }
}

/// The span of the datum that begins at `place`, inside of `datum`.
fn span_at(datum: &Datum, place: Place) -> Option<Span> {
    if datum.span.place() == place {
        return Some(datum.span);
    }
    datum.as_list().unwrap_or_default().iter().find_map(|item| span_at(item, place))
}
