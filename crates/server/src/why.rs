//! `/api/why`: a task at an instant and its explanation.

use crate::answer::{ApiError, ApiResult, Remedy};
use crate::state::AppState;
use apex_model::source::SourceFile;
use apex_model::task::TaskId;
use apex_model::time::Time;
use apex_runtime::explain::{Explainer, Monitors, TaskExplanation};
use apex_runtime::record::view::TaskLookup;

/// Explains task `id` at mission time `at_ns`. With `restore` the answer includes what only the restored agent knows; if the agent cannot
/// be restored, the answer states the reason and is made from the record's decisions alone.
pub(crate) fn why(state: &AppState, id: u64, at_ns: i64, restore: bool) -> ApiResult<TaskExplanation> {
    let (task, children) = match state.read(|view| Ok(view.task(id, at_ns)?))? {
        TaskLookup::Found { task, children } => (task, children),
        TaskLookup::NotYet { created_ns } => {
            return Err(ApiError::not_found(
                format!("task T{id} did not exist yet at {at_ns} ns"),
                format!("it was created at {created_ns} ns"),
            ));
        }
        TaskLookup::Unknown => {
            return Err(ApiError::not_found(
                format!("there is no task T{id} in this record"),
                Remedy::Tasks.help("`/api/tasks` lists the tasks of an instant"),
            ));
        }
    };
    // Restoring an instant may take long: a separate connection keeps the shared one free.
    let reader = state.reader()?;
    let load = state.load.as_deref().filter(|_| restore);
    // The program of a record never changes, so it is checked once. If it cannot be loaded, it is loaded again for the error message.
    let program = load.and_then(|_| state.program());
    let (id, at) = (TaskId(id), Time(at_ns));
    let decided = || Explainer::of_decisions(&reader).task(id, at);
    let (why, error) = match load {
        None => (decided()?, None),
        Some(load) => {
            let load = |sources: &[SourceFile]| program.clone().map_or_else(|| load(sources), Ok);
            match Explainer::new(&reader, &load).task(id, at) {
                Ok(why) => (why, None),
                Err(error) => (decided()?, Some(error.to_string())),
            }
        }
    };
    Ok(TaskExplanation::new(at_ns, *task, children, why, error))
}

/// Returns the conditions that living tasks watch at an instant; with `id`, only those of that task, with its variables.
pub(crate) fn monitors(state: &AppState, at_ns: Option<i64>, id: Option<u64>) -> ApiResult<Monitors> {
    let reader = state.reader()?;
    let program = state.program().ok_or_else(|| {
        ApiError::bad_request(
            "the record's program cannot be loaded, so its state at an instant cannot be restored",
            "read the record with the version of Apex that wrote it; `/api/mission` names it",
        )
    })?;
    let load = |_: &[SourceFile]| Ok(program.clone());
    let at = Time(at_ns.unwrap_or(i64::MAX));
    Ok(Explainer::new(&reader, &load).monitors(at, id.map(TaskId))?)
}
