//! Surroundings of a page's agent: a vehicle that answers commands and a planner, configured by the options of the page.

use crate::late::take_due;
use crate::scenario::read_time;
use apex_model::effect::{CommandId, SolveRequest};
use apex_model::event::EventKind;
use apex_model::planned::{PlannedActivity, PlannedProcedure, PlannedStep};
use apex_model::source::SourceFile;
use apex_model::symbol::Symbol;
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
use apex_runtime::ports::{Deliberator, Input, Posed, SolverAnswer, Vehicle};

/// Response of the vehicle to commands.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum VehicleManner {
    /// Acknowledges each command at once.
    #[default]
    Prompt,
    /// Acknowledges each command after this time.
    Slow(Duration),
    /// Rejects each command with this reason.
    Refuses(String),
    /// Never answers: a lost link.
    Silent,
}

/// Response of the planner to requests.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum PlannerManner {
    /// No planner is available.
    #[default]
    Absent,
    /// Answers each request after this time with these activities.
    Plans(Duration, Vec<Value>),
    /// Finds no plan after this time, with this reason.
    Fails(Duration, String),
}

impl VehicleManner {
    /// Reads `silent`, `answers after 3s`, `refuses REASON..`.
    ///
    /// # Errors
    /// The message names the known manners.
    pub fn read(words: &[&str]) -> Result<VehicleManner, String> {
        match words {
            ["silent"] => Ok(VehicleManner::Silent),
            ["answers", "after", time] => Ok(VehicleManner::Slow(read_time(time)? - Time::ZERO)),
            ["refuses", reason @ ..] if !reason.is_empty() => Ok(VehicleManner::Refuses(reason.join(" "))),
            _ => Err("a vehicle is `silent`, `answers after TIME` or `refuses REASON..`".into()),
        }
    }
}

impl PlannerManner {
    /// Reads `plans after 3s (ACTIVITY) (ACTIVITY)..`, `fails after 3s REASON..`.
    ///
    /// # Errors
    /// The message names the known manners, or the activity that cannot be read.
    pub fn read(words: &[&str]) -> Result<PlannerManner, String> {
        match words {
            ["plans", "after", time, activities @ ..] => {
                let text = format!("({})", activities.join(" "));
                let list = apex_pdl::read_value(&text).map_err(|error| format!("{text}: {error:?}"))?;
                let activities = list.as_list().unwrap_or_default().to_vec();
                Ok(PlannerManner::Plans(read_time(time)? - Time::ZERO, activities))
            }
            ["fails", "after", time, reason @ ..] if !reason.is_empty() => {
                Ok(PlannerManner::Fails(read_time(time)? - Time::ZERO, reason.join(" ")))
            }
            _ => Err("a planner `plans after TIME (ACTIVITY)..` or `fails after TIME REASON..`".into()),
        }
    }
}

/// Test double of a vehicle.
#[derive(Debug, Default)]
pub struct PageVehicle {
    manner: VehicleManner,
    answers: Vec<(CommandId, Input)>,
    /// Inputs to pass on later, ordered by the instants at which they arrive.
    late: Vec<(Time, Input)>,
}

impl PageVehicle {
    /// Returns a vehicle of this manner, whose link delays the inputs in `late`, each until its instant, in order of the instants.
    pub fn new(manner: VehicleManner, late: Vec<(Time, Input)>) -> PageVehicle {
        PageVehicle { manner, answers: Vec::new(), late }
    }
}

impl Vehicle for PageVehicle {
    fn next_report(&self) -> Option<Time> {
        let late = self.late.first().map(|(came, _)| *came);
        self.answers.iter().map(|(_, input)| input.at).chain(late).min()
    }

    fn advance(&mut self, to: Time, inputs: &mut Vec<Input>) -> Result<(), String> {
        let (due, later) = std::mem::take(&mut self.answers).into_iter().partition(|(_, input)| input.at <= to);
        self.answers = later;
        let due: Vec<(CommandId, Input)> = due;
        inputs.extend(due.into_iter().map(|(_, input)| input));
        inputs.extend(take_due(&mut self.late, to));
        Ok(())
    }

    fn command(&mut self, command: CommandId, _: &Value, at: Time) {
        let (at, answer) = match &self.manner {
            VehicleManner::Prompt => (at, Ok(Value::nil())),
            VehicleManner::Slow(time) => (at + *time, Ok(Value::nil())),
            VehicleManner::Refuses(reason) => (at, Err(reason.clone())),
            VehicleManner::Silent => return,
        };
        self.answers.push((command, Input::new(at, EventKind::CommandAcknowledged(command, answer))));
    }

    fn withdraw(&mut self, command: CommandId, _: Time) {
        self.answers.retain(|(pending, _)| *pending != command);
    }
}

/// Test double of planners.
#[derive(Debug, Default)]
pub struct PagePlanner(pub PlannerManner);

impl Deliberator for PagePlanner {
    fn pose(&mut self, request: &SolveRequest, _: Time) -> Posed {
        let answer = match &self.0 {
            PlannerManner::Absent => return Posed::failed(format!("no planner is available for {}", request.goal)),
            PlannerManner::Plans(charged, activities) => {
                SolverAnswer { result: Ok(plan(request, activities)), charged: *charged }
            }
            PlannerManner::Fails(charged, reason) => SolverAnswer { result: Err(reason.clone()), charged: *charged },
        };
        Posed::new("{}".into(), move |_| answer)
    }
}

fn plan(request: &SolveRequest, activities: &[Value]) -> PlannedProcedure {
    let tag = |number: usize| Symbol::new(&format!("p{}", number + 1));
    let step = |(number, goal): (usize, &Value)| PlannedStep {
        tag: tag(number),
        activity: PlannedActivity::Goal(goal.clone()),
        line: number as u32 + 2,
    };
    let lines: String =
        activities.iter().enumerate().map(|(n, goal)| format!("\n  (step {} {goal})", tag(n))).collect();
    let text = format!("(procedure :sequential (index {}){lines})\n", request.goal);
    PlannedProcedure {
        solver: request.solver.clone(),
        summary: format!("{} activities", activities.len()),
        steps: activities.iter().enumerate().map(step).collect(),
        repeat: false,
        plan: None,
        source: SourceFile { name: "<plan>".into(), text: text.into() },
    }
}
