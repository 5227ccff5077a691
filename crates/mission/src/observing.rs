//! The mission's data in the terms of the observation model: the vehicle's scanner, and the air as forecast.

use crate::Mission;
use crate::vehicle::VehicleModel;
use apex_geo::wind;
use apex_model::problem::{Position, WindField};
use apex_observation::clarity::{AttitudeHold, share_within};
use apex_observation::footprint::Ground;
use apex_observation::predict::{AirConditions, Conditions, PredictedScanner};
use apex_observation::result::LossCause;
use apex_observation::sensor::{RollLimits, ScannerMode};
use apex_observation::strip::ScannerSetting;

/// Losses by which coverage falls below 1.
pub(crate) const COVERAGE: [LossCause; 1] = [LossCause::NotSeen];
/// Losses by which clarity falls below 1.
pub(crate) const CLARITY: [LossCause; 8] = [
    LossCause::AttitudeNotRecorded,
    LossCause::Roll,
    LossCause::Rates,
    LossCause::LineGaps,
    LossCause::Smear,
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

/// Share of valid lines in turbulence of this eddy dissipation rate, m^(2/3)/s.
pub(crate) fn clarity(scanner: &PredictedScanner, edr: f64) -> f64 {
    scanner.setting.roll.map_or(1.0, |roll| share_within(scanner.hold.roll_sigma_deg(edr), &roll))
}

/// Terrain is not known: the ground lies at the elevation of each target.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NoTerrain {
    /// Elevation of the lowest target, m.
    pub(crate) lowest_m: f64,
}

impl Ground for NoTerrain {
    fn elevation_m_at(&self, _: Position) -> Option<f64> {
        None
    }

    /// No higher than any target, so that each one's own elevation counts.
    fn elevation_range_m(&self) -> (f64, f64) {
        (self.lowest_m - 1.0, self.lowest_m)
    }

    fn cell_m(&self) -> f64 {
        f64::INFINITY
    }
}

/// The line scanner that a vehicle carries, in the mode that it is flown in, and how the vehicle holds its attitude; none if
/// it carries none.
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
    Some(PredictedScanner {
        setting: ScannerSetting { mode, roll: Some(roll), rates: None, scan_rate_hz: None, is_ready: true },
        hold: AttitudeHold {
            roll_deg_per_edr: model.attitude_hold.roll_deg_per_edr,
            natural_frequency_rad_s: Some(model.attitude_hold.natural_frequency_rad_s),
            damping_ratio: model.attitude_hold.damping_ratio,
        },
    })
}

/// The air as the mission believes it.
pub(crate) struct ForecastAir<'a> {
    field: &'a WindField,
}

impl<'a> ForecastAir<'a> {
    /// By the forecast that the mission believes.
    pub(crate) fn new(mission: &'a Mission) -> ForecastAir<'a> {
        ForecastAir { field: &mission.forecast }
    }

    /// Eddy dissipation rate, m^(2/3)/s.
    pub(crate) fn edr(&self, position: Position, altitude_m: f64, time_s: f64) -> f64 {
        wind::at(self.field, position, altitude_m, time_s).edr
    }
}

impl Conditions for ForecastAir<'_> {
    fn at(&self, position: Position, altitude_m: f64, time_s: f64) -> AirConditions {
        AirConditions { edr: self.edr(position, altitude_m, time_s), clear_share: 1.0 }
    }
}
