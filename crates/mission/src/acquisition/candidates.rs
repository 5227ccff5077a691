//! Candidates for a goal: combinations of heights, directions and patterns, each a manoeuvre that vehicle and sensor can fly.
//!
//! Bound: [`CANDIDATES_MAX`].

use super::goal::{AcquisitionGoal, ProductKind};
use super::sweep_form::{SIDELAP, corners_of};
use super::vehicle::craft_of;
use crate::Mission;
use crate::observing::{camera_names, camera_of, scanner_of};
use crate::vehicle::Airframe;
use apex_geo::geodesy::{self, Position, RAD_PER_DEG, wrap_360};
use apex_geo::wind;
use apex_model::problem::ZoneKind;
use apex_observation::manoeuvres::{
    Arc, ArcShape, AttitudeMode, FlightPath, Instrument, Manoeuvre, Orbit, PayloadUse, Scene, Side, SpeedProfile,
    Spiral, StandOff, StraightOver, Sweep, VantagePoint,
};
use apex_observation::sensor::CameraSetting;

/// Candidates for one goal.
pub(super) const CANDIDATES_MAX: usize = 160;
/// Least height above ground if the mission requires no other: fixed wing, rotorcraft.
const HEIGHT_M_MIN: (f64, f64) = (100.0, 20.0);
/// Height kept from faces of zones without a requirement.
pub(super) const FACE_M: f64 = 30.0;
/// Height by which a vehicle may leave its altitude.
const LEVEL_M: f64 = 3.0;
/// Relative difference below which two heights count as equal.
const APART_SHARE: f64 = 0.08;
/// Look angles to try, degrees.
const LOOK_ANGLES_DEG: [f64; 4] = [0.0, 30.0, 45.0, 60.0];
/// Share of a footprint that plans use, because roll and position are never exact.
const FOOTPRINT_SHARE: f64 = 0.8;

/// A manoeuvre with the sensor that records it.
#[derive(Clone, Debug)]
pub(crate) struct ManoeuvreCandidate {
    pub(crate) manoeuvre: Manoeuvre,
    /// Name of the sensor in PDL.
    pub(crate) sensor: String,
    pub(crate) instrument: Instrument,
    pub(crate) height_m: f64,
    /// Speed in the terms of PDL: airspeed of a fixed wing, ground speed of a rotorcraft.
    pub(crate) speed_mps: f64,
    /// Distance between pictures.
    pub(crate) every_m: f64,
}

/// Returns the sensors that may record the product.
///
/// # Errors
/// If the vehicle carries no such sensor: the sensors that it carries.
pub(super) fn sensors(mission: &Mission, goal: &AcquisitionGoal) -> Result<Vec<(String, Instrument)>, String> {
    let model = &mission.model;
    let cameras = camera_names(model)
        .into_iter()
        .filter_map(|name| camera_of(model, name).map(|camera| (name.to_string(), Instrument::Camera(camera))));
    let scans = crate::observing::carries_scanner(model);
    let scanner =
        scanner_of(model).filter(|_| scans).map(|scanner| ("scanner".to_string(), Instrument::Scanner(scanner)));
    let all: Vec<(String, Instrument)> = cameras.chain(scanner).collect();
    let carried: Vec<String> = all.iter().map(|(name, _)| name.clone()).collect();
    let records = |instrument: &Instrument| match goal.product {
        ProductKind::Any => true,
        ProductKind::Stills | ProductKind::Video => matches!(instrument, Instrument::Camera(_)),
        ProductKind::Lines => matches!(instrument, Instrument::Scanner(_)),
    };
    let named = |name: &str| goal.sensor.as_ref().is_none_or(|wanted| wanted.eq_ignore_ascii_case(name));
    let fitting: Vec<_> = all.into_iter().filter(|(name, instrument)| named(name) && records(instrument)).collect();
    if fitting.is_empty() {
        let wanted = goal.sensor.as_ref().map_or_else(String::new, |name| format!(" with `{name}`"));
        let product = match goal.product {
            ProductKind::Any => "a product",
            ProductKind::Stills => "`:product stills`",
            ProductKind::Video => "`:product video`",
            ProductKind::Lines => "`:product lines`",
        };
        let carried = if carried.is_empty() { "no sensor".to_string() } else { carried.join(", ") };
        return Err(format!("no sensor of `{}` records {product}{wanted}; it carries {carried}", model.name));
    }
    Ok(fitting)
}

/// Heights above the target to try, rising: at least the lowest permitted.
pub(crate) fn heights_m(mission: &Mission, goal: &AcquisitionGoal, instrument: &Instrument) -> Vec<f64> {
    let model = &mission.model;
    let lowest_m = lowest_m(mission, goal);
    let level_m = goal.target.elevation_m;
    let ceiling_m = model.ceiling_m * model.planning.ceiling_share - level_m;
    let mut found = vec![lowest_m, model.planning.visit_height_m, mission.cruise_altitude_m() - level_m];
    let nadir_m = goal.resolution_m / instrument.pixel_rad();
    if nadir_m.is_finite() {
        let share = |angle_deg: f64| nadir_m * libm::cos(angle_deg * RAD_PER_DEG) * libm::cos(angle_deg * RAD_PER_DEG);
        found.extend([0.98 * nadir_m, share(30.0), share(45.0), 0.5 * nadir_m, share(60.0)]);
    } else {
        found.extend([2.0 * lowest_m, 0.5 * ceiling_m]);
    }
    if let Instrument::Scanner(scanner) = instrument {
        found.push(scanner.setting.mode.height_m_min_any(model.true_airspeed_m_s_cruise));
        let edge_rad = scanner.setting.mode.half_field_rad().min(std::f64::consts::FRAC_PI_4);
        found.extend(nadir_m.is_finite().then(|| scanner.setting.mode.height_m_max(goal.resolution_m, edge_rad)));
    }
    let face_m = mission.requirements.airspace.map_or(FACE_M, |buffer| buffer.vertical_m + LEVEL_M);
    for zone in mission.zones.iter().filter(|zone| zone.kind == ZoneKind::Restricted) {
        found.extend([zone.altitude_m_max + face_m - level_m, zone.altitude_m_min - face_m - level_m]);
    }
    for layer in &mission.forecast.layers {
        found.push(0.5 * (layer.altitude_m_min + layer.altitude_m_max) - level_m);
    }
    found.retain(|height_m| height_m.is_finite() && (lowest_m..=ceiling_m).contains(height_m));
    found.sort_by(f64::total_cmp);
    found.dedup_by(|next, before| *next - *before < APART_SHARE * *before);
    found
}

/// Returns the lowest height above the target: the clearance that the mission requires, otherwise the least height of the vehicle.
pub(super) fn lowest_m(mission: &Mission, goal: &AcquisitionGoal) -> f64 {
    clearance_m(mission) + LEVEL_M + (ground_m(mission, goal) - goal.target.elevation_m).max(0.0)
}

/// Returns the clearance over ground that candidates keep.
pub(super) fn clearance_m(mission: &Mission) -> f64 {
    let least_m = match mission.model.airframe {
        Airframe::FixedWing => HEIGHT_M_MIN.0,
        Airframe::Rotorcraft => HEIGHT_M_MIN.1,
    };
    mission.requirements.terrain_clearance_m.map_or(least_m, |clearance_m| clearance_m.max(least_m))
}

/// Returns the elevation of the ground at the target.
pub(super) fn ground_m(mission: &Mission, goal: &AcquisitionGoal) -> f64 {
    let target = mission.targets.iter().find(|target| target.id.eq_ignore_ascii_case(&goal.target.name));
    target.map_or(goal.target.elevation_m, |target| target.elevation_m)
}

/// Returns all candidates of one sensor at one height.
pub(crate) fn at_height(
    (mission, goal): (&Mission, &AcquisitionGoal),
    (sensor, instrument): (&str, &Instrument),
    height_m: f64,
    (here, at_s): (Position, f64),
) -> Vec<ManoeuvreCandidate> {
    let hovers = mission.model.airframe == Airframe::Rotorcraft;
    let field_wind = wind::at(&mission.forecast, goal.position, goal.target.elevation_m + height_m, at_s);
    let wind_mps = libm::hypot(field_wind.east_mps, field_wind.north_mps);
    // Into the wind, otherwise in the direction from which the vehicle arrives.
    let track_deg = match wind_mps > 1.0 {
        true => libm::atan2(-field_wind.east_mps, -field_wind.north_mps) / RAD_PER_DEG,
        false => geodesy::azimuth_deg(here, goal.position),
    };
    let towards_deg = geodesy::azimuth_deg(goal.position, here);
    let setting = Setting { mission, goal, sensor, instrument, height_m, track_deg, towards_deg, hovers, wind_mps };
    let mut made = Vec::new();
    setting.lines(&mut made);
    match instrument {
        Instrument::Camera(camera) => {
            setting.around(camera, &mut made);
            setting.hovering(&mut made);
        }
        Instrument::Scanner(_) => {}
    }
    made
}

/// Common data of the candidates of one sensor and height.
struct Setting<'a> {
    mission: &'a Mission,
    goal: &'a AcquisitionGoal,
    sensor: &'a str,
    instrument: &'a Instrument,
    height_m: f64,
    track_deg: f64,
    towards_deg: f64,
    hovers: bool,
    wind_mps: f64,
}

impl Setting<'_> {
    /// Returns the ground speed of a rotorcraft or the airspeed of a fixed wing, limited so that pictures neither smear nor leave gaps.
    fn speed_mps(&self, slant_m: f64) -> f64 {
        let model = &self.mission.model;
        let cruise = model.true_airspeed_m_s_cruise;
        let Instrument::Camera(camera) = self.instrument else { return cruise };
        let smear = camera.ground_speed_mps_max(slant_m);
        let base_m = self.base_m(slant_m);
        let by_interval = if camera.interval_s_min > 0.0 { base_m / camera.interval_s_min } else { f64::INFINITY };
        let most = if self.hovers { cruise - 0.5 * self.wind_mps } else { cruise };
        let least = if self.hovers { 1.0 } else { craft_of(model, self.height_m).true_airspeed_mps_min };
        most.min(smear).min(by_interval).max(least)
    }

    /// Returns the distance between pictures.
    fn base_m(&self, slant_m: f64) -> f64 {
        match self.instrument {
            Instrument::Camera(camera) => (camera.footprint_m(slant_m).1 * 0.3).clamp(2.0, 2_000.0),
            Instrument::Scanner(_) => 0.0,
        }
    }

    fn put(&self, made: &mut Vec<ManoeuvreCandidate>, path: FlightPath, (speed_mps, slant_m): (f64, f64)) {
        let every_m = libm::round(10.0 * self.base_m(slant_m)) / 10.0;
        let payload = match self.instrument {
            Instrument::Scanner(_) => PayloadUse::LineScan,
            Instrument::Camera(_) => PayloadUse::StillsEvery(every_m),
        };
        let is_aimed = matches!(
            path,
            FlightPath::Orbit(_) | FlightPath::Arc(_) | FlightPath::StandOff(_) | FlightPath::VantagePoint(_)
        );
        let attitude = if is_aimed && self.hovers { AttitudeMode::Pointing } else { AttitudeMode::Coordinated };
        let speed_mps = (libm::round(10.0 * speed_mps) / 10.0).max(0.5);
        let speed = if self.hovers { SpeedProfile::GroundSpeed(speed_mps) } else { SpeedProfile::Airspeed(speed_mps) };
        made.push(ManoeuvreCandidate {
            manoeuvre: Manoeuvre { path, attitude, speed, payload, data: self.goal.handling },
            sensor: self.sensor.to_string(),
            instrument: self.instrument.clone(),
            height_m: self.height_m,
            speed_mps,
            every_m,
        });
    }

    fn angles_deg(&self) -> impl Iterator<Item = f64> {
        let wanted = self.goal.look_angle_deg;
        let middle = wanted.map(|(low, high)| 0.5 * (low + high));
        let fits = move |angle: &f64| wanted.is_none_or(|(low, high)| (low..=high).contains(angle));
        LOOK_ANGLES_DEG.into_iter().filter(fits).chain(middle)
    }

    /// Adds lines: over the target, to its side, and sweeps of areas wider than a footprint.
    fn lines(&self, made: &mut Vec<ManoeuvreCandidate>) {
        let (height_m, speed_mps) = (self.height_m, self.speed_mps(self.height_m));
        let across_m = self.instrument.swath_m(height_m, self.goal.resolution_m);
        let margin_m = match self.instrument {
            Instrument::Camera(_) => self.base_m(height_m),
            // A scanner looks ahead by the pitch of level flight, so its lines begin that much earlier.
            Instrument::Scanner(_) => {
                let altitude_m = self.goal.target.elevation_m + height_m;
                height_m * libm::tan(self.mission.model.cruise_pitch_rad(altitude_m)).max(0.0)
            }
        };
        let sees_down = match self.instrument {
            Instrument::Camera(camera) => camera.sees_nadir(),
            Instrument::Scanner(_) => true,
        };
        if across_m > 0.0 && sees_down {
            let length_m = 2.0 * self.goal.radius_m + 2.0 * margin_m.max(10.0);
            for track_deg in [self.track_deg, self.track_deg + 90.0].map(wrap_360) {
                let path = StraightOver { track_deg, height_m, length_m, run_out_m: 0.0 };
                self.put(made, FlightPath::StraightOver(path), (speed_mps, height_m));
            }
            if self.goal.radius_m > 0.25 * across_m {
                self.sweep(made, (across_m, margin_m, speed_mps));
            }
        }
        for angle_deg in self.angles_deg().filter(|angle| *angle >= 10.0) {
            for side in [Side::Left, Side::Right] {
                let length_m = 2.0 * self.goal.radius_m.max(0.2 * height_m);
                let path = StandOff { track_deg: self.track_deg, side, height_m, look_angle_deg: angle_deg, length_m };
                let slant_m = height_m / libm::cos(angle_deg * RAD_PER_DEG);
                self.put(made, FlightPath::StandOff(path), (self.speed_mps(slant_m), slant_m));
            }
        }
    }

    fn sweep(&self, made: &mut Vec<ManoeuvreCandidate>, (across_m, margin_m, speed_mps): (f64, f64, f64)) {
        let scene = Scene::still(self.goal.position, self.goal.target.elevation_m);
        let corners = corners_of(&self.goal.target.area, &scene, self.goal.radius_m);
        // The direction of a sweep is searched, depending on the wind and the shape.
        let path = Sweep {
            corners,
            height_m: self.height_m,
            swath_m: across_m,
            sidelap: SIDELAP,
            track_deg: None,
            run_in_m: margin_m,
        };
        self.put(made, FlightPath::Sweep(path), (speed_mps, self.height_m));
    }

    /// Orbits, spirals and arcs.
    fn around(&self, camera: &CameraSetting, made: &mut Vec<ManoeuvreCandidate>) {
        let height_m = self.height_m;
        let aims = self.hovers || camera.mount.pan_deg.1 > 0.0;
        for angle_deg in self.angles_deg().filter(|angle| *angle >= 15.0 && aims) {
            let radius_m = height_m * libm::tan(angle_deg * RAD_PER_DEG);
            let slant_m = libm::hypot(height_m, radius_m);
            let orbit = Orbit { radius_m, height_m, turns: 1.0, from_deg: wrap_360(self.towards_deg), clockwise: true };
            self.put(made, FlightPath::Orbit(orbit), (self.speed_mps(slant_m), slant_m));
        }
        let across_m = FOOTPRINT_SHARE * camera.footprint_m(height_m).0;
        if camera.sees_nadir() && self.goal.radius_m > 0.5 * across_m {
            let spiral = Spiral {
                inner_radius_m: 0.3 * across_m,
                outer_radius_m: self.goal.radius_m.max(0.6 * across_m),
                spacing_m: 0.7 * across_m,
                height_m,
                from_deg: wrap_360(self.towards_deg),
                clockwise: true,
                inward: false,
            };
            self.put(made, FlightPath::Spiral(spiral), (self.speed_mps(height_m), height_m));
        }
        if self.hovers && self.goal.look_angle_deg.is_none_or(|(low, _)| low == 0.0) {
            let model = &self.mission.model;
            let arc = Arc {
                azimuth_deg: wrap_360(self.track_deg + if self.wind_mps > 1.0 { 180.0 } else { 0.0 }),
                shape: ArcShape::Level { height_m },
                from_elevation_deg: 40.0,
                speed_mps: self.speed_mps(height_m).min(8.0),
                turn_speed_mps: 1.0,
                yaw_rate_deg_s: model.yaw_rate_deg_s_max.min(45.0),
                acceleration_mps2: 0.5 * model.acceleration_m_s2_max * model.braking_share,
            };
            self.put(made, FlightPath::Arc(arc), (arc.speed_mps, height_m));
        }
    }

    /// Places to look from.
    fn hovering(&self, made: &mut Vec<ManoeuvreCandidate>) {
        for angle_deg in self.angles_deg().filter(|_| self.hovers) {
            let slant_m = self.height_m / libm::cos(angle_deg * RAD_PER_DEG);
            let sides: &[f64] = if angle_deg < 1.0 { &[0.0] } else { &[0.0, 90.0, 180.0, 270.0] };
            for side_deg in sides {
                let azimuth_deg = wrap_360(self.towards_deg + side_deg);
                let place = VantagePoint { azimuth_deg, look_angle_deg: angle_deg, slant_m, dwell_s: 5.0 };
                self.put(made, FlightPath::VantagePoint(place), (self.speed_mps(slant_m), slant_m));
            }
        }
    }
}
