//! Explanation of a task: its history, the chain behind its state, its open requirements, the holder of its resource.

use super::answer::{Blocked, Choice, Subtask, Unmet, Why};
use super::chain::Chain;
use super::history::{Conflict, History};
use super::snapshot::{RecordSnapshot, place_text};
use crate::error::RecordError;
use crate::method_detail::MethodDetail;
use crate::record::TaskRow;
use apex_executive::Agent;
use apex_executive::explanation::{self, Reason};
use apex_model::effect::{Decision, DecisionKind, Effect, Method};
use apex_model::task::{TaskId, TaskState};
use apex_model::time::Time;
use apex_model::value::Value;

/// Explains task `id`.
///
/// # Errors
/// If the flight has no such task, or the record cannot be read.
pub(super) fn of_task(
    snapshot: RecordSnapshot<'_>,
    id: TaskId,
    question: &'static str,
    asked: &str,
) -> Result<Why, RecordError> {
    let log = snapshot.log()?;
    let Some(row) = snapshot.row(id).cloned() else {
        return Err(RecordError::Question(format!("There is no task {id} in this flight.")));
    };
    let goals = |task| snapshot.goal(task);
    let last = log.decisions.last_move(id)?;
    let chained = last.as_ref().filter(|_| snapshot.restores());
    let because = chained.map(|row| Chain::new(&log, &goals).link(row, snapshot.depth)).transpose()?;
    let history = History::read(snapshot.decisions(), id)?;
    let subtasks = subtasks(&snapshot, id)?;
    let blocked = history.blocked.as_ref().map(|conflict| blocked(&snapshot, conflict));
    let goal = match history.waits() {
        true => snapshot.whole_goal(id),
        false => history.goal.clone().unwrap_or_else(|| row.goal.clone()),
    };
    let about = snapshot.about(question, "task", asked);
    let waits = history.waits();
    let chosen = log.decisions.before(id, "selected", i64::MAX)?.and_then(|row| match row.effect {
        Some(Effect::Decided(Decision { kind: DecisionKind::Selected { method, goal, .. }, .. })) => {
            Some((method, goal))
        }
        _ => None,
    });
    let agent = match (snapshot.into_agent(), waits) {
        (Ok(agent), _) => agent,
        // An ended task is explained from the record alone.
        (Err(_), false) => None,
        (Err(error), true) => return Err(error),
    };
    let view = agent.as_deref().and_then(|agent| explanation::describe_task(agent, id)).filter(|_| waits);
    Ok(Why {
        about,
        task: id.to_string(),
        tag: row.tag.clone(),
        goal,
        state: history.state,
        since: last.as_ref().map_or(row.created, |row| row.at).seconds(),
        outcome: row.outcome.clone().filter(|_| !waits),
        priority: view.as_ref().map(|view| view.priority),
        holds: view.iter().flat_map(|view| &view.resources).map(Value::to_string).collect(),
        method: history.method,
        place: row.place,
        because,
        choices: choices(agent.as_deref(), chosen),
        history: history.moments,
        waiting: agent.filter(|_| waits).map(|agent| waiting(&agent, id)).unwrap_or_default(),
        blocked,
        subtasks,
    })
}

fn blocked(snapshot: &RecordSnapshot<'_>, conflict: &Conflict) -> Blocked {
    Blocked {
        by: conflict.by.to_string(),
        goal: snapshot.goal(conflict.by),
        resource: conflict.resource.clone(),
        since: conflict.since.seconds(),
        winner_priority: conflict.winner.total(),
        loser_priority: conflict.loser.total(),
        winner_cost: conflict.winner.interrupt_cost,
        loser_cost: conflict.loser.interrupt_cost,
        strengths: format!("{} against {}", conflict.winner, conflict.loser),
    }
}

/// Returns the methods for the goal, best first; a built-in activity has no choice.
fn choices(agent: Option<&Agent>, chosen: Option<(Method, Value)>) -> Vec<Choice> {
    let (Some(agent), Some((method, goal))) = (agent, chosen) else { return Vec::new() };
    if method == Method::BuiltIn {
        return Vec::new();
    }
    let choice = |option: explanation::MethodOption| {
        let method = MethodDetail::of(&option.method, |place| place_text(agent, place));
        Choice {
            method: method.to_string(),
            place: method.place,
            index: option.index,
            matches: option.matches,
            because: option.because,
        }
    };
    explanation::options(agent, &goal).into_iter().map(choice).collect()
}

/// Returns the requirements for which the task waits, by the agent.
pub(super) fn waiting(agent: &Agent, task: TaskId) -> Vec<Unmet> {
    explanation::waiting(agent, task).into_iter().map(|reason| unmet(agent, reason)).collect()
}

fn unmet(agent: &Agent, reason: Reason) -> Unmet {
    Unmet {
        kind: reason.kind,
        what: reason.text,
        now: reason.now.unwrap_or_default(),
        unobserved: reason.unobserved,
        since: reason.since.map(Time::seconds),
        until: reason.until.map(Time::seconds),
        distance: reason.distance.map(|distance| distance.to_string()),
        task: reason.task.map(|task| task.to_string()),
        task_number: reason.task.map(|task| task.0),
        place: reason.place.map(|place| place_text(agent, place)),
    }
}

fn subtasks(snapshot: &RecordSnapshot<'_>, parent: TaskId) -> Result<Vec<Subtask>, RecordError> {
    let mut subtasks = Vec::new();
    let lives = |task: &&TaskRow| task.parent == Some(parent) && task.created <= snapshot.at;
    for task in snapshot.tasks.iter().filter(lives) {
        // A task that ended long ago and was not repeated needs no search of its decisions.
        if task.ended.is_some_and(|ended| ended <= snapshot.at) {
            continue;
        }
        let state = snapshot.decisions().state(task.id)?.unwrap_or_else(|| TaskState::Pending.word().into());
        if state != TaskState::Terminated.word() {
            subtasks.push(Subtask { task: task.id.to_string(), goal: snapshot.whole_goal(task.id), state });
        }
    }
    Ok(subtasks)
}
