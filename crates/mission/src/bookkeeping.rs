//! What a mission has achieved so far, read off the same batches and effects that the record stores.

use super::lines::{ScanLine, lines_of_goal};
use super::news::News;
use apex_model::effect::{DecisionKind, Effect, Method, SolveRequestId};
use apex_model::event::{Batch, EventKind, SolverReport};
use apex_model::limits::SOLVE_REQUESTS_MAX;
use apex_model::problem::Position;
use apex_model::quantity::Dimension;
use apex_model::source::Place;
use apex_model::time::Time;
use apex_model::value::Value;
use apex_runtime::ports::Observer;
use apex_runtime::record::TargetState;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

/// Beyond this roll angle a line of the scanner is not valid (missions.md 1).
const WINGS_LEVEL_DEG: f64 = 3.0;

/// One observation of one target.
#[derive(Debug, Clone)]
pub struct Visit {
    /// The target's name.
    pub target: String,
    /// When it began.
    pub begin: Time,
    /// When it ended; none while under way, or when it was broken off.
    pub end: Option<Time>,
    /// How many segments were flown again.
    pub reflies: u32,
    /// The lines flown, with what was seen of each.
    pub lines: Vec<ScanLine>,
    /// Sum and count of altitudes while scanning, for the mean.
    altitude_m: (f64, u32),
    /// The largest roll angle while on a line, degrees.
    pub roll_deg_max: f64,
}

impl Visit {
    /// Mean altitude above mean sea level while scanning.
    pub fn altitude_m(&self) -> Option<f64> {
        let (sum, count) = self.altitude_m;
        (count > 0).then(|| sum / f64::from(count))
    }
}

/// A decision worth telling.
#[derive(Debug, Clone)]
pub struct Note {
    /// When.
    pub at: Time,
    /// What, one line.
    pub text: String,
}

/// State of the vehicle as last reported.
#[derive(Debug, Clone, Default)]
pub struct VehicleState {
    /// Where.
    pub position: Option<Position>,
    /// Altitude above mean sea level.
    pub altitude_m: f64,
    /// Fuel left.
    pub fuel_kg: Option<f64>,
    /// Flight time that the fuel allows.
    pub endurance_s: Option<f64>,
    roll_deg: f64,
    on_line: bool,
    scanning: bool,
}

/// A procedure that was chosen for a goal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Chosen {
    /// Where it stands.
    pub place: Place,
    /// When it was chosen.
    pub since: Time,
}

/// Goals of which it is remembered what was chosen for them; more than any mission has.
const CHOSEN_MAX: usize = 10_000;

/// Everything that planning, the report and Sherpa's targets need to know about the flight so far.
#[derive(Debug, Clone, Default)]
pub struct Bookkeeping {
    /// Observations in order of their beginning.
    pub visits: Vec<Visit>,
    /// Decisions of note in order.
    pub notes: Vec<Note>,
    /// The vehicle.
    pub vehicle: VehicleState,
    /// What has been said of targets and weather.
    pub news: News,
    /// Changes of targets' states that are not in the record yet: target, time, state, detail.
    pub target_changes: Vec<(String, Time, TargetState, String)>,
    /// The request whose plan the executive took last.
    pub plan_taken: Option<SolveRequestId>,
    /// The procedure that was chosen last for each goal, by its text.
    pub chosen: BTreeMap<String, Chosen>,
    /// What plans say of targets, of which it is not known whether the executive takes them.
    offered: BTreeMap<SolveRequestId, Vec<(String, TargetState, String)>>,
    /// Lines of each target whose observation has been chosen.
    planned_lines: BTreeMap<String, Vec<ScanLine>>,
}

/// Bookkeeping shared between the observer, the deliberator and the report.
pub type SharedBookkeeping = Arc<Mutex<Bookkeeping>>;

/// Locks shared bookkeeping; a panic elsewhere does not make what is known unreadable.
pub fn lock(shared: &SharedBookkeeping) -> std::sync::MutexGuard<'_, Bookkeeping> {
    shared.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
}

impl Bookkeeping {
    /// Targets whose observation has ended.
    pub fn observed(&self) -> impl Iterator<Item = &Visit> {
        self.visits.iter().filter(|visit| visit.end.is_some())
    }

    fn open_visit(&mut self) -> Option<&mut Visit> {
        self.visits.last_mut().filter(|visit| visit.end.is_none())
    }

    /// Notes what has not been noted before.
    pub fn note_once(&mut self, at: Time, text: &str) {
        if !self.notes.iter().any(|note| note.text == text) {
            self.note(at, text.to_string());
        }
    }

    /// What the answer to a request says of targets: it counts once the executive takes the plan.
    pub fn offer(&mut self, request: SolveRequestId, targets: Vec<(String, TargetState, String)>) {
        self.offered.insert(request, targets);
        // Those of which nothing was heard for long will not be taken.
        while self.offered.len() > SOLVE_REQUESTS_MAX {
            self.offered.pop_first();
        }
    }

    fn take_plan(&mut self, now: Time, request: SolveRequestId, summary: &str) {
        self.note(now, format!("new plan: {summary}"));
        self.plan_taken = Some(request);
        for (target, state, detail) in self.offered.remove(&request).unwrap_or_default() {
            self.target_changes.push((target, now, state, detail));
        }
    }

    fn take_choice(&mut self, now: Time, goal: &Value, place: Place) {
        if let Some((target, lines)) = lines_of_goal(goal) {
            self.planned_lines.insert(target, lines);
        }
        let goal = goal.to_string();
        if self.chosen.len() < CHOSEN_MAX || self.chosen.contains_key(&goal) {
            self.chosen.insert(goal, Chosen { place, since: now });
        }
    }

    fn note(&mut self, at: Time, text: String) {
        self.notes.push(Note { at, text });
    }

    fn take_measurement(&mut self, attribute: &str, value: &Value) {
        match (attribute, value) {
            ("location", Value::List(_)) => {
                if let Some((position, altitude_m)) = location(value) {
                    self.vehicle.position = Some(position);
                    self.vehicle.altitude_m = altitude_m;
                }
            }
            ("fuel", Value::Quantity(fuel)) if fuel.dimension == Dimension::MASS => {
                self.vehicle.fuel_kg = Some(fuel.si);
            }
            ("endurance-remaining", Value::Duration(left)) => self.vehicle.endurance_s = Some(left.seconds()),
            ("roll-angle", Value::Quantity(roll)) => self.vehicle.roll_deg = roll.si.to_degrees(),
            ("flight-phase", Value::Symbol(phase)) => self.vehicle.on_line = phase.is("line"),
            ("scanner-state", Value::Symbol(state)) => self.vehicle.scanning = state.is("on"),
            _ => {}
        }
    }

    /// Marks what the scanner sees now on the line under way.
    fn scan(&mut self) {
        let VehicleState { position: Some(position), altitude_m, roll_deg, on_line: true, scanning: true, .. } =
            self.vehicle
        else {
            return;
        };
        let Some(visit) = self.open_visit() else { return };
        visit.altitude_m = (visit.altitude_m.0 + altitude_m, visit.altitude_m.1 + 1);
        visit.roll_deg_max = visit.roll_deg_max.max(roll_deg.abs());
        for line in &mut visit.lines {
            line.mark(position, roll_deg.abs() <= WINGS_LEVEL_DEG);
        }
    }

    fn take_message(&mut self, at: Time, form: &Value) {
        let Some([Value::Symbol(head), items @ ..]) = form.as_list() else { return };
        let Some(subject) = items.first().map(Value::to_string) else { return };
        match head.folded() {
            "observing" if self.open_visit().is_some_and(|visit| visit.target == subject) => {}
            "observing" => {
                self.target_changes.push((subject.clone(), at, TargetState::Observing, String::new()));
                let lines = self.planned_lines.get(&subject).cloned().unwrap_or_default();
                self.visits.push(Visit {
                    target: subject,
                    begin: at,
                    end: None,
                    reflies: 0,
                    lines,
                    altitude_m: (0.0, 0),
                    roll_deg_max: 0.0,
                });
            }
            "observed" => {
                self.target_changes.push((subject.clone(), at, TargetState::Observed, String::new()));
                if let Some(visit) = self.open_visit().filter(|visit| visit.target == subject) {
                    visit.end = Some(at);
                }
            }
            "wings-level-violation" => {
                if let Some(visit) = self.open_visit() {
                    visit.reflies += 1;
                }
                self.note(at, format!("re-fly: wings were not level over {subject}"));
            }
            "replan-wanted" => self.note(at, format!("replanning wanted: {subject}")),
            "communication-lost" => self.note(at, format!("communication over {subject} lost: going back")),
            "communication-regained" => self.note(at, format!("communication over {subject} regained")),
            "image-in-memory" => {
                self.target_changes.push((subject.clone(), at, TargetState::Observed, String::new()));
                self.note(at, format!("picture of {subject} in memory"));
            }
            "low-fuel" => self.note(at, "fuel is low".to_string()),
            head => {
                if let Some(note) = self.news.take(head, items) {
                    self.note(at, note);
                }
                if head == "target-gone" {
                    let detail = "no target any more".to_string();
                    self.target_changes.push((subject, at, TargetState::Skipped, detail));
                }
            }
        }
    }

    fn take_effect(&mut self, now: Time, effect: &Effect) {
        match effect {
            Effect::Inform { form, .. } => self.take_message(now, form),
            Effect::Decided(decision) => match &decision.kind {
                DecisionKind::Selected { goal, method: Method::Procedure(place), .. } => {
                    self.take_choice(now, goal, *place);
                }
                DecisionKind::ProcedureAdded { request, summary, .. } => self.take_plan(now, *request, summary),
                DecisionKind::Trouble { message } => self.note(now, format!("trouble: {message}")),
                _ => {}
            },
            _ => {}
        }
    }
}

/// A location value as position and altitude.
pub fn location(value: &Value) -> Option<(Position, f64)> {
    let items = value.as_list()?;
    let number = |index: usize| items.get(index).and_then(Value::as_number).map(|(number, _)| number);
    Some((Position::new(number(0)?, number(1)?), number(2).unwrap_or(0.0)))
}

/// Feeds shared bookkeeping from a run.
pub struct BookkeepingObserver {
    /// The books.
    pub books: SharedBookkeeping,
    /// Only the first agent flies: what it measures and does is what happened to the aircraft.
    flying: bool,
}

impl BookkeepingObserver {
    /// Feeds `books`.
    pub fn new(books: SharedBookkeeping) -> BookkeepingObserver {
        BookkeepingObserver { books, flying: true }
    }
}

impl Observer for BookkeepingObserver {
    fn turn(&mut self, agent: usize) -> Result<(), String> {
        self.flying = agent == 0;
        Ok(())
    }

    fn observe(&mut self, batch: &Batch, effects: &[Effect]) -> Result<(), String> {
        if !self.flying {
            return Ok(());
        }
        let mut books = lock(&self.books);
        let mut moved = false;
        for event in &batch.events {
            match &event.kind {
                EventKind::Measurement(variable, value) => {
                    moved |= variable.attribute.is("location");
                    books.take_measurement(variable.attribute.folded(), value);
                }
                EventKind::Occurrence(form) => books.take_message(event.at, form),
                EventKind::SolverReported(_, SolverReport::Failed(reason)) => {
                    books.note(event.at, format!("no plan: {reason}"));
                }
                _ => {}
            }
        }
        if moved {
            books.scan();
        }
        for effect in effects {
            books.take_effect(batch.now, effect);
        }
        Ok(())
    }
}
