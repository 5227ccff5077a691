//! Explanation of resources (their holders) and of commands (their causes).

use super::answer::{CommandAnswer, Holder, ResourceAnswer};
use super::chain::Chain;
use super::link::Link;
use super::log::Log;
use super::snapshot::RecordSnapshot;
use super::why;
use crate::error::RecordError;
use crate::record::view::decisions::DecisionRow as Row;
use apex_executive::Agent;
use apex_executive::explanation::describe_task;
use apex_executive::state::resource::Resource;
use apex_model::quantity::Dimension;
use apex_model::task::TaskId;
use apex_model::value::Value;

/// Returns the resource called `name`; `None` if the agent does not know it.
pub(super) fn resource<'a>(agent: &'a Agent, name: &str) -> Option<&'a Resource> {
    let same = |resource: &&Resource| resource.name.to_string().eq_ignore_ascii_case(name.trim());
    agent.resources.iter().map(|(_, resource)| resource).find(same)
}

/// The explanation of a resource.
pub(super) struct ExplainedResource {
    pub(super) answer: ResourceAnswer,
    /// The first task that waits for it; if there is none, the first that holds it.
    pub(super) first: Option<TaskId>,
}

/// Explains the holders of the resource called `name`; `None` if there is no such resource.
pub(super) fn of_resource(
    snapshot: &RecordSnapshot<'_>,
    name: &str,
    question: &'static str,
) -> Result<Option<ExplainedResource>, RecordError> {
    let Some((agent, found)) = snapshot.agent().and_then(|agent| Some((agent, resource(agent, name)?))) else {
        return Ok(None);
    };
    let log = snapshot.log()?;
    let amount = |number: f64| Value::measured(number, found.dimension).to_string();
    let whole = |number: f64| if found.dimension == Dimension::NONE { number.to_string() } else { amount(number) };
    let mut holders = Vec::new();
    for holding in &found.holders {
        let got = log.decisions.transition_before(holding.task, "ongoing", i64::MAX)?;
        let link = link(snapshot, &log, got)?;
        holders.push(holder(snapshot, agent, holding.task, Some(whole(holding.amount)), link));
    }
    let mut waiting = Vec::new();
    for task in found.waiting.tasks() {
        let conflict = log.decisions.before(task, "refused", i64::MAX)?;
        let lost = log.decisions.transition_before(task, "interrupted", i64::MAX)?;
        let last = [conflict, lost].into_iter().flatten().max_by_key(|row| row.id);
        let link = link(snapshot, &log, last)?;
        let mut waiter = holder(snapshot, agent, task, None, link);
        waiter.waits_for = why::waiting(agent, task);
        waiting.push(waiter);
    }
    let about = snapshot.about(question, "resource", name);
    let answer =
        ResourceAnswer { about, resource: found.name.to_string(), total: whole(found.total), holders, waiting };
    let first = found.waiting.tasks().next().or_else(|| found.holders.first().map(|holding| holding.task));
    Ok(Some(ExplainedResource { answer, first }))
}

fn link(snapshot: &RecordSnapshot<'_>, log: &Log<'_>, row: Option<Row>) -> Result<Option<Link>, RecordError> {
    let goals = |task| snapshot.goal(task);
    row.map(|row| Chain::new(log, &goals).link(&row, snapshot.depth)).transpose()
}

fn holder(
    snapshot: &RecordSnapshot<'_>,
    agent: &Agent,
    task: TaskId,
    amount: Option<String>,
    because: Option<Link>,
) -> Holder {
    let view = describe_task(agent, task);
    Holder {
        task: task.to_string(),
        goal: snapshot.goal(task),
        amount,
        priority: view.as_ref().map_or(0.0, |view| view.priority),
        interrupt_cost: view.and_then(|view| view.interrupt_cost).unwrap_or_default(),
        because,
        waits_for: Vec::new(),
    }
}

/// Explains the command `asked`: `command 7`, or words of its form, which refer to the last such command.
pub(super) fn of_command(snapshot: &RecordSnapshot<'_>, asked: &str) -> Result<Option<CommandAnswer>, RecordError> {
    let log = snapshot.log()?;
    let words = asked.trim();
    let number = words.strip_prefix("command ").and_then(|number| number.trim().parse().ok());
    let found = match number {
        Some(number) => log.decisions.command(number)?,
        None if words.len() < 3 => None,
        None => log.decisions.command_like(words)?,
    };
    let form = found.as_ref().map(|row| row.subject.clone()).unwrap_or_default();
    let because = link(snapshot, &log, found)?;
    Ok(because.map(|because| CommandAnswer { about: snapshot.about("why", "command", asked), form, because }))
}
