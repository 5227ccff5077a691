//! Interests (M&I)
//! What: determines the stimuli that a monitor must receive, so that all others cost it nothing.
//! Runs: when a monitor is filed, and when a verdict has found out more.
//! Reads: the monitor's tree.
//! Writes: nothing.
//! Bound: linear in the condition.
//! PDL: all conditions.
//! Paper: section III, condition monitoring.

use crate::monitoring::basic::{event, measurement, task_state};
use crate::state::monitors::monitor::{Interest, Monitor, Part, PartKind};
use crate::state::thresholds::Threshold;
use apex_model::event::StateVariable;
use apex_model::symbol::Symbol;

/// Returns the stimuli that `monitor` must receive, sorted and without repetitions. Changes only when a verdict makes a task known.
pub(crate) fn interests(monitor: &Monitor) -> Vec<Interest> {
    let mut interests = Vec::new();
    collect_interests(&monitor.root, &mut |interest| interests.push(interest));
    interests.sort();
    interests.dedup();
    interests
}

/// Returns the only interest of a monitor whose interests never change; `None` for all other monitors.
pub(crate) fn lasting_interest(monitor: &Monitor) -> Option<Interest> {
    match &monitor.root.kind {
        PartKind::Measurement(_)
        | PartKind::Episode(_)
        | PartKind::Persisted(_)
        | PartKind::Regression(_)
        | PartKind::Statistical(_)
        | PartKind::Cyclic(_)
        | PartKind::Event(_) => {
            let mut only = None;
            collect_interests(&monitor.root, &mut |interest| only = Some(interest));
            only
        }
        PartKind::TaskEnded(_)
        | PartKind::TaskState(_)
        | PartKind::And(_)
        | PartKind::Or(_)
        | PartKind::InOrder(_)
        | PartKind::Not(_)
        | PartKind::Timestamp(_)
        | PartKind::Delay(_)
        | PartKind::Allen(_)
        | PartKind::Absent(_)
        | PartKind::Function(_) => None,
    }
}

/// Returns a comparison that a sample must satisfy to change the monitor's verdict. It never changes.
pub(crate) fn threshold(monitor: &Monitor) -> Option<Threshold> {
    match &monitor.root.kind {
        PartKind::Measurement(leaf) => measurement::threshold(leaf),
        _ => None,
    }
}

/// Calls `add` with each interest of `part`.
pub(crate) fn collect_interests(part: &Part, add: &mut dyn FnMut(Interest)) {
    let samples = |variable: &Option<StateVariable>, attribute: &Symbol| {
        variable.clone().map_or_else(|| Interest::Attribute(attribute.clone()), Interest::Variable)
    };
    match &part.kind {
        PartKind::Measurement(leaf) => add(samples(&leaf.variable, &leaf.condition.variable.attribute)),
        PartKind::Episode(leaf) => add(samples(&leaf.variable, &leaf.condition.variable.attribute)),
        PartKind::Persisted(leaf) => add(samples(&leaf.variable, &leaf.condition.variable.attribute)),
        PartKind::Regression(leaf) => add(samples(&leaf.variable, &leaf.condition.variable.attribute)),
        PartKind::Statistical(leaf) => add(samples(&leaf.variable, &leaf.condition.variable.attribute)),
        PartKind::Cyclic(leaf) => add(samples(&leaf.variable, &leaf.condition.variable.attribute)),
        PartKind::Event(leaf) => add(event::interest(&leaf.pattern)),
        PartKind::TaskEnded(leaf) => add(task_state::interest(leaf.task)),
        PartKind::TaskState(leaf) => add(task_state::interest(leaf.task)),
        PartKind::And(composite) | PartKind::Or(composite) | PartKind::InOrder(composite) => {
            composite.parts.iter().for_each(|part| collect_interests(part, add));
        }
        PartKind::Not(inner) => collect_interests(inner, add),
        PartKind::Allen(leaf) => leaf.parts.iter().for_each(|part| collect_interests(part, add)),
        PartKind::Absent(leaf) => collect_interests(&leaf.part, add),
        PartKind::Function(_) => add(Interest::EveryStep),
        PartKind::Timestamp(_) | PartKind::Delay(_) => {}
    }
}
