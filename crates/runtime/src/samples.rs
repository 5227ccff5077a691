//! Inputs and effects made by hand, for tests that need no executive.

use apex_model::because::{Because, Cause, ConflictRule, Evidence, Share, Strength};
use apex_model::effect::{CommandId, Decision, DecisionKind, Effect, Method, QuestionId, SolveRequest, SolveRequestId};
use apex_model::event::{Batch, Event, EventKind, SolverReport, StateVariable};
use apex_model::library::Library;
use apex_model::planned::{PlannedActivity, PlannedProcedure, PlannedStep};
use apex_model::quantity::{Quantity, unit_named};
use apex_model::source::{Place, SourceFile};
use apex_model::symbol::Symbol;
use apex_model::task::{Outcome, TaskId, TaskState};
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
use std::sync::Arc;

/// Returns a library with one source, `camera.pdl`.
pub(crate) fn library() -> Library {
    let source = SourceFile { name: Arc::from("camera.pdl"), text: Arc::from("(procedure (noop))\n") };
    Library { sources: vec![source], ..Library::default() }
}

/// Returns a place in `camera.pdl`.
pub(crate) fn place(line: u32) -> Option<Place> {
    Some(Place { file: 0, line, column: 3 })
}

pub(crate) fn goal(words: &[&str]) -> Value {
    Value::list(words.iter().map(|word| Value::symbol(word)))
}

pub(crate) fn quantity(number: f64, unit: &str) -> Value {
    Value::Quantity(Quantity::of(number, unit_named(unit).unwrap()))
}

pub(crate) fn variable(attribute: &str, object: &str) -> StateVariable {
    StateVariable::new(Symbol::new(attribute), Value::symbol(object))
}

pub(crate) fn sample(attribute: &str, value: Value) -> EventKind {
    EventKind::Measurement(variable(attribute, "aircraft-1"), value)
}

/// Returns a batch at `seconds` whose events happened at that instant, numbered from `first`.
pub(crate) fn batch(seconds: f64, first: u64, kinds: Vec<EventKind>) -> Batch {
    let now = Time::from_seconds(seconds);
    let events = (first..).zip(kinds).map(|(sequence, kind)| Event { sequence, at: now, kind }).collect();
    Batch { now, events }
}

pub(crate) fn step(tag: &str, goal: Value, line: u32) -> PlannedStep {
    PlannedStep { tag: Symbol::new(tag), activity: PlannedActivity::Goal(goal), line }
}

pub(crate) fn plan() -> PlannedProcedure {
    PlannedProcedure {
        solver: Symbol::new("two-opt"),
        summary: "3 targets, value 12".into(),
        steps: vec![step("s1", goal(&["visit", "a"]), 1)],
        repeat: false,
        plan: None,
        source: SourceFile { name: Arc::from("<plan 1>"), text: Arc::from("(procedure (patrol))") },
    }
}

fn decided(task: u64, kind: DecisionKind, because: Because) -> Effect {
    Effect::Decided(Decision { task: Some(TaskId(task)), kind, because })
}

pub(crate) fn created(task: u64, parent: Option<u64>, tag: &str, words: &[&str]) -> Effect {
    let cause = parent.map_or(Cause::InitialTask, |parent| Cause::ParentStarted { parent: TaskId(parent) });
    let parent = parent.map(TaskId);
    let kind = DecisionKind::Created { parent, tag: Symbol::new(tag), goal: goal(words), place: place(2) };
    decided(task, kind, Because::new(cause, None))
}

pub(crate) fn transition(task: u64, from: TaskState, to: TaskState, cause: Cause) -> Effect {
    let outcome = (to == TaskState::Terminated).then_some(Outcome::Success(Value::Integer(7)));
    decided(task, DecisionKind::Transition { from, to, outcome }, Because::new(cause, place(4)))
}

/// Returns three steps that hold every kind of input and effect.
pub(crate) fn steps() -> Vec<(Batch, Vec<Effect>)> {
    let late = |sequence, seconds, kind| Event { sequence, at: Time::from_seconds(seconds), kind };
    let mut second = batch(
        1.5,
        5,
        vec![
            sample("altitude", quantity(24_000.0, "ft")),
            sample("roll-angle", quantity(7.25, "deg")),
            sample("altitude", quantity(7_000.0, "m")),
            sample("Altitude", Value::Integer(3)),
            sample("location", Value::list([Value::Real(34.5), Value::Real(-117.0), Value::Real(7000.0)])),
            EventKind::Occurrence(goal(&["ready", "camera-1"])),
        ],
    );
    second.events.push(late(20, 0.25, sample("roll-angle", Value::Real(f64::NAN))));
    second.events.push(late(21, 1.5, EventKind::SolverReported(SolveRequestId(1), SolverReport::Plan(plan()))));
    let third = batch(
        300.3,
        22,
        vec![
            EventKind::CommandAcknowledged(CommandId(1), Err("icing".into())),
            EventKind::CommandAcknowledged(CommandId(2), Ok(Value::nil())),
            EventKind::SolverReported(SolveRequestId(2), SolverReport::Failed("no feasible plan".into())),
            EventKind::OperatorAnswered(QuestionId(1), Value::text("yes")),
            EventKind::Woken,
        ],
    );
    vec![(batch(0.0, 1, vec![EventKind::Woken]), first_effects()), (second, second_effects()), (third, third_effects())]
}

fn first_effects() -> Vec<Effect> {
    vec![
        created(1, None, "root", &["fly", "mission"]),
        transition(1, TaskState::Pending, TaskState::Enabled, Cause::NoPreconditions),
        created(3, Some(1), "power-up", &["power-up", "?camera"]),
        transition(3, TaskState::Pending, TaskState::Enabled, Cause::PreconditionsSatisfied),
        Effect::Solve(SolveRequest {
            request: SolveRequestId(1),
            task: TaskId(1),
            goal: goal(&["patrol"]),
            solver: Symbol::new("auto"),
            budget: Some(Duration::from_seconds(5.0)),
            is_failure_handled: false,
        }),
    ]
}

fn second_effects() -> Vec<Effect> {
    let granted =
        Cause::ResourcesGranted { resources: vec![Share { resource: Value::symbol("camera-1"), amount: None }] };
    let evidence = Evidence::Sample {
        variable: StateVariable::new(Symbol::new("roll-angle"), Value::symbol("aircraft-1")),
        value: quantity(7.25, "deg"),
        at: Time::from_seconds(1.5),
    };
    let seen = Because { cause: Cause::PreconditionsSatisfied, place: place(5), evidence: vec![evidence].into() };
    let interval = (Time::from_seconds(0.5), Time::from_seconds(1.5));
    let primitive = Method::Primitive(Place { file: 0, line: 9, column: 1 });
    let selected = DecisionKind::Selected {
        method: primitive,
        goal: goal(&["power-up", "camera-1"]),
        alternatives: vec![Method::BuiltIn],
    };
    let added = DecisionKind::ProcedureAdded {
        request: SolveRequestId(1),
        summary: "3 targets, value 12".into(),
        pdl: "(procedure (patrol))".into(),
    };
    let arrived = Cause::PlanArrived { request: SolveRequestId(1), solver: Symbol::new("two-opt") };
    let refused = DecisionKind::Refused { resource: Value::symbol("flight-path"), winner: TaskId(3) };
    let outranked = Cause::Outranked {
        by: TaskId(3),
        resource: Value::symbol("flight-path"),
        rule: ConflictRule::Priority,
        winner: Strength::claiming(7.0),
        loser: Strength { priority: 3.0, interrupt_cost: 0.1 },
    };
    vec![
        decided(3, DecisionKind::Satisfied { clause: "waitfor".into(), interval }, seen),
        decided(
            3,
            DecisionKind::Bound { variable: Symbol::new("camera"), value: Value::symbol("camera-1") },
            Because::new(Cause::Binding { clause: "select".into() }, place(6)),
        ),
        decided(3, selected, Because::new(Cause::MostSpecific { candidates: 2 }, None)),
        transition(3, TaskState::Enabled, TaskState::Ongoing, granted),
        decided(1, added, Because::new(arrived, None)),
        decided(1, refused, Because::new(outranked, place(7))),
        Effect::Command {
            command: CommandId(1),
            task: TaskId(3),
            form: goal(&["switch", "camera-1"]),
            because: Because::new(Cause::FormRan { clause: "on-start".into() }, place(8)),
        },
        Effect::Inform { task: TaskId(3), form: goal(&["powering", "camera-1"]) },
        Effect::Publish {
            task: TaskId(3),
            variable: StateVariable::new(Symbol::new("pictures"), Value::symbol("camera-1")),
            value: Value::Integer(4),
            because: Because::new(Cause::FormRan { clause: "on-start".into() }, place(9)),
        },
        Effect::Print { task: TaskId(3), text: "two\nlines".into() },
    ]
}

fn third_effects() -> Vec<Effect> {
    let failed = Cause::CommandFailed { command: CommandId(1), reason: "icing".into() };
    let trouble = DecisionKind::Trouble { message: "division by zero".into() };
    let failure = Cause::ExpressionFailed { message: "division by zero".into() };
    vec![
        Effect::WithdrawCommand { command: CommandId(2), reason: "its task ended".into() },
        Effect::CancelSolve(SolveRequestId(2)),
        Effect::Ask {
            question: QuestionId(1),
            task: TaskId(1),
            text: "Ready?".into(),
            options: vec![Value::symbol("yes"), Value::symbol("no")],
            by: Some(Time::from_seconds(400.0)),
            default: Some(Value::symbol("no")),
        },
        Effect::Decided(Decision { task: None, kind: trouble, because: Because::new(failure, None) }),
        transition(3, TaskState::Ongoing, TaskState::Terminated, failed),
        transition(3, TaskState::Terminated, TaskState::Pending, Cause::Repetition),
        transition(1, TaskState::Enabled, TaskState::Terminated, Cause::StepsEnded { last: Some(TaskId(3)) }),
        Effect::EndApplication { reason: "the root task ended".into() },
    ]
}
