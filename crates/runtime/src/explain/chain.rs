//! Chains of causes: a decision, its causes, their causes, back to a sample, a message or a form of the program.

use super::cause::CauseDetail;
use super::history::because_of;
use super::link::Link;
use super::log::Log;
use crate::effect_describer::cause_text;
use crate::error::RecordError;
use crate::limits::EXPLANATION_LINKS_MAX;
use crate::record::view::decisions::DecisionRow as Row;
use apex_model::because::{Because, Cause, Evidence};
use apex_model::effect::{DecisionKind, Effect};
use apex_model::probing::ProbingEnd;
use apex_model::symbol::Symbol;
use apex_model::task::{TaskId, TaskState};
use apex_model::time::Time;
use std::collections::BTreeSet;

/// Follows decisions back.
pub(super) struct Chain<'a> {
    log: &'a Log<'a>,
    seen: BTreeSet<i64>,
    goals: &'a dyn Fn(TaskId) -> String,
}

type RowsResult = Result<Vec<Row>, RecordError>;

impl<'a> Chain<'a> {
    /// Returns a chain through the decisions of `log`; `goals` names tasks.
    pub(super) fn new(log: &'a Log<'a>, goals: &'a dyn Fn(TaskId) -> String) -> Chain<'a> {
        Chain { log, seen: BTreeSet::new(), goals }
    }

    /// Returns the link of `row` with at most `depth` links below one another.
    pub(super) fn link(&mut self, row: &Row, depth: usize) -> Result<Link, RecordError> {
        self.seen.insert(row.id);
        let because = because_of(row);
        let mut link = Link {
            t: row.at.seconds(),
            task: row.task.map(|task| task.to_string()),
            task_number: row.task.map(|task| task.0),
            what: self.what(row),
            kind: because.map(|because| because.cause.kind().to_string()),
            because: because.map(cause_text).unwrap_or_default(),
            cause: because.map(CauseDetail::of),
            place: row.place.clone(),
            source: row.place.as_ref().and_then(|place| self.log.source_line(place)),
            causes: Vec::new(),
            more: false,
        };
        let Some(because) = because else {
            if let (Some(task), true) = (row.task, row.kind == "inform" || row.kind == "solve") {
                let start = self.log.decisions.transition(task, "ongoing", (row.id, row.at))?;
                self.add(&mut link, start.into_iter().collect(), depth)?;
            }
            return Ok(link);
        };
        let mut below = self.evidence(&mut link, row, because)?;
        below.extend(self.behind(row, &because.cause)?);
        self.add(&mut link, below, depth)?;
        Ok(link)
    }

    fn add(&mut self, link: &mut Link, below: Vec<Row>, depth: usize) -> Result<(), RecordError> {
        for row in below {
            if self.seen.contains(&row.id) {
                continue;
            }
            if depth <= 1 || self.seen.len() >= EXPLANATION_LINKS_MAX {
                link.more = true;
                return Ok(());
            }
            let next = self.link(&row, depth - 1)?;
            link.causes.push(next);
        }
        Ok(())
    }

    fn what(&self, row: &Row) -> String {
        let name = row.task.map(|task| format!("{task} {}", (self.goals)(task))).unwrap_or_else(|| "the agent".into());
        match row.effect.as_ref() {
            Some(Effect::Decided(decision)) => match &decision.kind {
                DecisionKind::Created { .. } => format!("{name} was created"),
                DecisionKind::Transition { from, to, .. } => {
                    let word = moved(*from, *to, decision_outcome(decision));
                    format!("{name} {word}")
                }
                DecisionKind::Satisfied { clause, .. } => format!("{clause} of {name} became true"),
                DecisionKind::Bound { variable, value } => format!("{name} got ?{variable} = {value}"),
                DecisionKind::Selected { .. } => match &row.method {
                    Some(method) => format!("{name} is pursued by {method}"),
                    None => format!("{name} is pursued"),
                },
                DecisionKind::Refused { resource, .. } => format!("{name} was refused {resource}"),
                DecisionKind::ProcedureAdded { summary, .. } => format!("{name} got a plan: {summary}"),
                DecisionKind::Trouble { .. } => format!("{name} had an error"),
            },
            Some(Effect::Command { command, form, .. }) => format!("{name} sent command {} {form}", command.0),
            Some(Effect::Inform { form, .. }) => format!("{name} said {form}"),
            Some(Effect::Publish { variable, value, .. }) => format!("{name} published {variable} = {value}"),
            Some(Effect::Solve(request)) => format!("{name} asked {} for a plan", request.solver),
            _ => format!("{name}: {} {}", row.kind, row.subject),
        }
    }

    /// Adds the evidence: leaves of the chain, and the decisions that are evidence themselves.
    fn evidence(&self, link: &mut Link, row: &Row, because: &Because) -> RowsResult {
        let mut rows = Vec::new();
        let here = |at: Time| (row.id, at);
        for evidence in because.evidence.iter() {
            let found = match evidence {
                Evidence::TaskEnd { task, at } => self.log.decisions.transition(*task, "terminated", here(*at))?,
                Evidence::TaskState { task, state, at } => {
                    let word = state.to_string();
                    let word = if word == "resumed" { "ongoing" } else { word.as_str() };
                    self.log.decisions.transition(*task, word, here(*at))?
                }
                Evidence::Event { form, at, .. } => {
                    let said = self.log.decisions.inform(&form.to_string(), *at)?;
                    if said.is_none() {
                        link.causes.push(Link::seen(*at, format!("{form} was received as an input")));
                    }
                    said
                }
                Evidence::Sample { variable, value, at } => {
                    let published = self.log.decisions.publish(&format!("{variable} = {value}"), *at)?;
                    if published.is_none() {
                        link.causes.push(Link::seen(*at, format!("{} was measured", evidence.text())));
                    }
                    published
                }
                Evidence::Run { variable, start, end, samples } => {
                    let gap = self.log.largest_gap(variable, (*start, *end), *samples, row.at)?;
                    let apart = gap.map(|gap| format!(", at most {gap} apart")).unwrap_or_default();
                    link.causes.push(Link::seen(*end, format!("{} were measured{apart}", evidence.text())));
                    None
                }
                Evidence::Instant { at, .. } => {
                    link.causes.push(Link::seen(*at, format!("time passed: {}", evidence.text())));
                    None
                }
                Evidence::Function { at, .. } | Evidence::Absence { at, .. } => {
                    link.causes.push(Link::seen(*at, evidence.text()));
                    None
                }
                Evidence::Estimate(estimate) => {
                    link.causes.push(Link::seen(estimate.at, format!("{} was estimated", evidence.text())));
                    None
                }
                Evidence::Aggregate(aggregate) => {
                    link.causes.push(Link::seen(aggregate.interval.1, format!("{} was computed", evidence.text())));
                    None
                }
            };
            rows.extend(found);
        }
        Ok(rows)
    }

    /// Returns the decisions that a cause names, or on which it rests without naming them.
    fn behind(&self, row: &Row, cause: &Cause) -> RowsResult {
        let (log, here, own) = (self.log.decisions, (row.id, row.at), row.task.unwrap_or(TaskId(u64::MAX)));
        let found = match cause {
            Cause::ParentStarted { parent } | Cause::ItemOf { parent } | Cause::Meanwhile { parent } => {
                log.transition(*parent, "ongoing", here)?
            }
            Cause::PlanPursued { parent } | Cause::PlanBegunAgain { parent } => {
                log.before(*parent, "procedure-added", row.id)?
            }
            Cause::Probes { .. } | Cause::ProbingStopped { .. } => self.of_probing(cause, here)?,
            Cause::HandlesFailure { of } | Cause::ParentFailed { parent: of } => log.beside(*of, "trouble", here)?,
            Cause::Responding { answered } => log.transition(*answered, "enabled", here)?,
            Cause::Repetition => log.transition_before(own, "terminated", row.id)?,
            Cause::NoPreconditions => log.before(own, "created", row.id)?,
            Cause::StartsOver | Cause::RepeatedEnabled | Cause::IntervalElapsed => {
                log.transition_before(own, "pending", row.id)?
            }
            Cause::PredecessorEnded { predecessor: of }
            | Cause::ParentEnded { parent: of }
            | Cause::ChildFailed { child: of }
            | Cause::HandlerEnded { handler: of }
            | Cause::OutcomeMissed { task: of, .. }
            | Cause::ResultMissed { task: of, .. } => log.transition(*of, "terminated", here)?,
            Cause::ResultArrived { variable } => return self.result(own, variable, row),
            Cause::ResourcesGranted { .. } => return self.granted(own, row),
            Cause::Outranked { by, .. } | Cause::ResourceBusy { holder: by, .. } => {
                log.transition(*by, "ongoing", here)?
            }
            Cause::AncestorSuspended { ancestor } => self.either(*ancestor, "interrupted", here)?,
            Cause::AncestorResumed { ancestor } => self.either(*ancestor, "ongoing", here)?,
            Cause::Activity { by, .. } | Cause::ApplicationEnded { by } => log.transition(*by, "ongoing", here)?,
            Cause::StepsEnded { last } | Cause::ItemsEnded { last, .. } => match last {
                Some(last) => log.transition(*last, "terminated", here)?,
                None => log.transition_before(own, "ongoing", row.id)?,
            },
            Cause::CommandAcknowledged { command }
            | Cause::CommandMoved { command }
            | Cause::CommandFailed { command, .. }
            | Cause::CommandTimedOut { command, .. } => log.command_of(own, command.0)?,
            Cause::BuiltInDone { .. }
            | Cause::CompletedAtOnce
            | Cause::CompletedByForm
            | Cause::DurationElapsed { .. }
            | Cause::FormRan { .. }
            | Cause::SentAgain
            | Cause::OperatorAnswered { .. }
            | Cause::OperatorSilent { .. }
            | Cause::OperatorMute { .. } => log.transition_before(own, "ongoing", row.id)?,
            Cause::ParentRestarted { parent } => log.transition(*parent, "pending", here)?,
            Cause::FailureHandled { .. } => log.before(own, "trouble", row.id)?,
            Cause::PlanArrived { request, .. }
            | Cause::SolverFailed { request, .. }
            | Cause::SolverTimedOut { request, .. } => log.request(own, request.0)?,
            Cause::MostSpecific { .. }
            | Cause::FirstOfEquals { .. }
            | Cause::BuiltIn { .. }
            | Cause::ForAll { .. }
            | Cause::NoProcedureMatched
            | Cause::NoMethod { .. } => log.transition_before(own, "enabled", row.id)?,
            // All other causes rest on their evidence alone.
            _ => None,
        };
        Ok(found.into_iter().collect())
    }

    /// Returns the condition for which a task probes, or the event that ended the wait.
    fn of_probing(&self, cause: &Cause, here: (i64, Time)) -> Result<Option<Row>, RecordError> {
        match cause {
            Cause::ProbingStopped { waiting, reason: ProbingEnd::Satisfied, .. } => {
                self.log.decisions.beside(*waiting, "satisfied", here)
            }
            Cause::ProbingStopped { waiting, reason: ProbingEnd::NotAwaited, .. } => {
                let ended = self.log.decisions.transition(*waiting, "terminated", here)?;
                Ok(ended.filter(|row| row.at == here.1))
            }
            Cause::Probes { waiting, .. } | Cause::ProbingStopped { waiting, .. } => {
                self.log.decisions.before(*waiting, "created", here.0)
            }
            _ => Ok(None),
        }
    }

    /// Returns the change to this state, or, if the task did not change its state then, the clause that became true.
    fn either(&self, task: TaskId, state: &str, here: (i64, Time)) -> Result<Option<Row>, RecordError> {
        let changed = self.log.decisions.transition(task, state, here)?.filter(|row| row.at == here.1);
        if changed.is_some() { Ok(changed) } else { self.log.decisions.beside(task, "satisfied", here) }
    }

    /// Describes a result in the context of the parent.
    fn result(&self, own: TaskId, variable: &Symbol, row: &Row) -> RowsResult {
        let Some(created) = self.log.decisions.before(own, "created", row.id)? else { return Ok(Vec::new()) };
        let parent = match created.effect {
            Some(Effect::Decided(decision)) => match decision.kind {
                DecisionKind::Created { parent, .. } => parent,
                _ => None,
            },
            _ => None,
        };
        let found = match parent {
            Some(parent) => self.log.decisions.binding(parent, variable, row.id)?,
            None => None,
        };
        Ok(found.into_iter().collect())
    }

    /// Explains the instant of a grant: the blocking task left, and the task had been enabled.
    fn granted(&self, own: TaskId, row: &Row) -> RowsResult {
        let mut rows = Vec::new();
        let enabled = self.log.decisions.transition_before(own, "enabled", row.id)?;
        let waited = self.log.decisions.before(own, "refused", row.id)?;
        let lost = self.log.decisions.transition_before(own, "interrupted", row.id)?;
        let since = enabled.as_ref().map_or(0, |row| row.id);
        let conflict = [waited, lost].into_iter().flatten().filter(|row| row.id > since).max_by_key(|row| row.id);
        if let Some(Cause::Outranked { by, .. }) = conflict.as_ref().and_then(because_of).map(|because| &because.cause)
        {
            for state in ["terminated", "interrupted"] {
                let left = self.log.decisions.transition(*by, state, (row.id, row.at))?;
                rows.extend(left.filter(|left| left.at == row.at));
            }
        }
        rows.extend(enabled);
        Ok(rows)
    }
}

fn decision_outcome(decision: &apex_model::effect::Decision) -> Option<&apex_model::task::Outcome> {
    match &decision.kind {
        DecisionKind::Transition { outcome, .. } => outcome.as_ref(),
        _ => None,
    }
}

fn moved(from: TaskState, to: TaskState, outcome: Option<&apex_model::task::Outcome>) -> &'static str {
    use apex_model::task::Outcome;
    match (from, to, outcome) {
        (_, TaskState::Enabled, _) => "was enabled",
        (TaskState::Interrupted, TaskState::Ongoing, _) => "continued",
        (_, TaskState::Ongoing, _) => "started",
        (_, TaskState::Interrupted, _) => "was interrupted",
        (TaskState::Terminated, TaskState::Pending, _) => "is pending again",
        (_, TaskState::Pending, _) => "started over",
        (_, TaskState::Terminated, Some(Outcome::Success(_)) | None) => "ended",
        (_, TaskState::Terminated, Some(other)) => other.phrase(),
    }
}
