//! Converts the mission's data to the terms of the observation model: the vehicle's scanner, and the air as forecast.

use crate::Mission;
use crate::clouds::{CloudDeck, clear_share};
use crate::vehicle::{Airframe, VehicleModel};
use apex_geo::wind;
use apex_model::problem::{Position, WindField};
use apex_observation::clarity::{AttitudeHold, expected_rate_weight, share_within};
use apex_observation::predict::{AirConditions, Conditions, PredictedScanner};
use apex_observation::result::LossCause;
use apex_observation::sensor::{CameraSetting, Gimbal, RateLimits, RollLimits, ScannerMode};
use apex_observation::strip::ScannerSetting;
use apex_vehicle::{Mount, Optics};

/// Losses by which coverage falls below 1.
pub(crate) const COVERAGE: [LossCause; 1] = [LossCause::NotSeen];
/// Losses by which clarity falls below 1.
pub(crate) const CLARITY: [LossCause; 9] = [
    LossCause::AttitudeNotRecorded,
    LossCause::Roll,
    LossCause::Rates,
    LossCause::LineGaps,
    LossCause::Smear,
    LossCause::TooDark,
    LossCause::SensorNotReady,
    LossCause::Cloud,
    LossCause::Glint,
];
/// Losses by which resolution falls below 1.
pub(crate) const RESOLUTION: [LossCause; 2] = [LossCause::TooCoarse, LossCause::LookAngle];
/// Losses by which timing falls below 1.
pub(crate) const TIMING: [LossCause; 7] = [
    LossCause::WrongTime,
    LossCause::ValueFallen,
    LossCause::NoLight,
    LossCause::NoOverpass,
    LossCause::LateOnGround,
    LossCause::Order,
    LossCause::Interval,
];

/// Returns the clarity of lines in turbulence of this eddy dissipation rate, m^(2/3)/s: the share of valid lines, times the weight of the
/// shift between lines at a height and ground speed.
pub(crate) fn clarity(scanner: &PredictedScanner, edr: f64, (height_m, ground_speed_mps): (f64, f64)) -> f64 {
    let PredictedScanner { setting, hold } = scanner;
    let valid = setting.roll.map_or(1.0, |roll| share_within(hold.roll_sigma_deg(edr), &roll));
    let shift = setting.rates.zip(setting.scan_rate_hz_at(height_m, ground_speed_mps)).map(|(limits, scan_rate_hz)| {
        let rate_rad_s = hold.roll_rate_sigma_deg_s(edr).to_radians();
        expected_rate_weight(rate_rad_s / setting.mode.roll_rate_rad_s_per_pixel(scan_rate_hz), &limits)
    });
    valid * shift.unwrap_or(1.0)
}

/// Returns the line scanner of a vehicle in the mode in which it is used, with the vehicle's attitude errors; `None` if it carries none.
pub(crate) fn scanner_of(model: &VehicleModel) -> Option<PredictedScanner> {
    let scanner = model.scanner.as_ref()?;
    let mode = ScannerMode {
        name: "mission".to_string(),
        pixel_mrad: scanner.pixel_mrad,
        field_of_view_deg: scanner.field_of_view_deg,
        scan_rates_hz: scanner.scan_rates_hz.clone(),
        line_overlap: scanner.overlap_share,
    };
    let roll = RollLimits { valid_deg: model.level_roll_deg_max, zero_deg: None };
    let motion = model.sensors.iter().find(|sensor| sensor.scanner_mode().is_some()).map(|sensor| &sensor.model.motion);
    let rates =
        motion.map(|motion| RateLimits { full_pixels: motion.shift_px_valid, zero_pixels: motion.shift_px_zero });
    Some(PredictedScanner {
        setting: ScannerSetting { mode, roll: Some(roll), rates, scan_rate_hz: None, is_ready: true },
        hold: hold_of(model),
    })
}

/// Exposure of a video camera, which its file does not state: a usual electronic shutter in daylight, s.
const VIDEO_EXPOSURE_S: f64 = 0.002;
/// Least elevation of the sun, in degrees, for a camera whose bands all need daylight.
const SUN_DEG_MIN: f64 = 0.0;

/// Returns the names of the cameras that a vehicle carries.
pub(crate) fn camera_names(model: &VehicleModel) -> Vec<&str> {
    model.cameras.iter().map(|camera| camera.name.as_str()).collect()
}

/// Returns true if the vehicle carries a line scanner; a frame camera does not count.
pub(crate) fn carries_scanner(model: &VehicleModel) -> bool {
    model.sensors.iter().any(|sensor| sensor.scanner_mode().is_some())
}

/// Returns a camera of the vehicle by its name; `None` if it carries no such camera.
pub(crate) fn camera_of(model: &VehicleModel, name: &str) -> Option<CameraSetting> {
    let carried = model.sensors.iter().find(|sensor| sensor.name.eq_ignore_ascii_case(name))?;
    let commanded = carried.camera()?;
    let (pixel_rad, wide_deg, high_deg, exposure_s) = match &carried.model.optics {
        Optics::LineScanner { .. } => return None,
        Optics::Frame(frame) => {
            (frame.pixel_rad(), frame.field_of_view_deg(), frame.field_of_view_along_deg(), frame.exposure_s)
        }
        Optics::Video(video) => {
            (video.pixel_rad(), video.field_of_view_deg, video.field_of_view_along_deg(), VIDEO_EXPOSURE_S)
        }
    };
    let (is_stabilised, settle_s) = match carried.model.mount {
        Mount::Fixed { .. } => (false, 0.0),
        Mount::Gimbal { settle_s, .. } => (true, settle_s),
    };
    let motion = &carried.model.motion;
    Some(CameraSetting {
        name: carried.name.clone(),
        wide_deg,
        high_deg,
        pixel_mrad: pixel_rad * 1e3,
        exposure_s,
        interval_s_min: commanded.interval_s_min,
        mount: Gimbal {
            tilt_deg: (commanded.tilt_deg_min, commanded.tilt_deg_max),
            pan_deg: (-commanded.pan_deg_max, commanded.pan_deg_max),
            rate_deg_s: commanded.slew_rate_deg_s,
            settle_s,
        },
        is_stabilised,
        roll: RollLimits { valid_deg: motion.roll_deg_valid, zero_deg: Some(motion.roll_deg_zero) },
        smear: RateLimits { full_pixels: motion.shift_px_valid, zero_pixels: motion.shift_px_zero },
        sun_deg_min: (!carried.model.works_by_night()).then_some(SUN_DEG_MIN),
    })
}

/// Returns the camera with which the vehicle observes sites from its visits: straight down from a hover, or sideways from a circle.
/// `None` if it carries no suitable camera.
pub(crate) fn looks_with(model: &VehicleModel) -> Option<CameraSetting> {
    let cameras = camera_names(model).into_iter().filter_map(|name| camera_of(model, name));
    let can = |camera: &CameraSetting| match model.airframe {
        Airframe::Rotorcraft => camera.sees_nadir(),
        Airframe::FixedWing => camera.mount.pan_deg.1 > 0.0,
    };
    cameras.into_iter().find(can)
}

/// Returns the response of the vehicle to turbulence.
pub(crate) fn hold_of(model: &VehicleModel) -> AttitudeHold {
    AttitudeHold {
        roll_deg_per_edr: model.attitude_hold.roll_deg_per_edr,
        natural_frequency_rad_s: Some(model.attitude_hold.natural_frequency_rad_s),
        damping_ratio: model.attitude_hold.damping_ratio,
    }
}

/// The air as assumed by the mission.
pub(crate) struct ForecastAir<'a> {
    field: &'a WindField,
    clouds: &'a [CloudDeck],
}

impl<'a> ForecastAir<'a> {
    /// Returns the air of the forecasts that the mission assumes.
    pub(crate) fn new(mission: &'a Mission) -> ForecastAir<'a> {
        ForecastAir { field: &mission.forecast, clouds: &mission.clouds }
    }

    /// Returns the forecast eddy dissipation rate, m^(2/3)/s.
    pub(crate) fn edr(&self, position: Position, altitude_m: f64, time_s: f64) -> f64 {
        wind::at(self.field, position, altitude_m, time_s).edr
    }
}

impl Conditions for ForecastAir<'_> {
    fn at(&self, position: Position, altitude_m: f64, time_s: f64) -> AirConditions {
        let clear_share = clear_share(self.clouds, position, altitude_m, time_s);
        AirConditions { edr: self.edr(position, altitude_m, time_s), clear_share }
    }
}
