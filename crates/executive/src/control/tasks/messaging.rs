//! Messaging (TC)
//! What: sends each message of an agent to the agents of the application that receive it.
//! Runs: act phase and hooks.  Reads: declarations of agents and routers.  Writes: effects, messages of the agent to itself.
//! Bound: O(agents x routers of the author) pattern matches per message.
//! PDL: `cogevent`, `inform`, `publish`; section 8, routers.  Paper: section III, message passing and publish-subscribe.

use crate::control::cycle::{Cycle, SelfMessage};
use crate::expression::EvaluationError;
use crate::expression::declared_unit;
use crate::expression::view::View;
use crate::monitoring::pattern_matching::match_pattern;
use crate::state::bindings::Bindings;
use crate::state::clause::Level;
use apex_model::because::{Because, Cause};
use apex_model::effect::Effect;
use apex_model::event::{Message, StateVariable, measured};
use apex_model::library::{AgentDeclaration, DEFAULT_ROUTER, Topics};
use apex_model::source::Place;
use apex_model::symbol::Symbol;
use apex_model::task::TaskId;
use apex_model::value::Value;

/// Executes `(inform FORM)`: sends the message to the outside, to this agent, and to the agents that receive it on this agent's routers.
/// `(inform FORM router)` sends it to the outside and that router alone; the author does not receive it.
///
/// # Errors
/// The cause if no router has this name, or this agent does not publish on it.
pub(crate) fn inform(
    cycle: &mut Cycle<'_>,
    id: TaskId,
    form: Value,
    router: Option<&Value>,
    place: Place,
) -> Result<(), Because> {
    let message = Message::Occurrence(form.clone());
    let to = receivers(cycle, &message, router, place)?;
    cycle.effects.push(Effect::Inform { task: id, form: form.clone() });
    tell(cycle, id, to, message);
    if !is_given(router) {
        say(cycle, form);
    }
    Ok(())
}

/// Executes `(publish (ATTRIBUTE OBJECT) value [router])`: like [`inform`], for samples. The trace contains them; the outside does not
/// receive them.
///
/// # Errors
/// Like [`inform`].
pub(crate) fn publish(
    cycle: &mut Cycle<'_>,
    id: TaskId,
    (variable, value): (StateVariable, Value),
    router: Option<&Value>,
    because: Because,
) -> Result<(), Because> {
    let message = Message::Measurement(variable.clone(), value.clone());
    let to = receivers(cycle, &message, router, because.place.unwrap_or_default())?;
    if !is_given(router) {
        let held = declared_unit::in_declared_unit(cycle.library, &variable, value.clone());
        let shown = held.unwrap_or_else(|_| value.clone());
        let effect = Effect::Publish { task: id, variable: variable.clone(), value: shown, because };
        cycle.effects.push(effect);
        cycle.say_sample(variable, value);
    }
    tell(cycle, id, to, message);
    Ok(())
}

/// Delivers a message of the agent to itself; `(ATTRIBUTE OBJECT = VALUE)` is a sample.
fn say(cycle: &mut Cycle<'_>, form: Value) {
    match measured(&form) {
        Some((variable, value)) => cycle.say_sample(variable, value),
        None => cycle.work.said.push(SelfMessage::Occurrence(form)),
    }
}

/// Executes `(cogevent FORM [agent])`: sends a message to this agent or to another one.
///
/// # Errors
/// The cause if no agent of the application has this name.
pub(crate) fn cogevent(
    cycle: &mut Cycle<'_>,
    id: TaskId,
    form: Value,
    agent: Option<&Value>,
    place: Place,
) -> Result<(), Because> {
    let Some(agent) = agent.filter(|agent| agent.is_true()) else {
        say(cycle, form);
        return Ok(());
    };
    let own = &cycle.agent.name;
    match agent.as_symbol() {
        Some(name) if name == own => say(cycle, form),
        Some(name) if cycle.library.agents.iter().any(|each| each.name == *name) => {
            let to = vec![name.clone()];
            tell(cycle, id, to, Message::Occurrence(form));
        }
        _ => {
            let mut known: Vec<&str> = cycle.library.agents.iter().map(|each| each.name.printed()).collect();
            if known.is_empty() {
                known.push(own.printed());
            }
            let message = format!("no agent is called {agent}; the application has {}", known.join(", "));
            return Err(Because::new(Cause::NobodyHears { message }, Some(place)));
        }
    }
    Ok(())
}

fn is_given(router: Option<&Value>) -> bool {
    router.is_some_and(Value::is_true)
}

fn tell(cycle: &mut Cycle<'_>, task: TaskId, to: Vec<Symbol>, message: Message) {
    if !to.is_empty() {
        cycle.effects.push(Effect::Tell { task, to, message });
    }
}

/// Returns the other agents that receive `message` on `router`, or on any router to which this agent publishes it.
fn receivers(
    cycle: &Cycle<'_>,
    message: &Message,
    router: Option<&Value>,
    place: Place,
) -> Result<Vec<Symbol>, Because> {
    let named = router.filter(|router| router.is_true());
    if named.is_none() && !cycle.library.has_several_agents() {
        return Ok(Vec::new());
    }
    let failed = |message: String| Because::new(Cause::ExpressionFailed { message }, Some(place));
    let unheard = |message: String| Because::new(Cause::NobodyHears { message }, Some(place));
    let alone;
    let agents = match cycle.library.agents.as_slice() {
        [] => {
            alone = cycle.library.crew();
            &alone
        }
        some => some,
    };
    let own = agents.iter().find(|each| each.name == cycle.agent.name);
    let used = own.map(|own| own.routers.as_slice()).unwrap_or_default();
    if let Some(named) = named {
        check_router(cycle, used.iter().map(|each| &each.router), named).map_err(unheard)?;
    }
    let topic = match message {
        Message::Occurrence(form) => form.clone(),
        Message::Measurement(variable, _) => variable.form(),
    };
    let passes = |topics: &Topics| passes(cycle, topics, &topic).map_err(|error| failed(error.message));
    let mut to: Vec<Symbol> = Vec::new();
    for way in used.iter().filter(|way| named.is_none_or(|named| named.as_symbol() == Some(&way.router))) {
        let carries = cycle.library.routers.get(&way.router).map_or(&Topics::All, |router| &router.carries);
        if !passes(&way.publish)? || !passes(carries)? {
            continue;
        }
        for listener in agents.iter().filter(|each| each.name != cycle.agent.name) {
            if !to.contains(&listener.name) && hears(listener, &way.router, &passes)? {
                to.push(listener.name.clone());
            }
        }
    }
    to.sort_by_key(|name| agents.iter().position(|each| each.name == *name));
    Ok(to)
}

fn hears(
    listener: &AgentDeclaration,
    router: &Symbol,
    passes: &dyn Fn(&Topics) -> Result<bool, Because>,
) -> Result<bool, Because> {
    for way in listener.routers.iter().filter(|way| way.router == *router) {
        if passes(&way.subscribe)? {
            return Ok(true);
        }
    }
    Ok(false)
}

/// Checks that a named router exists and that this agent uses it.
fn check_router<'r>(
    cycle: &Cycle<'_>,
    mut used: impl Iterator<Item = &'r Symbol>,
    named: &Value,
) -> Result<(), String> {
    if used.any(|router| named.as_symbol() == Some(router)) {
        return Ok(());
    }
    let declared = |name: &Symbol| cycle.library.routers.contains_key(name) || name.is(DEFAULT_ROUTER);
    if named.as_symbol().is_some_and(declared) {
        return Err(format!("{} does not use router {named}; add it to the agent's `:routers`", cycle.agent.name));
    }
    let mut known: Vec<&str> = cycle.library.routers.keys().map(Symbol::printed).collect();
    if !known.contains(&DEFAULT_ROUTER) {
        known.push(DEFAULT_ROUTER);
    }
    Err(format!("no router is called {named}; there are {}", known.join(", ")))
}

/// Returns true if the topics include this one. A topic belongs to no task, so the variables of its pattern are local to it.
fn passes(cycle: &Cycle<'_>, topics: &Topics, topic: &Value) -> Result<bool, EvaluationError> {
    let patterns = match topics {
        Topics::All => return Ok(true),
        Topics::Matching(patterns) => patterns,
    };
    let nobody = TaskId(u64::MAX);
    let view = View { agent: cycle.agent, task: nobody, level: Level::Step, now: cycle.now };
    for pattern in patterns {
        if match_pattern(pattern, topic, &mut Bindings::new(), &view, Place::default())? {
            return Ok(true);
        }
    }
    Ok(false)
}
