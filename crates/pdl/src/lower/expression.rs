//! Expressions (`pdl.md`, Forms): literals, variables, indexicals, quotation, lists as calls.

use super::Lowering;
use crate::codes;
use crate::diagnostic::{Diagnostic, Span};
use crate::read::{Datum, DatumKind, is_number_like_symbol, parse_unit_misspelt};
use apex_model::expression::{Expr, ExprKind, Template};
use apex_model::symbol::Symbol;
use apex_model::value::Value;

/// Returns a constant expression at `span`.
pub(crate) fn constant(value: Value, span: Span) -> Expr {
    Expr { kind: ExprKind::Constant(value), place: span.place() }
}

impl Lowering {
    /// Lowers one expression.
    pub(crate) fn expression(&mut self, datum: &Datum) -> Option<Expr> {
        let span = datum.span;
        let kind = match &datum.kind {
            DatumKind::Integer(_)
            | DatumKind::Real(_)
            | DatumKind::Quantity(_)
            | DatumKind::Duration(_)
            | DatumKind::Text(_) => ExprKind::Constant(datum.to_value()),
            DatumKind::Symbol(name) => self.symbol(name, span),
            DatumKind::Variable(name) => self.variable(name, false, span)?,
            DatumKind::Bound(name) => self.variable(name, true, span)?,
            DatumKind::Indexical(name) => self.indexical(name, span),
            DatumKind::List(items) => return self.list(datum, items),
            DatumKind::Quote(inner) => ExprKind::Constant(inner.to_value()),
            DatumKind::Quasi(inner) => return self.template_expression(inner),
            // An activity needs a comma here; in an expression everything is evaluated, so the comma is ignored.
            DatumKind::Unquote(inner) => return self.expression(inner),
            DatumKind::Function(inner) => return self.function_value(inner),
            DatumKind::Anonymous => {
                let diagnostic = Diagnostic::error(codes::MALFORMED, span, "`?` has no value")
                    .reason("the anonymous variable matches anything and binds nothing")
                    .help("give the variable a name where it is bound, and use that name here");
                return self.refuse(diagnostic);
            }
            DatumKind::Splice(_) => {
                let diagnostic = Diagnostic::error(codes::MALFORMED, span, "`,@` is used outside of a list template")
                    .help("use it inside of a backquoted list or an activity");
                return self.refuse(diagnostic);
            }
        };
        Some(Expr { kind, place: span.place() })
    }

    /// Lowers every expression of a body.
    pub(crate) fn body(&mut self, items: &[Datum]) -> Option<Vec<Expr>> {
        self.all(items, Lowering::expression)
    }

    fn symbol(&mut self, name: &Symbol, span: Span) -> ExprKind {
        if name.folded().starts_with(':') || name.is("t") {
            return ExprKind::Constant(Value::Symbol(name.clone()));
        }
        if self.scope.is_local(name) {
            return ExprKind::Local(name.clone());
        }
        if let Some((value, _)) = self.names.constants.get(name) {
            return ExprKind::Constant(value.clone());
        }
        if self.names.computed.contains_key(name) {
            self.constants_used.insert(name.clone());
            return ExprKind::Named(name.clone());
        }
        self.check_quantity_name(name, span);
        ExprKind::Constant(Value::Symbol(name.clone()))
    }

    /// Like [`Lowering::check_quantity_name`], for every name in data that are not checked otherwise.
    pub(crate) fn check_quantity_names(&mut self, datum: &Datum) {
        match &datum.kind {
            DatumKind::Symbol(name) => self.check_quantity_name(name, datum.span),
            DatumKind::List(items) => items.iter().for_each(|item| self.check_quantity_names(item)),
            _ => {}
        }
    }

    /// Warns of a name that begins with a number and was probably meant as a quantity.
    pub(crate) fn check_quantity_name(&mut self, name: &Symbol, span: Span) {
        if !is_number_like_symbol(name) {
            return;
        }
        let Some((number, suffix)) = parse_unit_misspelt(name) else { return };
        let message = format!("`{name}` is a name, not a quantity");
        let severity = crate::diagnostic::Severity::Warning;
        let mark = |unit: &str| format!("{number}{unit}");
        let diagnostic = Diagnostic::new(severity, codes::SYMBOL_LIKE_QUANTITY, span, message)
            .reason("what follows the number is not a known unit")
            .fixes(crate::suggest::unit_renames(span, &suffix, mark));
        self.report(diagnostic);
    }

    /// Lowers `?x` or `<?x>`: a parameter, or a variable of the task.
    pub(crate) fn variable(&mut self, name: &Symbol, must_be_bound: bool, span: Span) -> Option<ExprKind> {
        if !self.scope.locals.is_empty() {
            let local = Symbol::new(&format!("?{name}"));
            if self.scope.is_local(&local) {
                return Some(ExprKind::Local(local));
            }
        }
        if !self.scope.has_variables {
            let diagnostic = Diagnostic::error(codes::UNBOUND_VARIABLE, span, format!("nothing binds `?{name}`"))
                .reason("variables belong to tasks; a function or indexical sees its own parameters only")
                .help("hand the value over as a parameter");
            return self.refuse(diagnostic);
        }
        self.scope.use_variable(name, span);
        Some(ExprKind::Variable { name: name.clone(), must_be_bound })
    }

    /// Lowers `+name+`: a constant or an indexical.
    pub(crate) fn indexical(&mut self, name: &Symbol, span: Span) -> ExprKind {
        if !self.names.constants.is_empty() || !self.names.computed.is_empty() {
            let written = Symbol::new(&format!("+{name}+"));
            if let Some((value, _)) = self.names.constants.get(&written) {
                return ExprKind::Constant(value.clone());
            }
            if self.names.computed.contains_key(&written) {
                self.constants_used.insert(written.clone());
                return ExprKind::Named(written);
            }
        }
        if !self.names.is_indexical(name) {
            self.unknown_indexicals.entry(name.clone()).or_default().push(span);
        }
        ExprKind::Indexical(name.clone())
    }

    fn list(&mut self, datum: &Datum, items: &[Datum]) -> Option<Expr> {
        let Some((head, arguments)) = items.split_first() else {
            return Some(constant(Value::nil(), datum.span));
        };
        match &head.kind {
            DatumKind::Symbol(name) => self.call(datum, name, head.span, arguments),
            DatumKind::List(_) if head.head_name() == "lambda" => {
                let function = self.expression(head)?;
                let rest = self.body(arguments)?;
                let arguments = std::iter::once(function).chain(rest).collect();
                let kind = ExprKind::Call { function: Symbol::new("funcall"), arguments };
                Some(Expr { kind, place: datum.span.place() })
            }
            DatumKind::Integer(_) | DatumKind::Real(_) if matches!(arguments, [unit] if unit.as_symbol().is_some()) => {
                let word = arguments.first().and_then(Datum::as_symbol).map_or("", Symbol::printed);
                let unit_span = arguments.first().map_or(datum.span, |unit| unit.span);
                let diagnostic =
                    Diagnostic::error(codes::UNKNOWN_UNIT, datum.span, format!("`{word}` is not a known unit"))
                        .fixes(crate::suggest::unit_renames(unit_span, word, str::to_string))
                        .help("to mean the list itself, quote it: '(..)");
                self.refuse(diagnostic)
            }
            // A list that begins with a number, a string or a variable can only be data, for example a location.
            _ => self.template_expression(datum),
        }
    }

    /// Lowers `datum` as data with holes to an expression.
    pub(crate) fn template_expression(&mut self, datum: &Datum) -> Option<Expr> {
        let kind = match self.template(datum)? {
            Template::Constant(value) => ExprKind::Constant(value),
            Template::Hole(expr) => return Some(expr),
            template => ExprKind::Template(Box::new(template)),
        };
        Some(Expr { kind, place: datum.span.place() })
    }

    /// Returns an argument documented as FORM: a datum with holes unless it is quoted, backquoted or a variable.
    pub(crate) fn form(&mut self, datum: &Datum) -> Option<Expr> {
        match &datum.kind {
            DatumKind::List(_) | DatumKind::Symbol(_) => self.template_expression(datum),
            _ => self.expression(datum),
        }
    }
}
