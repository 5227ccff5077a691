//! The history of an observation target: its recorded states up to the instant of a question.

use super::answer::TargetMoment;
use super::snapshot::RecordSnapshot;
use crate::error::RecordError;
use crate::record::view::TargetChange;
use apex_model::time::Time;

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
