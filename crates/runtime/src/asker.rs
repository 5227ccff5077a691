//! Questions of agents, shown to an operator while a run continues.

use crate::escaping::shortened;
use crate::limits::INPUT_MESSAGES_MAX;
use crate::live::RateLimit;
use crate::live_lines::OpenQuestions;
use crate::ports::{Deliberator, Observer};
use apex_executive::Agent;
use apex_model::effect::{DecisionKind, Effect, QuestionId};
use apex_model::event::{Batch, EventKind};
use apex_model::symbol::Symbol;
use apex_model::time::Time;
use apex_model::value::Value;
use std::time::Instant;

/// Printed refusals of answers per second, after the first ones: a flood of lines may all be taken for answers.
const REFUSALS_PER_SECOND: f64 = 2.0;

/// Shows the operator the questions of agents, and the outcome of answers.
pub struct Asker {
    open: OpenQuestions,
    names: Vec<Symbol>,
    turn: usize,
    print: fn(&str),
    refusals: RateLimit,
    began: Instant,
    /// Number of refusals since the last printed one.
    hidden: u64,
}

impl Asker {
    /// Returns an asker for agents with these names; `print` shows a line to the operator.
    pub fn new(open: OpenQuestions, names: Vec<Symbol>, print: fn(&str)) -> Asker {
        let refusals = RateLimit::with_burst(REFUSALS_PER_SECOND, INPUT_MESSAGES_MAX as f64);
        Asker { open, names, turn: 0, print, refusals, began: Instant::now(), hidden: 0 }
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

    /// Shows why an answer is refused; of many refusals some, and the number of the others.
    fn refuse(&mut self, message: &str) {
        if !self.refusals.admits(self.began.elapsed()) {
            self.hidden += 1;
            return;
        }
        self.print_hidden();
        (self.print)(&format!("  {}", shortened(message)));
    }

    fn print_hidden(&mut self) {
        let hidden = std::mem::take(&mut self.hidden);
        if hidden > 0 {
            (self.print)(&format!("  {hidden} more answers were refused"));
        }
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
                        self.refuse(&message.to_string());
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

impl Drop for Asker {
    fn drop(&mut self) {
        self.print_hidden();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Mutex;

    static PRINTED: Mutex<Vec<String>> = Mutex::new(Vec::new());

    #[test]
    fn a_flood_of_answers_is_counted() {
        let print = |line: &str| PRINTED.lock().unwrap().push(line.to_owned());
        let mut asker = Asker::new(OpenQuestions::default(), Vec::new(), print);
        asker.refuse(&"é".repeat(1_000_000));
        for _ in 0..10_000 {
            asker.refuse("the answer no came too late");
        }
        drop(asker);
        let printed = PRINTED.lock().unwrap();
        assert!(printed[0].ends_with("é ..") && printed[0].len() < 1_000, "{}", printed[0].len());
        assert!((INPUT_MESSAGES_MAX..100).contains(&printed.len()), "{printed:?}");
        assert!(printed.last().unwrap().ends_with("more answers were refused"), "{printed:?}");
    }
}
