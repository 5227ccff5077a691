//! Resource allocation (TC)
//! What: turns profiles into needs, gives resources to tasks and takes them back.
//! Runs: choose, commit, and at ends and interruptions.  Reads: profiles, declarations.  Writes: ResourceTable.
//! Bound: O(profile length) per task.  PDL: `profile`, `resource`, `hold-resource`, `release-resource`.
//! Paper: section III, resource allocation between contending tasks.

use crate::control::conflicts::priority;
use crate::control::cycle::Cycle;
use crate::expression::{EvalContext, evaluate, instantiate};
use crate::state::agent::Agent;
use crate::state::resource::{Holding, Need};
use crate::state::resource_id::ResourceId;
use apex_model::because::{Because, Cause};
use apex_model::event::StateVariable;
use apex_model::library::{RESOURCE_LEVEL, ResourceKind};
use apex_model::procedure::ResourceNeed;
use apex_model::quantity::Dimension;
use apex_model::source::Place;
use apex_model::symbol::Symbol;
use apex_model::task::TaskId;
use apex_model::value::Value;
use std::collections::BTreeSet;

/// Returns the needs that `profile` states.
///
/// # Errors
/// Message and place when a name or an amount cannot be evaluated, or an amount is invalid for its resource.
pub(crate) fn needs(
    cycle: &mut Cycle<'_>,
    profile: &[ResourceNeed],
    named: impl Fn(&Cycle<'_>, &ResourceNeed) -> Result<(Value, Option<Value>), (String, Place)>,
    list: &mut Vec<Need>,
) -> Result<(), (String, Place)> {
    for need in profile {
        let (name, amount) = named(cycle, need)?;
        let resource = intern(cycle, &name);
        let amount = amount_of(cycle, resource, amount.as_ref()).map_err(|message| (message, need.place))?;
        add(list, Need { resource, amount });
    }
    Ok(())
}

/// Returns the name and the amount of one entry of a profile, as `context` sees them.
///
/// # Errors
/// Message and place when one of them cannot be evaluated.
pub(crate) fn evaluate_need(
    need: &ResourceNeed,
    context: &dyn EvalContext,
) -> Result<(Value, Option<Value>), (String, Place)> {
    let name = instantiate(&need.resource, context).map_err(|error| (error.message, error.place))?;
    let amount = match &need.amount {
        Some(expr) => Some(evaluate(expr, context).map_err(|error| (error.message, error.place))?),
        None => None,
    };
    Ok((name, amount))
}

/// Returns the number of the resource called `name`; one without declaration is virtual and unitary.
pub(crate) fn intern(cycle: &mut Cycle<'_>, name: &Value) -> ResourceId {
    if let Some(id) = cycle.agent.resources.find(name) {
        return id;
    }
    let declared = name.as_symbol().and_then(|symbol| cycle.library.resources.get(symbol));
    let kind = declared.map_or(&ResourceKind::Unitary, |declaration| &declaration.kind);
    cycle.agent.resources.intern(name, kind)
}

/// Adds a need; two needs of one resource become one with their sum.
pub(crate) fn add(list: &mut Vec<Need>, need: Need) {
    match list.iter_mut().find(|each| each.resource == need.resource) {
        Some(each) => each.amount += need.amount,
        None => list.push(need),
    }
}

/// Adds the parts of the resources in `list`: a task that holds a resource holds all its parts.
pub(crate) fn add_parts(cycle: &mut Cycle<'_>, list: &mut Vec<Need>) {
    let library = cycle.library;
    if list.is_empty() || library.resources.values().all(|declared| declared.part_of.is_none()) {
        return;
    }
    let names = list.iter().filter_map(|need| cycle.agent.resources.get(need.resource)?.name.as_symbol().cloned());
    let parts: BTreeSet<Symbol> = names.flat_map(|name| library.parts_of(&name)).cloned().collect();
    for part in parts {
        let resource = intern(cycle, &Value::Symbol(part));
        let amount = cycle.agent.resources.get(resource).map_or(1.0, |resource| resource.total);
        match list.iter_mut().find(|each| each.resource == resource) {
            Some(each) => each.amount = amount,
            None => list.push(Need { resource, amount }),
        }
    }
}

/// Executes `(replenish RESOURCE [AMOUNT])`: restores the consumed amount, at most `AMOUNT`.
///
/// # Errors
/// The cause if the resource cannot be replenished, or the amount is invalid.
pub(crate) fn replenish(
    cycle: &mut Cycle<'_>,
    id: TaskId,
    name: &Value,
    amount: Option<&Value>,
    because: Because,
) -> Result<(), Because> {
    let failed = |message| Because::new(Cause::ExpressionFailed { message }, because.place);
    let number = intern(cycle, name);
    let wanted = amount.map(|amount| amount_of(cycle, number, Some(amount))).transpose().map_err(failed)?;
    let Some(resource) = cycle.agent.resources.get_mut(number) else { return Ok(()) };
    let Some(full) = resource.renewable else {
        let message = format!("{name} cannot be replenished; declare it as `(resource {name} :renewable AMOUNT)`");
        return Err(failed(message));
    };
    let more = wanted.unwrap_or(full);
    resource.total = (resource.total + more).min(full);
    if !resource.waiting.is_empty() {
        cycle.work.dirty.insert(number);
    }
    tell_level(cycle, id, number, because);
    Ok(())
}

/// Publishes the level of a renewable resource, reservations included.
pub(crate) fn tell_level(cycle: &mut Cycle<'_>, id: TaskId, number: ResourceId, because: Because) {
    let Some(resource) = cycle.agent.resources.get(number).filter(|resource| resource.renewable.is_some()) else {
        return;
    };
    let value = Value::measured(resource.total, resource.dimension);
    let variable = StateVariable::new(Symbol::new(RESOURCE_LEVEL), resource.name.clone());
    cycle.publish_own(id, (variable, value), because);
}

/// Publishes the level of each renewable resource as the agent begins.
pub(crate) fn tell_levels(cycle: &mut Cycle<'_>, root: TaskId) {
    let library = cycle.library;
    for (name, declared) in &library.resources {
        if matches!(declared.kind, ResourceKind::Renewable(_)) {
            let number = intern(cycle, &Value::Symbol(name.clone()));
            let because = Because::new(Cause::LevelChanged { resource: name.clone() }, Some(declared.place));
            tell_level(cycle, root, number, because);
        }
    }
}

fn amount_of(cycle: &Cycle<'_>, id: ResourceId, amount: Option<&Value>) -> Result<f64, String> {
    let Some(resource) = cycle.agent.resources.get(id) else { return Ok(1.0) };
    let Some(amount) = amount else { return Ok(resource.total) };
    let name = &resource.name;
    match amount.as_number() {
        Some((number, dimension)) if dimension == resource.dimension && number >= 0.0 => Ok(number),
        Some((_, dimension)) if dimension != resource.dimension && dimension != Dimension::NONE => Err(format!(
            "{amount} of {name} measures {dimension}, but {name} is declared as {}; write an amount of that kind",
            resource.dimension
        )),
        _ => {
            Err(format!("{amount} is not an amount of {name}; write a number that is not negative, with {name}'s unit"))
        }
    }
}

/// Gives the task all its needs.
pub(crate) fn take(cycle: &mut Cycle<'_>, id: TaskId, needs: &[Need]) {
    for need in needs {
        if let Some(resource) = cycle.agent.resources.get_mut(need.resource) {
            debug_assert!(
                resource.holders.iter().all(|holding| holding.task != id),
                "{id} holds {} twice",
                resource.name
            );
            resource.holders.push(Holding { task: id, amount: need.amount });
            resource.waiting.remove(id);
        }
    }
}

/// Effect of a release on the depletable amounts of a task.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Release {
    /// The resource was used: amounts of depletable resources are consumed.
    Used,
    /// The resource was not used: amounts of depletable resources are restored.
    Unused,
}

/// Returns the kind of release for a task that ends: reservations for work that never began are restored.
pub(crate) fn at_the_end(cycle: &Cycle<'_>, id: TaskId) -> Release {
    let begun = cycle.task(id).and_then(|task| task.selection.as_ref()).is_some_and(|selection| selection.begun);
    if begun { Release::Used } else { Release::Unused }
}

/// Releases the task's depletable resources and removes them from its needs.
pub(crate) fn release_depletables(cycle: &mut Cycle<'_>, id: TaskId, how: Release) {
    let is_depletable = |cycle: &Cycle<'_>, need: &Need| {
        cycle.agent.resources.get(need.resource).is_some_and(|resource| resource.depletable)
    };
    let found: Vec<Need> = needs_of(cycle, id).into_iter().filter(|need| is_depletable(cycle, need)).collect();
    if found.is_empty() {
        return;
    }
    for need in &found {
        release_one(cycle, id, need.resource, how);
    }
    let stays = |need: &Need| found.iter().all(|each| each.resource != need.resource);
    let Some(task) = cycle.agent.task_mut(id) else { return };
    if let Some(selection) = &mut task.selection {
        selection.needs.retain(|need| stays(need));
    }
    if let Some(extras) = &mut task.extras {
        extras.held.retain(|need| stays(need));
    }
}

/// Releases all resources of the task and withdraws its claims; other tasks may claim them.
pub(crate) fn release(cycle: &mut Cycle<'_>, id: TaskId, how: Release) {
    let Some(task) = cycle.task(id) else { return };
    let mut needs = task.selection.as_ref().map(|selection| selection.needs.clone()).unwrap_or_default();
    if let Some(extras) = &task.extras {
        extras.held.iter().for_each(|need| add(&mut needs, *need));
    }
    for need in needs {
        release_one(cycle, id, need.resource, how);
        // The claim kept other tasks from the resource, even if the task did not hold it.
        let claimed = cycle.agent.resources.get_mut(need.resource).is_some_and(|resource| resource.waiting.remove(id));
        if claimed && somebody_cares(cycle, id, need.resource) {
            cycle.work.dirty.insert(need.resource);
        }
    }
    cycle.agent.unsteady.remove(&id);
}

/// Releases one resource.
pub(crate) fn release_one(cycle: &mut Cycle<'_>, id: TaskId, resource_id: ResourceId, how: Release) {
    let Some(resource) = cycle.agent.resources.get_mut(resource_id) else { return };
    let Some(index) = resource.holders.iter().position(|holding| holding.task == id) else { return };
    let holding = resource.holders.remove(index);
    let consumed = resource.depletable && how == Release::Used;
    if consumed {
        resource.total = (resource.total - holding.amount).max(0.0);
    }
    if somebody_cares(cycle, id, resource_id) {
        cycle.work.dirty.insert(resource_id);
    }
    if consumed {
        take_from_ancestors(cycle, id, Need { resource: resource_id, amount: holding.amount });
        let name = cycle.agent.resources.get(resource_id).and_then(|resource| resource.name.as_symbol().cloned());
        if let Some(resource) = name {
            let because = Because::new(Cause::LevelChanged { resource }, cycle.place_of(id));
            tell_level(cycle, id, resource_id, because);
        }
    }
}

/// Returns true if another task is affected when `id` leaves the resource. That is a task that waits for it, or a ranked holder: the
/// priority of `id` may have counted for that holder, and no longer does.
fn somebody_cares(cycle: &Cycle<'_>, id: TaskId, resource: ResourceId) -> bool {
    let Some(resource) = cycle.agent.resources.get(resource) else { return false };
    let has_rank = |id: TaskId| priority::is_ranked(cycle.agent, id);
    !resource.waiting.is_empty()
        || (!resource.holders.is_empty() && has_rank(id) && resource.holders.iter().any(|other| has_rank(other.task)))
}

/// Subtracts the consumed amount from the reservations of the task's ancestors: they have used that much already.
fn take_from_ancestors(cycle: &mut Cycle<'_>, id: TaskId, consumed: Need) {
    let mut above = cycle.task(id).and_then(|task| task.parent);
    while let Some(ancestor) = above {
        let Some(task) = cycle.agent.tasks.get_mut(ancestor.0) else { return };
        above = task.parent;
        let holders = cycle.agent.resources.get_mut(consumed.resource).map(|resource| &mut resource.holders);
        let holding = holders.and_then(|holders| holders.iter_mut().find(|holding| holding.task == ancestor));
        let Some(holding) = holding else { continue };
        holding.amount = (holding.amount - consumed.amount).max(0.0);
        let profile = task.selection.iter_mut().flat_map(|selection| &mut selection.needs);
        let held = task.extras.iter_mut().flat_map(|extras| &mut extras.held);
        for need in profile.chain(held).filter(|need| need.resource == consumed.resource) {
            need.amount = need.amount.min(holding.amount);
        }
    }
}

/// Returns the resources that the task needs to be ongoing: its profile and those that it holds for its steps.
pub(crate) fn needs_of(cycle: &Cycle<'_>, id: TaskId) -> Vec<Need> {
    needs_in(cycle.agent, id)
}

/// Returns the needs of the task, outside of a cycle.
pub(crate) fn needs_in(agent: &Agent, id: TaskId) -> Vec<Need> {
    let Some(task) = agent.task(id) else { return Vec::new() };
    let mut needs = task.selection.as_ref().map(|selection| selection.needs.clone()).unwrap_or_default();
    if let Some(extras) = &task.extras {
        extras.held.iter().for_each(|need| add(&mut needs, *need));
    }
    needs
}
