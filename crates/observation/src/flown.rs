//! Flown observations: computed from the recorded samples of a flight.
//!
//! Samples, switches of the sensor, pictures and received products are passed in order of time. Ground between two samples counts as seen
//! while the sensor is on and the samples are close in time; a gap in the record is not seen. Only samples near a target are rasterised.
//! Bound: O(targets) per sample, O(cells of the swath) near a target.

mod ground;
mod nearest;
mod results;

use crate::assess::Product;
use crate::attitude::Attitude;
use crate::clarity::ClarityWeights;
use crate::footprint::{Ground, OFF_NADIR_DEG_MAX};
use crate::grid::{AreaError, GridSettings, TargetGrid};
use crate::look_needs::LookNeeds;
use crate::looks::{CellLook, StripFacts, TargetLooks};
use crate::pictures::{PictureView, add_picture};
use crate::result::Remark;
use crate::sensor::GimbalAngles;
use crate::strip::{AngularRates, ScanLine, ScannerSetting, add_between, hiding, scan_line};
use crate::target::{ObservedTarget, WANTED_LOOKS_MAX};
use crate::timing::sun::solar_position;
use apex_geo::geodesy::{self, Position, RAD_PER_DEG};
use std::collections::BTreeMap;
use std::fmt;

/// Time for which a target must not be seen, while the sensor is on, before the next sighting begins a new pass.
pub const PASS_GAP_S: f64 = 60.0;
/// Roll that changes by more than this between two samples is interpolated.
const ROLL_STEP_DEG: f64 = 0.5;
/// Time between interpolated samples.
const INTERPOLATION_S: f64 = 0.2;
/// Maximum number of interpolated pieces between two samples.
const PIECES_MAX: f64 = 20.0;

/// Settings of a [`FlownObservation`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlownSettings {
    /// Start of the mission, seconds of Unix time.
    pub zero_unix_s: f64,
    /// Resolution of the grids.
    pub grid: GridSettings,
    /// Greatest time between samples; the ground of longer gaps is not seen.
    pub sample_gap_s_max: f64,
}

/// Error in the targets of a flight, whose observations then cannot be accumulated.
#[derive(Clone, Debug, PartialEq)]
pub enum ObservationError {
    /// A target's area is not usable.
    Area(AreaError),
    /// A target requests more looks than [`WANTED_LOOKS_MAX`].
    TooManyLooks {
        /// Name of the target.
        target: String,
        /// Number of its wanted looks.
        looks: usize,
    },
    /// Two targets have the same name.
    DoubleName(String),
}

impl fmt::Display for ObservationError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ObservationError::Area(error) => error.fmt(f),
            ObservationError::TooManyLooks { target, looks } => {
                let most = WANTED_LOOKS_MAX;
                write!(
                    f,
                    "target `{target}` requests {looks} looks, at most {most} are possible: split it into two targets"
                )
            }
            ObservationError::DoubleName(name) => {
                write!(f, "two targets have the name `{name}`: give each its own name")
            }
        }
    }
}

impl std::error::Error for ObservationError {}

/// State of the sensor from an instant on.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum SensorState {
    /// Nothing is recorded.
    #[default]
    Off,
    /// A line scanner records.
    Scanning(ScannerSetting),
}

/// State of the vehicle at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlightSample {
    /// Instant.
    pub time_s: f64,
    /// Ground point of the vehicle.
    pub position: Position,
    /// Altitude above mean sea level.
    pub altitude_m: f64,
    /// Attitude; `None` if the record has none. Lines then count as level with clarity 0.
    pub attitude: Option<Attitude>,
    /// Ground speed.
    pub ground_speed_mps: f64,
    /// Share of the vertical line of sight that is free of cloud, 0 or 1 in simulation; `None` if it is unknown.
    pub clear_share: Option<f64>,
}

/// A picture or a frame of a video.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Picture {
    /// Vehicle at the instant of the exposure.
    pub sample: FlightSample,
    /// Angles of the gimbal.
    pub angles: GimbalAngles,
    /// Full horizontal field of view.
    pub horizontal_field_deg: f64,
    /// Full vertical field of view.
    pub vertical_field_deg: f64,
    /// Angle of one pixel.
    pub pixel_mrad: f64,
    /// True if the mount holds tilt relative to the horizon and pan relative to the heading, regardless of the body's attitude.
    pub is_stabilised: bool,
    /// Weights of clarity by motion, readiness and light.
    pub weights: ClarityWeights,
}

impl Picture {
    fn view(&self) -> PictureView {
        PictureView {
            time_s: self.sample.time_s,
            position: self.sample.position,
            altitude_m: self.sample.altitude_m,
            attitude: self.sample.attitude.unwrap_or_default(),
            angles: self.angles,
            is_stabilised: self.is_stabilised,
            wide_deg: self.horizontal_field_deg,
            high_deg: self.vertical_field_deg,
            pixel_mrad: self.pixel_mrad,
        }
    }
}

/// A target with its grid and its looks so far.
#[derive(Clone, Debug)]
struct TargetObservations {
    target: ObservedTarget,
    grid: TargetGrid,
    looks: TargetLooks,
    last_seen_s: f64,
    reach_m: f64,
}

/// The observations of a flight, accumulated from its samples.
#[derive(Clone, Debug)]
pub struct FlownObservation {
    settings: FlownSettings,
    watched: Vec<TargetObservations>,
    sensor: SensorState,
    last: Option<FlightSample>,
    products: Vec<Product>,
}

impl FlownObservation {
    /// Returns an accumulation without observations. `ground` contains the elevations of the targets.
    ///
    /// # Errors
    /// [`ObservationError`] if an area is invalid, a target has too many wanted looks, or two have the same name.
    pub fn new(
        targets: Vec<ObservedTarget>,
        settings: FlownSettings,
        ground: &dyn Ground,
    ) -> Result<FlownObservation, ObservationError> {
        let grid = |target: ObservedTarget| {
            let grid = FlownObservation::grid_of(&target, settings.grid, ground);
            (target, grid)
        };
        FlownObservation::with_grids(targets.into_iter().map(grid), settings)
    }

    /// Returns an accumulation without observations, for targets with their grids, as [`FlownObservation::grid_of`] makes them.
    ///
    /// # Errors
    /// Like [`FlownObservation::new`].
    pub fn with_grids(
        targets: impl IntoIterator<Item = (ObservedTarget, Result<TargetGrid, AreaError>)>,
        settings: FlownSettings,
    ) -> Result<FlownObservation, ObservationError> {
        let mut watched: Vec<TargetObservations> = Vec::new();
        for (target, grid) in targets {
            if target.looks.len() > WANTED_LOOKS_MAX {
                return Err(ObservationError::TooManyLooks { looks: target.looks.len(), target: target.name });
            }
            if watched.iter().any(|other| other.target.name == target.name) {
                return Err(ObservationError::DoubleName(target.name));
            }
            watched.push(TargetObservations::new(target, grid.map_err(ObservationError::Area)?));
        }
        Ok(FlownObservation { settings, watched, sensor: SensorState::Off, last: None, products: Vec::new() })
    }

    /// Changes the state of the sensor at the instant of the last sample: the strip that ends there is complete.
    pub fn sensor(&mut self, state: SensorState) {
        if self.sensor != state {
            self.sensor = state;
            self.end_passes();
            if self.sensor == SensorState::Off {
                self.last = None;
            }
        }
    }

    /// Adds the vehicle's state at the next instant. With a scanner on, the ground since the preceding sample is seen.
    pub fn sample(&mut self, sample: FlightSample, ground: &dyn Ground) {
        let SensorState::Scanning(setting) = &self.sensor else {
            self.last = None;
            return;
        };
        let before = self.last.replace(sample);
        let Some(before) = before else { return };
        let span_s = sample.time_s - before.time_s;
        if span_s.is_nan() || span_s <= 0.0 || span_s > self.settings.sample_gap_s_max {
            self.end_passes();
            return;
        }
        let lowest_m = ground.elevation_range_m().0;
        let roll_deg = |sample: &FlightSample| sample.attitude.map_or(0.0, |attitude| attitude.roll_deg.abs());
        let angle_deg = 0.5 * setting.mode.field_of_view_deg + roll_deg(&sample).max(roll_deg(&before));
        let swath_m =
            (sample.altitude_m - lowest_m).max(0.0) * libm::tan(angle_deg.min(OFF_NADIR_DEG_MAX) * RAD_PER_DEG);
        let zero_unix_s = self.settings.zero_unix_s;
        for watched in self.watched.iter_mut().filter(|watched| watched.is_near(sample.position, swath_m)) {
            watched.strip(&before, &sample, setting, ground, zero_unix_s);
        }
    }

    /// Adds a picture; the scanner's state does not matter.
    pub fn picture(&mut self, picture: &Picture, ground: &dyn Ground) {
        let lowest_m = ground.elevation_range_m().0;
        let height_m = (picture.sample.altitude_m - lowest_m).max(0.0);
        let reach_m = height_m * libm::tan(OFF_NADIR_DEG_MAX * RAD_PER_DEG);
        let near = |watched: &&mut TargetObservations| watched.is_near(picture.sample.position, reach_m);
        for watched in self.watched.iter_mut().filter(near) {
            watched.picture(picture, ground, self.settings.zero_unix_s);
        }
    }

    /// Adds the image of a line or picture that was received on the ground.
    pub fn product(&mut self, product: Product) {
        self.products.push(product);
    }

    /// Returns the images received so far.
    pub fn products(&self) -> &[Product] {
        &self.products
    }

    /// Returns the looks that a target has received until now; `None` for an unknown name.
    pub fn looks(&self, name: &str) -> Option<&TargetLooks> {
        self.watched.iter().find(|watched| watched.target.name == name).map(|watched| &watched.looks)
    }

    /// Returns the elevation of the target whose centre is nearest to a position; 0 without targets.
    pub fn elevation_m_near(&self, position: Position) -> f64 {
        let centres = self.watched.iter().map(|watched| watched.grid.plane().centre());
        let nearest = nearest::nearest(position, centres, |centre| geodesy::distance_m(centre, position));
        let nearest = nearest.and_then(|index| self.watched.get(index));
        nearest.map_or(0.0, |watched| watched.target.elevation_m)
    }

    /// Returns the instants at which a target was seen clearly and with pixels that have a value for one of its wanted looks.
    pub fn valid_looks_s(&self, name: &str) -> Vec<f64> {
        let Some(watched) = self.watched.iter().find(|watched| watched.target.name == name) else { return Vec::new() };
        let wanted = &watched.target.looks;
        let is_fine = |look: &CellLook| {
            let (along_m, across_m) = (f64::from(look.pixel_along_m), f64::from(look.pixel_across_m));
            wanted.iter().any(|wanted| wanted.resolution.factor(along_m, across_m) > 0.0)
        };
        watched.looks.valid().filter(|(look, _)| is_fine(look)).map(|(_, time_s)| time_s).collect()
    }

    /// Returns the grid of a target; `None` for an unknown name.
    pub fn grid(&self, name: &str) -> Option<&TargetGrid> {
        self.watched.iter().find(|watched| watched.target.name == name).map(|watched| &watched.grid)
    }

    /// Returns the first valid look of each target seen so far.
    pub fn first_valid_s(&self) -> BTreeMap<String, f64> {
        let seen = |watched: &TargetObservations| Some((watched.target.name.clone(), watched.looks.first_valid_s()?));
        self.watched.iter().filter_map(seen).collect()
    }

    fn end_passes(&mut self) {
        self.watched.iter_mut().for_each(|watched| watched.looks.end_pass());
    }
}

impl TargetObservations {
    /// Returns true if ground within `swath_m` of a position may belong to the target. Compares degrees, because most targets are far.
    fn is_near(&self, position: Position, swath_m: f64) -> bool {
        let centre = self.grid.plane().centre();
        let reach_m = self.reach_m + swath_m + 1_000.0;
        let north_deg = (position.latitude_deg - centre.latitude_deg).abs();
        if north_deg * 110_500.0 > reach_m {
            return false;
        }
        let east_deg = geodesy::wrap_180(position.longitude_deg - centre.longitude_deg).abs();
        let farthest_rad = (position.latitude_deg.abs().max(centre.latitude_deg.abs())).min(89.0) * RAD_PER_DEG;
        east_deg * 111_300.0 * libm::cos(farthest_rad) <= reach_m
    }

    fn begin(&mut self, time_s: f64) {
        if !self.looks.is_recording() || time_s - self.last_seen_s > PASS_GAP_S {
            let is_empty = self.looks.passes.last().is_some_and(|pass| pass.looks.is_empty());
            if is_empty {
                self.looks.passes.pop();
            }
            self.looks.begin_pass(&self.grid);
        }
    }

    fn strip(
        &mut self,
        from: &FlightSample,
        to: &FlightSample,
        setting: &ScannerSetting,
        ground: &dyn Ground,
        zero_unix_s: f64,
    ) {
        self.begin(to.time_s);
        let terrain = hiding(&self.grid, ground, setting.mode.half_field_rad());
        let (span_s, pieces) = (to.time_s - from.time_s, pieces(from, to));
        let level = || {
            let track_deg = geodesy::azimuth_deg(from.position, to.position);
            Attitude { heading_deg: track_deg, pitch_deg: 0.0, roll_deg: 0.0 }
        };
        let (first, last) = (from.attitude.unwrap_or_else(level), to.attitude.unwrap_or_else(level));
        let rates = AngularRates::between(&first, &last, span_s);
        let half_field_rad = setting.mode.half_field_rad();
        let fallback_m = self.target.elevation_m;
        let line = |share: f64| {
            let attitude = first.interpolate(&last, share);
            let here = between(from, to, share);
            scan_line(here.time_s, here.position, here.altitude_m, &attitude, half_field_rad, ground, fallback_m)
        };
        let mut before = line(0.0);
        for index in 1..=pieces {
            let share = index as f64 / pieces as f64;
            let here = line(share);
            if let (Some(start), Some(end)) = (&before, &here) {
                let middle = first.interpolate(&last, share - 0.5 / pieces as f64);
                let facts = self.facts(from, to, (start, end), middle.roll_deg, rates, setting);
                let sun = self.sun(zero_unix_s + facts.time_s);
                let pixel_rad = setting.mode.pixel_rad();
                let needs = LookNeeds { target: &self.target, centre: self.grid.plane().centre(), zero_unix_s };
                let context = (terrain, Some(&needs));
                if add_between(&mut self.looks, &self.grid, (start, end), pixel_rad, sun, facts, context) {
                    self.last_seen_s = to.time_s;
                }
            }
            before = here;
        }
    }

    fn facts(
        &mut self,
        from: &FlightSample,
        to: &FlightSample,
        lines: (&ScanLine, &ScanLine),
        roll_deg: f64,
        rates: AngularRates,
        setting: &ScannerSetting,
    ) -> StripFacts {
        let height_m = 0.5 * (lines.0.height_m + lines.1.height_m);
        let mut weights = setting.weights(roll_deg, rates, height_m, to.ground_speed_mps);
        if from.attitude.is_none() || to.attitude.is_none() {
            weights.attitude_known = 0.0;
            self.looks.remarks.insert(Remark::AttitudeNotRecorded);
        }
        if setting.mode.scan_rates_hz.is_empty() && setting.scan_rate_hz.is_none() {
            self.looks.remarks.insert(Remark::ScanRateNotKnown);
        }
        weights.clear_share = self.clear_share(to);
        StripFacts { time_s: 0.5 * (lines.0.time_s + lines.1.time_s), weights, is_flown: true, on_ground_s: None }
    }

    fn clear_share(&mut self, sample: &FlightSample) -> f64 {
        if sample.clear_share.is_none() {
            self.looks.remarks.insert(Remark::CloudNotKnown);
        }
        sample.clear_share.unwrap_or(1.0).clamp(0.0, 1.0)
    }

    /// Returns the azimuth and zenith angle of the sun in degrees; `None` for a target without water, where glint does not count.
    fn sun(&self, unix_s: f64) -> Option<(f64, f64)> {
        self.target.is_water.then(|| {
            let sun = solar_position(self.grid.plane().centre(), unix_s);
            (sun.azimuth_deg, 90.0 - sun.elevation_deg)
        })
    }

    fn picture(&mut self, picture: &Picture, ground: &dyn Ground, zero_unix_s: f64) {
        let sample = &picture.sample;
        self.begin(sample.time_s);
        let mut weights = picture.weights;
        if sample.attitude.is_none() {
            weights.attitude_known = 0.0;
            self.looks.remarks.insert(Remark::AttitudeNotRecorded);
        }
        weights.clear_share = self.clear_share(sample);
        let facts = StripFacts { time_s: sample.time_s, weights, is_flown: true, on_ground_s: None };
        let target = (&self.target, &self.grid);
        if add_picture(&mut self.looks, target, &picture.view(), facts, ground, zero_unix_s) {
            self.last_seen_s = sample.time_s;
        }
    }
}

/// Returns the number of pieces into which the strip between two samples is divided, so that a limit of roll is applied where it is
/// crossed.
fn pieces(from: &FlightSample, to: &FlightSample) -> usize {
    let (Some(first), Some(last)) = (from.attitude, to.attitude) else { return 1 };
    if (last.roll_deg - first.roll_deg).abs() <= ROLL_STEP_DEG {
        return 1;
    }
    libm::ceil((to.time_s - from.time_s) / INTERPOLATION_S).clamp(1.0, PIECES_MAX) as usize
}

/// Returns the vehicle between two samples; the path between them is straight, because they are at most a sample gap apart.
fn between(from: &FlightSample, to: &FlightSample, share: f64) -> FlightSample {
    let mix = |a: f64, b: f64| a + share * (b - a);
    let turn_deg = geodesy::wrap_180(to.position.longitude_deg - from.position.longitude_deg);
    FlightSample {
        time_s: mix(from.time_s, to.time_s),
        position: Position {
            latitude_deg: mix(from.position.latitude_deg, to.position.latitude_deg),
            longitude_deg: geodesy::wrap_180(from.position.longitude_deg + share * turn_deg),
        },
        altitude_m: mix(from.altitude_m, to.altitude_m),
        ..*to
    }
}
