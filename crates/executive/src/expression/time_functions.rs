//! Time functions: start, end and duration of tasks, intervals and results.

use super::Surroundings;
use apex_model::task::TaskId;
use apex_model::time::Time;
use apex_model::value::Value;

type Outcome = Result<Value, String>;

/// Calls the time function `name`; none when there is no such function.
pub(super) fn call(name: &str, arguments: &[Value], surroundings: &dyn Surroundings) -> Option<Outcome> {
    let [value] = arguments else { return None };
    let now = surroundings.now();
    Some(match name {
        "start-of" => start(value, surroundings).map(Value::Time),
        "end-of" | "time-of" => end(value, surroundings).map(Value::Time),
        "duration-of" => {
            start(value, surroundings).map(|start| Value::Duration(end(value, surroundings).unwrap_or(now) - start))
        }
        "elapsed" => start(value, surroundings).map(|start| Value::Duration(now - start)),
        "task-state" => task_state(value, surroundings),
        _ => return None,
    })
}

fn start(value: &Value, surroundings: &dyn Surroundings) -> Result<Time, String> {
    match value {
        Value::Time(time) => Ok(*time),
        Value::Interval(start, _) => Ok(*start),
        Value::Task(task) => surroundings.task_start(*task).ok_or_else(|| unknown(*task)),
        other => Err(not_timed(other)),
    }
}

fn end(value: &Value, surroundings: &dyn Surroundings) -> Result<Time, String> {
    match value {
        Value::Time(time) => Ok(*time),
        Value::Interval(_, end) => Ok(*end),
        Value::Task(task) => surroundings.task_end(*task).ok_or_else(|| format!("{task} has not ended yet")),
        other => Err(not_timed(other)),
    }
}

fn task_state(value: &Value, surroundings: &dyn Surroundings) -> Outcome {
    match value {
        Value::Task(task) => {
            surroundings.task_state(*task).map(|state| Value::symbol(state.word())).ok_or_else(|| unknown(*task))
        }
        other => Err(format!("expected a task, found {other}")),
    }
}

fn unknown(task: TaskId) -> String {
    format!("{task} is not a task of this agent any more")
}

fn not_timed(value: &Value) -> String {
    format!("expected a task, an interval, a result or an instant, found {value}")
}
