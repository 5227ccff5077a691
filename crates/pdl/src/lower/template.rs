//! Templates: activities, event forms, backquoted lists. Variables and indexicals are substituted, `,EXPR` is
//! evaluated, everything else is literal.

use super::Lowering;
use crate::read::{Datum, DatumKind};
use apex_model::expression::{Expr, ExprKind, Template};
use apex_model::value::Value;

impl Lowering {
    /// Lowers a datum with holes.
    pub(crate) fn template(&mut self, datum: &Datum) -> Option<Template> {
        let span = datum.span;
        let hole = |kind: ExprKind| match kind {
            ExprKind::Constant(value) => Template::Constant(value),
            kind => Template::Hole(Expr { kind, place: span.place() }),
        };
        match &datum.kind {
            DatumKind::Variable(name) => Some(hole(self.variable(name, false, span)?)),
            DatumKind::Bound(name) => Some(hole(self.variable(name, true, span)?)),
            DatumKind::Indexical(name) => Some(hole(self.indexical(name, span))),
            DatumKind::Unquote(inner) => self.expression(inner).map(hole_or_constant),
            DatumKind::Splice(inner) => self.expression(inner).map(Template::Splice),
            DatumKind::Quasi(inner) => self.template(inner),
            DatumKind::Quote(inner) => Some(Template::Constant(inner.to_value())),
            DatumKind::Symbol(name) => {
                self.check_quantity_name(name, span);
                Some(Template::Constant(datum.to_value()))
            }
            DatumKind::List(items) => {
                let parts = self.all(items, Lowering::template)?;
                Some(list_of(parts))
            }
            _ => Some(Template::Constant(datum.to_value())),
        }
    }
}

fn hole_or_constant(expr: Expr) -> Template {
    match expr.kind {
        ExprKind::Constant(value) => Template::Constant(value),
        _ => Template::Hole(expr),
    }
}

/// Returns a list template; a constant when no part has a hole.
pub(crate) fn list_of(parts: Vec<Template>) -> Template {
    if parts.iter().all(|part| matches!(part, Template::Constant(_))) {
        let values = parts.into_iter().filter_map(|part| match part {
            Template::Constant(value) => Some(value),
            _ => None,
        });
        return Template::Constant(Value::list(values));
    }
    Template::List(parts)
}
