//! Deliberation for a mission: poses problems from the situation at the instant of a request; jobs solve, check and translate.

mod current_plan;
mod draft;
mod intervals;
mod landing;
mod measured_wind;
mod operator_plan;
mod segment;
pub mod solve;
mod steps;

pub use apex_solvers::planners::human::OrderFault;
pub use draft::draft;
pub use landing::solve_for_landing;
pub(crate) use operator_plan::HUMAN;
pub use solve::{Deliberation, PLAN_VISITS_MAX, PlanningResources, SolveOptions, name_obstacles, solve, validate};
pub use steps::translate;

use crate::problem::{NoPlan, here, pose};
use crate::report::{Report, report};
use crate::score::{FlownScore, told};
use crate::situation::{OperatorPlan, Situation};
use crate::{Mission, TargetKind, acquisition};
use apex_model::effect::{Effect, SolveRequest};
use apex_model::event::Batch;
use apex_model::problem::{Plan, Position, Problem, WindField};
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
use apex_planning::solver::{time_of, units_in};
use apex_runtime::invocation::Invocations;
use apex_runtime::ports::{CancelToken, Deliberator, Input, Posed, SolverAnswer};
use apex_runtime::target_state::TargetChange;
use segment::LostSegments;
use serde::Serialize;
use solve::name_obstacles_of;
use std::sync::{Arc, Mutex, PoisonError};
use steps::nothing_more;

/// Deliberation time if neither the mission nor the request states one.
const BUDGET_DEFAULT: Duration = Duration(10_000_000_000);

/// Planning for one mission, from its situation.
pub struct MissionDeliberator {
    mission: Arc<Mission>,
    situation: Situation,
    /// Observations until now; `None` without single-visit targets, an error if the targets are invalid.
    flown: Result<Option<FlownScore>, String>,
    means: PlanningResources,
    /// Segments of lines that lost their data.
    segments: LostSegments,
    /// Runs the solvers, and remembers those that never returned: state of this process, which is not recorded.
    invocations: Arc<Mutex<Invocations>>,
}

impl MissionDeliberator {
    /// Returns a deliberator at the beginning of the mission.
    pub fn new(mission: Arc<Mission>, means: PlanningResources) -> MissionDeliberator {
        let flown = FlownScore::new(&mission);
        MissionDeliberator {
            mission,
            situation: Situation::default(),
            flown,
            means,
            segments: LostSegments::default(),
            invocations: Arc::default(),
        }
    }

    /// Returns the situation now.
    pub fn situation(&self) -> &Situation {
        &self.situation
    }

    /// Returns the total wall time of planning so far.
    pub fn planned_for(&self) -> std::time::Duration {
        self.invocations.lock().unwrap_or_else(PoisonError::into_inner).worked()
    }

    /// Returns the report of a flight with this end.
    pub fn report(&self, end: (Time, String)) -> Report {
        report(&self.mission, &self.situation, told(&self.flown), end)
    }
}

impl Deliberator for MissionDeliberator {
    fn observe(&mut self, agent: usize, batch: &Batch, effects: &[Effect]) {
        self.situation.observe(&self.mission, agent, batch, effects);
        // Only the first agent flies.
        if let (0, Ok(Some(flown))) = (agent, &mut self.flown) {
            flown.observe(batch);
            self.segments.observe(batch.now, effects);
        }
    }

    fn derive(&mut self) -> Vec<Input> {
        let mut derived = self.situation.take_derived();
        if let Ok(Some(flown)) = &self.flown {
            derived.extend(self.segments.weigh((&self.mission, &self.situation), flown));
        }
        derived
    }

    fn pose(&mut self, request: &SolveRequest, at: Time) -> Posed {
        if acquisition::is_goal(&request.goal) {
            return acquisition::pose(&self.mission, &self.situation, request, at);
        }
        let question = Question::of(
            &self.mission,
            (&self.situation, self.flown.as_ref().ok().and_then(Option::as_ref)),
            request,
            at,
        );
        let problem = serde_json::to_string(&question.shown()).unwrap_or_else(|error| error.to_string());
        let (means, invocations) = (self.means.clone(), Arc::clone(&self.invocations));
        Posed::new(problem, move |cancel| {
            let mut invocations = invocations.lock().unwrap_or_else(PoisonError::into_inner);
            question.answer(&means, &mut invocations, cancel)
        })
    }

    fn snapshot(&self) -> Option<Vec<u8>> {
        postcard::to_stdvec(&self.situation).ok()
    }

    fn layout(&self) -> Option<&'static str> {
        Some(env!("APEX_SITUATION_LAYOUT"))
    }

    fn target_changes(&self) -> &[TargetChange] {
        &self.situation.target_changes
    }
}

/// Everything on which the answer to one request depends, except the planners.
struct Question {
    /// The mission as updated so far.
    believed: Mission,
    problem: Result<Problem, NoPlan>,
    /// The forecast of the wind as corrected by measurements.
    measured_wind: Option<WindField>,
    /// Plan from which planners begin, with its origin.
    previous: Option<(Plan, &'static str)>,
    operator_plan: Option<OperatorPlan>,
    goal: Value,
    /// None lets the profile table choose.
    solver: Option<String>,
    budget: Duration,
    seed: u64,
    /// The vehicle's position and the instant of the request.
    from: (Position, Time),
    /// True if an observation has ended: if nothing more can be visited, the mission is then complete.
    has_observed: bool,
    /// True if the failure of the request would end the flight in the air: no plan is flown yet that could continue, or it is a
    /// surveillance of which no visit can give a picture.
    ends_in_the_air: bool,
    /// True if the program handles a failure of the request.
    is_failure_handled: bool,
    /// Looks whose observation has ended.
    observed: Vec<String>,
    /// True if a plan is imposed: if it cannot be flown, planning fails, and the mission does not end.
    is_imposed: bool,
    /// Number of planning problems posed so far in the flight; it numbers the plans.
    number: u32,
}

/// A [`Question`] in its recorded form.
#[derive(Serialize)]
struct Shown<'a> {
    #[serde(skip_serializing_if = "Option::is_none")]
    problem: Option<&'a Problem>,
    #[serde(skip_serializing_if = "Option::is_none")]
    measured_wind: Option<&'a WindField>,
    #[serde(skip_serializing_if = "Option::is_none")]
    no_problem: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    previous: Option<&'a Plan>,
    #[serde(skip_serializing_if = "Option::is_none")]
    begun_from: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    operator_plan: Option<&'a OperatorPlan>,
    goal: String,
    solver: Option<&'a str>,
    work_units: u64,
    seed: u64,
    from: Position,
    t_s: f64,
    has_observed: bool,
    number: u32,
}

impl Question {
    fn of(
        mission: &Mission,
        (situation, flown): (&Situation, Option<&FlownScore>),
        request: &SolveRequest,
        at: Time,
    ) -> Question {
        let believed = situation.updates.believed(mission);
        let here_now = here(&believed, situation);
        let believed = situation.links.without_weak_links(believed, here_now);
        let believed = situation.storms.without_storms(believed, here_now, at.seconds());
        let believed = match flown {
            Some(flown) => flown.with_growth(believed),
            None => believed,
        };
        let problem = pose(&believed, situation, flown, at);
        let previous = problem
            .as_ref()
            .ok()
            .and_then(|problem| current_plan::current_plan(&believed, situation, &request.goal, problem, at));
        // The open visits of an imposed plan are the answer; planners are not asked.
        let is_site = |id: &str| {
            mission.targets.iter().any(|target| target.id == id && matches!(target.kind, TargetKind::Site(_)))
        };
        let imposed = situation.open_imposed(is_site);
        let imposed_is_empty = imposed.is_empty();
        let has_no_visit = matches!(problem, Err(NoPlan::NothingLeft(_)));
        let watches_sites = mission.targets.iter().any(|target| matches!(target.kind, TargetKind::Site(_)));
        let asked = (!request.solver.is("auto")).then(|| request.solver.folded().to_string());
        let (solver, operator_plan) = match imposed.is_empty() {
            true => (asked, situation.updates.operator_plan().cloned()),
            false => (Some(operator_plan::HUMAN.to_string()), Some(OperatorPlan { visits: imposed, repeat: false })),
        };
        let is_first = situation.plan.is_none() && operator_plan.is_none();
        // No target can be posed: the report has the reason of each target.
        let problem = match problem {
            Err(NoPlan::Fault(reason)) if is_first && situation.ending().is_airborne() => {
                Err(NoPlan::NothingLeft(reason))
            }
            problem => problem,
        };
        let ends_in_the_air = situation.ending().is_airborne() && (is_first || watches_sites && has_no_visit);
        Question {
            is_imposed: !imposed_is_empty,
            measured_wind: matches!(problem, Ok(Problem::SingleVisit(_)))
                .then(|| situation.wind_error().field(&believed.forecast, at.seconds()))
                .flatten(),
            problem,
            previous,
            operator_plan,
            goal: request.goal.clone(),
            solver,
            budget: request.budget.unwrap_or(BUDGET_DEFAULT),
            seed: mission.settings.seed,
            from: (here_now, at),
            has_observed: situation.observed().next().is_some(),
            ends_in_the_air,
            is_failure_handled: request.is_failure_handled,
            observed: situation.observed().map(|visit| visit.target.clone()).collect(),
            number: situation.posed,
            believed,
        }
    }

    fn shown(&self) -> Shown<'_> {
        Shown {
            problem: self.problem.as_ref().ok(),
            measured_wind: self.measured_wind.as_ref(),
            no_problem: self.problem.as_ref().err().map(ToString::to_string),
            previous: self.previous.as_ref().map(|(plan, _)| plan),
            begun_from: self.previous.as_ref().map(|(_, what)| *what),
            operator_plan: self.operator_plan.as_ref(),
            goal: self.goal.to_string(),
            solver: self.solver.as_deref(),
            work_units: units_in(self.budget),
            seed: self.seed,
            from: self.from.0,
            t_s: self.from.1.seconds(),
            has_observed: self.has_observed,
            number: self.number,
        }
    }

    fn answer(self, means: &PlanningResources, invocations: &mut Invocations, cancel: &CancelToken) -> SolverAnswer {
        let Question {
            believed, goal, budget, from, has_observed, is_imposed, ends_in_the_air, number, observed, ..
        } = self;
        let solver = self.solver.as_deref();
        let (previous, begun_from) = self.previous.unzip();
        let mut without_visits = None;
        let is_posed = self.problem.is_ok();
        let solved = self.problem.and_then(|problem| {
            let means = operator_plan::means(means, solver, self.operator_plan.as_ref()).map_err(NoPlan::Fault)?;
            let wish = SolveOptions { means: &means, solver, budget, seed: self.seed, previous };
            let posed = (problem, self.measured_wind);
            let solved = measured_wind::solve_for_wind(&believed, posed, wish, invocations, cancel)?;
            // Before the flight, a plan without visits is an answer; in flight, the mission is then complete.
            if !solved.plan.targets().is_empty() {
                return Ok(solved);
            }
            let reason = solved.plan.summary().to_string();
            without_visits = Some(solved.plan);
            Err(NoPlan::NothingLeft(reason))
        });
        // In the air a failure would end the flight there; without a visit the aircraft flies home. The failure of a planner that the
        // program brings is one that the program handles, if it does.
        let is_unhandled = ends_in_the_air && !self.is_failure_handled;
        let is_shipped = || solver.is_none_or(|name| apex_solvers::shipped().find(name).is_some());
        let flies_home = ends_in_the_air && (!is_posed || without_visits.is_some() || is_shipped());
        let is_complete = has_observed || flies_home || !believed.weak_targets.is_empty();
        match solved {
            Err(none) if !is_imposed && (is_unhandled || is_complete && matches!(none, NoPlan::NothingLeft(_))) => {
                let nothing = nothing_more(&goal, number, &none.to_string(), without_visits);
                SolverAnswer { result: Ok(nothing), charged: Duration::ZERO }
            }
            Err(none) => SolverAnswer { result: Err(none.to_string()), charged: Duration::ZERO },
            Ok(mut solved) => {
                solved.from = Some(from);
                let is_open = |name: &str| !observed.iter().any(|seen| seen == name);
                name_obstacles_of(&believed, &mut solved, &is_open);
                let charged = time_of(solved.work).min(budget);
                let mut result = translate(&solved, &goal, number, &believed);
                if let Some(begun_from) = begun_from {
                    result.summary = format!("{} Begun from {begun_from}.", result.summary);
                }
                SolverAnswer { result: Ok(result), charged }
            }
        }
    }
}
