//! Solver selection (DM)
//! What: finds the solver declaration that serves a goal for which no procedure or primitive exists.
//! Runs: choose phase.  Reads: Library.  Writes: faults of guards.
//! Bound: one pattern match per declaration that shares the goal's first word.
//! PDL: `(solver NAME (index ..))`.  Paper: section V, solver selection.

use crate::control::cycle::Cycle;
use crate::control::matching::{index_of, match_index};
use crate::monitoring::specificity::specificity;
use crate::state::bindings::Bindings;
use crate::state::index::IndexCandidate;
use apex_model::task::TaskId;
use apex_model::value::Value;

/// Returns the index of the most specific solver declaration that serves `goal`; of equally specific ones, the first.
pub(crate) fn select(cycle: &mut Cycle<'_>, id: TaskId, goal: &Value) -> Option<u32> {
    let candidates: Vec<IndexCandidate> = cycle.agent.index.solvers.candidates(goal.head()).collect();
    let mut best = None;
    for candidate in candidates {
        let IndexCandidate::Solver(number) = candidate else { continue };
        let Some((pattern, place)) = index_of(cycle, candidate) else { continue };
        match match_index(cycle, id, &pattern, goal, &mut Bindings::new(), place) {
            Ok(true) => {
                let key = (specificity(pattern.get()), std::cmp::Reverse(number));
                if best.is_none_or(|before| key > before) {
                    best = Some(key);
                }
            }
            Ok(false) => {}
            Err(error) => cycle.trouble(Some(id), error.message, Some(error.place)),
        }
    }
    best.map(|(_, number)| number.0)
}
