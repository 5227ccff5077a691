//! One condition of a session: waiting for its beginning, or active with its monitor.

use super::scene::SessionState;
use crate::expression::EvaluationError;
use crate::monitoring::combination::result_report::{self, ResultReport};
use crate::monitoring::combination::{interest, monitors};
use crate::monitoring::episodes::threshold_episode;
use crate::monitoring::episodes::threshold_formula::{self, Leaves};
use crate::monitoring::memory::retention;
use crate::monitoring::reported_results::ReportedResults;
use crate::monitoring::stimulus::Stimulus;
use crate::state::clause::MonitorId;
use crate::state::episode_index::IndexedRun;
use crate::state::interests::{Interests, Narrowed};
use crate::state::monitors::monitor::{Interest, Keep, Monitor, Satisfaction, Unmet, Window};
use apex_model::condition::Condition;
use apex_model::event::StateVariable;
use apex_model::time::{Duration, Time};
use std::sync::Arc;

/// A condition with its monitor and the state of its reports.
#[derive(Clone, Debug)]
pub(super) struct WatchedCondition {
    pub(super) condition: Arc<Condition>,
    pub(super) created_at: Time,
    /// `None` until `created_at` has arrived.
    pub(super) monitor: Option<Monitor>,
    pub(super) told: ReportedResults,
    /// Stimuli that the monitor must receive.
    interests: Vec<Interest>,
    /// True if interests may change, because the condition refers to tasks that are not known yet.
    changing: bool,
    pub(super) wake: Option<Time>,
    /// The first result as it was when it was recognised.
    pub(super) first: Option<Satisfaction>,
    pub(super) results: u64,
    /// The leaves of a combination that episode indexes watch.
    pub(super) leaves: Option<Leaves>,
    /// Maximum lateness of its samples.
    pub(super) lateness: Duration,
}

impl WatchedCondition {
    /// Returns a condition that begins at `created_at`. A monitor is made at once as a trial, so that errors are reported early.
    pub(super) fn new(
        condition: Condition,
        created_at: Time,
        lateness: Duration,
        world: &SessionState,
    ) -> Result<WatchedCondition, EvaluationError> {
        let mut watched = WatchedCondition {
            condition: Arc::new(condition),
            created_at,
            monitor: None,
            told: ReportedResults::default(),
            interests: Vec::new(),
            changing: false,
            wake: None,
            first: None,
            results: 0,
            leaves: None,
            lateness,
        };
        watched.begin(world)?;
        if created_at > world.now {
            watched.monitor = None;
        }
        Ok(watched)
    }

    /// Makes the monitor and looks back over the remembered data since the condition's beginning.
    pub(super) fn begin(&mut self, world: &SessionState) -> Result<(), EvaluationError> {
        let window = Window::from(self.created_at);
        let monitor = monitors::create_keeping(&self.condition, window, Keep::Every, world)?;
        self.interests = interest::interests(&monitor);
        self.lateness = lateness_of(&self.interests, world).unwrap_or(self.lateness);
        self.changing = self.interests.iter().any(|each| matches!(each, Interest::Task(_) | Interest::AnyTask));
        self.monitor = Some(monitor);
        Ok(())
    }

    pub(super) fn notice(&mut self, stimulus: &Stimulus, world: &SessionState) {
        if let Some(monitor) = &mut self.monitor {
            monitors::notice(monitor, stimulus, world);
        }
    }

    /// Restores the monitor of a condition from an index, which has reported all of its results.
    pub(super) fn stand_up(&mut self, seen: Option<IndexedRun>) {
        let Some(monitor) = &mut self.monitor else { return };
        let open_at = seen.as_ref().and_then(|seen| seen.open_at);
        threshold_episode::stand_up(monitor, seen);
        self.told = threshold_episode::told(monitor, open_at);
    }

    /// Returns the variable whose samples decide leaf number `leaf`, if an episode index may watch that leaf.
    pub(super) fn variable_in_bank(&self, leaf: u32) -> Option<&StateVariable> {
        match &self.leaves {
            Some(leaves) => leaves.variables().nth(leaf as usize),
            None => threshold_episode::variable(self.monitor.as_ref()?),
        }
    }

    /// Lets indexes watch a combination again after its results were collected; `any` is true if one was reported.
    pub(super) fn lie_down_again(&mut self, any: bool) {
        if let WatchedCondition { monitor: Some(monitor), leaves: Some(leaves), .. } = self {
            threshold_formula::harvested(monitor, leaves, any);
            threshold_formula::lie_down(monitor);
        }
    }

    /// Collects the new results, after everything of the instant was noticed.
    pub(super) fn take_reports(&mut self, world: &SessionState) -> Vec<ResultReport> {
        match &mut self.monitor {
            Some(monitor) => result_report::report_results(monitor, &mut self.told, self.lateness, world),
            None => Vec::new(),
        }
    }

    /// Returns the final state of results whose intervals could still grow.
    pub(super) fn finish(&mut self, world: &SessionState) -> Vec<ResultReport> {
        match &self.monitor {
            Some(monitor) => result_report::finish(monitor, &mut self.told, world),
            None => Vec::new(),
        }
    }

    pub(super) fn next_wake(&self) -> Option<Time> {
        match &self.monitor {
            Some(monitor) => monitors::next_wake(monitor).map(|(at, _)| at),
            None => Some(self.created_at),
        }
    }

    pub(super) fn file(&self, interests: &mut Interests, id: MonitorId) {
        let narrowed = self.narrowed();
        self.interests.iter().for_each(|interest| interests.insert(interest, narrowed, id));
    }

    pub(super) fn take_out(&self, interests: &mut Interests, id: MonitorId) {
        let narrowed = self.narrowed();
        self.interests.iter().for_each(|interest| interests.remove(interest, narrowed, id));
    }

    /// Returns the threshold of a single comparison: samples that cannot satisfy it need not reach the monitor.
    fn narrowed(&self) -> Narrowed<'static> {
        let threshold = self.monitor.as_ref().and_then(interest::threshold);
        Narrowed { second: None, threshold }
    }

    /// Files the monitor under the stimuli of a task that a verdict has determined.
    pub(super) fn refile(&mut self, interests: &mut Interests, id: MonitorId) {
        let Some(monitor) = self.monitor.as_ref().filter(|_| self.changing) else { return };
        let wanted = interest::interests(monitor);
        if wanted != self.interests {
            self.take_out(interests, id);
            self.interests = wanted;
            self.file(interests, id);
        }
    }
}

/// Returns the maximum lateness of samples if the condition watches only samples.
fn lateness_of(interests: &[Interest], world: &SessionState) -> Option<Duration> {
    let mut most = Duration::ZERO;
    for interest in interests {
        let attribute = match interest {
            Interest::Variable(variable) => &variable.attribute,
            Interest::Attribute(attribute) => attribute,
            _ => return None,
        };
        let declared = world.library.state_variables.get(attribute).and_then(retention::lateness);
        most = most.max(declared.unwrap_or_default());
    }
    Some(most)
}

/// Returns the status of a condition that has not begun.
pub(super) fn not_begun(watched: &WatchedCondition) -> Unmet {
    Unmet {
        what: "the condition".to_string(),
        now: format!("it is watched from {} on", watched.created_at),
        unobserved: false,
        since: None,
        until: Some(watched.created_at),
        distance: None,
        place: watched.condition.place,
    }
}
