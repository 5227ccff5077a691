//! Checks of evidence: samples, messages, ends and states on which a cause is based are searched in the record.

use super::numbers;
use super::require::require;
use super::step::Step;
use super::thresholds::Thresholds;
use super::world::World;
use apex_model::because::{Because, Evidence};
use apex_model::condition::{Condition, ConditionKind, Constraint, MeasurementCondition, Relation};
use apex_model::effect::{DecisionKind, Effect};
use apex_model::pattern::Pattern;
use apex_model::source::Place;
use apex_model::task::{Outcome, TaskId, TaskState};
use apex_model::time::Time;
use apex_model::value::Value;

/// Looks for all evidence of `because`, which `task` may use.
pub(super) fn check(world: &World<'_>, step: &Step, task: TaskId, because: &Because) -> Result<(), String> {
    let conditions = because.place.map(|place| conditions_at(world, place)).unwrap_or_default();
    let mut leaves = Vec::new();
    conditions.iter().for_each(|condition| collect(condition, &mut leaves));
    for evidence in because.evidence.iter() {
        one(world, step, task, evidence, &leaves).map_err(|what| format!("{}: {what}", evidence.text()))?;
    }
    // All conditions of a clause hold together: each one that compares samples is based on a sample.
    let measured = |condition: &&&Condition| matches!(condition.kind, ConditionKind::Measurement(_));
    let together = conditions.len() > 1 && !because.evidence.is_empty();
    for condition in conditions.iter().filter(measured).take(if together { usize::MAX } else { 0 }) {
        let rests = because.evidence.iter().any(|evidence| match evidence {
            Evidence::Sample { variable, .. } => is_of(&variable.to_string(), &condition.kind),
            Evidence::Estimate(_) | Evidence::Aggregate(_) | Evidence::Run { .. } => true,
            _ => false,
        });
        require(rests, "one of several conditions rests on no sample")?;
    }
    Ok(())
}

pub(super) fn one(
    world: &World<'_>,
    step: &Step,
    task: TaskId,
    evidence: &Evidence,
    leaves: &[&ConditionKind],
) -> Result<(), String> {
    match evidence {
        Evidence::Sample { variable, value, at } => {
            in_time(world, *at)?;
            let variable = variable.to_string();
            was_measured(world, &variable, value, *at)?;
            meets_a_threshold(&Thresholds { world, task }, &variable, value, leaves)?;
            in_window(world, task, *at, leaves)
        }
        Evidence::Event { form, at, .. } => {
            in_time(world, *at)?;
            let said = world.messages.iter().any(|(when, known)| when == at && known == form);
            require(said || !is_outside(world, "(cogevent"), "no such message then")?;
            let fits = leaves
                .iter()
                .any(|leaf| matches!(leaf, ConditionKind::Event { pattern, .. } if may_fit(pattern, form)));
            require(leaves.is_empty() || fits, "the condition waits for another message")?;
            in_window(world, task, *at, leaves)
        }
        Evidence::TaskEnd { task, at } => {
            let ended = |(when, _, to): &(Time, TaskState, TaskState)| when == at && *to == TaskState::Terminated;
            let before = world.task(*task)?.moves.iter().any(ended);
            require(before || *at == world.now && ends_in(step, *task), "it did not end then")
        }
        Evidence::TaskState { task, state, at } => {
            in_time(world, *at)?;
            let word = state.to_string();
            let word = if word == "resumed" { "ongoing" } else { word.as_str() };
            let known = world.task(*task)?;
            let moved = known.moves.iter().any(|(when, _, to)| when == at && to.word() == word);
            let was = known.moves.iter().rfind(|(when, ..)| when <= at).map_or(TaskState::Pending, |(_, _, to)| *to);
            let ended_as = known.outcome.as_ref().is_some_and(|outcome| is_outcome(outcome, word));
            require(moved || was.word() == word || was == TaskState::Terminated && ended_as, "it was in another state")
        }
        Evidence::Run { variable, start, end, samples } => {
            in_time(world, *end)?;
            require(start <= end, "it ends before it begins")?;
            let Some(known) = world.samples.get(&variable.to_string()) else {
                return require(!is_outside(world, "(publish"), "no such variable was measured");
            };
            let inside = known.iter().filter(|(at, _)| at >= start && at <= end).count() as u64;
            require(known.iter().any(|(at, _)| at == start), "no sample at its start")?;
            require(known.iter().any(|(at, _)| at == end), "no sample at its end")?;
            require(*samples >= 1 && *samples <= inside, "it has fewer samples in the record")
        }
        Evidence::Instant { since, at } => {
            in_time(world, *at)?;
            require(since.is_none_or(|since| since <= *at), "it ends before it begins")
        }
        Evidence::Function { what, value, at } => {
            require(!what.is_empty() && value.is_true(), "it is not true")?;
            require(*at == world.now, "it is evidence of another instant")
        }
        Evidence::Absence { what, at } => {
            require(!what.is_empty(), "nothing is named")?;
            in_time(world, *at)?;
            // A past span without evidence remains past, but that something has not happened is stated about the present.
            require(*at == world.now || !is_outside(world, "(:absent "), "it is evidence of another instant")
        }
        Evidence::Estimate(estimate) => numbers::estimate(world, estimate),
        Evidence::Aggregate(aggregate) => numbers::aggregate(world, aggregate),
    }
}

/// Returns true if no source of the program contains `word`, the beginning of a form whose facts the record may lack.
fn is_outside(world: &World<'_>, word: &str) -> bool {
    !world.library.sources.iter().any(|source| source.text.contains(word))
}

pub(super) fn in_time(world: &World<'_>, at: Time) -> Result<(), String> {
    require(at <= world.now, "it is evidence of the future")
}

/// Returns true if the task ends in this step, after the present effect.
pub(super) fn ends_in(step: &Step, task: TaskId) -> bool {
    step.effects.iter().any(|effect| moves(effect, task) == Some(TaskState::Terminated))
}

/// Returns the state to which an effect moves the task.
pub(super) fn moves(effect: &Effect, task: TaskId) -> Option<TaskState> {
    match effect {
        Effect::Decided(decision) if decision.task == Some(task) => match &decision.kind {
            DecisionKind::Transition { to, .. } => Some(*to),
            _ => None,
        },
        _ => None,
    }
}

pub(super) fn was_measured(world: &World<'_>, variable: &str, value: &Value, at: Time) -> Result<(), String> {
    let Some(known) = world.samples.get(variable) else {
        return require(!is_outside(world, "(publish"), "no such variable was measured");
    };
    let close = |other: &Value| match (value.as_number(), other.as_number()) {
        // Bare numbers of a declared variable are in its unit, so their SI value differs.
        (Some((_, a)), Some((_, b))) if a != b => true,
        (Some((a, _)), Some((b, _))) => (a - b).abs() <= 1e-9 * a.abs().max(1.0),
        _ => value == other,
    };
    require(known.iter().any(|(when, other)| *when == at && close(other)), "no such sample then")
}

/// Returns true if the condition is about the attribute of this variable; objects are not compared.
pub(super) fn is_of(variable: &str, leaf: &ConditionKind) -> bool {
    match leaf {
        ConditionKind::Measurement(measurement) => {
            variable.trim_start_matches('(').starts_with(measurement.variable.attribute.printed())
        }
        _ => false,
    }
}

/// Checks that a condition that compares the variable with a number holds for the sample.
fn meets_a_threshold(
    thresholds: &Thresholds<'_, '_>,
    variable: &str,
    value: &Value,
    leaves: &[&ConditionKind],
) -> Result<(), String> {
    let of_variable = |leaf: &&ConditionKind| is_of(variable, leaf);
    let mut relevant = leaves.iter().copied().filter(|leaf| of_variable(leaf)).peekable();
    if leaves.is_empty() || relevant.peek().is_none() {
        return require(leaves.is_empty(), "the condition waits for another variable");
    }
    let holds = relevant.any(|leaf| match leaf {
        ConditionKind::Measurement(measurement) => holds_of(thresholds, measurement, value) != Some(false),
        _ => false,
    });
    require(holds, "it does not meet the condition's threshold")
}

/// Returns true if the measurement meets the condition's comparisons with numbers; `None` if other constraints decide.
pub(super) fn holds_of(
    thresholds: &Thresholds<'_, '_>,
    measurement: &MeasurementCondition,
    value: &Value,
) -> Option<bool> {
    let meets = |constraint: &Constraint| {
        let Constraint::Compare { relation, right, tolerance: None } = constraint else { return None };
        let ((own, a), (wanted, b)) = value.as_number().zip(thresholds.number(right))?;
        (a == b).then_some(match relation {
            Relation::Equal => own == wanted,
            Relation::Different => own != wanted,
            Relation::Less => own < wanted,
            Relation::LessOrEqual => own <= wanted,
            Relation::Greater => own > wanted,
            Relation::GreaterOrEqual => own >= wanted,
        })
    };
    let met: Vec<Option<bool>> = measurement.value.iter().map(meets).collect();
    if met.contains(&Some(false)) {
        return Some(false);
    }
    if met.contains(&None) { None } else { Some(true) }
}

/// Checks that the evidence is not older than the task, unless the condition states another window.
fn in_window(world: &World<'_>, task: TaskId, at: Time, leaves: &[&ConditionKind]) -> Result<(), String> {
    let says_otherwise = leaves.iter().any(|leaf| match leaf {
        ConditionKind::Measurement(measurement) => {
            !measurement.timestamp.is_empty() || measurement.estimation.is_some()
        }
        ConditionKind::Event { timing, .. } => *timing != Default::default(),
        _ => true,
    });
    let known = world.task(task)?;
    // A repeating step answers messages that arrived while it was busy, so evidence counts since its first instance began.
    let of_messages = leaves.iter().all(|leaf| matches!(leaf, ConditionKind::Event { .. }));
    let step = world.template(known).map(|(_, _, step)| step);
    let keeps = step.and_then(|step| step.repeating.as_ref()).is_some_and(|clause| !clause.drop_missed);
    let first = known.moves.first().map(|(when, ..)| *when).filter(|_| of_messages && keeps);
    let created = first.map_or(known.created, |first| first.min(known.created));
    require(leaves.is_empty() || says_otherwise || at >= created, "it is older than the task")
}

/// Returns true if the message may fit the pattern: only fixed words are compared.
fn may_fit(pattern: &Pattern, value: &Value) -> bool {
    match (pattern, value.as_list()) {
        (Pattern::Literal(literal), _) => literal.matches(value),
        (Pattern::List(parts), Some(items)) => {
            let open = parts.iter().any(|part| matches!(part, Pattern::Segment { .. } | Pattern::Guard(_)));
            open || parts.len() == items.len() && parts.iter().zip(items).all(|(part, item)| may_fit(part, item))
        }
        (Pattern::List(_), None) => false,
        _ => true,
    }
}

/// Adds to `leaves` the parts of a condition that can be evidence.
fn collect<'a>(condition: &'a Condition, leaves: &mut Vec<&'a ConditionKind>) {
    match &condition.kind {
        ConditionKind::And(parts, _)
        | ConditionKind::Or(parts, _)
        | ConditionKind::InOrder(parts, _)
        | ConditionKind::Allen { parts, .. } => parts.iter().for_each(|part| collect(part, leaves)),
        ConditionKind::Probing { condition, .. } => collect(condition, leaves),
        leaf => leaves.push(leaf),
    }
}

/// Returns the condition at `place`, and those of its waitfor that hold together with it, because they are reported together.
pub(super) fn conditions_at<'a>(world: &World<'a>, place: Place) -> Vec<&'a Condition> {
    let library = world.library;
    let at = |condition: &&Condition| condition.place == place;
    let mut steps = library.procedures.iter().flat_map(|procedure| &procedure.steps);
    if let Some(step) = steps.find(|step| step.waitfor.first().is_some_and(|first| first.place == place)) {
        return step.waitfor.iter().collect();
    }
    let found = library.procedures.iter().find_map(|procedure| {
        let steps = procedure.steps.iter();
        let own = [&procedure.transitions].into_iter().chain(steps.map(|step| &step.transitions)).flat_map(|clauses| {
            [
                &clauses.end_when,
                &clauses.restart_when,
                &clauses.resume_when,
                &clauses.suspend_when,
                &clauses.suspend_until,
                &clauses.skip_when,
                &clauses.exit_when,
                &clauses.precondition,
                &clauses.invariant,
            ]
            .into_iter()
            .flat_map(|clause| clause.as_deref())
        });
        own.into_iter().find(at)
    });
    found.into_iter().collect()
}

/// Returns true if `word` names the way in which a task ended, as conditions write it.
fn is_outcome(outcome: &Outcome, word: &str) -> bool {
    match outcome {
        Outcome::Success(_) => word == "succeeded",
        Outcome::Failure => word == "failed",
        Outcome::Cut => word == "cut",
        Outcome::Skipped => word == "skipped",
        Outcome::Exited => word == "exited",
        Outcome::PreconditionFailed => ["failed", "precondition-failed"].contains(&word),
        Outcome::InvariantViolated => ["failed", "invariant-violated"].contains(&word),
    }
}
