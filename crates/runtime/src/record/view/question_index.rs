//! The questions that an agent has asked operators, as known at an instant, kept in memory and extended with the record.
//!
//! A question is open from its effect until it is withdrawn (its time is over, its task was interrupted) or its task ends; an answer ends
//! the task. Bound: each effect is read once.

use crate::error::RecordError;
use crate::record::RecordReader;
use apex_model::effect::Effect;
use apex_model::task::TaskState;
use apex_model::value::Value;
use serde::Serialize;
use std::collections::BTreeMap;

/// A question to operators.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct AskedQuestion {
    /// Its number.
    pub question: u64,
    /// The number of the task that asks.
    pub task: u64,
    /// The question.
    pub text: String,
    /// Choices; without any, every form is an answer.
    pub options: Vec<String>,
    /// The answer that is taken if none comes in time; none fails the task.
    pub default: Option<String>,
    /// Mission time in nanoseconds at which it was asked.
    pub asked_ns: i64,
    /// Mission time in nanoseconds at which the time of the operators is over.
    pub by_ns: Option<i64>,
    /// Mission time in nanoseconds from which it was open no longer; null while it is open.
    pub closed_ns: Option<i64>,
    /// Reason of its withdrawal; null while it is open, and if the task ended, as by an answer.
    pub withdrawn: Option<String>,
}

/// All questions, kept in memory and grown with the record.
#[derive(Default)]
pub(super) struct QuestionIndex {
    /// Number of the last effect that was read or skipped.
    read_to: i64,
    questions: Vec<AskedQuestion>,
    /// Places of the open questions by task.
    open: BTreeMap<u64, usize>,
}

impl QuestionIndex {
    /// Returns the number of the last effect that was read or skipped.
    pub(super) fn read_to(&self) -> i64 {
        self.read_to
    }

    /// Reads the effects that were written since the last call, up to effect `last`.
    pub(super) fn refresh(&mut self, reader: &RecordReader, last: i64) -> Result<(), RecordError> {
        let effects = reader.effects()?;
        for place in effects.table.place_after(self.read_to)..effects.table.place_after(last) {
            let Some(kind) = effects.table.kind(place) else { continue };
            match kind.word {
                "ask" | "withdraw-question" => self.take(effects.at(place).0, effects.effect(place)?),
                "transition" if kind.to == Some(TaskState::Terminated) && !self.open.is_empty() => {
                    let asked = effects.table.task(place).and_then(|task| self.open.remove(&task));
                    self.close(asked, effects.at(place).0, None);
                }
                _ => {}
            }
        }
        self.read_to = self.read_to.max(last);
        Ok(())
    }

    /// Returns the questions that were asked by `at_ns`, as known then.
    pub(super) fn known(&self, at_ns: i64) -> Vec<AskedQuestion> {
        let known = self.questions.partition_point(|asked| asked.asked_ns <= at_ns);
        let as_known = |asked: &AskedQuestion| {
            let is_open = asked.closed_ns.is_none_or(|closed_ns| closed_ns > at_ns);
            let closed_ns = asked.closed_ns.filter(|_| !is_open);
            AskedQuestion { closed_ns, withdrawn: asked.withdrawn.clone().filter(|_| !is_open), ..asked.clone() }
        };
        self.questions.iter().take(known).map(as_known).collect()
    }

    fn take(&mut self, at_ns: i64, effect: Effect) {
        match effect {
            Effect::Ask { question, task, text, options, by, default } => {
                self.open.insert(task.0, self.questions.len());
                self.questions.push(AskedQuestion {
                    question: question.0,
                    task: task.0,
                    text,
                    options: options.iter().map(Value::to_string).collect(),
                    default: default.as_ref().map(Value::to_string),
                    asked_ns: at_ns,
                    by_ns: by.map(|by| by.0),
                    closed_ns: None,
                    withdrawn: None,
                });
            }
            Effect::WithdrawQuestion { question, reason } => {
                let is_asked = |place: &usize| self.questions.get(*place).is_some_and(|one| one.question == question.0);
                let task = self.open.iter().find(|(_, place)| is_asked(place)).map(|(task, _)| *task);
                let asked = task.and_then(|task| self.open.remove(&task));
                self.close(asked, at_ns, Some(reason));
            }
            _ => {}
        }
    }

    fn close(&mut self, place: Option<usize>, at_ns: i64, withdrawn: Option<String>) {
        if let Some(asked) = place.and_then(|place| self.questions.get_mut(place)) {
            (asked.closed_ns, asked.withdrawn) = (Some(at_ns), withdrawn);
        }
    }
}
