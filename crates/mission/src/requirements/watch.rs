//! The watcher: reads every requirement as the flight continues, and reports it as measurements and alarms.
//!
//! Runs: in the fold of the situation, after each step with a new position or another command; at most once a second near a limit, every
//! ten seconds otherwise. What it reports enters the next batch and is recorded like all inputs: `(margin REQUIREMENT)`,
//! `(time-to-violation REQUIREMENT)`, `(requirement-state REQUIREMENT)`, `(landing-commanded AGENT)`, and the messages
//! `(requirement-at-risk ..)` and `(requirement-kept ..)`.

use super::commanded::{BEHIND_S, Commanded, Flown};
use super::readings::{Known, Reading, Scene};
use super::response::Response;
use super::surface_wind::too_much_wind_at_start;
use super::unjudged::{UNKNOWN, Unjudged};
use crate::Mission;
use crate::in_air::AirState;
use crate::position::PositionFilter;
use crate::vehicle::turn_radius_m;
use crate::ways::STRAIGHT_CLIMB_M;
use crate::wind_error::WindError;
use apex_geo::wind;
use apex_model::effect::Effect;
use apex_model::event::{Batch, EventKind, StateVariable};
use apex_model::quantity::Dimension;
use apex_model::symbol::Symbol;
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
use apex_requirements::alarm::{AlarmState, RequirementSample};
use apex_requirements::response::must_act;
use apex_requirements::{Alarm, Concern, Thresholds};
use apex_runtime::ports::Input;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::LazyLock;

/// Time between readings near a limit, and otherwise.
const NEAR_S: f64 = 1.0;
const FAR_S: f64 = 10.0;
/// A limit is near if its response must begin within this time.
const NEAR_LIMIT_S: f64 = 60.0;
/// Far from every limit, samples are reported this often.
const REPORT_S: f64 = 60.0;
/// An alarm that lasts is repeated: a response may have ended without success.
const REPEAT_S: f64 = 30.0;
/// A storm this near on the route is watched each second.
const NEAR_STORM_S: f64 = 120.0;
/// A new plan for the rest of the mission is requested at most this often.
const REPLAN_S: f64 = 1_800.0;
/// Time without a new position after which no requirement is judged, as in the check of flights.
const SILENT_S: f64 = 60.0;
/// Significant digits of reported margins.
const DIGITS: i32 = 3;

/// Attributes that are reported of each requirement, and values that most reports contain: created once, because reports are frequent.
static MARGIN: LazyLock<Symbol> = LazyLock::new(|| Symbol::new("margin"));
static TIME_TO_VIOLATION: LazyLock<Symbol> = LazyLock::new(|| Symbol::new("time-to-violation"));
static REQUIREMENT_STATE: LazyLock<Symbol> = LazyLock::new(|| Symbol::new("requirement-state"));
static LANDING_COMMANDED: LazyLock<Symbol> = LazyLock::new(|| Symbol::new("landing-commanded"));
static NONE: LazyLock<Value> = LazyLock::new(|| Value::symbol("none"));
static KEPT: LazyLock<Value> = LazyLock::new(|| Value::symbol("kept"));

/// State of the watcher.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Watch {
    commanded: Commanded,
    flown: Flown,
    positions: PositionFilter,
    read_s: Option<f64>,
    /// The number of changes of the command that was read last.
    read_changes: u32,
    is_near: bool,
    /// Instant of the last new position.
    moved_s: Option<f64>,
    /// `landing-commanded` as reported last.
    says_landing: bool,
    storm: StormWatch,
    requirements: BTreeMap<String, RequirementState>,
}

/// State of the reports about storms.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct StormWatch {
    /// True while a cell is known.
    is_reported: bool,
    /// The landing place under a storm to which the command leads, and the instant since when.
    waits_for: Option<(String, f64)>,
}

/// State of one requirement.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct RequirementState {
    alarm: Alarm,
    reported_s: Option<f64>,
    /// True while it cannot be judged; a note has reported it once.
    is_unjudged: bool,
    has_noted_unjudged: bool,
    said_s: Option<f64>,
    /// Instant of the last request to plan the rest of the mission again.
    replanned_s: Option<f64>,
    /// The alarm as it was noted for the report last: a repetition of it is not noted again.
    noted: Option<(String, String)>,
}

/// Report of the watcher after a step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Findings {
    /// Inputs for the next batch.
    pub inputs: Vec<Input>,
    /// Lines for the report.
    pub notes: Vec<String>,
}

impl Watch {
    /// Returns the turbulence as last measured, m^(2/3)/s.
    pub(crate) fn edr(&self) -> Option<f64> {
        self.flown.edr
    }

    /// Returns the speed of the wind as last measured.
    pub(crate) fn wind_mps(&self) -> Option<f64> {
        self.flown.wind_mps
    }

    /// Returns the error of the forecast of the wind as measured.
    pub(crate) fn wind_error(&self) -> &WindError {
        &self.flown.wind_error
    }

    /// Observes a step of the agent that flies.
    pub(crate) fn observe(&mut self, known: Known<'_>, air: &AirState, batch: &Batch, effects: &[Effect]) -> Findings {
        let (mission, forecast, ..) = known;
        self.flown.is_on_ground = air.is_on_ground();
        let mut moved = false;
        let vehicle = &mission.agent.name;
        for event in &batch.events {
            match &event.kind {
                EventKind::Measurement(variable, value) if variable.object.as_symbol() == Some(vehicle) => {
                    let attribute = variable.attribute.folded();
                    if self.positions.admits(mission, event.at.seconds(), attribute, value) {
                        moved |= self.flown.measure(attribute, value);
                    }
                }
                EventKind::Measurement(variable, value) => {
                    self.flown.measure_part(mission, event.at.seconds(), variable, value);
                }
                kind => self.commanded.hear(kind),
            }
        }
        for effect in effects {
            self.commanded.take(batch.now.seconds(), effect, |value| mission.place(value));
        }
        let now_s = batch.now.seconds();
        let mut findings = Findings::default();
        self.report_landing(known.0, batch.now, &mut findings);
        if moved {
            self.moved_s = Some(now_s);
        }
        if let Some(here) = self.flown.position.filter(|_| moved) {
            let flown = &self.flown;
            let behind_m = if turn_radius_m(&mission.model) > 0.0 {
                BEHIND_S * mission.model.true_airspeed_m_s_cruise
            } else {
                0.0
            };
            self.commanded.pass(here, (now_s, behind_m), || flown.track_deg());
            if flown.height_above_ground_m.is_some_and(|height_m| height_m >= STRAIGHT_CLIMB_M) {
                self.commanded.begin_turns(here);
            }
            if let Some(measured) = flown.wind().filter(|_| !flown.is_on_ground) {
                let expected = wind::at(forecast, here, flown.altitude_m, now_s);
                self.flown.wind_error.take(measured, expected, now_s);
            }
        }
        let changed = self.commanded.changes != self.read_changes;
        let period_s = if self.is_near { NEAR_S } else { FAR_S };
        let due = self.read_s.is_none_or(|read_s| now_s - read_s >= period_s);
        if self.flown.is_on_ground {
            return findings;
        }
        if self.moved_s.is_some_and(|moved_s| now_s - moved_s > SILENT_S) {
            for (name, watched) in &mut self.requirements {
                watched.report_unjudged((name, "its position"), batch.now, &mut findings);
            }
        } else if moved && due || changed {
            self.read(known, batch.now, &mut findings);
        }
        findings
    }

    /// Reports whether a landing is commanded, for a vehicle that does not report its flight phase: programs would otherwise assume that
    /// it continues its mission.
    fn report_landing(&mut self, mission: &Mission, now: Time, findings: &mut Findings) {
        let lands = self.flown.is_near_ground.is_none() && self.commanded.lands();
        if lands != self.says_landing {
            self.says_landing = lands;
            let variable = StateVariable::new(LANDING_COMMANDED.clone(), Value::Symbol(mission.agent.name.clone()));
            let value = if lands { Value::symbol("t") } else { Value::nil() };
            findings.inputs.push(Input::new(now, EventKind::Measurement(variable, value)));
        }
    }

    fn read(&mut self, known: Known<'_>, now: Time, findings: &mut Findings) {
        let now_s = now.seconds();
        super::ice_level::update(&mut self.flown, known.0, &self.commanded, now_s);
        findings.inputs.extend(super::ice_level::report(&mut self.flown, known.0, &self.commanded, now));
        let Some(scene) = Scene::new(known, &self.flown, &self.commanded, now_s) else { return };
        // The vehicle's slowest report limits how soon the next reading can follow.
        let loop_s = known.0.model.report.cruise_s.clamp(NEAR_S, FAR_S);
        let is_first = self.read_s.is_none();
        let is_new_instant = self.read_s.is_none_or(|read_s| now_s > read_s);
        (self.read_s, self.read_changes, self.is_near) = (Some(now_s), self.commanded.changes, scene.is_joining());
        if is_first && let Some(reason) = too_much_wind_at_start(known.0) {
            findings.notes.push(reason);
        }
        self.is_near |= self.storm.report(&scene, now, findings);
        let unjudged = scene.unjudged();
        for Unjudged { name, missing } in &unjudged {
            let watched = self.requirements.entry((*name).to_string()).or_default();
            watched.report_unjudged((name, missing), now, findings);
        }
        for reading in scene.readings() {
            let is_urgent = |within_s: f64| {
                reading.margin < 0.0
                    || reading.after_s.is_some_and(|after_s| must_act(after_s, reading.response_s + within_s, loop_s))
            };
            let watched = self.requirements.entry(reading.name.to_string()).or_default();
            let must_act = is_urgent(0.0);
            let sample = RequirementSample { at_s: now_s, margin: reading.margin, must_act };
            // Two readings of one instant count as one sample.
            let change = if is_new_instant { watched.alarm.take(sample, &Thresholds::new(0.0)) } else { None };
            let is_raised = watched.alarm.state() == AlarmState::Raised;
            let is_near = is_raised || is_urgent(NEAR_LIMIT_S);
            self.is_near |= is_near;
            let rests = watched.replanned_s.is_some_and(|said_s| now_s - said_s < REPLAN_S);
            if !rests && scene.wants_replanning(&reading) {
                watched.replanned_s = Some(now_s);
                findings.say(now, vec![Value::symbol("off-schedule"), Value::symbol(reading.name)]);
                let left = Value::measured(rounded(reading.margin), reading.unit);
                findings.notes.push(format!("{} is in {left} more than the way home takes", reading.name));
            }
            // A reading without reports of the vehicle only predicts: it can raise an alarm, and does not say that the requirement is kept.
            if is_raised || unjudged.iter().all(|other| other.name != reading.name) {
                watched.report(&reading, now, is_near || change.is_some(), findings);
            }
            let repeat = watched.said_s.is_none_or(|said_s| now_s - said_s >= REPEAT_S);
            let is_raised_now = change == Some(AlarmState::Raised) || (is_raised && must_act && repeat);
            // Near the ground a fixed wing that takes off can only climb straight ahead: the alarm is raised after that, if it lasts.
            let waits = scene.climbs_from_the_ground() && reading.concern != Concern::Sensor;
            if is_raised_now && !waits {
                watched.said_s = Some(now_s);
                let said = raise(&scene, &reading, watched.alarm.is_escalated(), now, findings);
                let subject = (reading.what.clone(), said.0.word().to_string());
                if watched.noted.as_ref() != Some(&subject) {
                    findings.notes.push(said.1);
                    watched.noted = Some(subject);
                }
            } else if change == Some(AlarmState::Kept) && watched.noted.is_some() {
                findings.say(now, vec![Value::symbol("requirement-kept"), Value::symbol(reading.name)]);
                findings.notes.push(format!("{} is kept again", reading.name));
                watched.noted = None;
            }
        }
    }
}

impl StormWatch {
    /// Reports the storms in the way, in flights in which a cell has been seen; returns true if one is near on the route.
    fn report(&mut self, scene: &Scene<'_>, now: Time, findings: &mut Findings) -> bool {
        let is_clear = scene.storms.cells().is_empty();
        if is_clear && !self.is_reported {
            return false;
        }
        let (now_s, storm_s) = (now.seconds(), scene.storm_time_s());
        let awaited = scene.awaited_site();
        if self.waits_for.as_ref().map(|(name, _)| name.as_str()) != awaited {
            self.waits_for = awaited.map(|name| (name.to_string(), now_s));
        }
        let waited_s = self.waits_for.as_ref().map_or(0.0, |(_, since_s)| now_s - since_s);
        self.is_reported = !is_clear;
        let is_between = if scene.is_storm_between() { Value::symbol("t") } else { Value::nil() };
        for (attribute, value) in [
            ("storm-time", Value::Real(libm::round(storm_s))),
            ("storm-between", is_between),
            ("storm-wait", Value::measured(libm::round(waited_s), Dimension::TIME)),
        ] {
            let variable = StateVariable::new(Symbol::new(attribute), Value::Symbol(scene.mission.agent.name.clone()));
            findings.inputs.push(Input::new(now, EventKind::Measurement(variable, value)));
        }
        storm_s < NEAR_STORM_S
    }
}

/// Reports that a requirement needs a response; returns the response, and a line for the report.
fn raise(
    scene: &Scene<'_>,
    reading: &Reading,
    is_escalated: bool,
    now: Time,
    findings: &mut Findings,
) -> (Response, String) {
    let (response, way_out) = scene.recovery(reading, is_escalated);
    let violated_s = now.seconds() + reading.after_s.unwrap_or(0.0);
    let instant = Duration::from_seconds(libm::round(violated_s * 10.0) / 10.0);
    let margin = Value::measured(rounded(reading.margin), reading.unit);
    let note = format!(
        "{} at risk: {} at {}, margin now {margin}; response: {}",
        reading.name,
        reading.what,
        Time::from_seconds(libm::round(violated_s)),
        response.word()
    );
    findings.say(
        now,
        vec![
            Value::symbol("requirement-at-risk"),
            Value::symbol(reading.name),
            Value::text(&reading.what),
            Value::Duration(instant),
            margin,
            Value::symbol(response.word()),
            match response {
                Response::Stow | Response::Cool => Value::symbol(&reading.what),
                _ => way_out.value(),
            },
        ],
    );
    (response, note)
}

impl RequirementState {
    /// Reports that the requirement cannot be judged, if that is new or due, and notes it once; the vehicle does not report `missing`.
    fn report_unjudged(&mut self, (name, missing): (&str, &str), now: Time, findings: &mut Findings) {
        let due = self.reported_s.is_none_or(|reported_s| now.seconds() - reported_s >= REPORT_S);
        if self.is_unjudged && !due {
            return;
        }
        if !std::mem::replace(&mut self.has_noted_unjudged, true) {
            findings.notes.push(format!("{name} is not judged: the vehicle does not report {missing}"));
        }
        (self.reported_s, self.is_unjudged) = (Some(now.seconds()), true);
        let variable = StateVariable::new(REQUIREMENT_STATE.clone(), Value::symbol(name));
        findings.inputs.push(Input::new(now, EventKind::Measurement(variable, UNKNOWN.clone())));
    }

    /// Reports the samples of a requirement, if they are due.
    fn report(&mut self, reading: &Reading, now: Time, is_wanted: bool, findings: &mut Findings) {
        let due = self.reported_s.is_none_or(|reported_s| now.seconds() - reported_s >= REPORT_S);
        if !(is_wanted || due || self.is_unjudged) {
            return;
        }
        (self.reported_s, self.is_unjudged) = (Some(now.seconds()), false);
        let state = match self.alarm.state() {
            AlarmState::Kept => KEPT.clone(),
            AlarmState::Raised => Value::symbol("at-risk"),
        };
        let after = reading.after_s.map_or_else(
            || NONE.clone(),
            |after_s| Value::measured(libm::round(after_s * 10.0) / 10.0, Dimension::TIME),
        );
        let name = Value::symbol(reading.name);
        for (attribute, value) in [
            (&*MARGIN, Value::measured(rounded(reading.margin), reading.unit)),
            (&*TIME_TO_VIOLATION, after),
            (&*REQUIREMENT_STATE, state),
        ] {
            let variable = StateVariable::new(attribute.clone(), name.clone());
            findings.inputs.push(Input::new(now, EventKind::Measurement(variable, value)));
        }
    }
}

impl Findings {
    fn say(&mut self, now: Time, items: Vec<Value>) {
        self.inputs.push(Input::new(now, EventKind::Occurrence(Value::list(items))));
    }
}

/// Returns a number with [`DIGITS`] significant digits.
fn rounded(number: f64) -> f64 {
    if number == 0.0 || !number.is_finite() {
        return number;
    }
    let magnitude = libm::floor(libm::log10(number.abs())) as i32;
    let scale = libm::pow(10.0, f64::from(DIGITS - 1 - magnitude));
    libm::round(number * scale) / scale
}

#[cfg(test)]
#[path = "watch_tests.rs"]
mod tests;
