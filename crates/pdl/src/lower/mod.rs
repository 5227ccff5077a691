//! Lowers data to the types of the model: resolves names, checks shapes, reports every error once.
//!
//! Convention: a lowering method returns `None` after it has reported the reason.

mod activity;
mod agent_limits;
mod agents;
mod apart;
mod application;
mod calls;
mod clauses;
mod compose;
mod condition;
mod constants;
mod constraint;
mod cyclic;
mod declarations;
mod derivation;
mod episode;
mod execution;
mod expected;
mod expression;
mod goals;
mod indexes;
mod interface;
mod joined;
mod measurement;
mod misplaced;
mod names;
mod nearly;
mod other_unit;
mod parameters;
mod pattern;
mod placement;
mod primitive;
mod procedure;
mod scope;
mod shared;
mod shipped;
mod slips;
mod slips_in_words;
mod slips_of_tasks;
mod slips_of_variables;
mod special;
mod step;
mod tags;
mod template;
mod timing;
mod unindexed;
mod unserved;

pub(crate) use agents::{NameKind, NameUse};
pub(crate) use goals::{Goal, Served};
pub(crate) use indexes::shape;
pub(crate) use names::{Callable, Names};
pub(crate) use scope::Scope;
pub(crate) use unindexed::Unindexed;

use crate::diagnostic::{Diagnostic, Severity, Span};
use crate::read::Datum;
use apex_model::symbol::Symbol;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Maximum number of stored messages; further ones are dropped.
const DIAGNOSTICS_MAX: usize = 1_000;

/// State of lowering: the definitions so far and the findings.
pub(crate) struct Lowering {
    /// Definitions of all files.
    pub(crate) names: Names,
    /// True if the text is a fragment; undefined names are then notes.
    pub(crate) fragment: bool,
    /// Messages so far.
    pub(crate) diagnostics: Vec<Diagnostic>,
    /// Computed constants met in the present expression.
    pub(crate) constants_used: BTreeSet<Symbol>,
    /// Names of functions that nothing defines, with every use.
    pub(crate) unknown_functions: BTreeMap<Symbol, Vec<Span>>,
    /// Names of indexicals that nothing defines, with every use.
    pub(crate) unknown_indexicals: BTreeMap<Symbol, Vec<Span>>,
    /// Resources that are parts, their wholes, and the places that name these.
    pub(crate) wholes: Vec<(Symbol, Symbol, Span)>,
    /// Goals that steps pursue.
    pub(crate) goals: Vec<Goal>,
    /// Goals that procedures, primitives and solvers serve.
    pub(crate) served: Vec<Served>,
    /// The present procedure, primitive or function.
    pub(crate) scope: Scope,
    /// Context in which effects are forbidden, as words for the message; `None` allows them.
    pub(crate) pure_in: Option<&'static str>,
    /// Functions called since the last reset, to find out which functions have effects.
    pub(crate) called: BTreeSet<Symbol>,
    /// True if an effect was seen since the last reset.
    pub(crate) had_effect: bool,
    /// The bundle of the present forms; `None` is the default bundle.
    pub(crate) bundle: Option<Symbol>,
    /// True if the present index is a solver's.
    pub(crate) is_solver: bool,
    /// Uses of names of agents, routers and bundles that other forms must define.
    pub(crate) named: Vec<NameUse>,
    /// Bundles that `in-apex-bundle` has opened.
    pub(crate) bundle_names: BTreeSet<Symbol>,
    /// Words that are spelt like a variable in the same form, without its question mark.
    pub(crate) suspects: Vec<(Symbol, Span)>,
    /// True if a rejected form may serve goals or define names: these are then not reported as missing.
    pub(crate) refused_form: bool,
    /// The source texts, for fixes that keep a part of the written text.
    pub(crate) texts: Vec<Arc<str>>,
    /// Forms without an index.
    pub(crate) unindexed: Vec<Unindexed>,
}

impl Lowering {
    pub(crate) fn new(names: Names, fragment: bool) -> Lowering {
        Lowering {
            names,
            fragment,
            diagnostics: Vec::new(),
            constants_used: BTreeSet::new(),
            unknown_functions: BTreeMap::new(),
            unknown_indexicals: BTreeMap::new(),
            wholes: Vec::new(),
            goals: Vec::new(),
            served: Vec::new(),
            scope: Scope::default(),
            pure_in: None,
            called: BTreeSet::new(),
            had_effect: false,
            bundle: None,
            is_solver: false,
            named: Vec::new(),
            bundle_names: BTreeSet::new(),
            suspects: Vec::new(),
            refused_form: false,
            texts: Vec::new(),
            unindexed: Vec::new(),
        }
    }

    /// Reports `diagnostic`.
    pub(crate) fn report(&mut self, diagnostic: Diagnostic) {
        if self.diagnostics.len() < DIAGNOSTICS_MAX {
            self.diagnostics.push(diagnostic);
        }
    }

    /// Reports an error and yields nothing, for the end of a lowering method.
    pub(crate) fn refuse<T>(&mut self, diagnostic: Diagnostic) -> Option<T> {
        self.report(diagnostic);
        None
    }

    /// Returns the severity of an undefined name: in a fragment its definition may be elsewhere.
    pub(crate) fn undefined(&self) -> Severity {
        if self.fragment { Severity::Note } else { Severity::Error }
    }

    /// Runs `body` where effects are forbidden.
    pub(crate) fn pure<T>(&mut self, place: &'static str, body: impl FnOnce(&mut Lowering) -> T) -> T {
        let before = self.pure_in.replace(place);
        let result = body(self);
        self.pure_in = before;
        result
    }

    /// Lowers every item; `None` if one of them fails, after all have been lowered.
    pub(crate) fn all<T>(
        &mut self,
        items: &[Datum],
        mut lower: impl FnMut(&mut Lowering, &Datum) -> Option<T>,
    ) -> Option<Vec<T>> {
        let lowered: Vec<Option<T>> = items.iter().map(|item| lower(self, item)).collect();
        lowered.into_iter().collect()
    }
}

/// Returns the span of `items`, or `fallback` without items.
pub(crate) fn span_of(items: &[Datum], fallback: Span) -> Span {
    match (items.first(), items.last()) {
        (Some(first), Some(last)) => first.span.to(last.span),
        _ => fallback,
    }
}
