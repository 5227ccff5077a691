//! Objects of state variables that are named once and resemble another object of the same variable, which is named several times.

use super::walk;
use crate::codes;
use crate::diagnostic::{Diagnostic, Severity};
use crate::locate::Locator;
use crate::suggest::{meant, renames};
use apex_model::condition::VariablePattern;
use apex_model::expression::{Expr, ExprKind};
use apex_model::library::{Library, RESOURCE_LEVEL};
use apex_model::pattern::Pattern;
use apex_model::source::Place;
use apex_model::symbol::Symbol;
use apex_model::value::Value;
use std::collections::BTreeMap;

/// Places of the objects of one state variable.
type ObjectPlaces<'l> = BTreeMap<&'l Symbol, Vec<Place>>;

/// Returns all findings in the library.
pub(super) fn findings(library: &Library) -> Vec<Diagnostic> {
    let mut report = (Locator::new(&library.sources), Vec::new());
    // The names of resources are compared with their declarations.
    for (attribute, objects) in objects(library).into_iter().filter(|(attribute, _)| !attribute.is(RESOURCE_LEVEL)) {
        for (name, places) in &objects {
            let [place] = places.as_slice() else { continue };
            let often = objects.iter().filter(|(_, places)| places.len() > 1).map(|(object, _)| object.printed());
            let Some(known) = meant(name, often) else { continue };
            let span = report.0.word(*place, name);
            let message = format!("`{name}` is named once as an object of `{attribute}`, and `{known}` several times");
            let diagnostic = Diagnostic::new(Severity::Warning, codes::RESEMBLES, span, message)
                .reason("each object has its own samples, so a misspelt one has none")
                .fixes(renames(span, name.printed(), [known]));
            report.1.push(diagnostic);
        }
    }
    report.1
}

/// Returns the objects that conditions and queries name as words, by state variable.
fn objects<'l>(library: &'l Library) -> BTreeMap<&'l Symbol, ObjectPlaces<'l>> {
    let mut all: BTreeMap<&Symbol, ObjectPlaces<'_>> = BTreeMap::new();
    let mut add = |attribute: &'l Symbol, object: &'l Value, place| {
        if let Value::Symbol(name) = object {
            all.entry(attribute).or_default().entry(name).or_default().push(place);
        }
    };
    for procedure in &library.procedures {
        walk::conditions_of(procedure, &mut |condition| {
            if let Some(VariablePattern { attribute, object: Pattern::Literal(object) }) = walk::variable_of(condition)
            {
                add(attribute, object, condition.place);
            }
        });
    }
    walk::library(library, &mut |expr| {
        if let ExprKind::Call { function, arguments } = &expr.kind
            && walk::QUERIES.contains(&function.folded())
            && let [Expr { kind: ExprKind::Constant(Value::Symbol(attribute)), .. }, object, ..] = arguments.as_slice()
            && let ExprKind::Constant(object) = &object.kind
        {
            add(attribute, object, expr.place);
        }
    });
    all
}
