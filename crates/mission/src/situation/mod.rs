//! The situation: what is known and assumed of a mission at an instant. A pure function of the batches and effects in the record, so that
//! it can be computed again, stored and continued.

#[cfg(test)]
mod believed_tests;
mod contingency;
mod ending;
mod event;
mod kept;
mod news;
mod position_watch;
mod scan_line;
mod storms;
mod updates;
mod visit;

pub(crate) use ending::{Ending, NoPlanReason};
pub use event::MissionEvent;
pub use kept::{Chosen, MadePlan, Note};
use position_watch::PositionWatch;
pub use scan_line::ScanLine;
use storms::StormyVisits;
pub use updates::{MissionUpdate, MissionUpdates, OperatorPlan};
pub use visit::{VehicleState, Visit};

use crate::Mission;
use crate::diagnosis::DiagnosisService;
use crate::in_air::AirState;
use crate::link::LinkMemory;
use crate::position::PositionFilter;
use crate::predicted::Predicted;
use crate::requirements::Watch;
use crate::storm::StormMemory;
use crate::wind_error::WindError;
use apex_geo::wind;
use apex_model::effect::{DecisionKind, Effect, Method, SolveRequestId};
use apex_model::event::{Batch, EventKind, SolverReport};
use apex_model::limits::SOLVE_REQUESTS_MAX;
use apex_model::planned::{Location, PlannedActivity};
use apex_model::problem::Plan;
use apex_model::source::Place;
use apex_model::time::Time;
use apex_model::value::Value;
use apex_runtime::ports::Input;
use apex_runtime::target_state::{TargetChange, TargetState};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// Maximum number of goals whose chosen procedure is remembered; more than any mission has.
const CHOSEN_MAX: usize = 10_000;

/// Knowledge and assumptions of a mission.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Situation {
    /// Observations in order of their beginning.
    pub visits: Vec<Visit>,
    /// Notable decisions in order.
    pub notes: Vec<Note>,
    /// The vehicle.
    pub vehicle: VehicleState,
    positions: PositionFilter,
    position_watch: PositionWatch,
    /// New data of targets and weather.
    pub updates: MissionUpdates,
    /// Instant from which the visits of an imposed plan count.
    imposed_from: Time,
    /// Changes of targets' states in order.
    pub target_changes: Vec<TargetChange>,
    /// The plan that the executive adopted last.
    pub plan: Option<MadePlan>,
    /// The procedure that was chosen last for each goal, by its text.
    pub chosen: BTreeMap<String, Chosen>,
    /// Number of planning problems posed so far, by all agents.
    pub posed: u32,
    /// Number of plans that the executive has adopted.
    pub adopted: u32,
    /// Instant of each request without an answer.
    asked: BTreeMap<SolveRequestId, Time>,
    /// Plans that the executive may still adopt.
    answers: BTreeMap<SolveRequestId, MadePlan>,
    /// Lines of each target whose observation has been chosen.
    planned_lines: BTreeMap<String, Vec<ScanLine>>,
    /// Beginning of the first of these lines.
    line_begins: BTreeMap<String, Location>,
    /// Requirements compared with the flight.
    watch: Watch,
    /// Measurements of radio links.
    pub links: LinkMemory,
    /// Cells on the weather radar.
    pub storms: StormMemory,
    /// Visits for which a storm was announced, and plans were requested again.
    stormy: StormyVisits,
    /// Outcomes of tests and the diagnoses derived from them.
    pub diagnosis: DiagnosisService,
    /// The landing by a contingency, if there is one.
    landing: contingency::ContingencyLanding,
    /// Facts about the end of the flight.
    ending: Ending,
    /// Whether the vehicle is in the air.
    air: AirState,
    /// Additions of the last step to the next batch: a function of the rest, and not stored.
    #[serde(skip)]
    derived: Vec<Input>,
}

impl Situation {
    /// Observes one step of the agent with this number. Only the first agent flies: measurements and effects of the others do not concern
    /// the vehicle.
    pub fn observe(&mut self, mission: &Mission, agent: usize, batch: &Batch, effects: &[Effect]) {
        self.derived.clear();
        let requests = effects.iter().filter(|effect| matches!(effect, Effect::Solve(_))).count();
        self.posed = self.posed.saturating_add(u32::try_from(requests).unwrap_or(u32::MAX));
        if agent != 0 {
            return;
        }
        let vehicle = &mission.agent.name;
        self.air.observe(batch, effects, |object| object.as_symbol() == Some(vehicle));
        self.ending.observe(&self.air, batch, effects);
        if let Some(missing) = self.air.take_missing() {
            self.note(batch.now, missing);
        }
        let mut moved = false;
        for event in &batch.events {
            match &event.kind {
                EventKind::Measurement(variable, value) => {
                    let attribute = variable.attribute.folded();
                    let is_own = variable.object.as_symbol() == Some(&mission.agent.name);
                    let is_position = attribute == "location";
                    if is_position && !is_own {
                        continue;
                    }
                    let is_accepted = self.positions.admits(mission, event.at.seconds(), attribute, value);
                    if is_position {
                        self.notes.extend(self.position_watch.take(event.at, value, is_accepted));
                    }
                    if is_accepted {
                        moved |= is_position;
                        self.vehicle.measure(attribute, value);
                    }
                }
                EventKind::Occurrence(form) => self.take_message(mission, event.at, form),
                EventKind::SolverReported(request, report) => self.take_answer(event.at, *request, report),
                _ => {}
            }
        }
        self.notes.extend(self.position_watch.look(batch.now, self.air.is_on_ground()));
        if moved && let Some(visit) = self.visits.last_mut().filter(|visit| visit.end.is_none()) {
            visit.scan(&self.vehicle, mission.model.level_roll_deg_max);
        }
        for effect in effects {
            self.take_effect(mission, batch.now, effect);
        }
        let areas = self.storms.observe(mission, batch, effects);
        self.watch(mission, batch, effects);
        self.derived.extend(areas);
        self.derived.extend(self.outdated(batch));
        self.compare_storms(mission, batch.now);
        self.derived.extend(self.links.observe((mission, &self.air), batch, effects));
        if let Some(model) = &mission.diagnosis {
            let reported = self.diagnosis.observe(model, batch, effects);
            reported.notes.into_iter().for_each(|note| self.note(batch.now, note));
            self.derived.extend(reported.inputs);
        }
        if requests > 0 {
            // Data that planning cannot use are reported when a plan is requested.
            for unknown in self.updates.unknown(mission) {
                self.note_once(batch.now, &unknown);
            }
        }
    }

    /// Compares the requirements with the flight, by the forecast that is presently assumed.
    fn watch(&mut self, mission: &Mission, batch: &Batch, effects: &[Effect]) {
        let forecast = self.updates.forecast(mission);
        let findings = self.watch.observe((mission, forecast, &self.links, &self.storms), &self.air, batch, effects);
        for note in findings.notes {
            self.note(batch.now, note);
        }
        self.derived = findings.inputs;
    }

    /// Requests a new plan where a storm is in the way of the present one.
    fn compare_storms(&mut self, mission: &Mission, now: Time) {
        let mut stormy = self.stormy.clone();
        let Some(made) = self.plan.as_ref().filter(|_| self.storms.is_avoiding()) else { return };
        let observed: Vec<&str> = self.observed().map(|visit| visit.target.as_str()).collect();
        let plan = (&made.plan, made.made.seconds(), observed.as_slice());
        let (notes, input) = stormy.compare((mission, &self.storms), plan, now);
        self.stormy = stormy;
        self.derived.extend(input);
        notes.into_iter().for_each(|note| self.note(now, note));
    }

    /// Returns the inputs that the last step adds to the next batch, and clears them.
    pub fn take_derived(&mut self) -> Vec<Input> {
        std::mem::take(&mut self.derived)
    }

    /// Returns the observations that have ended.
    pub fn observed(&self) -> impl Iterator<Item = &Visit> {
        self.visits.iter().filter(|visit| visit.end.is_some())
    }

    /// Returns the visits of the imposed plan that are still open, in order. A site may be visited repeatedly: visits before the plan was
    /// imposed do not count for it. A fire that has been observed is done.
    pub(crate) fn open_imposed(&self, is_site: impl Fn(&str) -> bool) -> Vec<String> {
        let mut done: Vec<&str> = Vec::new();
        for visit in self.observed().filter(|visit| visit.end.is_some_and(|end| end > self.imposed_from)) {
            done.push(&visit.target);
        }
        let mut is_open = |target: &&String| {
            if !is_site(target) {
                return !self.observed().any(|visit| visit.target == **target);
            }
            let found = done.iter().position(|visited| visited == target);
            found.map(|index| done.remove(index)).is_none()
        };
        self.updates.imposed().iter().filter(|target| is_open(target)).cloned().collect()
    }

    /// Returns the turbulence as last measured, m^(2/3)/s.
    pub(crate) fn edr(&self) -> Option<f64> {
        self.watch.edr()
    }

    /// Returns the speed of the wind as last measured.
    pub(crate) fn wind_mps(&self) -> Option<f64> {
        self.watch.wind_mps()
    }

    /// Returns the mission with the forecast of the wind as corrected by measurements.
    pub(crate) fn in_measured_wind(&self, mission: Mission, now_s: f64) -> Mission {
        match self.wind_error().field(&mission.forecast, now_s) {
            Some(forecast) => Mission { forecast, ..mission },
            None => mission,
        }
    }

    /// Returns the error of the forecast of the wind as measured.
    pub(crate) fn wind_error(&self) -> &WindError {
        self.watch.wind_error()
    }

    /// Returns what is known about the end of the flight.
    pub(crate) fn ending(&self) -> &Ending {
        &self.ending
    }

    fn open_visit(&mut self) -> Option<&mut Visit> {
        self.visits.last_mut().filter(|visit| visit.end.is_none())
    }

    fn note(&mut self, at: Time, text: String) {
        self.notes.push(Note { at, text });
    }

    fn note_once(&mut self, at: Time, text: &str) {
        if !self.notes.iter().any(|note| note.text == text) {
            self.note(at, text.to_string());
        }
    }

    /// Returns the prediction of the present plan for an observation. A visit of a plan begins with the lead-in of its first line, an
    /// observation with that line.
    fn predicted(&self, mission: &Mission, target: &str) -> Option<Predicted> {
        let Plan::SingleVisit(plan) = &self.plan.as_ref()?.plan else { return None };
        let visit = plan.visits.iter().find(|visit| visit.target == target)?;
        let lead_in = visit.route.last().zip(self.line_begins.get(target));
        let lead_in_s = lead_in.and_then(|(entry, begin)| {
            let airspeed_mps = mission.model.true_airspeed_m_s_cruise;
            let forecast = self.updates.forecast(mission);
            wind::leg_time_s(*entry, begin.position, begin.altitude_m, airspeed_mps, forecast, visit.begin_s)
        });
        Predicted::of(visit, lead_in_s.unwrap_or(0.0))
    }

    fn change(&mut self, target: String, at: Time, state: TargetState, detail: String) {
        self.target_changes.push(TargetChange { target, at, state, detail });
    }

    fn state_of(&self, target: &str) -> Option<TargetState> {
        self.target_changes.iter().rev().find(|change| change.target == target).map(|change| change.state)
    }

    fn take_message(&mut self, mission: &Mission, at: Time, form: &Value) {
        let Some(event) = MissionEvent::read(form) else { return };
        match event {
            MissionEvent::Observing(target) => {
                let is_new = self.open_visit().is_none_or(|visit| visit.target != target);
                // A plan made during the visit has planned it again.
                if is_new || self.state_of(&target) != Some(TargetState::Observing) {
                    self.change(target.clone(), at, TargetState::Observing, String::new());
                }
                if is_new {
                    let lines = self.planned_lines.get(&target).cloned().unwrap_or_default();
                    let predicted = self.predicted(mission, &target);
                    self.visits.push(Visit::new(target, at, lines, predicted));
                }
            }
            MissionEvent::Observed(target) => {
                if let Some(visit) = self.open_visit().filter(|visit| visit.target == target) {
                    visit.end = Some(at);
                }
                self.change(target, at, TargetState::Observed, String::new());
            }
            // The visit is left without an end, as after an interruption: the target is still open.
            MissionEvent::NotObserved { target, why } => {
                self.note(at, format!("{target} was not observed: {why}"));
                self.change(target, at, TargetState::Skipped, why);
            }
            MissionEvent::WingsLevelViolation(target) => {
                self.note(at, format!("wings were not level over {target}"));
            }
            MissionEvent::SegmentWeighed { target, is_again, text } => {
                if let Some(visit) = self.open_visit().filter(|_| is_again) {
                    visit.reflies += 1;
                }
                let what = if is_again { "re-fly" } else { "no re-fly" };
                self.note(at, format!("{what} over {target}: {text}"));
            }
            MissionEvent::ReplanWanted(reason) => self.note(at, format!("replanning wanted: {reason}")),
            MissionEvent::CommunicationLost(link) => {
                let response = if self.links.is_everywhere(&link) { "waiting here" } else { "going back" };
                self.note(at, format!("communication over {link} lost: {response}"));
            }
            MissionEvent::CommunicationRegained(link) => self.note(at, format!("communication over {link} regained")),
            MissionEvent::CommunicationNotRegained(link) => {
                self.note(at, format!("communication over {link} not regained where it was good"));
            }
            MissionEvent::AwaitingInstructions { link, default } => {
                self.note(at, format!("awaiting instructions over {link}; without one: {default}"));
            }
            MissionEvent::Instructed { instruction, .. } => self.note(at, format!("instructed: {instruction}")),
            MissionEvent::ContingencyRoute { link, place, why } => {
                self.note(at, format!("contingency route to {place}: {link} {why}"));
            }
            // A picture during an observation, whose end is reported separately, or a picture straight down without a target.
            MissionEvent::ImageInMemory(target)
                if target == "down"
                    || self
                        .open_visit()
                        .is_some_and(|visit| visit.target.split('/').next() == Some(target.as_str())) => {}
            MissionEvent::ImageInMemory(target) => {
                self.change(target.clone(), at, TargetState::Observed, String::new());
                self.note(at, format!("picture of {target} in memory"));
            }
            MissionEvent::RequirementBroken { names, why } => {
                self.notes.extend(self.landing.broken(names.join("; "), &why).map(|text| Note { at, text }));
            }
            MissionEvent::Contingency { line, lands } => {
                self.landing.begin_if(lands);
                self.note(at, line);
            }
            MissionEvent::LowFuel => self.note(at, "fuel is low".to_string()),
            MissionEvent::Update(update) => self.take_update(mission, at, update),
        }
    }

    fn take_answer(&mut self, at: Time, request: SolveRequestId, report: &SolverReport) {
        let made = self.asked.remove(&request).unwrap_or(at);
        match report {
            SolverReport::Failed(reason) => {
                self.note(at, format!("no plan: {reason}"));
                self.ending.take_missing_plan(request, NoPlanReason::Failed(reason.clone()));
            }
            SolverReport::Plan(procedure) => {
                let Some(plan) = &procedure.plan else { return };
                self.answers.insert(request, MadePlan { plan: plan.as_ref().clone(), made });
                // The executive adopts a plan when it arrives; older answers are never adopted later.
                while self.answers.len() > SOLVE_REQUESTS_MAX {
                    self.answers.pop_first();
                }
            }
        }
    }

    fn take_effect(&mut self, mission: &Mission, now: Time, effect: &Effect) {
        match effect {
            Effect::Inform { form, .. } => self.take_message(mission, now, form),
            Effect::Solve(request) => {
                self.asked.insert(request.request, now);
            }
            Effect::CancelSolve(request) => {
                self.asked.remove(request);
            }
            Effect::Decided(decision) => match &decision.kind {
                DecisionKind::Selected { goal, method: Method::Procedure(place), .. } => {
                    self.take_choice(now, goal, *place);
                }
                DecisionKind::ProcedureAdded { request, summary, .. } => {
                    self.take_plan(mission, now, *request, summary)
                }
                DecisionKind::Trouble { message } => self.note(now, format!("trouble: {message}")), // english: allow
                _ => {}
            },
            _ => {}
        }
    }

    /// Records that the executive adopted the plan of `request`: its targets are planned; left-out targets are skipped, with the reason.
    fn take_plan(&mut self, mission: &Mission, now: Time, request: SolveRequestId, summary: &str) {
        self.note(now, format!("new plan: {summary}"));
        self.adopted = self.adopted.saturating_add(1);
        let made = self.answers.remove(&request);
        self.ending.take_plan(now, request, made.as_ref().is_some_and(|made| !made.plan.targets().is_empty()));
        let Some(made) = made else {
            self.ending.take_missing_plan(request, NoPlanReason::WithoutVisits(summary.to_string()));
            return;
        };
        let mut planned_targets = BTreeSet::new();
        for (target, detail, begin_s) in storms::planned_visits(&made.plan, made.made.seconds()) {
            // Of several visits to a target, the first one counts.
            if planned_targets.insert(target.clone()) {
                let storm = self.stormy.expect((mission, &self.storms), &target, (now, begin_s));
                let detail = format!("{detail}{storm}");
                self.change(target, now, TargetState::Planned, detail);
            }
        }
        for left_out in made.plan.left_out() {
            let storm = self.stormy.expect((mission, &self.storms), &left_out.target, (now, f64::INFINITY));
            let reason = format!("{}{storm}", left_out.reason);
            self.change(left_out.target.clone(), now, TargetState::Skipped, reason);
        }
        self.plan = Some(made);
    }

    fn take_choice(&mut self, now: Time, goal: &Value, place: Place) {
        let activity = PlannedActivity::from_goal(goal);
        if let PlannedActivity::Observe { target, lines, .. } | PlannedActivity::Photograph { target, lines, .. } =
            &activity
            && let Some((begin, _)) = lines.first()
        {
            self.line_begins.insert(target.clone(), *begin);
        }
        if let PlannedActivity::Observe { target, lines, .. } = activity {
            let lines = lines.iter().map(|(from, to)| ScanLine::new(from.position, to.position)).collect();
            self.planned_lines.insert(target, lines);
        }
        let goal = goal.to_string();
        if self.chosen.len() < CHOSEN_MAX || self.chosen.contains_key(&goal) {
            self.chosen.insert(goal, Chosen { place, since: now });
        }
    }
}
