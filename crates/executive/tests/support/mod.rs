//! A minimal runtime for tests: loads PDL, delivers events, steps the agent at its wakes, and records the effects.
#![allow(dead_code, missing_docs, unreachable_pub, unused_imports)]
#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "a test stops at an unexpected result")]

pub mod programs;

use apex_executive::{Agent, load, step};
use apex_model::effect::{CommandId, DecisionKind, Effect};
use apex_model::event::{Batch, Event, EventKind, StateVariable};
use apex_model::host::HostFunctions;
use apex_model::library::{AgentDeclaration, Library};
use apex_model::source::Place;
use apex_model::symbol::Symbol;
use apex_model::task::TaskId;
use apex_model::time::Time;
use apex_model::value::Value;
use apex_pdl::{CheckOptions, SourceText, check};
use std::collections::BTreeMap;
use std::sync::Arc;

pub fn library(pdl: &str) -> Arc<Library> {
    let source = SourceText { name: "test.pdl".into(), text: pdl.into() };
    let mut resolve = |_| Err("nothing to require".into());
    let checked = check(vec![source], CheckOptions { fragment: false, host: &[], resolve: &mut resolve });
    let messages = apex_pdl::render(&checked.diagnostics, &checked.library.sources, false);
    assert!(!checked.has_errors(), "{messages}");
    Arc::new(checked.library)
}

pub fn agent(pdl: &str) -> Agent {
    agent_of(library(pdl))
}

pub fn agent_of(library: Arc<Library>) -> Agent {
    let declaration = library.agents.first().cloned().unwrap_or_else(|| AgentDeclaration {
        name: Symbol::new("pilot"),
        initial_task: Value::list([Value::symbol("do-domain")]),
        bundles: Vec::new(),
        routers: Vec::new(),
        workload: apex_model::library::DEFAULT_WORKLOAD,
        limits: apex_model::agent_limits::Limits::default(),
        place: Place::default(),
    });
    load(library, &declaration, HostFunctions::default()).unwrap()
}

pub fn seconds(at: f64) -> Time {
    Time::from_seconds(at)
}

pub fn value(text: &str) -> Value {
    apex_pdl::read_value(text).unwrap()
}

pub fn message(at: f64, form: &str) -> Event {
    Event { sequence: 0, at: seconds(at), kind: EventKind::Occurrence(value(form)) }
}

pub fn sample(at: f64, variable: &str, measured: &str) -> Event {
    let form = value(variable);
    let parts = form.as_list().unwrap();
    let variable = StateVariable::new(parts[0].as_symbol().unwrap().clone(), parts[1].clone());
    Event { sequence: 0, at: seconds(at), kind: EventKind::Measurement(variable, value(measured)) }
}

pub fn answer(at: f64, command: u64, reply: Result<Value, &str>) -> Event {
    let kind = EventKind::CommandAcknowledged(CommandId(command), reply.map_err(str::to_string));
    Event { sequence: 0, at: seconds(at), kind }
}

/// Runs to `until` (seconds): events of one instant form one batch, and the agent is stepped at every wake that it requests.
pub fn run(agent: &mut Agent, events: &[Event], until: f64) -> Vec<(Time, Effect)> {
    run_from(agent, events, Time::ZERO, until)
}

pub fn run_from(agent: &mut Agent, events: &[Event], from: Time, until: f64) -> Vec<(Time, Effect)> {
    let mut instants: BTreeMap<Time, Vec<Event>> = BTreeMap::new();
    for (number, event) in events.iter().enumerate() {
        let event = Event { sequence: number as u64, ..event.clone() };
        instants.entry(event.at).or_default().push(event);
    }
    instants.entry(from).or_default();
    let mut effects = Vec::new();
    loop {
        let wake = agent.next_wake().map(|(at, _)| at);
        let event = instants.keys().next().copied();
        let Some(now) = [wake, event].into_iter().flatten().min().filter(|at| *at <= seconds(until)) else { break };
        let events = instants.remove(&now).unwrap_or_default();
        effects.extend(step(agent, &Batch { now, events }).into_iter().map(|effect| (now, effect)));
        if agent.is_finished() {
            break;
        }
    }
    effects
}

/// Returns the tag of each task, from the decisions of creation.
pub fn tags(effects: &[(Time, Effect)]) -> BTreeMap<TaskId, String> {
    let mut tags = BTreeMap::new();
    for (_, effect) in effects {
        if let Effect::Decided(decision) = effect
            && let (DecisionKind::Created { tag, .. }, Some(task)) = (&decision.kind, decision.task)
        {
            tags.insert(task, tag.to_string());
        }
    }
    tags
}

/// Returns the printed texts, in order.
pub fn printed(effects: &[(Time, Effect)]) -> Vec<String> {
    let text = |effect: &Effect| match effect {
        Effect::Print { text, .. } => Some(text.clone()),
        _ => None,
    };
    effects.iter().filter_map(|(_, effect)| text(effect)).collect()
}

/// Returns one line per transition, print, command and end: `2s a ongoing`.
pub fn story(effects: &[(Time, Effect)]) -> Vec<String> {
    let tags = tags(effects);
    let name = |task: &TaskId| tags.get(task).cloned().unwrap_or_else(|| task.to_string());
    let line = |effect: &Effect| match effect {
        Effect::Decided(decision) => match &decision.kind {
            DecisionKind::Transition { to, outcome, .. } => {
                let outcome = match outcome {
                    Some(apex_model::task::Outcome::Failure) => " failure",
                    Some(apex_model::task::Outcome::Cut) => " cut",
                    _ => "",
                };
                Some(format!("{} {to}{outcome}", name(&decision.task?)))
            }
            DecisionKind::Trouble { message } => Some(format!("trouble {message}")), // english: allow
            _ => None,
        },
        Effect::Print { text, .. } => Some(format!("print {text}")),
        Effect::Command { command, form, .. } => Some(format!("command {} {form}", command.0)),
        Effect::WithdrawCommand { command, .. } => Some(format!("withdraw {}", command.0)),
        Effect::Solve(request) => Some(format!("solve {} {}", request.request.0, request.goal)),
        Effect::CancelSolve(request) => Some(format!("cancel {}", request.0)),
        Effect::Ask { text, .. } => Some(format!("ask {text}")),
        Effect::Inform { form, .. } => Some(format!("inform {form}")),
        Effect::WithdrawQuestion { question, .. } => Some(format!("withdraw question {}", question.0)),
        Effect::Tell { to, message, .. } => Some(format!("tell {to:?} {message}")),
        Effect::Publish { variable, value, .. } => Some(format!("publish {variable} = {value}")),
        Effect::EndApplication { .. } | Effect::AgentEnded { .. } => Some("end".to_string()),
    };
    effects.iter().filter_map(|(at, effect)| Some(format!("{at} {}", line(effect)?))).collect()
}

/// Returns the lines of `story` that contain one of the words `wanted`.
pub fn lines(effects: &[(Time, Effect)], wanted: &[&str]) -> Vec<String> {
    let keep = |line: &String| wanted.iter().any(|word| line.split(' ').any(|part| part == *word));
    story(effects).into_iter().filter(keep).collect()
}
