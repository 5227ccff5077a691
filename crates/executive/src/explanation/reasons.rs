//! Reasons for which a task waits.

use crate::control::conflicts::competition::in_order;
use crate::control::conflicts::deadlock;
use crate::control::conflicts::priority::{defence, priority};
use crate::control::tasks::episode_index_tasks;
use crate::expression::instantiate_partially;
use crate::expression::view::View;
use crate::monitoring::combination::monitors;
use crate::state::agent::Agent;
use crate::state::clause::{Clause, Level};
use crate::state::controller::{Controller, PrimitiveController};
use crate::state::probing::Probing;
use crate::state::resource::Need;
use crate::state::task::Task;
use apex_model::because::Strength;
use apex_model::probing::{ordinal, stopped_text};
use apex_model::source::Place;
use apex_model::task::{TaskId, TaskState};
use apex_model::time::Time;
use apex_model::value::Value;
use serde::Serialize;
use std::collections::BTreeSet;

/// Kinds of reasons.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ReasonKind {
    /// A part of a condition does not hold.
    Condition,
    /// The step before it has not ended.
    Predecessor,
    /// The result of another step is not there.
    Result,
    /// A least interval or a duration is not over.
    Time,
    /// Other tasks hold or claim a resource that it needs.
    Resource,
    /// The task or an ancestor is suspended, or the parent is not ongoing.
    Suspended,
    /// A command has no answer.
    Command,
    /// A plan has not arrived.
    Plan,
    /// The operator has not answered.
    Operator,
    /// The task and other tasks wait for each other's resources.
    Circle,
    /// Subtasks have not ended.
    Subtasks,
    /// The task has ended.
    Ended,
}

/// One reason for which a task waits.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Reason {
    /// Kind.
    pub kind: ReasonKind,
    /// Requirement, human-readable.
    pub text: String,
    /// Present state of the requirement.
    pub now: Option<String>,
    /// True for a part of a condition about which no sample or message has arrived.
    pub unobserved: bool,
    /// Since when that is so.
    pub since: Option<Time>,
    /// Instant at which the wait for it ends by time alone, if nothing changes before.
    pub until: Option<Time>,
    /// Distance of the newest sample from the threshold.
    pub distance: Option<Value>,
    /// The other task concerned; `None` if the reason concerns no other task.
    pub task: Option<TaskId>,
    /// Position in the PDL text.
    pub place: Option<Place>,
}

impl Reason {
    fn new(kind: ReasonKind, text: String) -> Reason {
        Reason {
            kind,
            text,
            now: None,
            unobserved: false,
            since: None,
            until: None,
            distance: None,
            task: None,
            place: None,
        }
    }
}

/// Returns the reasons for which `task` waits now. Empty for a task that nothing can refer to any longer.
pub fn waiting(agent: &Agent, task: TaskId) -> Vec<Reason> {
    let Some(task) = agent.task(task) else { return Vec::new() };
    let mut reasons = match task.state {
        TaskState::Pending => preconditions(agent, task),
        TaskState::Enabled | TaskState::Interrupted => resources(agent, task),
        TaskState::Ongoing => controller(agent, task),
        TaskState::Terminated => vec![ended(task)],
    };
    if !task.is_terminated() {
        let before = suspensions(agent, task);
        reasons.splice(0..0, before);
        reasons.extend(circle(agent, task));
    }
    reasons
}

/// Returns the circle of tasks that wait for each other's resources, if the task is part of one.
fn circle(agent: &Agent, task: &Task) -> Option<Reason> {
    let links = deadlock::circle_at(agent, task.id)?;
    let text = "the end of one of the tasks that wait for each other's resources in a circle".to_string();
    let now = Some(deadlock::circle_text(agent, &links));
    Some(Reason { now, place: place(agent, task), ..Reason::new(ReasonKind::Circle, text) })
}

fn name(agent: &Agent, id: TaskId) -> String {
    match agent.task(id) {
        Some(task) => format!("{id} ({})", agent.tag(task)),
        None => id.to_string(),
    }
}

fn place(agent: &Agent, task: &Task) -> Option<Place> {
    let step = task.step()?;
    agent.procedure(step.procedure)?.steps.get(step.step as usize).map(|step| step.place)
}

fn preconditions(agent: &Agent, task: &Task) -> Vec<Reason> {
    let mut reasons = Vec::new();
    if task.held_back.by_predecessor {
        reasons.extend(predecessor(agent, task));
    }
    if task.held_back.by_result {
        reasons.extend(result(agent, task));
    }
    if task.held_back.by_interval {
        let wake = task.extras.as_ref().and_then(|extras| extras.wake);
        let text = match wake {
            Some(wake) => format!("the end of its minimum interval at {}", wake.at),
            None => "the end of its minimum interval".to_string(),
        };
        let until = wake.map(|wake| wake.at);
        reasons.push(Reason { until, place: place(agent, task), ..Reason::new(ReasonKind::Time, text) });
    }
    reasons.extend(unmet(agent, task, |clause| clause == Clause::Waitfor));
    reasons
}

/// Returns the parts of the task's watched clauses that do not hold.
fn unmet(agent: &Agent, task: &Task, wanted: impl Fn(Clause) -> bool) -> Vec<Reason> {
    let mut reasons = Vec::new();
    for id in &task.monitors {
        let Some(watch) = agent.watches.get(id.0).filter(|watch| wanted(watch.clause)) else { continue };
        let view = View { agent, task: task.id, level: watch.level, now: agent.now };
        for part in monitors::unmet(&episode_index_tasks::as_told(agent, *id, watch), &view) {
            let text = format!("{} {}", watch.clause.word(), part.what);
            reasons.push(Reason {
                now: Some(part.now),
                unobserved: part.unobserved,
                since: part.since,
                until: part.until,
                distance: part.distance,
                place: Some(part.place),
                ..Reason::new(ReasonKind::Condition, text)
            });
        }
        reasons.extend(agent.probings_of(*id).map(|(_, probing)| probed(agent, probing)));
    }
    reasons
}

/// Describes the pursuit of a condition with `:probing`, or its end.
fn probed(agent: &Agent, probing: &Probing) -> Reason {
    let view = View { agent, task: probing.waiting, level: probing.level, now: agent.now };
    let goal = instantiate_partially(&probing.goal, &view);
    let text = format!("probing for it with {goal} every {}", probing.interval);
    let next = probing.next_at(agent.now);
    let now = match (probing.end, probing.running) {
        (Some(reason), _) => stopped_text(probing.begun, reason),
        (None, Some(id)) => format!("{} is {}", ordinal(probing.begun, probing.count_limit), name(agent, id)),
        (None, None) => format!("{} begins at {next}", ordinal(probing.begun + 1, probing.count_limit)),
    };
    Reason {
        now: Some(now),
        since: probing.last_at,
        until: Some(next).filter(|at| probing.end.is_none() && probing.running.is_none() && *at > agent.now),
        task: probing.running,
        place: Some(probing.place),
        ..Reason::new(ReasonKind::Condition, text)
    }
}

fn predecessor(agent: &Agent, task: &Task) -> Option<Reason> {
    let step = task.step()?;
    let parent = agent.task(task.parent?)?;
    let Some(Controller::Procedure(controller)) = parent.controller.as_deref() else { return None };
    let tasks = controller.current.get(..step.step as usize)?.iter().rev().filter_map(|id| agent.task((*id)?));
    // Steps before it may have ended before their turn.
    let (passed, found) = tasks.enumerate().find(|(_, task)| !task.is_terminated())?;
    let before = found.id;
    let which = if passed == 0 { "the step before it" } else { "a step before it" };
    let text = format!("the end of {which}, {}", name(agent, before));
    Some(Reason {
        now: Some(format!("it is {}", found.state)),
        since: Some(found.since),
        task: Some(before),
        place: place(agent, found),
        ..Reason::new(ReasonKind::Predecessor, text)
    })
}

fn result(agent: &Agent, task: &Task) -> Vec<Reason> {
    use crate::expression::EvalContext;
    let Some(step) = task.step() else { return Vec::new() };
    let Some(index) = agent.procedure_index(step.procedure) else { return Vec::new() };
    let view = View { agent, task: task.id, level: Level::Step, now: agent.now };
    let awaits = index.steps.get(step.step as usize).map(|step| step.awaits.as_slice()).unwrap_or_default();
    let missing = awaits.iter().filter(|name| view.variable(name).is_none());
    missing
        .map(|name| Reason {
            now: Some("it has no value".to_string()),
            since: Some(task.created_at),
            place: place(agent, task),
            ..Reason::new(ReasonKind::Result, format!("the value of ?{name}, which another step yields"))
        })
        .collect()
}

fn suspensions(agent: &Agent, task: &Task) -> Vec<Reason> {
    let mut reasons = Vec::new();
    let mut next = Some(task.id);
    while let Some(each) = next.and_then(|id| agent.task(id)) {
        if each.suspended {
            let text = format!("{} is suspended", name(agent, each.id));
            let task = Some(each.id);
            // A task that was suspended before it began has been in its state for longer than it has been suspended.
            let since = Some(each.since).filter(|_| each.state == TaskState::Interrupted);
            reasons.push(Reason { since, task, ..Reason::new(ReasonKind::Suspended, text) });
            reasons.extend(unmet(agent, each, |clause| matches!(clause, Clause::SuspendUntil | Clause::ResumeWhen)));
        }
        next = each.parent;
    }
    let parent = task.parent.and_then(|parent| agent.task(parent));
    if let Some(parent) = parent.filter(|parent| task.state == TaskState::Enabled && parent.state != TaskState::Ongoing)
    {
        reasons.push(Reason {
            now: Some(format!("it is {}", parent.state)),
            since: Some(parent.since),
            task: Some(parent.id),
            ..Reason::new(ReasonKind::Suspended, format!("its parent {} is not ongoing", name(agent, parent.id)))
        });
    }
    reasons
}

fn resources(agent: &Agent, task: &Task) -> Vec<Reason> {
    let profile = task.selection.iter().flat_map(|selection| &selection.needs);
    let held = task.extras.iter().flat_map(|extras| &extras.held);
    profile
        .chain(held)
        .flat_map(|need| lacking(agent, task, need).into_iter().chain(rivals(agent, task, need)))
        .collect()
}

/// Returns the reason if less of a resource remains than the task needs, until the resource is replenished.
fn lacking(agent: &Agent, task: &Task, need: &Need) -> Option<Reason> {
    let resource = agent.resources.get(need.resource).filter(|resource| resource.renewable.is_some())?;
    let amount = |number: f64| Value::measured(number, resource.dimension);
    let now = format!("{} is left, and it needs {}", amount(resource.total), amount(need.amount));
    let text = format!("more {}", resource.name);
    let reason = Reason { now: Some(now), place: place(agent, task), ..Reason::new(ReasonKind::Resource, text) };
    (need.amount > resource.total).then_some(reason)
}

/// Returns all tasks that keep the task from this resource: its holders, or the claimant that won it.
fn rivals(agent: &Agent, task: &Task, need: &Need) -> Vec<Reason> {
    let Some(resource) = agent.resources.get(need.resource) else { return Vec::new() };
    let (claimants, precedence) = in_order(agent, agent.now, &BTreeSet::from([need.resource]), &BTreeSet::new());
    let lifted = |id: TaskId, own: f64| precedence.as_ref().map_or(own, |precedence| precedence.lifted(id, own));
    let instead = |id: TaskId| {
        let whom = precedence.as_ref().and_then(|precedence| precedence.instead_of_own(id));
        whom.map_or_else(String::new, |whom| format!(" of {}, which it precedes by rank", name(agent, whom)))
    };
    let own = format!("{}{}", lifted(task.id, priority(agent, task.id, agent.now)), instead(task.id));
    let refused = task.extras.as_ref().and_then(|extras| extras.refused);
    let still_claims = |winner: &TaskId| resource.waiting.contains(*winner);
    let refused = refused.filter(|(id, _)| *id == need.resource).map(|(_, winner)| winner).filter(still_claims);
    // Only the claimants at the front receive each refusal; the first claimant blocks all later ones.
    let first = claimants.iter().map(|each| each.id).find(|id| still_claims(id));
    let claimant = refused.or_else(|| first.filter(|id| *id != task.id));
    let holders = resource.holders.iter().map(|holding| holding.task);
    let holders: Vec<TaskId> =
        holders.filter(|holder| !crate::control::conflicts::competition::related(agent, *holder, task.id)).collect();
    let rivals = if holders.is_empty() { claimant.into_iter().collect() } else { holders };
    let reason = |rival: TaskId| {
        let holds = resource.holders.iter().any(|holding| holding.task == rival);
        let (word, strength) = if holds {
            ("holds it and defends it with", defence(agent, rival, agent.now))
        } else {
            ("claims it too with", Strength::claiming(priority(agent, rival, agent.now)))
        };
        let strength = Strength { priority: lifted(rival, strength.priority), ..strength };
        Reason {
            now: Some(format!("{} {word} priority {strength}{}, against {own}", name(agent, rival), instead(rival))),
            since: agent.task(rival).map(|task| task.since),
            task: Some(rival),
            place: place(agent, task),
            ..Reason::new(ReasonKind::Resource, format!("{}", resource.name))
        }
    };
    rivals.into_iter().map(reason).collect()
}

fn controller(agent: &Agent, task: &Task) -> Vec<Reason> {
    match task.controller.as_deref() {
        Some(Controller::Primitive(state)) => primitive(agent, task, state),
        Some(Controller::Question(state)) => {
            let now = state.by.map(|by| match &state.default {
                Some(default) => format!("{default} is taken at {by}"),
                None => format!("it fails at {by}"),
            });
            let options: Vec<String> = state.options.iter().map(ToString::to_string).collect();
            let choices = if options.is_empty() { String::new() } else { format!(" ({})", options.join(", ")) };
            let text = format!("the operator's answer to question {}, {:?}{choices}", state.question.0, state.text);
            vec![Reason { now, since: Some(task.since), ..Reason::new(ReasonKind::Operator, text) }]
        }
        Some(Controller::Planning(state)) => {
            let text = format!("a plan for {} (request {})", state.goal, state.request.0);
            let now = state.meanwhile.map(|child| format!("{} is pursued meanwhile", name(agent, child)));
            vec![Reason { now, since: Some(task.since), ..Reason::new(ReasonKind::Plan, text) }]
        }
        Some(other @ (Controller::Procedure(_) | Controller::Items(_) | Controller::Handling(_))) => {
            let living = other.children().into_iter().filter_map(|child| agent.task(child));
            let mut reasons: Vec<Reason> =
                living.filter(|child| !child.is_terminated()).map(|child| subtask(agent, child)).collect();
            if reasons.is_empty() {
                reasons = unmet(agent, task, |clause| clause == Clause::EndWhen);
            }
            reasons
        }
        Some(Controller::BuiltIn) | None => Vec::new(),
    }
}

fn subtask(agent: &Agent, child: &Task) -> Reason {
    Reason {
        now: Some(format!("it is {}", child.state)),
        since: Some(child.since),
        task: Some(child.id),
        place: place(agent, child),
        ..Reason::new(ReasonKind::Subtasks, format!("the end of {}", name(agent, child.id)))
    }
}

fn primitive(agent: &Agent, task: &Task, state: &PrimitiveController) -> Vec<Reason> {
    let place = agent.library.primitives.get(state.primitive as usize).map(|primitive| primitive.place);
    let mut reasons = Vec::new();
    for (id, open) in state.commands.iter().filter_map(|id| Some((id, agent.commands.get(id)?))) {
        let text = format!("the vehicle's answer to command {} {}", id.0, open.form);
        let now = Some(format!("it fails if no answer comes by {}", open.timeout.at));
        reasons.push(Reason { now, since: Some(open.sent_at), place, ..Reason::new(ReasonKind::Command, text) });
    }
    if let Some(end) = state.end {
        let text = format!("the end of its duration at {}", end.at);
        reasons.push(Reason {
            since: Some(task.since),
            until: Some(end.at),
            place,
            ..Reason::new(ReasonKind::Time, text)
        });
    }
    if let Some(update) = state.update.filter(|_| reasons.is_empty()) {
        let text = format!("its form (complete), evaluated next at {}", update.at);
        reasons.push(Reason { since: Some(task.since), place, ..Reason::new(ReasonKind::Time, text) });
    }
    reasons
}

fn ended(task: &Task) -> Reason {
    let text = match &task.outcome {
        Some(apex_model::task::Outcome::Success(value)) if value.is_true() => format!("it ended with {value}"),
        Some(apex_model::task::Outcome::Success(_)) | None => "it ended".to_string(),
        Some(other) => format!("it {}", other.phrase()),
    };
    Reason { since: Some(task.since), ..Reason::new(ReasonKind::Ended, text) }
}
