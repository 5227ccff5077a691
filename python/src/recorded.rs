//! Flight records: replay, continuation with changes, report.

use crate::errors::{input, mission as failed, warn};
use crate::flight::{Watch, report_value};
use crate::planning::{Means, positive};
use apex_mission::error::{MissionError, MissionResult};
use apex_mission::fork::{Changes, scaled_wind};
use apex_mission::{recorded, recording, scenario};
use apex_model::time::Time;
use apex_runtime::record::RecordReader;
use apex_runtime::trace::{TraceFilter, TraceFormat, trace_record};
use apex_simulation::{ForkTerms, WorldChanges};
use pyo3::prelude::*;
use serde_json::json;
use std::path::{Path, PathBuf};

/// Replays a record and returns the comparison as JSON.
#[pyfunction]
pub(crate) fn replay_json(python: Python<'_>, record: PathBuf) -> PyResult<String> {
    let reader = open(python, &record)?;
    let replayed = python.detach(move || -> MissionResult<String> {
        let report = recorded::replay(&reader)?;
        if report.batches == 0 {
            let message = format!("{} holds no steps: there is nothing to compare", record.display());
            return Err(MissionError::record_file(message).help("fly the mission again"));
        }
        let difference = report.difference.as_ref().map(|difference| {
            json!({
                "t_s": difference.at.seconds(),
                "step": difference.batch,
                "what": difference.what.to_string(),
                "recorded": difference.recorded,
                "replayed": difference.replayed,
            })
        });
        Ok(json!({
            "steps": report.batches,
            "effects": report.effects,
            "problems": report.problems,
            "end_s": report.end.seconds(),
            "difference": difference,
        })
        .to_string())
    });
    replayed.map_err(|failure| failed(python, failure))
}

/// Returns the trace of a record: a line of JSON for each input and each effect.
#[pyfunction]
pub(crate) fn trace_json(python: Python<'_>, record: PathBuf) -> PyResult<String> {
    let reader = open(python, &record)?;
    let traced = python.detach(move || -> MissionResult<String> {
        let lines = trace_record(&reader, Vec::new(), TraceFormat::JsonLines, TraceFilter::default());
        Ok(String::from_utf8_lossy(&lines.map_err(recording::read)?).into_owned())
    });
    traced.map_err(|failure| failed(python, failure))
}

/// Changes after the instant: factor of the wind, seed, lines of inputs, order of visits.
type Differences = (Option<f64>, Option<u64>, Option<String>, Vec<String>);

/// Continues a recorded flight from `at_s` on with changes and records it; returns both reports as JSON. Ctrl-C stops the flight; the
/// exception is raised after the record is closed.
#[pyfunction]
pub(crate) fn fork_json(
    python: Python<'_>,
    record: PathBuf,
    at_s: f64,
    changes: Differences,
    target: (PathBuf, Option<f64>),
    means: &Means,
) -> PyResult<String> {
    let ((wind_factor, seed, inputs, plan), (output, until_s)) = (changes, target);
    if let Some(factor) = wind_factor.filter(|factor| !(0.0..=100.0).contains(factor)) {
        return Err(input(format!("`wind_factor` is {factor:?}: write a number from 0 to 100")));
    }
    if !at_s.is_finite() {
        return Err(input(format!("`at_s` is {at_s:?}: write seconds of mission time")));
    }
    let until = until_s.map(|until_s| positive(until_s, "until_s")).transpose()?.map(Time::from_seconds);
    let means = means.inner.clone();
    let (mut watch, controls) = Watch::new(None);
    let reader = open(python, &record)?;
    let watching = &mut watch;
    let forked = python.detach(move || -> MissionResult<String> {
        let parts = [
            wind_factor.map(|factor| format!("wind times {factor}")),
            seed.map(|seed| format!("seed {seed}")),
            inputs.as_ref().map(|_| "inputs of the caller".to_string()),
            (!plan.is_empty()).then(|| format!("plan {}", plan.join(", "))),
        ];
        let parts: Vec<String> = parts.into_iter().flatten().collect();
        let text = (!parts.is_empty()).then(|| parts.join("; "));
        let wind = match wind_factor {
            Some(factor) => recorded::mission_of(&reader)?.map(|mission| scaled_wind(&mission.weather, factor)),
            None => None,
        };
        let inputs = inputs.map(|text| scenario::parse("the inputs", &text)).transpose()?.unwrap_or_default();
        let changes = (Changes { inputs, plan }, WorldChanges { wind, seed }, text);
        let terms = ForkTerms { until, controls: Some(controls), observer: Some(watching) };
        let forked = apex_simulation::fork(&reader, Time::from_seconds(at_s), changes, means, terms, &output);
        recording::release(&output);
        let forked = forked?;
        Ok(json!({
            "recorded": report_value(&forked.recorded),
            "forked": report_value(&forked.forked.report),
        })
        .to_string())
    });
    if let Some(error) = watch.raised() {
        return Err(error);
    }
    forked.map_err(|failure| failed(python, failure))
}

/// Returns the report of a recorded flight, computed from its steps, as JSON.
#[pyfunction]
pub(crate) fn report_json(python: Python<'_>, record: PathBuf) -> PyResult<String> {
    let reader = open(python, &record)?;
    let reported = python.detach(move || -> MissionResult<String> {
        let Some(mission) = recorded::mission_of(&reader)? else {
            return Err(MissionError::record_file(format!("{} is not the record of a mission", record.display()))
                .because("its program names no vehicle and no targets")
                .help("give a record that `fly` has written"));
        };
        Ok(report_value(&recorded::report_of(&reader, &mission)?).to_string())
    });
    reported.map_err(|failure| failed(python, failure))
}

/// Opens a record. Its warning, such as that it is incomplete, is a `RecordWarning` of Python.
fn open(python: Python<'_>, path: &Path) -> PyResult<RecordReader> {
    let opened = python.detach(|| recording::open(path));
    let (reader, warning) = opened.map_err(|failure| failed(python, failure))?;
    warning.map_or(Ok(()), |text| warn(python, &text))?;
    Ok(reader)
}
