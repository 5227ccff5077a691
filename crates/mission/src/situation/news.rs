//! Updates of the mission during a flight, and plans that visit a fire by an outline that has been replaced.
//!
//! A report of an outline leads to a new plan between two observations. If the fire is the next one to be visited and no observation is
//! under way, that would be after its visit: the message `(plan-outdated TARGET)` asks for a plan at once.

use super::updates::MissionUpdates;
use super::{MissionEvent, MissionUpdate, Situation, Visit};
use crate::Mission;
use apex_model::event::{Batch, EventKind};
use apex_model::problem::Plan;
use apex_model::time::Time;
use apex_model::value::Value;
use apex_runtime::ports::Input;
use apex_runtime::target_state::TargetState;

impl Situation {
    /// Records an update, and a note about it.
    pub(super) fn take_update(&mut self, mission: &Mission, at: Time, update: MissionUpdate) {
        if let Some(note) = MissionUpdates::without_subject(&update, mission) {
            self.updates.apply(update);
            self.note_once(at, &note);
            return;
        }
        let is_of = |visit: &Visit, target: &str| visit.target.split('/').next() == Some(target);
        match &update {
            // A fire is evaluated by the outline that was known when it was first observed.
            MissionUpdate::NewPerimeter(target, _) if self.visits.iter().any(|visit| is_of(visit, target)) => {
                self.note(at, format!("{target} has grown since it was observed"));
            }
            MissionUpdate::TargetGone { printed, .. } => {
                let printed = printed.clone();
                let note = self.updates.apply(update);
                self.note(at, note);
                self.change(printed, at, TargetState::Skipped, "no longer a target".to_string());
            }
            _ => {
                if matches!(update, MissionUpdate::PlanImposed(_)) {
                    self.imposed_from = at;
                }
                let note = self.updates.apply(update);
                self.note(at, note);
            }
        }
    }

    /// Returns the message about the next visit of the plan, if its fire has a new outline in this batch; at most one.
    pub(super) fn outdated(&self, batch: &Batch) -> Option<Input> {
        let last = self.visits.last().filter(|visit| visit.end.is_none());
        if last.is_some_and(|visit| self.state_of(&visit.target) == Some(TargetState::Observing)) {
            return None;
        }
        let Some(Plan::SingleVisit(plan)) = self.plan.as_ref().map(|made| &made.plan) else { return None };
        let next = plan.visits.iter().find(|visit| self.state_of(&visit.target) == Some(TargetState::Planned))?;
        // Ground by which a fire has grown, `FIRE/growth-1`, follows the outline of the fire.
        let fire = next.target.split('/').next()?;
        let is_of = |form: &Value| match MissionEvent::read(form) {
            Some(MissionEvent::Update(MissionUpdate::NewPerimeter(target, _))) => target == fire,
            _ => false,
        };
        let is_new = batch.events.iter().any(|event| match &event.kind {
            EventKind::Occurrence(form) => is_of(form),
            _ => false,
        });
        let form = Value::list([Value::symbol("plan-outdated"), Value::symbol(&next.target)]);
        is_new.then(|| Input::new(batch.now, EventKind::Occurrence(form)))
    }
}
