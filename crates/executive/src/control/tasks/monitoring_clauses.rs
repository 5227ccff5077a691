//! Monitors of clauses (TC)
//! What: makes, feeds, judges and removes the monitors of tasks' clauses, and files them by the stimuli that they must receive.
//! Runs: notice phase, and whenever a task gains or loses a clause.  Reads: Condition, histories, interests.
//! Writes: Watch, Interests, wakes, firings.
//! Bound: touches only the monitors interested in a stimulus; O(log n) to find them.
//! PDL: `waitfor`, `end-when`, `restart-when`, `suspend-when`, `resume-when`.  Paper: section III, condition monitoring.

use crate::control::cycle::{Cycle, Firing};
use crate::control::tasks::{episode_index_tasks, probing};
use crate::expression::view::View;
use crate::expression::{EvalContext, EvaluationError};
use crate::monitoring::basic::task_state;
use crate::monitoring::combination::{interest, monitors};
use crate::monitoring::stimulus::Stimulus;
use crate::state::clause::{Clause, ClauseMonitor, Filing, Level, MonitorId};
use crate::state::controller::Controller;
use crate::state::interests::{Interests, Narrowed};
use crate::state::monitor_set::MonitorIds;
use crate::state::monitors::monitor::{Interest, Monitor, PartKind, Satisfaction, Verdict, Window};
use crate::state::wake::Wake;
use apex_model::because::Evidence;
use apex_model::condition::Condition;
use apex_model::expression::ExprKind;
use apex_model::pattern::Pattern;
use apex_model::symbol::Symbol;
use apex_model::task::TaskId;
use apex_model::value::Value;
use smallvec::SmallVec;

/// Makes the monitor of a clause; it is judged in the next notice phase. Messages and samples count from `window` on. Ends and states of
/// tasks count from now on; with `standing`, those that hold already count too.
///
/// # Errors
/// When an expression of the condition that must be known now cannot be evaluated.
pub(crate) fn watch(
    cycle: &mut Cycle<'_>,
    task: TaskId,
    clause: Clause,
    level: Level,
    condition: &Condition,
    window: Window,
    standing: bool,
) -> Result<MonitorId, EvaluationError> {
    let probings = probing::of_condition(condition, &cycle.view(task, level), task, level)?;
    let (monitor, second) = {
        let view = cycle.view(task, level);
        let create = if standing { monitors::create } else { monitors::create_for_changes };
        let monitor = create(condition, window, &view)?;
        let second = second_word(&monitor, &view);
        (monitor, second)
    };
    let id = MonitorId(cycle.agent.next.monitor);
    cycle.agent.next.monitor += 1;
    let filing = filing(&monitor, second);
    let watch = ClauseMonitor { task, clause, level, monitor, filing, wake: None };
    file(&mut cycle.agent.interests, &watch, id);
    cycle.agent.watches.insert(id.0, watch);
    if let Some(task) = cycle.agent.task_mut(task) {
        task.monitors.push(id);
    }
    cycle.work.touched.push(id);
    probing::begin(cycle, id, probings);
    Ok(id)
}

/// Returns the entry by which the monitor is found again in the table of interests.
fn filing(monitor: &Monitor, second: Option<Value>) -> Option<Box<Filing>> {
    let lasts = second.is_none() && interest::lasting_interest(monitor).is_some();
    (!lasts).then(|| Box::new(Filing { interests: interest::interests(monitor), second }))
}

/// Calls `act` with each interest under which the monitor is filed, and with the narrowing of that interest.
fn for_each_interest(watch: &ClauseMonitor, mut act: impl FnMut(&Interest, Narrowed<'_>)) {
    match &watch.filing {
        Some(filing) => {
            let narrowed = Narrowed { second: filing.second.as_ref(), threshold: None };
            filing.interests.iter().for_each(|interest| act(interest, narrowed));
        }
        None => {
            let narrowed = Narrowed { second: None, threshold: interest::threshold(&watch.monitor) };
            interest::lasting_interest(&watch.monitor).iter().for_each(|interest| act(interest, narrowed));
        }
    }
}

/// Files the monitor under all its interests.
pub(crate) fn file(interests: &mut Interests, watch: &ClauseMonitor, id: MonitorId) {
    for_each_interest(watch, |interest, narrowed| interests.insert(interest, narrowed, id));
}

fn take_out(interests: &mut Interests, watch: &ClauseMonitor, id: MonitorId) {
    for_each_interest(watch, |interest, narrowed| interests.remove(interest, narrowed, id));
}

/// Returns true if the variable of the clause can get another value.
fn may_change(view: &View<'_>, name: &Symbol) -> bool {
    let Some(task) = view.agent.task(view.task) else { return false };
    let procedure = match view.level {
        Level::Step => task.step().map(|step| step.procedure),
        Level::Procedure => task.controller.as_deref().and_then(|controller| match controller {
            Controller::Procedure(state) => Some(state.procedure),
            _ => None,
        }),
    };
    let index = procedure.and_then(|procedure| view.agent.procedure_index(procedure));
    index.is_some_and(|index| index.changing.contains(name))
}

/// Returns the second word of the only message that the monitor waits for; `None` unless that word cannot change: a literal, or a
/// variable that is bound already and keeps its value.
fn second_word(monitor: &Monitor, view: &View<'_>) -> Option<Value> {
    let PartKind::Event(event) = &monitor.root.kind else { return None };
    match event.pattern.as_ref() {
        Pattern::Literal(form) => form.as_list()?.get(1).cloned(),
        Pattern::List(parts) => match (parts.first()?, parts.get(1)?) {
            (Pattern::Segment { .. }, _) => None,
            (_, Pattern::Literal(value)) => Some(value.clone()),
            (_, Pattern::Variable(name) | Pattern::BoundVariable(name)) => {
                view.variable(name).filter(|_| !may_change(view, name))
            }
            (_, Pattern::Computed(expr)) => match &expr.kind {
                ExprKind::Indexical(name) if name.is("self") => Some(Value::Symbol(view.agent_name().clone())),
                _ => None,
            },
            _ => None,
        },
        _ => None,
    }
}

/// Removes all monitors of `task` that `unwanted` names.
pub(crate) fn unwatch(cycle: &mut Cycle<'_>, task: TaskId, unwanted: impl Fn(Clause, Level) -> bool) {
    let Some(list) = cycle.agent.task_mut(task).map(|task| std::mem::take(&mut task.monitors)) else { return };
    if list.is_empty() {
        return;
    }
    let mut kept = SmallVec::new();
    for id in list {
        match cycle.agent.watches.get(id.0) {
            Some(watch) if !unwanted(watch.clause, watch.level) => kept.push(id),
            Some(_) => remove(cycle, id),
            None => {}
        }
    }
    if let Some(task) = cycle.agent.task_mut(task) {
        task.monitors = kept;
    }
}

fn remove(cycle: &mut Cycle<'_>, id: MonitorId) {
    let Some(mut watch) = cycle.agent.watches.remove(id.0) else { return };
    episode_index_tasks::take_out(cycle, id, &mut watch);
    take_out(&mut cycle.agent.interests, &watch, id);
    if let Some(wake) = watch.wake {
        cycle.agent.wakes.cancel(wake);
    }
    probing::not_awaited(cycle, id);
}

/// Executes the notice phase: passes everything recorded to monitors, then judges all monitors that were affected.
pub(crate) fn notice(cycle: &mut Cycle<'_>) {
    // Results that were found when tasks were made at the end of the last round are judged again: a sample may have been replaced since.
    cycle.work.firings.clear();
    let stimuli = std::mem::take(&mut cycle.work.stimuli);
    let mut found = MonitorIds::new();
    for stimulus in &stimuli {
        found.clear();
        match stimulus {
            Stimulus::Sample { variable, value, newest, .. } => {
                cycle.agent.interests.of_sample(variable, value, *newest, &mut found);
                cycle.work.priorities_changed |= !cycle.agent.unsteady.is_empty();
            }
            Stimulus::Event { form, .. } => cycle.agent.interests.of_event(form, &mut found),
            Stimulus::TaskEnded { task, before, .. } | Stimulus::TaskState { task, before, .. } => {
                cycle.agent.interests.of_task(*task, &mut found);
                found.retain(|id| *id < *before);
            }
        }
        episode_index_tasks::notice(cycle, stimulus, &mut found);
        found.sort_unstable();
        found.dedup();
        for id in &found {
            tell(cycle, *id, stimulus);
        }
    }
    cycle.agent.interests.of_every_step(&mut cycle.work.touched);
    let mut touched = std::mem::take(&mut cycle.work.touched);
    touched.sort_unstable();
    touched.dedup();
    for id in touched {
        judge(cycle, id);
    }
}

/// Returns true if the sample affects no monitor, so that the notice phase can be skipped.
pub(crate) fn is_unheard(cycle: &Cycle<'_>, stimulus: &Stimulus) -> bool {
    let Stimulus::Sample { variable, value, newest, .. } = stimulus else { return false };
    let interests = &cycle.agent.interests;
    let mut found = MonitorIds::new();
    interests.of_sample(variable, value, *newest, &mut found);
    let banked = interests.episodes(variable).is_some();
    found.is_empty() && !banked && interests.ignore_steps() && cycle.agent.unsteady.is_empty()
}

fn tell(cycle: &mut Cycle<'_>, id: MonitorId, stimulus: &Stimulus) {
    let Some(mut watch) = cycle.agent.watches.lift(id.0) else { return };
    let view = View { agent: cycle.agent, task: watch.task, level: watch.level, now: cycle.now };
    monitors::notice(&mut watch.monitor, stimulus, &view);
    cycle.agent.watches.put(id.0, watch);
    cycle.work.touched.push(id);
}

/// Files the monitor again after a verdict that determined or changed the task to which it refers.
fn refile(interests: &mut Interests, watch: &mut ClauseMonitor, id: MonitorId) {
    let Some(filing) = &watch.filing else { return };
    if let Some(sole) = task_state::sole_interest(&watch.monitor) {
        if filing.interests.as_slice() == [sole] {
            return;
        }
    } else if interest::lasting_interest(&watch.monitor).is_some() {
        return;
    }
    let wanted = interest::interests(&watch.monitor);
    if wanted != filing.interests {
        take_out(interests, watch, id);
        watch.filing = Some(Box::new(Filing { interests: wanted, second: None }));
        file(interests, watch, id);
    }
}

/// Evaluates the monitors of a tag again that names another task than `before` now.
pub(crate) fn tag_moved(cycle: &mut Cycle<'_>, before: TaskId) {
    let mut found = MonitorIds::new();
    cycle.agent.interests.of_task(before, &mut found);
    for id in found {
        let Some(mut watch) = cycle.agent.watches.lift(id.0) else { continue };
        let view = View { agent: cycle.agent, task: watch.task, level: watch.level, now: cycle.now };
        monitors::look_for_tasks(&mut watch.monitor, &view);
        refile(&mut cycle.agent.interests, &mut watch, id);
        cycle.agent.watches.put(id.0, watch);
        cycle.work.touched.push(id);
    }
}

/// Judges the monitor; a satisfied one is added to the firings.
pub(crate) fn judge(cycle: &mut Cycle<'_>, id: MonitorId) {
    let Some(mut watch) = cycle.agent.watches.lift(id.0) else { return };
    episode_index_tasks::take_out(cycle, id, &mut watch);
    let view = View { agent: cycle.agent, task: watch.task, level: watch.level, now: cycle.now };
    let verdict = monitors::verdict(&mut watch.monitor, &view);
    refile(&mut cycle.agent.interests, &mut watch, id);
    let troubles = monitors::take_troubles(&mut watch.monitor);
    let wake_at = match &verdict {
        Verdict::Satisfied(_) => None,
        _ if episode_index_tasks::put_in(cycle, id, &mut watch) => None,
        Verdict::NotSatisfied | Verdict::Unknown => monitors::next_wake(&watch.monitor).map(|(at, _)| at),
    };
    if watch.wake.map(|wake| wake.at) != wake_at {
        if let Some(wake) = watch.wake.take() {
            cycle.agent.wakes.cancel(wake);
        }
        watch.wake = wake_at.map(|at| cycle.agent.wakes.schedule(at, Wake::Monitor(id)));
    }
    let (task, clause, level, place) = (watch.task, watch.clause, watch.level, watch.monitor.root.place);
    probing::judged(cycle, id, &watch, matches!(verdict, Verdict::Satisfied(_)));
    cycle.agent.watches.put(id.0, watch);
    for trouble in troubles {
        cycle.trouble(Some(task), trouble.message, Some(trouble.place));
    }
    if let Verdict::Satisfied(satisfaction) = verdict {
        let answered = answered(cycle, &satisfaction);
        cycle.work.firings.push(Firing { task, clause, level, monitor: id, satisfaction, answered, place });
    }
}

/// Returns true if a noticed verdict still holds: earlier effects of this phase may have changed it.
pub(crate) fn still_holds(cycle: &Cycle<'_>, firing: &Firing) -> bool {
    let absence = |evidence: &Evidence| matches!(evidence, Evidence::Absence { .. });
    if cycle.work.stimuli.is_empty() || !firing.satisfaction.evidence.iter().any(absence) {
        return true;
    }
    let Some(watch) = cycle.agent.watches.get(firing.monitor.0) else { return false };
    let view = View { agent: cycle.agent, task: watch.task, level: watch.level, now: cycle.now };
    let mut monitor = watch.monitor.clone();
    for stimulus in &cycle.work.stimuli {
        monitors::notice(&mut monitor, stimulus, &view);
    }
    matches!(monitors::verdict(&mut monitor, &view), Verdict::Satisfied(_))
}

/// Judges a monitor whose wake is due.
pub(crate) fn woken(cycle: &mut Cycle<'_>, id: MonitorId) {
    let own = cycle.agent.watches.get_mut(id.0).and_then(|watch| watch.wake.take());
    if own.is_some() {
        cycle.work.touched.push(id);
    } else {
        episode_index_tasks::woken(cycle, id);
    }
}

/// Returns the newest arrival among the evidence: the next instance of a repeated task must not count it again.
fn answered(cycle: &Cycle<'_>, satisfaction: &Satisfaction) -> Option<u64> {
    let newest = cycle.agent.next.arrival.checked_sub(1);
    let arrival = |evidence: &Evidence| match evidence {
        Evidence::Event { sequence, .. } => Some(*sequence),
        Evidence::Sample { variable, at, .. } | Evidence::Run { variable, end: at, .. } if *at == cycle.now => {
            let sample = cycle.agent.histories.get(variable).and_then(|history| history.at(*at));
            sample.filter(|sample| sample.at == *at).map(|sample| sample.sequence).or(newest)
        }
        Evidence::Sample { .. }
        | Evidence::Run { .. }
        | Evidence::TaskState { .. }
        | Evidence::TaskEnd { .. }
        | Evidence::Instant { .. }
        | Evidence::Function { .. }
        | Evidence::Absence { .. }
        | Evidence::Estimate(_)
        | Evidence::Aggregate(_) => None,
    };
    satisfaction.evidence.iter().filter_map(arrival).max()
}
