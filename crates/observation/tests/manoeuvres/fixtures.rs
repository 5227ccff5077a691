//! Vehicles, sensors, scenes and manoeuvres that the tests share.

use crate::support::{self, CENTRE, rectangle, wide_scanner};
use apex_geo::wind::Wind;
use apex_observation::clarity::AttitudeHold;
use apex_observation::footprint::FlatGround;
use apex_observation::grid::{GridSettings, TargetGrid};
use apex_observation::manoeuvres::*;
use apex_observation::predict::{AirConditions, PredictedScanner, PredictionContext};
use apex_observation::sensor::{CameraSetting, Gimbal, RateLimits, RollLimits};
use apex_observation::target::WantedLook;
use std::collections::BTreeMap;

pub(crate) const HOLD: AttitudeHold =
    AttitudeHold { roll_deg_per_edr: 10.0, natural_frequency_rad_s: Some(1.0), damping_ratio: 0.7 };

/// Returns a Predator B: 95 m/s, 18 degrees of bank.
pub(crate) fn predator() -> Craft {
    Craft {
        name: "predator-b".to_string(),
        can_hover: false,
        true_airspeed_mps: 95.0,
        true_airspeed_mps_min: 60.0,
        true_airspeed_mps_max: 118.0,
        bank_deg: 18.0,
        acceleration_mps2: 1.0,
        braking_mps2: 1.0,
        yaw_rate_deg_s: 0.0,
        climb_mps_max: 6.0,
        descent_mps_max: 8.0,
        rearward_mps_max: 0.0,
        sideways_mps_max: 0.0,
        wind_mps_max: 20.0,
        settle_s: 5.0,
        level_pitch_deg: 0.0,
        hold: HOLD,
        drain: DrainTable { points: vec![(95.0, 62.3 / 3_600.0)] },
    }
}

/// Returns a mapping fixed wing: 13 m/s, 35 degrees of bank, 20 m of lead-in.
pub(crate) fn mapper() -> Craft {
    Craft {
        name: "mapper".to_string(),
        true_airspeed_mps: 13.0,
        true_airspeed_mps_min: 11.0,
        true_airspeed_mps_max: 30.0,
        bank_deg: 35.0,
        settle_s: 20.0 / 13.0,
        ..predator()
    }
}

/// Returns a helicopter: 8 m/s, 1.5 m/s^2, 45 deg/s.
pub(crate) fn helicopter() -> Craft {
    Craft {
        name: "rmax".to_string(),
        can_hover: true,
        true_airspeed_mps: 8.0,
        true_airspeed_mps_min: 0.0,
        true_airspeed_mps_max: 20.6,
        bank_deg: 20.0,
        acceleration_mps2: 1.5,
        braking_mps2: 1.5,
        yaw_rate_deg_s: 45.0,
        climb_mps_max: 8.0,
        descent_mps_max: 8.0,
        rearward_mps_max: 10.0,
        sideways_mps_max: 10.0,
        wind_mps_max: 10.0,
        settle_s: 0.0,
        drain: DrainTable { points: vec![(0.0, 600.0), (10.0, 560.0), (20.0, 700.0)] },
        ..predator()
    }
}

/// Returns a camera of 60 by 45 degrees that tilts from straight down to 10 degrees up.
pub(crate) fn camera(pans: bool) -> Instrument {
    Instrument::Camera(CameraSetting {
        name: "camera-1".to_string(),
        wide_deg: 60.0,
        high_deg: 45.0,
        pixel_mrad: 0.5,
        exposure_s: 0.001,
        interval_s_min: 1.0,
        mount: Gimbal {
            pan_deg: if pans { (-180.0, 180.0) } else { (0.0, 0.0) },
            tilt_deg: (-90.0, 10.0),
            rate_deg_s: 60.0,
            settle_s: 0.4,
        },
        is_stabilised: true,
        roll: RollLimits { valid_deg: 30.0, zero_deg: None },
        smear: RateLimits { full_pixels: 1.0, zero_pixels: 2.0 },
        sun_deg_min: None,
    })
}

pub(crate) fn scanner() -> Instrument {
    let mut setting = wide_scanner(&[12.5, 25.0]);
    setting.roll = Some(RollLimits { valid_deg: 3.0, zero_deg: None });
    Instrument::Scanner(PredictedScanner { setting, hold: HOLD })
}

pub(crate) fn still() -> Scene {
    Scene::still(CENTRE, 0.0)
}

pub(crate) fn windy(east_mps: f64, north_mps: f64) -> Scene {
    Scene { wind: Wind { east_mps, north_mps, edr: 0.0 }, ..still() }
}

pub(crate) fn with(path: FlightPath, attitude: AttitudeMode, speed: SpeedProfile, payload: PayloadUse) -> Manoeuvre {
    Manoeuvre { path, attitude, speed, payload, data: DataHandling::Store }
}

pub(crate) fn scanned(path: FlightPath) -> Manoeuvre {
    with(path, AttitudeMode::Coordinated, SpeedProfile::Airspeed(95.0), PayloadUse::LineScan)
}

pub(crate) fn forecast(
    manoeuvre: &Manoeuvre,
    craft: &Craft,
    instrument: &Instrument,
    scene: &Scene,
    size: (f64, f64),
    want_m: f64,
) -> Forecast {
    let target = rectangle("field", size, vec![WantedLook::new("look", 100.0, want_m)]);
    let grid = TargetGrid::new(&target, GridSettings::default()).unwrap();
    let first = BTreeMap::new();
    let prediction = PredictionContext {
        zero_unix_s: support::ZERO_UNIX_S,
        ground: &FlatGround { elevation_m: 0.0 },
        conditions: &AirConditions::STILL,
        seen: None,
        products: &[],
        first_valid_s: &first,
        is_explained: false,
    };
    manoeuvre.forecast(craft, instrument, scene, &ForecastContext { target: &target, grid: &grid, prediction }).unwrap()
}

pub(crate) fn box_of(width_m: f64, depth_m: f64) -> Vec<(f64, f64)> {
    let (x, y) = (0.5 * width_m, 0.5 * depth_m);
    vec![(-x, -y), (x, -y), (x, y), (-x, y)]
}

pub(crate) fn sweep(
    width_m: f64,
    depth_m: f64,
    height_m: f64,
    swath_m: f64,
    sidelap: f64,
    track_deg: Option<f64>,
) -> Sweep {
    Sweep { corners: box_of(width_m, depth_m), height_m, swath_m, sidelap, track_deg, run_in_m: 0.0 }
}

pub(crate) fn orbit(radius_m: f64, height_m: f64) -> Orbit {
    Orbit { radius_m, height_m, turns: 1.0, from_deg: 180.0, clockwise: true }
}

pub(crate) fn arch() -> Arc {
    Arc {
        azimuth_deg: 0.0,
        shape: ArcShape::Arch { radius_m: 80.0 },
        from_elevation_deg: 30.0,
        speed_mps: 8.0,
        turn_speed_mps: 1.0,
        yaw_rate_deg_s: 45.0,
        acceleration_mps2: 1.5,
    }
}
