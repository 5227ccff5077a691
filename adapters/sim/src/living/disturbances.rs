//! Sensor failures, applied to the reported samples of a vehicle: frozen, missing, biased or drifting values.

use super::FaultKind;
use super::faults::{FaultSpan, Faults};
use apex_model::event::EventKind;
use apex_model::quantity::Quantity;
use apex_model::value::Value;
use apex_runtime::ports::Input;
use std::collections::BTreeMap;

/// State variables of the position, which are not reported without navigation.
const POSITIONS: [&str; 3] = ["latitude", "longitude", "location"];

/// The last samples that frozen sensors repeat.
#[derive(Clone, Debug, Default)]
pub(crate) struct Disturbances {
    /// The state variables whose sensors may freeze, with their last samples.
    kept: BTreeMap<String, Option<Value>>,
}

impl Disturbances {
    /// Returns a memory for the state variables whose sensors freeze at some time.
    pub(crate) fn new(faults: &Faults) -> Disturbances {
        let frozen = faults.all().filter(|span| span.kind == FaultKind::Freeze);
        Disturbances { kept: frozen.map(|span| (span.of.clone(), None)).collect() }
    }

    /// Applies the failures active at `now` to the samples of `vehicle` in `inputs`, from index `first` on.
    pub(crate) fn apply(&mut self, spans: &[FaultSpan], vehicle: &str, inputs: &mut Vec<Input>, first: usize) {
        if spans.is_empty() && self.kept.is_empty() {
            return;
        }
        let mut index = 0;
        inputs.retain_mut(|input| {
            index += 1;
            index <= first || self.admits(spans, vehicle, &mut input.kind)
        });
    }

    /// Applies the failures to one message; false if the message is not sent.
    fn admits(&mut self, spans: &[FaultSpan], vehicle: &str, kind: &mut EventKind) -> bool {
        let EventKind::Measurement(variable, value) = kind else { return true };
        if !variable.object.as_symbol().is_some_and(|object| object.is(vehicle)) {
            return true;
        }
        let name = variable.attribute.folded();
        let of = |kind: FaultKind| spans.iter().find(|span| span.kind == kind && span.of == name);
        // Positions that drift are reported as estimated; see `navigation`.
        let has_position = spans.iter().all(|span| span.kind != FaultKind::Navigation || span.by.is_some());
        if of(FaultKind::Silence).is_some() || !has_position && POSITIONS.contains(&name) {
            return false;
        }
        let kept = self.kept.get_mut(name);
        if of(FaultKind::Freeze).is_some() {
            if let Some(kept) = kept.and_then(|kept| kept.as_ref()) {
                *value = kept.clone();
            }
            return true;
        }
        if let Some(kept) = kept {
            *kept = Some(value.clone());
        }
        if let Some(by) = of(FaultKind::Bias).and_then(|span| span.by) {
            *value = biased(value, by);
        }
        true
    }
}

fn biased(value: &Value, by: f64) -> Value {
    match value {
        Value::Quantity(quantity) => Value::Quantity(Quantity { si: quantity.si + by, ..*quantity }),
        Value::Real(number) => Value::Real(number + by),
        other => other.clone(),
    }
}
