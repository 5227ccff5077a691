//! Calls of functions: resolution, arity, purity, function-valued arguments, literal dimensions.

use super::expected::{Expected, ExpectedKind, dimension_of, zero_of};
use super::{Callable, Lowering, NameKind};
use crate::codes;
use crate::diagnostic::{Diagnostic, Span};
use crate::fix::Fix;
use crate::read::{Datum, DatumKind};
use crate::suggest::{nearest, renames, renames_marked};
use apex_model::builtins::{SPECIAL_FORMS, built_in};
use apex_model::expression::{Expr, ExprKind};
use apex_model::quantity::Dimension;
use apex_model::symbol::Symbol;
use apex_model::time::Duration;
use apex_model::value::Value;

/// Functions whose first argument is a function.
const FUNCTION_FIRST: &[&str] =
    &["apply", "every", "find-if", "funcall", "mapcar", "reduce", "remove-if", "remove-if-not", "some"];
/// Functions whose first argument is a datum with holes.
const FORM_FIRST: &[&str] = &["cogevent", "command", "inform", "publish"];
/// Functions whose numeric arguments must have the same dimension.
const ONE_DIMENSION: &[&str] = &["+", "-", "/=", "<", "<=", "=", ">", ">=", "max", "min", "mod", "rem"];

/// Maximum number of reported unknown names, because each needs a search for suggestions.
const UNKNOWN_NAMES_MAX: usize = 100;

/// Words that authors write for functions with another name.
const MEANT: &[(&str, &str)] = &[("set", "setq"), ("setf", "setq"), ("say", "print"), ("write-line", "print")];

impl Lowering {
    /// Lowers `(name argument..)`.
    pub(crate) fn call(&mut self, datum: &Datum, name: &Symbol, at: Span, arguments: &[Datum]) -> Option<Expr> {
        if SPECIAL_FORMS.binary_search(&name.folded()).is_ok() {
            return self.special_form(datum, name, arguments);
        }
        let function = self.resolve_call(name, at, datum.span, arguments.len());
        let canonical = function.clone().unwrap_or_else(|| name.clone());
        // The form of a misspelt `command` is still read as a form, so that one mistake gives one message.
        let is_unknown = self.names.function(name).is_none();
        let meant = is_unknown.then(|| nearest(name.printed(), FORM_FIRST.iter().copied())).flatten().map(Symbol::new);
        let mut lowered = Vec::with_capacity(arguments.len());
        let mut complete = function.is_some();
        for (position, argument) in arguments.iter().enumerate() {
            match self.argument(meant.as_ref().unwrap_or(&canonical), position, arguments, argument) {
                Some(expr) => lowered.push(expr),
                None => complete = false,
            }
        }
        if !complete {
            return None;
        }
        self.check_keywords(&canonical, arguments)?;
        if ONE_DIMENSION.contains(&canonical.folded()) {
            self.one_dimension(&canonical, arguments, &mut lowered)?;
        }
        self.no_zero_divisor(&canonical, arguments)?;
        if canonical.is("command")
            && let Some(at) = arguments.iter().position(|argument| argument.is(":timeout"))
            && let (Some(limit), Some(datum)) = (lowered.get_mut(at + 1), arguments.get(at + 1))
        {
            let expected = Expected::plain("this timeout", ExpectedKind::Duration);
            *limit = self.conform(limit.clone(), datum.span, &expected)?;
            if let ExprKind::Constant(Value::Duration(length)) = &limit.kind
                && *length <= Duration::ZERO
            {
                let diagnostic =
                    Diagnostic::error(codes::MALFORMED, datum.span, "this timeout is not greater than zero");
                return self.refuse(diagnostic.reason("the command would fail at once"));
            }
        }
        let kind = ExprKind::Call { function: canonical, arguments: lowered };
        Some(Expr { kind, place: datum.span.place() })
    }

    /// Refuses a division by a zero that is written as such.
    fn no_zero_divisor(&mut self, function: &Symbol, arguments: &[Datum]) -> Option<()> {
        if !matches!(function.folded(), "/" | "mod" | "rem" | "floor" | "ceiling" | "round" | "truncate") {
            return Some(());
        }
        let is_zero = |datum: &&Datum| match datum.kind {
            DatumKind::Integer(number) => number == 0,
            DatumKind::Real(number) => number == 0.0,
            _ => false,
        };
        let Some(zero) = arguments.iter().skip(1).find(is_zero) else { return Some(()) };
        self.refuse(Diagnostic::error(codes::OPERAND, zero.span, format!("`{function}` divides by zero")))
    }

    fn argument(&mut self, function: &Symbol, position: usize, all: &[Datum], datum: &Datum) -> Option<Expr> {
        let name = function.folded();
        let after_key = position > 0 && all.get(position - 1).is_some_and(|before| before.is(":key"));
        let wants_function =
            (position == 0 && FUNCTION_FIRST.contains(&name)) || (name == "sort" && (position == 1 || after_key));
        if wants_function {
            return self.function_argument(datum);
        }
        if position == 0 && FORM_FIRST.contains(&name) {
            return self.form(datum);
        }
        match (name, position) {
            ("cogevent", 1) => self.use_name(NameKind::Agent, datum),
            ("inform", 1) | ("publish", 2) => self.use_name(NameKind::Router, datum),
            _ => {}
        }
        self.expression(datum)
    }

    /// Returns a function passed to `mapcar` and the like: `#'f`, `f`, `'f`, a lambda or an expression that returns one.
    fn function_argument(&mut self, datum: &Datum) -> Option<Expr> {
        match &datum.kind {
            DatumKind::Symbol(name) if !self.scope.is_local(name) => self.function_value(datum),
            DatumKind::Quote(inner) if inner.as_symbol().is_some() => self.function_value(inner),
            _ => self.expression(datum),
        }
    }

    /// Lowers `#'name` or `#'(lambda ..)`.
    pub(crate) fn function_value(&mut self, datum: &Datum) -> Option<Expr> {
        let Some(name) = datum.as_symbol() else {
            if datum.head_name() == "lambda" {
                return self.expression(datum);
            }
            let diagnostic =
                Diagnostic::error(codes::MALFORMED, datum.span, "a function name or a lambda is needed here");
            return self.refuse(diagnostic);
        };
        let canonical = self.resolve_name(name, datum.span)?.0;
        Some(Expr { kind: ExprKind::FunctionName(canonical), place: datum.span.place() })
    }

    /// Returns the stored name of the function called `name`; unknown names are collected, not reported at once.
    fn resolve_name(&mut self, name: &Symbol, at: Span) -> Option<(Symbol, Option<Callable>)> {
        let Some((canonical, callable)) = self.names.function(name) else {
            self.unknown_functions.entry(name.clone()).or_default().push(at);
            return Some((name.clone(), None));
        };
        self.called.insert(canonical.clone());
        if !callable.pure {
            self.had_effect = true;
            if let Some(place) = self.pure_in {
                let mut diagnostic =
                    Diagnostic::error(codes::IMPURE, at, format!("`{name}` has effects and is not allowed in {place}"))
                        .reason("it would act each time the value is evaluated")
                        .help("call it in a hook (on-start, on-end, ..) or make it a separate step");
                if let Some(definition) = callable.place {
                    diagnostic = diagnostic.label(definition, "defined here");
                }
                return self.refuse(diagnostic);
            }
        }
        Some((canonical, Some(callable)))
    }

    /// Resolves and checks the number of arguments.
    pub(crate) fn resolve_call(&mut self, name: &Symbol, at: Span, whole: Span, count: usize) -> Option<Symbol> {
        let (canonical, callable) = self.resolve_name(name, at)?;
        let Some(callable) = callable else { return Some(canonical) };
        if count >= callable.min && callable.max.is_none_or(|max| count <= max) {
            return Some(canonical);
        }
        let wanted = match callable.max {
            Some(max) if max == callable.min => format!("{max}"),
            Some(max) => format!("{} to {max}", callable.min),
            None => format!("at least {}", callable.min),
        };
        let plural = if wanted == "1" || wanted == "at least 1" { "" } else { "s" };
        let message = format!("`{name}` takes {wanted} argument{plural}, not {count}");
        let mut diagnostic = Diagnostic::error(codes::ARITY, whole, message);
        if let Some(found) = built_in(canonical.folded()) {
            diagnostic = diagnostic.help(format!("({} ..): {}", found.name, found.summary));
        }
        if let Some(definition) = callable.place {
            diagnostic = diagnostic.label(definition, "defined here");
        }
        self.refuse(diagnostic)
    }

    /// Returns a predicate named in a pattern or constraint, called with `count` arguments.
    pub(crate) fn predicate(&mut self, name: &Symbol, at: Span, count: usize) -> Option<Symbol> {
        self.pure("a pattern or condition", |lowering| lowering.resolve_call(name, at, at, count))
    }

    fn check_keywords(&mut self, function: &Symbol, arguments: &[Datum]) -> Option<()> {
        let allowed = match function.folded() {
            "most-recent-svvalue" => ":prior-to",
            "sort" => ":key",
            "command" => ":timeout",
            _ => return Some(()),
        };
        for argument in arguments.iter().skip(1) {
            if let Some(keyword) = argument.keyword()
                && !argument.is(allowed)
            {
                let message = format!("`{function}` has no option `:{keyword}`");
                let diagnostic = Diagnostic::error(codes::UNKNOWN_OPTION, argument.span, message)
                    .help(format!("it knows `{allowed}`"));
                return self.refuse(diagnostic);
            }
        }
        Some(())
    }

    /// Checks that literal dimensions of the arguments agree; a literal 0 is zero of any dimension.
    fn one_dimension(&mut self, function: &Symbol, data: &[Datum], arguments: &mut [Expr]) -> Option<()> {
        let known: Vec<Option<Dimension>> = arguments.iter().map(dimension_of).collect();
        let Some(wanted) = known.iter().flatten().copied().find(|dimension| *dimension != Dimension::NONE) else {
            return Some(());
        };
        let place = data.iter().zip(&known).find(|(_, dimension)| **dimension == Some(wanted)).map(|(datum, _)| datum);
        for ((datum, argument), dimension) in data.iter().zip(arguments.iter_mut()).zip(&known) {
            let Some(dimension) = dimension.filter(|dimension| *dimension != wanted) else { continue };
            if let Some(zero) = zero_of(argument, wanted) {
                argument.kind = ExprKind::Constant(zero);
                continue;
            }
            let message = format!("cannot apply `{function}` to {wanted} and {dimension}");
            let mut diagnostic = Diagnostic::error(codes::DIMENSION, datum.span, message)
                .reason("only values of one dimension can be added or compared");
            if let Some(place) = place {
                diagnostic = diagnostic.label(place.span, format!("this is {wanted}"));
            }
            if dimension == Dimension::NONE {
                diagnostic = diagnostic.help("write the number with its unit");
            }
            return self.refuse(diagnostic);
        }
        Some(())
    }

    /// Reports functions and indexicals that nothing defines, each name once.
    pub(crate) fn report_unknown_names(&mut self) {
        let severity = self.undefined();
        let functions = std::mem::take(&mut self.unknown_functions);
        for (name, uses) in functions.iter().take(UNKNOWN_NAMES_MAX) {
            let Some((first, others)) = uses.split_first() else { continue };
            let fixes = match MEANT.iter().find(|(word, _)| name.is(word)) {
                Some((_, own)) => vec![Fix::look(format!("replace `{name}` by `{own}`")).replace(*first, *own)],
                None => renames(*first, name.printed(), self.names.operators()),
            };
            let message = format!("no function is called `{name}`");
            let mut diagnostic = Diagnostic::new(severity, codes::UNKNOWN_FUNCTION, *first, message).fixes(fixes);
            for other in others.iter().take(2) {
                diagnostic = diagnostic.label(*other, "used here, too");
            }
            if diagnostic.fixes.is_empty() {
                diagnostic = diagnostic
                    .help(format!("define it: `(defun {name} ..)`, or declare a function of the host program: `(declare-function ({name} ..))`"))
                    .help("to mean a list of data, quote it: '(..)");
            }
            self.report(diagnostic);
        }
        let indexicals = std::mem::take(&mut self.unknown_indexicals);
        for (name, uses) in indexicals.iter().take(UNKNOWN_NAMES_MAX) {
            let Some((first, others)) = uses.split_first() else { continue };
            let known = self.names.indexical_names();
            let fixes = renames_marked(*first, name.printed(), known, |name| format!("+{name}+"));
            let message = format!("no indexical is called `+{name}+`");
            let mut diagnostic = Diagnostic::new(severity, codes::UNKNOWN_INDEXICAL, *first, message);
            diagnostic = diagnostic.fixes_or_help(fixes, || format!("define it: `(defindexical +{name}+ EXPRESSION)`"));
            for other in others.iter().take(2) {
                diagnostic = diagnostic.label(*other, "used here, too");
            }
            self.report(diagnostic);
        }
    }
}
