//! A plan on the map: everything that a file for other programs needs, with places, altitudes and times.
//!
//! Plans contain names, times and, for vehicles in the air, routes. A chart adds positions; formats are written from it alone.

use super::watch::VisitFollower;
use crate::vehicle::Airframe;
use crate::{Mission, TargetKind};
use apex_metrics::eci;
use apex_model::problem::{
    AirspaceZone, Manoeuvre, Plan, PlannedVisit, Position, Problem, SingleVisitPlan, SingleVisitProblem,
    SurveillancePlan, SurveillanceProblem,
};
use apex_planning::surveillance::travel::SurveillanceTravel;
use serde_json::{Map, Value, json};

/// A position, with its altitude above mean sea level if known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChartPoint {
    /// Position.
    pub position: Position,
    /// Altitude.
    pub altitude_m: Option<f64>,
}

/// One observation, with the path to it.
#[derive(Clone, Debug, PartialEq)]
pub struct ChartVisit {
    /// The target's name.
    pub target: String,
    /// Way points from the place before to where the observation begins, both included.
    pub way: Vec<ChartPoint>,
    /// Lines flown while observing; empty if the vehicle stays in place.
    pub lines: Vec<ChartPoint>,
    /// Circle around the target from which the vehicle observes.
    pub circle: Option<Circle>,
    /// Arrival of the vehicle.
    pub arrive_s: f64,
    /// Beginning of the observation.
    pub begin_s: f64,
    /// End of the observation.
    pub end_s: f64,
}

/// Observation from a circle, with the data that an autopilot needs.
#[derive(Clone, Debug, PartialEq)]
pub struct Circle {
    /// Centre of the circle.
    pub centre: ChartPoint,
    /// The bends of the path to it.
    pub bends: Vec<ChartPoint>,
}

/// A target, visited or not.
#[derive(Clone, Debug, PartialEq)]
pub struct ChartTarget {
    /// Its name.
    pub name: String,
    /// Position.
    pub place: ChartPoint,
    /// Facts about the target and its observation: value, factors, costs.
    pub facts: Map<String, Value>,
    /// Reason if the target is not visited.
    pub left_out: Option<String>,
}

/// A plan on the map.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    /// Name of the problem.
    pub name: String,
    /// The plan as one line of text.
    pub summary: String,
    /// Facts of the plan: planner, value, upper bound on any plan.
    pub facts: Map<String, Value>,
    /// Civil time (seconds since 1970-01-01T00:00Z) of time zero, if known.
    pub zero_unix_s: Option<f64>,
    /// Flight properties of the vehicle, if known.
    pub airframe: Option<Airframe>,
    /// Its cruise speed, if known.
    pub speed_mps: Option<f64>,
    /// Start of the flight, if known.
    pub start: Option<ChartPoint>,
    /// Required end of the flight, if any.
    pub base: Option<ChartPoint>,
    /// The observations in order.
    pub visits: Vec<ChartVisit>,
    /// Number of visits of one round, if the plan repeats a round.
    pub round: Option<usize>,
    /// Way points from the last observation to the base, both included.
    pub return_way: Vec<ChartPoint>,
    /// End of the flight.
    pub end_s: f64,
    /// All targets in the problem's order.
    pub targets: Vec<ChartTarget>,
    /// Airspace.
    pub zones: Vec<AirspaceZone>,
}

impl Chart {
    /// Returns the whole path over ground, without doubled points.
    pub fn path(&self) -> Vec<ChartPoint> {
        let flown = self.visits.iter().flat_map(|visit| visit.way.iter().chain(&visit.lines));
        let mut path: Vec<ChartPoint> = flown.chain(&self.return_way).copied().collect();
        path.dedup();
        path
    }
}

/// Returns degrees rounded to about a centimetre on the ground.
pub fn digits(degrees: f64) -> f64 {
    (degrees * 1e7).round() / 1e7
}

/// Returns seconds rounded to a millisecond.
pub fn milliseconds(seconds: f64) -> f64 {
    (seconds * 1e3).round() / 1e3
}

/// Returns the chart of `plan` for `problem`. `start` is the start of a surveillance plan, which its problem does not contain.
///
/// # Errors
/// A message if the plan is of another kind than the problem, or the problem has no places.
pub fn chart(
    name: &str,
    (problem, plan): (&Problem, &Plan),
    start: Option<Position>,
    mission: Option<&Mission>,
) -> Result<Chart, String> {
    let mut chart = match (problem, plan) {
        (Problem::SingleVisit(problem), Plan::SingleVisit(plan)) => of_single_visit(problem, plan),
        (Problem::Surveillance(problem), Plan::Surveillance(plan)) => of_surveillance(problem, plan, start, mission),
        (Problem::SingleVisit(_), Plan::Surveillance(_)) | (Problem::Surveillance(_), Plan::SingleVisit(_)) => {
            return Err("the plan is of another kind than its problem".into());
        }
    };
    let same =
        |other: &ChartTarget| Some(other.place.position) == chart.targets.first().map(|first| first.place.position);
    if chart.targets.iter().all(same)
        && (chart.targets.len() > 1 || chart.targets.iter().all(|target| target.place.position == Position::default()))
    {
        return Err("it gives travel times only: all of its targets lie at one point".into());
    }
    chart.name = name.to_string();
    chart.summary = plan.summary().to_string();
    chart.facts.insert("solver".into(), json!(plan.solver()));
    for left in plan.left_out() {
        if let Some(target) = chart.targets.iter_mut().find(|target| target.name == left.target) {
            target.left_out = Some(left.reason.clone());
        }
    }
    if let Some(mission) = mission {
        chart.zones = mission.zones.clone();
        chart.zero_unix_s = mission.settings.epoch_unix_s;
        chart.airframe = Some(mission.model.airframe);
        chart.speed_mps = Some(mission.model.true_airspeed_m_s_cruise);
    }
    Ok(chart)
}

fn facts<const N: usize>(facts: [(&str, Value); N]) -> Map<String, Value> {
    facts.into_iter().map(|(name, value)| (name.to_string(), value)).collect()
}

fn of_single_visit(problem: &SingleVisitProblem, plan: &SingleVisitPlan) -> Chart {
    // With given travel times, no altitudes are known.
    let flown = problem.travel.is_none();
    let high = |altitude_m: f64| flown.then_some(altitude_m);
    let start = ChartPoint { position: problem.start, altitude_m: high(problem.start_altitude_m) };
    let mut targets: Vec<ChartTarget> = Vec::with_capacity(problem.targets.len());
    for target in &problem.targets {
        let place = ChartPoint { position: target.position, altitude_m: None };
        let facts = facts([("value", json!(target.value))]);
        targets.push(ChartTarget { name: target.name.clone(), place, facts, left_out: None });
    }
    let mut visits: Vec<ChartVisit> = Vec::with_capacity(plan.visits.len());
    let (mut before, mut altitude_m) = (start, problem.vehicle.cruise_altitude_m);
    for visit in &plan.visits {
        let index = problem.targets.iter().position(|target| target.name == visit.target);
        let Some((target, shown)) = index.and_then(|index| problem.targets.get(index).zip(targets.get_mut(index)))
        else {
            continue;
        };
        let Some(manoeuvre) = target.manoeuvres.get(visit.manoeuvre) else { continue };
        let at = |position: Position| ChartPoint { position, altitude_m: high(manoeuvre.altitude_m) };
        let mut way = vec![before];
        way.extend(bends(drawn(&visit.route, &visit.path), high(altitude_m)));
        let lines: Vec<ChartPoint> = manoeuvre.lines.iter().flat_map(|(from, to)| [at(*from), at(*to)]).collect();
        way.extend(manoeuvre.entry.map(at));
        way.push(lines.first().copied().unwrap_or(at(target.position)));
        before = lines.last().copied().unwrap_or(at(target.position));
        altitude_m = manoeuvre.altitude_m;
        shown.facts.extend(factors(manoeuvre, visit));
        shown.place.altitude_m = high(manoeuvre.altitude_m);
        let (arrive_s, begin_s, end_s) = (visit.arrive_s, visit.begin_s, visit.end_s);
        visits.push(ChartVisit { target: visit.target.clone(), way, lines, circle: None, arrive_s, begin_s, end_s });
    }
    let base = problem.base.map(|position| ChartPoint { position, altitude_m: high(problem.start_altitude_m) });
    let mut return_way = Vec::new();
    if let Some(base) = base {
        return_way.push(before);
        return_way.extend(bends(drawn(&plan.return_route, &plan.return_path), high(altitude_m)));
        return_way.push(base);
    }
    Chart {
        name: String::new(),
        summary: String::new(),
        facts: facts([
            ("benefits", json!(plan.benefits)),
            ("benefits_bound", json!(plan.benefits_bound)),
            ("costs", json!(plan.costs)),
            ("score", json!(plan.score)),
        ]),
        zero_unix_s: (problem.zero_unix_s != 0.0).then_some(problem.zero_unix_s),
        airframe: None,
        speed_mps: flown.then_some(problem.vehicle.true_airspeed_mps),
        start: Some(start),
        base,
        visits,
        round: None,
        return_way,
        end_s: plan.end_s,
        targets,
        zones: problem.zones.clone(),
    }
}

/// Returns the value of an observation with its reasons, factor by factor.
fn factors(manoeuvre: &Manoeuvre, visit: &PlannedVisit) -> Map<String, Value> {
    let mut facts = Map::new();
    let quality = &manoeuvre.quality;
    for (name, factor) in
        [("coverage", &quality.coverage), ("resolution", &quality.resolution), ("clarity", &quality.clarity)]
    {
        facts.insert(name.into(), json!(factor.factor));
        if !factor.cause.is_empty() {
            facts.insert(format!("{name}_cause"), json!(factor.cause));
        }
    }
    facts.insert("timing".into(), json!(visit.timing));
    facts.insert("worth".into(), json!(visit.worth));
    facts.insert("manoeuvre".into(), json!(manoeuvre.name));
    facts
}

/// Returns the travel computation between the targets of a mission's surveillance problem; `None` if the mission's data are invalid.
fn flown_ways(mission: &Mission, problem: &SurveillanceProblem) -> Option<SurveillanceTravel> {
    let positions: Vec<Position> = problem.targets.iter().map(|target| target.position).collect();
    crate::problem::survey(mission, &positions, mission.start, 0.0).ok()
}

/// Returns the path with its turns if there is one, otherwise the route.
fn drawn<'a>(route: &'a [Position], path: &'a [Position]) -> &'a [Position] {
    if path.is_empty() { route } else { path }
}

/// Returns the points strictly between the ends of a route.
pub(super) fn bends(route: &[Position], altitude_m: Option<f64>) -> impl Iterator<Item = ChartPoint> {
    let between = route.iter().skip(1).take(route.len().saturating_sub(2));
    between.map(move |position| ChartPoint { position: *position, altitude_m })
}

fn of_surveillance(
    problem: &SurveillanceProblem,
    plan: &SurveillancePlan,
    start: Option<Position>,
    mission: Option<&Mission>,
) -> Chart {
    let costs = eci::expected_cost(problem, &plan.visits);
    let altitude_m = |name: &str| {
        let mission = mission?;
        let site = mission.targets.iter().find(|target| target.id == name)?;
        matches!(site.kind, TargetKind::Site(_)).then(|| crate::problem::visit_altitude_m(mission, site))
    };
    let mut targets: Vec<ChartTarget> = Vec::with_capacity(problem.targets.len());
    for (target, cost) in problem.targets.iter().zip(&costs.targets) {
        targets.push(ChartTarget {
            name: target.name.clone(),
            place: ChartPoint { position: target.position, altitude_m: altitude_m(&target.name) },
            facts: facts([
                ("expected_cost", json!(cost.expected_cost)),
                ("observations", json!(cost.observations)),
                ("longest_gap_s", json!(cost.longest_gap_s)),
                ("dwell_s", json!(target.dwell_s)),
            ]),
            left_out: None,
        });
    }
    let start = start.or(mission.map(|mission| mission.start));
    let start =
        start.map(|position| ChartPoint { position, altitude_m: mission.map(|mission| mission.start_altitude_m) });
    let mut watch = VisitFollower::new(mission.and_then(|mission| flown_ways(mission, problem)), start);
    let mut visits: Vec<ChartVisit> = Vec::with_capacity(plan.visits.len());
    for visit in &plan.visits {
        let Some(to) = targets.iter().position(|target| target.name == visit.target) else { continue };
        let Some(here) = targets.get(to).map(|target| target.place) else { continue };
        visits.push(watch.visit((to, here), visit));
    }
    let base = start.filter(|_| problem.return_to_base);
    let return_way = base.map_or_else(Vec::new, |base| watch.home(base));
    let cycle = plan.cycle.len();
    let repeats = visits.iter().enumerate().all(|(index, visit)| {
        index.checked_rem(cycle).and_then(|place| plan.cycle.get(place)).is_some_and(|name| *name == visit.target)
    });
    let ends = visits.last().map_or(0.0, |visit| visit.end_s);
    Chart {
        name: String::new(),
        summary: String::new(),
        facts: facts([
            ("expected_cost", json!(plan.expected_cost)),
            ("expected_cost_bound", json!(plan.expected_cost_bound)),
            ("gap", json!(plan.gap())),
            ("horizon_s", json!(problem.horizon_s)),
        ]),
        zero_unix_s: None,
        airframe: None,
        speed_mps: None,
        start,
        base,
        return_way,
        end_s: plan.return_s.unwrap_or(ends),
        visits,
        round: (cycle > 0 && repeats).then_some(cycle),
        targets,
        zones: Vec::new(),
    }
}
