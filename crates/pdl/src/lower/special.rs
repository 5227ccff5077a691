//! Special forms: `if cond case when unless and or let let* lambda setq incf decf push progn quote function`.

use super::Lowering;
use super::expression::constant;
use crate::codes;
use crate::diagnostic::Diagnostic;
use crate::read::{Datum, DatumKind};
use apex_model::expression::{Expr, ExprKind};
use apex_model::symbol::Symbol;
use apex_model::value::Value;

impl Lowering {
    /// Lowers a special form.
    pub(crate) fn special_form(&mut self, datum: &Datum, name: &Symbol, arguments: &[Datum]) -> Option<Expr> {
        let kind = match (name.folded(), arguments) {
            ("quote", [inner]) => ExprKind::Constant(inner.to_value()),
            ("function", [inner]) => return self.function_value(inner),
            ("if", [test, then]) => {
                let (test, then) = (self.expression(test), self.expression(then));
                ExprKind::If(Box::new(test?), Box::new(then?), None)
            }
            ("if", [test, then, otherwise]) => {
                let (test, then, otherwise) =
                    (self.expression(test), self.expression(then), self.expression(otherwise));
                ExprKind::If(Box::new(test?), Box::new(then?), Some(Box::new(otherwise?)))
            }
            ("when", [test, body @ ..]) => {
                let (test, body) = (self.expression(test), self.sequence(datum, body));
                ExprKind::If(Box::new(test?), Box::new(body?), None)
            }
            ("unless", [test, body @ ..]) => {
                let (test, body) = (self.expression(test), self.sequence(datum, body));
                let nil = constant(Value::nil(), datum.span);
                ExprKind::If(Box::new(test?), Box::new(nil), Some(Box::new(body?)))
            }
            ("and", parts) => ExprKind::And(self.body(parts)?),
            ("or", parts) => ExprKind::Or(self.body(parts)?),
            ("progn", body) => ExprKind::Sequence(self.body(body)?),
            ("cond", clauses) => ExprKind::Cond(self.all(clauses, Lowering::cond_clause)?),
            ("case", [key, clauses @ ..]) => {
                let (key, clauses) = (self.expression(key), self.all(clauses, Lowering::case_clause));
                ExprKind::Case(Box::new(key?), clauses?)
            }
            ("let", [bindings, body @ ..]) => self.let_form(false, bindings, body)?,
            ("let*", [bindings, body @ ..]) => self.let_form(true, bindings, body)?,
            ("lambda", [parameters, body @ ..]) => {
                let (parameters, body) = self.parameters_and_body(parameters, body)?;
                ExprKind::Lambda { parameters, body }
            }
            ("setq", [place, value]) => {
                let value = self.expression(value);
                return self.assign(datum, place, value?);
            }
            ("incf" | "decf", [place]) => return self.step_assign(datum, name, place, None),
            ("incf" | "decf", [place, by]) => return self.step_assign(datum, name, place, Some(by)),
            ("push", [item, place]) => {
                let (item, old) = (self.expression(item), self.expression(place));
                let call = ExprKind::Call { function: Symbol::new("cons"), arguments: vec![item?, old?] };
                return self.assign(datum, place, Expr { kind: call, place: datum.span.place() });
            }
            _ => return self.malformed_special(datum, name),
        };
        Some(Expr { kind, place: datum.span.place() })
    }

    fn malformed_special<T>(&mut self, datum: &Datum, name: &Symbol) -> Option<T> {
        let shape = match name.folded() {
            "quote" => "(quote DATUM)",
            "function" => "(function NAME)",
            "if" => "(if TEST THEN [ELSE])",
            "when" | "unless" => "(when TEST FORM..)",
            "case" => "(case KEY ((DATUM..) FORM..) .. [(otherwise FORM..)])",
            "let" | "let*" => "(let ((NAME VALUE)..) FORM..)",
            "lambda" => "(lambda (NAME..) FORM..)",
            "setq" => "(setq NAME VALUE)",
            "push" => "(push ITEM NAME)",
            _ => "(incf NAME [NUMBER])",
        };
        let diagnostic =
            Diagnostic::error(codes::MALFORMED, datum.span, format!("this `{name}` form has the wrong parts"))
                .help(format!("its shape is `{shape}`"));
        self.refuse(diagnostic)
    }

    fn sequence(&mut self, datum: &Datum, body: &[Datum]) -> Option<Expr> {
        let body = self.body(body)?;
        Some(Expr { kind: ExprKind::Sequence(body), place: datum.span.place() })
    }

    fn cond_clause(&mut self, clause: &Datum) -> Option<(Expr, Vec<Expr>)> {
        let Some((test, body)) = clause.as_list().and_then(<[Datum]>::split_first) else {
            let diagnostic = Diagnostic::error(codes::MALFORMED, clause.span, "a clause of `cond` is a list")
                .help("its shape is `(TEST FORM..)`");
            return self.refuse(diagnostic);
        };
        // `otherwise` is not a test of cond, but its author never means the symbol.
        let test =
            if test.is("otherwise") { Some(constant(Value::truth(true), test.span)) } else { self.expression(test) };
        let body = self.body(body);
        Some((test?, body?))
    }

    fn case_clause(&mut self, clause: &Datum) -> Option<(Vec<Value>, Vec<Expr>)> {
        let Some((keys, body)) = clause.as_list().and_then(<[Datum]>::split_first) else {
            let diagnostic = Diagnostic::error(codes::MALFORMED, clause.span, "a clause of `case` is a list")
                .help("its shape is `((DATUM..) FORM..)` or `(otherwise FORM..)`");
            return self.refuse(diagnostic);
        };
        let keys = match &keys.kind {
            DatumKind::Symbol(name) if name.is("otherwise") || name.is("t") => Vec::new(),
            DatumKind::List(items) => items.iter().map(Datum::to_value).collect(),
            _ => vec![keys.to_value()],
        };
        Some((keys, self.body(body)?))
    }

    fn let_form(&mut self, sequential: bool, bindings: &Datum, body: &[Datum]) -> Option<ExprKind> {
        let Some(items) = bindings.as_list() else {
            let diagnostic = Diagnostic::error(codes::MALFORMED, bindings.span, "the variables of a `let` are a list")
                .help("its shape is `(let ((NAME VALUE)..) FORM..)`");
            return self.refuse(diagnostic);
        };
        let depth = self.scope.locals.len();
        let mut lowered = Vec::new();
        let mut complete = true;
        for item in items {
            match self.let_binding(item) {
                Some((name, value)) => {
                    if sequential {
                        self.scope.locals.push(name.clone());
                    }
                    lowered.push((name, value));
                }
                None => complete = false,
            }
        }
        if !sequential {
            self.scope.locals.extend(lowered.iter().map(|(name, _)| name.clone()));
        }
        let body = self.body(body);
        self.scope.locals.truncate(depth);
        let body = body.filter(|_| complete)?;
        Some(ExprKind::Let { sequential, bindings: lowered, body })
    }

    fn let_binding(&mut self, item: &Datum) -> Option<(Symbol, Expr)> {
        if let Some(name) = local_name(item) {
            return Some((name, constant(Value::nil(), item.span)));
        }
        match item.as_list() {
            Some([name]) if local_name(name).is_some() => {
                local_name(name).map(|name| (name, constant(Value::nil(), item.span)))
            }
            Some([name, value]) if local_name(name).is_some() => {
                let value = self.expression(value)?;
                local_name(name).map(|name| (name, value))
            }
            _ => {
                let diagnostic =
                    Diagnostic::error(codes::MALFORMED, item.span, "this is not a variable with its value")
                        .help("its shape is `(NAME VALUE)`");
                self.refuse(diagnostic)
            }
        }
    }

    fn step_assign(&mut self, datum: &Datum, name: &Symbol, place: &Datum, by: Option<&Datum>) -> Option<Expr> {
        let old = self.expression(place);
        let by = match by {
            Some(by) => self.expression(by),
            None => Some(constant(Value::Integer(1), datum.span)),
        };
        let function = Symbol::new(if name.is("incf") { "+" } else { "-" });
        let sum = Expr { kind: ExprKind::Call { function, arguments: vec![old?, by?] }, place: datum.span.place() };
        self.assign(datum, place, sum)
    }

    fn assign(&mut self, datum: &Datum, place: &Datum, value: Expr) -> Option<Expr> {
        let Some(name) = local_name(place) else {
            let diagnostic = Diagnostic::error(codes::MALFORMED, place.span, "only a variable can be assigned")
                .help("write a name or `?name` here");
            return self.refuse(diagnostic);
        };
        if self.scope.is_local(&name) {
            let kind = ExprKind::Assign { name, of_task: false, value: Box::new(value) };
            return Some(Expr { kind, place: datum.span.place() });
        }
        let Some(name) = place.as_variable().cloned() else {
            let diagnostic =
                Diagnostic::error(codes::UNBOUND_VARIABLE, place.span, format!("no variable `{name}` here"))
                    .help(format!("write `?{name}` for a variable of the task, or bind it: `(let (({name} ..)) ..)`"));
            return self.refuse(diagnostic);
        };
        self.assign_task_variable(datum, place, name, value)
    }

    fn assign_task_variable(&mut self, datum: &Datum, place: &Datum, name: Symbol, value: Expr) -> Option<Expr> {
        self.had_effect = true;
        if let Some(where_) = self.pure_in {
            let message = format!("`?{name}` may not be assigned in {where_}");
            let diagnostic = Diagnostic::error(codes::IMPURE, datum.span, message)
                .reason("it would change each time the value is evaluated")
                .help("assign it in a hook (on-start, on-end, ..), or bind it with select or `=>`");
            return self.refuse(diagnostic);
        }
        if !self.scope.has_variables {
            self.variable(&name, false, place.span)?;
        }
        self.scope.bind_everywhere(&name, place.span);
        let kind = ExprKind::Assign { name, of_task: true, value: Box::new(value) };
        Some(Expr { kind, place: datum.span.place() })
    }
}

/// Returns the name of a parameter or `let` variable. A name written `?x` keeps its question mark, so that it differs from `x`.
pub(crate) fn local_name(datum: &Datum) -> Option<Symbol> {
    match &datum.kind {
        DatumKind::Symbol(name) if !name.folded().starts_with(':') && !name.is("t") => Some(name.clone()),
        DatumKind::Variable(name) => Some(Symbol::new(&format!("?{name}"))),
        _ => None,
    }
}
