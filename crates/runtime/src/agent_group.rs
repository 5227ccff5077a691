//! The agents of one application, each with its inbox, driven by one clock.
//!
//! At each instant agents step in rounds, within a round in the order of their declarations. A message from one agent to
//! another arrives at the same instant in the next round, so results do not depend on that order. Rounds are bounded:
//! messages after the last round of an instant are dropped with a note.

use crate::error::RunError;
use crate::inbox::Inbox;
use crate::limits::MESSAGE_ROUNDS_MAX;
use crate::ports::Input;
use crate::run_settings::EndReason;
use apex_executive::Agent;
use apex_model::effect::{CommandId, QuestionId, SolveRequestId};
use apex_model::event::{Batch, EventKind, Message};
use apex_model::symbol::Symbol;
use apex_model::task::Outcome;
use apex_model::time::Time;

/// Translation of command and request numbers: every agent counts from 0, and outside of the group the numbers are unique.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Numbering {
    agent: u64,
    agents: u64,
}

impl Numbering {
    /// Returns the numbering of agent `agent` (from 0) of `agents`.
    pub fn new(agent: usize, agents: usize) -> Numbering {
        Numbering { agent: agent as u64, agents: (agents as u64).max(1) }
    }

    /// Returns the outer number of this agent's number `own`; with a single agent both are equal.
    pub fn outer(self, own: u64) -> u64 {
        own.saturating_mul(self.agents).saturating_add(self.agent)
    }

    /// Returns the agent to which the outside number `outer` belongs, and that agent's own number for it.
    fn inner(outer: u64, agents: usize) -> (usize, u64) {
        let agents = (agents as u64).max(1);
        (usize::try_from(outer % agents).unwrap_or(0), outer / agents)
    }
}

/// Agents with their inboxes, and the messages between them in the present round.
pub(crate) struct AgentGroup<'a> {
    agents: &'a mut [Agent],
    inboxes: Vec<Inbox>,
    post: Vec<(usize, EventKind)>,
    rounds: u32,
}

impl<'a> AgentGroup<'a> {
    pub(crate) fn new(agents: &'a mut [Agent]) -> AgentGroup<'a> {
        let inboxes = agents.iter().map(|_| Inbox::new()).collect();
        AgentGroup { agents, inboxes, post: Vec::new(), rounds: 0 }
    }

    /// Continues the numbering of events after the last one of each agent.
    pub(crate) fn resume(&mut self, last_sequences: &[u64]) {
        for (inbox, last) in self.inboxes.iter_mut().zip(last_sequences) {
            inbox.resume(*last);
        }
    }

    /// Returns the number of agents.
    pub(crate) fn len(&self) -> usize {
        self.agents.len()
    }

    /// Returns the agent with this index.
    pub(crate) fn agent(&self, index: usize) -> Option<&Agent> {
        self.agents.get(index)
    }

    /// Returns the agent with this index, mutable for its step.
    pub(crate) fn agent_mut(&mut self, index: usize) -> Option<&mut Agent> {
        self.agents.get_mut(index)
    }

    /// Returns true if no inbox holds an input.
    pub(crate) fn is_idle(&self) -> bool {
        self.inboxes.iter().all(Inbox::is_empty)
    }

    /// Returns the reasons for which all agents are finished, or `None` while one is not.
    pub(crate) fn finish(&self) -> Option<String> {
        let reasons: Option<Vec<(&Symbol, &String)>> =
            self.agents.iter().map(|agent| Some((&agent.name, agent.finished.as_ref()?))).collect();
        match reasons?.as_slice() {
            [(_, reason)] => Some((*reason).clone()),
            several => {
                let words: Vec<String> = several.iter().map(|(name, reason)| format!("{name}: {reason}")).collect();
                Some(format!("all agents are done; {}", words.join("; ")))
            }
        }
    }

    /// Returns the end of the application for `reason`: a failure if the initial task of an agent failed.
    pub(crate) fn ended(&self, reason: String) -> EndReason {
        let initial_task = |agent: &Agent| agent.tasks.iter().next().and_then(|(_, task)| task.outcome.clone());
        let outcomes: Vec<Option<Outcome>> = self.agents.iter().map(initial_task).collect();
        let failed = outcomes.iter().flatten().any(Outcome::is_failure);
        // A task that is cut has no outcome yet when the application ends.
        let is_cut = |outcome: &Option<Outcome>| outcome.as_ref().is_none_or(|outcome| *outcome == Outcome::Cut);
        let cut = !failed && outcomes.iter().any(is_cut);
        EndReason::Application { reason, failed, cut }
    }

    /// Returns the next instant at which an agent requests a wake.
    pub(crate) fn next_wake(&self) -> Option<Time> {
        self.agents.iter().filter_map(Agent::next_wake_at).min()
    }

    /// Wakes the agents whose requested instant is not after `now`; returns the first reason.
    pub(crate) fn wake(&mut self, now: Time) -> Result<Option<String>, RunError> {
        let mut cause = None;
        for (agent, inbox) in self.agents.iter().zip(&mut self.inboxes) {
            // Most inputs come before any wake, so the reason is put into words only when one is due.
            let is_due = agent.next_wake_at().is_some_and(|at| at <= now);
            if let Some((_, why)) = is_due.then(|| agent.next_wake()).flatten() {
                inbox.push(Input::new(now, EventKind::Woken))?;
                let named = format!("{why}, of {}", agent.name);
                cause.get_or_insert(if self.agents.len() > 1 { named } else { why });
            }
        }
        Ok(cause)
    }

    /// Puts an input into the inboxes of its addressees.
    pub(crate) fn deliver(&mut self, mut input: Input) -> Result<(), RunError> {
        let one = match &mut input.kind {
            EventKind::CommandAcknowledged(command, _) => {
                let (agent, own) = Numbering::inner(command.0, self.agents.len());
                *command = CommandId(own);
                Some(agent)
            }
            EventKind::CommandProgressed(command, _) => {
                let (agent, own) = Numbering::inner(command.0, self.agents.len());
                *command = CommandId(own);
                Some(agent)
            }
            EventKind::SolverReported(request, _) => {
                let (agent, own) = Numbering::inner(request.0, self.agents.len());
                *request = SolveRequestId(own);
                Some(agent)
            }
            EventKind::OperatorAnswered(question, _) if input.agent.is_none() => Some(self.asker(*question)),
            _ => None,
        };
        let one = match (&input.agent, one) {
            (_, Some(one)) => Some(one),
            (Some(name), None) => Some(self.index_of(name)?),
            (None, None) => None,
        };
        match one {
            Some(index) => match self.inboxes.get_mut(index) {
                Some(inbox) => inbox.push(input),
                None => Ok(()),
            },
            None => match self.inboxes.as_mut_slice() {
                [only] => only.push(input),
                several => several.iter_mut().try_for_each(|inbox| inbox.push(input.clone())),
            },
        }
    }

    /// Checks that an input can be delivered.
    ///
    /// # Errors
    /// [`RunError::Options`] if it addresses an agent that does not exist.
    pub(crate) fn check(&self, input: &Input) -> Result<(), RunError> {
        input.agent.as_ref().map_or(Ok(()), |name| self.index_of(name).map(|_| ()))
    }

    /// Checks that the agent called `name` exists.
    ///
    /// # Errors
    /// [`RunError::Options`] when it does not.
    pub(crate) fn check_agent(&self, name: &Symbol) -> Result<(), RunError> {
        self.index_of(name).map(|_| ())
    }

    fn index_of(&self, name: &Symbol) -> Result<usize, RunError> {
        self.agents.iter().position(|agent| agent.name == *name).ok_or_else(|| {
            let names: Vec<&str> = self.agents.iter().map(|agent| agent.name.printed()).collect();
            RunError::Options(format!(
                "an input is for the agent {name}, which does not exist; there is {}",
                names.join(", ")
            ))
        })
    }

    /// Returns the agent that asked `question`: the first for which it is open, otherwise the first that has asked that many questions.
    fn asker(&self, question: QuestionId) -> usize {
        let open = self.agents.iter().position(|agent| agent.questions.contains_key(&question));
        let asked = || self.agents.iter().position(|agent| agent.next.question > question.0);
        open.or_else(asked).unwrap_or(0)
    }

    /// Returns the batch of agent `index` at `now`; `None` if its inbox is empty or it is finished.
    pub(crate) fn take(&mut self, index: usize, now: Time) -> Option<Batch> {
        let batch = self.inboxes.get_mut(index)?.take(now);
        // Inputs of a finished agent are removed from its queue, and not executed.
        batch.filter(|_| self.agents.get(index).is_some_and(|agent| !agent.is_finished()))
    }

    /// Stores the messages of agent `from` for the next round; returns notes about messages that cannot be delivered.
    pub(crate) fn post(&mut self, from: usize, told: Vec<(Symbol, Message)>) -> Vec<String> {
        let mut notes = Vec::new();
        let Some(author) = self.agents.get(from).map(|agent| agent.name.clone()) else { return notes };
        for (name, message) in told {
            let found = self.agents.iter().enumerate().find(|(_, agent)| agent.name == name);
            let undelivered = match found {
                None => Some("it does not run".to_string()),
                Some((_, agent)) if agent.is_finished() => Some("it has ended".to_string()),
                Some(_) if self.rounds >= MESSAGE_ROUNDS_MAX => {
                    Some(format!("the agents have answered each other {MESSAGE_ROUNDS_MAX} times at one instant"))
                }
                Some((index, _)) => {
                    self.post.push((index, EventKind::Told(author.clone(), message.clone())));
                    None
                }
            };
            notes.extend(
                undelivered.map(|why| format!("{author} sent {name} {message}, but {why}: it is not delivered")),
            );
        }
        notes
    }

    /// Begins a new instant: the count of rounds starts again.
    pub(crate) fn new_instant(&mut self) {
        self.rounds = 0;
    }

    /// Ends a round: delivers its messages at `now`.
    pub(crate) fn end_round(&mut self, now: Time) -> Result<(), RunError> {
        if !self.post.is_empty() {
            self.rounds += 1;
        }
        for (index, kind) in std::mem::take(&mut self.post) {
            if let Some(inbox) = self.inboxes.get_mut(index) {
                inbox.push(Input::new(now, kind))?;
            }
        }
        Ok(())
    }

    /// Informs the agents that are not finished, except for `except`, that the application ends; returns their indices.
    pub(crate) fn stop(&mut self, except: Option<usize>, now: Time, reason: &str) -> Result<Vec<usize>, RunError> {
        let mut stopped = Vec::new();
        for (index, (agent, inbox)) in self.agents.iter().zip(&mut self.inboxes).enumerate() {
            if Some(index) != except && agent.started && !agent.is_finished() {
                inbox.push(Input::new(now, EventKind::Stop(reason.to_string())))?;
                stopped.push(index);
            }
        }
        Ok(stopped)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_come_back_to_a_caller_that_counts_so() {
        for agents in 1..4 {
            for agent in 0..agents {
                let outer = Numbering::new(agent, agents).outer(7);
                assert_eq!(Numbering::inner(outer, agents), (agent, 7));
            }
        }
        assert_eq!(Numbering::new(0, 1).outer(7), 7, "an only agent keeps its numbers");
    }
}
