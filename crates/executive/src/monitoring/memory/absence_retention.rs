//! Absence retention (M&I)
//! What: determines the history of other variables that an absence needs to judge samples that arrive late.
//! Runs: once, when an agent is loaded.
//! Reads: library.
//! Writes: the demands of a survey.
//! Bound: linear in the condition.
//! PDL: `(:absent C :for D)`, `:lateness`.
//! Paper: section IV, policies on logged data quantity.

use crate::monitoring::memory::demand::{Reach, Subject, Why};
use crate::monitoring::memory::retention::{Survey, lateness};
use apex_model::condition::{Condition, ConditionKind};
use apex_model::source::Place;
use apex_model::symbol::Symbol;
use std::collections::BTreeSet;

impl Survey<'_> {
    /// Judges a late sample together with the values at its instant.
    pub(crate) fn beside_late(&mut self, part: &Condition, place: Place) {
        let mut watched = BTreeSet::new();
        attributes(part, &mut watched);
        let declared = &self.library.state_variables;
        let is_late = |attribute: &&Symbol| declared.get(*attribute).and_then(lateness).is_some();
        let Some(late) = watched.iter().find(|attribute| is_late(attribute)) else { return };
        let text = || format!("(:absent .. :for ..), which watches ({late} ..) too");
        for attribute in watched.iter().filter(|attribute| !is_late(attribute)) {
            self.demand(Subject::Attribute((*attribute).clone()), Reach::Unbounded, Why::Lateness, text, place);
        }
    }
}

/// Collects the attributes whose samples the condition watches.
fn attributes<'a>(condition: &'a Condition, found: &mut BTreeSet<&'a Symbol>) {
    match &condition.kind {
        ConditionKind::Measurement(measurement) => drop(found.insert(&measurement.variable.attribute)),
        ConditionKind::Episode(episode) => drop(found.insert(&episode.variable.attribute)),
        ConditionKind::Cyclic(cyclic) => drop(found.insert(&cyclic.variable.attribute)),
        ConditionKind::And(parts, _)
        | ConditionKind::Or(parts, _)
        | ConditionKind::InOrder(parts, _)
        | ConditionKind::Allen { parts, .. } => parts.iter().for_each(|part| attributes(part, found)),
        ConditionKind::Not(part) | ConditionKind::Absent(part, _) => attributes(part, found),
        ConditionKind::Probing { condition, .. } => attributes(condition, found),
        ConditionKind::Event { .. }
        | ConditionKind::Delay(..)
        | ConditionKind::Timestamp(..)
        | ConditionKind::TaskEnded(_)
        | ConditionKind::TaskState { .. }
        | ConditionKind::Function(_) => {}
    }
}
