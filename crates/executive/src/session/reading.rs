//! Queries of a session: results, errors, time, histories, and the present status of a condition.

use super::{Judgement, MonitorResult, MonitorSession, SessionError, watched};
use crate::monitoring::combination::{interest, monitors};
use crate::state::clause::MonitorId;
use crate::state::histories::history::Histories;
use crate::state::monitors::monitor::{Interest, PartKind, Verdict};
use apex_model::library::Library;
use apex_model::symbol::Symbol;
use apex_model::time::Time;
use std::collections::BTreeSet;
use std::sync::Arc;

impl MonitorSession {
    /// Returns the results since the last call, in order of recognition.
    pub fn take_results(&mut self) -> Vec<MonitorResult> {
        std::mem::take(&mut self.results)
    }

    /// Takes the errors since the last call; at most [`SESSION_TROUBLES_MAX`], the first ones.
    pub fn take_troubles(&mut self) -> Vec<SessionError> {
        std::mem::take(&mut self.troubles)
    }

    /// Returns the session's time; [`Time::BEGINNING`] before the first input.
    pub fn now(&self) -> Time {
        self.world.now
    }

    /// Returns the library that defines the terms of the conditions.
    pub fn library(&self) -> &Arc<Library> {
        &self.world.library
    }

    /// Returns the remembered samples and messages, with counts of late, replaced and missing samples.
    pub fn histories(&self) -> &Histories {
        &self.world.histories
    }

    /// Returns the known stimuli that a condition must receive; empty before the condition begins.
    pub fn interests(&self, id: MonitorId) -> Vec<Interest> {
        let monitor = self.watches.get(id.0).and_then(|watched| watched.monitor.as_ref());
        monitor.map(interest::interests).unwrap_or_default()
    }

    /// Returns the variables that the watched conditions read and that had no sample: state variables such as `(roll-angle aircraft-1)`,
    /// and attributes such as `(roll-angle ..)` if the object is not fixed. Such a variable is mostly a misspelling.
    pub fn without_samples(&self) -> Vec<String> {
        let histories = self.histories();
        let measured: BTreeSet<&Symbol> = histories.iter().map(|(variable, _)| &variable.attribute).collect();
        let missing = |interest: Interest| match interest {
            Interest::Variable(variable) if histories.get(&variable).is_none() => Some(variable.to_string()),
            Interest::Attribute(attribute) if !measured.contains(&attribute) => Some(format!("({attribute} ..)")),
            _ => None,
        };
        let watched = (0..self.next_watch).flat_map(|number| self.interests(MonitorId(number)));
        let mut named = BTreeSet::new();
        watched.filter_map(missing).filter(|name| named.insert(name.clone())).collect()
    }

    /// Returns true if the condition is an absence, and it is unknown at the last instant that is over whether its part holds. A window
    /// that had passed before remains a result of the absence.
    pub fn is_in_doubt(&self, id: MonitorId) -> bool {
        let monitor = self.watches.get(id.0).and_then(|watched| self.as_told(id, watched));
        monitor.is_some_and(|mut monitor| {
            monitors::verdict(&mut monitor, &self.world);
            matches!(&monitor.root.kind, PartKind::Absent(leaf) if leaf.unknown)
        })
    }

    /// Returns the status of a condition at the last instant that is over; `None` if it is not watched.
    pub fn verdict(&self, id: MonitorId) -> Option<Judgement> {
        let watched = self.watches.get(id.0)?;
        let results = watched.results;
        if let Some(first) = &watched.first {
            return Some(Judgement { verdict: Verdict::Satisfied(first.clone()), because: Vec::new(), results });
        }
        let Some(mut monitor) = self.as_told(id, watched) else {
            return Some(Judgement { verdict: Verdict::Unknown, because: vec![watched::not_begun(watched)], results });
        };
        let verdict = monitors::verdict(&mut monitor, &self.world);
        Some(Judgement { verdict, because: monitors::unmet(&monitor, &self.world), results })
    }
}
