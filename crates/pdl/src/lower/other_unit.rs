//! Fixes for a quantity of the wrong dimension: the number may be right where the unit is not.

use super::Lowering;
use crate::diagnostic::{Diagnostic, Span};
use crate::fix::Fix;
use crate::read::number_and_unit;

impl Lowering {
    /// Says in which unit a value is wanted, and offers the number that is written with it. Only its author knows whether
    /// the number was meant in that unit.
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

    /// The number that is written at `span` as a duration: `m` is a length, and minutes are `min`.
    pub(crate) fn as_duration(&self, span: Span) -> Option<Fix> {
        let (number, other) = self.quantity_at(span)?;
        let unit = if other == "m" { "min" } else { "s" };
        let title = format!("replace `{number}{other}` by `{number}{unit}`");
        Some(Fix::look(title).replace(span, format!("{number}{unit}")))
    }

    /// The number and the unit of the quantity that is all that is written at `span`.
    fn quantity_at(&self, span: Span) -> Option<(&str, &str)> {
        number_and_unit(self.text_at(span)?)
    }

    /// Returns the text at `span`.
    pub(crate) fn text_at(&self, span: Span) -> Option<&str> {
        let text = self.texts.get(usize::try_from(span.file).ok()?)?;
        text.get(usize::try_from(span.start).ok()?..usize::try_from(span.end).ok()?)
    }
}
