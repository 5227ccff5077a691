//! Fixes for a quantity of the wrong dimension: they keep the number and replace the unit.

use super::Lowering;
use crate::diagnostic::{Diagnostic, Span};
use crate::fix::Fix;
use crate::read::number_and_unit;

impl Lowering {
    /// Adds the expected unit to a diagnostic, and a fix that writes the same number with it. The fix is not applied automatically,
    /// because only the author knows whether the number is meant in that unit.
    pub(crate) fn in_unit(&self, diagnostic: Diagnostic, span: Span, unit: &str) -> Diagnostic {
        let diagnostic = diagnostic.reason(format!("its values are in {unit}"));
        match self.quantity_at(span) {
            Some((number, other)) => {
                let title = format!("replace `{number}{other}` by `{number}{unit}`");
                diagnostic.fix(Fix::look(title).replace(span, format!("{number}{unit}")))
            }
            None => diagnostic.help(format!("write a value in {unit}, or a number without unit, which is in {unit}")),
        }
    }

    /// Returns a fix that writes the number at `span` as a duration: `m` is metres, minutes are `min`.
    pub(crate) fn as_duration(&self, span: Span) -> Option<Fix> {
        let (number, other) = self.quantity_at(span)?;
        let unit = if other == "m" { "min" } else { "s" };
        let title = format!("replace `{number}{other}` by `{number}{unit}`");
        Some(Fix::look(title).replace(span, format!("{number}{unit}")))
    }

    /// Returns the number and the unit of the text at `span`, if it is exactly one quantity.
    fn quantity_at(&self, span: Span) -> Option<(&str, &str)> {
        number_and_unit(self.text_at(span)?)
    }

    /// Returns the text at `span`.
    pub(crate) fn text_at(&self, span: Span) -> Option<&str> {
        let text = self.texts.get(usize::try_from(span.file).ok()?)?;
        text.get(usize::try_from(span.start).ok()?..usize::try_from(span.end).ok()?)
    }
}
