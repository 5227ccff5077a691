//! Series of flights in the built-in simulator. Other Python threads run meanwhile.

use crate::errors::mission as failed;
use crate::planning::{LoadedMission, Means, positive};
use apex_model::time::Time;
use apex_simulation::{RunSummary, RunTerms, RunsTable, fly_runs};
use pyo3::prelude::*;
use serde_json::json;
use std::path::PathBuf;
use std::sync::Arc;

/// Flies a mission in the worlds of `runs` seeds; returns the rows and the summary as JSON, and writes the rows to a table. An exception of
/// `on_progress`, or Ctrl-C, ends the series after the flights in progress, and is then raised.
#[pyfunction]
pub(crate) fn fly_runs_json(
    python: Python<'_>,
    mission: &LoadedMission,
    series: (Option<u64>, usize, usize),
    ends: (Option<f64>, Option<PathBuf>),
    means: &Means,
    on_progress: Option<Py<PyAny>>,
) -> PyResult<String> {
    let ((first_seed, runs, jobs), (until_s, out)) = (series, ends);
    let until = until_s.map(|until_s| positive(until_s, "until_s")).transpose()?.map(Time::from_seconds);
    let terms = RunTerms { first_seed, runs, jobs, until };
    let table = out.map(|path| RunsTable::open(&path)).transpose().map_err(|failure| failed(python, failure))?;
    let (mission, means) = (Arc::clone(&mission.inner), means.inner.clone());
    let mut raised = None;
    let mut flown = 0_usize;
    let rows = python.detach(|| {
        fly_runs(&mission, &means, &terms, || {
            flown += 1;
            let told = Python::attach(|python| {
                python.check_signals()?;
                on_progress.as_ref().map_or(Ok(()), |call| call.bind(python).call1((flown,)).map(|_| ()))
            });
            raised = raised.take().or(told.err());
            raised.is_none()
        })
    });
    if let Some(error) = raised {
        return Err(error);
    }
    let rows = rows.map_err(|failure| failed(python, failure))?;
    table.map_or(Ok(()), |table| table.write(&rows)).map_err(|failure| failed(python, failure))?;
    Ok(json!({ "summary": RunSummary::of(&rows), "summary_text": RunSummary::of(&rows).to_string(), "runs": rows })
        .to_string())
}
