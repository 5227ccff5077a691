//! Parts of conditions (M&I)
//! What: holds what the services of all kinds of parts share: truth, window and place of a part, errors, kept results.
//! Runs: with every service.
//! Reads: Part.
//! Writes: results and notes of a monitor.
//! Bound: O(1), except for dropping old results.
//! PDL: all conditions.
//! Paper: section III, condition monitoring.

use crate::expression::{EvalContext, EvaluationError};
use crate::state::monitors::monitor::{ConditionFault, Keep, Monitor, Part, Satisfaction, Window};
use apex_model::agent_limits::Limit;
use apex_model::limits::MONITOR_RESULTS_MAX;
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

/// What every part's service needs to know of the part.
#[derive(Clone, Copy)]
pub(crate) struct PartContext {
    /// The span of evidence that counts.
    pub(crate) window: Window,
    /// Which results are kept.
    pub(crate) keep: Keep,
    /// Where the part stands.
    pub(crate) place: Place,
}

pub(crate) fn site(part: &Part) -> PartContext {
    PartContext { window: part.window, keep: part.keep, place: part.place }
}

/// Errors met while judging, each once.
#[derive(Default)]
pub(crate) struct ConditionFaults(pub(crate) Vec<ConditionFault>);

impl ConditionFaults {
    pub(crate) fn add(&mut self, error: EvaluationError) {
        let trouble = ConditionFault { message: error.message, place: error.place };
        if !self.0.contains(&trouble) {
            self.0.push(trouble);
        }
    }

    pub(crate) fn reached(&mut self, limit: Limit, context: &dyn EvalContext, place: Place) {
        self.limit(limit.constant(), context.limits().count(limit), place);
    }

    pub(crate) fn limit(&mut self, name: &str, value: usize, place: Place) {
        self.add(EvaluationError { message: format!("the limit {name} = {value} of a condition was reached"), place });
    }

    pub(crate) fn too_many_results(&mut self, place: Place) {
        self.limit("MONITOR_RESULTS_MAX", MONITOR_RESULTS_MAX, place);
    }

    /// Moves what is new into the monitor.
    pub(crate) fn tell(self, monitor: &mut Monitor) {
        for trouble in self.0 {
            let notes = monitor.notes.get_or_insert_default();
            if !notes.told.contains(&trouble) {
                notes.told.push(trouble.clone());
                notes.troubles.push(trouble);
            }
        }
    }
}

/// Keeps a result, dropping the oldest when there are too many.
pub(crate) fn remember(
    settled: &mut Vec<Satisfaction>,
    result: Satisfaction,
    site: PartContext,
    troubles: &mut ConditionFaults,
) {
    if settled.len() >= MONITOR_RESULTS_MAX {
        troubles.too_many_results(site.place);
        settled.drain(..MONITOR_RESULTS_MAX / 4);
    }
    settled.push(result);
}
