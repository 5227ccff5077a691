//! Sensor failures, applied to the samples that a vehicle reports: frozen, missing, biased or drifting values.

use super::FaultKind;
use super::faults::FaultSpan;
use crate::packet::rounded;
use apex_geo::geodesy::RAD_PER_DEG;
use apex_model::event::EventKind;
use apex_model::quantity::Quantity;
use apex_model::time::Time;
use apex_model::value::Value;
use apex_runtime::ports::Input;
use std::collections::BTreeMap;

/// Length of a degree of latitude, metres.
const DEGREE_M: f64 = 111_195.0;

/// The last sample of each state variable, which a frozen sensor repeats.
#[derive(Clone, Debug, Default)]
pub(crate) struct Disturbances {
    kept: BTreeMap<String, Value>,
}

impl Disturbances {
    /// Applies the failures that hold `now` to what `vehicle` reports in `inputs` from `first` on.
    pub(crate) fn apply(
        &mut self,
        spans: &[FaultSpan],
        vehicle: &str,
        now: Time,
        inputs: &mut Vec<Input>,
        first: usize,
    ) {
        let reported = inputs.split_off(first.min(inputs.len()));
        inputs.extend(reported.into_iter().filter_map(|mut input| {
            let EventKind::Measurement(variable, value) = &mut input.kind else { return Some(input) };
            if !variable.object.as_symbol().is_some_and(|object| object.is(vehicle)) {
                return Some(input);
            }
            let name = variable.attribute.folded().to_owned();
            let of = |kind: FaultKind| spans.iter().find(|span| span.kind == kind && span.of == name);
            if let Some(span) = spans.iter().find(|span| span.kind == FaultKind::Navigation) {
                let drifted = drifted(&name, value, span, now)?;
                *value = drifted;
            }
            if of(FaultKind::Silence).is_some() {
                return None;
            }
            if of(FaultKind::Freeze).is_some() {
                if let Some(kept) = self.kept.get(&name) {
                    *value = kept.clone();
                }
                return Some(input);
            }
            self.kept.insert(name.clone(), value.clone());
            if let Some(by) = of(FaultKind::Bias).and_then(|span| span.by) {
                *value = biased(value, by);
            }
            Some(input)
        }));
    }
}

fn biased(value: &Value, by: f64) -> Value {
    match value {
        Value::Quantity(quantity) => Value::Quantity(Quantity { si: quantity.si + by, ..*quantity }),
        Value::Real(number) => Value::Real(number + by),
        other => other.clone(),
    }
}

/// Returns a sample while navigation fails: positions are absent, or drift to the east; other variables are unchanged.
fn drifted(name: &str, value: &Value, span: &FaultSpan, now: Time) -> Option<Value> {
    if !matches!(name, "latitude" | "longitude" | "location") {
        return Some(value.clone());
    }
    let east_m = span.by? * (now - span.from).seconds();
    Some(match (name, value) {
        // A degree of longitude has its length at 45 degrees of latitude; the drift need not be more accurate.
        ("longitude", value) => biased(value, east_m / (DEGREE_M * 0.7) * RAD_PER_DEG),
        (_, Value::List(items)) => {
            let numbers: Vec<f64> = items.iter().filter_map(|item| item.as_number().map(|(si, _)| si)).collect();
            match numbers.as_slice() {
                [latitude, longitude, altitude_m] => {
                    let longitude = rounded(longitude + east_m / (DEGREE_M * 0.7), 1e7);
                    Value::list([*latitude, longitude, *altitude_m].map(Value::Real))
                }
                _ => value.clone(),
            }
        }
        (_, value) => value.clone(),
    })
}
