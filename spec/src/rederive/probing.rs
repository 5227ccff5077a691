//! Second derivation of the causes for which probes begin and probing stops.

use super::causes::Scene;
use super::require::require;
use super::world::Known;
use apex_model::because::Cause;
use apex_model::effect::{DecisionKind, Effect};
use apex_model::probing::ProbingEnd;
use apex_model::task::{TaskId, TaskState};

type Checked = Result<(), String>;

/// Returns the latest probe with this number for the condition of the scene.
fn numbered<'a>(scene: &'a Scene<'_>, waiting: TaskId, wanted: u64) -> Result<&'a Known, String> {
    let place = scene.because.place;
    let is = |known: &&Known| {
        known.place == place
            && matches!(known.made, Cause::Probes { waiting: task, number, .. } if task == waiting && number == wanted)
    };
    scene.world.tasks.values().rfind(is).ok_or_else(|| format!("there was no probe {wanted}"))
}

/// Checks the beginning of a probe.
pub(super) fn probes(
    scene: &Scene<'_>,
    parent: Option<TaskId>,
    (waiting, number, limit): (TaskId, u64, Option<u64>),
) -> Checked {
    let known = scene.world.task(waiting)?;
    require(
        parent == known.parent || parent == Some(waiting),
        "its parent is neither the waiting task nor the parent of that task",
    )?;
    require(known.state != TaskState::Terminated, "no task waits")?;
    require(limit.is_none_or(|limit| number <= limit), "its number exceeds the limit of probes")?;
    let place = scene.because.place.ok_or("it names no condition")?;
    let source = scene.world.library.sources.get(place.file as usize);
    let tail = source.and_then(|source| {
        let line = source.text.lines().nth(place.line as usize - 1)?;
        let rest: Vec<&str> = source.text.lines().skip(place.line as usize).collect();
        Some(format!("{}\n{}", line.chars().skip(place.column as usize - 1).collect::<String>(), rest.join("\n")))
    });
    require(tail.is_some_and(|tail| tail.contains(":probing")), "its condition has no :probing")?;
    if number > 1 {
        let before = numbered(scene, waiting, number - 1)?;
        require(before.state == TaskState::Terminated, "the probe before it lives")?;
        require(before.created < scene.world.now, "the probe before it began just now")?;
    }
    Ok(())
}

/// Checks that a probe which had not ended is cut.
pub(super) fn cut(scene: &Scene<'_>, own: &Known, (waiting, probes, reason): (TaskId, u64, ProbingEnd)) -> Checked {
    let made = matches!(own.made, Cause::Probes { waiting: task, number, .. } if task == waiting && number == probes);
    require(made, "it is not a probe of that condition with that number")?;
    match reason {
        ProbingEnd::Satisfied => {
            let came = !scene.step.batch.events.is_empty() || !scene.world.messages.is_empty();
            require(came || said_something(scene, waiting), "nothing came that could satisfy the condition")
        }
        ProbingEnd::NotAwaited => require(said_something(scene, waiting), "nothing happened to the task that waits"),
        ProbingEnd::TimeLimit(_) => limit(scene, waiting, probes, reason),
        ProbingEnd::CountLimit(_) => Err("a probe that lives has not reached the limit".into()),
    }
}

fn said_something(scene: &Scene<'_>, waiting: TaskId) -> bool {
    let about = |effect: &Effect| {
        matches!(effect, Effect::Decided(decision) if decision.task == Some(waiting)
            && matches!(decision.kind, DecisionKind::Satisfied { .. } | DecisionKind::Transition { .. }))
    };
    scene.step.effects.iter().any(about)
}

/// Checks that a limit of probing is reached.
pub(super) fn limit(scene: &Scene<'_>, waiting: TaskId, probes: u64, reason: ProbingEnd) -> Checked {
    let (first, last) = (numbered(scene, waiting, 1)?, numbered(scene, waiting, probes)?);
    match reason {
        ProbingEnd::TimeLimit(span) => {
            require(first.created + span == scene.world.now, "the time limit does not end now")
        }
        ProbingEnd::CountLimit(count) => {
            require(count == probes, "there were fewer probes")?;
            require(
                last.state == TaskState::Terminated && last.since == scene.world.now,
                "the last probe has not ended, or ended at an earlier instant",
            )
        }
        ProbingEnd::Satisfied | ProbingEnd::NotAwaited => Err("that is not a limit".into()),
    }
}
