//! Commands of an operator: each is checked, decided, recorded as an input, and executed if accepted.

use super::{Flight, Waited};
use crate::authority::{Authority, AuthorityRequest};
use crate::commands::{Command, CommandEnd, Order};
use crate::error::RunError;
use crate::ports::Input;
use apex_model::event::EventKind;
use apex_model::time::Time;
use std::time::Duration;

/// The pace of single steps: practically as fast as possible, but with a clock, so that the run waits for operators at its end.
const STEP_PACE: f64 = 1e9;

impl Flight<'_, '_> {
    /// Settles, records and executes a command while the run waits for `instant`; `Some` if the command ends the wait.
    pub(super) fn obey(&mut self, command: &Command, instant: Time) -> Result<Option<Waited>, RunError> {
        let at = self.pacer.now(self.now, instant);
        // The lock is held from the decision to the effect, so that authority cannot change between them.
        let board = self.authority.clone();
        let mut authority = board.authority();
        let mut after = authority.clone();
        let (end, change) = match self.judge(command, &mut after, board.now()) {
            Ok(change) => (CommandEnd::Accepted { at }, change),
            Err(reason) => (CommandEnd::Rejected { reason }, None),
        };
        // The sender may have settled the command first: as expired, or as rejected before it arrived here.
        let settled = command.ticket.settle(end.clone());
        let end = if settled { end } else { command.ticket.end().unwrap_or(end) };
        let agent = match &command.order {
            Order::Input(Some(agent), _) if self.group.check_agent(agent).is_ok() => Some(agent.clone()),
            _ => self.group.agent(0).map(|agent| agent.name.clone()),
        };
        self.group.deliver(Input { at, kind: command.entry(&end), agent: agent.clone(), command_form: None })?;
        if !settled || !matches!(end, CommandEnd::Accepted { .. }) {
            return Ok(None);
        }
        *authority = after;
        drop(authority);
        if let Some(kind) = change {
            self.group.deliver(Input { at, kind, agent, command_form: None })?;
        }
        match &command.order {
            Order::Input(agent, kind) => {
                self.group.deliver(Input { at, kind: kind.clone(), agent: agent.clone(), command_form: None })?;
            }
            Order::Pace(pace) => {
                self.stepping = false;
                self.pacer.set(*pace, at).map_err(RunError::Options)?;
                self.tell_pace(at)?;
            }
            Order::Step => {
                self.stepping = true;
                self.pacer.set(Some(STEP_PACE), at).map_err(RunError::Options)?;
            }
            Order::Stop => return Ok(Some(Waited::Stop(at))),
            Order::Note | Order::Acknowledge(_) | Order::Authority(_) => {}
        }
        Ok(None)
    }

    /// Pauses mission time again after a single step with a visible effect.
    pub(super) fn pause_after_step(&mut self, now: Time) -> Result<(), RunError> {
        self.stepping = false;
        self.pacer.set(Some(0.0), now).map_err(RunError::Options)
    }

    /// Decides about a command: returns the reason of a refusal, or the accompanying change of `authority` as an event.
    fn judge(&self, command: &Command, authority: &mut Authority, now: Duration) -> Result<Option<EventKind>, String> {
        if let Some(objection) = self.objection(&command.order) {
            return Err(objection);
        }
        let Some(author) = &command.author else { return Ok(None) };
        let request = match &command.order {
            Order::Note | Order::Acknowledge(_) => return Ok(None),
            Order::Authority(request) => {
                authority.check_epoch(author.epoch)?;
                request
            }
            Order::Input(..) | Order::Pace(_) | Order::Step | Order::Stop => {
                authority.check(&author.actor, author.epoch)?;
                if authority.holder.is_some() {
                    return Ok(None);
                }
                // An accepted command takes authority that is free.
                &AuthorityRequest::Take
            }
        };
        let change = authority.apply(request, &author.actor, now)?;
        Ok(Some(change.entry(authority, &author.actor)))
    }

    /// Returns the reason for which the run cannot execute an order; `None` if it can.
    fn objection(&self, order: &Order) -> Option<String> {
        match order {
            Order::Input(agent, kind) => {
                if let Some(Err(error)) = agent.as_ref().map(|agent| self.group.check_agent(agent)) {
                    return Some(error.to_string());
                }
                let EventKind::OperatorAnswered(question, _) = kind else { return None };
                let asks = |index: usize| {
                    self.group.agent(index).is_some_and(|each| {
                        agent.as_ref().is_none_or(|wanted| *wanted == each.name)
                            && each.questions.contains_key(question)
                    })
                };
                let open = (0..self.group.len()).any(asks);
                (!open).then(|| format!("question {} is not open", question.0))
            }
            Order::Pace(Some(pace)) if !(0.0..=1e9).contains(pace) => {
                Some(format!("a pace of {pace} is not between 0 and 1e9 mission seconds per second"))
            }
            Order::Pace(_) | Order::Step | Order::Stop | Order::Note | Order::Acknowledge(_) | Order::Authority(_) => {
                None
            }
        }
    }
}
