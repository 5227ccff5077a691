//! Recording (M&I)
//! What: records samples and messages in the histories, in the declared unit, and returns the stimuli for monitors.
//! Runs: first phase of every step.
//! Reads: index of state variables.
//! Writes: histories.
//! Bound: O(log n) in the number of state variables per sample; a late one O(samples kept).
//! PDL: `(state-variable ..)`, `:lateness`.
//! Paper: section IV, logging and retrieving data.

use crate::expression::arithmetic::duration;
use crate::expression::declared_unit::in_unit;
use crate::monitoring::memory::demand::{Demand, Reach, Subject};
use crate::monitoring::stimulus::Stimulus;
use crate::state::histories::history::{Histories, Occurrence, Sample};
use crate::state::recorded::Recorded;
use crate::state::variable_index::VariableIndex;
use apex_model::agent_limits::{Limit, Limits};
use apex_model::event::StateVariable;
use apex_model::time::{Duration, Time};
use apex_model::value::Value;

/// Result of recording a measurement that arrived.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Recording {
    /// Stimulus for interested monitors; `None` if the sample changes nothing (repeated, missing, too late, rejected).
    pub(crate) stimulus: Option<Stimulus>,
    /// A message for the trace when the sample was refused or kept aside.
    pub(crate) trouble: Option<String>,
    /// Effect on the history; `None` if the measurement was refused.
    pub(crate) recorded: Option<Recorded>,
    /// True if this is the first time that a sample of the variable was dropped that a condition may need.
    pub(crate) overflows: bool,
}

/// Records a measurement in its history. A bare number has the declared unit of the variable; a value of another dimension is rejected.
pub(crate) fn record_sample(
    histories: &mut Histories,
    index: &VariableIndex,
    variable: StateVariable,
    value: Value,
    at: Time,
    sequence: u64,
) -> Recording {
    let rules = index.rules(&variable.attribute);
    let value = match in_unit(rules.and_then(|rules| rules.unit), &variable, value) {
        Ok(value) => value,
        Err(message) => {
            return Recording { stimulus: None, trouble: Some(message), recorded: None, overflows: false };
        }
    };
    let lateness = rules.and_then(|rules| rules.lateness.as_ref()).and_then(|value| duration(value).ok());
    let sample = Sample { at, sequence, value: value.clone() };
    let (recorded, overflows) = histories.record(&variable, sample, lateness.unwrap_or(Duration::ZERO));
    match recorded {
        Recorded::Appended | Recorded::Inserted | Recorded::Replaced => {
            let newest = recorded == Recorded::Appended;
            let stimulus = Some(Stimulus::Sample { variable, value, at, sequence, newest });
            Recording { stimulus, trouble: None, recorded: Some(recorded), overflows }
        }
        Recorded::Repeated | Recorded::Missing => {
            Recording { stimulus: None, trouble: None, recorded: Some(recorded), overflows }
        }
        Recorded::TooLate => {
            let message = format!(
                "the sample {value} of {variable} at {at} came too late and is kept aside; (state-variable ({} ?) :lateness D) accepts later ones",
                variable.attribute
            );
            Recording { stimulus: None, trouble: Some(message), recorded: Some(recorded), overflows }
        }
    }
}

/// Sets the reach of each history to the greatest one demanded.
pub(crate) fn obey(histories: &mut Histories, demands: Vec<Demand>) {
    for demand in demands {
        let lookback = match demand.reach {
            Reach::Span(span) => span,
            Reach::Unbounded => Duration::MAX,
            // The procedure opens a log when it begins to work, and closes it when it ends.
            Reach::Log { .. } => continue,
        };
        match &demand.subject {
            Subject::Attribute(attribute) => histories.require_lookback(attribute, lookback),
            Subject::EveryAttribute => histories.require_lookback_of_all(lookback),
            Subject::Messages => histories.require_event_lookback(lookback),
            Subject::MessagesOf(head) => histories.require_events_of(head, lookback),
        }
    }
}

/// Records a message in the memory of events. The flag is true if this is the first time that a message was dropped that a condition may
/// need.
pub(crate) fn record_event(histories: &mut Histories, form: Value, at: Time, sequence: u64) -> (Stimulus, bool) {
    let overflows = histories.record_event(Occurrence { at, sequence, form: form.clone() });
    (Stimulus::Event { form, at, sequence }, overflows)
}

/// Returns the message for the first dropped sample of `variable` that a condition may still need.
pub(crate) fn overflow_of_samples(variable: &StateVariable, limits: &Limits) -> String {
    let most = limits.of(Limit::HistorySamples);
    let over = format!("more than {most} samples of {variable} within the time that conditions or logs need");
    forgotten(&over, Limit::HistorySamples, limits)
}

/// Returns the message for the first dropped message that a condition may still need.
pub(crate) fn overflow_of_messages(limits: &Limits) -> String {
    let most = limits.of(Limit::EventHistory);
    forgotten(
        &format!("more than {most} messages within the time that conditions, queries or logs need"),
        Limit::EventHistory,
        limits,
    )
}

fn forgotten(over: &str, limit: Limit, limits: &Limits) -> String {
    let raise = if limits.of(limit) < limit.most() { format!(", or raise `:{}`", limit.word()) } else { String::new() };
    format!(
        "{over}: the oldest of them are forgotten, and a query that reaches back to them is \
         answered with \"unknown\"; query a shorter time{raise}"
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use apex_model::library::{Library, StateVariableDeclaration};
    use apex_model::quantity::unit_named;
    use apex_model::source::Place;
    use apex_model::symbol::Symbol;

    fn library() -> Library {
        let feet = unit_named("ft").unwrap();
        let mut library = Library::default();
        let declaration = StateVariableDeclaration {
            unit: Some(Symbol::new("ft")),
            dimension: feet.dimension,
            value_type: None,
            lateness: Some(Value::Duration(Duration::from_seconds(1.0))),
            rate_per_s: None,
            place: Place::default(),
        };
        library.state_variables.insert(Symbol::new("altitude"), declaration);
        library
    }

    #[test]
    fn bare_numbers_take_the_declared_unit_and_other_dimensions_are_refused() {
        let (mut histories, index) = (Histories::default(), VariableIndex::new(&library()));
        let variable = StateVariable::new(Symbol::new("altitude"), Value::symbol("uav"));
        let mut record = |value: Value, at: f64| {
            record_sample(&mut histories, &index, variable.clone(), value, Time::from_seconds(at), 0)
        };
        let Some(Stimulus::Sample { value, .. }) = record(Value::Integer(400), 1.0).stimulus else { panic!() };
        assert_eq!(value.to_string(), "400ft");
        let refused = record(Value::Duration(Duration(1)), 2.0);
        assert_eq!(refused.stimulus, None);
        assert!(refused.trouble.unwrap().contains("declared in ft, which measures length"));
        assert!(record(Value::Real(f64::NAN), 3.0).stimulus.is_none());
        assert!(record(Value::Integer(500), 0.5).stimulus.is_some());
        assert!(record(Value::Integer(500), -5.0).trouble.unwrap().contains("too late"));
    }
}
