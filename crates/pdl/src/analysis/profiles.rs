//! Resources that can never be granted: amounts beyond the total, and holders that never release.

use super::endings::{ends_procedure, terminated_tags};
use super::kinds::Kind;
use super::methods::Method;
use super::{FindingCollector, Program};
use crate::codes;
use crate::diagnostic::{Diagnostic, Severity};
use crate::fix::Fix;
use apex_model::expression::{ExprKind, Template};
use apex_model::library::ResourceKind;
use apex_model::procedure::{Activity, BuiltInActivity, Procedure, ProcedureKind, ResourceNeed, Step};
use apex_model::quantity::Dimension;
use apex_model::symbol::Symbol;
use apex_model::value::Value;
use std::collections::{BTreeMap, BTreeSet};

pub(super) fn check(program: &Program<'_>, report: &mut FindingCollector<'_>) {
    let mut told = BTreeSet::new();
    for procedure in &program.library.procedures {
        shortage(program, &[&procedure.profile], &mut told, report);
    }
    for primitive in &program.library.primitives {
        shortage(program, &[&primitive.profile], &mut told, report);
    }
    for (number, procedure) in program.library.procedures.iter().enumerate() {
        let holds_something =
            |step: &Step| matches!(step.activity, Activity::BuiltIn(BuiltInActivity::HoldResource, _));
        let holds = procedure.steps.iter().any(holds_something);
        for (index, step) in procedure.steps.iter().enumerate() {
            if !step.profile.is_empty() {
                let served = profile_of_served(program, (number, index), step);
                shortage(program, &[served, &step.profile], &mut told, report);
            }
            if !holds && program.endings.is_wild {
                continue;
            }
            useless_release(step, holds, report);
        }
        starved(program, number, procedure, report);
    }
}

fn resource_of(need: &ResourceNeed) -> Option<&Symbol> {
    match &need.resource {
        Template::Constant(value) => value.as_symbol(),
        _ => None,
    }
}

/// Returns the total of a resource, and its dimension.
fn total(program: &Program<'_>, resource: &Symbol) -> (f64, Dimension) {
    match program.library.resources.get(resource).map(|declaration| &declaration.kind) {
        Some(ResourceKind::Capacity(units)) => (f64::from(*units), Dimension::NONE),
        Some(ResourceKind::Depletable(amount) | ResourceKind::Renewable(amount)) => {
            amount.as_number().unwrap_or((f64::INFINITY, Dimension::NONE))
        }
        Some(ResourceKind::Unitary) | None => (1.0, Dimension::NONE),
    }
}

/// Returns the least amount that an entry requests; `None` if the amount is computed, or has another dimension than the resource.
fn least(program: &Program<'_>, resource: &Symbol, need: &ResourceNeed) -> Option<f64> {
    let (total, dimension) = total(program, resource);
    match need.amount.as_ref().map(|amount| &amount.kind) {
        None => Some(total),
        Some(ExprKind::Constant(value)) => match value.as_number() {
            Some((number, found)) if found == dimension => Some(number),
            _ => None,
        },
        Some(_) => None,
    }
}

/// Reports a written amount of another dimension than the declared resource has: `(winch 2m)`.
fn other_dimension(
    program: &Program<'_>,
    resource: &Symbol,
    need: &ResourceNeed,
    told: &mut BTreeSet<apex_model::source::Place>,
    report: &mut FindingCollector<'_>,
) {
    let Some(declaration) = program.library.resources.get(resource) else { return };
    let (_, dimension) = total(program, resource);
    let Some((place, found)) = need.amount.as_ref().and_then(|amount| match &amount.kind {
        ExprKind::Constant(value) => Some((amount.place, value.as_number()?.1)),
        _ => None,
    }) else {
        return;
    };
    if found == dimension || !told.insert(place) {
        return;
    }
    let (wanted, found) = (Kind::Number(dimension).words(), Kind::Number(found).words());
    let message = format!("`{resource}` is {wanted}, but this amount is {found}");
    let diagnostic = Diagnostic::error(codes::DIMENSION, report.locator.span(place), message)
        .label(report.locator.span(declaration.place), "declared here");
    report.add(diagnostic);
}

/// Reports resources of which the sum of the profiles exceeds the total.
fn shortage(
    program: &Program<'_>,
    profiles: &[&[ResourceNeed]],
    told: &mut BTreeSet<apex_model::source::Place>,
    report: &mut FindingCollector<'_>,
) {
    let mut sums: BTreeMap<&Symbol, (f64, Vec<&ResourceNeed>)> = BTreeMap::new();
    for need in profiles.iter().copied().flatten() {
        let Some(resource) = resource_of(need) else { continue };
        let Some(amount) = least(program, resource, need) else {
            other_dimension(program, resource, need, told, report);
            continue;
        };
        let (sum, needs) = sums.entry(resource).or_default();
        *sum += amount;
        needs.push(need);
        if amount < 0.0 && told.insert(need.place) {
            let diagnostic = Diagnostic::error(
                codes::RESOURCE_SHORT,
                report.locator.span(need.place),
                format!("a negative amount is needed of `{resource}`"),
            );
            report.add(diagnostic.help("write an amount that is not negative"));
        }
    }
    for (resource, (sum, needs)) in sums {
        let (all, _) = total(program, resource);
        let Some((last, others)) = needs.split_last() else { continue };
        if sum <= all || !told.insert(last.place) {
            continue;
        }
        let declaration = program.library.resources.get(resource);
        let message = match (declaration.map(|declaration| &declaration.kind), others) {
            (Some(ResourceKind::Capacity(units)), _) => {
                format!("{sum} units of `{resource}` are needed at once, but there are {units}")
            }
            (Some(ResourceKind::Depletable(amount) | ResourceKind::Renewable(amount)), _) => {
                let sum = Value::measured(sum, amount.as_number().map_or(Dimension::NONE, |(_, dimension)| dimension));
                format!("{sum} of `{resource}` is needed, but there is {amount}")
            }
            _ => format!("`{resource}` is needed twice by one task, but there is one"),
        };
        let mut diagnostic = Diagnostic::error(codes::RESOURCE_SHORT, report.locator.span(last.place), message);
        for other in others {
            diagnostic = diagnostic.label(report.locator.span(other.place), "and needed here for the same task");
        }
        if let Some(declaration) = declaration {
            diagnostic = diagnostic.label(report.locator.span(declaration.place), "declared here");
        }
        if !others.is_empty() {
            diagnostic = diagnostic.reason("entries for one task are added up, the step's and those of what serves it");
        }
        if !others.is_empty() {
            let fix = Fix::look(format!("ask for `{resource}` once"));
            diagnostic = diagnostic.fix(fix.replace(report.locator.span(last.place), ""));
        }
        diagnostic =
            diagnostic.help(if others.is_empty() { "ask for less, or declare more" } else { "keep one of them" });
        report.add(diagnostic);
    }
}

/// Returns the profile of the procedure or primitive that surely serves the step.
fn profile_of_served<'l>(program: &Program<'l>, (number, index): (usize, usize), step: &Step) -> &'l [ResourceNeed] {
    let Activity::Goal(goal) = &step.activity else { return &[] };
    if step.forall.is_some() {
        return &[];
    }
    let library = program.library;
    match program.methods.serving_step(number, index).unwrap_or_default() {
        [only] if program.methods.surely(goal, *only) => match only {
            Method::Procedure(number) => library.procedures.get(*number).map_or(&[], |each| &each.profile),
            Method::Primitive(number) => library.primitives.get(*number).map_or(&[], |each| &each.profile),
            Method::Solver(_) => &[],
        },
        _ => &[],
    }
}

/// Reports `release-resource` if the procedure holds nothing.
fn useless_release(step: &Step, holds: bool, report: &mut FindingCollector<'_>) {
    if !holds && matches!(step.activity, Activity::BuiltIn(BuiltInActivity::ReleaseResource, _)) {
        let span = report.locator.activity(step.place);
        let diagnostic = Diagnostic::new(Severity::Warning, codes::WITHOUT_EFFECT, span, "there is nothing to release")
            .reason("`release-resource` gives back what a `hold-resource` of the same procedure was granted")
            .help("what a profile was granted is given back when its task ends");
        let fix = Fix::look("remove this step").replace(report.locator.span(step.place), "");
        report.add(diagnostic.fix(fix));
    }
}

/// Reports steps of a concurrent procedure that need a resource that another step takes first and never releases.
fn starved(program: &Program<'_>, number: usize, procedure: &Procedure, report: &mut FindingCollector<'_>) {
    if program.endings.is_wild || procedure.kind == ProcedureKind::Sequential {
        return;
    }
    let terminated = terminated_tags(procedure);
    let mut keepers: BTreeMap<&Symbol, (usize, &Step)> = BTreeMap::new();
    for (index, step) in procedure.steps.iter().enumerate() {
        let stays =
            step.waitfor.is_empty() && step.transitions == Default::default() && !terminated.contains(&step.tag);
        if stays && !has_say(step) && step.forall.is_none() && !program.endings.activity_ends(number, index) {
            for resource in whole_needs(program, (number, index), step) {
                keepers.entry(resource).or_insert((index, step));
            }
        }
    }
    if keepers.is_empty() {
        return;
    }
    for (index, step) in procedure.steps.iter().enumerate() {
        let kept = whole_needs(program, (number, index), step)
            .into_iter()
            .find_map(|resource| Some((resource, keepers.get(resource)?)));
        let Some((resource, (first, keeper))) = kept else { continue };
        let comes_later = *first < index || *first != index && !step.waitfor.is_empty();
        if !comes_later || has_say(step) || ends_procedure(&step.activity) {
            continue;
        }
        let span = report.locator.activity(step.place);
        let message = format!("`{}` never gets `{resource}`", step.tag);
        let diagnostic = Diagnostic::new(Severity::Warning, codes::STARVED, span, message)
            .label(report.locator.activity(keeper.place), "this step holds the resource and does not end")
            .reason("of tasks with equal priority, the holder keeps the resource")
            .help("give the step a `(priority N)`, or let the other one end");
        report.add(diagnostic);
    }
}

/// Returns true if the step states a priority, rank or interrupt cost.
fn has_say(step: &Step) -> bool {
    !step.priority.is_empty() || step.rank.is_some() || step.interrupt_cost.is_some()
}

/// Returns the resources that one task at a time takes whole, needed by the step or by the method that certainly serves it.
fn whole_needs<'l>(program: &Program<'l>, at: (usize, usize), step: &'l Step) -> Vec<&'l Symbol> {
    let needs = step.profile.iter().chain(profile_of_served(program, at, step));
    needs.filter(|need| need.amount.is_none()).filter_map(resource_of).collect()
}
