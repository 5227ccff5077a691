//! Index matching (TC)
//! What: matches a goal against the index of a procedure, primitive or solver.
//! Runs: choose phase.
//! Reads: Library, generated procedures.
//! Writes: bindings of the index.
//! Bound: O(size of the pattern).
//! PDL: `index`, section 2.
//! Paper: section III, selection services.

use crate::control::cycle::Cycle;
use crate::expression::EvaluationError;
use crate::monitoring::pattern_matching::match_pattern;
use crate::state::bindings::Bindings;
use crate::state::clause::Level;
use crate::state::index::IndexCandidate;
use crate::state::task::ProcedureRef;
use apex_model::pattern::Pattern;
use apex_model::procedure::{Primitive, Procedure};
use apex_model::source::Place;
use apex_model::task::TaskId;
use apex_model::value::Value;
use std::sync::Arc;

/// Matches an index against a goal; the index sees only its own variables.
pub(crate) fn match_index(
    cycle: &Cycle<'_>,
    id: TaskId,
    pattern: &IndexPattern<'_>,
    goal: &Value,
    bindings: &mut Bindings,
    place: Place,
) -> Result<bool, EvaluationError> {
    // A task without a selection has no inner variables, so no variable of the index is bound yet.
    match_pattern(pattern.get(), goal, bindings, &cycle.view(id, Level::Procedure), place)
}

/// The pattern of an index, with its owner.
pub(crate) enum IndexPattern<'a> {
    /// A stored procedure's.
    Stored(&'a Procedure),
    /// Index of a generated procedure, which this value keeps alive.
    Generated(Arc<Procedure>),
    /// A primitive's.
    Primitive(&'a Primitive),
    /// A solver's.
    Solver(&'a Pattern),
}

impl IndexPattern<'_> {
    /// Returns the pattern.
    pub(crate) fn get(&self) -> &Pattern {
        match self {
            IndexPattern::Stored(procedure) => &procedure.index,
            IndexPattern::Generated(procedure) => &procedure.index,
            IndexPattern::Primitive(primitive) => &primitive.index,
            IndexPattern::Solver(pattern) => pattern,
        }
    }
}

/// Returns the index of a candidate and its place in PDL.
pub(crate) fn index_of<'a>(cycle: &Cycle<'a>, candidate: IndexCandidate) -> Option<(IndexPattern<'a>, Place)> {
    let library = cycle.library;
    match candidate {
        IndexCandidate::Procedure(index) => {
            let procedure = library.procedures.get(index as usize)?;
            Some((IndexPattern::Stored(procedure), procedure.place))
        }
        IndexCandidate::Generated(number) => {
            let procedure = cycle.agent.procedure(ProcedureRef::Generated(number))?.clone();
            let place = procedure.place;
            Some((IndexPattern::Generated(procedure), place))
        }
        IndexCandidate::Primitive(index) => {
            let primitive = library.primitives.get(index as usize)?;
            Some((IndexPattern::Primitive(primitive), primitive.place))
        }
        IndexCandidate::Solver(index) => {
            let solver = library.solvers.get(index as usize)?;
            Some((IndexPattern::Solver(&solver.index), solver.place))
        }
    }
}
