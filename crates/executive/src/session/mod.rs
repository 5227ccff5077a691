//! Conditions without tasks: a session watches conditions over samples and messages, and reports every result.

mod attributes;
mod banks;
mod gaps;
mod input;
mod reading;
mod results;
mod scene;
#[cfg(test)]
mod tests;
mod watched;

use crate::constants;
use crate::monitoring::combination::monitors;
use crate::monitoring::combination::result_report::{self, ResultReportKind};
use crate::monitoring::derivation::{self, Changed, Surroundings};
use crate::monitoring::memory::histories::{self, Recording};
use crate::monitoring::memory::retention;
use crate::monitoring::stimulus::Stimulus;
use crate::state::bindings::Bindings;
use crate::state::clause::MonitorId;
use crate::state::episode_index;
use crate::state::episode_index::LeafId;
use crate::state::histories::history::Histories;
use crate::state::interests::Interests;
use crate::state::monitor_set::MonitorIds;
use crate::state::monitors::monitor::Satisfaction;
use crate::state::recorded::Recorded;
use crate::state::table::Table;
use crate::state::variable_index::VariableIndex;
use apex_model::agent_limits::Limits;
use apex_model::condition::Condition;
use apex_model::event::{StateVariable, measured};
use apex_model::host::HostFunctions;
use apex_model::library::Library;
use apex_model::limits::SESSION_TROUBLES_MAX;
use apex_model::symbol::Symbol;
use apex_model::task::{TaskId, TaskState};
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
pub use gaps::SamplingGap;
use gaps::Spacings;
pub use results::{Judgement, MonitorResult, ResultEvent, SessionError};
use scene::{KnownTask, SessionState};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use watched::WatchedCondition;

/// Watches conditions over a stream of samples, messages and changes of tasks' states (`conditions.md`).
///
/// Stimuli may arrive in any number and order of calls; their instants advance the session's time, which never decreases. All stimuli
/// of one instant form one step (rule 4): an instant is over when a stimulus of a later instant arrives, or when
/// [`advance`](MonitorSession::advance) passes it. Decisions by the passing of time alone are made at their exact instant. So
/// results depend neither on the division into calls nor on the frequency of `advance` (rule 21).
///
/// # What is reported
///
/// A task waits for the first result of a condition; a session reports all results, each once:
///
/// - **A single condition** (measurement, episode, event, ..) reports every result: each sample that satisfies a
///   measurement, each maximal run that satisfies an episode, each message that matches. With an object variable there
///   are such results for each object.
/// - **An episode** is reported when it is recognised, say after its `:duration`. Its run may continue: then the result is marked
///   [`open`](ResultEvent::Recognised), and it is reported once more, with its final interval, when the run is over, which the
///   next sample shows: [`ResultEvent::Closed`]. A caller that needs each result once considers either kind.
/// - **A combination** (`:and`, `:in-order`, ..) reports a result as soon as results of its parts form one, and then begins again:
///   results of the parts up to that instant form no further result. Of several results of one instant that bind the same variables
///   (except for tags) the first in order is reported.
/// - **The alternatives** of an outermost `:or` are reported separately.
/// - **An absence** (`:not`) is reported once, when it becomes true, and not at every instant at which it is still true.
///
/// A late sample, within its variable's `:lateness`, can produce a result, which is recognised at the session's time. Earlier reports
/// are not revoked.
///
/// Results wait in the session until they are [taken](MonitorSession::take_results).
#[derive(Clone, Debug)]
pub struct MonitorSession {
    world: SessionState,
    interests: Interests,
    watches: Table<WatchedCondition>,
    next_watch: u64,
    arrivals: u64,
    /// Greatest delay of samples.
    lateness: Duration,
    /// True if no episode index is used, so that monitors process every sample; for comparisons.
    without_banks: bool,
    /// Stimuli of the present instant.
    stimuli: Vec<Stimulus>,
    /// Samples of the present instant that derived variables read.
    derive_from: Vec<Changed>,
    touched: Vec<MonitorId>,
    /// Updates that episode indexes have reported for the present instant.
    heard: Vec<episode_index::EpisodeUpdate>,
    /// Instants at which a condition begins or is judged, or at which the episode index of its leaf with this number is evaluated.
    wakes: BTreeSet<(Time, MonitorId, Option<u32>)>,
    results: Vec<MonitorResult>,
    /// Spacings for the gaps of results, if requested.
    spacings: Option<Spacings>,
    troubles: Vec<SessionError>,
}

impl MonitorSession {
    /// Returns a session in terms of `library`: its declared state variables, functions, constants and indexicals.
    ///
    /// # Errors
    /// A message if a declared host function is not registered or a constant has no value.
    pub fn new(library: Arc<Library>, host: HostFunctions) -> Result<MonitorSession, String> {
        crate::registration::all_registered(&library, &host)?;
        let mut histories = Histories::default();
        retention::prepare(&mut histories, &library, None);
        let lateness = library.state_variables.values().filter_map(|declared| declared.lateness.as_ref());
        let lateness = lateness.filter_map(|value| crate::expression::arithmetic::duration(value).ok()).max();
        let index = Arc::new(VariableIndex::new(&library));
        let mut world = SessionState {
            library,
            index,
            host,
            name: Symbol::new("monitor"),
            histories,
            tasks: BTreeMap::new(),
            variables: Bindings::new(),
            now: Time::BEGINNING,
            limits: Limits::default(),
        };
        let values = constants::compute(&world.library, &world)?;
        if !values.is_empty() {
            Arc::make_mut(&mut world.library).constants.extend(values);
        }
        Ok(MonitorSession {
            world,
            interests: Interests::narrowing(),
            watches: Table::default(),
            next_watch: 0,
            arrivals: 0,
            lateness: lateness.unwrap_or_default(),
            without_banks: false,
            stimuli: Vec::new(),
            derive_from: Vec::new(),
            touched: Vec::new(),
            heard: Vec::new(),
            wakes: BTreeSet::new(),
            results: Vec::new(),
            spacings: None,
            troubles: Vec::new(),
        })
    }

    /// Lets results state the largest time without a sample within them, so that a user can judge the density of the data.
    ///
    /// It is known for runs whose samples all arrived in order.
    pub fn with_gaps(mut self) -> MonitorSession {
        self.spacings = Some(Spacings::default());
        self
    }

    /// Lets the session keep all samples, messages and results: for logs, whose length bounds the memory.
    pub fn over_a_log(mut self) -> MonitorSession {
        self.world.limits = Limits::of_a_log();
        self.world.histories.limit(&self.world.limits);
        self
    }

    /// Keeps all samples, not only those that the conditions may still read.
    pub fn keeping_samples(mut self) -> MonitorSession {
        self.world.histories.require_lookback_of_all(Duration::MAX);
        self
    }

    /// Watches `condition` with a window from `created_at` on (rule 2). If that instant is in the future, the watch begins then; if it is
    /// in the past, the retained history is searched first, and results found there are recognised now.
    ///
    /// # Errors
    /// A message with its place if an expression that must be known now (a duration, a gap) has no value.
    pub fn watch(&mut self, condition: Condition, created_at: Time) -> Result<MonitorId, SessionError> {
        self.end_instant();
        let SessionState { histories, library, .. } = &mut self.world;
        retention::prepare_condition(histories, library, &condition);
        let id = MonitorId(self.next_watch);
        let watched = WatchedCondition::new(condition, created_at, self.lateness, &self.world).map_err(|error| {
            SessionError { watch: None, at: self.world.now, message: error.message, place: Some(error.place) }
        })?;
        self.next_watch += 1;
        if watched.monitor.is_some() {
            watched.file(&mut self.interests, id);
        }
        self.watches.insert(id.0, watched);
        self.judge(id);
        Ok(id)
    }

    /// Ends the watch of a condition. Its reported results stay until they are taken.
    pub fn unwatch(&mut self, id: MonitorId) {
        self.end_instant();
        if let Some(mut watched) = self.watches.remove(id.0) {
            self.take_out_of_bank(id, &mut watched);
            watched.take_out(&mut self.interests, id);
            if let Some(at) = watched.wake {
                self.wakes.remove(&(at, id, None));
            }
        }
    }

    /// Binds a variable (without `?`) that conditions may name, for example the tag of a task.
    pub fn bind(&mut self, name: Symbol, value: Value) {
        self.end_instant();
        self.world.variables.set(name, value);
        self.touch_all();
    }

    /// Records a measurement; a number without unit is in the declared unit. Returns the result of recording it; `None` if it was
    /// rejected, for the reason that a session error states.
    pub fn sample(&mut self, variable: &StateVariable, value: Value, at: Time) -> Option<Recorded> {
        self.come_to(at);
        let sequence = self.arrival();
        let SessionState { histories, index, .. } = &mut self.world;
        let recording = histories::record_sample(histories, index, variable.clone(), value, at, sequence);
        if recording.stimulus.is_some() && !index.readers(&variable.attribute).is_empty() {
            self.derive_from.push(Changed { variable: variable.clone(), at });
        }
        self.take_in(variable, at, recording)
    }

    /// Passes a sample to the conditions that watch its variable.
    fn take_in(&mut self, variable: &StateVariable, at: Time, recording: Recording) -> Option<Recorded> {
        if !self.interests.ignore_variable(variable) {
            self.stimuli.extend(recording.stimulus);
        }
        // Gaps are kept also for variables without a monitor, because a watch may begin at this instant.
        if let Some(spacings) = &mut self.spacings {
            spacings.note(variable, at, recording.recorded);
        }
        let overflow = || histories::overflow_of_samples(variable, &self.world.limits);
        for message in recording.trouble.into_iter().chain(recording.overflows.then(overflow)) {
            self.trouble(SessionError { watch: None, at, message, place: None });
        }
        recording.recorded
    }

    /// Records a message.
    pub fn event(&mut self, form: Value, at: Time) {
        if let Some((variable, value)) = measured(&form) {
            self.sample(&variable, value, at);
            return;
        }
        self.come_to(at);
        let sequence = self.arrival();
        let (stimulus, overflows) = histories::record_event(&mut self.world.histories, form, at, sequence);
        self.stimuli.push(stimulus);
        if overflows {
            let message = histories::overflow_of_messages(&self.world.limits);
            self.trouble(SessionError { watch: None, at, message, place: None });
        }
    }

    /// Records that a task enters a state; a task that the session does not know was pending before.
    pub fn task_state(&mut self, task: TaskId, state: TaskState, at: Time) {
        self.come_to(at);
        let first = KnownTask { state: TaskState::Pending, since: at, started_at: at, worked: Duration::ZERO };
        let known = self.world.tasks.entry(task).or_insert(first);
        let from = known.state;
        known.enter(state, at);
        self.stimuli.push(Stimulus::TaskState { task, from, state, at, before: MonitorId(u64::MAX) });
        if state == TaskState::Terminated {
            self.stimuli.push(Stimulus::TaskEnded { task, outcome: &[], at, before: MonitorId(u64::MAX) });
        }
    }

    /// Advances the time past `now`: all stimuli up to and including `now` were delivered, so its results are reported.
    pub fn advance(&mut self, now: Time) {
        self.come_to(now);
        self.end_instant();
    }

    /// Advances the time to `at`; further stimuli of that instant may follow.
    pub fn advance_to(&mut self, at: Time) {
        self.come_to(at);
    }

    /// Ends the session: results whose interval could still grow are reported as closed.
    pub fn finish(&mut self) {
        self.end_instant();
        for number in 0..self.next_watch {
            let Some(mut watched) = self.watches.lift(number) else { continue };
            self.take_out_of_bank(MonitorId(number), &mut watched);
            for telling in watched.finish(&self.world) {
                self.results.push(self.told(MonitorId(number), telling));
            }
            self.watches.put(number, watched);
        }
    }

    fn arrival(&mut self) -> u64 {
        self.arrivals += 1;
        self.arrivals
    }

    fn trouble(&mut self, trouble: SessionError) {
        if self.troubles.len() < SESSION_TROUBLES_MAX {
            self.troubles.push(trouble);
        }
    }

    /// Executes all wakes that are due before `at`, and advances the time to `at`.
    fn come_to(&mut self, at: Time) {
        if at <= self.world.now {
            return;
        }
        self.end_instant();
        while let Some((due, ..)) = self.wakes.first().copied().filter(|(due, ..)| *due < at) {
            self.world.now = self.world.now.max(due);
            self.end_instant();
        }
        self.world.now = at;
    }

    /// Ends the present instant: monitors process its stimuli, due watches begin, and all affected conditions are judged.
    fn end_instant(&mut self) {
        let now = self.world.now;
        self.derive();
        if self.stimuli.is_empty() && self.wakes.first().is_none_or(|(due, ..)| *due > now) {
            return;
        }
        let mut found = MonitorIds::new();
        let stimuli = std::mem::take(&mut self.stimuli);
        let repeated = banks::repeated(&stimuli);
        for stimulus in &stimuli {
            found.clear();
            match stimulus {
                Stimulus::Sample { variable, value, newest, .. } => {
                    self.interests.of_sample(variable, value, *newest, &mut found);
                }
                Stimulus::Event { form, .. } => self.interests.of_event(form, &mut found),
                Stimulus::TaskEnded { task, .. } | Stimulus::TaskState { task, .. } => {
                    self.interests.of_task(*task, &mut found);
                }
            }
            self.show_bank(stimulus, &repeated, &mut found);
            found.sort_unstable();
            found.dedup();
            for id in &found {
                if let Some(watched) = self.watches.get_mut(id.0) {
                    watched.notice(stimulus, &self.world);
                }
            }
            self.touched.extend(&found);
        }
        while let Some(wake) = self.wakes.first().copied().filter(|(due, ..)| *due <= now) {
            self.wakes.remove(&wake);
            match wake {
                (_, id, None) => self.begin(id),
                (_, monitor, Some(leaf)) => self.wake_bank(LeafId { monitor, leaf }),
            }
        }
        found.clear();
        self.interests.of_every_step(&mut found);
        self.touched.extend(&found);
        self.judge_touched();
    }

    /// Computes the samples of derived variables from those of the present instant.
    fn derive(&mut self) {
        if self.derive_from.is_empty() {
            return;
        }
        let changed = std::mem::take(&mut self.derive_from);
        let SessionState { library, index, host, name, limits, histories, .. } = &mut self.world;
        let surroundings = Surroundings { library, index, host, agent: name, limits };
        let arrivals = &mut self.arrivals;
        let mut arrival = || {
            *arrivals += 1;
            *arrivals
        };
        for derived in derivation::derive(changed, histories, &surroundings, &mut arrival) {
            self.take_in(&derived.variable, derived.at, derived.recording);
        }
    }

    fn judge_touched(&mut self) {
        let before = self.results.len();
        self.tell_heard();
        let heard = self.results.len() > before;
        let mut touched = std::mem::take(&mut self.touched);
        touched.sort_unstable();
        touched.dedup();
        touched.iter().for_each(|id| self.judge(*id));
        if let Some(told) = self.results.get_mut(before..).filter(|_| heard && !touched.is_empty()) {
            told.sort_by_key(|result| result.watch);
        }
        touched.clear();
        self.touched = touched;
    }

    fn touch_all(&mut self) {
        for number in 0..self.next_watch {
            self.judge(MonitorId(number));
        }
    }

    /// Reports the new results of a condition and requests its next wake.
    fn judge(&mut self, id: MonitorId) {
        let Some(mut watched) = self.watches.lift(id.0) else { return };
        let in_banks = self.look_into_banks(id, &mut watched);
        let before = watched.results;
        for report in watched.take_reports(&self.world) {
            if report.kind != ResultReportKind::Closed {
                watched.results += 1;
                watched.first.get_or_insert_with(|| report.result.clone());
            }
            self.results.push(self.told(id, report));
        }
        watched.refile(&mut self.interests, id);
        if in_banks {
            let any = watched.results > before;
            watched.lie_down_again(any);
        }
        let wake = if in_banks || self.put_into_bank(id, &mut watched) { None } else { watched.next_wake() };
        if wake != watched.wake {
            if let Some(at) = watched.wake {
                self.wakes.remove(&(at, id, None));
            }
            self.wakes.extend(wake.map(|at| (at, id, None)));
            watched.wake = wake;
        }
        let troubles = watched.monitor.as_mut().map(monitors::take_troubles).unwrap_or_default();
        self.watches.put(id.0, watched);
        for trouble in troubles {
            let (message, place) = (trouble.message, Some(trouble.place));
            self.trouble(SessionError { watch: Some(id), at: self.world.now, message, place });
        }
    }

    fn told(&self, watch: MonitorId, telling: result_report::ResultReport) -> MonitorResult {
        let kind = match telling.kind {
            ResultReportKind::Found { open } => ResultEvent::Recognised { open },
            ResultReportKind::Closed => ResultEvent::Closed,
        };
        MonitorResult { watch, telling: kind, gaps: self.gaps_of(&telling.result), result: telling.result }
    }

    fn gaps_of(&self, result: &Satisfaction) -> Vec<SamplingGap> {
        self.spacings.as_ref().map(|spacings| spacings.of(result)).unwrap_or_default()
    }
}
