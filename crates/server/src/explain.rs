//! The question that the record's rows alone cannot answer in full: what exactly is a task waiting for?

use serde_json::Value;

/// Answers "why" about a task with the executive's own knowledge (a restored agent), beyond the rows of the record.
///
/// The server answers `/api/why` from the effect rows (created, started, interrupted, ended, with their causes) in
/// any case; an explainer adds to that.
pub trait Explainer: Send + Sync {
    /// Why `task` is as it is at mission time `at_ns` (nanoseconds).
    ///
    /// The answer is an object. The page shows two of its members, both optional, and passes over all others:
    /// `sentences`, a list of texts; and `unmet`, a list of objects with `text` and, where known, `place`
    /// (`file:line:column`): the parts of conditions that do not hold yet.
    ///
    /// # Errors
    /// One sentence for people, when the task is unknown or the instant cannot be restored.
    fn why(&self, task: u64, at_ns: i64) -> Result<Value, String>;
}
