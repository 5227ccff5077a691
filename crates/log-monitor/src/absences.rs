//! Final intervals of absences in a log: `(:absent C :for D)` is recognised when D has passed, and the absence lasts until C occurs.
//!
//! For each such condition C is watched by a separate monitor. A recognised absence is held back until C occurs or the input ends, because
//! only then its interval is known. If the interval of C begins within the window that was recognised, the absence lasts until C is
//! recognised: the interval of a combination, or of a run with a least duration, begins before that is known.

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
            let end = lasting.as_ref().and_then(|known| ended_by(known, &result))?;
            return lasting.take().map(|known| until(known, end));
        }
        match self.lasting.get_mut(&result.watch) {
            Some(lasting) => lasting.replace(result),
            None => Some(result),
        }
    }

    /// Returns the absences that last until the input ends, each with the monitor of the absent condition.
    pub(crate) fn finish(&mut self) -> Vec<(MonitorResult, MonitorId)> {
        let mut found = Vec::new();
        for (part, absence) in &self.watched {
            let known = self.lasting.get_mut(absence).and_then(Option::take);
            found.extend(known.map(|known| (known, *part)));
        }
        found.sort_by_key(|(known, _)| known.watch);
        found
    }
}

/// Returns the end of the absence `known` if `result` of the absent condition ends it. A result from before the absence, which becomes
/// known or is over while the absence lasts, does not.
fn ended_by(known: &MonitorResult, result: &MonitorResult) -> Option<Time> {
    let (since, recognised) = known.result.interval;
    let (first, last) = result.result.interval;
    let at = result.result.recognised_at;
    if recognised <= first {
        return Some(first);
    }
    let ends = recognised <= at && since < last;
    ends.then_some(if is_past_run(result) { recognised } else { at })
}

/// Returns true for a run that was over when it was recognised: until then the absence would include the whole run.
fn is_past_run(result: &MonitorResult) -> bool {
    let mut evidence = result.result.evidence.iter();
    let is_run = matches!(evidence.next(), Some(Evidence::Run { .. })) && evidence.next().is_none();
    let is_over = result.telling != ResultEvent::Recognised { open: true };
    is_run && is_over && result.result.interval.1 < result.result.recognised_at
}

/// Returns the absence with its interval and evidence up to `end`.
pub(crate) fn until(mut known: MonitorResult, end: Time) -> MonitorResult {
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
