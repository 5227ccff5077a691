//! Independent check of a single-visit plan: flies it in short steps, with separate arithmetic for wind, polygons, fuel and value.

use super::{given_times, turns};
use apex_geo::geodesy::{self, Position, RAD_PER_DEG, wrap_180};
use apex_geo::{sun, wind};
use apex_model::problem::{
    AirspaceZone, Manoeuvre, PlannedVisit, SingleVisitPlan, SingleVisitProblem, SingleVisitTarget, ZoneKind,
};

/// Length of a step along a leg.
const STEP_M: f64 = 5_000.0;
/// Steps of one leg: short legs of small vehicles are cut, too.
const STEPS_MIN: usize = 20;
const STEPS_MAX: usize = 4_000;
/// A leg may be faster than the checker's by this share and [`TIME_TOLERANCE_S`]: both integrate in steps.
const TIME_TOLERANCE: f64 = 0.02;
const TIME_TOLERANCE_S: f64 = 30.0;
/// Relative difference between distances on the sphere and on the ellipsoid: a place that is nearer than the limit by more than this is
/// certainly near enough.
const SPHERE_TOLERANCE: f64 = 0.01;
const WORTH_TOLERANCE: f64 = 1e-6;

/// Returns the violations of `plan`; empty if there are none.
pub(super) fn violations(problem: &SingleVisitProblem, plan: &SingleVisitPlan) -> Vec<String> {
    let mut found = Vec::new();
    let mut here = problem.start;
    let mut altitude_m = problem.start_altitude_m;
    let mut time_s = problem.start_s;
    let mut benefits = 0.0;
    let mut exit = None;
    for (number, visit) in plan.visits.iter().enumerate() {
        let target = problem.targets.iter().find(|target| target.name == visit.target);
        let manoeuvre = target.and_then(|target| target.manoeuvres.get(visit.manoeuvre));
        let (Some(target), Some(manoeuvre)) = (target, manoeuvre) else {
            found.push(format!("visit {} names a target or manoeuvre that does not exist", number + 1));
            continue;
        };
        if plan.visits.iter().take(number).any(|earlier| earlier.target == visit.target) {
            found.push(format!("visits {} twice", visit.target));
        }
        let begins = manoeuvre.lines.first().map_or(target.position, |(from, _)| *from);
        let entry = manoeuvre.entry.unwrap_or(begins);
        let leg = CheckedLeg { to: &visit.target, from_m: altitude_m, to_m: manoeuvre.altitude_m, is_backwards: false };
        if problem.travel.is_none() {
            if visit.depart_s < time_s - 1e-6 {
                found.push(format!("leaves for {} before the previous visit has ended", visit.target));
            }
            ends_meet(&visit.route, here, entry, &visit.target, &mut found);
            let flown = turns::flown(problem, &visit.route, &visit.path);
            fly(problem, flown, &leg, (visit.depart_s, visit.arrive_s), &mut found);
            let ends = (exit, turns::track_rad(manoeuvre.lines.first(), false));
            turns::check(problem, flown, visit.depart_s, ends, &visit.target, &mut found);
        }
        observe(problem, target, manoeuvre, visit, &mut found);
        benefits += visit.worth;
        // If the manoeuvre has no lines, the vehicle leaves the place in the direction of its arrival.
        let came = || turns::end_track_rad(turns::flown(problem, &visit.route, &visit.path));
        exit = turns::track_rad(manoeuvre.lines.last(), true).or_else(came);
        here = manoeuvre.lines.last().map_or(target.position, |(_, to)| *to);
        (altitude_m, time_s) = (manoeuvre.altitude_m, visit.end_s);
    }
    if let Some(travel) = &problem.travel {
        given_times::legs(problem, travel, plan, &mut found);
    } else if plan.visits.is_empty() && problem.base.is_none_or(|base| geodesy::distance_m(problem.start, base) <= 1.0)
    {
        // No leg is flown: the vehicle stays at its position.
    } else if let Some(base) = problem.base {
        let leg = CheckedLeg {
            to: "the base",
            from_m: altitude_m,
            to_m: problem.vehicle.cruise_altitude_m,
            is_backwards: false,
        };
        ends_meet(&plan.return_route, here, base, "the base", &mut found);
        let depart_s = plan.return_depart_s.max(time_s);
        let flown = turns::flown(problem, &plan.return_route, &plan.return_path);
        fly(problem, flown, &leg, (depart_s, plan.end_s), &mut found);
        turns::check(problem, flown, depart_s, (exit, None), "the base", &mut found);
    } else if (plan.end_s - time_s).abs() > 1e-6 {
        found.push("does not end with its last visit".to_string());
    }
    order(problem, plan, &mut found);
    limits(problem, plan, &mut found);
    sums(problem, plan, benefits - missed(problem, plan), &mut found);
    found
}

struct CheckedLeg<'a> {
    to: &'a str,
    from_m: f64,
    to_m: f64,
    is_backwards: bool,
}

impl CheckedLeg<'_> {
    /// Returns the leg as seen from its end: with the altitudes by the time that is left.
    fn backwards(&self) -> Self {
        CheckedLeg { from_m: self.to_m, to_m: self.from_m, is_backwards: true, ..*self }
    }
}

fn ends_meet(route: &[Position], from: Position, to: Position, name: &str, found: &mut Vec<String>) {
    let apart = |end: Option<&Position>, wanted| end.is_none_or(|end| geodesy::distance_m(*end, wanted) > 1.0);
    if apart(route.first(), from) || apart(route.last(), to) {
        found.push(format!("the route to {name} does not lead from where the vehicle is to where it must be"));
    }
}

/// Part of a leg in which the altitude changes.
#[derive(Clone, Copy, PartialEq)]
enum ChangeOfAltitude {
    AtOnce,
    /// Within the last part of the leg, which takes the time of the change in addition: vehicles circle near the end.
    Late,
    /// In circles over the end of the leg, which take their own time.
    OverTheEnd,
}

/// Flies `route` in steps and compares time, airspace and landing distance. The altitude changes at the beginning of the leg, at its end,
/// or in circles over the end: one of these must keep the rules.
fn fly(
    problem: &SingleVisitProblem,
    route: &[Position],
    leg: &CheckedLeg<'_>,
    (depart_s, arrive_s): (f64, f64),
    found: &mut Vec<String>,
) {
    let vehicle = &problem.vehicle;
    let mut time_s = depart_s;
    let mut middles = Vec::new();
    for (from, to) in route.iter().zip(route.iter().skip(1)) {
        let (length_m, track_deg) = geodesy::inverse(*from, *to);
        let steps = ((length_m / STEP_M) as usize + 1).clamp(STEPS_MIN, STEPS_MAX);
        let mut begin = *from;
        for step in 0..steps {
            let at =
                |share: f64| geodesy::destination(*from, track_deg, (step as f64 + share) * length_m / steps as f64);
            let (middle, end) = (at(0.5), at(1.0));
            let speed_mps = ground_speed_mps(problem, begin, end, middle, time_s);
            begin = end;
            let begin_s = time_s;
            time_s += length_m / steps as f64 / speed_mps;
            middles.push((middle, begin_s, time_s));
        }
    }
    let end_s = time_s;
    let against = |change: ChangeOfAltitude| {
        let mut against = Vec::new();
        for (middle, begin_s, time_s) in &middles {
            let heights = match change {
                ChangeOfAltitude::AtOnce => heights_m(problem, leg, begin_s - depart_s),
                ChangeOfAltitude::Late => heights_m(problem, &leg.backwards(), end_s - time_s),
                ChangeOfAltitude::OverTheEnd => (leg.from_m, leg.from_m),
            };
            inside_rules(problem, *middle, heights, *time_s, leg.to, &mut against);
        }
        if change == ChangeOfAltitude::OverTheEnd
            && let Some(end) = route.last()
        {
            let heights = (leg.from_m.min(leg.to_m), leg.from_m.max(leg.to_m));
            inside_rules(problem, *end, heights, end_s, leg.to, &mut against);
        }
        against
    };
    let rate = if leg.to_m > leg.from_m { vehicle.climb_rate_mps } else { vehicle.descent_rate_mps };
    let change_s = if rate > 0.0 { (leg.to_m - leg.from_m).abs() / rate } else { 0.0 };
    let mut needed_s = (time_s - depart_s).max(change_s);
    let at_once = against(ChangeOfAltitude::AtOnce);
    if !at_once.is_empty() {
        needed_s = time_s - depart_s + change_s;
        if !against(ChangeOfAltitude::Late).is_empty() && !against(ChangeOfAltitude::OverTheEnd).is_empty() {
            at_once.into_iter().for_each(|message| note(found, message));
        }
    }
    let given_s = arrive_s - depart_s;
    if given_s.is_nan() || given_s < needed_s * (1.0 - TIME_TOLERANCE) - TIME_TOLERANCE_S {
        found.push(format!("allows {given_s:.0} s for the way to {}, but it takes {needed_s:.0} s", leg.to));
    }
}

/// Returns the altitudes that the vehicle may have `flown_s` seconds after departure: it climbs or descends at once, and may have
/// arrived.
fn heights_m(problem: &SingleVisitProblem, leg: &CheckedLeg<'_>, flown_s: f64) -> (f64, f64) {
    let vehicle = &problem.vehicle;
    let (climb, descent) = match leg.is_backwards {
        false => (vehicle.climb_rate_mps, vehicle.descent_rate_mps),
        true => (vehicle.descent_rate_mps, vehicle.climb_rate_mps),
    };
    let now_m = match leg.to_m > leg.from_m {
        true if climb > 0.0 => (leg.from_m + climb * flown_s).min(leg.to_m),
        false if descent > 0.0 => (leg.from_m - descent * flown_s).max(leg.to_m),
        _ => leg.to_m,
    };
    (now_m.min(leg.to_m), now_m.max(leg.to_m))
}

/// Returns the speed over ground from vectors: the air velocity of given length whose sum with the wind points along the step.
pub(super) fn ground_speed_mps(
    problem: &SingleVisitProblem,
    from: Position,
    to: Position,
    middle: Position,
    time_s: f64,
) -> f64 {
    let here = wind::at(&problem.wind, middle, problem.vehicle.cruise_altitude_m, time_s);
    let north = to.latitude_deg - from.latitude_deg;
    let east = wrap_180(to.longitude_deg - from.longitude_deg) * libm::cos(middle.latitude_deg * RAD_PER_DEG);
    let length = libm::hypot(east, north);
    if length == 0.0 {
        return problem.vehicle.true_airspeed_mps;
    }
    let (east, north) = (east / length, north / length);
    // |s u - w| = airspeed, for the speed s along the unit vector u: s^2 - 2 s u.w + w.w - airspeed^2 = 0.
    let along = east * here.east_mps + north * here.north_mps;
    let rest = here.east_mps * here.east_mps + here.north_mps * here.north_mps
        - problem.vehicle.true_airspeed_mps * problem.vehicle.true_airspeed_mps;
    let root = along * along - rest;
    if root <= 0.0 { f64::MIN_POSITIVE } else { (along + libm::sqrt(root)).max(f64::MIN_POSITIVE) }
}

/// Checks airspace and landing distance at one place.
fn inside_rules(
    problem: &SingleVisitProblem,
    place: Position,
    (low_m, high_m): (f64, f64),
    time_s: f64,
    name: &str,
    found: &mut Vec<String>,
) {
    let meets = |zone: &&AirspaceZone| {
        zone.altitude_m_min <= high_m && low_m < zone.altitude_m_max && zone.active.contains(time_s)
    };
    let restricted = problem.zones.iter().filter(|zone| zone.kind == ZoneKind::Restricted).filter(meets);
    for zone in restricted.filter(|zone| winds_around(zone, place)) {
        note(found, format!("enters restricted area {} on the way to {name}", zone.name));
    }
    let mut permitted = problem.zones.iter().filter(|zone| zone.kind == ZoneKind::Permitted).peekable();
    if permitted.peek().is_some() && !permitted.filter(meets).any(|zone| winds_around(zone, place)) {
        note(found, format!("leaves the permitted area of operation on the way to {name}"));
    }
    if let Some(limit_m) = problem.landing_distance_m_max {
        let near = |position: Position| spherical_m(place, position) < (1.0 - SPHERE_TOLERANCE) * limit_m;
        if problem.landing_places.iter().any(|landing| near(landing.position)) {
            return;
        }
        let distances = problem.landing_places.iter().map(|landing| geodesy::distance_m(place, landing.position));
        let nearest_m = distances.fold(f64::INFINITY, f64::min);
        if nearest_m > limit_m + 1000.0 {
            note(found, format!("is {:.0} km from any landing place on the way to {name}", nearest_m / 1000.0));
        }
    }
}

/// Returns the distance on the mean sphere by half-angle sines: within [`SPHERE_TOLERANCE`] of the geodesic.
fn spherical_m(a: Position, b: Position) -> f64 {
    let half_sine = |from_deg: f64, to_deg: f64| libm::sin(0.5 * (to_deg - from_deg) * RAD_PER_DEG);
    let (north, east) = (half_sine(a.latitude_deg, b.latitude_deg), half_sine(a.longitude_deg, b.longitude_deg));
    let squeeze = libm::cos(a.latitude_deg * RAD_PER_DEG) * libm::cos(b.latitude_deg * RAD_PER_DEG);
    let squared = north * north + squeeze * east * east;
    2.0 * geodesy::EARTH_RADIUS_M_MEAN * libm::asin(libm::sqrt(squared).min(1.0))
}

/// Adds one message per violation, however many steps show it.
fn note(found: &mut Vec<String>, message: String) {
    if !found.contains(&message) {
        found.push(message);
    }
}

/// Returns true if the zone's outline winds around `place`. Sums the angles under which its edges are seen, on a flat map scaled at
/// `place`, unlike the planners, which count crossings.
fn winds_around(zone: &AirspaceZone, place: Position) -> bool {
    let scale = libm::cos(place.latitude_deg * RAD_PER_DEG);
    let seen = |corner: &Position| {
        let east = wrap_180(corner.longitude_deg - place.longitude_deg) * scale;
        libm::atan2(corner.latitude_deg - place.latitude_deg, east) / RAD_PER_DEG
    };
    let next = zone.corners.iter().skip(1).chain(zone.corners.first());
    let turns = zone.corners.iter().zip(next).map(|(from, to)| wrap_180(seen(to) - seen(from)));
    turns.sum::<f64>().abs() > 180.0
}

fn observe(
    problem: &SingleVisitProblem,
    target: &SingleVisitTarget,
    manoeuvre: &Manoeuvre,
    visit: &PlannedVisit,
    found: &mut Vec<String>,
) {
    let name = &target.name;
    if visit.begin_s < visit.arrive_s - 1e-6 {
        found.push(format!("begins to observe {name} before it arrives"));
    }
    if (visit.end_s - visit.begin_s - manoeuvre.duration_s).abs() > 1e-6 {
        found.push(format!(
            "observes {name} for {:.0} s instead of {:.0} s",
            visit.end_s - visit.begin_s,
            manoeuvre.duration_s
        ));
    }
    // A window includes both of its ends.
    let (mut windows, begin_s) = (target.windows.iter(), visit.begin_s);
    if !target.windows.is_empty() && !windows.any(|window| window.from_s <= begin_s && begin_s <= window.until_s) {
        found.push(format!("observes {name} outside its time windows"));
    }
    for time_s in [visit.begin_s, visit.end_s] {
        if !sun::is_light(target.light, target.position, problem.zero_unix_s + time_s) {
            note(found, format!("observes {name} in the wrong light"));
        }
    }
    let worth = target.value
        * manoeuvre.quality.coverage.factor
        * manoeuvre.quality.resolution.factor
        * manoeuvre.quality.clarity.factor
        * target.timing_at(visit.begin_s);
    if (worth - visit.worth).abs() > WORTH_TOLERANCE * worth.max(1.0) {
        found.push(format!("claims {} for {name}, which is worth {worth}", visit.worth));
    }
    let heights = (manoeuvre.altitude_m, manoeuvre.altitude_m);
    let lead_in = manoeuvre.entry.and_then(|entry| Some((entry, manoeuvre.lines.first()?.0)));
    // Every line is met in its direction, after the same straight flight as the first one.
    let lead_m = lead_in.map_or(0.0, |(entry, begin)| geodesy::distance_m(entry, begin));
    let before = |(begin, end): &(Position, Position)| {
        let back_deg = geodesy::azimuth_deg(*begin, *end) + 180.0;
        (geodesy::destination(*begin, geodesy::wrap_360(back_deg), lead_m), *begin)
    };
    let lead_ins: Vec<(Position, Position)> = manoeuvre.lines.iter().skip(1).map(before).collect();
    for (from, to) in lead_in.iter().chain(&manoeuvre.lines).chain(&lead_ins) {
        let steps = ((geodesy::distance_m(*from, *to) / STEP_M) as usize + 1).min(STEPS_MAX);
        for step in 0..=steps {
            let place = geodesy::interpolate(*from, *to, step as f64 / steps as f64);
            inside_rules(problem, place, heights, visit.begin_s, name, found);
        }
    }
}

/// Returns the points lost by targets that must be observed: those without a visit, and those whose visit has too small a factor.
fn missed(problem: &SingleVisitProblem, plan: &SingleVisitPlan) -> f64 {
    let mut points = 0.0;
    for target in &problem.targets {
        let Some(must) = target.must else { continue };
        let is_made = plan.visits.iter().filter(|visit| visit.target == target.name).any(|visit| {
            let quality = target.manoeuvres.get(visit.manoeuvre).map(|manoeuvre| &manoeuvre.quality);
            let factor = quality
                .map_or(0.0, |quality| quality.coverage.factor * quality.resolution.factor * quality.clarity.factor);
            factor * target.timing_at(visit.begin_s) > must.factor_min
        });
        if !is_made {
            points += must.cost;
        }
    }
    points
}

fn order(problem: &SingleVisitProblem, plan: &SingleVisitPlan, found: &mut Vec<String>) {
    let place = |name: &String| plan.visits.iter().position(|visit| visit.target == *name);
    for (earlier, later) in &problem.precedence {
        if place(later).is_some_and(|later| place(earlier).is_none_or(|earlier| earlier > later)) {
            found.push(format!("visits {later} without {earlier} before it"));
        }
    }
}

fn limits(problem: &SingleVisitProblem, plan: &SingleVisitPlan, found: &mut Vec<String>) {
    let vehicle = &problem.vehicle;
    let flight_s = plan.end_s - problem.start_s;
    let spare_s = vehicle.endurance_s - vehicle.endurance_reserve_s - flight_s;
    if spare_s.is_nan() || spare_s < -1e-6 {
        found.push(format!("uses {:.0} s of the endurance reserve", -spare_s));
    }
    let burnt_kg = vehicle.fuel_flow_kg_per_s * flight_s;
    if vehicle.fuel_flow_kg_per_s > 0.0 && vehicle.fuel_kg - burnt_kg < vehicle.fuel_reserve_kg - 1e-6 {
        found.push(format!("burns {burnt_kg:.0} kg and thereby uses fuel of the reserve"));
    }
    if (burnt_kg - plan.fuel_used_kg).abs() > 1e-3 {
        found.push(format!("claims to burn {:.1} kg, but burns {burnt_kg:.1} kg", plan.fuel_used_kg));
    }
    if problem.end_s.is_some_and(|end_s| plan.end_s > end_s + 1e-6) {
        found.push("ends after the mission must end".to_string());
    }
}

fn sums(problem: &SingleVisitProblem, plan: &SingleVisitPlan, benefits: f64, found: &mut Vec<String>) {
    let hours = (plan.end_s - problem.start_s) / 3600.0;
    let wages: f64 = problem.crew.iter().map(|m| m.wage_per_hour * (m.fixed_hours + m.flight_share * hours)).sum();
    let failure = &problem.failure;
    let loss = failure.vehicle_share * failure.vehicle_cost + failure.mission_share * failure.mission_cost;
    let costs = wages + loss * (1.0 - libm::exp(-failure.probability_per_hour * hours));
    let claims =
        [(plan.benefits, benefits, "benefits"), (plan.costs, costs, "costs"), (plan.score, benefits - costs, "score")];
    for (claimed, own, name) in claims {
        if (claimed - own).abs() > WORTH_TOLERANCE * own.abs().max(1.0) {
            found.push(format!("claims {name} of {claimed:.4}, but the true value is {own:.4}"));
        }
    }
    for target in &problem.targets {
        let visited = plan.visits.iter().any(|visit| visit.target == target.name);
        if visited == plan.left_out.iter().any(|left_out| left_out.target == target.name) {
            let what =
                if visited { "is visited, but listed as left out" } else { "is not visited and no reason is given" };
            found.push(format!("{} {what}", target.name));
        }
    }
}
