//! Facts for which the report of a flight has a line at its end: why the initial task failed, where the vehicle is, a plan that no task
//! flew.

use super::visit::VehicleState;
use crate::Mission;
use crate::descent::approach_mps;
use crate::in_air::AirState;
use crate::vehicle::Airframe;
use apex_geo::{geodesy, landing};
use apex_model::cause::Cause;
use apex_model::effect::{CommandId, DecisionKind, Effect, Method, SolveRequestId};
use apex_model::event::{Batch, EventKind};
use apex_model::limits::SOLVE_REQUESTS_MAX;
use apex_model::problem::Position;
use apex_model::task::{TaskId, TaskState};
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

/// The initial task of an agent.
const INITIAL: TaskId = TaskId(0);
/// Maximum number of commands without an answer whose text is known; a vehicle has few.
const COMMANDS_MAX: usize = 64;
/// A command that failed at most this long before the end belongs to its reason, s.
const RECENT_S: f64 = 3_600.0;
/// A longer command is shown by its name alone: the coordinates of a way say nothing to a reader.
const COMMAND_CHARACTERS_MAX: usize = 60;
/// Maximum number of goals that are remembered; more than any mission has.
const GOALS_MAX: usize = 1_000;
/// Maximum number of failures from the initial task down to the first one.
const DEPTH_MAX: usize = 1_000;

/// A plan for a goal that no task pursued when it arrived.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct IdlePlan {
    at: Time,
    goal: String,
    /// Instant at which the last task that pursued the goal ended.
    ended: Option<Time>,
}

/// Reason for which there is no plan, as text.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) enum NoPlanReason {
    /// A planner failed.
    Failed(String),
    /// No further target can be visited: the summary of the procedure without visits that is flown instead.
    WithoutVisits(String),
    /// A data-acquisition goal was not met.
    NotAcquired {
        /// Its target.
        target: String,
        /// Reason for which its data were not acquired.
        why: String,
    },
}

/// Knowledge about the end of a flight.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Ending {
    is_airborne: bool,
    /// True if the vehicle reports whether it is on the ground.
    is_reported: bool,
    has_crashed: bool,
    /// Instants and texts of commands without an answer.
    commands: BTreeMap<CommandId, (Time, String)>,
    /// The last command whose failure ended a task: its instant, and what failed.
    failed_command: Option<(Time, String)>,
    /// Reason for which the initial task failed.
    failed_because: Option<String>,
    /// Goals of requests without an answer.
    goals: BTreeMap<SolveRequestId, String>,
    /// Targets of the data-acquisition goals among the last requests.
    acquired: BTreeMap<SolveRequestId, String>,
    /// Goals for which a plan was requested.
    solved: BTreeSet<String>,
    /// These goals, by the tasks that pursue them.
    pursued: BTreeMap<TaskId, String>,
    /// Instant at which the last task that pursued a goal ended.
    ended: BTreeMap<String, Time>,
    idle: Option<IdlePlan>,
    /// Reason of the last planner that had no plan.
    no_plan: Option<NoPlanReason>,
    /// The last new position, and its instant. One that repeats the position before it, although the vehicle moves, is not new.
    location: Option<Value>,
    located_at: Time,
    is_moving: bool,
    /// Last instant in the air.
    airborne_until: Time,
}

impl Ending {
    /// Observes one step of the agent that flies.
    pub(super) fn observe(&mut self, air: &AirState, batch: &Batch, effects: &[Effect]) {
        (self.is_airborne, self.is_reported) = (!air.is_on_ground(), air.is_reported());
        for event in &batch.events {
            match &event.kind {
                EventKind::Measurement(variable, value) => self.measure(event.at, variable.attribute.folded(), value),
                EventKind::Occurrence(form) if form.head().is_some_and(|head| head.is("crashed")) => {
                    self.has_crashed = true;
                }
                _ => {}
            }
        }
        let mut failures = BTreeMap::new();
        for effect in effects {
            self.take(batch.now, effect, &mut failures);
        }
        for event in &batch.events {
            if let EventKind::CommandAcknowledged(command, _) = &event.kind {
                self.commands.remove(command);
            }
        }
    }

    fn measure(&mut self, at: Time, attribute: &str, value: &Value) {
        match attribute {
            "ground-speed" => self.is_moving = value.as_number().is_some_and(|(speed, _)| speed > MOVING_M_S),
            "location" if !self.is_moving || self.location.as_ref() != Some(value) => {
                (self.location, self.located_at) = (Some(value.clone()), at);
            }
            _ => {}
        }
        if self.is_airborne {
            self.airborne_until = at;
        }
    }

    /// Returns the instant of the last new position if the flight lasted for longer than [`UNLOCATED_MIN`] after it.
    fn located_until(&self) -> Option<Time> {
        (self.airborne_until - self.located_at > UNLOCATED_MIN).then_some(self.located_at)
    }

    fn take<'e>(&mut self, now: Time, effect: &'e Effect, failures: &mut BTreeMap<TaskId, &'e Cause>) {
        match effect {
            Effect::Command { command, form, .. } => {
                self.commands.insert(*command, (now, command_text(form)));
                while self.commands.len() > COMMANDS_MAX {
                    self.commands.pop_first();
                }
            }
            Effect::Solve(request) => {
                let goal = request.goal.to_string();
                if self.solved.len() < GOALS_MAX {
                    self.solved.insert(goal.clone());
                }
                self.goals.insert(request.request, goal);
                if let Some(target) = acquired_target(&request.goal) {
                    self.acquired.insert(request.request, target);
                    while self.acquired.len() > SOLVE_REQUESTS_MAX {
                        self.acquired.pop_first();
                    }
                }
                while self.goals.len() > SOLVE_REQUESTS_MAX {
                    self.goals.pop_first();
                }
            }
            Effect::Decided(decision) => match (&decision.kind, decision.task) {
                (DecisionKind::Selected { goal, method, .. }, Some(task)) => self.take_choice(task, goal, method),
                (DecisionKind::Transition { to: TaskState::Terminated, outcome, .. }, Some(task)) => {
                    if let Some(goal) = self.pursued.remove(&task).filter(|goal| self.solved.contains(goal)) {
                        self.ended.insert(goal, now);
                    }
                    if outcome.as_ref().is_some_and(apex_model::task::Outcome::is_failure) {
                        failures.insert(task, &decision.because.cause);
                        self.take_failure(now, task, failures);
                    }
                }
                _ => {}
            },
            _ => {}
        }
    }

    fn take_choice(&mut self, task: TaskId, goal: &Value, method: &Method) {
        let goal = goal.to_string();
        if matches!(method, Method::Solver(_)) || self.solved.contains(&goal) {
            if self.idle.as_ref().is_some_and(|idle| idle.goal == goal) {
                self.idle = None;
            }
            self.pursued.insert(task, goal);
        }
    }

    /// Takes a failed task with the causes of the failures of this step so far.
    fn take_failure(&mut self, now: Time, task: TaskId, failures: &BTreeMap<TaskId, &Cause>) {
        if let Some(Cause::CommandFailed { command, .. } | Cause::CommandTimedOut { command, .. }) = failures.get(&task)
        {
            let what = failures.get(&task).map(|cause| self.words(cause)).unwrap_or_default();
            self.commands.remove(command);
            self.failed_command = Some((now, what));
        }
        if task != INITIAL {
            return;
        }
        let mut first = task;
        for _ in 0..DEPTH_MAX {
            match failures.get(&first) {
                Some(Cause::ChildFailed { child: below } | Cause::HandlerEnded { handler: below })
                    if failures.contains_key(below) =>
                {
                    first = *below;
                }
                _ => break,
            }
        }
        let Some(cause) = failures.get(&first) else { return };
        let is_command = matches!(cause, Cause::CommandFailed { .. } | Cause::CommandTimedOut { .. });
        let before = self.failed_command.as_ref().filter(|_| is_command || self.is_recent(now));
        self.failed_because = Some(match (is_command, before) {
            (true, Some((_, what))) => what.clone(),
            (false, Some((at, what))) => format!("{}; at {at} {what}", self.words(cause)),
            (_, None) => self.words(cause),
        });
    }

    fn is_recent(&self, now: Time) -> bool {
        self.failed_command.as_ref().is_some_and(|(at, _)| (now - *at).seconds() <= RECENT_S)
    }

    /// Returns a cause as text without numbers of the record.
    fn words(&self, cause: &Cause) -> String {
        let form = |command: &CommandId| match self.commands.get(command) {
            Some((_, form)) => format!("the command {form}"),
            None => "a command".to_string(),
        };
        match cause {
            Cause::CommandFailed { command, reason } => format!("{} failed: {reason}", form(command)),
            Cause::CommandTimedOut { command, patience } => {
                format!("{} was not answered within {patience}", form(command))
            }
            Cause::SolverFailed { reason, .. } => format!("no plan: {reason}"),
            Cause::SolverTimedOut { patience, .. } => format!("no plan: the solver did not answer within {patience}"),
            cause => cause.text(),
        }
    }

    /// Takes the adoption of a plan for a request.
    pub(super) fn take_plan(&mut self, now: Time, request: SolveRequestId, has_visits: bool) {
        let Some(goal) = self.goals.remove(&request) else { return };
        let is_pursued = self.pursued.values().any(|pursued| *pursued == goal);
        let ended = self.ended.get(&goal).copied();
        // Procedures may plan first and pursue the goal afterwards; only a goal that was pursued before is left.
        self.idle = (has_visits && !is_pursued && ended.is_some()).then_some(IdlePlan { at: now, goal, ended });
    }

    /// Returns the instant of the last plan that no task flew, and the reason.
    pub(crate) fn idle_plan(&self) -> Option<(Time, String)> {
        let IdlePlan { at, goal, ended } = self.idle.as_ref()?;
        let ended = ended.map_or_else(String::new, |ended| format!(", which ended at {ended}"));
        Some((*at, format!("no task pursued {goal}{ended}")))
    }

    /// Returns true unless the vehicle reports or shows that it is on the ground.
    pub(crate) fn is_airborne(&self) -> bool {
        self.is_airborne
    }

    /// Records that a planner had no plan for a request, or one without visits.
    pub(super) fn take_missing_plan(&mut self, request: SolveRequestId, reason: NoPlanReason) {
        self.no_plan = Some(match (self.acquired.get(&request), reason) {
            (Some(target), NoPlanReason::Failed(why)) => NoPlanReason::NotAcquired { target: target.clone(), why },
            (Some(target), NoPlanReason::WithoutVisits(summary)) => NoPlanReason::NotAcquired {
                target: target.clone(),
                why: format!("planned {summary}, but no observation of it was completed"),
            },
            (_, reason) => reason,
        });
    }

    /// Returns the reason of the last planner that had no plan; `None` if each request had one.
    pub(crate) fn no_plan(&self) -> Option<&NoPlanReason> {
        self.no_plan.as_ref()
    }

    /// Returns the reason for which the initial task failed; `None` if it did not.
    pub(crate) fn failed_because(&self) -> Option<&str> {
        self.failed_because.as_deref()
    }

    /// Returns a statement about a vehicle that did not land; `None` if it is on the ground. `wind_mps` is the wind as last measured.
    pub(crate) fn not_landed(
        &self,
        mission: &Mission,
        (vehicle, wind_mps): (&VehicleState, Option<f64>),
        end: Time,
    ) -> Option<String> {
        if self.has_crashed {
            return Some("the vehicle has crashed".to_string());
        }
        let position = vehicle.position.filter(|_| self.is_airborne)?;
        let distance_km = geodesy::distance_m(position, mission.start) / 1e3;
        let mut sentence = format!(
            "the vehicle has not landed: it is in the air at {:.0} m above sea level, {distance_km:.1} km from its start",
            vehicle.altitude_m
        );
        // Formatting into a string cannot fail.
        if !self.is_reported {
            let _ =
                write!(sentence, "; it does not report `on-ground`, so this follows from its commands and positions");
        }
        if let Some(until) = self.located_until() {
            let _ = write!(sentence, "; its last new position is that of {until}");
        }
        if let Some((since, form)) = self.commands.values().next_back() {
            let _ = write!(
                sentence,
                "; it has been executing {form} for {}",
                Time::from_seconds((end - *since).seconds().round())
            );
        }
        let approach_mps = approach_mps(&mission.model, vehicle.altitude_m);
        let is_fixed_wing = mission.model.airframe == Airframe::FixedWing;
        if let Some(wind_mps) = wind_mps.filter(|wind_mps| is_fixed_wing && *wind_mps >= approach_mps) {
            let _ = write!(
                sentence,
                "; the wind there is {wind_mps:.0} m/s, and the final approach is flown at {approach_mps:.0} m/s"
            );
        }
        Some(sentence)
    }

    /// Returns a statement about a vehicle that is on the ground after a flight, more than [`AWAY_M`] from every landing place and from its
    /// start; `None` for another one.
    pub(crate) fn landed_away(&self, mission: &Mission, position: Option<Position>) -> Option<String> {
        let position = position.filter(|_| !self.is_airborne && !self.has_crashed)?;
        if let Some(until) = self.located_until() {
            let (latitude_deg, longitude_deg) = (position.latitude_deg, position.longitude_deg);
            return Some(format!(
                "the vehicle is on the ground, it is not known where: the last new position is that of {until}, \
                 ({latitude_deg:.5} {longitude_deg:.5})"
            ));
        }
        let places = mission.landing_places();
        let nearest = landing::nearest(&places, position).map(|(place, distance_m)| (place.name.as_str(), distance_m));
        let start = ("its start", geodesy::distance_m(position, mission.start));
        let (name, distance_m) = nearest.filter(|(_, distance_m)| *distance_m <= start.1).unwrap_or(start);
        (distance_m > AWAY_M).then(|| {
            format!(
                "the vehicle is on the ground at ({:.5} {:.5}), {:.1} km from the nearest landing place, {name}",
                position.latitude_deg,
                position.longitude_deg,
                distance_m / 1e3
            )
        })
    }
}

/// Ground speed from which on a vehicle cannot be where it was.
const MOVING_M_S: f64 = 3.0;
/// Time in the air without a new position after which the place of the vehicle counts as unknown.
const UNLOCATED_MIN: Duration = Duration(60_000_000_000);
/// Returns the name of the target of a data-acquisition goal, `(acquire TARGET ..)`, or its printed place.
fn acquired_target(goal: &Value) -> Option<String> {
    let [head, target, ..] = goal.as_list()? else { return None };
    head.as_symbol().filter(|head| head.is("acquire"))?;
    Some(match target {
        Value::Symbol(symbol) => symbol.folded().to_string(),
        Value::Text(text) => text.to_lowercase(),
        place => place.to_string(),
    })
}

/// Distance from a landing place up to which a landing counts as one at the place: a fixed wing rolls out beyond it.
const AWAY_M: f64 = 3_000.0;

/// Returns a command as the report shows it: whole, or its name for a long one.
fn command_text(form: &Value) -> String {
    let whole = form.to_string();
    match form.head() {
        Some(head) if whole.chars().count() > COMMAND_CHARACTERS_MAX => format!("({head} ..)"),
        _ => whole,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_commands_are_shown_by_their_names() {
        let command = |places: usize| {
            let place = Value::list([34.7982, -119.59357, 4673.0].map(Value::Real));
            Value::list(std::iter::once(Value::symbol("join-line")).chain(std::iter::repeat_n(place, places)))
        };
        assert_eq!(command_text(&command(1)), "(join-line (34.7982 -119.59357 4673.0))");
        assert_eq!(command_text(&command(3)), "(join-line ..)");
    }
}
