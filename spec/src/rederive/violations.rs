//! Checks of violated conditions: a `precondition` or `invariant` that does not hold is based on facts that make it false, or on missing
//! knowledge.

use super::evidence::{conditions_at, holds_of, in_time, is_of, one, was_measured};
use super::require::require;
use super::step::Step;
use super::thresholds::Thresholds;
use super::world::World;
use apex_model::because::{Because, Evidence};
use apex_model::condition::{Condition, ConditionKind};
use apex_model::task::TaskId;

/// Looks for the evidence that one of the conditions does not hold.
pub(super) fn check(world: &World<'_>, step: &Step, task: TaskId, because: &Because) -> Result<(), String> {
    let conditions = because.place.map(|place| conditions_at(world, place)).unwrap_or_default();
    let mut leaves = Vec::new();
    conditions.iter().for_each(|condition| collect(condition, false, &mut leaves));
    require(!because.evidence.is_empty(), "nothing says why it does not hold")?;
    for evidence in because.evidence.iter() {
        fact(world, step, task, evidence, &leaves).map_err(|what| format!("{}: {what}", evidence.text()))?;
    }
    Ok(())
}

fn fact(
    world: &World<'_>,
    step: &Step,
    task: TaskId,
    evidence: &Evidence,
    leaves: &[(&ConditionKind, bool)],
) -> Result<(), String> {
    match evidence {
        Evidence::Sample { variable, value, at } => {
            in_time(world, *at)?;
            let variable = variable.to_string();
            was_measured(world, &variable, value, *at)?;
            let thresholds = Thresholds { world, task };
            let decides = leaves.iter().any(|(leaf, truth)| match leaf {
                ConditionKind::Measurement(measurement) if is_of(&variable, leaf) => {
                    holds_of(&thresholds, measurement, value) != Some(!truth)
                }
                _ => false,
            });
            require(decides, "it does not make the condition false")
        }
        Evidence::Function { value, at, .. } => {
            let decides = |(leaf, truth): &(&ConditionKind, bool)| {
                matches!(leaf, ConditionKind::Function(_)) && value.is_true() == *truth
            };
            require(leaves.iter().any(decides), "it does not make the condition false")?;
            require(*at == world.now, "its instant is not the present")
        }
        Evidence::TaskState { .. } => {
            let about = |(leaf, _): &(&ConditionKind, bool)| {
                matches!(leaf, ConditionKind::TaskState { .. } | ConditionKind::TaskEnded(_))
            };
            require(leaves.iter().any(about), "the condition names no state of a task")?;
            one(world, step, task, evidence, &[])
        }
        other => one(world, step, task, other, &[]),
    }
}

/// Collects the parts of the condition, each with the truth value that gives the whole this truth value.
fn collect<'a>(condition: &'a Condition, truth: bool, leaves: &mut Vec<(&'a ConditionKind, bool)>) {
    match &condition.kind {
        ConditionKind::And(parts, _) | ConditionKind::Or(parts, _) => {
            parts.iter().for_each(|part| collect(part, truth, leaves));
        }
        ConditionKind::Not(part) => collect(part, !truth, leaves),
        leaf => leaves.push((leaf, truth)),
    }
}
