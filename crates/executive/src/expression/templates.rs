//! Templates: data with holes.

use super::EvalContext;
use super::evaluator::{Evaluator, error};
use super::lists::{bounded, items};
use super::result::EvalResult;
use apex_forms::print::Style;
use apex_model::expression::{Expr, ExprKind, Template};
use apex_model::source::Place;
use apex_model::value::Value;
use smallvec::SmallVec;

/// Values collected for one list; most lists are short.
type Few = SmallVec<[Value; 8]>;

/// Nesting of templates, which is bounded by the reader already.
const DEPTH_MAX: usize = apex_model::limits::READ_DEPTH_MAX;

impl Evaluator<'_> {
    /// Returns the datum that `template` yields; `place` is used for messages about splices.
    pub(super) fn template(&mut self, template: &Template, place: Place) -> EvalResult {
        self.filled(template, place, DEPTH_MAX)
    }

    fn filled(&mut self, template: &Template, place: Place, depth: usize) -> EvalResult {
        let Some(depth) = depth.checked_sub(1) else {
            return Err(error(place, "the form is nested too deep"));
        };
        match template {
            Template::Constant(value) => Ok(value.clone()),
            Template::Hole(expr) | Template::Splice(expr) => self.value(expr),
            Template::List(parts) => {
                let mut values = Few::with_capacity(parts.len());
                for part in parts {
                    match part {
                        Template::Splice(expr) => {
                            let value = self.value(expr)?;
                            let list = items(&value).map_err(|message| error(expr.place, format!(",@: {message}")))?;
                            values.extend(list.iter().cloned());
                        }
                        other => values.push(self.filled(other, place, depth)?),
                    }
                    self.charge(1, place)?;
                }
                bounded(values).map_err(|message| error(place, message))
            }
        }
    }
}

/// Returns the first hole's place: where messages about the whole template point.
pub(super) fn place_of(template: &Template) -> Place {
    match template {
        Template::Constant(_) => Place::default(),
        Template::Hole(expr) | Template::Splice(expr) => expr.place,
        Template::List(parts) => {
            parts.iter().map(place_of).find(|place| *place != Place::default()).unwrap_or_default()
        }
    }
}

/// Returns `template` with its known values filled in; holes without a value remain as they are written.
pub(super) fn partially(template: &Template, context: &dyn EvalContext) -> Value {
    partially_within(template, context, DEPTH_MAX)
}

fn partially_within(template: &Template, context: &dyn EvalContext, depth: usize) -> Value {
    let Some(depth) = depth.checked_sub(1) else { return Value::symbol("..") };
    match template {
        Template::Constant(value) => value.clone(),
        Template::Hole(expr) | Template::Splice(expr) => {
            Evaluator::new(context, None).value(expr).unwrap_or_else(|_| written(expr))
        }
        Template::List(parts) => {
            let mut values = Few::with_capacity(parts.len());
            for part in parts {
                match part {
                    Template::Splice(expr) => match Evaluator::new(context, None).value(expr) {
                        Ok(Value::List(items)) => values.extend(items.iter().cloned()),
                        _ => values.push(written(expr)),
                    },
                    other => values.push(partially_within(other, context, depth)),
                }
            }
            Value::list_of(&mut values)
        }
    }
}

/// Returns an argument with known variables replaced by their values; calls remain as they are written.
pub(super) fn as_known(expr: &Expr, context: &dyn EvalContext) -> Value {
    as_known_within(expr, context, DEPTH_MAX)
}

fn as_known_within(expr: &Expr, context: &dyn EvalContext, depth: usize) -> Value {
    let Some(depth) = depth.checked_sub(1) else { return Value::symbol("..") };
    let list = |head: &str, parts: &[Expr]| {
        let parts = parts.iter().map(|part| as_known_within(part, context, depth));
        Value::list([Value::symbol(head)].into_iter().chain(parts))
    };
    match &expr.kind {
        ExprKind::Constant(value) => value.clone(),
        ExprKind::Call { function, arguments } => list(&function.to_string(), arguments),
        ExprKind::And(parts) => list("and", parts),
        ExprKind::Or(parts) => list("or", parts),
        ExprKind::If(test, ..) => {
            Value::list([Value::symbol("if"), as_known_within(test, context, depth), Value::symbol("..")])
        }
        ExprKind::Template(template) => partially_within(template, context, depth),
        ExprKind::Variable { .. } | ExprKind::Indexical(_) | ExprKind::Named(_) | ExprKind::Local(_) => {
            Evaluator::new(context, None).value(expr).unwrap_or_else(|_| written(expr))
        }
        ExprKind::FunctionName(name) => Value::symbol(&format!("#'{name}")),
        ExprKind::Cond(_)
        | ExprKind::Case(..)
        | ExprKind::Let { .. }
        | ExprKind::Lambda { .. }
        | ExprKind::Assign { .. }
        | ExprKind::Sequence(_) => Value::symbol(&Style::Exact.expression(expr)),
    }
}

/// Returns a hole without a value as a symbol.
fn written(expr: &Expr) -> Value {
    match &expr.kind {
        ExprKind::Variable { name, .. } => Value::symbol(&format!("?{name}")),
        ExprKind::Indexical(name) => Value::symbol(&format!("+{name}+")),
        ExprKind::Local(name) | ExprKind::Named(name) => Value::Symbol(name.clone()),
        ExprKind::Call { function, .. } => Value::symbol(&format!(",({function} ..)")),
        _ => Value::symbol(",(..)"),
    }
}
