//! Activities that can end, and activities that provably take no time.
//!
//! "Can end" may be true wrongly, "takes no time" may be false wrongly: conclusions from their opposites are proven.

use super::horn::{Horn, HornAtom, Solution};
use super::methods::{Method, Methods};
use super::walk;
use crate::lower::Names;
use apex_model::condition::{Condition, ConditionKind};
use apex_model::expression::{Expr, ExprKind};
use apex_model::library::Library;
use apex_model::procedure::{Activity, BuiltInActivity, Primitive, Procedure, ProcedureKind, Repetition, Step};
use apex_model::symbol::Symbol;
use apex_model::time::Duration;
use apex_model::value::Value;
use std::collections::{BTreeMap, BTreeSet};

/// Nodes of one procedure and its steps.
struct ProcedureNodes {
    whole: HornAtom,
    /// The activity of each step.
    activities: Vec<HornAtom>,
}

struct Nodes {
    procedures: Vec<ProcedureNodes>,
    primitives: Vec<HornAtom>,
}

/// Known endings of one library.
pub(crate) struct Endings {
    ending: (Nodes, Solution),
    instant: (Nodes, Solution),
    /// True if an activity ends a task that is not a step of its procedure: any task may then be ended.
    pub(crate) is_wild: bool,
}

impl Endings {
    /// Determines the endings of `library`.
    pub(crate) fn new(library: &Library, names: &Names, methods: &Methods<'_>) -> Endings {
        let reaches = Reaching::new(library, names);
        Endings {
            ending: ending(library, methods, &reaches),
            instant: instantaneous(library, methods, &reaches),
            is_wild: library.procedures.iter().any(|procedure| ends_strangers(procedure)),
        }
    }

    /// Returns true if the activity of this step may end without a failure.
    pub(crate) fn activity_ends(&self, procedure: usize, step: usize) -> bool {
        let (nodes, solution) = &self.ending;
        let node = nodes.procedures.get(procedure).and_then(|nodes| nodes.activities.get(step));
        node.is_none_or(|node| solution.holds(*node))
    }

    /// Returns true if a task of this method may end without a failure.
    pub(crate) fn ends(&self, method: Method) -> bool {
        holds(&self.ending, method).unwrap_or(true)
    }

    /// Returns true if the activity of this step provably takes no time.
    pub(crate) fn activity_takes_no_time(&self, procedure: usize, step: usize) -> bool {
        let (nodes, solution) = &self.instant;
        let node = nodes.procedures.get(procedure).and_then(|nodes| nodes.activities.get(step));
        node.is_some_and(|node| solution.holds(*node))
    }
}

fn holds((nodes, solution): &(Nodes, Solution), method: Method) -> Option<bool> {
    let node = match method {
        Method::Procedure(number) => nodes.procedures.get(number).map(|nodes| nodes.whole),
        Method::Primitive(number) => nodes.primitives.get(number).copied(),
        Method::Solver(_) => None,
    };
    node.map(|node| solution.holds(node))
}

/// Returns the truth of a constant test; `None` if it is not constant.
pub(crate) fn known_truth(test: Option<&Expr>) -> Option<bool> {
    match &test?.kind {
        ExprKind::Constant(value) => Some(value.is_true()),
        _ => None,
    }
}

/// Returns true for a repetition that none of its clauses ends.
pub(crate) fn is_endless(clause: &Repetition) -> bool {
    let goes_on = clause.while_true.is_none() || known_truth(clause.while_true.as_ref()) == Some(true);
    goes_on && (clause.until.is_none() || known_truth(clause.until.as_ref()) == Some(false))
}

/// Returns true for a step that repeats or responds endlessly by its clause (whatever its tests): the end of its procedure does not wait
/// for it.
pub(crate) fn is_uncounted(step: &Step) -> bool {
    let bounded = |clause: &Repetition| clause.while_true.is_some() || clause.until.is_some();
    step.responding.is_some() || step.repeating.as_deref().is_some_and(|clause| !bounded(clause))
}

/// Returns true if this activity ends the procedure that contains it.
pub(crate) fn ends_procedure(activity: &Activity) -> bool {
    matches!(activity, Activity::Terminate { task: None, .. })
}

/// Returns the tags of the steps that activities of their procedure end.
pub(crate) fn terminated_tags(procedure: &Procedure) -> BTreeSet<&Symbol> {
    let activities = procedure.steps.iter().flat_map(walk::activities);
    let targets = activities.filter_map(|activity| match activity {
        Activity::Terminate { task: Some(task), .. } => match &task.kind {
            ExprKind::Variable { name, .. } => Some(name),
            _ => None,
        },
        _ => None,
    });
    targets.collect()
}

fn ends_strangers(procedure: &Procedure) -> bool {
    let targets = terminated_tags(procedure);
    let strange = |activity: &Activity| match activity {
        Activity::Terminate { task: Some(task), .. } => match &task.kind {
            ExprKind::Variable { .. } => false,
            ExprKind::Indexical(name) => !name.is("this-task"),
            _ => true,
        },
        _ => false,
    };
    let tags: BTreeSet<&Symbol> =
        if targets.is_empty() { BTreeSet::new() } else { procedure.steps.iter().map(|step| &step.tag).collect() };
    !targets.is_subset(&tags) || procedure.steps.iter().flat_map(walk::activities).any(strange)
}

/// Returns the node of a goal: true if one of its methods is, or, with `of_all`, if all of them are. If the methods are undecided, the node
/// is true without `of_all` and false with it.
fn goal_node(horn: &mut Horn, methods: Option<&[Method]>, nodes: &Nodes, of_all: bool) -> HornAtom {
    let Some(methods) = methods.filter(|methods| !methods.is_empty()) else {
        return if of_all { horn.any() } else { horn.fact() };
    };
    let known = |method: &Method| match method {
        Method::Procedure(number) => nodes.procedures.get(*number).map(|nodes| nodes.whole),
        Method::Primitive(number) => nodes.primitives.get(*number).copied(),
        Method::Solver(_) => None,
    };
    let served: Vec<Option<HornAtom>> = methods.iter().map(known).collect();
    if served.contains(&None) {
        return if of_all { horn.any() } else { horn.fact() };
    }
    let node = if of_all { horn.all(served.len()) } else { horn.any() };
    served.into_iter().flatten().for_each(|method| horn.rule(method, node));
    node
}

/// Finds the methods that may end. Waits are assumed to be satisfied.
fn ending(library: &Library, methods: &Methods<'_>, reaches: &Reaching<'_>) -> (Nodes, Solution) {
    let mut horn = Horn::default();
    let mut nodes = Nodes { procedures: Vec::new(), primitives: Vec::new() };
    for primitive in &library.primitives {
        let node = if reaches.never_completes(primitive) { horn.any() } else { horn.fact() };
        nodes.primitives.push(node);
    }
    for procedure in &library.procedures {
        let whole = if ends_at_will(procedure) { horn.fact() } else { horn.any() };
        nodes.procedures.push(ProcedureNodes { whole, activities: Vec::new() });
    }
    for (number, procedure) in library.procedures.iter().enumerate() {
        let terminated = terminated_tags(procedure);
        let awaited = awaited_steps(procedure);
        let done = horn.all(awaited.iter().filter(|awaited| **awaited).count());
        let mut activities = Vec::with_capacity(procedure.steps.len());
        for (index, (step, is_awaited)) in procedure.steps.iter().zip(awaited).enumerate() {
            let activity = match &step.activity {
                Activity::Goal(_) => goal_node(&mut horn, methods.serving_step(number, index), &nodes, false),
                Activity::Terminate { .. } | Activity::BuiltIn(..) => horn.fact(),
            };
            activities.push(activity);
            if !is_awaited {
                continue;
            }
            if is_stopped(step, &terminated) {
                let end = horn.fact();
                horn.rule(end, done);
            } else if !goes_on(procedure, step) {
                let end = if step.forall.is_some() || step.on_failure.is_some() { horn.fact() } else { activity };
                horn.rule(end, done);
            }
        }
        if let Some(nodes) = nodes.procedures.get_mut(number) {
            horn.rule(done, nodes.whole);
            nodes.activities = activities;
        }
    }
    (nodes, horn.solve())
}

/// Returns true if a clause or a terminate step can end the procedure; their conditions are assumed to hold.
fn ends_at_will(procedure: &Procedure) -> bool {
    procedure.transitions.end_when.is_some()
        || procedure.kind != ProcedureKind::Sequential && procedure.steps.iter().any(may_end_procedure)
}

fn may_end_procedure(step: &Step) -> bool {
    walk::activities(step).any(ends_procedure)
}

/// Returns for each step true if it must have ended before the procedure is complete.
fn awaited_steps(procedure: &Procedure) -> Vec<bool> {
    if procedure.kind == ProcedureKind::Sequential {
        let last = procedure.steps.iter().position(may_end_procedure).unwrap_or(procedure.steps.len());
        return (0..procedure.steps.len()).map(|number| number < last).collect();
    }
    let all_uncounted = procedure.steps.iter().all(is_uncounted);
    procedure.steps.iter().map(|step| all_uncounted || !is_uncounted(step)).collect()
}

/// Returns true if something other than its activity may finally end the step.
pub(crate) fn is_stopped(step: &Step, terminated: &BTreeSet<&Symbol>) -> bool {
    step.transitions.end_when.is_some() || terminated.contains(&step.tag)
}

/// Returns true if the step begins again whenever it ends. In a sequence one response suffices for the next step.
pub(crate) fn goes_on(procedure: &Procedure, step: &Step) -> bool {
    let responding = step.responding.as_deref().filter(|_| procedure.kind != ProcedureKind::Sequential);
    step.repeating.as_deref().or(responding).is_some_and(is_endless)
}

/// Finds the methods that provably take no time once they have begun.
fn instantaneous(library: &Library, methods: &Methods<'_>, reaches: &Reaching<'_>) -> (Nodes, Solution) {
    let mut horn = Horn::default();
    let mut nodes = Nodes { procedures: Vec::new(), primitives: Vec::new() };
    for primitive in &library.primitives {
        let node = if reaches.completes_at_once(primitive) { horn.fact() } else { horn.any() };
        nodes.primitives.push(node);
    }
    for procedure in &library.procedures {
        let whole = if is_plain(procedure) { horn.all(procedure.steps.len()) } else { horn.any() };
        nodes.procedures.push(ProcedureNodes { whole, activities: Vec::new() });
    }
    for (number, procedure) in library.procedures.iter().enumerate() {
        let mut activities = Vec::with_capacity(procedure.steps.len());
        for (index, step) in procedure.steps.iter().enumerate() {
            let activity = match &step.activity {
                Activity::Goal(_) => goal_node(&mut horn, methods.serving_step(number, index), &nodes, true),
                Activity::Terminate { .. } => horn.fact(),
                Activity::BuiltIn(BuiltInActivity::AskOperator | BuiltInActivity::Plan, _) => horn.any(),
                Activity::BuiltIn(BuiltInActivity::HoldResource, _) => horn.any(),
                Activity::BuiltIn(..) => horn.fact(),
            };
            activities.push(activity);
            if let Some(nodes) = nodes.procedures.get(number).filter(|_| is_plain(procedure)) {
                let waits_for_steps = step.waitfor.iter().all(|each| is_end_of(each).is_some());
                if waits_for_steps && is_plain_step(step) && step.repeating.is_none() && step.responding.is_none() {
                    horn.rule(activity, nodes.whole);
                }
            }
        }
        if let Some(nodes) = nodes.procedures.get_mut(number) {
            nodes.activities = activities;
        }
    }
    (nodes, horn.solve())
}

/// Returns the step for whose end the condition waits; `None` if it waits for anything else.
pub(crate) fn is_end_of(condition: &Condition) -> Option<&Symbol> {
    match &condition.kind {
        ConditionKind::TaskEnded(tag) => Some(tag),
        _ => None,
    }
}

/// Returns true if the procedure has steps and nothing else decides when it begins, pauses or ends.
pub(crate) fn is_plain(procedure: &Procedure) -> bool {
    let transitions = walk::transitions(&procedure.transitions).next().is_none();
    transitions && procedure.profile.is_empty() && !procedure.steps.is_empty()
}

/// Returns true if nothing but its waitfor decides when the step begins, pauses or ends.
pub(crate) fn is_plain_step(step: &Step) -> bool {
    let transitions = walk::transitions(&step.transitions).next().is_none();
    transitions && step.profile.is_empty()
}

/// Functions that complete a primitive or send a command, directly or through the functions that they call.
struct Reaching<'l> {
    acting: BTreeSet<&'l Symbol>,
    names: &'l Names,
}

impl<'l> Reaching<'l> {
    fn new(library: &'l Library, names: &'l Names) -> Reaching<'l> {
        let mut callers: BTreeMap<&Symbol, Vec<&'l Symbol>> = BTreeMap::new();
        let mut acting = BTreeSet::new();
        let mut open: Vec<&'l Symbol> =
            library.host_functions.iter().filter(|(_, function)| function.command).map(|(name, _)| name).collect();
        for (name, function) in &library.functions {
            walk::exprs(&function.body, &mut |expr| {
                if let ExprKind::Call { function, .. } | ExprKind::FunctionName(function) = &expr.kind {
                    callers.entry(function).or_default().push(name);
                    if matches!(function.folded(), "complete" | "command") {
                        open.push(name);
                    }
                }
            });
        }
        while let Some(name) = open.pop() {
            if acting.insert(name) {
                open.extend(callers.get(name).into_iter().flatten());
            }
        }
        Reaching { acting, names }
    }

    fn acts(&self, primitive: &Primitive) -> bool {
        let mut acts = false;
        walk::primitive(primitive, &mut |expr| {
            if let ExprKind::Call { function, .. } | ExprKind::FunctionName(function) = &expr.kind {
                // An undefined function may do anything.
                acts |= matches!(function.folded(), "complete" | "command")
                    || self.acting.contains(function)
                    || !self.names.is_operator(function);
            }
        });
        acts
    }

    /// Returns true if the primitive has no duration, no form completes it, and no answer to a command can.
    fn never_completes(&self, primitive: &Primitive) -> bool {
        primitive.duration.is_none() && primitive.update.is_some() && !self.acts(primitive)
    }

    fn completes_at_once(&self, primitive: &Primitive) -> bool {
        let no_clock = match &primitive.duration {
            None => primitive.update.is_none(),
            Some(duration) => matches!(
                &duration.kind,
                ExprKind::Constant(Value::Integer(0)) | ExprKind::Constant(Value::Duration(Duration::ZERO))
            ),
        };
        no_clock && primitive.profile.is_empty() && !self.acts(primitive)
    }
}

/// Returns the primitives that never complete, by their index in the library.
pub(crate) fn never_completing(library: &Library, names: &Names) -> Vec<usize> {
    let reaches = Reaching::new(library, names);
    let numbered = library.primitives.iter().enumerate();
    numbered.filter(|(_, primitive)| reaches.never_completes(primitive)).map(|(number, _)| number).collect()
}
