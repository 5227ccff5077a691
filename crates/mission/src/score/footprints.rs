//! The ground that the sensors of a flight have seen, for maps: scan lines and outlines of pictures, from the same measurements and
//! geometry as the score. The score itself never reads them.

use super::samples::Latest;
use apex_model::problem::Position;
use apex_model::time::Time;
use apex_observation::attitude::{Attitude, Vector};
use apex_observation::flown::Picture;
use apex_observation::footprint::{FlatGround, hit_flat, offset_position, picture_rays};
use apex_observation::sensor::camera::sight_of;
use apex_observation::strip::{AngularRates, ScannerSetting, scan_line};
use serde::Serialize;

/// Time between two scan lines that are kept, unless the validity changes.
const LINE_STEP_S: f64 = 4.0;

/// A scan line on the ground.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct SeenLine {
    /// Mission time in nanoseconds.
    pub t_ns: i64,
    /// Left end, `[longitude, latitude]` in degrees.
    pub left: [f64; 2],
    /// Right end, `[longitude, latitude]` in degrees.
    pub right: [f64; 2],
    /// True if the line counts: the attitude is known, the roll is within its limits, and no cloud hides the ground.
    pub valid: bool,
}

/// The ground seen from the moment at which the scanner was switched on to the next gap.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Swath {
    /// Scan lines by time. The ground between neighbours is seen.
    pub lines: Vec<SeenLine>,
}

/// The outline of a picture on the ground.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct SeenPicture {
    /// Mission time in nanoseconds of the exposure.
    pub t_ns: i64,
    /// Corners, `[longitude, latitude]` in degrees.
    pub corners: Vec<[f64; 2]>,
}

/// The ground seen in a stretch of a flight.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Footprints {
    /// Swaths of the scanner by time.
    pub swaths: Vec<Swath>,
    /// Pictures by time.
    pub pictures: Vec<SeenPicture>,
}

impl Footprints {
    /// Returns the part within `from_ns ..= to_ns`; it does not depend on later observations.
    pub fn between(&self, from_ns: i64, to_ns: i64) -> Footprints {
        let is_in = |t_ns: i64| (from_ns..=to_ns).contains(&t_ns);
        let cut =
            |swath: &Swath| Swath { lines: swath.lines.iter().filter(|line| is_in(line.t_ns)).copied().collect() };
        Footprints {
            swaths: self.swaths.iter().map(cut).filter(|swath| !swath.lines.is_empty()).collect(),
            pictures: self.pictures.iter().filter(|picture| is_in(picture.t_ns)).cloned().collect(),
        }
    }
}

/// Collects footprints during a flight.
#[derive(Clone, Debug, Default)]
pub(super) struct FootprintLog {
    pub(super) seen: Footprints,
    is_open: bool,
    /// Attitude and validity of the last line, kept or not.
    last: Option<SeenLine>,
}

impl FootprintLog {
    /// Ends the swath: the scanner was switched off, or data are missing for a while.
    pub(super) fn end_swath(&mut self) {
        if let Some(last) = self.last.take()
            && let Some(swath) = self.seen.swaths.last_mut()
            && swath.lines.last().is_some_and(|line| line.t_ns < last.t_ns)
        {
            swath.lines.push(last);
        }
        self.is_open = false;
    }

    /// Records the line that the scanner sees at `at`, over ground of `ground_m` above mean sea level.
    pub(super) fn line(
        &mut self,
        latest: &Latest,
        setting: &ScannerSetting,
        (at, ground_m, gap_s_max): (Time, f64, f64),
    ) {
        let Some((position, altitude_m)) = latest.place else { return };
        let known = latest.attitude(at);
        let attitude = known.unwrap_or(Attitude { heading_deg: 0.0, pitch_deg: 0.0, roll_deg: 0.0 });
        let ground = FlatGround { elevation_m: ground_m };
        let half_field_rad = setting.mode.half_field_rad();
        let line = scan_line(at.seconds(), position, altitude_m, &attitude, half_field_rad, &ground, ground_m);
        let Some(line) = line else { return self.end_swath() };
        let rates = AngularRates::default();
        let weights = setting.weights(attitude.roll_deg, rates, line.height_m, latest.ground_speed_mps(at));
        let seen = SeenLine {
            t_ns: at.0,
            left: pair(line.left),
            right: pair(line.right),
            valid: known.is_some()
                && weights.roll * weights.steady() > 0.0
                && latest.clear_share.is_none_or(|share| share > 0.0),
        };
        if self.last.is_some_and(|last| (at - Time(last.t_ns)).seconds() > gap_s_max) {
            self.end_swath();
        }
        self.keep(seen);
    }

    /// Keeps a line if it is the first one, far enough from the last kept one, or of different validity.
    fn keep(&mut self, seen: SeenLine) {
        if !self.is_open {
            self.is_open = true;
            self.seen.swaths.push(Swath { lines: vec![seen] });
        } else if let Some(swath) = self.seen.swaths.last_mut()
            && let Some(kept) = swath.lines.last().copied()
        {
            let changes = kept.valid != seen.valid;
            if changes && let Some(last) = self.last.filter(|last| last.t_ns > kept.t_ns) {
                swath.lines.push(last);
            }
            if changes || Time(seen.t_ns) - Time(kept.t_ns) >= apex_model::time::Duration::from_seconds(LINE_STEP_S) {
                swath.lines.push(seen);
            }
        }
        self.last = Some(seen);
    }

    /// Records a picture of ground at `ground_m` above mean sea level.
    pub(super) fn picture(&mut self, picture: &Picture, at: Time, ground_m: f64) {
        let sample = &picture.sample;
        let sight = sight_of(&sample.attitude.unwrap_or_default(), picture.angles, picture.is_stabilised);
        let rays: Vec<Vector> =
            picture_rays(sight, picture.horizontal_field_deg.to_radians(), picture.vertical_field_deg.to_radians());
        let corner = |ray: Vector| {
            let hit = hit_flat(ray, sample.altitude_m - ground_m)?;
            Some(pair(offset_position(sample.position, hit.north_m, hit.east_m)))
        };
        let corners: Vec<[f64; 2]> = rays.into_iter().filter_map(corner).collect();
        if corners.len() > 2 {
            self.seen.pictures.push(SeenPicture { t_ns: at.0, corners });
        }
    }
}

fn pair(position: Position) -> [f64; 2] {
    [position.longitude_deg, position.latitude_deg]
}
