//! Threshold episodes of tasks (TC)
//! What: lets episode indexes watch the undecided threshold episodes of task clauses, and marks a monitor for judgement when its episode is
//! decided.
//! Runs: notice phase; when a monitor is judged, removed or explained.  Reads: Watch.
//! Writes: Interests, Watch, wakes.
//! Bound: O(threshold episodes of the variable) per sample, one comparison each.
//! PDL: `:episode`.  Paper: section III, condition monitoring.

use crate::control::cycle::Cycle;
use crate::control::tasks::monitoring_clauses;
use crate::expression::view::View;
use crate::monitoring::episodes::threshold_episode;
use crate::monitoring::stimulus::Stimulus;
use crate::state::agent::Agent;
use crate::state::clause::{ClauseMonitor, MonitorId};
use crate::state::episode_index::{LeafId, Taken};
use crate::state::monitor_set::MonitorIds;
use crate::state::monitors::monitor::Monitor;
use crate::state::wake::Wake;
use apex_model::event::StateVariable;
use std::borrow::Cow;

/// Passes the stimulus to the episode index of its variable. Monitors that must receive it individually are added to `found`.
pub(crate) fn notice(cycle: &mut Cycle<'_>, stimulus: &Stimulus, found: &mut MonitorIds) {
    let Stimulus::Sample { variable, value, at, newest, .. } = stimulus else { return };
    let Some(bank) = cycle.agent.interests.episodes_mut(variable) else { return };
    let mut taken = Taken::new();
    match bank.takes(*at, value).filter(|_| *newest) {
        Some(number) => {
            let mut told = Vec::new();
            bank.sample(*at, number, &mut told);
            bank.take_decided(&told, &mut taken);
        }
        None => {
            bank.take_all(&mut taken);
            found.extend(taken.iter().map(|(leaf, _)| leaf.monitor));
        }
    }
    stand_up(cycle, taken);
    refresh(cycle, variable);
}

/// Handles the wake of the episode index that holds an episode of `id`: one of its episodes is due.
pub(crate) fn woken(cycle: &mut Cycle<'_>, id: MonitorId) {
    let watch = cycle.agent.watches.get(id.0);
    let Some(variable) = watch.and_then(|watch| threshold_episode::variable(&watch.monitor)).cloned() else { return };
    let Some(bank) = cycle.agent.interests.episodes_mut(&variable) else { return };
    bank.wake.take_if(|(wake, _)| wake.at <= cycle.now);
    let mut taken = Taken::new();
    let mut told = Vec::new();
    bank.pass_time(cycle.now, &mut told);
    bank.take_decided(&told, &mut taken);
    stand_up(cycle, taken);
    refresh(cycle, &variable);
}

/// Removes the monitor from its episode index, if it is in one.
pub(crate) fn take_out(cycle: &mut Cycle<'_>, id: MonitorId, watch: &mut ClauseMonitor) {
    let Some(variable) = threshold_episode::variable(&watch.monitor).cloned() else { return };
    let Some(run) = cycle.agent.interests.episodes_mut(&variable).and_then(|bank| bank.take(LeafId::whole(id))) else {
        return;
    };
    threshold_episode::stand_up(&mut watch.monitor, run);
    monitoring_clauses::file(&mut cycle.agent.interests, watch, id);
    refresh(cycle, &variable);
}

/// Moves the undecided monitor into an episode index. Returns false if no episode index can watch it.
pub(crate) fn put_in(cycle: &mut Cycle<'_>, id: MonitorId, watch: &mut ClauseMonitor) -> bool {
    let Some(variable) = threshold_episode::variable(&watch.monitor).cloned() else { return false };
    let view = View { agent: cycle.agent, task: watch.task, level: watch.level, now: cycle.now };
    let Some((wanted, run)) = threshold_episode::bankable(&watch.monitor, &view) else { return false };
    if !cycle.agent.interests.bank(&variable, LeafId::whole(id), &wanted, run) {
        return false;
    }
    threshold_episode::lie_down(&mut watch.monitor);
    refresh(cycle, &variable);
    true
}

fn stand_up(cycle: &mut Cycle<'_>, taken: Taken) {
    let agent = &mut *cycle.agent;
    for (LeafId { monitor: id, .. }, seen) in taken {
        if let Some(watch) = agent.watches.get_mut(id.0) {
            threshold_episode::stand_up(&mut watch.monitor, seen);
            monitoring_clauses::file(&mut agent.interests, watch, id);
            cycle.work.touched.push(id);
        }
    }
}

/// Schedules the next wake of the episode index, cancels an earlier one, and drops the episode index if it is empty.
fn refresh(cycle: &mut Cycle<'_>, variable: &StateVariable) {
    let agent = &mut *cycle.agent;
    let Some(bank) = agent.interests.episodes_mut(variable) else { return };
    let due = bank.due();
    if bank.wake.map(|(wake, leaf)| (wake.at, leaf)) != due {
        if let Some((wake, _)) = bank.wake.take() {
            agent.wakes.cancel(wake);
        }
        bank.wake = due.map(|(at, leaf)| (agent.wakes.schedule(at, Wake::Monitor(leaf.monitor)), leaf));
    }
    if bank.is_empty() {
        agent.interests.drop_empty_bank(variable);
    }
}

/// Returns the monitor in the state that it would have without an episode index.
pub(crate) fn as_told<'a>(agent: &Agent, id: MonitorId, watch: &'a ClauseMonitor) -> Cow<'a, Monitor> {
    let variable = threshold_episode::variable(&watch.monitor);
    let run = variable.and_then(|variable| agent.interests.episodes(variable)?.run_of(LeafId::whole(id)));
    match run {
        Some(run) => {
            let mut monitor = watch.monitor.clone();
            threshold_episode::stand_up(&mut monitor, run);
            Cow::Owned(monitor)
        }
        None => Cow::Borrowed(&watch.monitor),
    }
}
