//! Prediction: the looks of planned lines in the forecast air.
//!
//! A planned line is divided into pieces of level flight, which are processed like recorded samples (`strip`). The share of valid lines
//! follows from the turbulence and the attitude hold, cloud from the forecast cover.
//! Bound: O(length / [`PIECE_M`]) pieces per line and O(cells seen).

use crate::assess::{AssessContext, Product, assess_factors};
use crate::attitude::Attitude;
use crate::clarity::{AttitudeHold, ClarityWeights, expected_rate_weight, share_within};
use crate::footprint::Ground;
use crate::grid::TargetGrid;
use crate::look_needs::LookNeeds;
use crate::looks::{StripFacts, TargetLooks};
use crate::result::{Remark, TargetResult};
use crate::strip::{ScanLine, ScannerSetting, add_between, hiding, scan_line};
use crate::target::ObservedTarget;
use crate::timing::sun::solar_position;
use apex_geo::geodesy::{self, Position, RAD_PER_DEG};
use std::collections::BTreeMap;

/// Length of a piece of a planned line: within it weather changes little and the geodesic is practically straight.
pub const PIECE_M: f64 = 4_000.0;
/// Maximum number of pieces of one line.
pub const PIECES_MAX: usize = 500;

/// A straight line that is planned to be flown level with the sensor on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlannedLine {
    /// Point at which the sensor is switched on.
    pub from: Position,
    /// Point at which the sensor is switched off.
    pub to: Position,
    /// Altitude above mean sea level.
    pub altitude_m: f64,
    /// Instant at `from`.
    pub from_s: f64,
    /// Ground speed.
    pub ground_speed_mps: f64,
    /// Heading minus track: the angle by which the nose points into the wind.
    pub crab_deg: f64,
    /// Pitch angle of the level flight: a scanner that is fixed to the body looks ahead by it.
    pub pitch_deg: f64,
    /// Instant at which the image of the line is on the ground; `None` if that is not planned.
    pub on_ground_s: Option<f64>,
}

impl PlannedLine {
    /// Returns the length over ground.
    pub fn length_m(&self) -> f64 {
        geodesy::distance_m(self.from, self.to)
    }

    /// Returns the instant at `to`.
    pub fn until_s(&self) -> f64 {
        self.from_s + self.length_m() / self.ground_speed_mps
    }
}

/// Forecast influence of the air on observations at a place, altitude and time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AirConditions {
    /// Turbulence: cube root of the eddy dissipation rate in m^(2/3)/s.
    pub edr: f64,
    /// Share of the sky between the altitude and the ground that is free of cloud, seen straight down: 1 without cloud.
    pub clear_share: f64,
}

impl AirConditions {
    /// Smooth and clear.
    pub const STILL: AirConditions = AirConditions { edr: 0.0, clear_share: 1.0 };
}

/// Forecast of the air.
pub trait Conditions {
    /// Returns the air at a place, altitude above mean sea level, and time.
    fn at(&self, position: Position, altitude_m: f64, time_s: f64) -> AirConditions;
}

impl Conditions for AirConditions {
    fn at(&self, _position: Position, _altitude_m: f64, _time_s: f64) -> AirConditions {
        *self
    }
}

/// A scanner on a vehicle, for prediction.
#[derive(Clone, Debug, PartialEq)]
pub struct PredictedScanner {
    /// Operation of the scanner.
    pub setting: ScannerSetting,
    /// Response of the vehicle to turbulence.
    pub hold: AttitudeHold,
}

/// Input of a prediction in addition to target and lines.
#[derive(Clone, Copy)]
pub struct PredictionContext<'a> {
    /// Start of the mission, seconds of Unix time.
    pub zero_unix_s: f64,
    /// Ground.
    pub ground: &'a dyn Ground,
    /// Forecast.
    pub conditions: &'a dyn Conditions,
    /// Earlier looks of the target, on the same grid; `None` without looks.
    pub seen: Option<&'a TargetLooks>,
    /// Images of earlier looks received on the ground.
    pub products: &'a [Product],
    /// First valid look of other targets, seen or planned, for order constraints.
    pub first_valid_s: &'a BTreeMap<String, f64>,
    /// True to compute losses by cause.
    pub is_explained: bool,
}

/// Returns the result of a target after the planned lines, together with earlier looks, without the figures of what is seen.
pub fn predict(
    target: &ObservedTarget,
    grid: &TargetGrid,
    lines: &[PlannedLine],
    scanner: &PredictedScanner,
    context: &PredictionContext<'_>,
) -> TargetResult {
    let planned = planned_looks(target, grid, lines, scanner, context);
    let assess_context = AssessContext {
        zero_unix_s: context.zero_unix_s,
        products: context.products,
        first_valid_s: context.first_valid_s,
        is_explained: context.is_explained,
    };
    match context.seen {
        Some(seen) => assess_factors(target, grid, &[seen, &planned], &assess_context),
        None => assess_factors(target, grid, &[&planned], &assess_context),
    }
}

/// Returns the gain of flying a segment again: the points with the planned lines less the points without them.
///
/// Each planned look adds `P(valid) max(0, q_new - q_best)` to its cell. If the cause of a loss persists, the present conditions make
/// P(valid) small, and so the gain.
pub fn gain_points(
    target: &ObservedTarget,
    grid: &TargetGrid,
    lines: &[PlannedLine],
    scanner: &PredictedScanner,
    context: &PredictionContext<'_>,
) -> f64 {
    gain_after(target, grid, (&[], lines), scanner, context)
}

/// Returns the gain of `more` lines that are flown after `lines`: the points of all of them less the points of `lines` alone.
pub fn gain_after(
    target: &ObservedTarget,
    grid: &TargetGrid,
    (lines, more): (&[PlannedLine], &[PlannedLine]),
    scanner: &PredictedScanner,
    context: &PredictionContext<'_>,
) -> f64 {
    let assess_context = AssessContext {
        zero_unix_s: context.zero_unix_s,
        products: context.products,
        first_valid_s: context.first_valid_s,
        is_explained: false,
    };
    let points = |planned: &TargetLooks| {
        let all: Vec<&TargetLooks> = context.seen.into_iter().chain([planned]).collect();
        assess_factors(target, grid, &all, &assess_context).points()
    };
    let mut planned = planned_looks(target, grid, lines, scanner, context);
    let without = points(&planned);
    add_lines(&mut planned, target, grid, more, scanner, context);
    points(&planned) - without
}

/// Returns true if flying again is worthwhile: its gain exceeds the value displaced by its time. `points_per_s` is the displaced benefit
/// per second, best computed from the values of two plans; 0 if there is slack.
pub fn is_worth_flying_again(gain_points: f64, points_per_s: f64, flight_s: f64) -> bool {
    gain_points > points_per_s * flight_s
}

/// Returns the looks of planned lines, one pass per line.
pub fn planned_looks(
    target: &ObservedTarget,
    grid: &TargetGrid,
    lines: &[PlannedLine],
    scanner: &PredictedScanner,
    context: &PredictionContext<'_>,
) -> TargetLooks {
    let mut looks = TargetLooks::default();
    if scanner.setting.mode.scan_rates_hz.is_empty() {
        looks.remarks.insert(Remark::ScanRateNotKnown);
    }
    add_lines(&mut looks, target, grid, lines, scanner, context);
    looks
}

/// Adds the looks of lines, one pass per line.
fn add_lines(
    looks: &mut TargetLooks,
    target: &ObservedTarget,
    grid: &TargetGrid,
    lines: &[PlannedLine],
    scanner: &PredictedScanner,
    context: &PredictionContext<'_>,
) {
    for line in lines {
        looks.begin_pass(grid);
        add_line(looks, target, grid, line, scanner, context);
        looks.end_pass();
    }
}

fn add_line(
    looks: &mut TargetLooks,
    target: &ObservedTarget,
    grid: &TargetGrid,
    line: &PlannedLine,
    scanner: &PredictedScanner,
    context: &PredictionContext<'_>,
) {
    let (length_m, azimuth_deg) = geodesy::inverse(line.from, line.to);
    let is_flyable = length_m.is_finite() && length_m > 0.0 && line.ground_speed_mps > 0.0;
    if !is_flyable {
        return;
    }
    let count = (libm::ceil(length_m / PIECE_M) as usize).clamp(1, PIECES_MAX);
    let half_field_rad = scanner.setting.mode.half_field_rad();
    let piece = |index: usize| -> Option<ScanLine> {
        let along_m = length_m * index as f64 / count as f64;
        let position = geodesy::destination(line.from, azimuth_deg, along_m);
        let track_deg = if index < count { geodesy::azimuth_deg(position, line.to) } else { azimuth_deg };
        let attitude = Attitude { heading_deg: track_deg + line.crab_deg, pitch_deg: line.pitch_deg, roll_deg: 0.0 };
        let time_s = line.from_s + along_m / line.ground_speed_mps;
        scan_line(time_s, position, line.altitude_m, &attitude, half_field_rad, context.ground, target.elevation_m)
    };
    let terrain = hiding(grid, context.ground, half_field_rad);
    let needs = LookNeeds { target, centre: grid.plane().centre(), zero_unix_s: context.zero_unix_s };
    let mut before: Option<ScanLine> = piece(0);
    for index in 1..=count {
        let here = piece(index);
        if let (Some(first), Some(last)) = (&before, &here) {
            let facts = facts(first, last, line, scanner, context);
            let sun = target.is_water.then(|| {
                let sun = solar_position(last.position, context.zero_unix_s + facts.time_s);
                (sun.azimuth_deg, 90.0 - sun.elevation_deg)
            });
            let context = (terrain, Some(&needs));
            add_between(looks, grid, (first, last), scanner.setting.mode.pixel_rad(), sun, facts, context);
        }
        before = here;
    }
}

fn facts(
    first: &ScanLine,
    last: &ScanLine,
    line: &PlannedLine,
    scanner: &PredictedScanner,
    context: &PredictionContext<'_>,
) -> StripFacts {
    let (setting, time_s) = (&scanner.setting, 0.5 * (first.time_s + last.time_s));
    let height_m = 0.5 * (first.height_m + last.height_m);
    let air = context.conditions.at(first.position, line.altitude_m, time_s);
    let roll_sigma_deg = scanner.hold.roll_sigma_deg(air.edr);
    let mut weights = ClarityWeights {
        roll: setting.roll.map_or(1.0, |limits| share_within(roll_sigma_deg, &limits)),
        ready: if setting.is_ready { 1.0 } else { 0.0 },
        clear_share: air.clear_share.clamp(0.0, 1.0),
        ..ClarityWeights::CLEAR
    };
    if let Some(scan_rate_hz) = setting.scan_rate_hz_at(height_m, line.ground_speed_mps) {
        weights.line_gaps = setting.mode.covered_share(height_m, line.ground_speed_mps, 0.0, scan_rate_hz);
        if let Some(limits) = setting.rates {
            let shift = scanner.hold.roll_rate_sigma_deg_s(air.edr) * RAD_PER_DEG
                / setting.mode.roll_rate_rad_s_per_pixel(scan_rate_hz);
            weights.rates = expected_rate_weight(shift, &limits);
        }
    }
    StripFacts { time_s, weights, is_flown: false, on_ground_s: line.on_ground_s }
}
