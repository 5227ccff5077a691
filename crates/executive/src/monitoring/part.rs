//! Parts of conditions (M&I)
//! What: holds what all kinds of parts share: truth, window and place of a part, errors, kept results.
//! Runs: with every service.
//! Reads: Part.
//! Writes: results and notes of a monitor.
//! Bound: O(1), except for dropping old results.
//! PDL: all conditions.
//! Paper: section III, condition monitoring.

use crate::expression::{EvalContext, EvaluationError};
use crate::state::monitors::monitor::{ConditionFault, Keep, Monitor, Part, Satisfaction, Window};
use apex_model::agent_limits::Limit;
use apex_model::source::Place;

/// Kleene's three values, in order: conjunction is the least, disjunction the greatest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Truth {
    False,
    Unknown,
    True,
}

impl Truth {
    pub(crate) fn of(satisfied: bool, unknown: bool) -> Truth {
        match (satisfied, unknown) {
            (true, _) => Truth::True,
            (false, true) => Truth::Unknown,
            (false, false) => Truth::False,
        }
    }

    pub(crate) fn negated(self) -> Truth {
        match self {
            Truth::False => Truth::True,
            Truth::Unknown => Truth::Unknown,
            Truth::True => Truth::False,
        }
    }
}

/// Context of a part for its service.
#[derive(Clone, Copy)]
pub(crate) struct PartContext {
    /// The span of evidence that counts.
    pub(crate) window: Window,
    /// Results that are kept.
    pub(crate) keep: Keep,
    /// Position of the part in the PDL text.
    pub(crate) place: Place,
}

pub(crate) fn site(part: &Part) -> PartContext {
    PartContext { window: part.window, keep: part.keep, place: part.place }
}

/// Errors that occurred while a condition was judged, each once, and whether data were dropped at a limit.
pub(crate) struct ConditionFaults {
    pub(crate) list: Vec<ConditionFault>,
    /// Number of times that a limit was reached; a result may be missing if it is not zero.
    pub(crate) limits_reached: u64,
    /// Maximum number of results that a part may keep.
    pub(crate) results_max: usize,
}

impl ConditionFaults {
    /// Returns an empty list of faults, for conditions that are judged in `context`.
    pub(crate) fn none(context: &dyn EvalContext) -> ConditionFaults {
        let results_max = context.limits().count(Limit::MonitorResults);
        ConditionFaults { list: Vec::new(), limits_reached: 0, results_max }
    }

    /// Adds the errors of another query of the same monitor.
    pub(crate) fn append(&mut self, other: ConditionFaults) {
        self.limits_reached += other.limits_reached;
        for trouble in other.list {
            if !self.list.contains(&trouble) {
                self.list.push(trouble);
            }
        }
    }

    pub(crate) fn add(&mut self, error: EvaluationError) {
        let trouble = ConditionFault { message: error.message, place: error.place };
        if !self.list.contains(&trouble) {
            self.list.push(trouble);
        }
    }

    pub(crate) fn reached(&mut self, limit: Limit, context: &dyn EvalContext, place: Place) {
        self.limit(limit.constant(), context.limits().count(limit), place);
    }

    pub(crate) fn limit(&mut self, name: &str, value: usize, place: Place) {
        self.limits_reached += 1;
        self.add(EvaluationError { message: format!("the limit {name} = {value} of a condition was reached"), place });
    }

    pub(crate) fn too_many_results(&mut self, place: Place) {
        self.limit(Limit::MonitorResults.constant(), self.results_max, place);
    }

    /// Moves the new errors into the monitor.
    pub(crate) fn tell(self, monitor: &mut Monitor) {
        monitor.root.forgotten |= self.limits_reached > 0;
        for trouble in self.list {
            let notes = monitor.notes.get_or_insert_default();
            if !notes.told.contains(&trouble) {
                notes.told.push(trouble.clone());
                notes.troubles.push(trouble);
            }
        }
    }
}

/// Runs `act` on the part. If that reaches a limit, the part is marked as having dropped results.
pub(crate) fn noting_limits(
    part: &mut Part,
    troubles: &mut ConditionFaults,
    act: impl FnOnce(&mut Part, &mut ConditionFaults),
) {
    let before = troubles.limits_reached;
    act(part, troubles);
    part.forgotten |= troubles.limits_reached > before;
}

/// Keeps a result, dropping the oldest when there are too many.
pub(crate) fn remember(
    settled: &mut Vec<Satisfaction>,
    result: Satisfaction,
    site: PartContext,
    troubles: &mut ConditionFaults,
) {
    if settled.len() >= troubles.results_max {
        troubles.too_many_results(site.place);
        settled.drain(..troubles.results_max / 4);
    }
    settled.push(result);
}
