//! The answer to a data-acquisition goal: a typed procedure that is printed as PDL, or the reason for which no manoeuvre meets the goal.

use super::data_mode::DataMode;
use super::form::{form_of, form_of_sweep};
use super::goal::AcquisitionGoal;
use super::pareto::Predicted;
use super::solve::{Start, Synthesis, synthesise, told};
use crate::Mission;
use crate::energy::energy;
use crate::problem::here;
use crate::situation::Situation;
use apex_model::effect::SolveRequest;
use apex_model::planned::{Location, PlannedActivity, PlannedProcedure, PlannedStep};
use apex_model::quantity::Dimension;
use apex_model::source::SourceFile;
use apex_model::symbol::Symbol;
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
use apex_observation::manoeuvres::{FlightPath, Instrument};
use apex_pdl::PrintedPlan;
use apex_runtime::ports::{Posed, SolverAnswer};
use serde_json::json;

/// Deliberation time charged for each candidate in simulation.
const CANDIDATE_S: f64 = 1e-3;

/// Poses the problem of a goal at the instant `at` of a flight.
pub(crate) fn pose(mission: &Mission, situation: &Situation, request: &SolveRequest, at: Time) -> Posed {
    let believed = situation.updates.believed(mission);
    let energy = energy(&believed, situation);
    let start = Start {
        here: here(&believed, situation),
        at_s: at.seconds(),
        endurance_s: energy.endurance_s - energy.reserve_s,
    };
    let problem = json!({
        "acquisition": request.goal.to_string(),
        "from": [start.here.latitude_deg, start.here.longitude_deg],
        "t_s": start.at_s,
        "endurance_s": start.endurance_s,
        "number": situation.posed,
    });
    let (goal, number) = (request.goal.clone(), situation.posed);
    Posed::new(problem.to_string(), move |_| answer(&believed, &goal, start, number))
}

fn answer(mission: &Mission, goal: &Value, start: Start, number: u32) -> SolverAnswer {
    let made = AcquisitionGoal::read(mission, goal).and_then(|wanted| {
        let synthesis = synthesise(mission, &wanted, start)?;
        Ok((procedure(&wanted, goal, &synthesis, (start, number))?, synthesis.tried))
    });
    match made {
        Err(why) => SolverAnswer { result: Err(why), charged: Duration::ZERO },
        Ok((procedure, tried)) => {
            SolverAnswer { result: Ok(procedure), charged: Duration::from_seconds(CANDIDATE_S * tried as f64) }
        }
    }
}

/// Returns the manoeuvres that meet a goal, best first, as one line of text each; for displays and measurements.
///
/// # Errors
/// As in flight: the error in the goal, or the manoeuvre that comes closest to meeting it.
pub fn synthesised(mission: &Mission, goal: &Value, from_s: f64) -> Result<Vec<String>, String> {
    let wanted = AcquisitionGoal::read(mission, goal)?;
    let energy = energy(mission, &Situation::default());
    let start = Start { here: mission.start, at_s: from_s, endurance_s: energy.endurance_s - energy.reserve_s };
    let synthesis = synthesise(mission, &wanted, start)?;
    Ok(synthesis.front.iter().map(told).collect())
}

/// Returns the procedure that flies the chosen manoeuvre.
fn procedure(
    wanted: &AcquisitionGoal,
    goal: &Value,
    synthesis: &Synthesis,
    (start, number): (Start, u32),
) -> Result<PlannedProcedure, String> {
    let chosen = synthesis.front.first().ok_or("no manoeuvre meets the goal")?;
    let activity = activity(wanted, chosen, start)?;
    let tag = Symbol::new("acquire");
    let PrintedPlan { text, step_lines } = apex_pdl::print_plan(goal, &[(tag.clone(), activity.goal())], false);
    let mut head = format!("; {}\n", told(chosen));
    for other in synthesis.front.iter().skip(1) {
        head.push_str(&format!("; or {}\n", told(other)));
    }
    for miss in &synthesis.misses {
        head.push_str(&format!("; not: {miss}\n"));
    }
    let before = u32::try_from(head.lines().count()).unwrap_or(0);
    let line = step_lines.first().copied().unwrap_or(1) + before;
    let summary = format!(
        "{}; chosen among {} manoeuvres that meet the goal and that no other one beats, of {} tried",
        told(chosen),
        synthesis.front.len(),
        synthesis.tried
    );
    Ok(PlannedProcedure {
        solver: Symbol::new(super::SOLVER),
        summary,
        steps: vec![PlannedStep { tag, activity, line }],
        repeat: false,
        plan: None,
        source: SourceFile { name: format!("<plan {number}>").into(), text: format!("{head}{text}").into() },
    })
}

/// Returns the activity of the step that flies a manoeuvre.
fn activity(wanted: &AcquisitionGoal, chosen: &Predicted, start: Start) -> Result<PlannedActivity, String> {
    let candidate = &chosen.candidate;
    let target = wanted.named.clone();
    let due_s = start.at_s + chosen.travel_s + chosen.forecast.time_s;
    let due = Duration::from_seconds(due_s.round());
    let scans = matches!(candidate.instrument, Instrument::Scanner(_));
    let is_lines = matches!(
        candidate.manoeuvre.path,
        FlightPath::Sweep(_) | FlightPath::StraightOver(_) | FlightPath::StandOff(_)
    );
    let name = wanted.target.name.clone();
    let is_sweep = matches!(candidate.manoeuvre.path, FlightPath::Sweep(_));
    // A goal that states a handling of its data is answered by a form, because lines and hovers have none.
    let has_lines = (scans && is_lines) || is_sweep;
    if has_lines && wanted.data.is_none() {
        let lines = lines(chosen);
        return Ok(match scans {
            true => PlannedActivity::Observe { target: name, lines, due: Some(due) },
            false => PlannedActivity::Photograph {
                target: name,
                lines,
                camera: candidate.sensor.clone(),
                every_m: candidate.every_m,
                speed_mps: candidate.speed_mps,
                due,
            },
        });
    }
    let word = Value::symbol;
    if let (FlightPath::VantagePoint(_), None) = (&candidate.manoeuvre.path, wanted.data) {
        let pose = chosen.forecast.flown.poses.first().ok_or("the vantage point has no place")?;
        let from = location(chosen, pose.point, pose.height_m);
        let head = [word("inspect"), target.clone(), word("from"), from.value(), word("with"), word(&candidate.sensor)];
        let how = [word("pointed"), word("at"), target, word("taking"), Value::Integer(1)];
        let items = head.into_iter().chain(how).chain([word("due"), Value::Duration(due)]);
        return Ok(PlannedActivity::from_goal(&Value::list(items)));
    }
    let form = match &candidate.manoeuvre.path {
        FlightPath::Sweep(sweep) => form_of_sweep(sweep),
        path => form_of(path).ok_or("the manoeuvre cannot be written as a form of PDL")?,
    };
    let form = with_data(form, wanted.data);
    let speed = Value::measured(candidate.speed_mps, Dimension::SPEED);
    if scans {
        let items = [word("scan"), target, word("by"), form, word("at"), speed];
        return Ok(PlannedActivity::Goal(Value::list(items)));
    }
    let every = Value::measured(candidate.every_m, Dimension::LENGTH);
    let head = [word("perform"), form, word("at"), target, word("with"), word(&candidate.sensor)];
    let how = [word("at"), speed, word("every"), every];
    Ok(PlannedActivity::Goal(Value::list(head.into_iter().chain(how))))
}

/// Returns a form with the handling of the data.
fn with_data(form: Value, data: Option<DataMode>) -> Value {
    let Some(data) = data else { return form };
    let items = form.as_list().unwrap_or_default().to_vec();
    Value::list(items.into_iter().chain([Value::symbol(":data"), data.value()]))
}

/// Returns the observed lines in the order in which they are flown.
fn lines(chosen: &Predicted) -> Vec<(Location, Location)> {
    let poses = &chosen.forecast.flown.poses;
    let observed = poses.windows(2).filter_map(|pair| match pair {
        [from, to] if from.is_observed => {
            Some((location(chosen, from.point, from.height_m), location(chosen, to.point, to.height_m)))
        }
        _ => None,
    });
    observed.collect()
}

/// Converts a point of the local plane to a location, rounded to about a metre.
fn location(chosen: &Predicted, point: apex_geo::plane::Point, height_m: f64) -> Location {
    let position = chosen.scene.position(point);
    let digits = |degrees: f64| libm::round(degrees * 1e5) / 1e5;
    Location {
        position: apex_model::problem::Position::new(digits(position.latitude_deg), digits(position.longitude_deg)),
        altitude_m: libm::round(10.0 * (chosen.scene.elevation_m + height_m)) / 10.0,
    }
}
