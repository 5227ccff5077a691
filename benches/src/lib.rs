//! Programs and agents shared by the measurements.
#![allow(clippy::panic, reason = "a measurement that cannot be set up must stop at once")]

pub mod monitoring;
pub mod programs;
pub mod rows;

use apex_executive::{Agent, load, step};
use apex_model::effect::{CommandId, DecisionKind, Effect};
use apex_model::event::{Batch, Event, EventKind, StateVariable};
use apex_model::host::HostFunctions;
use apex_model::library::{AgentDeclaration, Library};
use apex_model::source::Place;
use apex_model::symbol::Symbol;
use apex_model::task::TaskState;
use apex_model::time::Time;
use apex_model::value::Value;
use apex_pdl::{CheckOptions, Checked, SourceText};
use std::sync::Arc;
use std::time::Duration;

/// Time for which a row runs before its measurement.
pub const WARM_UP: Duration = Duration::from_millis(500);
/// Approximate time for which a row is measured, so short that all rows together take minutes.
pub const MEASUREMENT: Duration = Duration::from_secs(2);

/// Program of COUNT tasks, each of which waits for a separate variable, commands, and waits again.
pub const WATCHERS: &str = "
(procedure (index (do-domain))
  (step all (watch ?n) (forall ?n in (range COUNT))))
(procedure (index (watch ?n))
  (step act (act on ?n) (waitfor (level <?n> > 10)) (repeating)))
(primitive (index (act on ?n)) (on-start (command (act ?n))))
";

/// A patrol that is interrupted by every fire, for ten thousand seconds.
pub const PATROL: &str = "
(procedure (index (do-domain))
  (step patrol (patrol) (repeating))
  (step fire (look at ?where) (waitfor (fire ?where)) (responding) (priority 5))
  (step over (terminate) (waitfor (landed))))
(primitive (index (patrol)) (profile flight-path) (duration 60s))
(primitive (index (look at ?where)) (profile flight-path) (duration 5s))
";

/// Checks a program that requires nothing.
pub fn check(text: &str) -> Checked {
    let source = SourceText { name: "bench.pdl".into(), text: text.into() };
    let mut resolve = |_| Err("a measured program requires nothing".into());
    apex_pdl::check(vec![source], CheckOptions { fragment: false, host: &[], resolve: &mut resolve })
}

/// Returns the library of a program without mistakes.
pub fn library(text: &str) -> Arc<Library> {
    let checked = check(text);
    if checked.has_errors() {
        panic!("{}", apex_pdl::render(&checked.diagnostics, &checked.library.sources, false));
    }
    Arc::new(checked.library)
}

/// Returns an agent with the default initial task.
pub fn agent(library: &Arc<Library>) -> Agent {
    load(Arc::clone(library), &declaration(), HostFunctions::default()).unwrap_or_else(|message| panic!("{message}"))
}

/// Returns the default agent.
pub fn declaration() -> AgentDeclaration {
    AgentDeclaration {
        name: Symbol::new("agent"),
        initial_task: Value::list([Value::symbol("do-domain")]),
        bundles: Vec::new(),
        routers: Vec::new(),
        workload: apex_model::library::DEFAULT_WORKLOAD,
        limits: apex_model::agent_limits::Limits::default(),
        place: Place::default(),
    }
}

/// An agent with the clock and the counter of its inputs.
#[derive(Clone, Debug)]
pub struct Driven {
    agent: Agent,
    now: Time,
    sequence: u64,
}

impl Driven {
    /// Returns a new agent that has not begun.
    pub fn ready(library: &Arc<Library>) -> Driven {
        Driven { agent: agent(library), now: Time::ZERO, sequence: 0 }
    }

    /// Begins at mission time 0; returns the agent and its first effects.
    #[inline(never)]
    pub fn begin(mut self) -> (Driven, Vec<Effect>) {
        let effects = step(&mut self.agent, &Batch { now: Time::ZERO, events: Vec::new() });
        (self, effects)
    }

    /// Returns a new agent that has begun, and its first effects.
    pub fn begun(library: &Arc<Library>) -> (Driven, Vec<Effect>) {
        Driven::ready(library).begin()
    }

    /// Returns a new agent that has begun.
    pub fn new(library: &Arc<Library>) -> Driven {
        Driven::begun(library).0
    }

    /// Returns the batch that brings `kind` a millisecond later.
    pub fn batch(&mut self, kind: EventKind) -> Batch {
        self.now = Time(self.now.0 + 1_000_000);
        self.sequence += 1;
        Batch { now: self.now, events: vec![Event { sequence: self.sequence, at: self.now, kind }] }
    }

    /// Steps the agent.
    #[inline(never)]
    pub fn step(&mut self, batch: &Batch) -> Vec<Effect> {
        step(&mut self.agent, batch)
    }

    /// Like `step`, under another name, so that profilers can exclude it.
    #[inline(never)]
    pub fn answer(&mut self, batch: &Batch) {
        step(&mut self.agent, batch);
    }
}

/// Returns true if a task has changed from one state to the other.
pub fn moved(effects: &[Effect], from: TaskState, to: TaskState) -> bool {
    effects.iter().any(|effect| match effect {
        Effect::Decided(decision) => {
            matches!(&decision.kind, DecisionKind::Transition { from: a, to: b, .. } if (*a, *b) == (from, to))
        }
        _ => false,
    })
}

/// Returns per sample of `(level number)`.
pub fn level(number: i64, value: i64) -> EventKind {
    EventKind::Measurement(StateVariable::new(Symbol::new("level"), Value::Integer(number)), Value::Integer(value))
}

/// Returns the command among the effects.
pub fn command_in(effects: &[Effect]) -> Option<CommandId> {
    effects.iter().find_map(|effect| match effect {
        Effect::Command { command, .. } => Some(*command),
        _ => None,
    })
}
