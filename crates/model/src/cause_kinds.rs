//! Names of the kinds of causes, for other programs. They are part of the format of record and trace.

use crate::cause::Cause;

impl Cause {
    /// Returns the name of the cause's kind: `resources-granted`.
    pub fn kind(&self) -> &'static str {
        match self {
            Cause::InitialTask => "initial-task",
            Cause::ParentStarted { .. } => "parent-started",
            Cause::PlanPursued { .. } => "plan-pursued",
            Cause::PlanBegunAgain { .. } => "plan-begun-again",
            Cause::ItemOf { .. } => "item-of",
            Cause::Meanwhile { .. } => "meanwhile",
            Cause::Probes { .. } => "probes",
            Cause::ProbingStopped { .. } => "probing-stopped",
            Cause::HandlesFailure { .. } => "handles-failure",
            Cause::Responding { .. } => "responding",
            Cause::Repetition => "repetition",
            Cause::NoPreconditions => "no-preconditions",
            Cause::PreconditionsSatisfied => "preconditions-satisfied",
            Cause::PredecessorEnded { .. } => "predecessor-ended",
            Cause::ResultArrived { .. } => "result-arrived",
            Cause::IntervalElapsed => "interval-elapsed",
            Cause::StartsOver => "starts-over",
            Cause::RepeatedEnabled => "repeated-enabled",
            Cause::ConditionSatisfied { .. } => "condition-satisfied",
            Cause::ResourcesGranted { .. } => "resources-granted",
            Cause::Outranked { .. } => "outranked",
            Cause::ResourceExhausted { .. } => "resource-exhausted",
            Cause::AncestorSuspended { .. } => "ancestor-suspended",
            Cause::AncestorResumed { .. } => "ancestor-resumed",
            Cause::Activity { .. } => "activity",
            Cause::StepsEnded { .. } => "steps-ended",
            Cause::ItemsEnded { .. } => "items-ended",
            Cause::BuiltInDone { .. } => "built-in-done",
            Cause::CompletedAtOnce => "completed-at-once",
            Cause::CompletedByForm => "completed-by-form",
            Cause::DurationElapsed { .. } => "duration-elapsed",
            Cause::CommandAcknowledged { .. } => "command-acknowledged",
            Cause::CommandFailed { .. } => "command-failed",
            Cause::CommandTimedOut { .. } => "command-timed-out",
            Cause::ParentEnded { .. } => "parent-ended",
            Cause::ParentRestarted { .. } => "parent-restarted",
            Cause::ParentFailed { .. } => "parent-failed",
            Cause::ChildFailed { .. } => "child-failed",
            Cause::FailureHandled { .. } => "failure-handled",
            Cause::HandlerEnded { .. } => "handler-ended",
            Cause::MostSpecific { .. } => "most-specific",
            Cause::FirstOfEquals { .. } => "first-of-equals",
            Cause::BuiltIn { .. } => "built-in",
            Cause::ForAll { .. } => "for-all",
            Cause::NoProcedureMatched => "no-procedure-matched",
            Cause::PlanArrived { .. } => "plan-arrived",
            Cause::NoMethod { .. } => "no-method",
            Cause::SolverFailed { .. } => "solver-failed",
            Cause::SolverTimedOut { .. } => "solver-timed-out",
            _ => self.kind_of_the_rest(),
        }
    }

    /// Returns the kinds about bindings, faults, operators, and the agent's own publications.
    fn kind_of_the_rest(&self) -> &'static str {
        match self {
            Cause::Binding { .. } => "binding",
            Cause::FormRan { .. } => "form-ran",
            Cause::SentAgain => "sent-again",
            Cause::ExpressionFailed { .. } => "expression-failed",
            Cause::ResultDoesNotFit { .. } => "result-does-not-fit",
            Cause::InputRefused { .. } => "input-refused",
            Cause::StrayAnswer { .. } => "stray-answer",
            Cause::LimitReached { .. } => "limit-reached",
            Cause::OperatorAnswered { .. } => "operator-answered",
            Cause::OperatorSilent { .. } => "operator-silent",
            Cause::OperatorMute { .. } => "operator-mute",
            Cause::ApplicationEnded { .. } => "application-ended",
            Cause::Stopped { .. } => "stopped",
            Cause::NobodyHears { .. } => "nobody-hears",
            Cause::WaitsInCircle { .. } => "waits-in-circle",
            Cause::ConditionViolated { .. } => "condition-violated",
            Cause::OutcomeMissed { .. } => "outcome-missed",
            Cause::ResultMissed { .. } => "result-missed",
            Cause::ResourceBusy { .. } => "resource-busy",
            Cause::CommandMoved { .. } => "command-moved",
            Cause::LevelChanged { .. } => "level-changed",
            Cause::ExecutiveFault { .. } => "executive-fault",
            Cause::RecordingLost { .. } => "recording-lost",
            // `kind` has the names of the other causes.
            _ => "",
        }
    }
}
