//! Index of a library, built once to avoid searches at run time: candidates by the first word of a goal, steps by tag, results that steps
//! wait for. Derived from the library alone; never part of a snapshot.

use crate::state::awaited_outcomes as outcomes;
use crate::state::step_clauses::StepClauses;
use crate::state::variable_index::VariableIndex;
use crate::state::walk;
use apex_forms::awaited::Awaited;
use apex_model::condition::{Condition, ConditionKind};
use apex_model::event::COMMAND_STATE;
use apex_model::expression::{Expr, ExprKind};
use apex_model::library::Library;
use apex_model::pattern::Pattern;
use apex_model::procedure::{Hooks, Procedure, ProcedureKind, Repetition, Step};
use apex_model::source::Place;
use apex_model::symbol::Symbol;
use rustc_hash::FxBuildHasher;
use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;

/// Something with an index that may serve a goal. Of equally specific ones the first in this order is taken: a plan made in flight
/// precedes stored procedures for the same goal, because it was requested for use.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum IndexCandidate {
    /// A generated procedure.
    Generated(u64),
    /// A stored procedure.
    Procedure(u32),
    /// A primitive.
    Primitive(u32),
    /// A solver declaration.
    Solver(u32),
}

/// Candidates by the first word of their index.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Heads {
    by_head: HashMap<Symbol, Vec<IndexCandidate>, FxBuildHasher>,
    general: Vec<IndexCandidate>,
}

impl Heads {
    /// Files `candidate` under the first word of `pattern`.
    pub fn insert(&mut self, pattern: &Pattern, candidate: IndexCandidate) {
        match head(pattern) {
            Some(head) => self.by_head.entry(head).or_default().push(candidate),
            None => self.general.push(candidate),
        }
    }

    /// Takes `candidate` out again.
    pub fn remove(&mut self, pattern: &Pattern, candidate: IndexCandidate) {
        let list = match head(pattern) {
            Some(head) => self.by_head.get_mut(&head),
            None => Some(&mut self.general),
        };
        if let Some(list) = list {
            list.retain(|each| *each != candidate);
        }
    }

    /// Returns the candidates for a goal that begins with `head`, in order of filing.
    pub fn candidates(&self, head: Option<&Symbol>) -> impl Iterator<Item = IndexCandidate> {
        let filed = head.and_then(|head| self.by_head.get(head));
        filed.into_iter().flatten().chain(&self.general).copied()
    }
}

/// Returns the symbol with which every value that matches `pattern` begins, if there is one.
fn head(pattern: &Pattern) -> Option<Symbol> {
    match pattern {
        Pattern::Literal(value) => match value.as_list() {
            Some(items) => items.first()?.as_symbol().cloned(),
            None => value.as_symbol().cloned(),
        },
        Pattern::List(parts) => match parts.first()? {
            Pattern::Literal(value) => value.as_symbol().cloned(),
            _ => None,
        },
        _ => None,
    }
}

/// Index of a step.
#[derive(Clone, Debug, PartialEq)]
pub struct StepIndex {
    /// Its preconditions as one condition; `None` without preconditions.
    pub waitfor: Option<Arc<Condition>>,
    /// Results of other steps that its preconditions, activity, `select` or `forall` mention.
    pub awaits: Vec<Symbol>,
    /// The results that its preconditions mention: the preconditions cannot be watched before these exist.
    pub condition_awaits: Vec<Symbol>,
    /// True if the procedure does not end before the step has ended.
    pub counts: bool,
    /// True if a clause of its procedure or of another step names its failure: the procedure then does not fail with it.
    pub failure_awaited: bool,
    /// Steps whose `waitfor` names its outcome.
    pub outcome_waiters: Vec<u32>,
    /// Variables that its `=>` binds.
    pub produces: Vec<Symbol>,
    /// Clauses of the step.
    pub clauses: StepClauses,
}

/// Index of a procedure.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ProcedureIndex {
    /// Steps by tag.
    pub tags: HashMap<Symbol, u32, FxBuildHasher>,
    /// Its steps.
    pub steps: Vec<StepIndex>,
    /// True if the written order gives each step a distinct rank.
    pub ranked_by_order: bool,
    /// Variables whose values may change while the procedure runs: results of steps, and assignments in its forms.
    pub changing: BTreeSet<Symbol>,
}

/// Index of a library.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LibraryIndex {
    /// Procedures and primitives in library order, procedures first.
    pub methods: Heads,
    /// Solver declarations.
    pub solvers: Heads,
    /// By index in the library.
    pub procedures: Vec<Arc<ProcedureIndex>>,
    /// True if the program names `(command-state ..)`: only then states of commands are published.
    pub names_command_states: bool,
    /// State variables by attribute.
    pub variables: VariableIndex,
}

impl LibraryIndex {
    /// Returns the index of `library` for an agent that uses `bundles`; an empty list means all bundles.
    pub fn new(library: &Library, bundles: &[Symbol]) -> LibraryIndex {
        let uses = |bundle: &Option<Symbol>| {
            bundles.is_empty() || bundle.as_ref().is_none_or(|bundle| bundles.contains(bundle))
        };
        let names = |text: &str| text.to_ascii_lowercase().contains(COMMAND_STATE);
        let names_command_states = library.sources.iter().any(|source| names(&source.text));
        let variables = VariableIndex::new(library);
        let mut index = LibraryIndex { names_command_states, variables, ..LibraryIndex::default() };
        for (procedure, number) in library.procedures.iter().zip(0..) {
            if uses(&procedure.bundle) {
                index.methods.insert(&procedure.index, IndexCandidate::Procedure(number));
            }
            index.procedures.push(Arc::new(ProcedureIndex::new(procedure)));
        }
        for (primitive, number) in library.primitives.iter().zip(0..) {
            if uses(&primitive.bundle) {
                index.methods.insert(&primitive.index, IndexCandidate::Primitive(number));
            }
        }
        for (solver, number) in library.solvers.iter().zip(0..) {
            index.solvers.insert(&solver.index, IndexCandidate::Solver(number));
        }
        index
    }
}

impl ProcedureIndex {
    /// Returns the index of `procedure`.
    pub fn new(procedure: &Procedure) -> ProcedureIndex {
        let endless_only = procedure.steps.iter().all(|step| !ends_by_itself(step));
        let awaited = Awaited::new(procedure);
        let named = outcomes::AwaitedOutcomes::new(procedure);
        let steps = procedure.steps.iter().enumerate().map(|(number, step)| {
            let awaits = awaited.by(number);
            StepIndex {
                waitfor: conjunction(&step.waitfor, step.place),
                clauses: StepClauses::of(step, procedure.kind, !awaits.is_empty()),
                awaits,
                condition_awaits: awaited.by_conditions_of(number),
                counts: endless_only || ends_by_itself(step),
                failure_awaited: named.is_failure_of(&step.tag),
                outcome_waiters: named.waiters_for(&step.tag),
                produces: outcomes::produced(step),
            }
        });
        let steps = steps.collect();
        let ranked = matches!(procedure.kind, ProcedureKind::Ranked | ProcedureKind::SoftSequential);
        let by_order = |step: &Step| step.rank.is_none() && step.responding.is_none();
        ProcedureIndex {
            ranked_by_order: ranked && procedure.steps.iter().all(by_order),
            tags: procedure.steps.iter().zip(0..).map(|(step, number)| (step.tag.clone(), number)).collect(),
            steps,
            changing: changing(procedure, awaited.into_produced()),
        }
    }
}

/// Returns the results of steps, and the variables that are assigned by hooks, activities and `select`.
fn changing(procedure: &Procedure, results: impl Iterator<Item = Symbol>) -> BTreeSet<Symbol> {
    let mut names: BTreeSet<Symbol> = results.collect();
    let mut see = |expr: &Expr| {
        if let ExprKind::Assign { name, of_task: true, .. } = &expr.kind {
            names.insert(name.clone());
        }
    };
    let hooks = procedure.steps.iter().map(|step| &step.hooks).chain([&procedure.hooks]);
    let forms = hooks.flat_map(|Hooks { on_start, on_end, on_suspend, on_resume }| {
        [on_start, on_end, on_suspend, on_resume].into_iter().flatten()
    });
    forms.for_each(|form| walk::each(form, &mut see));
    for step in &procedure.steps {
        step.select.iter().for_each(|(_, expr)| walk::each(expr, &mut see));
        walk::each_in_activity(&step.activity, &mut see);
    }
    names
}

/// Returns true if the step ends without a clause; steps that repeat or respond without bound never do.
fn ends_by_itself(step: &Step) -> bool {
    let bounded = |repetition: &Repetition| repetition.while_true.is_some() || repetition.until.is_some();
    step.responding.is_none() && step.repeating.as_deref().is_none_or(bounded)
}

fn conjunction(conditions: &[Condition], place: Place) -> Option<Arc<Condition>> {
    match conditions {
        [] => None,
        [one] => Some(Arc::new(one.clone())),
        several => {
            let place = several.first().map_or(place, |first| first.place);
            Some(Arc::new(Condition { tag: None, kind: ConditionKind::And(several.to_vec(), Vec::new()), place }))
        }
    }
}
