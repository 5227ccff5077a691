//! Messages about steps that never begin: circles of waits, waits for steps that never end, steps after the end.

use super::endings::{ends_procedure, goes_on, never_completing};
use super::methods::Method;
use super::starts::{Blocked, Premise, Waits, tags};
use super::{FindingCollector, Program};
use crate::codes;
use crate::diagnostic::{Diagnostic, Severity, Span};
use crate::fix::Fix;
use crate::print::{pattern_text, template_text};
use apex_model::procedure::{Activity, Procedure, Step};
use apex_model::source::Place;
use std::collections::BTreeSet;

/// Reports steps that never begin. `caught` holds the procedures for which an endless recursion is reported already.
pub(super) fn check(program: &Program<'_>, caught: &BTreeSet<usize>, report: &mut FindingCollector<'_>) {
    unreached_completions(program, report);
    if program.endings.is_wild {
        // Some activity may end any task, so every wait may be satisfied.
        return;
    }
    for (number, procedure) in program.library.procedures.iter().enumerate() {
        let Some(waits) = Waits::new(program.library, number, &program.endings) else { continue };
        let mut told: BTreeSet<usize> = BTreeSet::new();
        for blocked in waits.blocked() {
            match blocked {
                Blocked::Circle(circle) => report_circle(procedure, &circle, report),
                Blocked::Endless(step, premise) => {
                    let known =
                        procedure.steps.get(target(&premise)).is_some_and(|step| leads_to(program, step, caught));
                    if told.insert(target(&premise)) && !known {
                        report_endless(program, number, &waits, step, &premise, report);
                    }
                }
                Blocked::OwnState(step, place) => {
                    let tag = tags(procedure, [step]).concat();
                    let message = format!("{tag} waits for a state that it has only after it began");
                    let diagnostic = Diagnostic::error(codes::NEVER_STARTS, report.locator.span(place), message)
                        .reason("as long as a step waits, its task is pending")
                        .help("wait for the state of another step, or move the condition to `end-when`, `suspend-when` or `restart-when`");
                    report.add(diagnostic);
                }
                Blocked::Told => {}
            }
        }
    }
}

/// Returns true if the step pursues one of these procedures.
fn leads_to(program: &Program<'_>, step: &Step, caught: &BTreeSet<usize>) -> bool {
    let Activity::Goal(goal) = &step.activity else { return false };
    let methods = program.methods.serving(goal).unwrap_or_default();
    methods.iter().any(|method| matches!(method, Method::Procedure(number) if caught.contains(number)))
}

fn target(premise: &Premise) -> usize {
    match premise {
        Premise::End { step, .. } | Premise::Sequence { step } | Premise::Begin { step, .. } => *step,
        Premise::Result { steps, .. } => steps.first().copied().unwrap_or(usize::MAX),
        Premise::OwnState { .. } | Premise::Impossible => usize::MAX,
    }
}

/// Returns the position at which a step states its wait.
fn place_of(procedure: &Procedure, step: usize, premise: &Premise, report: &mut FindingCollector<'_>) -> Span {
    let own = procedure.steps.get(step).map_or(procedure.place, |step| step.place);
    match premise {
        Premise::End { place, .. } | Premise::Begin { place, .. } | Premise::OwnState { place } => {
            report.locator.span(*place)
        }
        Premise::Result { name, .. } => report.locator.variable(own, name),
        Premise::Sequence { .. } | Premise::Impossible => report.locator.tag(own),
    }
}

/// Returns "`a` waits for the end of `b`".
fn wait_in_words(procedure: &Procedure, step: usize, premise: &Premise) -> String {
    let own = tags(procedure, [step]).concat();
    let other = tags(procedure, [target(premise)]).concat();
    match premise {
        Premise::End { .. } => format!("{own} waits for the end of {other}"),
        Premise::Begin { .. } => format!("{own} waits for {other} to begin"),
        Premise::Sequence { .. } => format!("{own} comes after {other} in the sequence"),
        Premise::Result { name, .. } => format!("{own} needs `?{name}`, the result of {other}"),
        Premise::OwnState { .. } | Premise::Impossible => format!("{own} waits"),
    }
}

fn report_circle(procedure: &Procedure, circle: &[(usize, Premise)], report: &mut FindingCollector<'_>) {
    // The circle begins where a wait is written: the order of a sequence is not a mistake.
    let written = |(_, premise): &(usize, Premise)| !matches!(premise, Premise::Sequence { .. });
    let first = circle.iter().position(written).unwrap_or(0);
    let turned: Vec<&(usize, Premise)> = circle.iter().cycle().skip(first).take(circle.len()).collect();
    let Some((step, premise)) = turned.first() else { return };
    let names = tags(procedure, turned.iter().map(|(step, _)| *step));
    let message = match (names.as_slice(), premise) {
        ([own], Premise::Result { name, .. }) => format!("{own} needs its own result `?{name}` before it can begin"),
        ([own], _) => format!("{own} waits for its own end"),
        ([one, other], _) => format!("{one} and {other} wait for each other"),
        (several, _) => format!("{} wait for each other in a circle", listed(several)),
    };
    let span = place_of(procedure, *step, premise, report);
    let mut diagnostic = Diagnostic::error(codes::WAIT_CYCLE, span, message);
    for (step, premise) in turned.iter().skip(1).copied().take(LABELS_MAX) {
        let label = wait_in_words(procedure, *step, premise);
        diagnostic = diagnostic.label(place_of(procedure, *step, premise, report), label);
    }
    let words: Vec<String> = turned.iter().map(|(step, premise)| wait_in_words(procedure, *step, premise)).collect();
    let who = if circle.len() == 1 { "it can never begin" } else { "none of them can ever begin" };
    diagnostic = diagnostic.reason(format!("{}: {who}", words.join("; ")));
    if let (1, Premise::End { place, .. }) = (circle.len(), premise) {
        diagnostic = diagnostic.fixes(step_before(procedure, *step, *place, report));
    }
    let help = if circle.len() == 1 { "remove this wait, or name another step" } else { "remove one of these waits" };
    let written = procedure.steps.get(*step).and_then(|step| report.locator.wait(step.place, span));
    let fix = written.map(|wait| Fix::look("remove this wait").replace(wait, ""));
    report.add(diagnostic.help(help).fixes(fix));
}

/// Returns a fix for a step that waits for itself: it probably waits for the step before it.
fn step_before(procedure: &Procedure, step: usize, place: Place, report: &mut FindingCollector<'_>) -> Option<Fix> {
    let before = &procedure.steps.get(step.checked_sub(1)?)?.tag;
    let condition = report.locator.datum(place)?;
    let task = condition.tail().first().unwrap_or(&condition);
    task.as_variable()?;
    Some(Fix::look(format!("wait for `?{before}`, the step before it")).replace(task.span, format!("?{before}")))
}

/// Returns "a, b and c".
fn listed(names: &[String]) -> String {
    match names.split_last() {
        Some((last, others)) if !others.is_empty() => format!("{} and {last}", others.join(", ")),
        _ => names.concat(),
    }
}

/// Maximum number of further places shown for one circle.
const LABELS_MAX: usize = 8;

fn report_endless(
    program: &Program<'_>,
    number: usize,
    waits: &Waits<'_>,
    step: usize,
    premise: &Premise,
    report: &mut FindingCollector<'_>,
) {
    let Some(procedure) = program.library.procedures.get(number) else { return };
    let Some(blocker) = procedure.steps.get(target(premise)) else { return };
    if procedure.steps.get(step).is_none_or(|step| step.place == blocker.place) {
        // The sequence's own end, which the text does not contain: the last step continues until its procedure is ended from above.
        return;
    }
    let span = place_of(procedure, step, premise, report);
    let (own, other) = (tags(procedure, [step]).concat(), format!("`{}`", blocker.tag));
    let is_terminate = ends_procedure(&blocker.activity);
    if is_terminate && matches!(premise, Premise::Sequence { .. }) {
        let diagnostic =
            Diagnostic::new(Severity::Warning, codes::UNREACHABLE, span, format!("{own} is never reached"))
                .label(report.locator.span(blocker.place), "this ends the procedure")
                .help(format!("move {own} before it, or remove it"));
        let unreached = procedure.steps.get(step).map(|step| report.locator.span(step.place));
        let fix = unreached.map(|step| Fix::look(format!("remove {own}")).replace(step, ""));
        return report.add(diagnostic.fixes(fix));
    }
    let message = format!("{own} can never begin");
    let mut diagnostic = Diagnostic::error(codes::NEVER_STARTS, span, message);
    let waits_in_words = wait_in_words(procedure, step, premise);
    if is_terminate {
        diagnostic = diagnostic
            .label(report.locator.span(blocker.place), "this ends the whole procedure")
            .reason(format!("{waits_in_words}, and by then the procedure is over"))
            .help(format!("let {own} come first, and {other} wait for it"));
    } else if goes_on(procedure, blocker) && waits.activity_ends(target(premise)) {
        let clause = if blocker.responding.is_some() { "responding" } else { "repeating" };
        diagnostic = diagnostic
            .label(report.locator.clause(blocker.place, clause), format!("{other} begins again whenever it ends"))
            .reason(format!("{waits_in_words}, which is never over"))
            .help("add `:while TEST` or `:until TEST`, or make the procedure concurrent and let the step wait for an event");
    } else {
        let (place, why) = why_endless(program, &blocker.activity, report)
            .unwrap_or_else(|| (report.locator.activity(blocker.place), format!("{other} does not end on its own")));
        diagnostic = diagnostic
            .label(place, why)
            .reason(format!("{waits_in_words}, which does not end on its own"))
            .help(format!("give {other} an `end-when`, or an activity that ends"));
    }
    report.add(diagnostic);
}

/// Returns the method that serves the goal and does not end.
fn why_endless(
    program: &Program<'_>,
    activity: &Activity,
    report: &mut FindingCollector<'_>,
) -> Option<(Span, String)> {
    let Activity::Goal(goal) = activity else { return None };
    let methods = program.methods.serving(goal)?;
    let method = methods.into_iter().find(|method| !program.endings.ends(*method))?;
    match method {
        Method::Procedure(number) => {
            let procedure = program.library.procedures.get(number)?;
            let text = pattern_text(&procedure.index);
            Some((report.locator.index(procedure.place), format!("`{text}` never ends")))
        }
        Method::Primitive(number) => {
            let primitive = program.library.primitives.get(number)?;
            let why = "this has an `update`, but no duration and no `(complete)`";
            Some((report.locator.index(primitive.place), why.to_string()))
        }
        Method::Solver(_) => Some((report.locator.span(program.library.solvers.first()?.place), template_text(goal))),
    }
}

/// Reports clauses for the completion of primitives that never complete.
fn unreached_completions(program: &Program<'_>, report: &mut FindingCollector<'_>) {
    for number in never_completing(program.library, program.names) {
        let Some(primitive) = program.library.primitives.get(number) else { continue };
        let clause = match (&primitive.returns, primitive.on_completion.is_empty()) {
            (_, false) => "on-completion",
            (Some(_), true) => "return",
            (None, true) => continue,
        };
        let span = report.locator.clause(primitive.place, clause);
        let message = format!("this `{clause}` is never reached");
        let diagnostic = Diagnostic::new(Severity::Warning, codes::UNREACHABLE, span, message)
            .reason("the primitive has no duration, sends no command, and none of its forms is `(complete)`")
            .help("add `(duration D)`, or `(complete)` in its `update`; what is to run at any end belongs to `on-end`");
        report.add(diagnostic);
    }
}
