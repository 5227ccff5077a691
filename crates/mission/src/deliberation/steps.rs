//! Translates a plan into the procedure that the executive flies.

use super::current_plan::{observed_lines, rounded};
use super::operator_plan;
use super::solve::Deliberation;
use crate::observing::looks_with;
use crate::problem::{survey, visit_altitude_m};
use crate::site_pictures::Daylight;
use crate::vehicle::Airframe;
use crate::ways::is_inside;
use crate::{Mission, Target, TargetKind};
use apex_geo::sun::is_light;
use apex_geo::{geodesy, wind};
use apex_model::planned::{Location, LookFrom, PlannedActivity, PlannedProcedure, PlannedStep};
use apex_model::problem::{
    AirspaceZone, Manoeuvre, PictureWork, Plan, PlannedVisit, Position, Problem, SingleVisitPlan, SingleVisitProblem,
    SingleVisitTarget, SurveillancePlan, ZoneKind,
};
use apex_model::source::SourceFile;
use apex_model::symbol::Symbol;
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
use apex_pdl::PrintedPlan;

/// An arrival may be this many seconds earlier than planned: the mission then still keeps its plan (`+max-delay+` in
/// library/aerial-observation.pdl).
const EARLY_S: f64 = 900.0;
/// Timing factors that differ by less are equal.
const TIMING_TOLERANCE: f64 = 1e-3;

/// A vehicle this near to its base has not taken off; planners of ways use the same distance.
const AT_BASE_M: f64 = 1.0;

/// Shorter waits before the first visit are not flown, s.
const WAIT_S_MIN: f64 = 30.0;

/// Tag and activity of a step.
type NamedActivity = (Symbol, PlannedActivity);

/// Returns the plan as a procedure for `goal`.
pub fn translate(solved: &Deliberation, goal: &Value, number: u32, mission: &Mission) -> PlannedProcedure {
    let (mut steps, repeat) = match (&solved.problem, &solved.plan) {
        (Problem::SingleVisit(problem), Plan::SingleVisit(plan)) => (single_visit_steps(problem, plan), false),
        (_, Plan::Surveillance(plan)) => surveillance_steps(plan, mission, solved.from),
        (Problem::Surveillance(_), Plan::SingleVisit(_)) => (Vec::new(), false),
    };
    if solved.people_plan_better {
        steps.insert(0, operator_plan::step(goal, solved.plan.summary()));
    }
    let head = format!("; {}\n; {}\n", solved.plan.summary(), solved.reason);
    PlannedProcedure {
        solver: Symbol::new(solved.plan.solver()),
        summary: solved.plan.summary().to_string(),
        plan: Some(Box::new(solved.plan.clone())),
        ..procedure(goal, number, &head, steps, repeat)
    }
}

/// Returns the procedure without steps for a mission in progress in which no further target can be visited: the mission ends, and the
/// return begins. `plan` is the plan without visits, with the reason for each target; `None` if no problem could be posed.
pub(super) fn nothing_more(goal: &Value, number: u32, reason: &str, plan: Option<Plan>) -> PlannedProcedure {
    let summary = format!("no further target can be visited. {reason}");
    let head = format!("; {summary}\n");
    PlannedProcedure {
        solver: Symbol::new("single-visit"),
        summary,
        plan: plan.map(Box::new),
        ..procedure(goal, number, &head, Vec::new(), false)
    }
}

/// Returns the steps with their text, of which `head` is the beginning.
fn procedure(goal: &Value, number: u32, head: &str, steps: Vec<NamedActivity>, repeat: bool) -> PlannedProcedure {
    let goals: Vec<(Symbol, Value)> = steps.iter().map(|(tag, activity)| (tag.clone(), activity.goal())).collect();
    let PrintedPlan { text, step_lines } = apex_pdl::print_plan(goal, &goals, repeat);
    let before = u32::try_from(head.lines().count()).unwrap_or(0);
    let lines = step_lines.into_iter().map(|line| line + before).chain(std::iter::repeat(1));
    let step = |((tag, activity), line)| PlannedStep { tag, activity, line };
    PlannedProcedure {
        solver: Symbol::new(""),
        summary: String::new(),
        steps: steps.into_iter().zip(lines).map(step).collect(),
        repeat,
        plan: None,
        source: SourceFile { name: format!("<plan {number}>").into(), text: format!("{head}{text}").into() },
    }
}

fn single_visit_steps(problem: &SingleVisitProblem, plan: &SingleVisitPlan) -> Vec<NamedActivity> {
    let mut steps = Vec::new();
    let mut altitude_m = problem.vehicle.cruise_altitude_m;
    // A plan that is made on the ground is flown after the take-off, whose altitude it does not know.
    let is_at_base = problem.base.is_some_and(|base| geodesy::distance_m(problem.start, base) <= AT_BASE_M);
    let mut from_m = (!is_at_base).then_some(problem.start_altitude_m);
    let mut ready_s = problem.start_s;
    for visit in &plan.visits {
        let target = problem.targets.iter().find(|target| target.name == visit.target);
        let Some(manoeuvre) = target.and_then(|target| target.manoeuvres.get(visit.manoeuvre)) else { continue };
        hold(&mut steps, &visit.route, altitude_m, visit.depart_s - ready_s);
        ready_s = visit.end_s;
        altitude_m = manoeuvre.altitude_m;
        let change = (from_m.unwrap_or(altitude_m), altitude_m);
        detour(&mut steps, &visit.route, &bends_m(problem, (&visit.route, visit.depart_s), change));
        from_m = Some(altitude_m);
        if target.is_some_and(|target| waits(problem, target, manoeuvre, visit)) {
            wait(&mut steps, &visit.route, altitude_m, (problem, manoeuvre, visit.begin_s));
        }
        steps.push(observation(visit, manoeuvre));
    }
    hold(&mut steps, &plan.return_route, altitude_m, plan.return_depart_s - ready_s);
    let cruise_m = problem.vehicle.cruise_altitude_m;
    let change = (from_m.unwrap_or(cruise_m), cruise_m);
    let altitudes_m = bends_m(problem, (&plan.return_route, plan.return_depart_s), change);
    detour(&mut steps, &plan.return_route, &altitudes_m);
    steps
}

/// Returns the altitudes at the bends of a route: a vehicle that had to be at the altitude of the end there would circle at the first one,
/// but the plan counts the change of altitude on the whole route. Out of the space over or under a zone the altitude changes at the end.
fn bends_m(
    problem: &SingleVisitProblem,
    (route, depart_s): (&[Position], f64),
    (from_m, to_m): (f64, f64),
) -> Vec<f64> {
    let bends = route.len().saturating_sub(2);
    let vehicle = &problem.vehicle;
    let rate_mps = if to_m > from_m { vehicle.climb_rate_mps } else { vehicle.descent_rate_mps };
    if rate_mps <= 0.0 {
        return vec![to_m; bends];
    }
    let (low_m, high_m) = (from_m.min(to_m), from_m.max(to_m));
    let is_over = |zone: &&AirspaceZone| {
        zone.kind == ZoneKind::Restricted
            && zone.altitude_m_min <= high_m
            && low_m < zone.altitude_m_max
            && route.first().is_some_and(|begin| is_inside(*begin, &zone.corners))
    };
    if problem.zones.iter().any(|zone| is_over(&zone)) {
        return vec![from_m; bends];
    }
    let mut at_s = depart_s;
    let legs = route.iter().zip(route.iter().skip(1)).take(bends);
    let altitudes_m = legs.map(|(from, to)| {
        let leg_s = wind::leg_time_s(*from, *to, to_m, vehicle.true_airspeed_mps, &problem.wind, at_s);
        at_s += leg_s.unwrap_or_else(|| geodesy::distance_m(*from, *to) / vehicle.true_airspeed_mps);
        let change_m = rate_mps * (at_s - depart_s);
        if to_m > from_m { (from_m + change_m).min(to_m) } else { (from_m - change_m).max(to_m) }
    });
    altitudes_m.collect()
}

/// Returns the step that observes the target of a visit: with the scanner, or with a camera.
fn observation(visit: &PlannedVisit, manoeuvre: &Manoeuvre) -> NamedActivity {
    let target = visit.target.clone();
    let due = Duration::from_seconds(visit.end_s.round());
    let lines = observed_lines(manoeuvre);
    let (verb, activity) = match (&manoeuvre.pictures, lines.first()) {
        (
            Some(PictureWork {
                form: Some(form), camera, at: Some(at), every_m: Some(every_m), true_airspeed_mps, ..
            }),
            _,
        ) => {
            let (form, camera, at) = (form.clone(), camera.clone(), at.clone());
            let (speed_mps, every_m) = (*true_airspeed_mps, *every_m);
            ("perform", PlannedActivity::Perform { target, at, form, camera, speed_mps, every_m, due })
        }
        (Some(PictureWork { camera, at: Some(at), count, .. }), Some((from, _))) => {
            let (from, camera, at) = (*from, camera.clone(), at.clone());
            ("inspect", PlannedActivity::Inspect { target, from, camera, at, count: *count, due })
        }
        (Some(PictureWork { camera, every_m: Some(every_m), true_airspeed_mps, .. }), _) => {
            let (camera, every_m, speed_mps) = (camera.clone(), *every_m, *true_airspeed_mps);
            ("photograph", PlannedActivity::Photograph { target, lines, camera, every_m, speed_mps, due })
        }
        _ => ("observe", PlannedActivity::Observe { target, lines, due: Some(due) }),
    };
    (Symbol::new(&format!("{verb}-{}", visit.target)), activity)
}

/// Returns true if the observation waits for its instant: the plan waits, or an earlier arrival would meet unsuitable light, a closed
/// window or a lower timing factor.
fn waits(
    problem: &SingleVisitProblem,
    target: &SingleVisitTarget,
    manoeuvre: &Manoeuvre,
    visit: &PlannedVisit,
) -> bool {
    let early_s = visit.begin_s - EARLY_S;
    let closed = !target.windows.is_empty() && !target.windows.iter().any(|window| window.contains(early_s));
    let dark = [early_s, early_s + manoeuvre.duration_s]
        .iter()
        .any(|time_s| !is_light(target.light, target.position, problem.zero_unix_s + time_s));
    let lower = target.timing_at(early_s) < target.timing_at(visit.begin_s) - TIMING_TOLERANCE;
    visit.begin_s - visit.arrive_s >= 1.0 || closed || dark || lower
}

/// Adds a circle at the end of a route until the observation may begin; it ends at once if that instant has passed. A vehicle with turns
/// leaves the circle in time for the lead-in before the first line.
fn wait(
    steps: &mut Vec<NamedActivity>,
    route: &[Position],
    altitude_m: f64,
    (problem, manoeuvre, begin_s): (&SingleVisitProblem, &Manoeuvre, f64),
) {
    let Some(there) = route.last() else { return };
    let tag = Symbol::new(&format!("wait-{}", steps.len() + 1));
    let until = Duration::from_seconds(libm::ceil(begin_s));
    let is_from_point = manoeuvre.pictures.as_ref().is_some_and(|work| work.form.is_some() || work.at.is_some());
    let line = observed_lines(manoeuvre).first().copied();
    let line = line.filter(|_| problem.vehicle.turn_radius_m > 0.0 && !is_from_point);
    let circle = PlannedActivity::LoiterUntil { at: at(*there, altitude_m), until };
    let activity = line.map(|(from, to)| {
        let before = ["before", "line", "from"].map(Value::symbol).into_iter().chain([from.value()]);
        let items = circle.goal().as_list().unwrap_or_default().to_vec();
        let goal = items.into_iter().chain(before).chain([Value::symbol("to"), to.value()]);
        PlannedActivity::Goal(Value::list(goal))
    });
    steps.push((tag, activity.unwrap_or(circle)));
}

/// Adds a hold at the beginning of a route until it is open; nothing for less than a second.
fn hold(steps: &mut Vec<NamedActivity>, route: &[Position], altitude_m: f64, seconds: f64) {
    let Some(here) = route.first().filter(|_| seconds >= 1.0) else { return };
    let tag = Symbol::new(&format!("hold-{}", steps.len() + 1));
    let time = Duration::from_seconds(seconds.round());
    steps.push((tag, PlannedActivity::Loiter { at: at(*here, altitude_m), time }));
}

/// Adds the way points strictly between the ends of a route, the bends around airspace, at these altitudes.
fn detour(steps: &mut Vec<NamedActivity>, route: &[Position], altitudes_m: &[f64]) {
    let bends = route.len().saturating_sub(2);
    for (bend, altitude_m) in route.iter().skip(1).take(bends).zip(altitudes_m) {
        let tag = Symbol::new(&format!("around-{}", steps.len() + 1));
        steps.push((tag, PlannedActivity::FlyTo(at(*bend, *altitude_m))));
    }
}

fn surveillance_steps(
    plan: &SurveillancePlan,
    mission: &Mission,
    from: Option<(Position, Time)>,
) -> (Vec<NamedActivity>, bool) {
    let site = |target: &Target| match &target.kind {
        TargetKind::Site(site) => Some((target.clone(), site.dwell_s)),
        _ => None,
    };
    let sites: Vec<(Target, f64)> = mission.targets.iter().filter_map(site).collect();
    let positions: Vec<Position> = sites.iter().map(|(target, _)| target.position).collect();
    let (start, begin) = from.unwrap_or((mission.start, Time::ZERO));
    let mut ways = survey(mission, &positions, start, begin.seconds()).ok();
    let first = plan.visits.first();
    let first_number = first.and_then(|visit| sites.iter().position(|(target, _)| target.id == visit.target));
    let way_s = ways.as_ref().zip(first_number).map(|(ways, number)| ways.times.start_to(number));
    // The plan begins with the daylight; a cycle is then written as its visits, so that it begins only once. The planned arrival does not
    // tell the wait: it may be later because of the wind that is measured.
    let dark_s =
        Daylight::next(mission, begin.seconds()).ok().flatten().map_or(0.0, |light| light.from_s - begin.seconds());
    let wait_s = way_s.map_or(0.0, |way_s| (dark_s - way_s).max(0.0));
    let repeat = !plan.cycle.is_empty() && wait_s < WAIT_S_MIN;
    let order: Vec<&String> =
        if repeat { plan.cycle.iter().collect() } else { plan.visits.iter().map(|visit| &visit.target).collect() };
    // A cycle is flown again and again by the ways of its first lap.
    let mut departs_s = vec![0.0];
    departs_s.extend(plan.visits.iter().map(|visit| visit.end_s));
    let mut route = |from: Option<usize>, to: usize, number: usize| {
        let depart_s = departs_s.get(number).or(departs_s.last()).copied().unwrap_or(0.0);
        ways.as_mut().map_or_else(Vec::new, |ways| ways.route(from, to, depart_s))
    };
    let mut order: Vec<usize> =
        order.iter().filter_map(|name| sites.iter().position(|(target, _)| target.id == **name)).collect();
    if repeat {
        // A cycle is repeated from its first site, so a route without bends is preferred for the way from the start.
        let open = order.iter().position(|site| route(None, *site, 0).len() == 2);
        order.rotate_left(open.unwrap_or(0));
    }
    // A vehicle that cannot hover observes from a circle around the site.
    let circles = mission.model.airframe == Airframe::FixedWing;
    let camera = looks_with(&mission.model).map(|camera| camera.name);
    let mut steps = Vec::new();
    if let (false, Some((target, _))) = (repeat, order.first().and_then(|number| sites.get(*number))) {
        let wait_s = if wait_s < WAIT_S_MIN { 0.0 } else { wait_s };
        hold(&mut steps, &[start], visit_altitude_m(mission, target), wait_s);
    }
    let mut before = None;
    for (index, number) in order.iter().enumerate() {
        let Some((target, dwell_s)) = sites.get(*number) else { continue };
        let altitude_m = visit_altitude_m(mission, target);
        if before.is_some() || !repeat {
            let route = route(before, *number, index);
            detour(&mut steps, &route, &vec![altitude_m; route.len()]);
        }
        before = Some(*number);
        let visit = PlannedActivity::Visit {
            site: target.id.clone(),
            from: if circles { LookFrom::Circle } else { LookFrom::Point },
            at: at(target.position, altitude_m),
            dwell: Duration::from_seconds(*dwell_s),
            camera: camera.clone(),
        };
        steps.push((Symbol::new(&format!("visit-{}-{}", index + 1, target.id)), visit));
    }
    if let (true, Some(first), Some(last)) = (repeat, order.first(), order.last()) {
        let altitude_m = sites.get(*first).map_or(0.0, |(target, _)| visit_altitude_m(mission, target));
        let route = route(Some(*last), *first, order.len());
        detour(&mut steps, &route, &vec![altitude_m; route.len()]);
    }
    (steps, repeat)
}

/// Returns a location, rounded.
fn at(position: Position, altitude_m: f64) -> Location {
    rounded(Location { position, altitude_m })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Altitudes of the bend of a plan whose vehicle is `start` at 6,000 m and observes from 10,000 m: 100 m/s, climbing at 4 m/s.
    fn bend_m(start: Position) -> f64 {
        let (bend, entry) = (Position::new(40.5, -120.0), Position::new(41.0, -119.5));
        let manoeuvre = Manoeuvre { altitude_m: 10_000.0, lines: vec![(entry, entry)], ..Manoeuvre::default() };
        let target =
            SingleVisitTarget { name: "fire".into(), manoeuvres: vec![manoeuvre], ..SingleVisitTarget::default() };
        let mut problem = SingleVisitProblem {
            targets: vec![target],
            start,
            start_altitude_m: 6_000.0,
            base: Some(Position::new(40.0, -120.0)),
            ..SingleVisitProblem::default()
        };
        problem.vehicle.true_airspeed_mps = 100.0;
        (problem.vehicle.climb_rate_mps, problem.vehicle.descent_rate_mps) = (4.0, 5.0);
        let visit = PlannedVisit {
            target: "fire".into(),
            manoeuvre: 0,
            route: vec![start, bend, entry],
            path: Vec::new(),
            depart_s: 0.0,
            arrive_s: 1_500.0,
            begin_s: 1_500.0,
            end_s: 1_500.0,
            timing: 1.0,
            worth: 1.0,
            quality: None,
        };
        let plan = SingleVisitPlan {
            solver: String::new(),
            visits: vec![visit],
            return_route: Vec::new(),
            return_path: Vec::new(),
            return_depart_s: 1_500.0,
            end_s: 1_500.0,
            fuel_used_kg: 0.0,
            benefits: 1.0,
            costs: 0.0,
            score: 1.0,
            benefits_bound: None,
            left_out: Vec::new(),
            summary: String::new(),
        };
        let steps = single_visit_steps(&problem, &plan);
        match &steps[0].1 {
            PlannedActivity::FlyTo(bend) => bend.altitude_m,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn a_bend_is_reached_at_the_altitude_that_the_plan_counts_there() {
        // 44.5 km to the north of the start: 445 s of climb.
        let in_flight_m = bend_m(Position::new(40.1, -120.0));
        assert!((in_flight_m - (6_000.0 + 4.0 * 444.2)).abs() < 10.0, "{in_flight_m}");
        // On the ground the altitude after the take-off is not known.
        assert_eq!(bend_m(Position::new(40.0, -120.0)), 10_000.0);
    }

    #[test]
    fn a_way_that_opens_later_is_waited_for_where_it_begins() {
        let here = Position::new(40.0, -120.0);
        let mut steps = Vec::new();
        hold(&mut steps, &[here, here], 7000.0, 0.5);
        assert_eq!(steps, []);
        hold(&mut steps, &[here, here], 7000.0, 90.2);
        let printed = procedure(&Value::symbol("go"), 1, "; head\n", steps, false);
        assert_eq!(printed.steps.iter().map(|step| step.line).collect::<Vec<_>>(), [4]);
        let printed = printed.source.text;
        assert!(printed.contains("(step hold-1 (loiter at (40.0 -120.0 7000.0) for P1M30S))"), "{printed}");
    }
}
