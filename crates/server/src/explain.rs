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
    /// `waiting`, a list of `{what, now, place}` (the part of a condition that does not hold yet, what is known about
    /// it then, its `file:line:column`; the last two may be missing); and `blocked`,
    /// `{by, goal, resource, winner_priority, loser_priority, strengths}`: who has the task's resource, with the numbers
    /// compared, and what they are made of in words.
    ///
    /// # Errors
    /// One sentence for people, when the task is unknown or the instant cannot be restored.
    fn why(&self, task: u64, at_ns: i64) -> Result<Value, String>;
}
