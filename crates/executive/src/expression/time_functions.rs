//! Time functions: start, end and duration of tasks, intervals and results.

use super::EvalContext;
use super::result::FunctionResult;
use apex_model::task::TaskId;
use apex_model::time::Time;
use apex_model::value::Value;

/// Calls the time function `name`; `None` if there is no such function.
pub(super) fn call(name: &str, arguments: &[Value], context: &dyn EvalContext) -> Option<FunctionResult> {
    let [value] = arguments else { return None };
    let now = context.now();
    Some(match name {
        "start-of" => start(value, context).map(Value::Time),
        "end-of" | "time-of" => end(value, context).map(Value::Time),
        "duration-of" => start(value, context).map(|start| Value::Duration(end(value, context).unwrap_or(now) - start)),
        "elapsed" => start(value, context).map(|start| Value::Duration(now - start)),
        "task-state" => task_state(value, context),
        _ => return None,
    })
}

fn start(value: &Value, context: &dyn EvalContext) -> Result<Time, String> {
    match value {
        Value::Time(time) => Ok(*time),
        Value::Interval(start, _) => Ok(*start),
        Value::Task(task) => context.task_start(*task).ok_or_else(|| unknown(*task)),
        other => Err(not_timed(other)),
    }
}

fn end(value: &Value, context: &dyn EvalContext) -> Result<Time, String> {
    match value {
        Value::Time(time) => Ok(*time),
        Value::Interval(_, end) => Ok(*end),
        Value::Task(task) => context.task_end(*task).ok_or_else(|| format!("{task} has not ended yet")),
        other => Err(not_timed(other)),
    }
}

fn task_state(value: &Value, context: &dyn EvalContext) -> FunctionResult {
    match value {
        Value::Task(task) => {
            context.task_state(*task).map(|state| Value::symbol(state.word())).ok_or_else(|| unknown(*task))
        }
        other => Err(format!("expected a task, found {other}")),
    }
}

fn unknown(task: TaskId) -> String {
    format!("{task} is no longer a task of this agent")
}

fn not_timed(value: &Value) -> String {
    format!("expected a task, an interval, a result or an instant, found {value}")
}
