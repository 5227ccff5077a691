//! Constants: literals are known when the text is loaded; others are computed once, when an agent is loaded.

use super::{Lowering, Scope};
use crate::codes;
use crate::diagnostic::{Diagnostic, Span};
use crate::read::{Datum, DatumKind};
use apex_model::builtins::CHANGING;
use apex_model::expression::Expr;
use apex_model::library::Library;
use apex_model::symbol::Symbol;
use std::collections::{BTreeMap, BTreeSet};

const SHAPE: &str = "(defconstant NAME EXPRESSION)";

impl Lowering {
    /// Records a constant. A literal one has its value at once.
    pub(crate) fn collect_constant(&mut self, form: &Datum) -> Option<()> {
        let [name, value] = form.tail() else {
            return self.missing_part(form.span, "this `defconstant` has the wrong parts", SHAPE);
        };
        let Some(symbol) = constant_name(name) else {
            return self.missing_part(name.span, "a constant's name is a symbol", SHAPE);
        };
        let literal = self.names.constants.get(&symbol).map(|(_, span)| *span);
        let first = literal.or_else(|| self.names.computed.get(&symbol).copied());
        self.define(symbol.printed(), first, name.span)?;
        match &value.kind {
            DatumKind::Quote(inner) => {
                self.names.constants.insert(symbol, (inner.to_value(), name.span));
            }
            _ if is_computed(value) => {
                self.names.computed.insert(symbol, name.span);
            }
            _ => {
                self.names.constants.insert(symbol, (value.to_value(), name.span));
            }
        }
        Some(())
    }

    /// Lowers the computed constants. `changing` are the functions that depend on more than their arguments.
    pub(crate) fn computed_constants<'d>(
        &mut self,
        forms: impl Iterator<Item = &'d Datum>,
        callers: &BTreeMap<Symbol, Vec<Symbol>>,
        library: &mut Library,
    ) {
        let changing = changing_functions(callers);
        let mut uses: BTreeMap<Symbol, (BTreeSet<Symbol>, Span)> = BTreeMap::new();
        for form in forms.filter(|form| form.head_name() == "defconstant") {
            let [name, value] = form.tail() else { continue };
            let Some(symbol) = constant_name(name).filter(|name| self.names.computed.contains_key(name)) else {
                continue;
            };
            if let Some(expr) = self.constant_expression(value, &changing) {
                uses.insert(symbol.clone(), (std::mem::take(&mut self.constants_used), name.span));
                library.constants.insert(symbol, expr);
            }
        }
        self.refuse_circles(&uses);
    }

    fn constant_expression(&mut self, value: &Datum, changing: &BTreeSet<Symbol>) -> Option<Expr> {
        self.scope = Scope::default();
        self.called.clear();
        self.constants_used.clear();
        if let Some(found) = indexical_in(value).filter(|(name, _)| !self.names.computed_or_literal(name)) {
            let (name, span) = found;
            let diagnostic =
                Diagnostic::error(codes::MALFORMED, span, format!("`+{name}+` is not allowed in a constant"))
                    .reason("a constant has one value; an indexical is evaluated at each use")
                    .help("use `defindexical` for a value that changes");
            return self.refuse(diagnostic);
        }
        let expr = self.pure_expression(value, "a constant")?;
        if let Some(function) = self.called.iter().find(|name| changing.contains(*name)).cloned() {
            let message = format!("`{function}` may not be called for a constant");
            let diagnostic = Diagnostic::error(codes::MALFORMED, value.span, message)
                .reason("its value depends on the time or on what was measured; a constant has one value")
                .help("use `defindexical` for a value that changes");
            return self.refuse(diagnostic);
        }
        Some(expr)
    }

    /// Reports constants that are computed from themselves.
    fn refuse_circles(&mut self, uses: &BTreeMap<Symbol, (BTreeSet<Symbol>, Span)>) {
        for (name, (direct, span)) in uses {
            let mut open: Vec<&Symbol> = direct.iter().collect();
            let mut seen: BTreeSet<&Symbol> = BTreeSet::new();
            while let Some(next) = open.pop() {
                if seen.insert(next) {
                    open.extend(uses.get(next).into_iter().flat_map(|(names, _)| names));
                }
            }
            if seen.contains(name) {
                let message = format!("the constant `{name}` is computed from itself");
                self.report(
                    Diagnostic::error(codes::MALFORMED, *span, message).help("give one of them a literal value"),
                );
            }
        }
    }
}

fn constant_name(datum: &Datum) -> Option<Symbol> {
    match &datum.kind {
        DatumKind::Symbol(symbol) => Some(symbol.clone()),
        DatumKind::Indexical(inner) => Some(Symbol::new(&format!("+{inner}+"))),
        _ => None,
    }
}

/// Returns true if the value must be computed: a list that begins with a number or a string is data, for example a location.
fn is_computed(value: &Datum) -> bool {
    match &value.kind {
        DatumKind::List(items) if items.first().is_some_and(|head| head.as_symbol().is_some()) => true,
        _ => value.has_holes(),
    }
}

/// Returns the first indexical that is evaluated with `value`.
fn indexical_in(value: &Datum) -> Option<(Symbol, Span)> {
    match &value.kind {
        DatumKind::Indexical(name) => Some((name.clone(), value.span)),
        DatumKind::List(items) => items.iter().find_map(indexical_in),
        DatumKind::Quasi(inner) | DatumKind::Unquote(inner) | DatumKind::Splice(inner) => indexical_in(inner),
        _ => None,
    }
}

/// Returns the functions whose values change with time, and those that call them.
fn changing_functions(callers: &BTreeMap<Symbol, Vec<Symbol>>) -> BTreeSet<Symbol> {
    let mut open: Vec<Symbol> = CHANGING.iter().map(|name| Symbol::new(name)).collect();
    let mut changing = BTreeSet::new();
    while let Some(name) = open.pop() {
        open.extend(callers.get(&name).into_iter().flatten().filter(|caller| !changing.contains(*caller)).cloned());
        changing.insert(name);
    }
    changing
}
