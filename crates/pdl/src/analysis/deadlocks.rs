//! Resources that are taken in opposite orders by steps that run at the same time: each may hold what the other needs.
//!
//! The result is a warning, because the times decide whether the tasks meet. Orders are read from constant names of resources that one
//! task at a time takes whole; resources of one profile are taken together and have no order.

use super::methods::Method;
use super::{FindingCollector, Program};
use crate::codes;
use crate::diagnostic::{Diagnostic, Severity};
use apex_model::condition::{Condition, ConditionKind};
use apex_model::expression::{ExprKind, Template};
use apex_model::procedure::{Activity, BuiltInActivity, Procedure, ProcedureKind, ResourceNeed, Step};
use apex_model::source::Place;
use apex_model::symbol::Symbol;
use std::collections::BTreeSet;

/// Maximum depth to which the procedures that serve a step's goals are followed.
const DEPTH_MAX: usize = 12;
/// Maximum number of orders of one step that are compared with those of others.
const ORDERS_MAX: usize = 200;
/// Maximum number of tasks in one circle.
const CIRCLE_MAX: usize = 4;

/// A resource with the place of its request.
type Taken<'l> = (&'l Symbol, Place);

/// A task requests `needed` while it holds `held`.
#[derive(Clone)]
struct AcquisitionOrder<'l> {
    held: Taken<'l>,
    needed: Taken<'l>,
    /// All resources that the task holds at that request.
    all: Vec<&'l Symbol>,
}

pub(super) fn check(program: &Program<'_>, report: &mut FindingCollector<'_>) {
    let mut told = BTreeSet::new();
    for (number, procedure) in program.library.procedures.iter().enumerate() {
        if procedure.kind == ProcedureKind::Sequential || procedure.steps.len() < 2 {
            continue;
        }
        let orders: Vec<Vec<AcquisitionOrder<'_>>> =
            (0..procedure.steps.len()).map(|step| of_step(program, number, step)).collect();
        for start in 0..orders.len() {
            for first in orders.get(start).into_iter().flatten() {
                let mut circle = vec![(start, first)];
                if close(procedure, &orders, &mut circle) && told.insert(key(&circle)) {
                    warn(procedure, &circle, report);
                }
            }
        }
    }
}

/// Returns the resources of a circle, in a fixed order: each circle is reported once.
fn key(circle: &[(usize, &AcquisitionOrder<'_>)]) -> Vec<String> {
    let mut names: Vec<String> = circle.iter().map(|(_, order)| order.held.0.folded().to_string()).collect();
    names.sort();
    names
}

/// Returns the orders that arise in a step and below it; it holds nothing when it begins.
fn of_step<'l>(program: &Program<'l>, procedure: usize, step: usize) -> Vec<AcquisitionOrder<'l>> {
    let mut orders = Vec::new();
    if let Some(found) = program.library.procedures.get(procedure).and_then(|each| each.steps.get(step)) {
        pursue(program, (procedure, step), found, &mut Vec::new(), &mut orders, 0);
    }
    orders
}

fn pursue<'l>(
    program: &Program<'l>,
    (procedure, number): (usize, usize),
    step: &'l Step,
    held: &mut Vec<Taken<'l>>,
    orders: &mut Vec<AcquisitionOrder<'l>>,
    depth: usize,
) {
    if depth > DEPTH_MAX || orders.len() >= ORDERS_MAX {
        return;
    }
    let Activity::Goal(goal) = &step.activity else { return };
    let [only] = program.methods.serving_step(procedure, number).unwrap_or_default() else { return };
    if !program.methods.surely(goal, *only) {
        return;
    }
    let before = held.len();
    match *only {
        Method::Procedure(inner) => {
            let Some(method) = program.library.procedures.get(inner) else { return };
            take(step.profile.iter().chain(&method.profile), held, orders);
            within(program, inner, method, held, orders, depth + 1);
        }
        Method::Primitive(inner) => {
            let Some(method) = program.library.primitives.get(inner) else { return };
            take(step.profile.iter().chain(&method.profile), held, orders);
        }
        Method::Solver(_) => {}
    }
    held.truncate(before);
}

/// Collects the orders of resources in the steps of a procedure, while `held` is held. In a sequence, a resource that one step holds is
/// held for all later ones.
fn within<'l>(
    program: &Program<'l>,
    number: usize,
    procedure: &'l Procedure,
    held: &mut Vec<Taken<'l>>,
    orders: &mut Vec<AcquisitionOrder<'l>>,
    depth: usize,
) {
    for (index, step) in procedure.steps.iter().enumerate() {
        match &step.activity {
            Activity::BuiltIn(BuiltInActivity::HoldResource, names) if procedure.kind == ProcedureKind::Sequential => {
                let taken = names.iter().filter_map(|name| match &name.kind {
                    ExprKind::Constant(value) => Some((value.as_symbol()?, step.place)),
                    ExprKind::Template(template) => match template.as_ref() {
                        Template::Constant(value) => Some((value.as_symbol()?, step.place)),
                        _ => None,
                    },
                    _ => None,
                });
                add(taken.collect(), held, orders);
            }
            // Released resources are not analysed: fewer orders are found than exist.
            Activity::BuiltIn(BuiltInActivity::ReleaseResource, _) => return,
            _ => pursue(program, (number, index), step, held, orders, depth),
        }
    }
}

fn take<'l>(
    needs: impl Iterator<Item = &'l ResourceNeed>,
    held: &mut Vec<Taken<'l>>,
    orders: &mut Vec<AcquisitionOrder<'l>>,
) {
    let whole = needs.filter(|need| need.amount.is_none());
    let taken = whole.filter_map(|need| match &need.resource {
        Template::Constant(value) => Some((value.as_symbol()?, need.place)),
        _ => None,
    });
    add(taken.collect(), held, orders);
}

fn add<'l>(taken: Vec<Taken<'l>>, held: &mut Vec<Taken<'l>>, orders: &mut Vec<AcquisitionOrder<'l>>) {
    let new: Vec<Taken<'l>> = taken.into_iter().filter(|(name, _)| held.iter().all(|(has, _)| has != name)).collect();
    let all: Vec<&Symbol> = held.iter().map(|(name, _)| *name).collect();
    for needed in &new {
        for holding in held.iter().take(ORDERS_MAX.saturating_sub(orders.len())) {
            orders.push(AcquisitionOrder { held: *holding, needed: *needed, all: all.clone() });
        }
    }
    held.extend(new);
}

/// Extends the chain until its last task needs what the first one holds. Returns true if that succeeds.
fn close<'a, 'l>(
    procedure: &Procedure,
    orders: &'a [Vec<AcquisitionOrder<'l>>],
    circle: &mut Vec<(usize, &'a AcquisitionOrder<'l>)>,
) -> bool {
    let (Some((_, first)), Some((_, last))) = (circle.first().copied(), circle.last().copied()) else { return false };
    if circle.len() > 1 && last.needed.0 == first.held.0 {
        return true;
    }
    if circle.len() == CIRCLE_MAX {
        return false;
    }
    for (step, of_step) in orders.iter().enumerate() {
        let meets = |other: &usize| run_together(procedure, *other, step);
        if !circle.iter().map(|(other, _)| other).all(meets) {
            continue;
        }
        for next in of_step.iter().filter(|order| order.held.0 == last.needed.0) {
            // Two tasks that hold a resource in common at these requests run in sequence and cannot block each other.
            let is_kept_apart = circle.iter().any(|(_, other)| other.all.iter().any(|name| next.all.contains(name)));
            if is_kept_apart {
                continue;
            }
            circle.push((step, next));
            if close(procedure, orders, circle) {
                return true;
            }
            circle.pop();
        }
    }
    false
}

/// Returns true for two different steps, neither of which waits for a task. A wait for any third step counts too: fewer circles are found
/// than exist.
fn run_together(procedure: &Procedure, one: usize, other: usize) -> bool {
    let (Some(a), Some(b)) = (procedure.steps.get(one), procedure.steps.get(other)) else { return false };
    one != other && !waits_for_steps(a) && !waits_for_steps(b)
}

fn waits_for_steps(step: &Step) -> bool {
    let mut found = false;
    let mut look = |condition: &Condition| {
        found |= matches!(condition.kind, ConditionKind::TaskEnded(_) | ConditionKind::TaskState { .. });
    };
    for condition in &step.waitfor {
        super::walk::conditions(condition, &mut |each| look(each));
    }
    found
}

fn warn(procedure: &Procedure, circle: &[(usize, &AcquisitionOrder<'_>)], report: &mut FindingCollector<'_>) {
    let Some((_, first)) = circle.first() else { return };
    let tag = |step: usize| procedure.steps.get(step).map(|step| step.tag.to_string()).unwrap_or_default();
    let one = |(step, order): &(usize, &AcquisitionOrder<'_>)| {
        format!("`{}` holds `{}` and needs `{}`", tag(*step), order.held.0, order.needed.0)
    };
    let sentences: Vec<String> = circle.iter().map(one).collect();
    let names: Vec<String> = circle.iter().map(|(step, _)| format!("`{}`", tag(*step))).collect();
    let (last, others) = names.split_last().map_or(("", &[][..]), |(last, others)| (last.as_str(), others));
    let message = format!("{} and {last} may wait for each other's resources without end", others.join(", "));
    let span = report.locator.span(first.needed.1);
    let mut diagnostic = Diagnostic::new(Severity::Warning, codes::DEADLOCK, span, message);
    for (step, order) in circle.iter().skip(1) {
        let text = format!("`{}` needs `{}` here", tag(*step), order.needed.0);
        diagnostic = diagnostic.label(report.locator.span(order.needed.1), text);
    }
    report.add(
        diagnostic
            .reason(format!("they run at the same time: {}", sentences.join("; ")))
            .help("ask for the resources in the same order everywhere, or for all of them in one profile"),
    );
}
