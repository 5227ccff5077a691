//! Cost of turns in a plan whose vehicle cannot turn on the spot.

use crate::Mission;
use crate::problem::survey;
use crate::vehicle::turn_radius_m;
use apex_model::problem::{Plan, Position, Problem, SurveillancePlan, SurveillanceProblem};

/// Time that turns add to the paths of a plan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turns {
    /// Least radius of a turn through the air; in surveillance that of the circles around its targets over ground.
    pub radius_m: f64,
    /// Ways of the plan, the return included.
    pub ways: usize,
    /// Total beyond straight legs, in the worst wind and, of surveillance, from the worst point of each circle.
    pub time_s: f64,
}

/// Returns the cost of turns; `None` if turns take no time, or the problem states only times.
pub fn of(problem: &Problem, plan: &Plan, mission: Option<&Mission>) -> Option<Turns> {
    match (problem, plan) {
        (Problem::SingleVisit(problem), Plan::SingleVisit(plan)) => {
            let radius_m = problem.vehicle.turn_radius_m;
            let turning = radius_m > 0.0 && problem.travel.is_none();
            let (ways, time_s) =
                turning.then(|| apex_solvers::planners::single_visit::turns_s(problem, plan).ok())??;
            Some(Turns { radius_m, ways, time_s })
        }
        (Problem::Surveillance(problem), Plan::Surveillance(plan)) => of_surveillance(problem, plan, mission?),
        _ => None,
    }
}

fn of_surveillance(problem: &SurveillanceProblem, plan: &SurveillancePlan, mission: &Mission) -> Option<Turns> {
    // A vehicle that turns on the spot needs no travel computation, which takes longer than everything else.
    if turn_radius_m(&mission.model) <= 0.0 {
        return None;
    }
    let positions: Vec<Position> = problem.targets.iter().map(|target| target.position).collect();
    let mut ways = survey(mission, &positions, mission.start, 0.0).ok()?;
    let mut turns = Turns { radius_m: ways.circle_radius_m(), ways: 0, time_s: 0.0 };
    let (mut from, mut depart_s) = (None, 0.0);
    for visit in &plan.visits {
        let to = problem.targets.iter().position(|target| target.name == visit.target)?;
        if from != Some(to) {
            turns.ways += 1;
            turns.time_s += ways.turns_s(from, to, depart_s);
        }
        (from, depart_s) = (Some(to), visit.end_s);
    }
    if let Some(from) = from.filter(|_| problem.return_to_base) {
        turns.ways += 1;
        turns.time_s += ways.turns_to_base_s(from, depart_s);
    }
    Some(turns)
}
