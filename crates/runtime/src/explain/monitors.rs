//! The monitors of an instant: the conditions that living tasks watch, as trees, and the variables of a task.

use super::Explainer;
use super::snapshot::{instant_of, place_text, restored};
use crate::error::RecordError;
use apex_executive::Agent;
use apex_executive::explanation::{self, ConditionNode, WatchedClause};
use apex_model::task::TaskId;
use apex_model::time::Time;
use serde::Serialize;

/// Conditions that living tasks watch at an instant.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Monitors {
    /// The instant, nanoseconds of mission time.
    pub at_ns: i64,
    /// One entry for each watched clause, in order of the tasks' creation.
    pub monitors: Vec<TaskMonitor>,
    /// The variables of the requested task with their values; empty without a task.
    pub bindings: Vec<Binding>,
}

/// A clause that a task watches.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct TaskMonitor {
    /// The task's number.
    pub task: u64,
    /// The task's goal, as known at the instant.
    pub goal: String,
    /// The clause: `waitfor`, `restart-when`, ..
    pub clause: String,
    /// Its condition.
    pub condition: MonitoredCondition,
}

/// A part of a condition with its present state.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct MonitoredCondition {
    /// Kind of the part: `and`, `or`, `measurement`, `episode`, `event`, ..
    pub kind: String,
    /// The part as PDL text.
    pub text: String,
    /// True if the part holds; null if the data do not decide.
    pub holds: Option<bool>,
    /// The state variable that the part watches.
    pub variable: Option<String>,
    /// The newest value of that variable, with its unit.
    pub value: Option<String>,
    /// Constraints on the value, resolved: `> 15deg`.
    pub limits: Vec<String>,
    /// The present state of the part as text.
    pub now: String,
    /// Instant since which the part holds, or since which its present state has been known; nanoseconds of mission time.
    pub since_ns: Option<i64>,
    /// Instant at which the part becomes true by time alone; nanoseconds of mission time.
    pub until_ns: Option<i64>,
    /// `file:line:column` of the part.
    pub place: String,
    /// Its parts.
    pub parts: Vec<MonitoredCondition>,
}

/// A variable of a task.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Binding {
    /// Its name with the question mark.
    pub name: String,
    /// Its value as PDL text.
    pub value: String,
}

impl Explainer<'_> {
    /// Returns the conditions that living tasks watch at `at`, or at the end of the record if that is earlier. With `task`, only those of
    /// that task, with its variables.
    ///
    /// # Errors
    /// [`RecordError`] if the instant cannot be restored.
    pub fn monitors(&self, at: Time, task: Option<TaskId>) -> Result<Monitors, RecordError> {
        let load = self.load.ok_or_else(|| {
            RecordError::Question(
                "A record does not contain monitors: restore the agent at this instant to list them.".into(),
            )
        })?;
        let at = instant_of(self.reader, at)?;
        let agent = restored(self.reader, at, load)?;
        let monitors = explanation::watched(&agent, task).into_iter().map(|watched| monitor(&agent, watched)).collect();
        let bindings = task.map(|task| explanation::bindings(&agent, task)).unwrap_or_default();
        let bindings =
            bindings.into_iter().map(|(name, value)| Binding { name: format!("?{name}"), value: value.to_string() });
        Ok(Monitors { at_ns: at.0, monitors, bindings: bindings.collect() })
    }
}

fn monitor(agent: &Agent, watched: WatchedClause) -> TaskMonitor {
    let goal = explanation::describe_task(agent, watched.task).map(|view| view.goal.to_string());
    TaskMonitor {
        task: watched.task.0,
        goal: goal.unwrap_or_default(),
        clause: watched.clause.to_string(),
        condition: condition(agent, watched.condition),
    }
}

fn condition(agent: &Agent, node: ConditionNode) -> MonitoredCondition {
    MonitoredCondition {
        kind: node.kind.to_string(),
        text: node.text,
        holds: node.holds,
        variable: node.variable,
        value: node.value,
        limits: node.limits,
        now: node.now,
        since_ns: node.since.map(|since| since.0),
        until_ns: node.until.map(|until| until.0),
        place: place_text(agent, node.place),
        parts: node.parts.into_iter().map(|part| condition(agent, part)).collect(),
    }
}
