//! The kinds of causes. `docs/reference/trace.md` lists them with their meaning; a test compares the names of the kinds.

use crate::because::{CircleLink, ConflictRule, EqualsRule, Share, Strength};
use crate::effect::{CommandId, QuestionId, SolveRequestId};
use crate::probing::ProbingEnd;
use crate::symbol::Symbol;
use crate::task::TaskId;
use crate::time::Duration;
use crate::value::Value;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// Causes of decisions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Cause {
    /// The agent started with this goal.
    InitialTask,
    /// The parent became ongoing, and its procedure has this step.
    ParentStarted {
        /// The parent.
        parent: TaskId,
    },
    /// The parent's plan arrived while the parent was ongoing, and has this step.
    PlanPursued {
        /// The parent.
        parent: TaskId,
    },
    /// The parent's plan is a cycle, and begins again.
    PlanBegunAgain {
        /// The parent.
        parent: TaskId,
    },
    /// The parent's `forall` has this item.
    ItemOf {
        /// The parent.
        parent: TaskId,
    },
    /// The task works while its parent waits for a plan.
    Meanwhile {
        /// The parent.
        parent: TaskId,
    },
    /// A task waits for a condition with `:probing`, and this task is one of its probes.
    Probes {
        /// The task that waits.
        waiting: TaskId,
        /// Number of the probe, from 1.
        number: u64,
        /// Greatest number of probes.
        limit: Option<u64>,
    },
    /// No further probe is pursued for a condition with `:probing`.
    ProbingStopped {
        /// The task that waits, or waited.
        waiting: TaskId,
        /// Number of probes that were begun.
        probes: u64,
        /// Reason.
        reason: ProbingEnd,
    },
    /// This is the `on-failure` of a task that failed.
    HandlesFailure {
        /// The task that failed.
        of: TaskId,
    },
    /// A `responding` step answered an event; a new task waits for the next one.
    Responding {
        /// The task that answers the event.
        answered: TaskId,
    },
    /// The step repeats: its task ended, and is pending again.
    Repetition,
    /// The task has no preconditions.
    NoPreconditions,
    /// The preconditions hold.
    PreconditionsSatisfied,
    /// The preceding step of a sequence ended.
    PredecessorEnded {
        /// That step's task.
        predecessor: TaskId,
    },
    /// The result of another step, which the task uses, exists now.
    ResultArrived {
        /// The variable, without `?`.
        variable: Symbol,
    },
    /// Its `:with-min-interval` is over.
    IntervalElapsed,
    /// The task was made to start over, and its preconditions held already.
    StartsOver,
    /// The step repeats with `:enabled`: its preconditions are not checked again.
    RepeatedEnabled,
    /// A clause's condition holds (`end-when`, `restart-when`, `suspend-when`, ..).
    ConditionSatisfied {
        /// The clause's name.
        clause: Cow<'static, str>,
    },
    /// All resources were granted, or none is needed.
    ResourcesGranted {
        /// Resources that the task got.
        resources: Vec<Share>,
    },
    /// A conflict over a resource was lost.
    Outranked {
        /// The winner.
        by: TaskId,
        /// The resource.
        resource: Value,
        /// The rule that decided.
        rule: ConflictRule,
        /// Strength of the winner.
        winner: Strength,
        /// Strength of the loser.
        loser: Strength,
    },
    /// The resource cannot provide the needed amount: its total or its rest is smaller.
    ResourceExhausted {
        /// The resource.
        resource: Value,
        /// The amount needed, with its unit.
        needed: Value,
        /// Remaining amount, with its unit.
        left: Value,
    },
    /// An ancestor was suspended with everything below it.
    AncestorSuspended {
        /// The ancestor.
        ancestor: TaskId,
    },
    /// The suspension of an ancestor was lifted.
    AncestorResumed {
        /// The ancestor.
        ancestor: TaskId,
    },
    /// A built-in activity of another task caused it: `terminate`, `suspend`, `resume`, `reset`.
    Activity {
        /// The task that did it.
        by: TaskId,
        /// The activity's name.
        activity: Cow<'static, str>,
    },
    /// All steps have ended.
    StepsEnded {
        /// The task that ended last; `None` without steps.
        last: Option<TaskId>,
    },
    /// All tasks made by `forall` have ended, or the list was empty.
    ItemsEnded {
        /// Number of items.
        items: u64,
        /// The task that ended last; `None` if the list was empty.
        last: Option<TaskId>,
    },
    /// A built-in activity is complete when it begins.
    BuiltInDone {
        /// The activity's name.
        activity: Cow<'static, str>,
    },
    /// A primitive with nothing to wait for is complete at once.
    CompletedAtOnce,
    /// A primitive's `(complete)` form.
    CompletedByForm,
    /// A primitive's duration is over.
    DurationElapsed {
        /// The time worked, without suspensions.
        duration: Duration,
    },
    /// The vehicle acknowledged the command.
    CommandAcknowledged {
        /// The command.
        command: CommandId,
    },
    /// The vehicle refused the command, or failed to execute it.
    CommandFailed {
        /// The command.
        command: CommandId,
        /// The vehicle's reason.
        reason: String,
    },
    /// The vehicle did not answer the command in time.
    CommandTimedOut {
        /// The command.
        command: CommandId,
        /// Time for which the answer was waited for.
        patience: Duration,
    },
    /// The parent ended.
    ParentEnded {
        /// The parent.
        parent: TaskId,
    },
    /// The parent starts over.
    ParentRestarted {
        /// The parent.
        parent: TaskId,
    },
    /// The parent failed, and its `on-failure` replaces its other work.
    ParentFailed {
        /// The parent.
        parent: TaskId,
    },
    /// A child failed, and no clause handles the failure.
    ChildFailed {
        /// The child.
        child: TaskId,
    },
    /// Another task handles the failure of this one, and is its work now.
    FailureHandled {
        /// The task that handles it.
        by: TaskId,
    },
    /// The task that handled the failure of this one ended, and this one ends in the same way.
    HandlerEnded {
        /// The task that handled it.
        handler: TaskId,
    },
    /// The most specific match.
    MostSpecific {
        /// Number of matches.
        candidates: u64,
    },
    /// No match is more specific, and it precedes the equally specific ones.
    FirstOfEquals {
        /// Number of matches.
        candidates: u64,
        /// Number of equally specific matches, itself included.
        equals: u64,
        /// Rule that put it first.
        rule: EqualsRule,
    },
    /// The activity is built in: there is no choice of method.
    BuiltIn {
        /// The activity's name.
        activity: Cow<'static, str>,
    },
    /// The step has a `forall`: one task is made for each item.
    ForAll {
        /// Number of items.
        items: u64,
    },
    /// No procedure or primitive matched, and a solver serves the goal.
    NoProcedureMatched,
    /// A solver's plan arrived.
    PlanArrived {
        /// The request.
        request: SolveRequestId,
        /// The solver.
        solver: Symbol,
    },
    /// Nothing in the library and no solver serves the goal.
    NoMethod {
        /// The goal.
        goal: Value,
    },
    /// A solver failed to plan for the goal.
    SolverFailed {
        /// The request.
        request: SolveRequestId,
        /// The solver's reason.
        reason: String,
    },
    /// A solver did not answer in time.
    SolverTimedOut {
        /// The request.
        request: SolveRequestId,
        /// Time for which the answer was waited for.
        patience: Duration,
    },
    /// A `waitfor`, `select`, `=>` or `setq` bound a variable.
    Binding {
        /// The clause's name.
        clause: Cow<'static, str>,
    },
    /// A form of this clause sent the command.
    FormRan {
        /// `on-start`, `update`, `on-resume`, ..
        clause: Cow<'static, str>,
    },
    /// The command was withdrawn at an interruption, and is sent again.
    SentAgain,
    /// An expression could not be evaluated.
    ExpressionFailed {
        /// Error message.
        message: String,
    },
    /// A step's value does not fit the pattern after `=>`.
    ResultDoesNotFit {
        /// The value.
        value: Value,
    },
    /// A sample or a message could not be recorded as received.
    InputRefused {
        /// Error in it.
        message: String,
    },
    /// An answer arrived for a command, solver request or question that was never made.
    StrayAnswer {
        /// `command 7`, `solver request 2`, `question 1`.
        to: String,
    },
    /// A limit of the executive was reached.
    LimitReached {
        /// The limit's name in `limits.rs`.
        limit: String,
        /// The value of the limit, which the agent may have lowered.
        value: u64,
    },
    /// The operator answered.
    OperatorAnswered {
        /// The question.
        question: QuestionId,
        /// The answer.
        answer: Value,
    },
    /// The operator's time was over, and the default was taken.
    OperatorSilent {
        /// The question.
        question: QuestionId,
        /// The default.
        default: Value,
    },
    /// The operator's time was over, and there was no default.
    OperatorMute {
        /// The question.
        question: QuestionId,
    },
    /// `(end-application)`.
    ApplicationEnded {
        /// The task that executed the form.
        by: TaskId,
    },
    /// The application ends for a reason outside of this agent.
    Stopped {
        /// Reason, as stated from outside.
        reason: String,
    },
    /// A message has no receiver: no agent or router has this name.
    NobodyHears {
        /// Intended receiver, and the agents that exist.
        message: String,
    },
    /// Tasks wait for each other's resources in a circle.
    WaitsInCircle {
        /// For each task of the circle, the resource for which it waits and the holder; the next link's task is below the holder.
        links: Vec<CircleLink>,
    },
    /// The executive contradicts itself: a bug of Apex, never of a program.
    ExecutiveFault {
        /// Description of the contradiction.
        message: String,
    },
    /// The flight is no longer recorded, because the record cannot be written; the flight continues.
    RecordingLost {
        /// Reason stated by the system.
        reason: String,
    },
    /// The `precondition` or `invariant` of a task does not hold.
    ConditionViolated {
        /// The clause's name.
        clause: Cow<'static, str>,
    },
    /// The `waitfor` can no longer hold: it needs an outcome that a step of the procedure did not have.
    OutcomeMissed {
        /// The task of that step.
        task: TaskId,
        /// The outcome that was waited for: `failed`.
        outcome: Symbol,
    },
    /// The result that the step uses can no longer exist: the step that binds it ended without success.
    ResultMissed {
        /// The task of that step.
        task: TaskId,
        /// The variable, without `?`.
        variable: Symbol,
    },
    /// A resource was in use, and the profile says `:refuse-if-busy`.
    ResourceBusy {
        /// The resource.
        resource: Value,
        /// The task that holds it, or gets it.
        holder: TaskId,
    },
    /// A command was sent, made progress, ended or was withdrawn.
    CommandMoved {
        /// The command.
        command: CommandId,
    },
    /// The level of a renewable resource: when the agent begins, and when work has changed it.
    LevelChanged {
        /// The resource.
        resource: Symbol,
    },
}
