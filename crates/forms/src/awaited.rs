//! Results of steps that other steps of the same procedure wait for.

use crate::variables;
use apex_model::procedure::{Procedure, ProcedureKind};
use apex_model::symbol::Symbol;
use std::collections::{BTreeMap, BTreeSet};

/// Results of steps that other steps of the same procedure wait for.
#[derive(Debug)]
pub struct Awaited<'p> {
    procedure: &'p Procedure,
    /// Steps by the variables that their `=>` binds.
    producers: BTreeMap<Symbol, Vec<usize>>,
}

impl<'p> Awaited<'p> {
    /// Collects the variables that the steps of `procedure` bind by `=>`.
    pub fn new(procedure: &'p Procedure) -> Awaited<'p> {
        let mut producers: BTreeMap<Symbol, Vec<usize>> = BTreeMap::new();
        for (number, step) in procedure.steps.iter().enumerate() {
            step.binds.iter().for_each(|pattern| {
                variables::of_pattern(pattern, &mut |name| producers.entry(name.clone()).or_default().push(number));
            });
        }
        Awaited { procedure, producers }
    }

    /// Returns the results of other steps that the step with this number mentions, each once.
    pub fn by(&self, step: usize) -> Vec<Symbol> {
        self.mentioned(step, false)
    }

    /// Returns the results of other steps that the step's preconditions mention, each once.
    pub fn by_conditions_of(&self, step: usize) -> Vec<Symbol> {
        self.mentioned(step, true)
    }

    /// Returns the variables that the procedure's steps bind by `=>`, in order.
    pub fn into_produced(self) -> impl Iterator<Item = Symbol> {
        self.producers.into_keys()
    }

    fn is_produced_by_another(&self, name: &Symbol, number: usize) -> bool {
        let sequential = self.procedure.kind == ProcedureKind::Sequential;
        let producers = self.producers.get(name).map(Vec::as_slice).unwrap_or_default();
        producers.iter().any(|producer| *producer != number && (!sequential || *producer < number))
    }

    fn mentioned(&self, number: usize, in_conditions: bool) -> Vec<Symbol> {
        let mut awaited = Vec::new();
        let Some(step) = self.procedure.steps.get(number).filter(|_| !self.producers.is_empty()) else {
            return awaited;
        };
        let own: BTreeSet<&Symbol> =
            step.select.iter().map(|(name, _)| name).chain(step.forall.iter().map(|forall| &forall.0)).collect();
        let mut sink = |name: &Symbol| {
            if !own.contains(name) && !awaited.contains(name) && self.is_produced_by_another(name, number) {
                awaited.push(name.clone());
            }
        };
        step.waitfor.iter().for_each(|condition| variables::of_condition(condition, &mut sink));
        if in_conditions {
            return awaited;
        }
        variables::of_activity(&step.activity, &mut sink);
        step.select.iter().for_each(|(_, expr)| variables::of_expr(expr, &mut sink));
        step.forall.iter().for_each(|forall| variables::of_expr(&forall.1, &mut sink));
        awaited
    }
}
