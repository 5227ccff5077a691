//! The holders of resources over time, kept in memory and extended with the record.

use crate::error::RecordError;
use crate::record::RecordReader;
use apex_model::cause::Cause;
use apex_model::effect::{DecisionKind, Effect};
use apex_model::task::TaskState;
use std::collections::BTreeMap;

/// All holdings, kept in memory and grown with the record. Bound: each transition is read once.
#[derive(Default)]
pub(super) struct HoldingIndex {
    /// Number of the last effect that was read or skipped.
    read_to: i64,
    resources: Vec<(String, Vec<Held>)>,
    /// Positions in `resources` of the holdings of each task.
    held: BTreeMap<u64, Vec<(usize, usize)>>,
}

/// A span of time in which a task holds a share of a resource; its end is `None` while it continues.
#[derive(Clone)]
pub(super) struct Held {
    pub(super) task: u64,
    pub(super) amount: Option<String>,
    pub(super) from_ns: i64,
    pub(super) to_ns: Option<i64>,
}

impl HoldingIndex {
    /// Returns the resources in the order of their first holding, each with its holdings by begin.
    pub(super) fn resources(&self) -> &[(String, Vec<Held>)] {
        &self.resources
    }

    /// Returns the number of the last effect that was read or skipped.
    pub(super) fn read_to(&self) -> i64 {
        self.read_to
    }

    /// Reads the effects that were written since the last call, up to effect `last`.
    pub(super) fn refresh(&mut self, reader: &RecordReader, last: i64) -> Result<(), RecordError> {
        let effects = reader.effects()?;
        for place in effects.table.place_after(self.read_to)..effects.table.place_after(last) {
            let Some(kind) = effects.table.kind(place).filter(|kind| kind.word == "transition") else { continue };
            let Some(task) = effects.table.task(place) else { continue };
            // Every transition ends the holdings of its task; a transition to `ongoing` then adds the granted ones.
            for (resource, held) in self.held.remove(&task).unwrap_or_default() {
                let slot = self.resources.get_mut(resource).and_then(|(_, list)| list.get_mut(held));
                if let Some(held) = slot {
                    held.to_ns = Some(effects.at(place).0);
                }
            }
            if kind.grants {
                self.grant(task, effects.at(place).0, effects.effect(place)?);
            }
        }
        self.read_to = self.read_to.max(last);
        Ok(())
    }

    /// Adds the holdings that a transition to `ongoing` granted.
    fn grant(&mut self, task: u64, at_ns: i64, effect: Effect) {
        let Effect::Decided(decision) = effect else { return };
        let DecisionKind::Transition { to: TaskState::Ongoing, .. } = decision.kind else { return };
        let Cause::ResourcesGranted { resources } = decision.because.cause else { return };
        for share in resources {
            let name = share.resource.to_string();
            let index = self.resources.iter().position(|(known, _)| *known == name).unwrap_or_else(|| {
                self.resources.push((name, Vec::new()));
                self.resources.len() - 1
            });
            let Some((_, list)) = self.resources.get_mut(index) else { continue };
            let amount = share.amount.map(|amount| amount.to_string());
            list.push(Held { task, amount, from_ns: at_ns, to_ns: None });
            self.held.entry(task).or_default().push((index, list.len() - 1));
        }
    }
}
