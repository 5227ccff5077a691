//! Reported results (M&I)
//! What: stores which results of a monitor were reported, so that each is reported once.
//! Runs: with every result report.
//! Reads: results.
//! Writes: keys of reported results.
//! Bound: O(results reported that late samples may still change).
//! PDL: all conditions.
//! Paper: section IV, creating monitors from PDL specifications.

use crate::state::monitors::monitor::{Part, Satisfaction};
use apex_model::because::Evidence;
use apex_model::source::Place;
use apex_model::time::Time;
use apex_model::value::Value;

/// Identity of a result of a part; it does not change when the interval grows.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Key {
    part: Place,
    start: Time,
    pub(crate) recognised_at: Time,
    subject: Option<Value>,
}

impl Key {
    /// Returns the key of a result of `part`.
    pub(crate) fn of(part: Place, result: &Satisfaction) -> Key {
        let subject = result.evidence.iter().find_map(|evidence| match evidence {
            Evidence::Sample { variable, .. } | Evidence::Run { variable, .. } => Some(variable.object.clone()),
            Evidence::Estimate(estimate) => Some(estimate.variable.object.clone()),
            Evidence::Aggregate(aggregate) => Some(aggregate.variable.object.clone()),
            Evidence::Event { form, .. } => Some(form.clone()),
            Evidence::TaskState { state, .. } => Some(state.clone()),
            Evidence::TaskEnd { .. }
            | Evidence::Instant { .. }
            | Evidence::Function { .. }
            | Evidence::Absence { .. } => None,
        });
        Key { part, start: result.interval.0, recognised_at: result.recognised_at, subject }
    }
}

/// Results of parts that belong to a reported result.
#[derive(Clone, Debug, Default)]
pub(crate) struct Used {
    pub(crate) keys: Vec<Key>,
    /// A late sample lets parts look back and find reported results again: results recognised before this instant are not new.
    pub(crate) horizon: Option<Time>,
}

impl Used {
    /// Adds a result of a part.
    pub(crate) fn add(&mut self, part: Place, result: &Satisfaction) {
        self.keys.push(Key::of(part, result));
    }

    /// Returns true if the result was reported.
    pub(crate) fn contains(&self, part: Place, result: &Satisfaction) -> bool {
        self.horizon.is_some_and(|horizon| result.recognised_at < horizon)
            || (!self.keys.is_empty() && self.keys.contains(&Key::of(part, result)))
    }
}

/// Reported results of one monitor: for each alternative of its outermost `:or`, or for the whole.
#[derive(Clone, Debug, Default)]
pub(crate) struct ReportedResults(pub(crate) Vec<Branch>);

impl ReportedResults {
    /// Returns the state after an episode index has reported the monitor's run: the result of the run before the newest sample, and the
    /// open result.
    pub(crate) fn by_bank(part: &Part, before: Option<&Satisfaction>, open: Option<&Satisfaction>) -> ReportedResults {
        let key = |result: &Satisfaction| Key::of(part.place, result);
        let open: Vec<Key> = open.map(key).into_iter().collect();
        let keys = before.map(key).into_iter().chain(open.iter().cloned()).collect();
        ReportedResults(vec![Branch { used: Used { keys, horizon: None }, open, absence: false }])
    }

    /// Returns true if the end of an open result will be reported; false if it was reported already and a sample has withdrawn it.
    pub(crate) fn awaits_end(&self) -> bool {
        self.0.iter().any(|branch| !branch.open.is_empty())
    }
}

/// Reported results of one alternative.
#[derive(Clone, Debug, Default)]
pub(crate) struct Branch {
    /// Results of parts that belong to reported results.
    pub(crate) used: Used,
    /// Reported results whose interval still grows.
    pub(crate) open: Vec<Key>,
    /// True if the absence of an event was reported.
    pub(crate) absence: bool,
}
