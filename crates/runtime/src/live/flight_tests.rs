//! A flight in a flood of telemetry: commands of operators are executed, due steps happen at their instant, and losses are inputs.

use super::*;
use crate::flight::Flight;
use crate::ports::{Input, Observer};
use crate::program::{NoDeliberator, NoVehicle};
use crate::run_settings::{Control, EndReason, RunSettings};
use crate::solver_thread::SolverThread;
use apex_executive::Agent;
use apex_model::effect::Effect;
use apex_model::event::{Batch, EventKind, StateVariable};
use apex_model::symbol::Symbol;
use apex_model::time::Time;
use apex_model::value::Value;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Sender, channel};

fn started(agent: &mut Agent, _: &Batch) -> Vec<Effect> {
    agent.started = true;
    Vec::new()
}

fn form(word: &str) -> EventKind {
    EventKind::Occurrence(Value::list([Value::symbol(word)]))
}

/// Batches as lines; stops the run once each of `awaited` was seen.
struct BatchLog {
    lines: Vec<String>,
    awaited: Vec<&'static str>,
    people: Sender<Control>,
}

impl Observer for BatchLog {
    fn observe(&mut self, batch: &Batch, _: &[Effect]) -> Result<(), String> {
        let word = |kind: &EventKind| match kind {
            EventKind::Measurement(..) => "value".to_owned(),
            EventKind::Occurrence(form) => form.to_string(),
            other => format!("{other:?}"),
        };
        let words: Vec<String> = batch.events.iter().map(|event| word(&event.kind)).collect();
        let line = format!("{} {}", batch.now, words.join(", "));
        self.awaited.retain(|part| !line.contains(part));
        if self.awaited.is_empty() {
            self.people.send(Control::Stop).unwrap();
        }
        self.lines.push(line);
        Ok(())
    }
}

/// Sends measurements of one variable as fast as possible until `over` is true.
fn flood(source: &LiveSource, over: &AtomicBool) {
    let variable = StateVariable::new(Symbol::new("height"), Value::symbol("uav"));
    let value = |value| LiveInput::Event(None, EventKind::Measurement(variable.clone(), Value::Integer(value)));
    while !over.load(Ordering::Relaxed) && source.say((0..500).map(value)) {}
}

#[test]
fn an_operator_is_heard_in_a_flood_and_what_is_due_is_stepped() {
    let (people, controls) = channel();
    let wake = people.clone();
    let sources = LiveSources::new(move || wake.send(Control::Look).unwrap_or_default());
    let introduced = |name: &str, class| {
        let source = sources.admit(class).unwrap();
        source.introduce(&Introduction { name: name.into(), class }).unwrap();
        source
    };
    let (nav, tower) = (introduced("nav", SourceClass::Vehicle), introduced("tower", SourceClass::Operator));
    let over = Arc::new(AtomicBool::new(false));
    let flooding = Arc::clone(&over);
    let flooder = std::thread::spawn(move || flood(&nav, &flooding));
    assert!(tower.say([LiveInput::Event(None, form("hello"))]));
    let options = RunSettings {
        pace: Some(1.0),
        until: Time::from_seconds(120.0),
        inputs: vec![Input::new(Time::from_seconds(0.1), form("deadline"))],
        controls: Some(controls),
        live: Some(sources),
        ..RunSettings::default()
    };
    let awaited = vec!["(hello)", "(deadline)", "(live-source nav lost ", "value"];
    let (mut agent, mut log) = (Agent::default(), BatchLog { lines: Vec::new(), awaited, people });
    let queue = Box::new(SolverThread::new(options.solver_timeout));
    let (mut vehicle, mut deliberator) = (NoVehicle::silent(), NoDeliberator);
    let mut observers: Vec<&mut dyn Observer> = vec![&mut log];
    let agents = std::slice::from_mut(&mut agent);
    let mut flight =
        Flight::new(started, agents, &mut vehicle, &mut deliberator, &mut observers, queue, options).unwrap();
    let reason = flight.run().unwrap();
    drop(flight);
    over.store(true, Ordering::Relaxed);
    flooder.join().unwrap();

    assert_eq!(reason, EndReason::Stopped);
    let has = |part: &str| log.lines.iter().filter(|line| line.contains(part)).count();
    assert_eq!(has(" (live-source tower says), (hello)"), 1, "with its author, before any telemetry: {:?}", log.lines);
    assert!(log.lines.iter().any(|line| line.starts_with("0.1s ") && line.contains("(deadline)")), "{:?}", log.lines);
    assert!(has("(live-source nav connected vehicle)") == 1 && has("(live-source nav lost ") >= 1, "{:?}", log.lines);
}
