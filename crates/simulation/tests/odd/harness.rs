//! A mission from its parts, flown and recorded.

use apex_mission::Mission;
use apex_mission::deliberation::PlanningResources;
use apex_mission::flight::{FlightOutcome, MissionFlight};
use apex_mission::verification::{CheckResult, verify};
use apex_model::effect::Effect;
use apex_model::event::EventKind;
use apex_model::time::Time;
use apex_model::value::Value;
use apex_planning::registry::Registry;
use apex_runtime::record::{RecordReader, RecordedEffect};
use apex_runtime::target_state::TargetState;
use std::path::PathBuf;
use std::sync::Arc;
use tempfile::TempDir;

/// A recorded flight.
pub(crate) struct Flown {
    _folder: TempDir,
    record: PathBuf,
    pub(crate) outcome: FlightOutcome,
}

/// The program of most missions here: a planner chooses, updates lead to new plans, requirements are guarded.
pub(crate) fn program(options: &str, cruise: &str) -> String {
    format!(
        "(defapplication \"Odd\" :type native-sim :libraries (\"vehicle\" \"aerial-observation\" \"contingencies\" \"replanning\") {options}\n \
         :agents ((agent uav-1 :initial-task (fly the mission))))\n\
         (solver auto (index (see them)) :budget 200ms)\n\
         (procedure (index (fly the mission))\n\
           (step up (take off to {cruise}))\n\
           (step survey (see them) (waitfor (end ?up)) (restart-when (new plan)))\n\
           (step again (keep planning (see them)))\n\
           (step safe (guard the flight))\n\
           (step home (return to home at {cruise}) (waitfor (end ?survey)))\n\
           (step finish (terminate) (waitfor (end ?home))))\n"
    )
}

/// Flies the mission of a program and its data files.
pub(crate) fn fly(program: &str, files: &[(&str, &str)]) -> Flown {
    fly_with(apex_solvers::shipped(), program, files)
}

/// Loads the mission of a program and its data files, from the folder that is returned.
pub(crate) fn loaded(program: &str, files: &[(&str, &str)]) -> (TempDir, Mission) {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("mission.pdl"), program).unwrap();
    for (name, text) in files {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let mission = Mission::load(folder.path()).unwrap_or_else(|error| panic!("{error:?}"));
    (folder, mission)
}

/// Like [`fly`], with these planners.
pub(crate) fn fly_with(planners: Registry, program: &str, files: &[(&str, &str)]) -> Flown {
    let (folder, mission) = loaded(program, files);
    let mission = Arc::new(mission);
    let record = folder.path().join("flight.apex");
    let mut recorder = apex_simulation::create_record(&record, &mission, None).unwrap();
    let means = PlanningResources::of(&Arc::new(planners));
    let terms = MissionFlight::terms(&mission, None);
    let outcome = apex_simulation::fly(mission, means, None, terms, &mut recorder, &mut []).unwrap();
    Flown { _folder: folder, record, outcome }
}

impl Flown {
    pub(crate) fn text(&self) -> String {
        self.outcome.report.text()
    }

    /// Returns all events with their instants.
    pub(crate) fn events(&self) -> Vec<(f64, EventKind)> {
        let mut events = Vec::new();
        for step in RecordReader::open(&self.record).unwrap().steps_of_all(Time::END).unwrap() {
            events.extend(step.unwrap().batch.events.into_iter().map(|event| (event.at.seconds(), event.kind)));
        }
        events
    }

    /// Returns all commands with their instants, as text.
    pub(crate) fn commands(&self) -> Vec<(f64, String)> {
        let mut commands = Vec::new();
        for step in RecordReader::open(&self.record).unwrap().steps_of_all(Time::END).unwrap() {
            let step = step.unwrap();
            let command = |recorded: &RecordedEffect| match recorded.effect().unwrap() {
                Effect::Command { form, .. } => Some((step.batch.now.seconds(), form.to_string())),
                _ => None,
            };
            commands.extend(step.effects.iter().filter_map(command));
        }
        commands
    }

    /// Returns time, latitude, longitude and altitude of each reported location.
    pub(crate) fn track(&self) -> Vec<(f64, f64, f64, f64)> {
        let location = |(at_s, kind): (f64, EventKind)| match kind {
            EventKind::Measurement(variable, Value::List(items)) if variable.attribute.is("location") => {
                let number = |index: usize| items[index].as_number().unwrap().0;
                Some((at_s, number(0), number(1), number(2)))
            }
            _ => None,
        };
        self.events().into_iter().filter_map(location).collect()
    }

    /// Returns the part of the track on which the scanner was on.
    pub(crate) fn scanned(&self) -> Vec<(f64, f64, f64, f64)> {
        let is_on = |(at_s, kind): (f64, EventKind)| match kind {
            EventKind::Measurement(variable, value) if variable.attribute.is("scanner-state") => {
                Some((at_s, value.as_symbol().is_some_and(|state| state.is("on"))))
            }
            _ => None,
        };
        let states: Vec<(f64, bool)> = self.events().into_iter().filter_map(is_on).collect();
        let scans = |at_s: f64| states.iter().rfind(|state| state.0 <= at_s).is_some_and(|state| state.1);
        self.track().into_iter().filter(|at| scans(at.0)).collect()
    }

    /// Returns all values of a measured attribute.
    pub(crate) fn numbers(&self, attribute: &str) -> Vec<f64> {
        self.timed_numbers(attribute).into_iter().map(|(_, number)| number).collect()
    }

    /// Returns all values of a measured attribute with their instants.
    pub(crate) fn timed_numbers(&self, attribute: &str) -> Vec<(f64, f64)> {
        let number = |(at_s, kind): (f64, EventKind)| match kind {
            EventKind::Measurement(variable, value) if variable.attribute.is(attribute) => {
                value.as_number().map(|(number, _)| (at_s, number))
            }
            _ => None,
        };
        self.events().into_iter().filter_map(number).collect()
    }

    /// Returns the result of the independent check of the flight.
    pub(crate) fn check(&self) -> CheckResult {
        let reader = RecordReader::open(&self.record).unwrap();
        let mission = apex_mission::recorded::mission_of(&reader).unwrap().unwrap();
        verify(&reader, &mission).unwrap()
    }

    /// Returns the messages from outside the agent that begin with `head`, as text: what it says itself is in the report.
    pub(crate) fn said(&self, head: &str) -> Vec<(f64, String)> {
        let message = |(at_s, kind): (f64, EventKind)| match kind {
            EventKind::Occurrence(form) => {
                form.head().is_some_and(|word| word.is(head)).then(|| (at_s, form.to_string()))
            }
            _ => None,
        };
        self.events().into_iter().filter_map(message).collect()
    }

    /// Returns for each plan of a surveillance its instant, the target of its first visit, and the planned time until the arrival.
    pub(crate) fn first_planned_visits(&self) -> Vec<(f64, String, f64)> {
        let problems = RecordReader::open(&self.record).unwrap().problems().unwrap();
        let first = |plan: &str, at_s: f64| {
            let visit = plan.split_once("\"visits\":[")?.1;
            let after = |key: &str| Some(visit.split_once(key)?.1.split([',', '}', '"']).next()?.to_string());
            Some((at_s, after("\"target\":\"")?, after("\"arrive_s\":")?.parse().ok()?))
        };
        problems.iter().filter_map(|row| first(row.plan.as_ref()?, row.at.seconds())).collect()
    }

    /// Returns the instant at which the observation of a target begins by the first plan of the flight.
    pub(crate) fn planned_begin_s(&self, target: &str) -> f64 {
        let problems = RecordReader::open(&self.record).unwrap().problems().unwrap();
        let plan = problems.iter().find_map(|row| row.plan.clone()).unwrap();
        let visit = plan.split_once(&format!("\"target\":\"{target}\"")).unwrap().1;
        visit.split_once("\"begin_s\":").unwrap().1.split([',', '}']).next().unwrap().parse().unwrap()
    }

    /// Returns the end of the visit of a target, in seconds; none if it was not observed.
    pub(crate) fn observed_s(&self, target: &str) -> Option<f64> {
        let visit = self.outcome.report.visits.iter().find(|visit| visit.target == target)?;
        visit.end.map(Time::seconds)
    }

    /// Returns the reason for which a target was left out.
    pub(crate) fn left_out(&self, target: &str) -> String {
        let found = self.outcome.report.left_out.iter().find(|(name, _)| name == target);
        found.unwrap_or_else(|| panic!("{target} was not left out:\n{}", self.text())).1.clone()
    }

    /// Returns the details of all changes of a target to a state, in order.
    pub(crate) fn target_details(&self, target: &str, state: TargetState) -> Vec<String> {
        let reader = RecordReader::open(&self.record).unwrap();
        let mission = apex_mission::recorded::mission_of(&reader).unwrap().unwrap();
        let situation = apex_mission::recorded::situation_at(&reader, &mission, Time::END).unwrap();
        let changes = situation.target_changes.into_iter();
        changes.filter(|change| change.target == target && change.state == state).map(|change| change.detail).collect()
    }

    /// Positions inside a box of degrees, between two altitudes and two instants.
    pub(crate) fn inside(&self, (west, south, east, north): (f64, f64, f64, f64), low_m: f64, high_m: f64) -> Vec<f64> {
        let holds = |at: &(f64, f64, f64, f64)| {
            (south..north).contains(&at.1) && (west..east).contains(&at.2) && (low_m..high_m).contains(&at.3)
        };
        self.track().into_iter().filter(holds).map(|at| at.0).collect()
    }
}

/// A feature of a GeoJSON file; `properties` are members of the object, as text.
pub(crate) fn feature(properties: &str, geometry: &str) -> String {
    format!(r#"{{"type": "Feature", "properties": {{{properties}}}, "geometry": {geometry}}}"#)
}

pub(crate) fn point(longitude: f64, latitude: f64) -> String {
    format!(r#"{{"type": "Point", "coordinates": [{longitude}, {latitude}]}}"#)
}

/// A box of degrees as a polygon.
pub(crate) fn area((west, south, east, north): (f64, f64, f64, f64)) -> String {
    format!(
        r#"{{"type": "Polygon", "coordinates": [[[{west}, {south}], [{east}, {south}], [{east}, {north}], [{west}, {north}], [{west}, {south}]]]}}"#
    )
}

pub(crate) fn collection(features: &[String]) -> String {
    format!(r#"{{"type": "FeatureCollection", "features": [{}]}}"#, features.join(",\n"))
}

/// The base at which the small vehicles start.
pub(crate) fn home() -> String {
    feature(r#""id": "home", "kind": "base", "elevation_m": 100"#, &point(-121.0, 37.4))
}
