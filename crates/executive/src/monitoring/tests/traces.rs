//! Traces of one variable as arrivals, for tests against definitions.

use super::*;
use proptest::prelude::*;

/// Arrivals: instants may repeat (a later value replaces), and a value may be missing.
pub(super) type Trace = Vec<(i64, Option<i64>)>;

/// Returns the samples that count: the last valid arrival of each instant.
pub(super) fn valid(trace: &[(i64, Option<i64>)]) -> Vec<(i64, i64)> {
    let mut samples: Vec<(i64, i64)> = Vec::new();
    for (at, value) in trace {
        let Some(value) = value else { continue };
        match samples.last_mut() {
            Some(last) if last.0 == *at => last.1 = *value,
            _ => samples.push((*at, *value)),
        }
    }
    samples
}

/// Returns up to 23 arrivals with values below `most`; a sample is missing about once for every `present` others.
pub(super) fn traces(most: i64, present: u32) -> impl Strategy<Value = Trace> {
    let step = (0..6_i64, prop_oneof![present => (0..most).prop_map(Some), 1 => Just(None)]);
    proptest::collection::vec(step, 0..24).prop_map(|steps| {
        let mut at = 0;
        steps
            .into_iter()
            .map(|(pause, value)| {
                at += pause;
                (at, value)
            })
            .collect()
    })
}

/// Passes the samples of the trace in sequence; a missing value is a NaN.
pub(super) fn tell(world: &mut World, trace: &[(i64, Option<i64>)]) {
    for (at, value) in trace {
        let value = value.map_or(Value::Real(f64::NAN), Value::Integer);
        world.sample("a", "uav", value, *at);
    }
}

/// Returns the verdict without its result.
pub(super) fn as_truth(verdict: &Verdict) -> Truth {
    match verdict {
        Verdict::Satisfied(_) => Truth::True,
        Verdict::NotSatisfied => Truth::False,
        Verdict::Unknown => Truth::Unknown,
    }
}

/// Returns the groups of arrivals of one instant: the input of one step each.
pub(super) fn instants(trace: &[(i64, Option<i64>)]) -> Vec<&[(i64, Option<i64>)]> {
    trace.chunk_by(|a, b| a.0 == b.0).collect()
}
