//! Constraints on values: `(op expr)`, ranges, predicates, tolerances (`conditions.md`, C).

use super::Lowering;
use super::apart::apart_from_unit;
use super::expected::{Expected, ExpectedKind};
use crate::codes;
use crate::diagnostic::{Diagnostic, Severity, Span};
use crate::read::{Datum, DatumKind};
use apex_model::condition::{Constraint, Relation};
use apex_model::expression::{Expr, ExprKind};
use apex_model::pattern::Pattern;
use apex_model::symbol::Symbol;
use apex_model::value::Value;

/// Returns the relation that a symbol names.
pub(crate) fn relation_named(datum: &Datum) -> Option<Relation> {
    match datum.as_symbol()?.folded() {
        "=" => Some(Relation::Equal),
        "/=" => Some(Relation::Different),
        "<" => Some(Relation::Less),
        "<=" => Some(Relation::LessOrEqual),
        ">" => Some(Relation::Greater),
        ">=" => Some(Relation::GreaterOrEqual),
        _ => None,
    }
}

impl Lowering {
    /// Lowers constraints that all must hold.
    pub(crate) fn constraints(&mut self, items: &[Datum], expected: &Expected) -> Option<Vec<Constraint>> {
        let groups = self.all(items, |lowering, item| lowering.constraint(item, expected))?;
        Some(groups.into_iter().flatten().collect())
    }

    /// Lowers one constraint; `(:and ..)` gives several.
    fn constraint(&mut self, datum: &Datum, expected: &Expected) -> Option<Vec<Constraint>> {
        let one = |constraint: Option<Constraint>| constraint.map(|constraint| vec![constraint]);
        let Some((head, arguments)) = datum.as_list().and_then(<[Datum]>::split_first) else {
            return self.malformed_constraint(datum);
        };
        if let Some(relation) = relation_named(head) {
            return one(self.comparison(relation, arguments, datum.span, expected));
        }
        match (head.as_symbol().map_or("", Symbol::folded), arguments) {
            (":and" | "and", parts) => self.constraints(parts, expected),
            (":range", [low, high]) => {
                let (low, high) = (self.bound(low, expected), self.bound(high, expected));
                one(Some(Constraint::Range(Some(low?), Some(high?))))
            }
            (":min", [low]) => one(self.bound(low, expected).map(|low| Constraint::Range(Some(low), None))),
            (":max", [high]) => one(self.bound(high, expected).map(|high| Constraint::Range(None, Some(high)))),
            ("or" | ":or" | "not" | ":not" | ":range" | ":min" | ":max" | "", _) => self.malformed_constraint(datum),
            (name, _) if name.starts_with(':') => self.malformed_constraint(datum),
            _ => {
                let name = head.as_symbol()?;
                let predicate = self.predicate(name, head.span, arguments.len() + 1);
                let arguments = self.pure("a condition", |lowering| lowering.body(arguments));
                one(Some(Constraint::Predicate(predicate?, arguments?)))
            }
        }
    }

    fn malformed_constraint<T>(&mut self, datum: &Datum) -> Option<T> {
        let diagnostic = Diagnostic::error(codes::MALFORMED_CONSTRAINT, datum.span, "this is not a constraint").help(
            "a constraint is `(> EXPR)`, `(= EXPR +/- TOLERANCE)`, `(:range A B)`, `(:min A)`, `(:max B)` or `(predicate)`",
        );
        self.refuse(diagnostic)
    }

    fn bound(&mut self, datum: &Datum, expected: &Expected) -> Option<Expr> {
        self.note_words(datum);
        let expr = self.pure("a condition", |lowering| lowering.right_side(datum, expected))?;
        self.conform(expr, datum.span, expected)
    }

    /// Returns the right side of a comparison. A rate may be written `(20 P1S)`: an amount per duration.
    fn right_side(&mut self, datum: &Datum, expected: &Expected) -> Option<Expr> {
        if let ExpectedKind::Rate(dimension, unit) = expected.kind
            && let Some([amount, per]) = datum.as_list()
            && let DatumKind::Duration(per_duration) = per.kind
        {
            let amount_expected = Expected { kind: ExpectedKind::Measured(dimension, unit), ..expected.clone() };
            let amount = self.bound(amount, &amount_expected)?;
            let place = datum.span.place();
            let per_s = per_duration.seconds();
            if let ExprKind::Constant(value) = &amount.kind
                && let Some((si, found)) = value.as_number()
                && per_s > 0.0
            {
                let rate = Value::measured(si / per_s, found.over(apex_model::quantity::Dimension::TIME));
                return Some(Expr { kind: ExprKind::Constant(rate), place });
            }
            let arguments =
                vec![amount, Expr { kind: ExprKind::Constant(Value::Duration(per_duration)), place: per.span.place() }];
            return Some(Expr { kind: ExprKind::Call { function: Symbol::new("/"), arguments }, place });
        }
        self.expression(datum)
    }

    /// Lowers `REL right [+/- tolerance]`, the relation already read.
    pub(crate) fn comparison(
        &mut self,
        relation: Relation,
        arguments: &[Datum],
        span: Span,
        expected: &Expected,
    ) -> Option<Constraint> {
        let (right, tolerance) = match arguments {
            [right] => (right, None),
            [right, mark, tolerance] if mark.is("+/-") => (right, Some(tolerance)),
            _ => {
                let diagnostic =
                    Diagnostic::error(codes::MALFORMED_CONSTRAINT, span, "a comparison has one right side")
                        .fixes(apart_from_unit(arguments))
                        .help("its shape is `REL EXPR` or `= EXPR +/- TOLERANCE`");
                return self.refuse(diagnostic);
            }
        };
        if tolerance.is_some() && relation != Relation::Equal {
            let diagnostic = Diagnostic::error(codes::MALFORMED_CONSTRAINT, span, "only `=` takes a tolerance")
                .help("include the tolerance in the limit");
            return self.refuse(diagnostic);
        }
        if relation == Relation::Equal && tolerance.is_none() && self.is_pattern(right) {
            return Some(match self.pattern(right)? {
                Pattern::Literal(value) => {
                    let right = super::expression::constant(value, right.span);
                    Constraint::Compare { relation, right, tolerance: None }
                }
                pattern => Constraint::Matches(pattern),
            });
        }
        let right_span = right.span;
        let right = self.bound(right, expected)?;
        let tolerance = match tolerance {
            Some(tolerance) => Some(self.bound(tolerance, expected)?),
            None => None,
        };
        if relation == Relation::Equal && tolerance.is_none() {
            self.warn_of_real_equality(&right, right_span, expected);
        }
        Some(Constraint::Compare { relation, right, tolerance })
    }

    /// Returns true for a right side of `=` that binds variables or describes a structure rather than computes a value.
    fn is_pattern(&self, datum: &Datum) -> bool {
        match &datum.kind {
            DatumKind::Variable(_) | DatumKind::Bound(_) | DatumKind::Anonymous => true,
            DatumKind::List(items) => match items.first().map(|head| &head.kind) {
                Some(DatumKind::Symbol(name)) => !self.names.is_operator(name),
                Some(DatumKind::Integer(_) | DatumKind::Real(_)) => {
                    !matches!(items.as_slice(), [_, unit] if unit.as_symbol().is_some())
                }
                _ => true,
            },
            _ => false,
        }
    }

    fn warn_of_real_equality(&mut self, right: &Expr, span: Span, expected: &Expected) {
        let ExprKind::Constant(value) = &right.kind else { return };
        let declared_real = expected.value_type.as_ref().is_some_and(|name| name.is("real"));
        let is_real = match value {
            Value::Real(_) | Value::Quantity(_) => expected.value_type.as_ref().is_none_or(|name| !name.is("integer")),
            Value::Integer(_) => declared_real,
            _ => false,
        };
        if is_real && !matches!(expected.kind, ExpectedKind::Anything | ExpectedKind::Instant) {
            let message = format!("real values of {} are compared for equality", expected.subject);
            let diagnostic = Diagnostic::new(Severity::Warning, codes::REAL_EQUALITY, span, message)
                .reason("measured reals are hardly ever exactly equal")
                .help(format!("allow a tolerance: `= {value} +/- ..`"));
            self.report(diagnostic);
        }
    }
}
