//! Procedures, primitives and solvers that are never chosen, because a more specific or earlier one serves all of their goals.

use super::methods::Method;
use super::{FindingCollector, Program, walk};
use crate::codes;
use crate::diagnostic::{Diagnostic, Severity};
use crate::lower::shape;
use crate::matching::{View, covers, pattern_head, specificity};
use crate::print::pattern_text;
use apex_model::expression::ExprKind;
use apex_model::limits::MATCH_STEPS_MAX;
use apex_model::pattern::Pattern;
use apex_model::procedure::{Activity, BuiltInActivity};
use apex_model::source::Place;
use apex_model::symbol::Symbol;
use std::collections::BTreeMap;

/// Maximum number of methods with one first word that are compared pairwise.
const COMPARED_MAX: usize = 100;

struct IndexEntry<'l> {
    method: Method,
    index: &'l Pattern,
    bundle: Option<&'l Symbol>,
    place: Place,
}

pub(super) fn check(program: &Program<'_>, report: &mut FindingCollector<'_>) {
    let mut groups: BTreeMap<&Symbol, Vec<IndexEntry<'_>>> = BTreeMap::new();
    for entry in entries(program) {
        if let Some(head) = pattern_head(entry.index) {
            groups.entry(head).or_default().push(entry);
        }
    }
    for group in groups.values().map(|group| group.get(..COMPARED_MAX).unwrap_or(group)) {
        for entry in group {
            if let Some(other) = group.iter().find(|other| hides(program, other, entry)) {
                report_hidden(program, entry, other, report);
            }
        }
    }
}

fn entries<'l>(program: &Program<'l>) -> impl Iterator<Item = IndexEntry<'l>> {
    let library = program.library;
    let procedures = library.procedures.iter().enumerate().map(|(number, each)| IndexEntry {
        method: Method::Procedure(number),
        index: &each.index,
        bundle: each.bundle.as_ref(),
        place: each.place,
    });
    let primitives = library.primitives.iter().enumerate().map(|(number, each)| IndexEntry {
        method: Method::Primitive(number),
        index: &each.index,
        bundle: each.bundle.as_ref(),
        place: each.place,
    });
    let solvers = library.solvers.iter().enumerate().map(|(number, each)| IndexEntry {
        method: Method::Solver(number),
        index: &each.index,
        bundle: None,
        place: each.place,
    });
    procedures.chain(primitives).chain(solvers)
}

/// Returns true if `other` is always chosen where `entry` could be.
fn hides(program: &Program<'_>, other: &IndexEntry<'_>, entry: &IndexEntry<'_>) -> bool {
    if other.method == entry.method || matches!(other.method, Method::Solver(_)) {
        return false;
    }
    let both_used = other.bundle.is_none()
        || other.bundle == entry.bundle
        || program.library.agents.iter().all(|agent| agent.bundles.is_empty());
    let is_solver = matches!(entry.method, Method::Solver(_));
    let (general, special) = (specificity(other.index), specificity(entry.index));
    let wins = is_solver || general > special || general == special && other.method < entry.method;
    let matches_all =
        |shaped: bool| covers(other.index, entry.index) || shaped && shape(other.index) == shape(entry.index);
    // Two with the same shape in one bundle are a separate error.
    both_used && wins && matches_all(other.bundle != entry.bundle) && !(is_solver && is_planned(program, entry.index))
}

/// Returns true if only `plan` activities, which use solvers alone, pursue the goals of this index.
fn is_planned(program: &Program<'_>, index: &Pattern) -> bool {
    let steps = program.library.procedures.iter().flat_map(|procedure| &procedure.steps);
    let mut activities = steps.flat_map(walk::activities);
    activities.any(|activity| match activity {
        Activity::BuiltIn(BuiltInActivity::Plan, arguments) => match arguments.first().map(|goal| &goal.kind) {
            Some(ExprKind::Constant(value)) => {
                crate::matching::may_match(View::Value(value), index, &mut { MATCH_STEPS_MAX })
            }
            Some(ExprKind::Template(template)) => {
                crate::matching::may_match(View::Template(template), index, &mut { MATCH_STEPS_MAX })
            }
            _ => true,
        },
        _ => false,
    })
}

fn report_hidden(
    program: &Program<'_>,
    entry: &IndexEntry<'_>,
    other: &IndexEntry<'_>,
    report: &mut FindingCollector<'_>,
) {
    if program.foreign.contains(&entry.place.file) && program.foreign.contains(&other.place.file) {
        return;
    }
    let span = report.locator.index(entry.place);
    let message = format!("`{}` is never chosen", pattern_text(entry.index));
    let mut diagnostic = Diagnostic::new(Severity::Warning, codes::SHADOWED, span, message)
        .label(report.locator.index(other.place), "this serves all of its goals, and is chosen for them");
    let reason = if matches!(entry.method, Method::Solver(_)) {
        "a solver is asked only where no procedure or primitive serves the goal"
    } else if specificity(other.index) == specificity(entry.index) {
        "the two are equally specific, and the other one comes first"
    } else {
        "the one with fewer variables, then with the longer constant beginning, is the more specific"
    };
    diagnostic = diagnostic.reason(reason);
    report.add(diagnostic.help("make its index more specific, or remove one of the two"));
}
