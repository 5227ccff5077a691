//! Reports messages that steps wait for and that can never arrive: nothing sends them, or not with these arguments.

use super::calls::{Call, Calls};
use super::findings::{Findings, is_shipped};
use super::known::KnownNames;
use crate::analysis::walk;
use crate::codes;
use crate::diagnostic::{Diagnostic, Severity};
use crate::matching::{may_match, pattern_head};
use crate::suggest::renames;
use apex_model::condition::ConditionKind;
use apex_model::interface::{ArgumentType, InterfaceDeclaration};
use apex_model::library::Library;
use apex_model::limits::MATCH_STEPS_MAX;
use apex_model::pattern::Pattern;
use apex_model::source::Place;
use apex_model::symbol::Symbol;
use apex_model::value::Value;
use std::collections::{BTreeMap, BTreeSet};

pub(super) fn check(library: &Library, known: &KnownNames, calls: &Calls<'_>, findings: &mut Findings<'_>) {
    if calls.is_wild {
        // A computed message may have any form, so every awaited message may be sent.
        return;
    }
    let mut sent: BTreeMap<&Symbol, Vec<&Call<'_>>> = BTreeMap::new();
    for call in calls.all.iter().filter(|call| call.is_message) {
        if let Some(head) = call.head() {
            sent.entry(head).or_default().push(call);
        }
    }
    let mut told: BTreeSet<&Symbol> = BTreeSet::new();
    for (pattern, place) in awaited(library) {
        let Some(head) = pattern_head(pattern) else { continue };
        let declared = library.events.get(head);
        if declared.is_some_and(|declared| !may_be(declared, pattern)) {
            // `check_declared` has reported it.
            continue;
        }
        let from_outside = declared.is_some_and(|declared| declared.from.is_some()) || known.messages.contains(head);
        let of_program = sent.get(head);
        if !from_outside && of_program.is_none() {
            if told.insert(head) {
                never_sent(library, &sent, head, place, findings);
            }
            continue;
        }
        let fits_program = of_program
            .into_iter()
            .flatten()
            .any(|call| !call.is_complete || may_match(call.view, pattern, &mut { MATCH_STEPS_MAX }));
        let fits_outside = known.messages.contains(head)
            || declared.is_some_and(|declared| declared.from.is_some() && may_be(declared, pattern));
        if !fits_program && !fits_outside {
            never_so(declared, of_program, head, place, findings);
        }
    }
}

/// Reports awaited messages with other arguments than their declaration has. This needs no mission: no sender may send them so.
pub(super) fn check_declared(library: &Library, findings: &mut Findings<'_>) {
    for (pattern, place) in awaited(library) {
        let Some(head) = pattern_head(pattern) else { continue };
        let declared = library.events.get(head);
        if declared.is_some_and(|declared| !may_be(declared, pattern)) {
            never_so(declared, None, head, place, findings);
        }
    }
}

/// Returns the messages for which the program's own procedures wait. A shipped library may wait for messages that not every mission sends.
fn awaited(library: &Library) -> Vec<(&Pattern, Place)> {
    let mut awaited: Vec<(&Pattern, Place)> = Vec::new();
    for procedure in library.procedures.iter().filter(|procedure| !is_shipped(library, procedure.place)) {
        walk::conditions_of(procedure, &mut |condition| {
            if let ConditionKind::Event { pattern, .. } = &condition.kind {
                awaited.push((pattern, condition.place));
            }
        });
    }
    awaited
}

/// Returns false if no message of this declaration can match.
fn may_be(declaration: &InterfaceDeclaration, pattern: &Pattern) -> bool {
    let literals: Vec<Pattern>;
    let parts: &[Pattern] = match pattern {
        Pattern::List(parts) => parts,
        Pattern::Literal(Value::List(items)) => {
            literals = items.iter().cloned().map(Pattern::Literal).collect();
            &literals
        }
        _ => return true,
    };
    if parts.iter().any(|part| matches!(part, Pattern::Segment { .. } | Pattern::Guard(_))) {
        return true;
    }
    let given = parts.len().saturating_sub(1);
    if given < declaration.required || !declaration.is_open && given > declaration.parameters.len() {
        return false;
    }
    parts.iter().skip(1).zip(&declaration.parameters).all(|(part, parameter)| match (part, &parameter.argument_type) {
        (Pattern::Literal(Value::Symbol(word)), ArgumentType::OneOf(words)) => words.contains(word),
        _ => true,
    })
}

fn never_sent(
    library: &Library,
    sent: &BTreeMap<&Symbol, Vec<&Call<'_>>>,
    head: &Symbol,
    place: Place,
    findings: &mut Findings<'_>,
) {
    let span = findings.locator.word(place, head);
    let outside = library.events.iter().filter(|(_, declared)| declared.from.is_some()).map(|(name, _)| name);
    let names = outside.chain(sent.keys().copied()).map(Symbol::printed);
    let diagnostic =
        Diagnostic::new(Severity::Warning, codes::NEVER_SENT, span, format!("nothing sends `({head} ..)`"))
            .reason("no step, hook or scenario sends it, and it is not declared as a message from outside")
            .fixes(renames(span, head.printed(), names))
            .help(format!("if it comes from outside, declare it: `(declare-event ({head} ..) :from operator)`"));
    findings.add(diagnostic);
}

fn never_so(
    declared: Option<&InterfaceDeclaration>,
    sent: Option<&Vec<&Call<'_>>>,
    head: &Symbol,
    place: Place,
    findings: &mut Findings<'_>,
) {
    let span = findings.locator.word(place, head);
    let message = format!("no message `({head} ..)` that is sent matches this");
    let mut diagnostic = Diagnostic::new(Severity::Warning, codes::NEVER_SENT, span, message);
    if let Some(declared) = declared {
        diagnostic = diagnostic.label(findings.locator.span(declared.place), "declared here");
    }
    for call in sent.into_iter().flatten().take(SENDERS_SHOWN) {
        diagnostic = diagnostic.label(findings.locator.span(call.place), "sent here");
    }
    findings.add(diagnostic.help("give it as many arguments as the message has, with the same words"));
}

/// Maximum number of senders shown for one message.
const SENDERS_SHOWN: usize = 3;
