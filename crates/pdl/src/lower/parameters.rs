//! Parameters of functions: `(a b &optional c (d 2) &rest others)`.

use super::Lowering;
use super::special::local_name;
use crate::codes;
use crate::diagnostic::Diagnostic;
use crate::fix::Fix;
use crate::read::Datum;
use apex_model::expression::{Expr, Parameters};
use apex_model::symbol::Symbol;

/// Part of a parameter list.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum ParameterKind {
    Required,
    Optional,
    Rest,
}

/// The marks between parameters.
const MARKS: &[(&str, ParameterKind)] =
    &[("&optional", ParameterKind::Optional), ("&rest", ParameterKind::Rest), ("&body", ParameterKind::Rest)];

/// Returns the least and greatest number of arguments that a list of parameters takes, before its expressions are checked.
pub(crate) fn argument_counts(parameters: &[Datum]) -> (usize, Option<usize>) {
    let mark = |item: &Datum| item.as_symbol().is_some_and(|name| name.folded().starts_with('&'));
    let least = parameters.iter().take_while(|item| !mark(item)).count();
    let rest = parameters.iter().any(|item| item.is("&rest") || item.is("&body"));
    let named = parameters.iter().filter(|item| !mark(item)).count();
    (least, (!rest).then_some(named))
}

impl Lowering {
    /// Lowers the parameters of a function, and its body with them in scope.
    pub(crate) fn parameters_and_body(
        &mut self,
        parameters: &Datum,
        body: &[Datum],
    ) -> Option<(Parameters, Vec<Expr>)> {
        let depth = self.scope.locals.len();
        let parameters = self.parameters(parameters);
        let body = parameters.and_then(|parameters| Some((parameters, self.body(body)?)));
        self.scope.locals.truncate(depth);
        body
    }

    /// Returns the parameters; their names are local variables from here on.
    fn parameters(&mut self, datum: &Datum) -> Option<Parameters> {
        let Some(items) = datum.as_list() else {
            let diagnostic = Diagnostic::error(codes::MALFORMED, datum.span, "parameters are a list of names");
            let diagnostic = match datum.as_symbol() {
                Some(name) => {
                    let fix = Fix::safe(format!("write `({name})`")).insert_before(datum.span, "(");
                    diagnostic.fix(fix.insert_after(datum.span, ")"))
                }
                None => diagnostic.help("write `()` for none"),
            };
            return self.refuse(diagnostic);
        };
        let mut parameters = Parameters::default();
        let mut part = ParameterKind::Required;
        for item in items {
            if let Some(mark) = item.as_symbol().filter(|name| name.folded().starts_with('&')) {
                part = self.mark(item, mark, part)?;
                continue;
            }
            let (name, default) = self.parameter(item, part)?;
            if parameters.names().any(|known| *known == name) {
                let message = format!("two parameters are called `{name}`");
                return self.refuse(Diagnostic::error(codes::MALFORMED, item.span, message));
            }
            self.scope.locals.push(name.clone());
            match part {
                ParameterKind::Required => parameters.required.push(name),
                ParameterKind::Optional => parameters.optional.push((name, default)),
                ParameterKind::Rest if parameters.rest.is_none() => parameters.rest = Some(name),
                ParameterKind::Rest => {
                    let diagnostic = Diagnostic::error(codes::MALFORMED, item.span, "nothing can follow `&rest NAME`")
                        .reason("it takes all arguments that are left");
                    return self.refuse(diagnostic);
                }
            }
        }
        if part == ParameterKind::Rest && parameters.rest.is_none() {
            return self.missing_part(datum.span, "`&rest` is followed by a name", "(NAME.. &rest NAME)");
        }
        Some(parameters)
    }

    fn mark(&mut self, item: &Datum, mark: &Symbol, before: ParameterKind) -> Option<ParameterKind> {
        let known = MARKS.iter().find(|(name, _)| mark.is(name)).map(|(_, part)| *part);
        match known {
            Some(part) if part > before => Some(part),
            Some(_) => {
                let diagnostic = Diagnostic::error(codes::MALFORMED, item.span, format!("`{mark}` comes too late"))
                    .help("the order is `(NAME.. &optional NAME.. &rest NAME)`, each mark once");
                self.refuse(diagnostic)
            }
            None => {
                let diagnostic = Diagnostic::error(codes::MALFORMED, item.span, format!("`{mark}` is not known here"))
                    .help("there are `&optional` and `&rest`");
                self.refuse(diagnostic)
            }
        }
    }

    /// Lowers a name, or an optional parameter with its default.
    fn parameter(&mut self, item: &Datum, part: ParameterKind) -> Option<(Symbol, Option<Expr>)> {
        if let Some(name) = local_name(item) {
            return Some((name, None));
        }
        match item.as_list() {
            Some([name, default]) if part == ParameterKind::Optional && local_name(name).is_some() => {
                let default = self.expression(default)?;
                local_name(name).map(|name| (name, Some(default)))
            }
            Some([name]) if part == ParameterKind::Optional => local_name(name).map(|name| (name, None)),
            _ => {
                let diagnostic = Diagnostic::error(codes::MALFORMED, item.span, "a parameter is a name")
                    .help("an optional parameter comes after `&optional`: `NAME` or `(NAME DEFAULT)`");
                self.refuse(diagnostic)
            }
        }
    }
}
