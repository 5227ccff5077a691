//! Final intervals of absences in a log: `(:absent C :for D)` is recognised when D has passed, and the absence lasts until C comes.
//!
//! For each such condition C is watched by a separate monitor. A recognised absence is held back until C begins or the input ends, because
//! only then its interval is known.

use apex_executive::state::clause::MonitorId;
use apex_executive::{MonitorResult, ResultEvent};
use apex_model::because::Evidence;
use apex_model::condition::{Condition, ConditionKind};
use apex_model::evidence_list::EvidenceList;
use apex_model::time::Time;
use std::collections::BTreeMap;

/// Absences whose end is not known yet.
#[derive(Default)]
pub(crate) struct Absences {
    /// The monitor of each absence, by the monitor of the absent condition.
    watched: BTreeMap<MonitorId, MonitorId>,
    /// The last recognised absence of each absence monitor; `None` before the first one.
    lasting: BTreeMap<MonitorId, Option<MonitorResult>>,
}

/// Returns the condition that is absent, if `condition` is an absence.
pub(crate) fn absent(condition: &Condition) -> Option<&Condition> {
    match &condition.kind {
        ConditionKind::Absent(part, _) => Some(part),
        _ => None,
    }
}

impl Absences {
    /// Notes that the monitor `part` watches the condition that is absent in `absence`.
    pub(crate) fn add(&mut self, absence: MonitorId, part: MonitorId) {
        self.watched.insert(part, absence);
        self.lasting.insert(absence, None);
    }

    /// Takes a result and returns the one that can be reported now: an absence when it is over, all other results at once.
    pub(crate) fn pass(&mut self, result: MonitorResult) -> Option<MonitorResult> {
        if let Some(absence) = self.watched.get(&result.watch) {
            let lasting = self.lasting.get_mut(absence)?;
            let begin = result.result.interval.0;
            let is_over = lasting.as_ref().is_some_and(|known| known.result.interval.1 <= begin);
            return if is_over { lasting.take().map(|known| until(known, begin)) } else { None };
        }
        match self.lasting.get_mut(&result.watch) {
            Some(lasting) => lasting.replace(result),
            None => Some(result),
        }
    }

    /// Returns the absences that last until the input ends at `end`.
    pub(crate) fn finish(&mut self, end: Time) -> Vec<MonitorResult> {
        let lasting = self.lasting.values_mut().filter_map(Option::take);
        lasting.map(|known| until(known, end)).collect()
    }
}

/// Returns the absence with its interval and evidence up to `end`.
fn until(mut known: MonitorResult, end: Time) -> MonitorResult {
    let interval = &mut known.result.interval;
    interval.1 = interval.1.max(end);
    let end = interval.1;
    let what = known.result.evidence.iter().find_map(|evidence| match evidence {
        Evidence::Absence { what, .. } => Some(what.clone()),
        _ => None,
    });
    if let Some(what) = what {
        known.result.evidence = EvidenceList::one(Evidence::Absence { what, at: end });
    }
    known.telling = ResultEvent::Recognised { open: false };
    known
}
