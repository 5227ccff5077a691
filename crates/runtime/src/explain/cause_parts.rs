//! The parts of every kind of cause, in the order in which its text names them.

use super::cause::{CausePart, PartValue};
use apex_model::because::ConflictRule;
use apex_model::cause::Cause;
use apex_model::probing::ProbingEnd;

/// Returns the parts of `cause`; none for causes that are their kind alone.
pub(super) fn parts(cause: &Cause) -> Vec<CausePart> {
    of_task_tree(cause).or_else(|| of_resources(cause)).or_else(|| of_outside(cause)).unwrap_or_default()
}

fn part(role: &'static str, value: impl Into<PartValue>) -> CausePart {
    CausePart { role, value: value.into() }
}

fn name(role: &'static str, name: &str) -> CausePart {
    CausePart { role, value: PartValue::Name { name: name.into() } }
}

fn message(message: &str) -> CausePart {
    CausePart { role: "message", value: PartValue::Message { message: message.into() } }
}

/// Returns the parts of causes that name tasks above, below and next to, and clauses of PDL; `None` for other causes.
fn of_task_tree(cause: &Cause) -> Option<Vec<CausePart>> {
    let parts = match cause {
        Cause::ParentStarted { parent }
        | Cause::PlanPursued { parent }
        | Cause::PlanBegunAgain { parent }
        | Cause::ItemOf { parent }
        | Cause::Meanwhile { parent }
        | Cause::ParentEnded { parent }
        | Cause::ParentRestarted { parent }
        | Cause::ParentFailed { parent } => vec![part("parent", *parent)],
        Cause::Probes { waiting, number, limit } => {
            let limit = limit.map(|limit| part("limit", limit));
            [part("waiting-task", *waiting), part("number", *number)].into_iter().chain(limit).collect()
        }
        Cause::ProbingStopped { waiting, probes, reason } => {
            let reason = match reason {
                ProbingEnd::Satisfied => "satisfied",
                ProbingEnd::NotAwaited => "not-awaited",
                ProbingEnd::TimeLimit(_) => "time-limit",
                ProbingEnd::CountLimit(_) => "count-limit",
            };
            vec![part("waiting-task", *waiting), part("probes", *probes), name("reason", reason)]
        }
        Cause::HandlesFailure { of } => vec![part("failed", *of)],
        Cause::Responding { answered } => vec![part("answered", *answered)],
        Cause::PredecessorEnded { predecessor } => vec![part("predecessor", *predecessor)],
        Cause::ResultArrived { variable } => vec![name("variable", variable.printed())],
        Cause::ConditionSatisfied { clause }
        | Cause::ConditionViolated { clause }
        | Cause::Binding { clause }
        | Cause::FormRan { clause } => {
            vec![name("clause", clause)]
        }
        Cause::AncestorSuspended { ancestor } | Cause::AncestorResumed { ancestor } => {
            vec![part("ancestor", *ancestor)]
        }
        Cause::Activity { by, activity } => vec![part("by", *by), name("activity", activity)],
        Cause::StepsEnded { last } => last.iter().map(|last| part("last", *last)).collect(),
        Cause::ItemsEnded { items, last } => {
            let last = last.iter().map(|last| part("last", *last));
            std::iter::once(part("items", *items)).chain(last).collect()
        }
        Cause::BuiltInDone { activity } | Cause::BuiltIn { activity } => vec![name("activity", activity)],
        Cause::ChildFailed { child } => vec![part("child", *child)],
        Cause::FailureHandled { by } | Cause::ApplicationEnded { by } => vec![part("by", *by)],
        Cause::OutcomeMissed { task, outcome } => vec![part("task", *task), name("outcome", outcome.printed())],
        Cause::ResultMissed { task, variable } => vec![part("task", *task), name("variable", variable.printed())],
        Cause::HandlerEnded { handler } => vec![part("handler", *handler)],
        Cause::DurationElapsed { duration } => vec![part("duration", *duration)],
        Cause::MostSpecific { candidates } => vec![part("candidates", *candidates)],
        Cause::FirstOfEquals { candidates, equals, rule } => {
            vec![part("candidates", *candidates), part("equals", *equals), part("rule", *rule)]
        }
        Cause::ForAll { items } => vec![part("items", *items)],
        Cause::NoMethod { goal } => vec![part("goal", goal)],
        Cause::ResultDoesNotFit { value } => vec![part("value", value)],
        _ => return None,
    };
    Some(parts)
}

/// Returns the parts of causes that name resources; `None` for other causes.
fn of_resources(cause: &Cause) -> Option<Vec<CausePart>> {
    let parts = match cause {
        Cause::ResourcesGranted { resources } => resources.iter().map(|share| part("granted", share)).collect(),
        Cause::Outranked { by, resource, rule, winner, loser } => {
            let before = match rule {
                ConflictRule::GoesBefore { whom } => Some(part("goes-before", *whom)),
                _ => None,
            };
            let parts = [
                part("by", *by),
                part("resource", resource),
                part("rule", *rule),
                part("winner", *winner),
                part("loser", *loser),
            ];
            parts.into_iter().chain(before).collect()
        }
        Cause::WaitsInCircle { links } => links
            .iter()
            .flat_map(|link| [part("waits", link.task), part("resource", &link.resource), part("holder", link.holder)])
            .collect(),
        Cause::LevelChanged { resource } => vec![name("resource", resource.printed())],
        Cause::ResourceBusy { resource, holder } => vec![part("resource", resource), part("holder", *holder)],
        Cause::ResourceExhausted { resource, needed, left } => {
            vec![part("resource", resource), part("needed", needed), part("left", left)]
        }
        _ => return None,
    };
    Some(parts)
}

/// Returns the parts of causes that name vehicles, solvers, operators, and faults; `None` for other causes.
fn of_outside(cause: &Cause) -> Option<Vec<CausePart>> {
    let parts = match cause {
        Cause::CommandAcknowledged { command } | Cause::CommandMoved { command } => vec![part("command", command.0)],
        Cause::CommandFailed { command, reason } => vec![part("command", command.0), message(reason)],
        Cause::CommandTimedOut { command, patience } => {
            vec![part("command", command.0), part("patience", *patience)]
        }
        Cause::PlanArrived { request, solver } => vec![part("request", request.0), name("solver", solver.printed())],
        Cause::SolverFailed { request, reason } => vec![part("request", request.0), message(reason)],
        Cause::SolverTimedOut { request, patience } => {
            vec![part("request", request.0), part("patience", *patience)]
        }
        Cause::OperatorAnswered { question, answer } => vec![part("question", question.0), part("answer", answer)],
        Cause::OperatorSilent { question, default } => vec![part("question", question.0), part("default", default)],
        Cause::OperatorMute { question } => vec![part("question", question.0)],
        Cause::LimitReached { limit, value } => vec![name("limit", limit), part("value", *value)],
        Cause::StrayAnswer { to } => vec![name("to", to)],
        Cause::ExpressionFailed { message: text }
        | Cause::InputRefused { message: text }
        | Cause::NobodyHears { message: text }
        | Cause::ExecutiveFault { message: text }
        | Cause::RecordingLost { reason: text }
        | Cause::Stopped { reason: text } => vec![message(text)],
        _ => return None,
    };
    Some(parts)
}

#[cfg(test)]
mod tests {
    use super::*;
    use apex_model::because::Strength;
    use apex_model::task::TaskId;
    use apex_model::value::Value;

    #[test]
    fn a_lost_conflict_names_winner_resource_rule_and_strengths() {
        let (winner, loser) = (Strength { priority: 5.0, interrupt_cost: 0.5 }, Strength::claiming(3.0));
        let rule = ConflictRule::GoesBefore { whom: TaskId(7) };
        let cause = Cause::Outranked { by: TaskId(4), resource: Value::symbol("camera-1"), rule, winner, loser };
        let json = serde_json::to_value(parts(&cause)).unwrap();
        let expected = serde_json::json!([
            {"role": "by", "type": "task", "task": "T4"},
            {"role": "resource", "type": "form", "form": "camera-1"},
            {"role": "rule", "type": "name", "name": "goes-before"},
            {"role": "winner", "type": "strength", "priority": 5.0, "interrupt_cost": 0.5},
            {"role": "loser", "type": "strength", "priority": 3.0, "interrupt_cost": 0.0},
            {"role": "goes-before", "type": "task", "task": "T7"},
        ]);
        assert_eq!(json, expected);
    }

    #[test]
    fn every_task_and_number_of_the_text_is_a_part() {
        let cause = Cause::CommandTimedOut {
            command: apex_model::effect::CommandId(12),
            patience: apex_model::time::Duration(2_500_000_000),
        };
        let json = serde_json::to_value(parts(&cause)).unwrap();
        assert_eq!(json[0]["number"], 12);
        assert_eq!(json[1]["seconds"], 2.5);
        assert!(parts(&Cause::Repetition).is_empty());
    }
}
