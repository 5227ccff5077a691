//! Measurements that a program publishes, `(publish (ATTRIBUTE OBJECT) VALUE)` or as messages, `(inform (ATTRIBUTE OBJECT = VALUE))`,
//! against the declared state variables.

use super::kinds::{Kind, Kinds, is_zero};
use super::walk;
use crate::codes;
use crate::diagnostic::{Diagnostic, Severity};
use crate::locate::Locator;
use crate::matching::View;
use crate::suggest::{meant, renames};
use apex_model::expression::{Expr, ExprKind, Template};
use apex_model::library::Library;
use apex_model::procedure::{Activity, BuiltInActivity};
use apex_model::quantity::Dimension;
use apex_model::symbol::Symbol;
use apex_model::value::Value;
use std::collections::BTreeSet;

/// The places of forms, and the findings.
type FindingsWithPlaces<'l> = (Locator<'l>, Vec<Diagnostic>);

/// Returns all findings in the library.
pub(super) fn findings(library: &Library) -> Vec<Diagnostic> {
    let mut report = (Locator::new(&library.sources), Vec::new());
    for step in library.procedures.iter().flat_map(|procedure| &procedure.steps) {
        if let Activity::BuiltIn(BuiltInActivity::Inform | BuiltInActivity::Cogevent, arguments) = &step.activity {
            arguments.first().into_iter().for_each(|form| message(library, form, &mut report));
        }
    }
    let read = attributes_read(library);
    walk::library(library, &mut |expr| {
        if let ExprKind::Call { function, arguments } = &expr.kind
            && let ("publish", [variable, value, ..]) = (function.folded(), arguments.as_slice())
        {
            publish(library, &read, (variable, value), &mut report);
        }
        if let ExprKind::Call { function, arguments } = &expr.kind
            && matches!(function.folded(), "inform" | "cogevent" | "publish")
        {
            arguments.first().into_iter().for_each(|form| message(library, form, &mut report));
        }
    });
    report.1
}

/// Returns the attributes that conditions, queries and derivations read.
fn attributes_read(library: &Library) -> BTreeSet<&Symbol> {
    let mut read: BTreeSet<&Symbol> =
        library.derivations.values().flat_map(|each| &each.inputs).map(|input| &input.attribute).collect();
    for procedure in &library.procedures {
        walk::conditions_of(procedure, &mut |condition| {
            read.extend(walk::variable_of(condition).map(|variable| &variable.attribute));
        });
    }
    walk::library(library, &mut |expr| {
        if let ExprKind::Call { function, arguments } = &expr.kind
            && walk::QUERIES.contains(&function.folded())
            && let Some(Expr { kind: ExprKind::Constant(Value::Symbol(attribute)), .. }) = arguments.first()
        {
            read.insert(attribute);
        }
    });
    read
}

/// Checks `(publish (ATTRIBUTE OBJECT) VALUE)`.
fn publish(
    library: &Library,
    read: &BTreeSet<&Symbol>,
    (variable, value): (&Expr, &Expr),
    report: &mut FindingsWithPlaces<'_>,
) {
    let Some(items) = view_of(variable).and_then(View::items) else { return };
    let Some(attribute) = items.first().and_then(|item| item.value()?.as_symbol()) else { return };
    // An attribute that something reads is meant as it is written.
    if read.contains(attribute) || is_known(library, attribute, variable, report) {
        let kind = if is_zero(value) { Kind::Unknown } else { Kinds::of(library, value) };
        value_of_kind(library, attribute, value, kind, report);
    }
}

/// Returns a view of a form with constant and computed parts; `None` for an expression that is computed as a whole.
pub(super) fn view_of(form: &Expr) -> Option<View<'_>> {
    match &form.kind {
        ExprKind::Constant(value) => Some(View::Value(value)),
        ExprKind::Template(template) => Some(View::Template(template)),
        _ => None,
    }
}

/// Checks a message that has the form of a measurement.
fn message(library: &Library, form: &Expr, report: &mut FindingsWithPlaces<'_>) {
    let Some(items) = view_of(form).and_then(View::items) else { return };
    let is_equal = |item: &View<'_>| item.value().and_then(Value::as_symbol).is_some_and(|word| word.is("="));
    let Some(attribute) = items.first().and_then(|item| item.value()?.as_symbol()) else { return };
    match items.as_slice() {
        [_, equal, _] if is_equal(equal) => without_object(library, attribute, form, report),
        [_, _, equal, value] if is_equal(equal) => {
            if !is_known(library, attribute, form, report) {
                return;
            }
            value_of(library, attribute, (form, *value), report);
        }
        _ => {}
    }
}

/// Reports a measurement without an object: it would be a message that no condition on the state variable sees.
fn without_object(library: &Library, attribute: &Symbol, form: &Expr, report: &mut FindingsWithPlaces<'_>) {
    if !library.state_variables.contains_key(attribute) {
        return;
    }
    let message = format!("this measurement of `{attribute}` names no object");
    let diagnostic = Diagnostic::error(codes::MALFORMED, report.0.span(form.place), message)
        .reason("without an object it is a message of three words, and no state variable changes")
        .help(format!("write `({attribute} OBJECT = VALUE)`"));
    report.1.push(diagnostic);
}

/// Returns false if the state variable is not declared but another one with nearly this name is; reports that.
fn is_known(library: &Library, attribute: &Symbol, form: &Expr, report: &mut FindingsWithPlaces<'_>) -> bool {
    let declared = &library.state_variables;
    if declared.contains_key(attribute) {
        return true;
    }
    let span = report.0.word(form.place, attribute);
    if let Some(known) = meant(attribute, declared.keys().map(Symbol::printed)) {
        let message = format!("no state variable `{attribute}` is declared, but `{known}` is");
        let diagnostic = Diagnostic::new(Severity::Warning, codes::RESEMBLES, span, message)
            .reason("conditions on the declared one do not see this measurement")
            .fixes(renames(span, attribute.printed(), [known]));
        report.1.push(diagnostic);
    }
    false
}

/// Reports a value of another dimension or type than the declaration of the state variable has.
fn value_of(
    library: &Library,
    attribute: &Symbol,
    (form, value): (&Expr, View<'_>),
    report: &mut FindingsWithPlaces<'_>,
) {
    let found = match value {
        View::Template(Template::Hole(expr)) if is_zero(expr) => return,
        View::Template(Template::Hole(expr)) => Kinds::of(library, expr),
        _ => match value.value() {
            Some(Value::Symbol(_)) => Kind::Other("a name"),
            Some(Value::Text(_)) => Kind::Other("a text"),
            Some(value) => value.as_number().map_or(Kind::Unknown, |(_, dimension)| Kind::Number(dimension)),
            None => return,
        },
    };
    value_of_kind(library, attribute, form, found, report);
}

fn value_of_kind(library: &Library, attribute: &Symbol, form: &Expr, found: Kind, report: &mut FindingsWithPlaces<'_>) {
    let Some(declared) = library.state_variables.get(attribute) else { return };
    let is_number =
        declared.value_type.as_ref().is_some_and(|name| matches!(name.folded(), "real" | "integer" | "number"));
    if declared.unit.is_none() && !is_number {
        return;
    }
    let fits = match found {
        Kind::Unknown => true,
        // A bare number is in the variable's unit.
        Kind::Number(dimension) => {
            declared.unit.is_none() || dimension == declared.dimension || dimension == Dimension::NONE
        }
        Kind::Instant | Kind::Other(_) => false,
    };
    if fits {
        return;
    }
    let wanted = match &declared.value_type {
        Some(name) if declared.unit.is_none() => format!("of type {name}"),
        _ => Kind::Number(declared.dimension).words(),
    };
    let code = if matches!(found, Kind::Number(_)) { codes::DIMENSION } else { codes::VALUE_TYPE };
    let message = format!("`({attribute} ..)` is {wanted}, but this measurement is {}", found.words());
    let diagnostic = Diagnostic::error(code, report.0.span(form.place), message)
        .label(report.0.span(declared.place), format!("declared as {wanted} here"))
        .reason("the executive refuses samples of another dimension or type");
    report.1.push(diagnostic);
}
