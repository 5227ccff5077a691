//! The questions that an agent has asked operators, as known at an instant, kept in memory and extended with the record.
//!
//! A question is open from its effect until it is withdrawn (its time is over, its task was interrupted) or its task ends; an answer ends
//! the task. The cause of the task's end tells answers and defaults from other ends. Bound: each effect is read once.

use crate::commands::author_of_answer;
use crate::error::RecordError;
use crate::record::{Effects, RecordReader};
use apex_model::cause::Cause;
use apex_model::effect::{Decision, Effect, QuestionId};
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
    /// End of it; null while it is open.
    pub ended: Option<QuestionEnd>,
}

/// End of a question.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
#[serde(tag = "how", rename_all = "kebab-case")]
pub enum QuestionEnd {
    /// It was answered.
    Answered {
        /// The answer.
        answer: String,
        /// Name of the operator, if the record states it: that of a command to a run.
        author: Option<String>,
    },
    /// The time of the operators was over, and the default was taken.
    Default {
        /// The default.
        answer: String,
    },
    /// It was withdrawn.
    Withdrawn {
        /// Reason.
        reason: String,
    },
    /// Its task ended, and the record does not state more.
    TaskEnded,
}

/// All questions, kept in memory and grown with the record.
#[derive(Default)]
pub(super) struct QuestionIndex {
    /// Number of the last effect that was read or skipped.
    read_to: i64,
    questions: Vec<AskedQuestion>,
    /// Places of the open questions by task.
    open: BTreeMap<u64, usize>,
    /// Places of the questions withdrawn at one instant, which is the last one: the default may be taken at this instant.
    withdrawn: (i64, Vec<usize>),
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
                "transition" if kind.to == Some(TaskState::Terminated) => self.end_task(&effects, place)?,
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
            AskedQuestion { closed_ns, ended: asked.ended.clone().filter(|_| !is_open), ..asked.clone() }
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
                    ended: None,
                });
            }
            Effect::WithdrawQuestion { question, reason } => {
                let is_asked = |place: &usize| self.is_question(*place, question);
                let task = self.open.iter().find(|(_, place)| is_asked(place)).map(|(task, _)| *task);
                let Some(place) = task.and_then(|task| self.open.remove(&task)) else { return };
                if self.withdrawn.0 != at_ns {
                    self.withdrawn = (at_ns, Vec::new());
                }
                self.withdrawn.1.push(place);
                self.close(place, at_ns, QuestionEnd::Withdrawn { reason });
            }
            _ => {}
        }
    }

    /// Ends the open question of a task that has ended, by the cause of its end.
    fn end_task(&mut self, effects: &Effects<'_>, place: usize) -> Result<(), RecordError> {
        let (at_ns, task) = (effects.at(place).0, effects.table.task(place));
        let open = task.and_then(|task| self.open.remove(&task));
        let is_withdrawn_now = self.withdrawn.0 == at_ns && !self.withdrawn.1.is_empty();
        if open.is_none() && !is_withdrawn_now {
            return Ok(());
        }
        let Effect::Decided(Decision { because, .. }) = effects.effect(place)? else { return Ok(()) };
        match because.cause {
            Cause::OperatorAnswered { question, answer } => {
                if let Some(asked) = open {
                    let inputs = effects.inputs(place)?;
                    let author = inputs.iter().find_map(|event| author_of_answer(&event.kind, question.0));
                    self.close(asked, at_ns, QuestionEnd::Answered { answer: answer.to_string(), author });
                }
            }
            Cause::OperatorSilent { question, default } => {
                let withdrawn = self.withdrawn.1.iter().copied().filter(|_| is_withdrawn_now);
                let asked = withdrawn.chain(open).find(|asked| self.is_question(*asked, question));
                if let Some(asked) = asked {
                    self.close(asked, at_ns, QuestionEnd::Default { answer: default.to_string() });
                }
            }
            _ => {
                if let Some(asked) = open {
                    self.close(asked, at_ns, QuestionEnd::TaskEnded);
                }
            }
        }
        Ok(())
    }

    fn is_question(&self, place: usize, question: QuestionId) -> bool {
        self.questions.get(place).is_some_and(|asked| asked.question == question.0)
    }

    fn close(&mut self, place: usize, at_ns: i64, end: QuestionEnd) {
        if let Some(asked) = self.questions.get_mut(place) {
            (asked.closed_ns, asked.ended) = (Some(at_ns), Some(end));
        }
    }
}
