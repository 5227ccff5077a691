//! Steps that can begin, and the waits of the others that are never satisfied.
//!
//! A step begins when the preceding step of a sequence has ended finally, its waitfor holds, and the results that it uses exist. A step
//! for which this cannot be derived never begins; the reason is searched afterwards.

use super::endings::{Endings, ends_procedure, goes_on, is_stopped, terminated_tags};
use super::horn::{Horn, HornAtom, Solution};
use super::impossible::impossible;
use super::walk;
use crate::lookup::Lookup;
use apex_forms::awaited::Awaited;
use apex_forms::variables;
use apex_model::condition::{Condition, ConditionKind};
use apex_model::expression::{Expr, ExprKind};
use apex_model::library::Library;
use apex_model::pattern::Pattern;
use apex_model::procedure::{Procedure, ProcedureKind, Step};
use apex_model::source::Place;
use apex_model::symbol::Symbol;
use std::collections::{BTreeMap, BTreeSet};

/// A fact that must hold before a step begins.
#[derive(Clone, Debug)]
pub(crate) enum Premise {
    /// The end of an instance of the step with this number.
    End { step: usize, place: Place },
    /// The preceding step of the sequence.
    Sequence { step: usize },
    /// The condition that the step with this number has begun.
    Begin { step: usize, place: Place },
    /// A result that one of these steps binds.
    Result { name: Symbol, steps: Vec<usize> },
    /// A state of the step's own task that the task reaches only after its beginning.
    OwnState { place: Place },
    /// A condition that can never hold; a separate message states the reason.
    Impossible,
}

enum Need {
    Leaf(Premise),
    All(Vec<Need>),
    Any(Vec<Need>),
    Free,
}

/// Reason for which a step never begins.
#[derive(Debug)]
pub(crate) enum Blocked {
    /// Steps of a circle, each with its wait: for the next step, and the last one for the first.
    Circle(Vec<(usize, Premise)>),
    /// This step waits for another that begins, but does not end.
    Endless(usize, Premise),
    /// This step waits for its own later state.
    OwnState(usize, Place),
    /// Another message gives the reason.
    Told,
}

/// The waits of one procedure.
pub(crate) struct Waits<'l> {
    procedure: &'l Procedure,
    number: usize,
    endings: &'l Endings,
    needs: Vec<Need>,
    begins: Vec<HornAtom>,
    ends: Vec<HornAtom>,
    done: Vec<HornAtom>,
    solution: Solution,
}

impl<'l> Waits<'l> {
    /// Returns the waits of the procedure with this number; `None` if all of its steps begin, because they wait for nothing, or only for
    /// earlier steps that end.
    pub(crate) fn new(library: &'l Library, number: usize, endings: &'l Endings) -> Option<Waits<'l>> {
        let procedure = library.procedures.get(number)?;
        let is_sequence = procedure.kind == ProcedureKind::Sequential && procedure.steps.len() > 1;
        let waits = |step: &Step| !step.waitfor.is_empty() || step.binds.is_some();
        let passes = |(index, step): (usize, &Step)| can_end(step, number, index, endings) && !goes_on(procedure, step);
        let mut before_last = procedure.steps.iter().enumerate().take(procedure.steps.len().saturating_sub(1));
        if !procedure.steps.iter().any(waits) && (!is_sequence || before_last.all(passes)) {
            return None;
        }
        let needs = needs_of(library, procedure);
        let terminated = terminated_tags(procedure);
        if all_begin_in_order(procedure, number, endings, &needs, &terminated) {
            return None;
        }
        let mut horn = Horn::default();
        let begins: Vec<HornAtom> = needs.iter().map(|_| horn.any()).collect();
        let ends: Vec<HornAtom> = needs.iter().map(|_| horn.any()).collect();
        let done: Vec<HornAtom> = needs.iter().map(|_| horn.any()).collect();
        for (step, need) in needs.iter().enumerate() {
            let Some(template) = procedure.steps.get(step) else { continue };
            let nodes = (begins.get(step), ends.get(step), done.get(step));
            let (Some(begin), Some(end), Some(finish)) = nodes else { continue };
            let needed = node_of(&mut horn, need, &begins, &ends, &done);
            horn.rule(needed, *begin);
            if is_stopped(template, &terminated) {
                let stopped = horn.fact();
                horn.rule(stopped, *end);
                horn.rule(stopped, *finish);
            }
            if can_end(template, number, step, endings) {
                horn.rule(*begin, *end);
                if !goes_on(procedure, template) {
                    horn.rule(*end, *finish);
                }
            }
        }
        let solution = horn.solve();
        Some(Waits { procedure, number, endings, needs, begins, ends, done, solution })
    }

    /// Returns true if the step may begin.
    pub(crate) fn begins(&self, step: usize) -> bool {
        self.begins.get(step).is_none_or(|node| self.solution.holds(*node))
    }

    /// Returns true if the step's activity ends once it has begun.
    pub(crate) fn activity_ends(&self, step: usize) -> bool {
        self.procedure.steps.get(step).is_none_or(|template| can_end(template, self.number, step, self.endings))
    }

    /// Returns every reason why steps never begin, each once, in order of the first step concerned.
    pub(crate) fn blocked(&self) -> Vec<Blocked> {
        let mut found = Vec::new();
        // For each visited step, the step at which that walk began.
        let mut seen: BTreeMap<usize, usize> = BTreeMap::new();
        for start in (0..self.needs.len()).filter(|step| !self.begins(*step)) {
            let mut path: Vec<(usize, Premise)> = Vec::new();
            let mut step = start;
            loop {
                if let Some(walk) = seen.get(&step) {
                    if *walk == start {
                        let first = path.iter().position(|(each, _)| *each == step).unwrap_or(0);
                        found.push(Blocked::Circle(path.split_off(first)));
                    }
                    break;
                }
                seen.insert(step, start);
                let Some(premise) = self.needs.get(step).and_then(|need| self.unmet(need)) else { break };
                let next = match &premise {
                    Premise::OwnState { place } => {
                        found.push(Blocked::OwnState(step, *place));
                        break;
                    }
                    Premise::Impossible => {
                        found.push(Blocked::Told);
                        break;
                    }
                    Premise::End { step, .. } | Premise::Sequence { step } | Premise::Begin { step, .. } => *step,
                    Premise::Result { steps, .. } => match steps.first() {
                        Some(step) => *step,
                        None => break,
                    },
                };
                if self.begins(next) {
                    found.push(Blocked::Endless(step, premise));
                    break;
                }
                path.push((step, premise));
                step = next;
            }
        }
        found
    }

    /// Returns the first premise that is not met.
    fn unmet(&self, need: &Need) -> Option<Premise> {
        match need {
            Need::Free => None,
            Need::Leaf(premise) => (!self.is_met(premise)).then(|| premise.clone()),
            Need::All(parts) => parts.iter().find_map(|part| self.unmet(part)),
            Need::Any(parts) => {
                let unmet: Vec<Option<Premise>> = parts.iter().map(|part| self.unmet(part)).collect();
                if unmet.iter().any(Option::is_none) { None } else { unmet.into_iter().flatten().next() }
            }
        }
    }

    fn is_met(&self, premise: &Premise) -> bool {
        let holds = |nodes: &[HornAtom], step: usize| nodes.get(step).is_none_or(|node| self.solution.holds(*node));
        match premise {
            Premise::End { step, .. } => holds(&self.ends, *step),
            Premise::Sequence { step } => holds(&self.done, *step),
            Premise::Begin { step, .. } => holds(&self.begins, *step),
            Premise::Result { steps, .. } => steps.iter().any(|step| holds(&self.ends, *step)),
            Premise::OwnState { .. } | Premise::Impossible => false,
        }
    }
}

/// Returns true if every step can begin after the earlier steps have done all they can. This holds for most procedures, and a single pass
/// through the steps then replaces many rules.
fn all_begin_in_order(
    procedure: &Procedure,
    number: usize,
    endings: &Endings,
    needs: &[Need],
    terminated: &BTreeSet<&Symbol>,
) -> bool {
    // For each earlier step: true if it ends, true if it has ended finally.
    let mut before: Vec<(bool, bool)> = Vec::with_capacity(needs.len());
    procedure.steps.iter().zip(needs).enumerate().all(|(index, (step, need))| {
        let begins = is_met_by(&before, need);
        let stopped = is_stopped(step, terminated);
        let ends = can_end(step, number, index, endings);
        before.push((stopped || ends, stopped || ends && !goes_on(procedure, step)));
        begins
    })
}

/// Returns true if `need` is met once the steps `before` have begun.
fn is_met_by(before: &[(bool, bool)], need: &Need) -> bool {
    let step = |step: &usize| before.get(*step);
    match need {
        Need::Free => true,
        Need::Leaf(Premise::End { step: other, .. }) => step(other).is_some_and(|(ends, _)| *ends),
        Need::Leaf(Premise::Sequence { step: other }) => step(other).is_some_and(|(_, for_good)| *for_good),
        Need::Leaf(Premise::Begin { step: other, .. }) => step(other).is_some(),
        Need::Leaf(Premise::Result { steps, .. }) => steps.iter().filter_map(step).any(|(ends, _)| *ends),
        Need::Leaf(Premise::OwnState { .. } | Premise::Impossible) => false,
        Need::All(parts) => parts.iter().all(|part| is_met_by(before, part)),
        Need::Any(parts) => parts.iter().any(|part| is_met_by(before, part)),
    }
}

/// Returns true if a begun instance of the step may end while its procedure continues.
fn can_end(step: &Step, procedure: usize, number: usize, endings: &Endings) -> bool {
    let handled = step.on_failure.is_some() || step.forall.is_some();
    handled || !ends_procedure(&step.activity) && endings.activity_ends(procedure, number)
}

fn node_of(horn: &mut Horn, need: &Need, begins: &[HornAtom], ends: &[HornAtom], done: &[HornAtom]) -> HornAtom {
    let known = |nodes: &[HornAtom], step: usize| nodes.get(step).copied();
    match need {
        Need::Free => horn.fact(),
        Need::Leaf(Premise::End { step, .. }) => known(ends, *step).unwrap_or_else(|| horn.fact()),
        Need::Leaf(Premise::Sequence { step }) => known(done, *step).unwrap_or_else(|| horn.fact()),
        Need::Leaf(Premise::Begin { step, .. }) => known(begins, *step).unwrap_or_else(|| horn.fact()),
        Need::Leaf(Premise::Result { steps, .. }) => {
            let node = horn.any();
            steps.iter().filter_map(|step| known(ends, *step)).for_each(|end| horn.rule(end, node));
            node
        }
        Need::Leaf(Premise::OwnState { .. } | Premise::Impossible) => horn.any(),
        Need::All(parts) => {
            let node = horn.all(parts.len());
            for part in parts {
                let part = node_of(horn, part, begins, ends, done);
                horn.rule(part, node);
            }
            node
        }
        Need::Any(parts) => {
            let node = horn.any();
            for part in parts {
                let part = node_of(horn, part, begins, ends, done);
                horn.rule(part, node);
            }
            node
        }
    }
}

fn needs_of(library: &Library, procedure: &Procedure) -> Vec<Need> {
    let tags: Lookup<&Symbol, usize> =
        procedure.steps.iter().enumerate().map(|(number, step)| (&step.tag, number)).collect();
    let results = StepResults::new(procedure);
    let reader = NeedReader { library, tags };
    let sequential = procedure.kind == ProcedureKind::Sequential;
    let steps = procedure.steps.iter().enumerate();
    let needs = steps.map(|(number, step)| {
        let mut parts: Vec<Need> = step.waitfor.iter().map(|each| reader.need(each, number)).collect();
        if sequential && number > 0 {
            parts.push(Need::Leaf(Premise::Sequence { step: number - 1 }));
        }
        parts.extend(results.needs(number));
        Need::All(parts.into_iter().filter(|part| !matches!(part, Need::Free)).collect())
    });
    needs.collect()
}

/// Results of steps that other steps wait for.
struct StepResults<'l> {
    awaited: Option<Awaited<'l>>,
    producers: Lookup<Symbol, Vec<usize>>,
}

impl<'l> StepResults<'l> {
    fn new(procedure: &'l Procedure) -> StepResults<'l> {
        let mut producers: Lookup<Symbol, Vec<usize>> = Lookup::default();
        for (number, step) in procedure.steps.iter().enumerate() {
            step.binds.iter().for_each(|pattern| {
                variables::of_pattern(pattern, &mut |name| producers.or_insert(name, Vec::new()).push(number));
            });
        }
        if producers.is_empty() {
            return StepResults { awaited: None, producers };
        }
        // Variables that the index or a hook binds do not need the step.
        variables::of_pattern(&procedure.index, &mut |name| {
            producers.remove(name);
        });
        walk::procedure(procedure, &mut |expr| {
            if let ExprKind::Assign { name, of_task: true, .. } = &expr.kind {
                producers.remove(name);
            }
        });
        StepResults { awaited: Some(Awaited::new(procedure)), producers }
    }

    fn needs(&self, step: usize) -> Vec<Need> {
        let awaits = self.awaited.as_ref().map(|awaited| awaited.by(step)).unwrap_or_default();
        let results = awaits.into_iter().filter_map(|name| {
            let steps: Vec<usize> =
                self.producers.get(&name)?.iter().copied().filter(|producer| *producer != step).collect();
            Some(Need::Leaf(Premise::Result { name, steps }))
        });
        results.collect()
    }
}

/// Reads conditions as needs.
struct NeedReader<'l> {
    library: &'l Library,
    tags: Lookup<&'l Symbol, usize>,
}

impl NeedReader<'_> {
    fn need(&self, condition: &Condition, own: usize) -> Need {
        if impossible(condition, self.library).is_some() {
            return Need::Leaf(Premise::Impossible);
        }
        let parts = |parts: &[Condition]| parts.iter().map(|part| self.need(part, own)).collect::<Vec<_>>();
        match &condition.kind {
            ConditionKind::And(all, _) | ConditionKind::InOrder(all, _) | ConditionKind::Allen { parts: all, .. } => {
                Need::All(parts(all))
            }
            ConditionKind::Or(some, _) => Need::Any(parts(some)),
            ConditionKind::TaskEnded(tag) => match self.tags.get(&tag) {
                Some(step) => Need::Leaf(Premise::End { step: *step, place: condition.place }),
                None => Need::Free,
            },
            ConditionKind::TaskState { task, state } => self.state(task, state, condition.place, own),
            _ => Need::Free,
        }
    }

    fn state(&self, task: &Expr, state: &Pattern, place: Place, own: usize) -> Need {
        let step = match &task.kind {
            ExprKind::Indexical(name) if name.is("this-task") => Some(own),
            ExprKind::Variable { name, .. } => self.tags.get(&name).copied(),
            _ => None,
        };
        let word = match state {
            Pattern::Literal(value) => value.as_symbol(),
            _ => None,
        };
        let (Some(step), Some(word)) = (step, word) else { return Need::Free };
        match word.folded() {
            "pending" => Need::Free,
            _ if step == own => Need::Leaf(Premise::OwnState { place }),
            "terminated" => Need::Leaf(Premise::End { step, place }),
            _ => Need::Leaf(Premise::Begin { step, place }),
        }
    }
}

/// Returns the tags of steps in a row, human-readable.
pub(crate) fn tags(procedure: &Procedure, steps: impl IntoIterator<Item = usize>) -> Vec<String> {
    let steps = steps.into_iter().filter_map(|step| procedure.steps.get(step));
    steps.map(|step| format!("`{}`", step.tag)).collect()
}
