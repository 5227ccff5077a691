//! Strips: the ground that a scanner sees between two instants, and its weights of clarity.
//!
//! Planned lines and recorded samples are converted to the same values, so that both are accumulated by the same code.

use crate::attitude::Attitude;
use crate::clarity::ClarityWeights;
use crate::footprint::{self, Ground, GroundHit};
use crate::grid::TargetGrid;
use crate::look_needs::LookNeeds;
use crate::looks::{SeenGround, StripFacts, TargetLooks};
use crate::sensor::{RateLimits, RollLimits, ScannerMode};
use apex_geo::geodesy::{Position, RAD_PER_DEG, wrap_180};

/// A scan line: where the vehicle is and where the ends of the line meet the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScanLine {
    /// Instant.
    pub time_s: f64,
    /// Ground point of the vehicle.
    pub position: Position,
    /// Altitude of the vehicle above mean sea level.
    pub altitude_m: f64,
    /// Left end.
    pub left: Position,
    /// Right end.
    pub right: Position,
    /// Mean height above the ends.
    pub height_m: f64,
}

/// Returns the scan line of a scanner at a place and attitude; `None` if it does not meet the ground within the limits.
pub fn scan_line(
    time_s: f64,
    position: Position,
    altitude_m: f64,
    attitude: &Attitude,
    half_field_rad: f64,
    ground: &dyn Ground,
    fallback_m: f64,
) -> Option<ScanLine> {
    let [left, right] = footprint::scan_edges(attitude, half_field_rad)?;
    let hit = |ray| footprint::hit_terrain(ray, position, altitude_m, ground, fallback_m);
    let (left, right) = (hit(left)?, hit(right)?);
    let there = |hit: GroundHit| footprint::offset_position(position, hit.north_m, hit.east_m);
    let height_m = 0.5 * (left.height_m + right.height_m);
    Some(ScanLine { time_s, position, altitude_m, left: there(left), right: there(right), height_m })
}

/// Adds the ground between two scan lines to the seen ground of a target. `context` is that of [`TargetLooks::add_needed`]. Returns true
/// if any cell was seen.
pub fn add_between(
    looks: &mut TargetLooks,
    grid: &TargetGrid,
    lines: (&ScanLine, &ScanLine),
    pixel_rad: f64,
    sun: Option<(f64, f64)>,
    facts: StripFacts,
    context: (Option<&dyn Ground>, Option<&LookNeeds<'_>>),
) -> bool {
    let (first, last) = lines;
    let plane = grid.plane();
    let project = |position: Position| plane.project(position);
    let (first_left, first_right) = (project(first.left), project(first.right));
    let (last_left, last_right) = (project(last.left), project(last.right));
    let seen = SeenGround {
        polygon: &[first_left, first_right, last_right, last_left],
        foot: [project(first.position), project(last.position)],
        altitude_m: [first.altitude_m, last.altitude_m],
        first_line: Some([first_left, first_right]),
        last_left,
        pixel_rad,
        sun,
    };
    looks.add_needed(grid, &seen, facts, context)
}

/// Returns the ground if it is steep enough to hide cells from a sensor with this half field of view.
pub(crate) fn hiding<'a>(grid: &TargetGrid, ground: &'a dyn Ground, half_field_rad: f64) -> Option<&'a dyn Ground> {
    let flattest_ray = libm::tan((0.5 * std::f64::consts::PI - half_field_rad).max(0.0));
    (grid.slope_max() > flattest_ray).then_some(ground)
}

/// Operation of a scanner.
#[derive(Clone, Debug, PartialEq)]
pub struct ScannerSetting {
    /// Mode.
    pub mode: ScannerMode,
    /// Limits of roll; `None`: roll does not degrade lines.
    pub roll: Option<RollLimits>,
    /// Limits of rates; `None`: rates do not degrade lines.
    pub rates: Option<RateLimits>,
    /// Scan rate. None: the lowest rate of the mode without gaps is chosen for height and speed.
    pub scan_rate_hz: Option<f64>,
    /// False while the sensor starts up.
    pub is_ready: bool,
}

/// Angular rates in radians per second.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AngularRates {
    /// Roll rate.
    pub roll: f64,
    /// Pitch rate.
    pub pitch: f64,
    /// Yaw rate.
    pub yaw: f64,
}

impl AngularRates {
    /// Returns the mean rates between two attitudes `span_s` apart; zero without a span.
    pub fn between(from: &Attitude, to: &Attitude, span_s: f64) -> AngularRates {
        if span_s.is_nan() || span_s <= 0.0 {
            return AngularRates::default();
        }
        let rate = |a: f64, b: f64| wrap_180(b - a) * RAD_PER_DEG / span_s;
        AngularRates {
            roll: rate(from.roll_deg, to.roll_deg),
            pitch: rate(from.pitch_deg, to.pitch_deg),
            yaw: rate(from.heading_deg, to.heading_deg),
        }
    }
}

impl ScannerSetting {
    /// Returns the scan rate at a height and speed; `None` if the rates of the mode are not known.
    pub fn scan_rate_hz_at(&self, height_m: f64, ground_speed_mps: f64) -> Option<f64> {
        self.scan_rate_hz.or_else(|| self.mode.choose_scan_rate_hz(height_m, ground_speed_mps))
    }

    /// Returns the weights of a flown line at a roll angle, with these rates, height above ground and ground speed. Cloud is unknown
    /// here: `clear_share` is 1.
    pub fn weights(&self, roll_deg: f64, rates: AngularRates, height_m: f64, ground_speed_mps: f64) -> ClarityWeights {
        let mut weights = ClarityWeights {
            roll: self.roll.map_or(1.0, |limits| limits.weight(roll_deg)),
            ready: if self.is_ready { 1.0 } else { 0.0 },
            ..ClarityWeights::CLEAR
        };
        if let Some(scan_rate_hz) = self.scan_rate_hz_at(height_m, ground_speed_mps) {
            weights.line_gaps = self.mode.covered_share(height_m, ground_speed_mps, rates.pitch, scan_rate_hz);
            if let Some(limits) = self.rates {
                let by_roll = rates.roll.abs() / self.mode.roll_rate_rad_s_per_pixel(scan_rate_hz);
                let by_yaw = rates.yaw.abs() / self.mode.yaw_rate_rad_s_per_pixel(scan_rate_hz);
                weights.rates = limits.weight(by_roll.max(by_yaw));
            }
        }
        weights
    }
}
