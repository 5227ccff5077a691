//! Value intervals (TC)
//! What: computes bounds of an expression over a span of time in which no input arrives.
//! Runs: contend phase, for priorities and interrupt costs.  Reads: expressions, Task.  Writes: nothing.
//! Bound: O(size of the expression), with what it calls.  PDL: `priority`, `interrupt-cost`, `+now+`, `+tot+`.
//! Paper: section III, priority of competitors.

use crate::expression::evaluate;
use crate::expression::view::View;
use apex_model::expression::{Expr, ExprKind};
use apex_model::library::Library;
use apex_model::symbol::Symbol;
use apex_model::time::Time;
use apex_model::value::Value;

/// Depth of nested definitions up to which an expression is analysed; a deeper one counts as changing.
const NESTING_MAX: u32 = 16;
/// Relative width added to computed bounds, so that rounding cannot make them too narrow.
const ROUNDING: f64 = 1e-13;

/// Least and greatest value. Instants and durations are in seconds, everything else in SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds {
    /// Lower bound.
    pub(crate) low: f64,
    /// Upper bound.
    pub(crate) high: f64,
}

impl Bounds {
    /// Bounds of an unknown value.
    pub(crate) const ANY: Bounds = Bounds { low: f64::NEG_INFINITY, high: f64::INFINITY };

    /// Returns the tightest bounds that contain all `corners`.
    pub(crate) fn of(corners: &[f64]) -> Bounds {
        let fold = |start, pick: fn(f64, f64) -> f64| corners.iter().copied().fold(start, pick);
        Bounds { low: fold(f64::INFINITY, f64::min), high: fold(f64::NEG_INFINITY, f64::max) }
    }

    /// Returns the bounds of the greater of two values.
    pub(crate) fn greater(self, other: Bounds) -> Bounds {
        Bounds { low: self.low.max(other.low), high: self.high.max(other.high) }
    }

    /// Returns the bounds of the sum of two values.
    pub(crate) fn plus(self, other: Bounds) -> Bounds {
        Bounds { low: self.low + other.low, high: self.high + other.high }
    }

    fn both(self, other: Bounds) -> Bounds {
        Bounds { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    fn widened(self) -> Bounds {
        let by = ROUNDING * (1.0 + self.low.abs().max(self.high.abs()));
        Bounds { low: self.low - by, high: self.high + by }
    }
}

/// Returns true if the value may change with time alone.
pub(crate) fn moves(expr: &Expr, library: &Library) -> bool {
    reads_time(expr, library, 0)
}

fn reads_time(expr: &Expr, library: &Library, depth: u32) -> bool {
    if depth > NESTING_MAX {
        return true;
    }
    let any = |parts: &[Expr]| parts.iter().any(|part| reads_time(part, library, depth));
    let one = |part: &Expr| reads_time(part, library, depth);
    let inside = |part: &Expr| reads_time(part, library, depth + 1);
    match &expr.kind {
        ExprKind::Constant(_) | ExprKind::Variable { .. } | ExprKind::Local(_) | ExprKind::FunctionName(_) => false,
        ExprKind::Indexical(name) => is_clock(name) || library.indexicals.get(name).is_some_and(inside),
        ExprKind::Named(name) => library.constants.get(name).is_some_and(inside),
        ExprKind::Call { function, arguments } => {
            let body = library.functions.get(function).map(|function| function.body.as_slice()).unwrap_or_default();
            looks_back(function) || any(arguments) || body.iter().any(inside)
        }
        ExprKind::If(test, then, otherwise) => one(test) || one(then) || otherwise.as_deref().is_some_and(one),
        ExprKind::Cond(rows) => rows.iter().any(|(test, body)| one(test) || any(body)),
        ExprKind::Case(key, rows) => one(key) || rows.iter().any(|(_, body)| any(body)),
        ExprKind::And(parts) | ExprKind::Or(parts) | ExprKind::Sequence(parts) => any(parts),
        ExprKind::Let { bindings, body, .. } => bindings.iter().any(|(_, value)| one(value)) || any(body),
        ExprKind::Lambda { body, .. } => any(body),
        ExprKind::Assign { value, .. } => one(value),
        ExprKind::Template(_) => true,
    }
}

fn is_clock(name: &Symbol) -> bool {
    name.is("now") || name.is("tot") || name.is("met")
}

/// Returns true for functions that read the clock or a window that ends now.
fn looks_back(function: &Symbol) -> bool {
    ["elapsed", "duration-of", "mean-over", "min-over", "max-over", "samples-over", "events-over"]
        .iter()
        .any(|name| function.is(name))
}

/// Returns the bounds of `expr` from `view.now` to `until`; [`Bounds::ANY`] if the form of the expression is not analysed. `None` if its
/// present value is not a number.
pub(crate) fn bounds(expr: &Expr, view: &View<'_>, until: Time) -> Option<Bounds> {
    if !moves(expr, &view.agent.library) {
        let value = magnitude(&evaluate(expr, view).ok()?)?;
        return Some(Bounds { low: value, high: value });
    }
    let within = |part: &Expr| bounds(part, view, until);
    let found = match &expr.kind {
        ExprKind::Indexical(name) if is_clock(name) => rising(expr, view, until),
        ExprKind::Indexical(name) => view.agent.library.indexicals.get(name).and_then(within),
        ExprKind::Call { function, arguments } if function.is("elapsed") => match arguments.as_slice() {
            [since] if !moves(since, &view.agent.library) => rising(expr, view, until),
            _ => None,
        },
        ExprKind::Call { function, arguments } if !looks_back(function) => {
            let values: Option<Vec<Bounds>> = arguments.iter().map(within).collect();
            values.and_then(|values| call(function, &values))
        }
        ExprKind::If(test, then, otherwise) => {
            let (then, otherwise) = (within(then), otherwise.as_deref().and_then(within));
            match truth(test, view, until) {
                Some(true) => then,
                Some(false) => otherwise,
                None => then.zip(otherwise).map(|(then, otherwise)| then.both(otherwise)),
            }
        }
        _ => None,
    };
    Some(found.unwrap_or(Bounds::ANY))
}

/// Returns the bounds of an expression that never decreases, such as a clock.
fn rising(expr: &Expr, view: &View<'_>, until: Time) -> Option<Bounds> {
    let low = magnitude(&evaluate(expr, view).ok()?)?;
    let later = View { now: until, ..*view };
    let high = magnitude(&evaluate(expr, &later).ok()?)?;
    Some(Bounds { low, high }.widened())
}

fn magnitude(value: &Value) -> Option<f64> {
    match value {
        Value::Time(time) => Some(time.seconds()),
        other => other.as_number().map(|(number, _)| number).filter(|number| number.is_finite()),
    }
}

/// Returns the bounds of a call from those of its arguments; `None` for functions that are not known here.
fn call(function: &Symbol, values: &[Bounds]) -> Option<Bounds> {
    let first = *values.first()?;
    let fold = |combine: fn(Bounds, Bounds) -> Bounds| {
        let rest = values.iter().skip(1).copied();
        rest.fold(first, |sum, each| combine(sum, each).widened())
    };
    let known = values.iter().all(|each| each.low.is_finite() && each.high.is_finite());
    Some(match function.folded() {
        _ if !known => return None,
        "+" => fold(|a, b| Bounds { low: a.low + b.low, high: a.high + b.high }),
        "-" if values.len() == 1 => Bounds { low: -first.high, high: -first.low },
        "-" => fold(|a, b| Bounds { low: a.low - b.high, high: a.high - b.low }),
        "*" => fold(times),
        "/" if values.iter().skip(1).all(|each| each.low > 0.0 || each.high < 0.0) && values.len() > 1 => {
            fold(|a, b| times(a, Bounds::of(&[1.0 / b.low, 1.0 / b.high])))
        }
        "min" => fold(|a, b| Bounds { low: a.low.min(b.low), high: a.high.min(b.high) }),
        "max" => fold(Bounds::greater),
        "abs" if first.low >= 0.0 => first,
        "abs" => {
            Bounds { low: if first.high < 0.0 { -first.high } else { 0.0 }, high: first.low.abs().max(first.high) }
        }
        "sqrt" if first.low >= 0.0 => Bounds { low: libm::sqrt(first.low), high: libm::sqrt(first.high) }.widened(),
        "exp" => Bounds { low: libm::exp(first.low), high: libm::exp(first.high) }.widened(),
        "log" if values.len() == 1 && first.low > 0.0 => {
            Bounds { low: libm::log(first.low), high: libm::log(first.high) }.widened()
        }
        _ => return None,
    })
}

fn times(a: Bounds, b: Bounds) -> Bounds {
    Bounds::of(&[a.low * b.low, a.low * b.high, a.high * b.low, a.high * b.high])
}

/// Returns the truth of a test that cannot change; `None` if it may change or is unknown.
fn truth(test: &Expr, view: &View<'_>, until: Time) -> Option<bool> {
    if !moves(test, &view.agent.library) {
        return Some(evaluate(test, view).ok()?.is_true());
    }
    match &test.kind {
        ExprKind::And(parts) => all(parts.iter().map(|part| truth(part, view, until)), true),
        ExprKind::Or(parts) => all(parts.iter().map(|part| truth(part, view, until)), false),
        ExprKind::Call { function, arguments } => match arguments.as_slice() {
            [part] if function.is("not") => truth(part, view, until).map(|truth| !truth),
            [a, b] => {
                let (a, b) = (bounds(a, view, until)?, bounds(b, view, until)?);
                match function.folded() {
                    "<" => decided(a.high < b.low, a.low >= b.high),
                    "<=" => decided(a.high <= b.low, a.low > b.high),
                    ">" => decided(a.low > b.high, a.high <= b.low),
                    ">=" => decided(a.low >= b.high, a.high < b.low),
                    _ => None,
                }
            }
            _ => None,
        },
        _ => None,
    }
}

fn decided(yes: bool, no: bool) -> Option<bool> {
    (yes || no).then_some(yes)
}

/// Returns true if all parts are `value`, false if one is not, and `None` if that is not known.
fn all(mut parts: impl Iterator<Item = Option<bool>>, value: bool) -> Option<bool> {
    parts
        .try_fold(Some(value), |so_far, part| match part {
            Some(truth) if truth != value => Err(!value),
            Some(_) => Ok(so_far),
            None => Ok(None),
        })
        .unwrap_or_else(Some)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn symbol(name: &str) -> Symbol {
        Symbol::new(name)
    }

    #[test]
    fn a_product_of_mixed_signs_is_between_its_corners() {
        let (a, b) = (Bounds { low: -2.0, high: 3.0 }, Bounds { low: -5.0, high: 1.0 });
        let product = call(&symbol("*"), &[a, b]).unwrap_or(Bounds::ANY);
        assert!((product.low + 15.0).abs() < 1e-9 && (product.high - 10.0).abs() < 1e-9, "{product:?}");
    }

    #[test]
    fn what_is_divided_by_something_around_zero_is_not_known() {
        let (a, b) = (Bounds { low: 1.0, high: 1.0 }, Bounds { low: -1.0, high: 1.0 });
        assert_eq!(call(&symbol("/"), &[a, b]), None);
        let c = Bounds { low: 2.0, high: 4.0 };
        let quotient = call(&symbol("/"), &[a, c]).unwrap_or(Bounds::ANY);
        assert!(quotient.low <= 0.25 && quotient.high >= 0.5 && quotient.high < 0.51);
    }
}
