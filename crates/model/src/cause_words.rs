//! Texts of causes: made here and nowhere else, so that the trace, `apex why`, Sherpa and Python print the same.

use crate::because::{CircleLink, ConflictRule, EqualsRule, Share, Strength};
use crate::cause::Cause;
use crate::probing::{ordinal, stopped_text};
use crate::task::TaskId;
use crate::value::Value;

impl Cause {
    /// Returns the cause as text, after "because".
    pub fn text(&self) -> String {
        match self {
            Cause::InitialTask => "it is the agent's initial task".into(),
            Cause::ParentStarted { parent } => format!("{parent} started and has this step"),
            Cause::PlanPursued { parent } => format!("{parent} pursues the plan that arrived, which has this step"),
            Cause::PlanBegunAgain { parent } => format!("the plan of {parent} is a cycle and begins again"),
            Cause::ItemOf { parent } => format!("{parent} started and has this item in its forall"),
            Cause::Meanwhile { parent } => format!("this is done while {parent} waits for its plan"),
            Cause::Probes { waiting, number, limit } => {
                format!("{waiting} waits for a condition with :probing, and this is {}", ordinal(*number, *limit))
            }
            Cause::ProbingStopped { waiting, probes, reason } => {
                format!("{} (of {waiting})", stopped_text(*probes, *reason))
            }
            Cause::HandlesFailure { of } => format!("{of} failed and this is its on-failure"),
            Cause::Responding { answered } => {
                format!("{answered} answers the preceding event, and this task waits for the next one")
            }
            Cause::Repetition => "its step repeats".into(),
            Cause::NoPreconditions => "there is nothing to wait for".into(),
            Cause::PreconditionsSatisfied => "its preconditions hold".into(),
            Cause::PredecessorEnded { predecessor } => format!("{predecessor}, the step before it, ended"),
            Cause::ResultArrived { variable } => format!("?{variable} has a value"),
            Cause::IntervalElapsed => "its minimum interval has passed".into(),
            Cause::StartsOver => "it starts over, and its preconditions held before".into(),
            Cause::RepeatedEnabled => "it repeats :enabled".into(),
            Cause::ConditionSatisfied { clause } => format!("the condition of {clause} holds"),
            Cause::ResourcesGranted { resources } => granted_text(resources),
            Cause::Outranked { by, resource, rule, winner, loser } => {
                outranked_text(*by, resource, *rule, *winner, *loser)
            }
            Cause::ResourceExhausted { resource, needed, left } => {
                format!("{resource} does not suffice: the task needs {needed}, and {left} is left")
            }
            Cause::AncestorSuspended { ancestor } => format!("{ancestor} above it was suspended"),
            Cause::AncestorResumed { ancestor } => format!("{ancestor} above it was resumed"),
            Cause::Activity { by, activity } => format!("{by} executed ({activity})"),
            Cause::StepsEnded { last: Some(last) } => format!("all of its steps have ended, {last} as the last"),
            Cause::StepsEnded { last: None } => "it has no steps".into(),
            Cause::BuiltInDone { activity } => format!("({activity} ..) is done at once"),
            Cause::CompletedAtOnce => "its primitive takes no time".into(),
            Cause::CompletedByForm => "its primitive executed (complete)".into(),
            Cause::DurationElapsed { duration } => format!("its duration of {duration} is over"),
            _ => self.text_of_the_rest(),
        }
    }

    /// Returns the texts of ends from outside, choices, bindings and faults.
    fn text_of_the_rest(&self) -> String {
        match self {
            Cause::ItemsEnded { items, last } => items_text(*items, *last),
            Cause::CommandAcknowledged { command } => format!("command {} was acknowledged as done", command.0),
            Cause::CommandFailed { command, reason } => format!("command {} failed: {reason}", command.0),
            Cause::CommandTimedOut { command, patience } => {
                format!("command {} failed: no answer within {patience}", command.0)
            }
            Cause::ParentEnded { parent } => format!("{parent} above it ended"),
            Cause::ParentRestarted { parent } => format!("{parent} above it starts over"),
            Cause::ParentFailed { parent } => format!("{parent} above it failed, and its on-failure takes over"),
            Cause::ChildFailed { child } => format!("its subtask {child} failed"),
            Cause::FailureHandled { by } => format!("{by} handles its failure"),
            Cause::HandlerEnded { handler } => format!("{handler} handled its failure and ended"),
            Cause::MostSpecific { candidates: 1 } => "it is the only match".into(),
            Cause::MostSpecific { candidates } => format!("it is the most specific of {candidates} matches"),
            Cause::FirstOfEquals { candidates, equals, rule } => {
                let of = match equals == candidates {
                    true => format!("of {candidates} equally specific matches it is"),
                    false => format!("of {candidates} matches {equals} are the most specific, and it is"),
                };
                let rule = match rule {
                    EqualsRule::MadeInFlight => "the plan made in flight",
                    EqualsRule::Procedure => "a procedure, which precedes primitives",
                    EqualsRule::FirstInLibrary => "the first in the library",
                };
                format!("{of} {rule}")
            }
            Cause::BuiltIn { activity } => format!("({activity} ..) is built in"),
            Cause::ForAll { items } => format!("its forall has {items} items"),
            Cause::NoProcedureMatched => "no procedure or primitive matches, and a solver serves the goal".into(),
            Cause::PlanArrived { request, solver } => format!("{solver} answered request {}", request.0),
            Cause::NoMethod { goal } => format!("no procedure, primitive or solver serves {goal}"),
            Cause::SolverTimedOut { request, patience } => {
                format!("solver request {} failed: no answer within {patience}", request.0)
            }
            Cause::SolverFailed { request, reason } => format!("solver request {} failed: {reason}", request.0),
            Cause::Binding { clause } => format!("{clause} gave it"),
            Cause::FormRan { clause } => format!("a form of its {clause} caused this"),
            Cause::SentAgain => "it was withdrawn at the interruption, and the task continues".into(),
            Cause::ExpressionFailed { message } => format!("an expression failed: {message}"),
            Cause::ResultDoesNotFit { value } => format!("the result {value} does not fit the pattern after =>"),
            Cause::InputRefused { message } => message.clone(),
            Cause::RecordingLost { reason } => format!("the flight is not being recorded: {reason}"),
            Cause::StrayAnswer { to } => format!("an answer arrived for {to}, which was never asked"),
            Cause::LimitReached { limit, value } => format!("the limit {limit} = {value} was reached"),
            Cause::OperatorAnswered { answer, .. } => format!("the operator answered {answer}"),
            Cause::OperatorSilent { default, .. } => {
                format!("the operator did not answer in time, and the default {default} is taken")
            }
            Cause::OperatorMute { .. } => "the operator did not answer in time, and there is no default".into(),
            Cause::ApplicationEnded { by } => format!("{by} ended the application"),
            Cause::Stopped { reason } => format!("the application ends: {reason}"),
            Cause::NobodyHears { message } => message.clone(),
            Cause::WaitsInCircle { links } => circle_text(links),
            Cause::ConditionViolated { clause } => format!("its {clause} does not hold"),
            Cause::OutcomeMissed { task, outcome } => {
                format!("its waitfor can no longer hold: {task} has ended, and is not `{outcome}`")
            }
            Cause::ResultMissed { task, variable } => {
                format!("?{variable} can no longer get a value: {task} has ended without success")
            }
            Cause::ResourceBusy { resource, holder } => {
                format!("{holder} has {resource}, and its profile says :refuse-if-busy")
            }
            Cause::CommandMoved { command } => format!("this is the state of command {}", command.0),
            Cause::LevelChanged { resource } => format!("this is the remaining amount of {resource}"),
            Cause::ExecutiveFault { message } => format!("{message}: this is a fault of the executive"),
            // `text` has the texts of the others.
            _ => String::new(),
        }
    }
}

fn granted_text(shares: &[Share]) -> String {
    match shares {
        [] => "it needs no resources".into(),
        some => format!("it was granted {}", some.iter().map(Share::text).collect::<Vec<_>>().join(", ")),
    }
}

fn circle_text(links: &[CircleLink]) -> String {
    let sentence = |link: &CircleLink| format!("{} waits for {} of {}", link.task, link.resource, link.holder);
    links.iter().map(sentence).collect::<Vec<_>>().join(", ")
}

fn items_text(items: u64, last: Option<TaskId>) -> String {
    match last {
        None => "its forall list is empty".into(),
        Some(last) => format!("all {items} items of its forall have ended, {last} as the last"),
    }
}

fn outranked_text(by: TaskId, resource: &Value, rule: ConflictRule, winner: Strength, loser: Strength) -> String {
    match rule {
        ConflictRule::Rank => format!("{by} comes first on {resource} (rank {winner} before {loser})"),
        ConflictRule::Priority => format!("{by} outranks it on {resource} (priority {winner} > {loser})"),
        ConflictRule::Incumbent => format!("{by} holds {resource} and defends it (priority {winner} against {loser})"),
        ConflictRule::Begun => format!("{by} has begun and continues with {resource} (both priority {winner})"),
        ConflictRule::WrittenOrder => {
            format!("{by} precedes it in the text and takes {resource} (both priority {winner})")
        }
        ConflictRule::CreationOrder => format!("{by} is older and takes {resource} (both priority {winner})"),
        ConflictRule::GoesBefore { whom: successor } => {
            format!(
                "{by} outranks it on {resource} (priority {winner} of {successor}, which it precedes by rank, > {loser})"
            )
        }
        ConflictRule::Capacity => format!("too little of {resource} is left, because {by} holds it"),
    }
}
