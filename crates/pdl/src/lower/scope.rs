//! Variables of one procedure, primitive or function: who binds them, who uses them, who sees whom.
//!
//! A procedure's index, `=>` results and step tags are seen by all of its clauses; what a step's waitfor, select or
//! forall binds is seen by that step only.

use super::Lowering;
use crate::codes;
use crate::diagnostic::{Diagnostic, Span};
use crate::suggest::renames_marked;
use apex_model::symbol::Symbol;
use std::collections::{BTreeMap, BTreeSet};

/// Names in force.
#[derive(Default)]
pub(crate) struct Scope {
    /// Step tags of the procedure.
    pub(crate) tags: BTreeMap<Symbol, Span>,
    /// Variables that `=>` binds, with the last step that does.
    pub(crate) results: BTreeMap<Symbol, usize>,
    /// The step being lowered; none at procedure level.
    pub(crate) step: Option<usize>,
    /// Parameters and `let` variables, innermost last; those written `?x` with their question mark.
    pub(crate) locals: Vec<Symbol>,
    /// Patterns bind in the surrounding task: false inside a function or an indexical.
    pub(crate) has_variables: bool,
    /// A condition is being lowered.
    pub(crate) in_condition: bool,
    binders: BTreeMap<Symbol, BTreeMap<Option<usize>, Span>>,
    uses: Vec<(Symbol, Option<usize>, Span)>,
}

impl Scope {
    /// The scope of a procedure or primitive.
    pub(crate) fn of_tasks() -> Scope {
        Scope { has_variables: true, ..Scope::default() }
    }

    /// Is `name` a parameter or `let` variable here?
    pub(crate) fn is_local(&self, name: &Symbol) -> bool {
        self.locals.iter().rev().any(|local| local == name)
    }

    /// Notes that `name` is bound here, visible in the step at hand or, at procedure level, everywhere.
    pub(crate) fn bind(&mut self, name: &Symbol, span: Span) {
        let step = self.step;
        self.bind_in(name, step, span);
    }

    /// Notes that `name` is bound for the whole procedure.
    pub(crate) fn bind_everywhere(&mut self, name: &Symbol, span: Span) {
        self.bind_in(name, None, span);
    }

    fn bind_in(&mut self, name: &Symbol, step: Option<usize>, span: Span) {
        self.binders.entry(name.clone()).or_default().entry(step).or_insert(span);
    }

    /// Is `name` bound for the whole procedure by what has been lowered so far?
    pub(crate) fn is_bound_everywhere(&self, name: &Symbol) -> bool {
        self.is_visible(name, None)
    }

    fn is_visible(&self, name: &Symbol, step: Option<usize>) -> bool {
        self.binders.get(name).is_some_and(|binders| binders.contains_key(&None) || binders.contains_key(&step))
    }

    /// Notes that `name` is used here; checked when the whole procedure is known.
    pub(crate) fn use_variable(&mut self, name: &Symbol, span: Span) {
        self.uses.push((name.clone(), self.step, span));
    }

    /// The step other than the one at hand whose result binds `name`.
    pub(crate) fn is_result_of_another_step(&self, name: &Symbol) -> bool {
        self.results.get(name).is_some_and(|step| Some(*step) != self.step)
    }
}

impl Lowering {
    /// Reports every use of a variable that nothing binds, and forgets the scope. Without a `complete` scope nothing is
    /// reported: a clause that was refused may bind what is missed.
    pub(crate) fn finish_scope(&mut self, complete: bool) {
        let scope = std::mem::take(&mut self.scope);
        if !complete {
            return;
        }
        let mut reported: BTreeSet<&Symbol> = BTreeSet::new();
        for (name, step, span) in &scope.uses {
            if scope.is_visible(name, *step) || !reported.insert(name) {
                continue;
            }
            let message = format!("nothing binds `?{name}`");
            let mut diagnostic = Diagnostic::error(codes::UNBOUND_VARIABLE, *span, message);
            if let Some((_, binder)) = scope.binders.get(name).and_then(|binders| binders.first_key_value()) {
                diagnostic = diagnostic
                    .label(*binder, "bound here, for this step only")
                    .reason("what a step's waitfor, select or forall binds is not seen by other clauses")
                    .help(format!("hand it on as the step's value: `=> ?{name}`"));
            } else {
                let visible = scope.binders.keys().filter(|key| scope.is_visible(key, *step)).map(Symbol::printed);
                let fixes = renames_marked(*span, name.printed(), visible, |name| format!("?{name}"));
                let reason = "a variable gets its value from the index, a `=>`, a waitfor, a select or a forall";
                diagnostic = diagnostic.reason(reason).fixes(fixes);
            }
            self.report(diagnostic);
        }
    }
}
