//! Limits of paths from the data of a mission: zones, ground, wind, turns and reach of landing places.

use crate::vehicle::Airframe;
use crate::vehicle::{VehicleModel, turn_radius_m};
use crate::{Mission, TargetKind};
use apex_geo::landing;
use apex_geo::plane::{self, Plane, Point};
use apex_geo::terrain::Terrain;
use apex_model::problem::{AirspaceZone, LandingPlace, Position, WindField, ZoneKind};
use apex_vehicle::Climb;
use std::borrow::Cow;
use std::sync::Arc;

/// A part of the ground with one elevation.
#[derive(Clone, Debug)]
pub(super) struct Patch {
    pub(super) position: Position,
    pub(super) radius_m: f64,
    pub(super) elevation_m: f64,
}

/// The requirements of a mission on the position of the vehicle, and the vehicle's flight performance.
#[derive(Clone, Debug)]
pub struct Limits {
    pub(super) zones: Vec<AirspaceZone>,
    /// Areas with a weak link. Paths avoid them if possible; a path through them violates no requirement.
    pub(super) weak: Vec<AirspaceZone>,
    /// Areas of storms, which are zones, too.
    storms: Vec<AirspaceZone>,
    pub(super) landing_places: Vec<LandingPlace>,
    pub(super) landing_distance_m_max: Option<f64>,
    pub(super) wind: WindField,
    pub(super) patches: Vec<Patch>,
    /// The terrain between these patches, if the mission has one.
    pub(super) terrain: Option<Arc<Terrain>>,
    /// Distance kept from zones.
    pub(super) margin_m: f64,
    /// Distance kept above and below zones.
    pub(super) above_zone_m: f64,
    /// Distance kept from the edge of a permitted area and from the end of the reach of landing places.
    pub(super) rim_m: f64,
    /// Height kept over ground away from both ends of a path.
    pub(super) ground_margin_m: f64,
    /// The part of it that every path keeps, with any share of the margins.
    ground_required_m: f64,
    pub(super) true_airspeed_mps: f64,
    /// Slowest indicated airspeed of a fixed wing; 0 for a rotorcraft.
    pub(super) indicated_airspeed_mps_min: f64,
    /// Radius of planned turns through the air; 0 for a vehicle that turns on the spot.
    pub(super) turn_radius_m: f64,
    /// Radius of circles as a multiple of `turn_radius_m`.
    pub(super) circle_width: f64,
    pub(super) climb_rate_mps: f64,
    /// The fastest climb.
    pub(super) climb: Climb,
    /// Length of the run before a fixed wing lifts off, and its slowest true airspeed, at the altitude of the start.
    pub(super) take_off: (f64, f64),
    pub(super) descent_rate_mps: f64,
    /// Fastest descent, which plans do not count on.
    pub(super) descent_rate_mps_max: f64,
    pub(super) altitude_m_max: f64,
    /// Straight flight before lines.
    pub(super) lead_in_s: f64,
    pub(super) final_approach_m: f64,
    pub(super) final_approach_height_m: f64,
    /// End of the mission.
    pub(super) end_s: f64,
    /// Named places with their elevation.
    places: Vec<(String, Position, f64)>,
}

/// Time of straight flight before a line, so that the wings are level at its beginning: a multiple of the time for rolling into a turn,
/// since the end of a turn leaves an error across the line. The minimum is that of autopilots, the maximum that of a large aircraft, s.
const LEAD_IN_ROLLS: f64 = 8.0;
const LEAD_IN_S: (f64, f64) = (16.0, 24.0);

/// Returns seconds of straight flight before a line of a scanner or a camera.
pub(crate) fn lead_in_s(model: &VehicleModel) -> f64 {
    (LEAD_IN_ROLLS * model.bank_deg_max / model.roll_rate_deg_s_max).clamp(LEAD_IN_S.0, LEAD_IN_S.1)
}

/// Name of the requirement to stay above the ground, in reports of its violation.
pub(super) const GROUND: &str = "ground";
/// Name of the requirement to stay inside of the permitted zones.
pub(super) const PERMITTED: &str = "permitted area";
/// Width of a turn, and its overshoot, as multiples of the radius over ground.
pub(super) const TURN_WIDTH: f64 = 3.0;
/// Height over ground that paths keep: fixed wing, rotorcraft. The first is 1,000 feet, the minimum height over open country
/// (ICAO Annex 2, 4.6), less for a slow aircraft; the second is the usual distance of small aircraft from obstacles.
const GROUND_MARGIN_M: (f64, f64) = (300.0, 30.0);
const GROUND_MARGIN_S: f64 = 3.3;
/// Distance kept above and below zones, and from the edge of permitted areas: that of a large aircraft, and times at cruise speed by which
/// slower ones keep less; never less than the buffers of requirement `airspace`.
const ABOVE_ZONE_M: f64 = 150.0;
const ABOVE_ZONE_S: f64 = 1.6;
const RIM_M: f64 = 500.0;
const RIM_S: f64 = 5.3;
/// Width of the ground that counts on either side of a leg: a multiple of the turn radius, with a minimum.
const GROUND_WIDTH_RADII: f64 = 1.0;
const GROUND_WIDTH_M_MIN: f64 = 50.0;
/// Time of a climb as a multiple of the shortest one.
const CLIMB_SPARE: f64 = 1.05;
/// Least space for climbs and descents around a landing place.
const FIELD_M: f64 = 200.0;
/// Steps along a final approach, and the ground that counts around each: at most, and as shares of a short approach.
const APPROACH_STEP_M: f64 = 1_500.0;
const APPROACH_STEP_SHARE: f64 = 0.15;
const APPROACH_WIDTH_M: f64 = 500.0;
const APPROACH_WIDTH_SHARE: f64 = 0.1;

/// Returns the height over ground that paths keep: the usual one or, with terrain, at least [`REQUIRED_SHARE`] of the requirement.
fn ground_margin_m(mission: &Mission, is_fixed_wing: bool) -> f64 {
    let slow_m = GROUND_MARGIN_S * mission.model.true_airspeed_m_s_cruise;
    let usual_m = if is_fixed_wing { GROUND_MARGIN_M.0.min(slow_m) } else { GROUND_MARGIN_M.1 };
    ground_required_m(mission).map_or(usual_m, |required_m| usual_m.max(REQUIRED_SHARE * required_m))
}

/// Returns the height that the mission requires over known terrain.
fn ground_required_m(mission: &Mission) -> Option<f64> {
    mission.requirements.terrain_clearance_m.filter(|_| mission.terrain.is_some())
}

/// Multiple of the required clearance that paths keep, because vehicles hold altitudes only within some metres.
const REQUIRED_SHARE: f64 = 1.1;
/// Extent of the known elevation around a target or an airfield.
const PATCH_M: f64 = 10_000.0;

impl Limits {
    /// Returns the limits of a mission.
    pub fn of(mission: &Mission) -> Limits {
        let model = &mission.model;
        let is_fixed_wing = model.airframe == Airframe::FixedWing;
        let patch =
            |position, radius_m: f64, elevation_m| Patch { position, radius_m: radius_m + PATCH_M, elevation_m };
        let targets = mission.targets.iter().map(|target| {
            let radius_m = if let TargetKind::Fire(fire) = &target.kind { fire.radius_m } else { 0.0 };
            patch(target.position, radius_m, target.elevation_m)
        });
        let airfields = mission.airfields.iter().map(|field| patch(field.position, 0.0, field.elevation_m));
        let of_targets = mission.targets.iter().map(|target| (target.id.clone(), target.position, target.elevation_m));
        let of_fields = mission.airfields.iter().map(|field| (field.id.clone(), field.position, field.elevation_m));
        let buffer = mission.requirements.airspace;
        let cruise_mps = model.true_airspeed_m_s_cruise;
        let above_zone_m = ABOVE_ZONE_M.min(ABOVE_ZONE_S * cruise_mps);
        let rim_m = RIM_M.min(RIM_S * cruise_mps);
        let single_visits = mission.targets.iter().any(|target| matches!(target.kind, TargetKind::Fire(_)));
        Limits {
            zones: mission.zones.clone(),
            weak: Vec::new(),
            storms: Vec::new(),
            landing_places: mission.landing_places(),
            landing_distance_m_max: mission.requirements.landing_distance_m_max(),
            wind: mission.forecast.clone(),
            patches: targets.chain(airfields).collect(),
            terrain: mission.terrain.clone(),
            margin_m: match single_visits {
                true => mission.requirements.zone_margin_m,
                false => mission.requirements.obstacle_margin_m,
            },
            above_zone_m: buffer.map_or(above_zone_m, |buffer| above_zone_m.max(buffer.vertical_m)),
            rim_m: buffer.map_or(rim_m, |buffer| rim_m.max(buffer.horizontal_m)),
            ground_margin_m: ground_margin_m(mission, is_fixed_wing),
            ground_required_m: ground_required_m(mission).unwrap_or_else(|| ground_margin_m(mission, is_fixed_wing)),
            true_airspeed_mps: model.true_airspeed_m_s_cruise,
            indicated_airspeed_mps_min: if is_fixed_wing { model.indicated_airspeed_m_s_min } else { 0.0 },
            turn_radius_m: turn_radius_m(model),
            circle_width: model.turns.circle_width,
            climb_rate_mps: model.climb_rate_m_s_max * model.planning.climb_share,
            climb: model.climb(),
            take_off: (
                model.take_off_run_m(mission.start_altitude_m),
                model.true_airspeed_m_s_min(mission.start_altitude_m),
            ),
            descent_rate_mps: model.descent_rate_m_s_max * model.planning.descent_share,
            descent_rate_mps_max: model.descent_rate_m_s_max,
            altitude_m_max: model.ceiling_m * model.planning.ceiling_share,
            lead_in_s: lead_in_s(model),
            final_approach_m: model.final_approach_m,
            final_approach_height_m: model.final_approach_height_m,
            end_s: mission.settings.duration.seconds(),
            places: of_fields.chain(of_targets).collect(),
        }
    }

    /// Returns true if the mission limits paths neither by zones nor by landing places nor by terrain.
    pub(super) fn are_none(&self) -> bool {
        self.zones.is_empty() && self.landing_distance_m_max.is_none() && self.terrain.is_none()
    }

    /// Returns true if a link is weak somewhere.
    pub(super) fn has_weak(&self) -> bool {
        !self.weak.is_empty()
    }

    /// Returns the limits in another wind.
    pub(super) fn in_wind(&self, wind: WindField) -> Limits {
        Limits { wind, ..self.clone() }
    }

    /// Returns the limits with the areas of weak links and storms that a flight has measured.
    pub(super) fn with_areas(&self, weak: Vec<AirspaceZone>, storms: Vec<AirspaceZone>) -> Cow<'_, Limits> {
        if weak.is_empty() && storms.is_empty() {
            return Cow::Borrowed(self);
        }
        let zones = self.zones.iter().chain(&storms).cloned().collect();
        Cow::Owned(Limits { zones, weak, storms, ..self.clone() })
    }

    /// Returns true if a place is in the present area of a storm.
    pub(super) fn is_under_storm(&self, place: Position) -> bool {
        let first_s = self.storms.iter().map(|storm| storm.active.from_s).fold(f64::INFINITY, f64::min);
        let mut present = self.storms.iter().filter(|storm| storm.active.from_s <= first_s);
        present.any(|storm| distance_m(storm, place) <= 0.0)
    }

    /// Returns the limits with weak areas as zones, except for areas near the ends of a path; `None` if no area remains.
    pub(super) fn around_weak(&self, ends: [Position; 2]) -> Option<Limits> {
        let near_m = self.margin_m + TURN_WIDTH * self.turn_radius_m_over_ground();
        let is_clear = |zone: &&AirspaceZone| ends.iter().all(|end| distance_m(zone, *end) > near_m);
        let weak: Vec<AirspaceZone> = self.weak.iter().filter(is_clear).cloned().collect();
        if weak.is_empty() {
            return None;
        }
        let zones = self.zones.iter().cloned().chain(weak).collect();
        Some(Limits { zones, weak: Vec::new(), ..self.clone() })
    }

    /// Returns the position of a named place, with its elevation.
    pub(super) fn place(&self, name: &str) -> Option<(Position, f64)> {
        let place = self.places.iter().find(|(known, ..)| known == name);
        place.map(|(_, position, elevation_m)| (*position, *elevation_m))
    }

    /// Returns the elevation of the ground at a position, as far as it is known.
    pub(super) fn elevation_m_at(&self, position: Position) -> f64 {
        if let Some(elevation_m) = self.terrain.as_ref().and_then(|terrain| terrain.elevation_m_at(position)) {
            return elevation_m;
        }
        let near = self.patches.iter().map(|patch| (apex_geo::geodesy::distance_m(position, patch.position), patch));
        let near = near.filter(|(distance_m, patch)| *distance_m <= patch.radius_m);
        near.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(0.0, |(_, patch)| patch.elevation_m)
    }

    /// Returns the strongest wind of the forecast.
    pub(super) fn wind_mps_max(&self) -> f64 {
        apex_geo::wind::speed_mps_max(&self.wind)
    }

    /// Returns the radius over ground of a turn in the strongest wind: at the airspeed and the wind together.
    pub(super) fn turn_radius_m_over_ground(&self) -> f64 {
        let share = 1.0 + self.wind_mps_max() / self.true_airspeed_mps;
        self.turn_radius_m * share * share
    }

    /// Returns the radius of the circles that the vehicle flies where it holds.
    pub(super) fn circle_radius_m(&self) -> f64 {
        self.circle_width * self.turn_radius_m_over_ground()
    }

    /// Returns the time of a climb or a descent: as long as plans count it, and as the vehicle needs, whose climb rate falls with the
    /// altitude.
    pub(super) fn change_s(&self, from_m: f64, to_m: f64) -> f64 {
        self.planned_change_s(from_m, to_m).max(CLIMB_SPARE * self.climb.time_s(from_m, to_m))
    }

    /// Returns the time that plans count for a climb or a descent.
    pub(super) fn planned_change_s(&self, from_m: f64, to_m: f64) -> f64 {
        ((to_m - from_m) / self.climb_rate_mps).max((from_m - to_m) / self.descent_rate_mps)
    }

    /// Returns the shortest time of a climb or a descent.
    pub(super) fn fastest_change_s(&self, from_m: f64, to_m: f64) -> f64 {
        self.climb.time_s(from_m, to_m).max((from_m - to_m) / self.descent_rate_mps_max)
    }

    /// Returns true if the vehicle must stay inside a zone.
    pub(super) fn must_stay(&self) -> bool {
        self.zones.iter().any(|zone| zone.kind == ZoneKind::Permitted)
    }

    /// Returns the lowest permitted altitude over the ground under the legs between `places`, except for the ground around both ends,
    /// with this share of the margins.
    pub(super) fn lowest_altitude_m(&self, places: &[Position], ends: (Position, Position), margins: f64) -> f64 {
        let distance_m = apex_geo::geodesy::distance_m;
        let counts = |patch: &&Patch| {
            let is_at = |end: Position| distance_m(patch.position, end) <= patch.radius_m;
            let near_a_leg = |pair: (&Position, &Position)| leg_is_near(*pair.0, *pair.1, patch);
            !is_at(ends.0) && !is_at(ends.1) && places.iter().zip(places.iter().skip(1)).any(near_a_leg)
        };
        let highest_m = match &self.terrain {
            Some(terrain) => self.highest_ground_m(terrain, places),
            None => {
                let elevations = self.patches.iter().filter(counts).map(|patch| patch.elevation_m);
                elevations.fold(f64::NEG_INFINITY, f64::max)
            }
        };
        highest_m + self.kept_m(margins)
    }

    /// Returns the height over ground that paths keep with this share of the margins.
    pub(super) fn kept_m(&self, margins: f64) -> f64 {
        self.ground_required_m + margins * (self.ground_margin_m - self.ground_required_m)
    }

    /// Returns the altitude below which a path must not descend from `from_altitude_m` over the terrain around the landing place at which
    /// it begins. That ground does not count for [`Limits::lowest_altitude_m`], because the vehicle may still climb there. A path that
    /// ends at a landing place descends there.
    pub(super) fn lowest_descent_m(&self, places: &[Position], from_altitude_m: f64, margins: f64) -> f64 {
        let room_m = |end: Option<&Position>| end.map_or(0.0, |end| self.field_room_m(*end));
        let (first_m, last_m) = (room_m(places.first()), room_m(places.last()));
        let counts = first_m > 0.0 && last_m <= 0.0;
        let Some(terrain) = self.terrain.as_ref().filter(|_| counts) else { return f64::NEG_INFINITY };
        let rest_m = (length_m(places) - first_m).max(0.0);
        from_altitude_m.min(self.highest_m_between(terrain, places, (0.0, rest_m)) + self.kept_m(margins))
    }

    /// Returns the highest ground under the legs and the turns at their ends. Ground around the landing places at which the path begins or
    /// ends does not count, because the vehicle climbs or descends there.
    fn highest_ground_m(&self, terrain: &Terrain, places: &[Position]) -> f64 {
        let skip_m = |end: Option<&Position>| end.map_or(0.0, |end| self.field_room_m(*end));
        self.highest_m_between(terrain, places, (skip_m(places.first()), skip_m(places.last())))
    }

    /// Returns the highest ground under the legs and the turns at their ends, without so many metres at the beginning and at the end.
    fn highest_m_between(&self, terrain: &Terrain, places: &[Position], (first_m, last_m): (f64, f64)) -> f64 {
        let half_width_m = GROUND_WIDTH_M_MIN.max(GROUND_WIDTH_RADII * self.turn_radius_m_over_ground());
        let legs = places.iter().zip(places.iter().skip(1));
        let lengths_m: Vec<f64> = legs.clone().map(|(from, to)| apex_geo::geodesy::distance_m(*from, *to)).collect();
        let whole_m: f64 = lengths_m.iter().sum();
        let (mut before_m, mut highest_m) = (0.0, f64::NEG_INFINITY);
        for ((from, to), length_m) in legs.zip(&lengths_m) {
            let after_m = whole_m - before_m - length_m;
            let skip_m = ((first_m - before_m).max(0.0), (last_m - after_m).max(0.0));
            if let Some(found_m) = terrain.highest_m_along(*from, *to, half_width_m, skip_m) {
                highest_m = highest_m.max(found_m);
            }
            before_m += length_m;
        }
        highest_m
    }

    /// Returns the radius for climbs and descents around the landing place at which a path begins or ends; 0 elsewhere, and for a vehicle
    /// that climbs and descends on the spot.
    fn field_room_m(&self, end: Position) -> f64 {
        if self.turn_radius_m <= 0.0 {
            return 0.0;
        }
        let room_m = FIELD_M.max(self.final_approach_m + 2.0 * self.circle_radius_m());
        let is_field = |place: &LandingPlace| apex_geo::geodesy::distance_m(place.position, end) <= room_m;
        if self.landing_places.iter().any(is_field) { room_m } else { 0.0 }
    }

    /// Returns true if the glide path from `begin` to a landing place is clear of the ground below the final approach.
    pub(super) fn approach_is_clear(&self, begin: Position, field: Position, field_m: f64) -> bool {
        let Some(terrain) = &self.terrain else { return true };
        let (length_m, azimuth_deg) = apex_geo::geodesy::inverse(field, begin);
        let step_m = APPROACH_STEP_M.min(APPROACH_STEP_SHARE * length_m);
        let width_m = APPROACH_WIDTH_M.min(APPROACH_WIDTH_SHARE * length_m);
        let count = libm::ceil(length_m / step_m) as u32;
        (1..=count).map(|number| f64::from(number) * step_m).all(|out_m| {
            let there = apex_geo::geodesy::destination(field, azimuth_deg, out_m.min(length_m));
            let path_m = field_m + self.final_approach_height_m * (out_m / self.final_approach_m).min(1.0);
            let ground_m = terrain.highest_m_near(there, width_m);
            // The smaller of half the glide path's height and the height that paths keep.
            let kept_m = self.ground_margin_m.min(0.5 * (path_m - field_m));
            ground_m.is_none_or(|ground_m| path_m - ground_m >= kept_m)
        })
    }

    /// Returns true if a leg is at least `slack_m` within reach of the landing places.
    pub(super) fn leg_is_within_reach(&self, from: Position, to: Position, slack_m: f64) -> bool {
        let Some(limit_m) = self.landing_distance_m_max else { return true };
        landing::leg_is_within(&self.landing_places, from, to, limit_m - slack_m)
    }
}

/// Returns the distance of a place from the outline of a zone; 0 inside.
fn distance_m(zone: &AirspaceZone, place: Position) -> f64 {
    let plane = Plane::new(place);
    let corners: Vec<Point> = zone.corners.iter().filter_map(|corner| plane.project(*corner)).collect();
    let here = Point::default();
    if plane::inside(here, &corners) { 0.0 } else { plane::segment_to_edges(here, here, &corners) }
}

fn length_m(places: &[Position]) -> f64 {
    places.iter().zip(places.iter().skip(1)).map(|(from, to)| apex_geo::geodesy::distance_m(*from, *to)).sum()
}

fn leg_is_near(from: Position, to: Position, patch: &Patch) -> bool {
    let plane = Plane::new(patch.position);
    let ends = plane.project(from).zip(plane.project(to));
    ends.is_some_and(|(a, b)| plane::point_to_segment(Default::default(), a, b) <= patch.radius_m)
}
