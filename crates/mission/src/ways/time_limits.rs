//! Time limits of flights to the mission's places by name.

use super::limits::Limits;
use apex_geo::time_limit::flight_time_limit;
use apex_model::host::HostFunctions;
use apex_model::value::Value;
use std::sync::Arc;

/// Replaces the function of time limits by one that knows the positions of the mission's places.
pub(super) fn register(limits: Arc<Limits>, functions: &mut HostFunctions) {
    let time_limit = move |arguments: &[Value]| {
        let known: Vec<Value> = arguments.iter().map(|argument| with_positions(&limits, argument)).collect();
        flight_time_limit(&known).map_err(|reason| format!("`flight-time-limit`: {reason}"))
    };
    functions.register("flight-time-limit", Arc::new(time_limit));
}

/// Returns a value in which the names of the mission's places are replaced by their positions: a flight to a place of unknown position
/// has a time limit that is three hours longer.
fn with_positions(limits: &Limits, value: &Value) -> Value {
    match value {
        Value::Symbol(name) => limits.place(name.folded()).map_or_else(
            || value.clone(),
            |(place, _)| Value::list([Value::Real(place.latitude_deg), Value::Real(place.longitude_deg)]),
        ),
        Value::List(items) => Value::list(items.iter().map(|item| with_positions(limits, item))),
        _ => value.clone(),
    }
}
