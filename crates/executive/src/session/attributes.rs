//! State variables that conditions read, so that a reader of a log can skip the others.

use super::MonitorSession;
use crate::monitoring::memory::demand::Subject;
use crate::monitoring::memory::retention;
use crate::state::monitors::monitor::Interest;
use apex_model::condition::Condition;
use apex_model::symbol::Symbol;
use apex_model::time::Time;
use std::collections::BTreeSet;

impl MonitorSession {
    /// Returns the attributes of all state variables that `conditions` read, directly, by queries, or through derived variables. `None`
    /// if they are not known in advance, or if every sample is an instant at which a condition is judged.
    pub fn attributes_read(&self, conditions: &[Condition]) -> Option<BTreeSet<Symbol>> {
        let library = &self.world.library;
        let mut found = BTreeSet::new();
        let mut trial = self.clone();
        for condition in conditions {
            let id = trial.watch(condition.clone(), Time::BEGINNING).ok()?;
            for interest in trial.interests(id) {
                match interest {
                    Interest::Variable(variable) => found.insert(variable.attribute),
                    Interest::Attribute(attribute) => found.insert(attribute),
                    Interest::EveryStep => return None,
                    Interest::EventHead(_) | Interest::AnyEvent | Interest::Task(_) | Interest::AnyTask => false,
                };
            }
        }
        let of_library = retention::demands(library);
        for demand in conditions.iter().flat_map(|each| retention::demands_of(library, each)).chain(of_library) {
            match demand.subject {
                Subject::Attribute(attribute) => _ = found.insert(attribute),
                Subject::EveryAttribute => return None,
                Subject::Messages | Subject::MessagesOf(_) => {}
            }
        }
        // Inputs have lower ranks than the variables that are derived from them.
        let mut ranked: Vec<_> = library.derivations.iter().collect();
        ranked.sort_by_key(|(_, derivation)| std::cmp::Reverse(derivation.rank));
        for (attribute, derivation) in ranked {
            if found.contains(attribute) {
                found.extend(derivation.inputs.iter().map(|input| input.attribute.clone()));
            }
        }
        Some(found)
    }
}
