//! Goals that are served, but not for every agent or activity: goals of an agent with its bundles, and goals of a `plan` activity, which
//! only solvers serve.

use super::methods::Method;
use super::{FindingCollector, Program, walk};
use crate::codes;
use crate::diagnostic::{Diagnostic, Severity, Span};
use crate::matching::{View, may_match};
use crate::print::template_text;
use apex_model::expression::{ExprKind, Template};
use apex_model::library::AgentDeclaration;
use apex_model::limits::MATCH_STEPS_MAX;
use apex_model::procedure::{Activity, BuiltInActivity};
use apex_model::symbol::Symbol;
use std::collections::BTreeSet;

pub(super) fn check(program: &Program<'_>, report: &mut FindingCollector<'_>) {
    if program.fragment {
        return;
    }
    plans(program, report);
    let mut told: BTreeSet<(u32, u32)> = BTreeSet::new();
    for agent in program.library.agents.iter().filter(|agent| !agent.bundles.is_empty()) {
        unknown_to(program, agent, &mut told, report);
    }
}

/// Reports goals of `plan` that no solver serves.
fn plans(program: &Program<'_>, report: &mut FindingCollector<'_>) {
    for step in program.library.procedures.iter().flat_map(|procedure| &procedure.steps) {
        for activity in walk::activities(step) {
            let Activity::BuiltIn(BuiltInActivity::Plan, arguments) = activity else { continue };
            let Some(goal) = arguments.first() else { continue };
            let template = match &goal.kind {
                ExprKind::Constant(value) => Template::Constant(value.clone()),
                ExprKind::Template(template) => (**template).clone(),
                _ => continue,
            };
            let view = View::Template(&template);
            let serves = |index| may_match(view, index, &mut { MATCH_STEPS_MAX });
            if view.head().is_none() || program.library.solvers.iter().any(|solver| serves(&solver.index)) {
                continue;
            }
            let text = template_text(&template);
            let message = format!("no solver plans for `{text}`");
            // The step states what to do after a failure, so the procedure can continue.
            let severity = if step.on_failure.is_some() { Severity::Warning } else { Severity::Error };
            let span = report.locator.span(goal.place);
            let diagnostic = Diagnostic::new(severity, codes::UNSERVED_GOAL, span, message)
                .reason("`plan` asks a solver, even if a procedure serves the goal")
                .help(format!("declare one: `(solver auto (index {text}))`"));
            report.add(diagnostic);
        }
    }
}

/// Reports goals that the agent may pursue and that only bundles serve that it does not use.
fn unknown_to(
    program: &Program<'_>,
    agent: &AgentDeclaration,
    told: &mut BTreeSet<(u32, u32)>,
    report: &mut FindingCollector<'_>,
) {
    let library = program.library;
    let mut seen: BTreeSet<Method> = BTreeSet::new();
    let mut open: Vec<Method> = Vec::new();
    let initial = Template::Constant(agent.initial_task.clone());
    let serving = program.methods.serving(&initial);
    if let Some(methods) = &serving {
        open.extend(methods.iter().filter(|method| knows(program, agent, **method)));
        if open.is_empty() && !methods.is_empty() {
            let span = report.locator.word(agent.place, &Symbol::new("initial-task"));
            report_unknown(program, agent, &initial, methods, span, report);
        }
    }
    while let Some(method) = open.pop() {
        let Method::Procedure(number) = method else { continue };
        let Some(procedure) = library.procedures.get(number).filter(|_| seen.insert(method)) else { continue };
        for (index, step) in procedure.steps.iter().enumerate() {
            let Activity::Goal(goal) = &step.activity else { continue };
            let Some(methods) = program.methods.serving_step(number, index) else { continue };
            let known: Vec<Method> = methods.iter().copied().filter(|method| knows(program, agent, *method)).collect();
            if known.is_empty() && !methods.is_empty() && told.insert((step.place.file, step.place.line)) {
                let span = report.locator.activity(step.place);
                report_unknown(program, agent, goal, methods, span, report);
            }
            open.extend(known);
        }
        walk::probes(procedure, &mut |place, goal| {
            let Some(methods) = program.methods.serving(goal) else { return };
            let known: Vec<Method> = methods.iter().copied().filter(|method| knows(program, agent, *method)).collect();
            if known.is_empty() && !methods.is_empty() && told.insert((place.file, place.line)) {
                let span = report.locator.probe(place);
                report_unknown(program, agent, goal, &methods, span, report);
            }
            open.extend(known);
        });
    }
}

fn bundle<'l>(program: &Program<'l>, method: Method) -> Option<&'l Symbol> {
    match method {
        Method::Procedure(number) => program.library.procedures.get(number)?.bundle.as_ref(),
        Method::Primitive(number) => program.library.primitives.get(number)?.bundle.as_ref(),
        Method::Solver(_) => None,
    }
}

fn knows(program: &Program<'_>, agent: &AgentDeclaration, method: Method) -> bool {
    bundle(program, method).is_none_or(|bundle| agent.bundles.contains(bundle))
}

fn report_unknown(
    program: &Program<'_>,
    agent: &AgentDeclaration,
    goal: &Template,
    methods: &[Method],
    span: Span,
    report: &mut FindingCollector<'_>,
) {
    let Some(bundle) = methods.first().and_then(|method| bundle(program, *method)) else { return };
    let message = format!("nothing that agent `{}` uses serves `{}`", agent.name, template_text(goal));
    let diagnostic = Diagnostic::error(codes::UNSERVED_GOAL, span, message)
        .label(report.locator.word(agent.place, &agent.name), "this agent")
        .reason(format!("only the bundle `{bundle}` serves it, and the agent's `:use-bundles` leaves it out"))
        .help(format!("add `:{bundle}` to `:use-bundles`, or remove the option: then all bundles are used"));
    report.add(diagnostic);
}
