//! The history of an observation target: its recorded states up to the instant of a question.

use super::answer::TargetMoment;
use super::snapshot::RecordSnapshot;
use crate::error::RecordError;
use crate::record::view::TargetChange;
use apex_model::time::Time;

impl TargetMoment {
    /// Returns the detail without the state, which some details repeat: `for 9:30` of `planned for 9:30`.
    pub(super) fn rest(&self) -> &str {
        self.detail.strip_prefix(&self.state).filter(|rest| rest.starts_with(' ')).unwrap_or(&self.detail).trim()
    }
}

/// Returns the recorded states of the target up to the instant of the question; repetitions are left out.
pub(super) fn moments(snapshot: &RecordSnapshot<'_>, id: &str) -> Result<Vec<TargetMoment>, RecordError> {
    let moment = |change: TargetChange| TargetMoment {
        t: Time(change.t_ns).seconds(),
        state: change.state,
        detail: change.detail.unwrap_or_default(),
    };
    let changes = snapshot.decisions().target_changes(id)?;
    let mut moments: Vec<TargetMoment> = changes.into_iter().map(moment).collect();
    moments.dedup_by(|later, earlier| later.state == earlier.state && later.detail == earlier.detail);
    Ok(moments)
}
