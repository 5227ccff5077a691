//! The program as run by Apex: text, checker, executive; reported in the reference's words.

use apex_executive::{Agent, load, step};
use apex_model::because::Cause;
use apex_model::effect::{Decision, DecisionKind, Effect};
use apex_model::event::{Batch, Event, EventKind, StateVariable};
use apex_model::host::HostFunctions;
use apex_model::library::AgentDeclaration;
use apex_model::source::Place;
use apex_model::symbol::Symbol;
use apex_model::task::{Outcome, TaskState};
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
use apex_pdl::{CheckOptions, SourceText};
use apex_reference::trace::State;
use apex_reference::{Cut, Input, Line, Run, Said, What};
use std::sync::Arc;

/// Checks and loads a text.
///
/// # Errors
/// The checker's messages.
pub fn loaded(pdl: &str) -> Result<Agent, String> {
    let source = SourceText { name: "page.pdl".into(), text: pdl.into() };
    let mut resolve = |_| Err("nothing is required".into());
    let options = CheckOptions { fragment: false, host: &[], resolve: &mut resolve };
    let checked = apex_pdl::check(vec![source], options);
    if checked.has_errors() {
        return Err(apex_pdl::render(&checked.diagnostics, &checked.library.sources, false));
    }
    let declaration = AgentDeclaration {
        name: Symbol::new("agent"),
        initial_task: Value::list([Value::symbol("do-domain")]),
        bundles: Vec::new(),
        routers: Vec::new(),
        workload: apex_model::library::DEFAULT_WORKLOAD,
        limits: apex_model::agent_limits::Limits::default(),
        place: Place::default(),
    };
    load(Arc::new(checked.library), &declaration, HostFunctions::default())
}

/// Runs the agent to `until`; inputs are in order of arrival. Each instant is a separate step, except that with `together` one step may
/// cover several instants.
pub fn run(agent: &mut Agent, inputs: &[Input], until: i64, together: bool) -> Run {
    let mut run = Run::default();
    let mut events: Vec<(i64, Event)> = Vec::new();
    for (sequence, input) in (0..).zip(inputs) {
        events.push((input.arrives, Event { at: Time(input.at), sequence, kind: kind_of(&input.said) }));
    }
    let mut events = events.as_slice();
    loop {
        let wake = agent.next_wake().map(|(at, _)| at.0);
        let arrival = events.first().map(|(arrives, _)| *arrives);
        let Some(now) = wake.into_iter().chain(arrival).min().filter(|now| *now <= until) else { break };
        // An agent begins at its first step.
        let last = if together && agent.started {
            events.last().map_or(now, |(arrives, _)| now.max(*arrives)).min(until)
        } else {
            now
        };
        let count = events.iter().take_while(|(arrives, _)| *arrives <= last).count();
        let (batch, later) = events.split_at_checked(count).unwrap_or((events, &[]));
        events = later;
        let batch = Batch { now: Time(last), events: batch.iter().map(|(_, event)| event.clone()).collect() };
        let effects = step(agent, &batch);
        run.lines.extend(effects.iter().filter_map(|effect| line_of(last, effect)));
        if effects.iter().any(is_restless) {
            run.cut = Some(Cut::Restless(last));
        }
        if agent.is_finished() || run.cut.is_some() {
            break;
        }
    }
    tell_end(agent, &mut run);
    run
}

fn tell_end(agent: &Agent, run: &mut Run) {
    run.states = agent.tasks.iter().map(|(_, task)| (number(task.id.0), state_of(task.state))).collect();
    for (_, resource) in agent.resources.iter() {
        run.totals.insert(resource.name.to_string(), resource.total.to_string());
        for holding in &resource.holders {
            run.holders.insert((resource.name.to_string(), number(holding.task.0), holding.amount.to_string()));
        }
    }
}

/// Returns true if the executive stopped at an instant because a limit was reached.
fn is_restless(effect: &Effect) -> bool {
    let Effect::Decided(decision) = effect else { return false };
    matches!(decision.because.cause, Cause::LimitReached { .. })
}

fn kind_of(said: &Said) -> EventKind {
    match said {
        Said::Message(words) => EventKind::Occurrence(Value::list(words.iter().map(value_of))),
        Said::Sample(attribute, object, value) => {
            let variable = StateVariable::new(Symbol::new(attribute), Value::symbol(object));
            EventKind::Measurement(variable, value_of(value))
        }
    }
}

fn value_of(value: &apex_reference::Value) -> Value {
    use apex_reference::Value as Theirs;
    match value {
        Theirs::Nil => Value::nil(),
        Theirs::Word(word) => Value::symbol(word),
        Theirs::Number(number) if number.fract() == 0.0 => Value::Integer(*number as i64),
        Theirs::Number(number) => Value::Real(*number),
        Theirs::Span(span) => Value::Duration(Duration(*span)),
        Theirs::List(items) => Value::list(items.iter().map(value_of)),
        Theirs::Task(_) => Value::nil(),
    }
}

fn number(id: u64) -> usize {
    usize::try_from(id).unwrap_or(usize::MAX)
}

fn state_of(state: TaskState) -> State {
    match state {
        TaskState::Pending => State::Pending,
        TaskState::Enabled => State::Enabled,
        TaskState::Ongoing => State::Ongoing,
        TaskState::Interrupted => State::Interrupted,
        TaskState::Terminated => State::Terminated,
    }
}

fn line_of(at: i64, effect: &Effect) -> Option<Line> {
    let (task, what) = match effect {
        Effect::Decided(decision) => (number(decision.task?.0), decided(decision)?),
        Effect::Inform { task, form } => (number(task.0), What::Informed(form.to_string())),
        Effect::Print { task, text } => (number(task.0), What::Printed(text.clone())),
        Effect::EndApplication { .. } => (0, What::Finished),
        _ => return None,
    };
    Some(Line { at, task, what })
}

fn decided(decision: &Decision) -> Option<What> {
    match &decision.kind {
        DecisionKind::Created { parent, tag, .. } => {
            let tag = if parent.is_none() { "root".to_string() } else { tag.to_string() };
            Some(What::Created(parent.map(|parent| number(parent.0)), tag))
        }
        DecisionKind::Transition { from, to, outcome } => {
            let outcome = outcome.as_ref().map(|outcome| match outcome {
                Outcome::Success(value) => format!("success {}", shown(value)),
                other => other.word().to_string(),
            });
            let cause = cause(&decision.because.cause);
            Some(What::Moved(state_of(*from), state_of(*to), outcome, cause))
        }
        _ => None,
    }
}

fn shown(value: &Value) -> String {
    match value {
        Value::Duration(span) => format!("{}ns", span.0),
        other => other.to_string(),
    }
}

/// Causes in the words of the reference.
fn cause(cause: &Cause) -> String {
    match cause {
        Cause::NoPreconditions
        | Cause::PreconditionsSatisfied
        | Cause::PredecessorEnded { .. }
        | Cause::ResultArrived { .. }
        | Cause::IntervalElapsed
        | Cause::StartsOver
        | Cause::RepeatedEnabled => "nothing holds it back".into(),
        Cause::ConditionSatisfied { clause } => format!("clause {clause}"),
        Cause::ResourcesGranted { .. } => "granted".into(),
        Cause::Outranked { by, resource, .. } => format!("outranked by {by} on {resource}"),
        Cause::ResourceExhausted { .. } => "a resource is exhausted".into(),
        Cause::AncestorSuspended { ancestor } => format!("suspended {ancestor}"),
        Cause::AncestorResumed { ancestor } => format!("resumed {ancestor}"),
        Cause::Activity { by, activity } => format!("{activity} by {by}"),
        Cause::StepsEnded { .. } => "all steps ended".into(),
        Cause::CompletedAtOnce | Cause::BuiltInDone { .. } => "at once".into(),
        Cause::CompletedByForm => "a form".into(),
        Cause::DurationElapsed { .. } => "its duration".into(),
        Cause::ConditionViolated { clause } => format!("{clause} does not hold"),
        Cause::OutcomeMissed { .. } => "its outcome is missed".into(),
        Cause::ResultMissed { .. } => "its result is missed".into(),
        Cause::ResourceBusy { .. } => "a resource is busy".into(),
        Cause::ItemsEnded { .. } => "all items ended".into(),
        Cause::ParentEnded { parent } => format!("parent {parent} ended"),
        Cause::ParentRestarted { parent } => format!("parent {parent} restarted"),
        Cause::ParentFailed { parent } => format!("parent {parent} failed"),
        Cause::ChildFailed { child } => format!("child {child} failed"),
        Cause::FailureHandled { by } => format!("handled by {by}"),
        Cause::HandlerEnded { handler } => format!("handler {handler} ended"),
        Cause::Repetition => "repetition".into(),
        Cause::NoMethod { .. } => "no method".into(),
        Cause::ExpressionFailed { .. } | Cause::InputRefused { .. } => "an expression".into(),
        Cause::ApplicationEnded { .. } => "the application ended".into(),
        other => format!("{other:?}"),
    }
}
