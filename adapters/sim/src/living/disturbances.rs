//! Sensor failures, applied to the reported samples of a vehicle: frozen, missing, biased or drifting values.

use super::FaultKind;
use super::faults::FaultSpan;
use apex_model::event::EventKind;
use apex_model::quantity::Quantity;
use apex_model::value::Value;
use apex_runtime::ports::Input;
use std::collections::BTreeMap;

/// State variables of the position, which are not reported without navigation.
const POSITIONS: [&str; 3] = ["latitude", "longitude", "location"];

/// The last sample of each state variable, which a frozen sensor repeats.
#[derive(Clone, Debug, Default)]
pub(crate) struct Disturbances {
    kept: BTreeMap<String, Value>,
}

impl Disturbances {
    /// Applies the failures active at `now` to the samples of `vehicle` in `inputs`, from index `first` on.
    pub(crate) fn apply(&mut self, spans: &[FaultSpan], vehicle: &str, inputs: &mut Vec<Input>, first: usize) {
        let reported = inputs.split_off(first.min(inputs.len()));
        inputs.extend(reported.into_iter().filter_map(|mut input| {
            let EventKind::Measurement(variable, value) = &mut input.kind else { return Some(input) };
            if !variable.object.as_symbol().is_some_and(|object| object.is(vehicle)) {
                return Some(input);
            }
            let name = variable.attribute.folded().to_owned();
            let of = |kind: FaultKind| spans.iter().find(|span| span.kind == kind && span.of == name);
            // Positions that drift are reported as estimated; see `navigation`.
            let has_position = spans.iter().all(|span| span.kind != FaultKind::Navigation || span.by.is_some());
            if of(FaultKind::Silence).is_some() || !has_position && POSITIONS.contains(&name.as_str()) {
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
