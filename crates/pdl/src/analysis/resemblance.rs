//! Names that need no definition but resemble another name: messages, state variables, resources. Inputs from outside may have any name,
//! so a name is suspected only if it is unknown and a similar name is known.

use super::{FindingCollector, Program, walk};
use crate::codes;
use crate::diagnostic::{Diagnostic, Severity};
use crate::matching::{View, pattern_head};
use crate::suggest::{meant, renames};
use apex_model::condition::{ConditionKind, VariablePattern};
use apex_model::expression::{Expr, ExprKind, Template};
use apex_model::procedure::{Activity, BuiltInActivity, ResourceNeed};
use apex_model::source::Place;
use apex_model::symbol::Symbol;
use apex_model::value::Value;
use std::collections::BTreeMap;

/// Names with the places that use them.
type Uses<'l> = BTreeMap<&'l Symbol, Vec<Place>>;

/// Maximum number of suspects in one program.
const SUSPECTS_MAX: usize = 500;

pub(super) fn check(program: &Program<'_>, report: &mut FindingCollector<'_>) {
    messages(program, report);
    state_variables(program, report);
    resources(program, report);
    commands(program, report);
    outcomes(program, report);
}

/// Reports commands that nothing declares and that resemble a declared one: the vehicle will not know them.
fn commands(program: &Program<'_>, report: &mut FindingCollector<'_>) {
    let declared = &program.library.commands;
    if declared.is_empty() {
        return;
    }
    let mut used: Uses<'_> = BTreeMap::new();
    walk::library(program.library, &mut |expr| {
        if let ExprKind::Call { function, arguments } = &expr.kind
            && function.is("command")
            && let Some(form) = arguments.first()
        {
            let head = match &form.kind {
                ExprKind::Constant(Value::List(items)) => items.first().and_then(Value::as_symbol),
                ExprKind::Template(template) => View::Template(template).head(),
                _ => None,
            };
            used.extend(head.map(|head| (head, vec![expr.place])));
        }
    });
    for (name, places) in used.iter().filter(|(name, _)| !declared.contains_key(**name)).take(SUSPECTS_MAX) {
        let known = meant(name, declared.keys().map(Symbol::printed));
        let (Some(known), Some(place)) = (known, places.first()) else { continue };
        let span = report.locator.word(*place, name);
        let message = format!("no command `{name}` is declared, but `{known}` is");
        let diagnostic = Diagnostic::new(Severity::Warning, codes::RESEMBLES, span, message)
            .reason("a vehicle that does not know a command refuses it in flight")
            .fixes(renames(span, name.printed(), [known]));
        report.add(diagnostic);
    }
}

/// Reports messages that steps wait for and no step sends, if they resemble messages that are sent and that no step waits for.
fn messages(program: &Program<'_>, report: &mut FindingCollector<'_>) {
    let mut waited: Uses<'_> = BTreeMap::new();
    for procedure in &program.library.procedures {
        walk::conditions_of(procedure, &mut |condition| {
            if let ConditionKind::Event { pattern, .. } = &condition.kind
                && let Some(head) = pattern_head(pattern)
            {
                waited.entry(head).or_default().push(condition.place);
            }
        });
    }
    if waited.is_empty() {
        return;
    }
    let said = said_in(program);
    let unheard = || said.keys().filter(|name| !waited.contains_key(*name)).map(|name| name.printed());
    misspelt_said(&said, &waited, report);
    for (name, places) in waited.iter().filter(|(name, _)| !said.contains_key(*name)).take(SUSPECTS_MAX) {
        let (Some(known), Some(place)) = (meant(name, unheard()), places.first()) else { continue };
        let span = report.locator.word(*place, name);
        let message = format!("no step sends `({name} ..)`, but the program sends `({known} ..)`");
        let mut diagnostic = Diagnostic::new(Severity::Warning, codes::RESEMBLES, span, message)
            .reason("if no source outside the program sends it either, the wait never ends")
            .fixes(renames(span, name.printed(), [known]));
        if let Some(place) = said.get(&Symbol::new(known)).and_then(|places| places.first()) {
            diagnostic = diagnostic.label(report.locator.span(*place), "sent here, and no clause waits for it");
        }
        report.add(diagnostic);
    }
}

/// Reports messages that are sent once and awaited by no step, and that resemble messages that are both sent elsewhere and awaited.
fn misspelt_said(said: &Uses<'_>, waited: &Uses<'_>, report: &mut FindingCollector<'_>) {
    let heard = || said.keys().filter(|name| waited.contains_key(*name)).map(|name| name.printed());
    let suspects = said.iter().filter(|(name, places)| places.len() == 1 && !waited.contains_key(*name));
    for (name, places) in suspects.take(SUSPECTS_MAX) {
        let (Some(known), Some(place)) = (meant(name, heard()), places.first()) else { continue };
        let span = report.locator.word(*place, name);
        let message = format!("no clause waits for `({name} ..)`, but one waits for `({known} ..)`");
        let diagnostic = Diagnostic::new(Severity::Warning, codes::RESEMBLES, span, message).fixes(renames(
            span,
            name.printed(),
            [known],
        ));
        report.add(diagnostic);
    }
}

/// Returns the messages that the program sends.
fn said_in<'l>(program: &Program<'l>) -> Uses<'l> {
    let mut messages: Vec<(&'l Expr, Place)> = Vec::new();
    walk::library(program.library, &mut |expr| {
        if let ExprKind::Call { function, arguments } = &expr.kind
            && matches!(function.folded(), "inform" | "cogevent")
        {
            messages.extend(arguments.first().map(|message| (message, expr.place)));
        }
    });
    for step in program.library.procedures.iter().flat_map(|procedure| &procedure.steps) {
        for activity in walk::activities(step) {
            if let Activity::BuiltIn(BuiltInActivity::Inform | BuiltInActivity::Cogevent, arguments) = activity {
                messages.extend(arguments.first().map(|message| (message, step.place)));
            }
        }
    }
    let mut said: Uses<'l> = BTreeMap::new();
    for (message, place) in messages {
        let head = match &message.kind {
            ExprKind::Constant(Value::List(items)) => items.first().and_then(Value::as_symbol),
            ExprKind::Template(template) => View::Template(template).head(),
            _ => None,
        };
        if let Some(head) = head {
            said.entry(head).or_default().push(place);
        }
    }
    said
}

/// Reports undeclared state variables that resemble declared ones.
fn state_variables(program: &Program<'_>, report: &mut FindingCollector<'_>) {
    let declared = &program.library.state_variables;
    if declared.is_empty() {
        return;
    }
    let mut used: Uses<'_> = BTreeMap::new();
    for procedure in &program.library.procedures {
        walk::conditions_of(procedure, &mut |condition| {
            let Some(VariablePattern { attribute, .. }) = walk::variable_of(condition) else { return };
            used.entry(attribute).or_default().push(condition.place);
        });
        for policy in &procedure.log {
            if let Some(head) = View::Template(&policy.subject).head().filter(|head| !head.is(":events")) {
                used.entry(head).or_default().push(procedure.place);
            }
        }
    }
    walk::library(program.library, &mut |expr| {
        if let ExprKind::Call { function, arguments } = &expr.kind
            && walk::QUERIES.contains(&function.folded())
            && let Some(Expr { kind: ExprKind::Constant(Value::Symbol(attribute)), .. }) = arguments.first()
        {
            used.entry(attribute).or_default().push(expr.place);
        }
    });
    for derivation in program.library.derivations.values() {
        for input in &derivation.inputs {
            used.entry(&input.attribute).or_default().push(derivation.place);
        }
    }
    for (name, places) in used.iter().filter(|(name, _)| !declared.contains_key(**name)).take(SUSPECTS_MAX) {
        let known = meant(name, declared.keys().map(Symbol::printed));
        let (Some(known), Some(place)) = (known, places.first()) else { continue };
        let known_symbol = Symbol::new(known);
        if let Some(declaration) =
            declared.get(&known_symbol).filter(|_| places.len() > 1 && !used.contains_key(&known_symbol))
        {
            // Several uses agree on the undeclared name, and no form uses the declared one: the declaration is probably wrong.
            let span = report.locator.word(declaration.place, &known_symbol);
            let message = format!("state variable `{known}` is declared and never used, but `{name}` is used");
            let diagnostic = Diagnostic::new(Severity::Warning, codes::RESEMBLES, span, message)
                .label(report.locator.word(*place, name), "used here")
                .fixes(renames(span, known, [name.printed()]));
            report.add(diagnostic);
            continue;
        }
        let span = report.locator.word(*place, name);
        let message = format!("no state variable `{name}` is declared, but `{known}` is");
        let mut diagnostic = Diagnostic::new(Severity::Warning, codes::RESEMBLES, span, message).fixes(renames(
            span,
            name.printed(),
            [known],
        ));
        if let Some(declaration) = declared.get(&Symbol::new(known)) {
            diagnostic = diagnostic.label(report.locator.span(declaration.place), "declared here");
        }
        report.add(diagnostic);
    }
}

/// Reports resources that are named once, are not declared, and resemble others.
fn resources(program: &Program<'_>, report: &mut FindingCollector<'_>) {
    let library = program.library;
    let mut used: Uses<'_> = BTreeMap::new();
    let note = |needs: &[ResourceNeed]| -> Vec<(Symbol, Place)> {
        let named = needs.iter().filter_map(|need| match &need.resource {
            Template::Constant(value) => Some((value.as_symbol()?.clone(), need.place)),
            _ => None,
        });
        named.collect()
    };
    let procedures = library.procedures.iter().map(|each| &each.profile);
    let steps = library.procedures.iter().flat_map(|each| &each.steps).map(|each| &each.profile);
    let primitives = library.primitives.iter().map(|each| &each.profile);
    let mut all: Vec<(Symbol, Place)> =
        procedures.chain(steps).chain(primitives).flat_map(|needs| note(needs)).collect();
    for step in library.procedures.iter().flat_map(|each| &each.steps) {
        if let Activity::BuiltIn(BuiltInActivity::HoldResource | BuiltInActivity::ReleaseResource, names) =
            &step.activity
        {
            all.extend(names.iter().filter_map(|name| match &name.kind {
                ExprKind::Constant(Value::Symbol(word)) => Some((word.clone(), name.place)),
                _ => None,
            }));
        }
    }
    for (name, place) in &all {
        used.entry(name).or_default().push(*place);
    }
    let common = used.iter().filter(|(_, places)| places.len() > 1).map(|(name, _)| *name);
    let known: Vec<&str> = common.chain(library.resources.keys()).map(Symbol::printed).collect();
    let suspects = used.iter().filter(|(name, places)| places.len() == 1 && !library.resources.contains_key(**name));
    for (name, places) in suspects.take(SUSPECTS_MAX) {
        // A suspect is never proposed as the name that was meant.
        let found = meant(name, known.iter().copied());
        let (Some(known), Some(place)) = (found, places.first()) else { continue };
        let span = report.locator.span(*place);
        let span = report.locator.word(*place, name).to(span);
        let message = format!("resource `{name}` is needed nowhere else, but `{known}` is");
        let diagnostic = Diagnostic::new(Severity::Warning, codes::RESEMBLES, span, message)
            .reason("a resource that only one step needs never causes a conflict")
            .fixes(renames(span, name.printed(), [known]));
        report.add(diagnostic);
    }
}

/// Outcomes of `terminate` with a special meaning; every other word means success.
const OUTCOMES: &[&str] = &["success", "failure", "fail", "failed", "cut", "abort", "aborted"];

fn outcomes(program: &Program<'_>, report: &mut FindingCollector<'_>) {
    for step in program.library.procedures.iter().flat_map(|procedure| &procedure.steps) {
        for activity in walk::activities(step) {
            let Activity::Terminate { outcome: Some(outcome), .. } = activity else { continue };
            let ExprKind::Constant(Value::Symbol(word)) = &outcome.kind else { continue };
            let Some(known) = meant(word, OUTCOMES.iter().copied()).filter(|_| !OUTCOMES.contains(&word.folded()))
            else {
                continue;
            };
            let span = report.locator.span(outcome.place);
            let message = format!("`{word}` is not an outcome, so it counts as success");
            let diagnostic = Diagnostic::new(Severity::Warning, codes::RESEMBLES, span, message)
                .fixes(renames(span, word.printed(), [known]))
                .help("outcomes are success, failure and cut");
            report.add(diagnostic);
        }
    }
}
