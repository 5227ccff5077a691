//! Questions of agents, shown to an operator while a run continues.

use crate::live_lines::OpenQuestions;
use crate::ports::{Deliberator, Observer};
use apex_executive::Agent;
use apex_model::effect::{DecisionKind, Effect, QuestionId};
use apex_model::event::{Batch, EventKind};
use apex_model::symbol::Symbol;
use apex_model::time::Time;
use apex_model::value::Value;

/// Shows the operator the questions of agents, and the outcome of answers.
pub struct Asker {
    open: OpenQuestions,
    names: Vec<Symbol>,
    turn: usize,
    print: fn(&str),
}

impl Asker {
    /// Returns an asker for agents with these names; `print` shows a line to the operator.
    pub fn new(open: OpenQuestions, names: Vec<Symbol>, print: fn(&str)) -> Asker {
        Asker { open, names, turn: 0, print }
    }

    fn asked(&self, question: QuestionId, text: &str, options: &[Value], end: Option<String>) {
        let Some(agent) = self.names.get(self.turn).cloned() else { return };
        let options: Vec<String> = options.iter().map(ToString::to_string).collect();
        let choices = if options.is_empty() { String::new() } else { format!(" [{}]", options.join(", ")) };
        let number = self.number(question);
        // The question is registered before it is shown, because its reader may answer at once.
        self.open.opened(agent, question, text);
        (self.print)(&format!("? {number}: {text}{choices}{}", end.unwrap_or_default()));
    }

    /// Returns the number of a question as text: `2`, or `pilot/2` if several agents ask.
    fn number(&self, question: QuestionId) -> String {
        match self.names.get(self.turn) {
            Some(agent) if self.names.len() > 1 => format!("{agent}/{}", question.0),
            _ => question.0.to_string(),
        }
    }
}

impl Observer for Asker {
    fn turn(&mut self, agent: usize) -> Result<(), String> {
        self.turn = agent;
        Ok(())
    }

    fn observe(&mut self, batch: &Batch, effects: &[Effect]) -> Result<(), String> {
        let answered = batch.events.iter().any(|event| matches!(event.kind, EventKind::OperatorAnswered(..)));
        for effect in effects {
            match effect {
                Effect::Ask { question, text, options, by, default, .. } => {
                    let end = by.map(|by| match default {
                        Some(default) => format!(" ({default} is taken at {by})"),
                        None => format!(" (until {by})"),
                    });
                    self.asked(*question, text, options, end);
                }
                Effect::WithdrawQuestion { question, reason } => {
                    (self.print)(&format!("  {}: withdrawn, {reason}", self.number(*question)));
                }
                Effect::Decided(decision) if answered => {
                    if let DecisionKind::Trouble { message } = &decision.kind {
                        (self.print)(&format!("  {message}"));
                    }
                }
                _ => {}
            }
        }
        Ok(())
    }

    fn inspect(&mut self, agent: &Agent, _: &dyn Deliberator, _: Time) -> Result<(), String> {
        self.open.keep_those_of(agent);
        Ok(())
    }
}
