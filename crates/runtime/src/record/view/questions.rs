//! The questions that an agent has asked operators, as known at an instant.

use super::RecordView;
use super::question_index::{AskedQuestion, QuestionIndex};
use crate::error::RecordError;
use serde::Serialize;

/// Maximum number of questions in one answer; open ones first, then the newest.
const QUESTIONS_MAX: usize = 100;

/// Questions by an instant.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Questions {
    /// By the instant at which they were asked.
    pub questions: Vec<AskedQuestion>,
    /// Number of earlier questions that are left out; all of them are closed.
    pub left_out: usize,
}

impl RecordView {
    /// Returns the questions that were asked by mission time `at_ns` (nanoseconds; `None`: the record's end).
    ///
    /// # Errors
    /// [`RecordError::Damaged`].
    pub fn questions(&self, at_ns: Option<i64>) -> Result<Questions, RecordError> {
        let at_ns = at_ns.unwrap_or(i64::MAX);
        let index = self.current(&self.indexes.questions, QuestionIndex::read_to, QuestionIndex::refresh)?;
        let mut questions = index.known(at_ns);
        let surplus = questions.len().saturating_sub(QUESTIONS_MAX);
        let mut left_out = 0;
        questions.retain(|asked| {
            let is_left_out = left_out < surplus && asked.closed_ns.is_some();
            left_out += usize::from(is_left_out);
            !is_left_out
        });
        Ok(Questions { questions, left_out })
    }
}
