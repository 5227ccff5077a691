//! Second derivation of the causes for which tasks end and faults are reported.

use super::causes::Scene;
use super::probing;
use super::require::require;
use super::step::Step;
use super::world::{Known, World};
use apex_model::because::{Because, Cause, CircleLink};
use apex_model::effect::{Effect, Method};
use apex_model::event::{EventKind, SolverReport};
use apex_model::library::AgentDeclaration;
use apex_model::task::{Outcome, TaskId, TaskState};
use apex_model::value::Value;

type Checked = Result<(), String>;

/// Limits with their values, as stated in their source file.
const LIMITS: &str = include_str!("../../../crates/model/src/limits.rs");

/// Checks a decision about the whole agent.
pub(super) fn of_nobody(world: &World<'_>, step: &Step, because: &Because) -> Checked {
    match &because.cause {
        Cause::StrayAnswer { to } => {
            let number = to.rsplit(' ').next().and_then(|number| number.parse().ok()).unwrap_or_default();
            let asked = world.commands.contains_key(&number) && to.starts_with("command");
            require(!asked && !step.batch.events.is_empty(), "it was asked, or nothing came in")
        }
        Cause::InputRefused { message } => {
            let came = !step.batch.events.is_empty();
            let said = world.library.sources.iter().any(|source| source.text.contains("(publish"));
            require(!message.is_empty() && (came || said), "nothing came in")
        }
        Cause::NobodyHears { message } => require(!message.is_empty(), "it says nothing"),
        cause => of_expression_or_limit(world, because, cause),
    }
}

fn of_expression_or_limit(world: &World<'_>, because: &Because, cause: &Cause) -> Checked {
    match cause {
        Cause::ExpressionFailed { message } => {
            require(!message.is_empty() && because.place.is_some(), "it names no place or no reason")
        }
        Cause::LimitReached { limit, value } => {
            let line = LIMITS.lines().find(|line| line.contains(&format!("pub const {limit}:")));
            let stated = line.and_then(|line| line.split_once("= ")).map(|(_, number)| number.replace(['_', ';'], ""));
            // The agent's program may state a lower limit, which then applies.
            let word = limit.trim_end_matches("_MAX").to_lowercase().replace('_', "-");
            let mut declared = world.library.agents.iter().flat_map(|agent| lowered(world, agent));
            let lowered = declared.any(|(name, lowered)| name == word && lowered == value.to_string());
            require(lowered || stated == Some(value.to_string()), "no such limit, or it has another value")
        }
        other => Err(format!("{} is not a condition fault", other.kind())),
    }
}

/// Returns the words after `:limits` in the text of the agent's declaration, two by two.
fn lowered(world: &World<'_>, agent: &AgentDeclaration) -> Vec<(String, String)> {
    let source = usize::try_from(agent.place.file).ok().and_then(|file| world.library.sources.get(file));
    let skipped = (agent.place.line as usize).saturating_sub(1);
    let text: String =
        source.map(|source| source.text.lines().skip(skipped).collect::<Vec<_>>().join(" ")).unwrap_or_default();
    let Some((_, after)) = text.split_once(":limits") else { return Vec::new() };
    let inside = after.split(')').next().unwrap_or_default().replace('(', " ");
    let words: Vec<&str> = inside.split_whitespace().collect();
    words
        .chunks(2)
        .filter_map(|pair| Some((pair.first()?.trim_start_matches(':').to_string(), pair.get(1)?.to_string())))
        .collect()
}

/// Checks the fault of a task, whether the task fails because of it or continues.
pub(super) fn trouble(scene: &Scene<'_>) -> Checked {
    let because = scene.because;
    match &because.cause {
        Cause::ExpressionFailed { .. } | Cause::LimitReached { .. } => {
            of_expression_or_limit(scene.world, because, &because.cause)
        }
        Cause::NobodyHears { .. } | Cause::InputRefused { .. } => of_nobody(scene.world, scene.step, because),
        Cause::ProbingStopped { waiting, probes, reason } => {
            require(*waiting == scene.id, "another task waits")?;
            probing::limit(scene, *waiting, *probes, *reason)
        }
        Cause::WaitsInCircle { links } => circle(scene, links),
        // The cause of a failure that `on-failure` handles.
        _ => failed(scene, scene.own()?),
    }
}

/// Checks that the tasks wait in a circle: each waits for a resource held by an ancestor of the next one.
fn circle(scene: &Scene<'_>, links: &[CircleLink]) -> Checked {
    let world = scene.world;
    require(links.iter().any(|link| link.task == scene.id), "the task is not in its circle")?;
    for (index, link) in links.iter().enumerate() {
        let waiting = world.task(link.task)?;
        require(matches!(waiting.state, TaskState::Enabled | TaskState::Interrupted), "one of them does not wait")?;
        let holders = world.holders.get(&link.resource.to_string()).map(Vec::as_slice).unwrap_or_default();
        require(holders.iter().any(|(task, _)| *task == link.holder), "one of the holders does not hold it")?;
        let next = links.get((index + 1) % links.len()).ok_or("it is empty")?;
        require(world.is_above(link.holder, next.task), "a holder is not above the next one that waits")?;
    }
    Ok(())
}

/// Checks the transition to terminated.
pub(super) fn ended(scene: &Scene<'_>, own: &Known, from: TaskState, outcome: Option<&Outcome>) -> Checked {
    let outcome = outcome.ok_or("it has no outcome")?;
    let (world, now) = (scene.world, scene.world.now);
    let works = || require(from == TaskState::Ongoing, "it did not work");
    let primitive = |what: &str| {
        works()?;
        let template = world.primitive(own);
        require(matches!(own.method, Some(Method::Primitive(_))), "it is not a primitive")?;
        require(
            template.is_none_or(|template| format!("{template:?}").contains(what)),
            "its primitive says nothing of it",
        )
    };
    match &scene.because.cause {
        Cause::StepsEnded { last } => steps_ended(world, scene.id, *last),
        Cause::ItemsEnded { items, last } => {
            let own_items = world.children(scene.id).filter(|(_, child)| Some(child.created) >= own.began);
            let count = own_items.filter(|(_, child)| matches!(child.made, Cause::ItemOf { .. })).count() as u64;
            require(count == *items, "it has another number of items")?;
            steps_ended(world, scene.id, *last)
        }
        Cause::BuiltInDone { activity } => {
            works()?;
            let says = own.goal.as_ref().is_some_and(|goal| goal.to_string().starts_with(&format!("({activity}")));
            require(says && own.since == now, "it does something else, or began before")
        }
        Cause::CompletedAtOnce => {
            primitive("")?;
            let timed = world.primitive(own).is_some_and(|each| each.duration.is_some() || each.update.is_some());
            require(!timed && own.since == now, "its primitive takes time")
        }
        Cause::CompletedByForm => primitive("complete"),
        Cause::DurationElapsed { duration } => {
            primitive("")?;
            require(own.worked + (now - own.since) == *duration, "it worked for another time")
        }
        Cause::CommandAcknowledged { command } => {
            let answered =
                |kind: &EventKind| matches!(kind, EventKind::CommandAcknowledged(id, Ok(_)) if id == command);
            require(scene.step.batch.events.iter().any(|event| answered(&event.kind)), "no such answer came in")?;
            sent_by(world, command.0, scene.id).map(|_| ())
        }
        _ => ended_from_outside(scene, own, outcome),
    }
}

/// Checks ends by clauses, activities, operators and parents.
fn ended_from_outside(scene: &Scene<'_>, own: &Known, outcome: &Outcome) -> Checked {
    let (world, now) = (scene.world, scene.world.now);
    match &scene.because.cause {
        Cause::PlanArrived { .. } => plan_arrived(scene.step, &scene.because.cause),
        Cause::ConditionSatisfied { .. } => by_clause(scene, own, outcome),
        Cause::OutcomeMissed { .. } | Cause::ResultMissed { .. } => skipped(scene, own, outcome),
        Cause::Activity { .. } => scene.clause_or_activity(own, &[], &["terminate"]),
        Cause::OperatorAnswered { question, answer } => {
            let said = |kind: &EventKind| matches!(kind, EventKind::OperatorAnswered(id, value) if id == question && same_word(value, answer));
            require(scene.step.batch.events.iter().any(|event| said(&event.kind)), "no such answer came in")
        }
        Cause::OperatorSilent { question, default } => {
            let asked = world.questions.get(&question.0).ok_or("that was never asked")?;
            require(
                asked.0.is_some_and(|by| by <= now) && asked.1.as_ref() == Some(default),
                "it is not time, or the default differs",
            )
        }
        Cause::HandlerEnded { handler } => {
            let known = world.task(*handler)?;
            let made = known.made == Cause::HandlesFailure { of: scene.id };
            require(made && known.state == TaskState::Terminated && known.since == now, "that task did not handle it")?;
            require(known.outcome.as_ref() == Some(outcome), "that task ended in another way")
        }
        Cause::ProbingStopped { waiting, probes, reason } => {
            require(*outcome == Outcome::Cut, "it was not cut")?;
            probing::cut(scene, own, (*waiting, *probes, *reason))
        }
        Cause::ApplicationEnded { by } => {
            world.task(*by)?;
            require(
                scene.step.effects.iter().any(|effect| matches!(effect, Effect::EndApplication { .. })),
                "it continues",
            )
        }
        Cause::Stopped { reason } => require(!reason.is_empty(), "it says nothing"),
        Cause::ParentEnded { parent }
        | Cause::ParentRestarted { parent }
        | Cause::ParentFailed { parent }
        | Cause::PlanBegunAgain { parent } => {
            require(*outcome == Outcome::Cut, "it was not cut")?;
            require(own.parent == Some(*parent), "that is not its parent")?;
            let happens = match &scene.because.cause {
                Cause::ParentEnded { .. } => scene.moves_now(*parent, TaskState::Terminated),
                Cause::ParentRestarted { .. } => scene.moves_now(*parent, TaskState::Pending),
                _ => true,
            };
            require(happens, "nothing of the kind happens to the parent now")
        }
        _ => {
            let meant = match &scene.because.cause {
                Cause::ConditionViolated { clause } if clause == "precondition" => Outcome::PreconditionFailed,
                Cause::ConditionViolated { .. } => Outcome::InvariantViolated,
                _ => Outcome::Failure,
            };
            require(*outcome == meant, "its outcome is another")?;
            failed(scene, own)
        }
    }
}

/// Checks the end by a clause: with success, as skipped before the task has begun, as exited after that.
fn by_clause(scene: &Scene<'_>, own: &Known, outcome: &Outcome) -> Checked {
    scene.clause_or_activity(own, &["end-when", "skip-when", "exit-when"], &[])?;
    let begun = matches!(own.state, TaskState::Ongoing | TaskState::Interrupted);
    match (&*clause_of(scene.because), outcome) {
        ("end-when", Outcome::Success(_)) => Ok(()),
        ("exit-when", Outcome::Exited) => require(begun, "it had not begun"),
        ("exit-when" | "skip-when", Outcome::Skipped) => require(!begun, "it had begun"),
        _ => Err("its outcome is another".into()),
    }
}

/// Checks the end of a step that waits for an outcome or a result of another step that has ended differently.
fn skipped(scene: &Scene<'_>, own: &Known, outcome: &Outcome) -> Checked {
    require(*outcome == Outcome::Skipped && own.state == TaskState::Pending, "it was not skipped")?;
    let (Cause::OutcomeMissed { task, .. } | Cause::ResultMissed { task, .. }) = &scene.because.cause else {
        return Err("that skips nothing".into());
    };
    let known = scene.world.task(*task)?;
    require(known.parent == own.parent && known.state == TaskState::Terminated, "that sibling has not ended")?;
    match &scene.because.cause {
        Cause::OutcomeMissed { outcome: missed, .. } => {
            let states = known.outcome.as_ref().map(Outcome::states).unwrap_or_default();
            require(!states.contains(&missed.folded()), "that is its outcome")
        }
        _ => require(!matches!(known.outcome, Some(Outcome::Success(_))), "that task has a result"),
    }
}

fn clause_of(because: &Because) -> std::borrow::Cow<'static, str> {
    match &because.cause {
        Cause::ConditionSatisfied { clause } => clause.clone(),
        _ => "".into(),
    }
}

/// Checks the cause of a failure, including a handled one.
fn failed(scene: &Scene<'_>, own: &Known) -> Checked {
    let (world, now) = (scene.world, scene.world.now);
    let events = || scene.step.batch.events.iter().map(|event| &event.kind);
    match &scene.because.cause {
        Cause::ChildFailed { child } => {
            let known = world.task(*child)?;
            require(known.parent == Some(scene.id), "that is not its subtask")?;
            let failed = known.outcome.as_ref().is_some_and(Outcome::is_failure);
            require(failed && known.since == now, "that subtask did not fail now")
        }
        Cause::CommandFailed { command, reason } => {
            let refused = events().any(
                |kind| matches!(kind, EventKind::CommandAcknowledged(id, Err(said)) if id == command && said == reason),
            );
            require(refused, "no such answer came in")?;
            sent_by(world, command.0, scene.id).map(|_| ())
        }
        Cause::CommandTimedOut { command, patience } => {
            let sent = sent_by(world, command.0, scene.id)?;
            require(sent + *patience == now, "its time is not over now")
        }
        Cause::SolverFailed { request, reason } => {
            let failed = events().any(|kind| matches!(kind, EventKind::SolverReported(id, SolverReport::Failed(said)) if id == request && said == reason));
            require(failed, "no such answer came in")
        }
        Cause::SolverTimedOut { request, patience } => {
            let asked = world.requests.get(&request.0).ok_or("that was never asked")?;
            require(*asked + *patience == now, "its time is not over now")
        }
        Cause::NoMethod { goal } => {
            let served =
                |index: &apex_model::pattern::Pattern| *index == apex_model::pattern::Pattern::Literal(goal.clone());
            let known = world.library.procedures.iter().any(|each| served(&each.index));
            let primitive = world.library.primitives.iter().any(|each| served(&each.index));
            require(*goal != Value::nil() && !known && !primitive, "something serves exactly this goal")
        }
        Cause::ResourceExhausted { needed, left, .. } => {
            let numbers = needed.as_number().zip(left.as_number());
            require(numbers.is_some_and(|((needed, _), (left, _))| needed > left), "there is enough")
        }
        Cause::ConditionViolated { clause } => {
            let begun = matches!(own.state, TaskState::Ongoing);
            let right = match &**clause {
                "precondition" => true,
                "invariant" => begun,
                _ => false,
            };
            require(right && !scene.because.evidence.is_empty(), "it had not begun, or there is no evidence")
        }
        Cause::ResourceBusy { resource, holder } => {
            let holders = world.holders.get(&resource.to_string()).map(Vec::as_slice).unwrap_or_default();
            let granted = scene.step.effects.iter().any(|effect| {
                matches!(effect, Effect::Decided(decision)
                if decision.task == Some(*holder) && matches!(decision.because.cause, Cause::ResourcesGranted { .. }))
            });
            require(granted || holders.iter().any(|(task, _)| task == holder), "that task does not have it")
        }
        Cause::ResultDoesNotFit { .. } => {
            let binds = world.template(own).is_none_or(|(_, _, step)| step.binds.is_some());
            require(binds, "its step binds no result")
        }
        Cause::Activity { .. } => scene.clause_or_activity(own, &[], &["terminate"]),
        Cause::OperatorMute { question } => {
            let asked = world.questions.get(&question.0).ok_or("that was never asked")?;
            require(asked.0.is_some_and(|by| by <= now), "it is not time")
        }
        Cause::NobodyHears { message } => require(!message.is_empty(), "it says nothing"),
        cause => of_expression_or_limit(world, scene.because, cause),
    }
}

/// Returns true if two answers are equal; a text equals the word with the same spelling.
fn same_word(a: &Value, b: &Value) -> bool {
    let word = |value: &Value| value.to_string().trim_matches('"').to_lowercase();
    word(a) == word(b)
}

fn sent_by(world: &World<'_>, command: u64, task: TaskId) -> Result<apex_model::time::Time, String> {
    let (sender, at) = world.commands.get(&command).ok_or("that command was never sent")?;
    require(*sender == task, "another task sent that command").map(|()| *at)
}

/// Checks that step `last` ended now, and that all other steps have ended, except for those that repeat or respond.
fn steps_ended(world: &World<'_>, id: TaskId, last: Option<TaskId>) -> Checked {
    if let Some(last) = last {
        let known = world.task(last)?;
        require(known.parent == Some(id), "the last one is not its own")?;
        require(known.state == TaskState::Terminated && known.since == world.now, "the last one did not end now")?;
    }
    let living = world.children(id).filter(|(_, child)| child.state != TaskState::Terminated);
    let awaited = living.filter(|(_, child)| {
        let again =
            world.template(child).is_some_and(|(_, _, step)| step.repeating.is_some() || step.responding.is_some());
        !again
    });
    let count = awaited.count();
    require(count == 0, &format!("{count} of its subtasks live"))
}

/// Checks that the plan that the cause names arrived in the batch of this step.
pub(super) fn plan_arrived(step: &Step, cause: &Cause) -> Checked {
    let Cause::PlanArrived { request, solver } = cause else { return Err("it is not a plan".into()) };
    let came = step.batch.events.iter().any(|event| {
        matches!(&event.kind, EventKind::SolverReported(id, SolverReport::Plan(plan)) if id == request && plan.solver == *solver)
    });
    require(came, "no such plan came in")
}
