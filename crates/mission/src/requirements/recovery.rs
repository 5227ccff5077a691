//! Ways out: the destination of a response.

use super::readings::{Reading, Scene};
use super::response::Response;
use super::statement::LandingReach;
use apex_geo::geodesy::{self, Position};
use apex_geo::plane::Point;
use apex_geo::wind;
use apex_model::planned::Location;
use apex_requirements::margin::landing::disc_m;
use apex_requirements::margin::zone::{KeepIn, LocalZone, ZoneBuffer};
use apex_requirements::prediction::RouteSpan;
use apex_requirements::{Concern, Route, first_violation};
use std::f64::consts::TAU;

/// Number of compared directions of a turn away.
const DIRECTIONS: u32 = 24;
/// Length of a turn away in turn radii, and its least length.
const AWAY_RADII: f64 = 3.0;
const AWAY_M_MIN: f64 = 300.0;
/// Step and number of the altitudes, upwards and downwards, that are compared to leave the weather.
const LAYER_M: f64 = 500.0;
const LAYERS: i32 = 10;
/// Clearance that a climb aims at, as a multiple of the required one.
const CLEARANCE_SHARE: f64 = 1.5;
/// Additional distance in metres of a level beyond a zone's face, for the altitude error of the vehicle.
const LEVEL_M: f64 = 10.0;

impl Scene<'_> {
    /// Returns the response to a reading, with its way out. If `is_escalated`, earlier responses did not help, and the response is a
    /// landing at the nearest landing site.
    pub(super) fn recovery(&self, reading: &Reading, is_escalated: bool) -> (Response, Location) {
        let site = match reading.concern {
            Concern::Energy => self.site_for_energy(),
            Concern::MissionEnd => self.site_for_mission_end(reading),
            Concern::LandingDistance if !is_escalated => self.nearest_site(self.here).0,
            _ => self.nearest_open_site(is_escalated),
        };
        let to_site = Location { position: site.position, altitude_m: site.elevation_m };
        let may_land = !matches!(reading.concern, Concern::Terrain | Concern::Sensor);
        if is_escalated && may_land && reading.response != Response::LandHere {
            return (Response::LandAt, to_site);
        }
        let here = Location { position: self.here, altitude_m: self.flown.altitude_m };
        match (reading.concern, reading.response) {
            (_, Response::LandHere) => {
                let ground_m = self.flown.altitude_m - self.flown.height_above_ground_m.unwrap_or(0.0);
                (Response::LandHere, Location { altitude_m: ground_m, ..here })
            }
            (Concern::Energy, _) => (Response::LandAt, to_site),
            (Concern::MissionEnd, response) => (response, to_site),
            (Concern::Terrain, wanted) => {
                let clearance_m = self.requirements().terrain_clearance_m.unwrap_or(0.0);
                let altitude_m = (self.ground_ahead_m() + CLEARANCE_SHARE * clearance_m).max(self.flown.altitude_m);
                let altitude_m = altitude_m.min(self.mission.model.ceiling_m);
                match wanted {
                    Response::TurnAway => (wanted, Location { altitude_m, ..self.turn_away().0 }),
                    _ => (Response::Climb, Location { altitude_m, ..here }),
                }
            }
            (Concern::LandingDistance, _) => (Response::TurnAway, self.towards(site.position)),
            (Concern::Weather, _) => self.calmer_layer(reading).unwrap_or((Response::LandAt, to_site)),
            (Concern::Airspace, _) => self.leave_airspace(reading),
            (Concern::Sensor, response) => (response, here),
            (Concern::Link, _) => {
                (Response::TurnAway, self.good_link_place(reading).unwrap_or_else(|| self.turn_away().0))
            }
        }
    }

    fn away_m(&self) -> f64 {
        (AWAY_RADII * self.motion.turn_radius_m).max(AWAY_M_MIN)
    }

    fn towards(&self, place: Position) -> Location {
        let (distance_m, azimuth_deg) = geodesy::inverse(self.here, place);
        let limit_m = match self.requirements().landing {
            Some(LandingReach::Disc { distance_m_max }) => 0.1 * distance_m_max,
            _ => 0.0,
        };
        let position = geodesy::destination(self.here, azimuth_deg, self.away_m().max(limit_m).min(distance_m));
        Location { position, altitude_m: self.flown.altitude_m }
    }

    /// Returns another altitude if a climb or a descent causes the violation; otherwise a turn to a place that keeps the requirement;
    /// otherwise the nearest altitude that keeps it, because a face of a zone that covers all surroundings cannot be left sideways.
    fn leave_airspace(&self, reading: &Reading) -> (Response, Location) {
        let to_level = |altitude_m: f64| {
            let response = if altitude_m > self.flown.altitude_m { Response::Climb } else { Response::Descend };
            (response, Location { position: self.here, altitude_m })
        };
        if let Some(altitude_m) = self.level_on_the_way(reading) {
            return to_level(altitude_m);
        }
        let (place, end_m) = self.turn_away();
        let level = if end_m < 0.0 { self.permitted_level(Point::default(), self.flown.altitude_m) } else { None };
        level.map_or((Response::TurnAway, place), to_level)
    }

    /// Returns the nearest permitted altitude if the route violates the requirement by its altitude alone.
    fn level_on_the_way(&self, reading: &Reading) -> Option<f64> {
        let state = self.route.at(reading.after_s?.min(self.route.end_s()))?;
        let is_level = (state.altitude_m - self.flown.altitude_m).abs() < LEVEL_M;
        let (zones, _) = self.near_zones();
        let area = KeepIn::new(&zones, self.flown.altitude_m, self.now_s);
        let here = (self.flown.altitude_m, self.now_s + state.after_s);
        let kept_m = self.zone_margin_m(state.point, here, &zones, area.as_ref(), &self.zone_buffer());
        if is_level || kept_m < 0.0 { None } else { self.permitted_level(state.point, state.altitude_m) }
    }

    fn zone_buffer(&self) -> ZoneBuffer {
        self.requirements().airspace.unwrap_or(ZoneBuffer { horizontal_m: 0.0, vertical_m: 0.0, time_s: 0.0 })
    }

    /// Returns the altitude nearest to `wished_m`, beyond a face of a zone, at which the vehicle may be at `point`.
    fn permitted_level(&self, point: Point, wished_m: f64) -> Option<f64> {
        let buffer = self.zone_buffer();
        let (zones, _) = self.near_zones();
        let model = &self.mission.model;
        let ground_m = self.flown.altitude_m - self.flown.height_above_ground_m.unwrap_or(0.0);
        let lowest_m = ground_m + CLEARANCE_SHARE * self.requirements().terrain_clearance_m.unwrap_or(0.0);
        let off_m = buffer.vertical_m + LEVEL_M;
        let faces = zones.iter().flat_map(|zone| [zone.altitude_m().0, zone.altitude_m().1]);
        let levels = faces.flat_map(|face_m| [face_m - off_m, face_m + off_m]);
        let is_kept = |altitude_m: &f64| {
            let area = KeepIn::new(&zones, *altitude_m, self.now_s);
            self.zone_margin_m(point, (*altitude_m, self.now_s), &zones, area.as_ref(), &buffer) >= 0.0
        };
        let distance_m = |altitude_m: &f64| (altitude_m - wished_m).abs();
        levels
            .filter(|altitude_m| (lowest_m..=model.ceiling_m).contains(altitude_m))
            .filter(is_kept)
            .min_by(|a, b| distance_m(a).total_cmp(&distance_m(b)))
    }

    /// Returns the least margin of all zones at a point, an altitude and an instant.
    fn zone_margin_m(
        &self,
        point: Point,
        (altitude_m, at_s): (f64, f64),
        zones: &[LocalZone],
        area: Option<&KeepIn>,
        buffer: &ZoneBuffer,
    ) -> f64 {
        let out = zones.iter().filter(|zone| zone.is_restricted() && zone.is_active(at_s));
        let out_m = out.map(|zone| zone.keep_out_m(point, altitude_m, buffer)).fold(f64::INFINITY, f64::min);
        out_m.min(area.map_or(f64::INFINITY, |area| area.keep_in_m(point, altitude_m, buffer)))
    }

    /// Returns the place around the vehicle whose path has the greatest margin, among equals the one nearest to the present course, and
    /// that margin.
    fn turn_away(&self) -> (Location, f64) {
        let buffer = self.zone_buffer();
        let (zones, _) = self.near_zones();
        let area = KeepIn::new(&zones, self.flown.altitude_m, self.now_s);
        let course_rad = self.flown.track_deg().to_radians();
        let away_m = self.away_m();
        let mut best: Option<(f64, Point)> = None;
        for number in 0..DIRECTIONS {
            // 0, 15, -15, 30, -30 degrees ..: away from the present course a step at a time.
            let side = if number % 2 == 0 { 1.0 } else { -1.0 };
            let angle_rad = course_rad + side * f64::from(number.div_ceil(2)) * TAU / f64::from(DIRECTIONS);
            let to = Point { x: away_m * libm::sin(angle_rad), y: away_m * libm::cos(angle_rad) };
            let worst_m = self.worst_m(to, &zones, area.as_ref(), &buffer);
            if best.is_none_or(|(found_m, _)| worst_m > found_m + 1.0) {
                best = Some((worst_m, to));
            }
        }
        let to = best.map_or(Point::default(), |(_, to)| to);
        let altitude_m = self.flown.altitude_m;
        let end_m = self.zone_margin_m(to, (altitude_m, self.now_s), &zones, area.as_ref(), &buffer);
        (Location { position: self.plane.position(to), altitude_m }, end_m)
    }

    /// Returns the least margin on the path to a place, at most the distance to it: a greater margin has no advantage.
    fn worst_m(&self, to: Point, zones: &[LocalZone], area: Option<&KeepIn>, buffer: &ZoneBuffer) -> f64 {
        let track_rad = self.flown.track_deg().to_radians();
        let track = Point { x: libm::sin(track_rad), y: libm::cos(track_rad) };
        let altitude_m = self.flown.altitude_m;
        let route = Route::begin(Point::default(), track, (altitude_m, altitude_m), self.motion).fly_to(to);
        let reach = self.requirements().landing_distance_m_max();
        let clearance_m = self.requirements().terrain_clearance_m.unwrap_or(0.0);
        // A climb on the path counts, because the obstacle may be the ground.
        let over_ground_m = |point: Point, after_s: f64| {
            let ground_m = self.known_ground_m(self.plane.position(point)).unwrap_or(f64::NEG_INFINITY);
            altitude_m + self.motion.climb_mps * after_s - ground_m - clearance_m
        };
        let margin = |point: Point, at_s: f64| self.zone_margin_m(point, (altitude_m, at_s), zones, area, buffer);
        let mut worst_m = to.length();
        let count = (route.end_s() / 2.0) as u32;
        for number in 0..=count {
            if let Some(state) = route.at(f64::from(number) * 2.0) {
                worst_m = worst_m.min(margin(state.point, self.now_s + state.after_s));
                worst_m = worst_m.min(over_ground_m(state.point, state.after_s));
            }
        }
        if let Some(most_m) = reach {
            worst_m = worst_m.min(disc_m(self.nearest_site(self.plane.position(to)).1, most_m));
        }
        // The end of a path matters most: it must be clear.
        worst_m.min(margin(to, self.now_s + route.end_s()) - 1e-3)
    }

    /// Returns the nearest altitude at which the forecast keeps the limit: of wind and turbulence at the vehicle, of icing along the route.
    /// `None` if there is none, or if a restricted zone closes the climb or descent.
    fn calmer_layer(&self, reading: &Reading) -> Option<(Response, Location)> {
        let requirements = self.requirements();
        let model = &self.mission.model;
        let lowest_m = self.flown.altitude_m - self.flown.height_above_ground_m.unwrap_or(0.0)
            + CLEARANCE_SHARE * requirements.terrain_clearance_m.unwrap_or(0.0);
        let ceiling_m = model.ceiling_m * model.planning.ceiling_share;
        let limit = |altitude_m: f64| {
            let there = wind::at(self.forecast, self.here, altitude_m, self.now_s);
            match reading.name {
                "icing" => !self.may_ice_at_level(altitude_m),
                "wind" => {
                    requirements.wind_mps_max.is_some_and(|most| libm::hypot(there.east_mps, there.north_mps) < most)
                }
                _ => requirements.edr_max.is_some_and(|most| there.edr < most),
            }
        };
        let layers = (1..=LAYERS).flat_map(|number| [-f64::from(number), f64::from(number)]);
        let layers = layers.map(|number| self.flown.altitude_m + number * LAYER_M);
        // Near ice that was met, the altitude that was found then is kept.
        let level = self.flown.ice.level_m.filter(|_| reading.name == "icing");
        let altitudes = level.into_iter().chain(layers);
        let found = altitudes
            .filter(|altitude_m| (lowest_m..=ceiling_m).contains(altitude_m))
            .find(|altitude_m| limit(*altitude_m))?;
        let response = if found > self.flown.altitude_m { Response::Climb } else { Response::Descend };
        // A climb into a zone is no way out.
        let buffer = self.zone_buffer();
        let (zones, _) = self.near_zones();
        let climb =
            Route::begin(Point::default(), Point::default(), (self.flown.altitude_m, found), self.motion).stop(60.0);
        let is_shut = zones.iter().filter(|zone| zone.is_restricted() && zone.is_active(self.now_s)).any(|zone| {
            first_violation(&climb, RouteSpan { from_s: 0.0, until_s: 60.0 }, f64::INFINITY, |state| {
                zone.keep_out_m(state.point, state.altitude_m, &buffer)
            })
            .is_some()
        });
        (!is_shut).then_some((response, Location { position: self.here, altitude_m: found }))
    }
}
