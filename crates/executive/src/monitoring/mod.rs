//! Monitoring and interpretation services: what conditions mean (`monitoring.md`; paper, section IV and Appendix B).
//!
//! One file per service. A monitor is plain data (`apex_model::monitor`); it is made by [`create`], fed by [`notice`]
//! with the stimuli it has an interest in, and asked by [`verdict`].

mod absence;
mod aggregates;
mod allen;
mod choices;
pub(crate) mod constraints;
mod creation;
mod cyclic;
mod episode;
pub(crate) mod event;
mod extents;
mod function;
mod harvest;
mod histories;
mod interest;
mod line_crossing;
mod logic;
mod measurement;
mod number_runs;
mod numbers_unmet;
mod parts;
pub(crate) mod pattern_matching;
mod persistence;
pub(crate) mod plain_combination;
pub(crate) mod plain_episode;
mod plain_look_back;
mod quick_runs;
mod reach;
mod regression;
mod relation;
mod replay;
mod retention;
mod retention_of_absence;
mod retention_of_queries;
mod runs;
mod samples;
mod significance;
mod sliding_window;
pub(crate) mod specificity;
mod statistics;
mod stimulus;
pub(crate) mod task_state;
#[cfg(test)]
mod tests;
mod time_bounds;
mod time_conditions;
mod together;
mod unmet;
mod wake;

pub(crate) use harvest::{Telling, TellingKind, Told, finish, harvest};
pub(crate) use histories::{overflow_of_messages, overflow_of_samples, record_event, record_sample};
pub(crate) use interest::{interests, lasting_interest, threshold};
pub(crate) use parts::holds as part_holds;
pub(crate) use retention::{demands, lateness, prepare, prepare_condition};
pub(crate) use stimulus::Stimulus;
pub(crate) use wake::WakeReason;

use crate::expression::{EvaluationError, Surroundings};
use apex_model::agent_limits::Limit;
use apex_model::condition::Condition;
use apex_model::limits::MONITOR_RESULTS_MAX;
use apex_model::monitor::{Keep, Monitor, Part, PartKind, Satisfaction, Trouble, Unmet, Verdict, Window};
use apex_model::source::Place;
use apex_model::time::Time;
use samples::Seen;
use time_conditions::Kind;

/// Kleene's three values, in order: conjunction is the least, disjunction the greatest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Truth {
    False,
    Unknown,
    True,
}

impl Truth {
    fn of(satisfied: bool, unknown: bool) -> Truth {
        match (satisfied, unknown) {
            (true, _) => Truth::True,
            (false, true) => Truth::Unknown,
            (false, false) => Truth::False,
        }
    }

    fn negated(self) -> Truth {
        match self {
            Truth::False => Truth::True,
            Truth::Unknown => Truth::Unknown,
            Truth::True => Truth::False,
        }
    }
}

/// What every part's service needs to know of the part.
#[derive(Clone, Copy)]
struct Site {
    window: Window,
    keep: Keep,
    place: Place,
}

fn site(part: &Part) -> Site {
    Site { window: part.window, keep: part.keep, place: part.place }
}

/// Errors met while judging, each once.
#[derive(Default)]
struct Troubles(Vec<Trouble>);

impl Troubles {
    fn add(&mut self, error: EvaluationError) {
        let trouble = Trouble { message: error.message, place: error.place };
        if !self.0.contains(&trouble) {
            self.0.push(trouble);
        }
    }

    fn reached(&mut self, limit: Limit, surroundings: &dyn Surroundings, place: Place) {
        self.limit(limit.constant(), surroundings.limits().count(limit), place);
    }

    fn limit(&mut self, name: &str, value: usize, place: Place) {
        self.add(EvaluationError { message: format!("the limit {name} = {value} of a condition was reached"), place });
    }

    fn too_many_results(&mut self, place: Place) {
        self.limit("MONITOR_RESULTS_MAX", MONITOR_RESULTS_MAX, place);
    }

    /// Moves what is new into the monitor.
    fn tell(self, monitor: &mut Monitor) {
        for trouble in self.0 {
            let notes = monitor.notes.get_or_insert_default();
            if !notes.told.contains(&trouble) {
                notes.told.push(trouble.clone());
                notes.troubles.push(trouble);
            }
        }
    }
}

/// A question to a monitor.
struct Asking<'a> {
    surroundings: &'a dyn Surroundings,
    now: Time,
    troubles: Troubles,
    wake: Option<Time>,
    /// Results of parts that do not count any more.
    used: Option<harvest::Used>,
}

impl<'a> Asking<'a> {
    fn new(surroundings: &'a dyn Surroundings) -> Asking<'a> {
        Asking { surroundings, now: surroundings.now(), troubles: Troubles::default(), wake: None, used: None }
    }

    /// What `ask` says when everything counts.
    fn of_everything<T>(&mut self, ask: impl FnOnce(&mut Asking<'a>) -> T) -> T {
        let used = self.used.take();
        let answer = ask(self);
        self.used = used;
        answer
    }

    fn wake_at(&mut self, at: Time) {
        self.wake = Some(self.wake.map_or(at, |before| before.min(at)));
    }

    fn wake_at_after_now(&mut self, at: Time) {
        if at > self.now {
            self.wake_at(at);
        }
    }
}

/// Keeps a result, dropping the oldest when there are too many.
fn remember(settled: &mut Vec<Satisfaction>, result: Satisfaction, site: Site, troubles: &mut Troubles) {
    if settled.len() >= MONITOR_RESULTS_MAX {
        troubles.too_many_results(site.place);
        settled.drain(..MONITOR_RESULTS_MAX / 4);
    }
    settled.push(result);
}

/// Makes the monitor of `condition` and looks back over what is remembered since the window's start. That a task has
/// ended, or the state in which it is, counts also where it did so before.
///
/// # Errors
/// When an expression that must be known now (a duration, a gap) cannot be evaluated.
pub(crate) fn create(
    condition: &Condition,
    window: Window,
    surroundings: &dyn Surroundings,
) -> Result<Monitor, EvaluationError> {
    made(condition, window, (Keep::First, true), surroundings)
}

/// As [`create`], for a monitor of which only changes of tasks' states count from now on, not those that stand.
///
/// # Errors
/// As [`create`].
pub(crate) fn create_for_changes(
    condition: &Condition,
    window: Window,
    surroundings: &dyn Surroundings,
) -> Result<Monitor, EvaluationError> {
    made(condition, window, (Keep::First, false), surroundings)
}

/// As [`create`], for a monitor that remembers what `keep` says until it is harvested.
///
/// # Errors
/// As [`create`].
pub(crate) fn create_keeping(
    condition: &Condition,
    window: Window,
    keep: Keep,
    surroundings: &dyn Surroundings,
) -> Result<Monitor, EvaluationError> {
    made(condition, window, (keep, true), surroundings)
}

fn made(
    condition: &Condition,
    window: Window,
    manner: (Keep, bool),
    surroundings: &dyn Surroundings,
) -> Result<Monitor, EvaluationError> {
    let mut root = creation::tree(condition, window, manner, surroundings)?;
    let mut troubles = Troubles::default();
    creation::look_back(&mut root, surroundings, &mut troubles);
    let mut monitor =
        Monitor { created_at: surroundings.now(), window, root, asked_at: surroundings.now(), notes: None };
    troubles.tell(&mut monitor);
    Ok(monitor)
}

/// Tells `monitor` what happened. Stimuli it has no interest in change nothing.
pub(crate) fn notice(monitor: &mut Monitor, stimulus: &Stimulus, surroundings: &dyn Surroundings) {
    let mut troubles = Troubles::default();
    notice_part(&mut monitor.root, stimulus, surroundings, &mut troubles);
    troubles.tell(monitor);
}

fn notice_part(part: &mut Part, stimulus: &Stimulus, surroundings: &dyn Surroundings, troubles: &mut Troubles) {
    let site = site(part);
    if let Some(sequence) = replay::changes_the_past(part, stimulus, surroundings) {
        replay::replay(part, Some(sequence), surroundings, troubles);
        return;
    }
    if let Stimulus::Sample { variable, value, at, sequence, newest } = stimulus {
        let sample = Seen { variable, value, at: *at, sequence: *sequence };
        notice_sample(part, sample, *newest, surroundings, troubles);
    }
    match (&mut part.kind, stimulus) {
        (PartKind::Event(leaf), Stimulus::Event { form, at, sequence }) => {
            event::notice(leaf, site, form, *at, *sequence, surroundings, troubles);
        }
        (PartKind::TaskEnded(leaf), Stimulus::TaskEnded { task, at, .. }) => task_state::notice_ended(leaf, *task, *at),
        (PartKind::TaskState(leaf), Stimulus::TaskState { task, from, state, at, .. }) => {
            task_state::notice_state(leaf, site, (*task, *from, *state, *at), surroundings, troubles);
        }
        (PartKind::And(composite) | PartKind::Or(composite) | PartKind::InOrder(composite), _) => {
            composite.parts.iter_mut().for_each(|part| notice_part(part, stimulus, surroundings, troubles));
        }
        (PartKind::Not(inner), _) => notice_part(inner, stimulus, surroundings, troubles),
        (PartKind::Allen(leaf), _) if !allen::is_done(leaf, site) => {
            if let Stimulus::Sample { variable, at, newest: false, .. } = stimulus {
                allen::replace(leaf, variable, *at);
            }
            leaf.parts.iter_mut().for_each(|part| notice_part(part, stimulus, surroundings, troubles));
        }
        // Also when nothing more is wanted: what comes late may take back what was found.
        (PartKind::Absent(leaf), _) => {
            notice_part(&mut leaf.part, stimulus, surroundings, troubles);
            replay::look_at(part, stimulus, surroundings, troubles);
        }
        _ => {}
    }
}

/// Tells a part that watches a state variable of a sample.
fn notice_sample(
    part: &mut Part,
    sample: Seen<'_>,
    newest: bool,
    surroundings: &dyn Surroundings,
    troubles: &mut Troubles,
) {
    let site = site(part);
    match &mut part.kind {
        PartKind::Measurement(leaf) => measurement::notice(leaf, site, sample, newest, surroundings, troubles),
        PartKind::Episode(leaf) => episode::notice(leaf, site, sample, surroundings, troubles),
        PartKind::Persisted(leaf) => persistence::notice(leaf, site, sample, surroundings, troubles),
        PartKind::Regression(leaf) => regression::notice(leaf, site, sample, surroundings, troubles),
        PartKind::Statistical(leaf) => statistics::notice(leaf, site, sample, surroundings, troubles),
        PartKind::Cyclic(leaf) => cyclic::notice(leaf, site, sample, surroundings, troubles),
        _ => {}
    }
}

/// Lets parts that depend on time and on other tasks catch up with the present.
fn advance(part: &mut Part, surroundings: &dyn Surroundings, troubles: &mut Troubles) {
    let site = site(part);
    while let Some(at) = replay::overdue(part, surroundings.now()) {
        replay::look_then(part, at, surroundings, troubles);
    }
    match &mut part.kind {
        PartKind::TaskEnded(leaf) => task_state::advance_ended(leaf, surroundings),
        PartKind::TaskState(leaf) => task_state::advance_state(leaf, site, surroundings, troubles),
        PartKind::Timestamp(leaf) => time_conditions::advance(leaf, Kind::Timestamp, site, surroundings),
        PartKind::Delay(leaf) => time_conditions::advance(leaf, Kind::Delay, site, surroundings),
        PartKind::And(composite) | PartKind::Or(composite) | PartKind::InOrder(composite) => {
            composite.parts.iter_mut().for_each(|part| advance(part, surroundings, troubles));
        }
        PartKind::Not(inner) => advance(inner, surroundings, troubles),
        PartKind::Allen(leaf) => {
            leaf.parts.iter_mut().for_each(|part| advance(part, surroundings, troubles));
            allen::advance(leaf, site, part.tag.as_ref(), surroundings, troubles);
        }
        PartKind::Absent(leaf) => {
            advance(&mut leaf.part, surroundings, troubles);
            absence::advance(leaf, site, surroundings, troubles);
        }
        PartKind::Function(leaf) => function::advance(leaf, surroundings, troubles),
        PartKind::Measurement(_)
        | PartKind::Episode(_)
        | PartKind::Persisted(_)
        | PartKind::Regression(_)
        | PartKind::Statistical(_)
        | PartKind::Cyclic(_)
        | PartKind::Event(_) => {}
    }
}

/// Finds out anew which tasks the monitor is about: a tag stands for another one now.
pub(crate) fn look_for_tasks(monitor: &mut Monitor, surroundings: &dyn Surroundings) {
    let mut troubles = Troubles::default();
    advance(&mut monitor.root, surroundings, &mut troubles);
    troubles.tell(monitor);
}

/// Is the condition true at `surroundings.now()`? Asked after all stimuli of the instant were noticed.
pub(crate) fn verdict(monitor: &mut Monitor, surroundings: &dyn Surroundings) -> Verdict {
    let mut asking = Asking::new(surroundings);
    advance(&mut monitor.root, surroundings, &mut asking.troubles);
    let truth = logic::truth(&monitor.root, &mut asking);
    let best = match truth {
        Truth::True => logic::first_result(&monitor.root, &mut asking),
        Truth::False | Truth::Unknown => None,
    };
    monitor.asked_at = asking.now;
    if asking.wake.is_some() || monitor.notes.is_some() {
        monitor.notes.get_or_insert_default().delay_over_at = asking.wake;
    }
    let created_at = monitor.created_at;
    asking.troubles.tell(monitor);
    match (best, truth) {
        (Some(best), _) => {
            Verdict::Satisfied(Satisfaction { recognised_at: best.recognised_at.max(created_at), ..best })
        }
        (None, Truth::Unknown) => Verdict::Unknown,
        (None, Truth::True | Truth::False) => Verdict::NotSatisfied,
    }
}

/// When the verdict can change by time alone, strictly after the last `verdict`, and why.
pub(crate) fn next_wake(monitor: &Monitor) -> Option<(Time, WakeReason)> {
    let after = monitor.asked_at;
    let delay = monitor.notes.as_ref().and_then(|notes| notes.delay_over_at).filter(|at| *at > after);
    wake_of(&monitor.root, after).into_iter().chain(delay.map(|at| (at, WakeReason::Foreseen))).min()
}

fn wake_of(part: &Part, after: Time) -> Option<(Time, WakeReason)> {
    match &part.kind {
        PartKind::Episode(leaf) => episode::next_wake(leaf, site(part), after),
        PartKind::Timestamp(leaf) => time_conditions::next_wake(leaf, Kind::Timestamp, after),
        PartKind::Delay(leaf) => time_conditions::next_wake(leaf, Kind::Delay, after),
        PartKind::And(composite) | PartKind::Or(composite) => {
            composite.parts.iter().filter_map(|part| wake_of(part, after)).min()
        }
        // Delays between ordered parts are no instants of their own.
        PartKind::InOrder(composite) => composite
            .parts
            .iter()
            .filter(|part| !matches!(part.kind, PartKind::Delay(_)))
            .filter_map(|part| wake_of(part, after))
            .min(),
        PartKind::Not(inner) => wake_of(inner, after),
        PartKind::Allen(leaf) if allen::is_done(leaf, site(part)) => None,
        PartKind::Allen(leaf) => {
            let decided = leaf.decides_at.filter(|at| *at > after).map(|at| (at, WakeReason::RelationDecided));
            leaf.parts.iter().filter_map(|part| wake_of(part, after)).chain(decided).min()
        }
        PartKind::Absent(leaf) if absence::is_done(leaf, site(part)) => None,
        PartKind::Absent(leaf) => {
            let over = leaf.decides_at.filter(|at| *at > after).map(|at| (at, WakeReason::AbsenceOver(leaf.length)));
            wake_of(&leaf.part, after).into_iter().chain(over).min()
        }
        PartKind::Function(_) => None,
        // The last verdict said when these would come true.
        PartKind::Persisted(_) | PartKind::Regression(_) | PartKind::Statistical(_) => None,
        PartKind::Measurement(_)
        | PartKind::Cyclic(_)
        | PartKind::Event(_)
        | PartKind::TaskEnded(_)
        | PartKind::TaskState(_) => None,
    }
}

/// The parts that do not hold, with what is known about each.
pub(crate) fn unmet(monitor: &Monitor, surroundings: &dyn Surroundings) -> Vec<Unmet> {
    let mut asking = Asking::new(surroundings);
    let mut list = Vec::new();
    unmet::collect(&monitor.root, &mut asking, &mut list);
    list
}

/// Errors met while judging since the last call: to be reported as trouble.
pub(crate) fn take_troubles(monitor: &mut Monitor) -> Vec<Trouble> {
    monitor.notes.as_mut().map(|notes| std::mem::take(&mut notes.troubles)).unwrap_or_default()
}
