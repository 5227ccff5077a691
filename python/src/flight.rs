//! Flights of missions in the built-in simulator. Other Python threads run during a flight.

use crate::errors::mission as failed;
use crate::planning::{LoadedMission, Means, positive};
use apex_mission::error::MissionResult;
use apex_mission::flight::{FlightOutcome, MissionFlight};
use apex_mission::recording;
use apex_mission::report::Report;
use apex_model::effect::Effect;
use apex_model::event::Batch;
use apex_model::time::Time;
use apex_runtime::ports::Observer;
use apex_runtime::{Control, RunSettings};
use pyo3::prelude::*;
use serde_json::{Map, Value, json};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant};

/// Interval at which a flight lets Python handle signals such as Ctrl-C.
const SIGNALS_EVERY: Duration = Duration::from_millis(50);

/// Flies a mission and records it; returns the end and the report as JSON. An exception of `on_progress`, or Ctrl-C, stops the flight
/// cleanly, and is raised after the record is closed.
#[pyfunction]
pub(crate) fn fly_json(
    python: Python<'_>,
    mission: &LoadedMission,
    record: PathBuf,
    seed: Option<u64>,
    limits: (Option<f64>, Option<f64>),
    means: &Means,
    on_progress: Option<Py<PyAny>>,
) -> PyResult<String> {
    let (until_s, pace) = limits;
    let until = until_s.map(|until_s| positive(until_s, "until_s")).transpose()?.map(Time::from_seconds);
    let pace = pace.map(|pace| positive(pace, "pace")).transpose()?;
    let (mut watch, controls) = Watch::new(on_progress);
    let (mission, means) = (Arc::clone(&mission.inner), means.inner.clone());
    let flown = python.detach(|| -> MissionResult<FlightOutcome> {
        let pace = apex_simulation::pace_of(&mission, pace)?;
        // If the mission cannot be simulated, an older record is left unchanged.
        apex_simulation::world(&mission, seed)?;
        let mut recorder = apex_simulation::create_record(&record, &mission, seed)?;
        if pace.is_some() {
            // The only later command is a stop, so the flight does not wait for inputs from operators.
            let _ = watch.stop.send(Control::Quiet);
        }
        let terms = RunSettings { pace, controls: Some(controls), ..MissionFlight::terms(&mission, until) };
        let flown = apex_simulation::fly(mission, means, seed, terms, &mut recorder, &mut [&mut watch]);
        drop(recorder);
        recording::release(&record);
        flown
    });
    if let Some(error) = watch.raised {
        return Err(error);
    }
    let outcome = flown.map_err(|failure| failed(python, failure))?;
    Ok(json!({
        "end_s": outcome.end.at.seconds(),
        "reason": outcome.end.reason.text(),
        "steps": outcome.end.steps,
        "events": outcome.end.events,
        "effects": outcome.end.effects,
        "report": report_value(&outcome.report),
    })
    .to_string())
}

/// Returns the sections of a report and its text.
pub(crate) fn report_value(report: &Report) -> Value {
    let sections: Map<String, Value> =
        report.sections().into_iter().map(|(name, body)| (name.to_string(), body)).collect();
    json!({ "sections": sections, "text": report.text() })
}

/// Reports the progress of a flight to Python, and stops the flight at a signal or an exception.
pub(crate) struct Watch {
    stop: Sender<Control>,
    on_progress: Option<Py<PyAny>>,
    /// Whole minutes of mission time that were reported.
    minutes: u64,
    asked: Instant,
    raised: Option<PyErr>,
}

impl Watch {
    pub(crate) fn new(on_progress: Option<Py<PyAny>>) -> (Watch, Receiver<Control>) {
        let (stop, controls) = channel();
        (Watch { stop, on_progress, minutes: 0, asked: Instant::now(), raised: None }, controls)
    }

    /// Returns the exception that stopped the flight, if any.
    pub(crate) fn raised(self) -> Option<PyErr> {
        self.raised
    }

    fn ask(&self, progress: Option<f64>) -> PyResult<()> {
        Python::attach(|python| {
            python.check_signals()?;
            match (&self.on_progress, progress) {
                (Some(call), Some(now_s)) => call.bind(python).call1((now_s,)).map(|_| ()),
                _ => Ok(()),
            }
        })
    }
}

impl Observer for Watch {
    fn observe(&mut self, batch: &Batch, _: &[Effect]) -> Result<(), String> {
        let minutes = (batch.now.seconds() / 60.0) as u64;
        let progress = (minutes > self.minutes && self.on_progress.is_some()).then(|| batch.now.seconds());
        if self.raised.is_some() || (progress.is_none() && self.asked.elapsed() < SIGNALS_EVERY) {
            return Ok(());
        }
        self.minutes = self.minutes.max(minutes);
        if let Err(error) = self.ask(progress) {
            self.raised = Some(error);
            // A flight that has already ended need not be stopped.
            let _ = self.stop.send(Control::Stop);
        }
        self.asked = Instant::now();
        Ok(())
    }
}
