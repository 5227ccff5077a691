//! Validation of problems. Solvers call it first, so that an invalid problem is reported instead of searched.

mod travel;

use apex_model::problem::{
    AirspaceZone, CostFunction, Manoeuvre, Position, SingleVisitProblem, SurveillanceProblem, SurveillanceTarget,
    TravelTimes,
};

/// Maximum number of targets of one problem: a hundred times the largest known mission.
pub const TARGETS_MAX: usize = 5_000;

/// Rejects invalid surveillance problems.
///
/// # Errors
/// An error message that names the target and the field.
pub fn surveillance(problem: &SurveillanceProblem) -> Result<(), String> {
    if problem.targets.is_empty() {
        return Err("there is no target to watch".to_string());
    }
    at_most_targets(problem.targets.len())?;
    positive("the horizon", problem.horizon_s)?;
    if let Some(endurance_s) = problem.endurance_s {
        positive("the endurance", endurance_s)?;
    }
    unique_names(problem.targets.iter().map(|target| target.name.as_str()))?;
    problem.targets.iter().try_for_each(surveillance_target)?;
    travel_times(problem)
}

fn surveillance_target(target: &SurveillanceTarget) -> Result<(), String> {
    let name = &target.name;
    on_map(&format!("Target {name}"), target.position)?;
    not_negative(&format!("the dwell of target {name}"), target.dwell_s)?;
    not_negative(&format!("the initial age of target {name}"), target.initial_age_s)?;
    let rates = &target.rate.steps;
    if rates.iter().any(|(time_s, rate)| !time_s.is_finite() || !rate.is_finite() || *rate < 0.0) {
        return Err(format!("the event rate of target {name} has a step that is negative or not finite"));
    }
    if rates.iter().zip(rates.iter().skip(1)).any(|((before, _), (after, _))| before >= after) {
        return Err(format!("the event rate of target {name} has steps out of order of time"));
    }
    cost_function(name, &target.cost)
}

fn cost_function(name: &str, cost: &CostFunction) -> Result<(), String> {
    let numbers = match cost {
        CostFunction::Linear { cost_per_s } => vec![*cost_per_s],
        CostFunction::Saturating { maximum, rate_per_s } => vec![*maximum, *rate_per_s],
        CostFunction::Step { deadline_s, maximum } => vec![*deadline_s, *maximum],
        CostFunction::Logistic { maximum, rate_per_s, midpoint_s } => vec![*maximum, *rate_per_s, *midpoint_s],
        CostFunction::Delayed { response_s, cost } => {
            cost_function(name, cost)?;
            vec![*response_s]
        }
        CostFunction::Table { points } => points.iter().flat_map(|(age_s, cost)| [*age_s, *cost]).collect(),
    };
    if numbers.iter().any(|number| !number.is_finite() || *number < 0.0) {
        return Err(format!("the cost function of target {name} has a number that is negative or not finite"));
    }
    if let CostFunction::Table { points } = cost {
        let falls = |((age0, cost0), (age1, cost1)): (&(f64, f64), &(f64, f64))| age1 < age0 || cost1 < cost0;
        if points.is_empty() || points.iter().zip(points.iter().skip(1)).any(falls) {
            return Err(format!("the cost table of target {name} is empty or falls; cost never falls with age"));
        }
    }
    Ok(())
}

fn travel_times(problem: &SurveillanceProblem) -> Result<(), String> {
    let count = problem.targets.len();
    travel::times(&problem.travel, count, problem.return_to_base)?;
    for (index, target) in problem.targets.iter().enumerate() {
        let least_s = (0..count).map(|from| problem.travel.between_s_min(from, index)).fold(f64::INFINITY, f64::min);
        if target.dwell_s + least_s <= 0.0 {
            return Err(format!(
                "observing target {} takes no time at all; give it a dwell of at least a second",
                target.name
            ));
        }
    }
    Ok(())
}

/// Rejects invalid single-visit problems.
///
/// # Errors
/// An error message that names the target and the field.
pub fn single_visit(problem: &SingleVisitProblem) -> Result<(), String> {
    if problem.targets.is_empty() {
        return Err("there is no target to visit".to_string());
    }
    at_most_targets(problem.targets.len())?;
    unique_names(problem.targets.iter().map(|target| target.name.as_str()))?;
    let vehicle = &problem.vehicle;
    positive("the true airspeed", vehicle.true_airspeed_mps)?;
    positive("the endurance", vehicle.endurance_s)?;
    not_negative("the endurance reserve", vehicle.endurance_reserve_s)?;
    turn_radius(vehicle.turn_radius_m)?;
    not_negative("the fuel flow", vehicle.fuel_flow_kg_per_s)?;
    not_negative("the fuel reserve", vehicle.fuel_reserve_kg)?;
    not_negative("the margin of zones", problem.zone_margin_m)?;
    finite("the cruise altitude", vehicle.cruise_altitude_m)?;
    finite("the start altitude", problem.start_altitude_m)?;
    finite("the start time", problem.start_s)?;
    finite("the civil time of zero", problem.zero_unix_s)?;
    on_map("the start", problem.start)?;
    problem.base.map_or(Ok(()), |base| on_map("the base", base))?;
    for place in &problem.landing_places {
        on_map(&format!("Landing place {}", place.name), place.position)?;
    }
    problem.zones.iter().try_for_each(zone)?;
    for target in &problem.targets {
        on_map(&format!("Target {}", target.name), target.position)?;
        not_negative(&format!("the value of target {}", target.name), target.value)?;
        not_negative(&format!("the cost of missing target {}", target.name), target.miss_cost())?;
        if target.must.is_some_and(|must| !(0.0..=1.0).contains(&must.factor_min)) {
            return Err(format!("the least factor with which target {} is not missed lies outside 0..1", target.name));
        }
        if target.manoeuvres.is_empty() {
            return Err(format!("target {} has no manoeuvre; give at least one way to observe it", target.name));
        }
        target.manoeuvres.iter().try_for_each(|manoeuvre| manoeuvre_of(&target.name, manoeuvre))?;
        if target.timing.iter().any(|(time_s, factor)| !time_s.is_finite() || !(0.0..=1.0).contains(factor)) {
            return Err(format!("the timing of target {} has a factor outside 0..1", target.name));
        }
        let rises = target.timing.windows(2).all(|pair| matches!(pair, [(one_s, _), (next_s, _)] if one_s <= next_s));
        if !rises {
            return Err(format!("the timing of target {} is not in the order of its times", target.name));
        }
        if let Some(window) = target.windows.iter().find(|window| window.from_s > window.until_s) {
            return Err(format!(
                "a window of target {} ends at {} s, before it begins at {} s",
                target.name, window.until_s, window.from_s
            ));
        }
    }
    problem.travel.as_ref().map_or(Ok(()), |travel| given_times(problem, travel))?;
    precedence(problem)
}

/// Greatest turn radius: ten times that of an airliner in a strong wind.
const TURN_RADIUS_M_MAX: f64 = 200_000.0;

/// Rejects turns that no vehicle flies.
///
/// # Errors
/// An error message that states the limits of turns.
pub fn turn_radius(radius_m: f64) -> Result<(), String> {
    not_negative("the turn radius", radius_m)?;
    if radius_m > TURN_RADIUS_M_MAX {
        return Err(format!(
            "the turn radius is {radius_m} m, wider than the {TURN_RADIUS_M_MAX} m that any aircraft needs; give metres, from its speed and bank"
        ));
    }
    Ok(())
}

/// Checks given travel times: one for each pair, and no property that only a vehicle in the air has.
fn given_times(problem: &SingleVisitProblem, travel: &TravelTimes) -> Result<(), String> {
    travel::times(travel, problem.targets.len(), problem.base.is_some())?;
    let flown = [
        (!problem.zones.is_empty(), "zones"),
        (problem.landing_distance_m_max.is_some(), "a distance to landing places"),
        (!problem.wind.layers.is_empty(), "wind"),
    ];
    match flown.iter().find(|(given, _)| *given) {
        Some((_, what)) => Err(format!("the problem has travel times and {what}; leave one of the two out")),
        None => Ok(()),
    }
}

fn precedence(problem: &SingleVisitProblem) -> Result<(), String> {
    for name in problem.precedence.iter().flat_map(|(earlier, later)| [earlier, later]) {
        if !problem.targets.iter().any(|target| target.name == *name) {
            return Err(format!("the order of visits names {name}, which is not a target"));
        }
    }
    // Repeatedly removes targets without predecessors; the remaining ones form a circle.
    let mut open: Vec<&(String, String)> = problem.precedence.iter().collect();
    loop {
        let before = open.len();
        let kept: Vec<&(String, String)> =
            open.iter().copied().filter(|(earlier, _)| open.iter().any(|(_, later)| later == earlier)).collect();
        open = kept;
        if open.len() == before {
            break;
        }
    }
    match open.first() {
        Some((earlier, later)) => {
            Err(format!("the order of visits is a circle that contains {earlier} and {later}; remove one of its pairs"))
        }
        None => Ok(()),
    }
}

fn zone(zone: &AirspaceZone) -> Result<(), String> {
    zone.corners.iter().try_for_each(|corner| on_map(&format!("a corner of zone {}", zone.name), *corner))
}

fn manoeuvre_of(target: &str, manoeuvre: &Manoeuvre) -> Result<(), String> {
    let name = format!("Manoeuvre {} of target {target}", manoeuvre.name);
    not_negative(&format!("the duration of {name}"), manoeuvre.duration_s)?;
    finite(&format!("the altitude of {name}"), manoeuvre.altitude_m)?;
    let quality = &manoeuvre.quality;
    let factors = [&quality.coverage, &quality.resolution, &quality.clarity].map(|factor| factor.factor);
    if let Some(factor) = factors.into_iter().find(|factor| !(0.0..=1.0).contains(factor)) {
        return Err(format!("a factor of the quality of {name} is {factor}; it must be within 0..1"));
    }
    if let Some(entry) = manoeuvre.entry {
        if manoeuvre.lines.is_empty() {
            return Err(format!("{name} has an `entry` but no line that it leads into"));
        }
        on_map(&name, entry)?;
    }
    manoeuvre.lines.iter().try_for_each(|(from, to)| on_map(&name, *from).and_then(|()| on_map(&name, *to)))
}

fn at_most_targets(count: usize) -> Result<(), String> {
    if count > TARGETS_MAX {
        Err(format!("{count} targets are more than {TARGETS_MAX}; split the mission"))
    } else {
        Ok(())
    }
}

fn unique_names<'a>(names: impl Iterator<Item = &'a str>) -> Result<(), String> {
    let mut sorted: Vec<&str> = names.collect();
    sorted.sort_unstable();
    let twice = sorted.iter().zip(sorted.iter().skip(1)).find(|(a, b)| a == b);
    twice.map_or(Ok(()), |(name, _)| Err(format!("two targets are called {name}; names must differ")))
}

fn positive(what: &str, number: f64) -> Result<(), String> {
    if number.is_finite() && number > 0.0 { Ok(()) } else { Err(format!("{what} is {number}; it must be positive")) }
}

fn not_negative(what: &str, number: f64) -> Result<(), String> {
    if number.is_finite() && number >= 0.0 {
        Ok(())
    } else {
        Err(format!("{what} is {number}; it must not be negative"))
    }
}

fn finite(what: &str, number: f64) -> Result<(), String> {
    if number.is_finite() { Ok(()) } else { Err(format!("{what} is {number}; it must be a number")) }
}

fn on_map(what: &str, position: Position) -> Result<(), String> {
    let (latitude, longitude) = (position.latitude_deg, position.longitude_deg);
    if latitude.abs() <= 90.0 && longitude.abs() <= 360.0 {
        Ok(())
    } else {
        Err(format!("{what} lies at ({latitude} {longitude}), which is not on the map"))
    }
}
