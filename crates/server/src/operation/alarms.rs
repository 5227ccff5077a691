//! Alarms as the record of a run has them: an operator acknowledges only what was raised.

use crate::answer::ApiResult;
use apex_model::time::Time;
use apex_runtime::record::view::{RecordView, Trouble, TroubleKind}; // english: allow

/// Number of alarms that a refusal names.
const NAMED_MAX: usize = 5;

/// An alarm as a command states it.
#[derive(Clone, Debug)]
pub(crate) struct StatedAlarm {
    /// Mission time in nanoseconds at which it was raised last.
    pub(crate) at_ns: i64,
    /// The signal that raised it; `None` for a failure, a fault and a target that was left out.
    pub(crate) signal: Option<String>,
}

/// Returns the reason for which an alarm cannot be acknowledged: the flight has not raised it. `None` if it has.
///
/// # Errors
/// If the record cannot be read.
pub(crate) fn objection(view: &mut RecordView, alarm: &StatedAlarm) -> ApiResult<Option<String>> {
    let at = Time(alarm.at_ns);
    if let Some(signal) = &alarm.signal {
        let known = view.signals(Some(alarm.at_ns), None)?.signals;
        let is_known = known.iter().any(|known| known.name == *signal);
        return Ok((!is_known).then(|| format!("`{signal}` has no sample by {at}, and has raised no alarm")));
    }
    let calls = |entry: &&Trouble| entry.kind != TroubleKind::Interrupted; // english: allow
    let raised = view.troubles(Some(alarm.at_ns))?.troubles; // english: allow
    if raised.iter().filter(calls).any(|entry| entry.t_ns == alarm.at_ns) {
        return Ok(None);
    }
    let all = view.troubles(None)?.troubles; // english: allow
    let last: Vec<&Trouble> = all.iter().rev().filter(calls).take(NAMED_MAX).collect(); // english: allow
    Ok(Some(match last.is_empty() {
        true => format!("the flight raised no alarm at {at}, and none before"),
        false => {
            let named: Vec<String> = last
                .iter()
                .rev()
                .map(|entry| format!("{} at {} (`at_ns` {})", entry.subject, Time(entry.t_ns), entry.t_ns))
                .collect();
            format!("the flight raised no alarm at {at}; its last ones are {}", named.join(", "))
        }
    }))
}
