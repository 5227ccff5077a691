//! Patterns (`pdl.md`, Patterns).

use super::Lowering;
use crate::codes;
use crate::diagnostic::Diagnostic;
use crate::read::{Datum, DatumKind};
use apex_model::expression::{Expr, ExprKind};
use apex_model::pattern::Pattern;
use apex_model::symbol::Symbol;
use apex_model::value::Value;

impl Lowering {
    /// Lowers a pattern and records the variables that it binds.
    pub(crate) fn pattern(&mut self, datum: &Datum) -> Option<Pattern> {
        let span = datum.span;
        match &datum.kind {
            DatumKind::Variable(name) => {
                if self.scope.in_condition && self.scope.is_result_of_another_step(name) {
                    // The variable belongs to the procedure: the condition cannot hold before that step has ended, instead of binding the
                    // variable to the first matching value.
                    self.scope.use_variable(name, span);
                    return Some(Pattern::BoundVariable(name.clone()));
                }
                self.scope.bind(name, span);
                Some(Pattern::Variable(name.clone()))
            }
            DatumKind::Bound(name) => {
                self.scope.use_variable(name, span);
                Some(Pattern::BoundVariable(name.clone()))
            }
            DatumKind::Anonymous => Some(Pattern::Anonymous),
            DatumKind::Indexical(name) => Some(match self.indexical(name, span) {
                ExprKind::Constant(value) => Pattern::Literal(value),
                kind => Pattern::Computed(Expr { kind, place: span.place() }),
            }),
            DatumKind::Unquote(inner) => {
                self.pure("a pattern", |lowering| lowering.expression(inner)).map(Pattern::Computed)
            }
            DatumKind::Quote(inner) => Some(Pattern::Literal(inner.to_value())),
            DatumKind::Quasi(inner) => self.pattern(inner),
            DatumKind::List(items) => self.list_pattern(datum, items),
            DatumKind::Splice(_) | DatumKind::Function(_) => {
                let diagnostic = Diagnostic::error(codes::MALFORMED, span, "this is not allowed in a pattern");
                self.refuse(diagnostic)
            }
            _ => Some(Pattern::Literal(datum.to_value())),
        }
    }

    fn list_pattern(&mut self, datum: &Datum, items: &[Datum]) -> Option<Pattern> {
        if let Some((Datum { kind: DatumKind::Variable(head), .. }, arguments)) = items.split_first()
            && is_operator(head)
        {
            return self.operator_pattern(datum, head, arguments);
        }
        let parts = self.all(items, Lowering::pattern)?;
        if parts.iter().all(|part| matches!(part, Pattern::Literal(_))) {
            let values = parts.into_iter().filter_map(|part| match part {
                Pattern::Literal(value) => Some(value),
                _ => None,
            });
            return Some(Pattern::Literal(Value::list(values)));
        }
        Some(Pattern::List(parts))
    }

    fn operator_pattern(&mut self, datum: &Datum, head: &Symbol, arguments: &[Datum]) -> Option<Pattern> {
        let segment = |variable, minimum, maximum| Some(Pattern::Segment { variable, minimum, maximum });
        match (head.folded(), arguments) {
            ("*", []) => segment(None, 0, None),
            ("+", []) => segment(None, 1, None),
            ("?", []) => segment(None, 0, Some(1)),
            ("*" | "+" | "?", [Datum { kind: DatumKind::Variable(name), span }]) => {
                self.scope.bind(name, *span);
                let variable = Some(name.clone());
                match head.folded() {
                    "*" => segment(variable, 0, None),
                    "+" => segment(variable, 1, None),
                    _ => segment(variable, 0, Some(1)),
                }
            }
            ("*" | "+" | "?", [Datum { kind: DatumKind::Anonymous, .. }]) => self.operator_pattern(datum, head, &[]),
            ("if", [test]) => self.pure("a pattern", |lowering| lowering.expression(test)).map(Pattern::Guard),
            ("is", [Datum { kind: DatumKind::Variable(name), span }, predicate]) => {
                let Some(predicate) = function_name(predicate) else { return self.malformed_pattern(datum, head) };
                self.scope.bind(name, *span);
                let predicate = self.predicate(predicate, datum.span, 1)?;
                Some(Pattern::Is { variable: name.clone(), predicate })
            }
            ("and", parts) if !parts.is_empty() => self.all(parts, Lowering::pattern).map(Pattern::And),
            ("or", parts) if !parts.is_empty() => self.all(parts, Lowering::pattern).map(Pattern::Or),
            ("not", [part]) => self.pattern(part).map(|pattern| Pattern::Not(Box::new(pattern))),
            _ => self.malformed_pattern(datum, head),
        }
    }

    fn malformed_pattern<T>(&mut self, datum: &Datum, head: &Symbol) -> Option<T> {
        let shape = match head.folded() {
            "if" => "(?if EXPRESSION)",
            "is" => "(?is ?variable predicate)",
            "and" | "or" => "(?and PATTERN..)",
            "not" => "(?not PATTERN)",
            _ => "(?* ?variable)",
        };
        let diagnostic =
            Diagnostic::error(codes::MALFORMED, datum.span, format!("this `?{head}` pattern has the wrong parts"))
                .help(format!("its shape is `{shape}`"));
        self.refuse(diagnostic)
    }
}

fn is_operator(name: &Symbol) -> bool {
    matches!(name.folded(), "*" | "+" | "?" | "if" | "is" | "and" | "or" | "not")
}

/// Returns a function's name, plain or as `#'name` or `'name`.
pub(crate) fn function_name(datum: &Datum) -> Option<&Symbol> {
    match &datum.kind {
        DatumKind::Function(inner) | DatumKind::Quote(inner) => inner.as_symbol(),
        _ => datum.as_symbol(),
    }
}
