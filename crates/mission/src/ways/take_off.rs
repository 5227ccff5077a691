//! The climb after the take-off of a fixed wing, compared with known terrain: straight ahead to 300 m, then on a circle.

use super::circles::{CLIMB_SPEED, STRAIGHT_CLIMB_M};
use super::{Limits, Request};
use crate::Mission;
use crate::error::{MissionError, MissionResult};
use apex_geo::geodesy;
use apex_geo::terrain::Terrain;
use apex_model::expression::Template;
use apex_model::library::Library;
use apex_model::problem::Position;
use apex_model::procedure::Activity;
use apex_model::quantity::Dimension;
use apex_model::source::Place;

/// Height that a climb gains over obstacles for each metre of its length: ICAO Doc 8168 (PANS-OPS), volume II, part I, section 3.
const CLEARANCE_PER_M: f64 = 0.008;
/// Level ground beyond the end of the run.
const LEVEL_M: f64 = 300.0;
/// Time from the end of the run to a steady climb.
const ROTATION_S: f64 = 2.0;
/// Half of the width of the ground that counts below the climb.
const HALF_WIDTH_M: f64 = 50.0;
/// Interval between compared places of the straight climb, and the longest one.
const STEP_S: f64 = 1.0;
const STEPS_MAX: u32 = 1_200;
/// Width of the circle, as a multiple of its radius, because joining it swings out; compared places on it.
const CIRCLE_WIDTH: f64 = 1.4;
const RINGS: u32 = 12;
const DIRECTIONS: u32 = 24;
/// Directions that are tried to name one that is clear.
const HEADINGS: u32 = 36;

/// A place at which a climb would meet the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Obstacle {
    /// Distance from the start.
    distance_m: f64,
    /// Elevation of the ground.
    ground_m: f64,
    /// Altitude of the vehicle there.
    altitude_m: f64,
}

impl Limits {
    /// Returns why a fixed wing must not take off as requested: the climb towards `from_track_rad` meets known terrain. `None` if it is
    /// clear, or no terrain is known.
    pub(super) fn closed_take_off(&self, request: &Request) -> Option<String> {
        let terrain = self.terrain.as_ref().filter(|_| self.turn_radius_m > 0.0)?;
        let heading_rad = request.from_track_rad?;
        let obstacle = self.obstacle(terrain, request, heading_rad)?;
        let degrees = |number: u32| 360.0 / f64::from(HEADINGS) * f64::from(number);
        let clear: Vec<f64> = (0..HEADINGS)
            .map(degrees)
            .filter(|heading_deg| self.obstacle(terrain, request, heading_deg.to_radians()).is_none())
            .collect();
        let heading_deg = heading_rad.to_degrees().rem_euclid(360.0);
        let apart_deg = |other: &f64| geodesy::wrap_180(*other - heading_deg).abs();
        let nearest = clear.into_iter().min_by(|a, b| apart_deg(a).total_cmp(&apart_deg(b)));
        let help = match nearest {
            Some(clear_deg) => format!(
                "a take-off towards {clear_deg:.0} degrees is clear: `:heading {clear_deg:.0}deg` in `:vehicle`"
            ),
            None => "no direction is clear of the ground: choose another place, or a lower altitude".to_string(),
        };
        Some(format!(
            "the climb after a take-off towards {heading_deg:.0} degrees meets the ground {:.1} km from the start, which rises to {:.0} m \
             there; the vehicle would be at {:.0} m; {help}",
            obstacle.distance_m / 1_000.0,
            obstacle.ground_m,
            obstacle.altitude_m
        ))
    }

    /// Returns the first place at which the climb towards `heading_rad` comes closer to the ground than it may.
    fn obstacle(&self, terrain: &Terrain, request: &Request, heading_rad: f64) -> Option<Obstacle> {
        let at = |from: Position, azimuth_deg: f64, metres: f64| geodesy::destination(from, azimuth_deg, metres);
        let heading_deg = heading_rad.to_degrees();
        let (run_m, slowest_mps) = self.take_off;
        let speed_mps = CLIMB_SPEED * slowest_mps + self.tailwind_mps(request, heading_rad);
        let (mut distance_m, mut altitude_m) = (run_m + ROTATION_S * speed_mps, request.from_altitude_m);
        let level_m = distance_m + LEVEL_M;
        let closed = |(from_start_m, altitude_m): (f64, f64), ground_m: Option<f64>| {
            let ground_m = ground_m.filter(|_| from_start_m > level_m)?;
            let is_clear = altitude_m >= ground_m + CLEARANCE_PER_M * from_start_m;
            (!is_clear).then_some(Obstacle { distance_m: from_start_m, ground_m, altitude_m })
        };
        for _ in 0..STEPS_MAX {
            let there = at(request.from, heading_deg, distance_m);
            let beside = [-90.0, 90.0].map(|turn_deg| at(there, heading_deg + turn_deg, HALF_WIDTH_M));
            let below_m = [there, beside[0], beside[1]].into_iter().filter_map(|place| terrain.elevation_m_at(place));
            if let Some(obstacle) = closed((distance_m, altitude_m), below_m.max_by(f64::total_cmp)) {
                return Some(obstacle);
            }
            let ground_m = terrain.elevation_m_at(there).unwrap_or(request.from_altitude_m);
            if altitude_m >= request.to_altitude_m || altitude_m >= ground_m + STRAIGHT_CLIMB_M {
                break;
            }
            altitude_m = (altitude_m + STEP_S * self.climb.rate_m_s(altitude_m)).min(request.to_altitude_m);
            distance_m += STEP_S * speed_mps;
        }
        if altitude_m >= request.to_altitude_m {
            return None;
        }
        // On the circle the vehicle is at each place at the earliest when it could have flown straight to it.
        let middle = at(request.from, heading_deg, distance_m);
        let outer_m = CIRCLE_WIDTH * self.circle_radius_m();
        (1..=RINGS).map(|ring| f64::from(ring) / f64::from(RINGS) * outer_m).find_map(|out_m| {
            let climbed_m = out_m / self.true_airspeed_mps * self.climb.rate_m_s(altitude_m);
            let there_m = (altitude_m + climbed_m).min(request.to_altitude_m);
            let width_m = outer_m / f64::from(RINGS);
            (0..DIRECTIONS).find_map(|direction| {
                let there = at(middle, 360.0 / f64::from(DIRECTIONS) * f64::from(direction), out_m);
                let ground_m = terrain.highest_m_near(there, width_m);
                closed((geodesy::distance_m(request.from, there), there_m), ground_m)
            })
        })
    }

    /// Returns the place at which the straight climb after a take-off ends, 300 m higher or at the altitude of the climb.
    pub(super) fn end_of_straight_climb(&self, request: &Request) -> Request {
        let (run_m, slowest_mps) = self.take_off;
        let climb_m = (request.to_altitude_m - request.from_altitude_m).clamp(0.0, STRAIGHT_CLIMB_M);
        let climb_s = ROTATION_S + self.climb.time_s(request.from_altitude_m, request.from_altitude_m + climb_m);
        let heading_rad = request.from_track_rad.unwrap_or_default();
        let straight_m = run_m + climb_s * (CLIMB_SPEED * slowest_mps + self.tailwind_mps(request, heading_rad));
        let to = geodesy::destination(request.from, heading_rad.to_degrees(), straight_m);
        Request { to, to_altitude_m: request.from_altitude_m + climb_m, ..*request }
    }

    fn tailwind_mps(&self, request: &Request, heading_rad: f64) -> f64 {
        let wind = apex_geo::wind::at(&self.wind, request.from, request.from_altitude_m, request.at_s);
        (wind.east_mps * libm::sin(heading_rad) + wind.north_mps * libm::cos(heading_rad)).max(0.0)
    }
}

/// Checks the take-offs of a mission's program that state their altitude, for a vehicle at the start.
///
/// # Errors
/// An altitude not above the start or above the ceiling, a climb that meets the ground, and a circle of the climb for which the airspace leaves no space; with the place of the goal.
pub fn check_take_offs(mission: &Mission) -> MissionResult {
    let limits = Limits::of(mission);
    let (start_m, ceiling_m) = (mission.start_altitude_m, mission.model.ceiling_m);
    for (altitude_m, place) in stated_take_offs(&mission.library) {
        if altitude_m <= start_m || altitude_m > ceiling_m {
            return Err(MissionError::setting(format!("the take-off to {altitude_m:.0} m is not possible"))
                .at(mission.library.describe_place(place))
                .because(format!(
                    "the start is at {start_m:.0} m, and the ceiling of `{}` is {ceiling_m:.0} m",
                    mission.model.name
                ))
                .help("write an altitude between both, above mean sea level, such as 3000m"));
        }
    }
    if limits.are_none() {
        return Ok(());
    }
    for (altitude_m, place) in stated_take_offs(&mission.library) {
        let request = Request {
            from: mission.start,
            from_altitude_m: mission.start_altitude_m,
            from_track_rad: Some(mission.settings.start_heading_deg.to_radians()),
            at_s: 0.0,
            to: mission.start,
            to_altitude_m: altitude_m,
            to_track_rad: None,
            circle_radius_m: 0.0,
            stay_s: 0.0,
        };
        let circle =
            || limits.climb_circle(&request).err().map(|broken| format!("{}: {}", broken.names.join("; "), broken.why));
        if let Some(reason) = limits.closed_take_off(&request).or_else(circle) {
            return Err(MissionError::setting(format!("the take-off to {altitude_m:.0} m breaks a requirement"))
                .at(mission.library.describe_place(place))
                .because(reason)
                .help("`:heading` in `:vehicle` is the direction of the take-off (docs/reference/mission-data.md)"));
        }
    }
    Ok(())
}

/// Returns the altitudes of all goals `(take off to ALTITUDE)` with a number for ALTITUDE, and their places.
fn stated_take_offs(library: &Library) -> Vec<(f64, Place)> {
    let goals = library.procedures.iter().flat_map(|procedure| &procedure.steps).filter_map(|step| {
        let Activity::Goal(Template::Constant(goal)) = &step.activity else { return None };
        let [take, off, to, altitude] = goal.as_list()? else { return None };
        let is_named = [(take, "take"), (off, "off"), (to, "to")];
        let is_named = is_named.iter().all(|(word, name)| word.as_symbol().is_some_and(|symbol| symbol.is(name)));
        let (altitude_m, unit) = altitude.as_number()?;
        (is_named && matches!(unit, Dimension::LENGTH | Dimension::NONE)).then_some((altitude_m, step.place))
    });
    goals.collect()
}
