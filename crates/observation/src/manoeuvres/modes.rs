//! Modes of flying and recording along a path, each as a value: attitude, speed, payload and data.

use super::craft::Craft;
use super::refusal::{Limit, Refusal, rounded_down, rounded_up};
use super::scene::{Instrument, Scene};
use apex_geo::geodesy::RAD_PER_DEG;
use apex_geo::plane::Point;
use apex_geo::wind::{self, Wind};
use serde::{Deserialize, Serialize};

/// Time between the pictures as which a video is recorded, s.
pub(crate) const VIDEO_S: f64 = 1.0;

/// Direction in which the vehicle faces.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum AttitudeMode {
    /// Nose in the direction of flight through the air; turns are banked.
    Coordinated,
    /// Nose in a fixed direction, clockwise from north.
    Fixed {
        /// The direction.
        heading_deg: f64,
    },
    /// Nose, or the mount of the camera, towards the target.
    Pointing,
}

/// Speed along the path.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SpeedProfile {
    /// A constant true airspeed, in m/s.
    Airspeed(f64),
    /// A constant ground speed, in m/s.
    GroundSpeed(f64),
    /// As fast as the camera takes pictures that overlap by this share, no faster than cruise.
    Overlap(f64),
    /// This ground speed, in m/s, slower where the mount could not follow the target: `min(v, rate h / sin^2 beta)`, with `beta` the angle
    /// of the line of sight below the horizon.
    SlowAtClosest(f64),
    /// The speed at which pictures smear by this many pixels, at most cruise speed.
    Smear(f64),
}

/// Recording by the payload.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PayloadUse {
    /// Pictures by distance over ground, in metres.
    StillsEvery(f64),
    /// Pictures by time, in seconds.
    StillsInterval(f64),
    /// Video: on for all of the observed part.
    Video,
    /// Scan lines: on for the observed part, valid while the wings are level.
    LineScan,
}

/// Handling of the data.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum DataHandling {
    /// Stored on board and read after landing.
    Store,
    /// Sent while it is recorded; needs a link that carries pictures as fast as they are taken.
    Stream {
        /// Size of a picture.
        picture_bit: f64,
        /// Rate that the link carries.
        link_bit_s: f64,
    },
    /// Each picture is processed on board, and its product is sent.
    Process {
        /// Processing time of a picture.
        delay_s: f64,
        /// Size of the product of a picture.
        product_bit: f64,
        /// Rate that the link carries.
        link_bit_s: f64,
    },
}

impl DataHandling {
    /// Returns the instants at which pictures taken at these instants, in order, are on the ground: they are sent in sequence, each
    /// when it is ready and the link is free. `None` if they are stored until landing.
    pub fn arrivals_s(&self, taken_s: impl IntoIterator<Item = f64>) -> Option<Vec<f64>> {
        let (delay_s, sending_s) = match self {
            DataHandling::Store => return None,
            DataHandling::Stream { picture_bit, link_bit_s } => (0.0, picture_bit / link_bit_s),
            DataHandling::Process { delay_s, product_bit, link_bit_s } => (*delay_s, product_bit / link_bit_s),
        };
        let mut free_s = f64::NEG_INFINITY;
        let arrival_s = |taken_s: f64| {
            free_s = free_s.max(taken_s + delay_s) + sending_s;
            free_s
        };
        Some(taken_s.into_iter().map(arrival_s).collect())
    }

    /// Rejects a link that does not carry pictures which are taken every `interval_s`; `None` if they are not taken at regular intervals.
    pub(crate) fn check(&self, manoeuvre: &str, interval_s: Option<f64>) -> Result<(), Refusal> {
        let (DataHandling::Stream { picture_bit, link_bit_s }, Some(interval_s)) = (self, interval_s) else {
            return Ok(());
        };
        let limit = Limit { manoeuvre, figure: "a data rate", unit: "bit/s" };
        limit.at_most(picture_bit / interval_s, *link_bit_s, "the link cannot carry more data", || {
            let works_s = rounded_up(picture_bit / link_bit_s, 1);
            format!("take a picture every {works_s} s, store the data, or process it on board")
        })
    }
}

impl AttitudeMode {
    /// Returns the direction of the nose in degrees clockwise from north, at a point relative to the target, for a track, a ground speed
    /// and the wind of the scene.
    pub(crate) fn heading_deg(&self, here: Point, (track_deg, ground_speed_mps): (f64, f64), scene: &Scene) -> f64 {
        match self {
            AttitudeMode::Coordinated => {
                let track_rad = track_deg * RAD_PER_DEG;
                let air = (
                    ground_speed_mps * libm::sin(track_rad) - scene.wind.east_mps,
                    ground_speed_mps * libm::cos(track_rad) - scene.wind.north_mps,
                );
                if libm::hypot(air.0, air.1) < 0.5 { track_deg } else { libm::atan2(air.0, air.1) / RAD_PER_DEG }
            }
            AttitudeMode::Fixed { heading_deg } => *heading_deg,
            AttitudeMode::Pointing if here.length() < 1e-6 => track_deg,
            AttitudeMode::Pointing => libm::atan2(-here.x, -here.y) / RAD_PER_DEG,
        }
    }

    /// Rejects a nose direction other than that of flight for a vehicle that cannot fly so.
    pub(crate) fn check(&self, manoeuvre: &str, craft: &Craft, instrument: &Instrument) -> Result<(), Refusal> {
        let is_free = craft.can_hover || matches!(self, AttitudeMode::Coordinated);
        let by_mount = matches!(self, AttitudeMode::Pointing) && instrument.pans();
        if is_free || by_mount {
            return Ok(());
        }
        let limit = Limit { manoeuvre, figure: "a pan range", unit: "degrees" };
        let because = format!("{} cannot turn its nose away from its course, and its sensor does not pan", craft.name);
        let nearest = match self {
            AttitudeMode::Fixed { .. } => "fly it coordinated",
            _ => "fly it coordinated, or with a camera that pans",
        };
        Err(limit.refusal(0.0, 90.0, &because, nearest.to_string()))
    }
}

impl SpeedProfile {
    /// Returns the ground speed on a track at a height over the target's level and a horizontal distance from the target.
    ///
    /// # Errors
    /// If the wind is too strong for the track, or the speed is outside of the vehicle's range.
    pub(crate) fn ground_speed_mps(
        &self,
        (manoeuvre, track_deg): (&str, f64),
        (height_m, distance_m): (f64, f64),
        craft: &Craft,
        instrument: &Instrument,
        wind: Wind,
    ) -> Result<f64, Refusal> {
        let at_airspeed = |airspeed_mps: f64| {
            wind::triangle(track_deg, airspeed_mps, wind).map(|triangle| triangle.ground_speed_mps).ok_or_else(|| {
                let wind_mps = libm::hypot(wind.east_mps, wind.north_mps);
                let limit = Limit { manoeuvre, figure: "a wind", unit: "m/s" };
                let because =
                    format!("at {airspeed_mps:.1} m/s {} makes no progress along {track_deg:.0} degrees", craft.name);
                limit.refusal(wind_mps, airspeed_mps, &because, "wait for less wind, or fly faster".to_string())
            })
        };
        let cruise = || at_airspeed(craft.true_airspeed_mps);
        let wanted_mps = match self {
            SpeedProfile::Airspeed(airspeed_mps) => at_airspeed(*airspeed_mps)?,
            SpeedProfile::GroundSpeed(speed_mps) => *speed_mps,
            SpeedProfile::Overlap(overlap) => instrument.overlap_speed_mps(height_m, *overlap).min(cruise()?),
            SpeedProfile::SlowAtClosest(speed_mps) => {
                let squared = height_m * height_m + distance_m * distance_m;
                let rate = instrument.slew_rate_deg_s() * RAD_PER_DEG;
                speed_mps.min(rate * squared / height_m.max(0.1))
            }
            SpeedProfile::Smear(pixels) => {
                instrument.smear_speed_mps(libm::hypot(height_m, distance_m), *pixels).min(cruise()?)
            }
        };
        // A fixed wing cannot fly slower than its least speed, whatever the profile requests.
        let slowest_mps = if craft.can_hover { 0.0 } else { at_airspeed(craft.true_airspeed_mps_min).unwrap_or(0.0) };
        let wanted_mps = wanted_mps.max(slowest_mps);
        let is_airspeed = matches!(self, SpeedProfile::Airspeed(_));
        check_airspeed(manoeuvre, track_deg, (wanted_mps, is_airspeed), craft, wind)?;
        Ok(wanted_mps)
    }

    /// Returns the airspeed at which turns between observed parts are flown.
    pub(crate) fn turn_airspeed_mps(&self, craft: &Craft) -> f64 {
        match self {
            SpeedProfile::Airspeed(airspeed_mps) => *airspeed_mps,
            _ => craft.true_airspeed_mps,
        }
    }
}

/// Rejects a ground speed whose airspeed is outside of the vehicle's range, with a speed that works in the terms of the request.
fn check_airspeed(
    manoeuvre: &str,
    track_deg: f64,
    (speed_mps, is_airspeed): (f64, bool),
    craft: &Craft,
    wind: Wind,
) -> Result<(), Refusal> {
    let airspeed_mps = airspeed_of(track_deg, speed_mps, wind);
    let limit = Limit { manoeuvre, figure: "a true airspeed", unit: "m/s" };
    let (low, high) = (craft.true_airspeed_mps_min, craft.true_airspeed_mps_max);
    // A ground speed that is possible in every direction: a path turns.
    let wind_mps = if is_airspeed { 0.0 } else { libm::hypot(wind.east_mps, wind.north_mps) };
    let (least, most) = (rounded_up(low + wind_mps, 1), rounded_down(high - wind_mps, 1));
    let works = |speed: &str| match low + wind_mps < high - wind_mps - 0.2 {
        true if is_airspeed => format!("{speed} m/s works"),
        true => format!("a ground speed of {speed} m/s works in this wind"),
        false => "wait for less wind".to_string(),
    };
    let slower = format!("{} cannot fly slower", craft.name);
    limit.at_least(airspeed_mps + 1e-6, low, &slower, || works(&least))?;
    limit.at_most(airspeed_mps - 1e-6, high, &format!("{} cannot fly faster", craft.name), || works(&most))
}

/// Returns the true airspeed of a ground speed along a track.
pub(crate) fn airspeed_of(track_deg: f64, speed_mps: f64, wind: Wind) -> f64 {
    let track_rad = track_deg * RAD_PER_DEG;
    libm::hypot(speed_mps * libm::sin(track_rad) - wind.east_mps, speed_mps * libm::cos(track_rad) - wind.north_mps)
}

impl PayloadUse {
    /// Returns the time between pictures at a ground speed; `None` if they are not taken at regular intervals.
    pub(crate) fn interval_s(&self, ground_speed_mps: f64, instrument: &Instrument) -> Option<f64> {
        let Instrument::Camera(camera) = instrument else { return None };
        match self {
            PayloadUse::StillsEvery(_) if ground_speed_mps < 0.05 => None,
            PayloadUse::StillsEvery(every_m) => Some((every_m / ground_speed_mps).max(camera.interval_s_min)),
            PayloadUse::StillsInterval(interval_s) => Some(interval_s.max(camera.interval_s_min)),
            PayloadUse::Video => Some(VIDEO_S),
            PayloadUse::LineScan => None,
        }
    }

    /// Rejects a payload that the sensor does not record, and one that cannot be used on the path.
    pub(crate) fn check(
        &self,
        (manoeuvre, curve_radius_m): (&str, Option<f64>),
        craft: &Craft,
        instrument: &Instrument,
    ) -> Result<(), Refusal> {
        let fits = matches!((self, instrument), (PayloadUse::LineScan, Instrument::Scanner(_)))
            || !matches!(self, PayloadUse::LineScan) && matches!(instrument, Instrument::Camera(_));
        if !fits {
            let limit = Limit { manoeuvre, figure: "a sensor count", unit: "" };
            let (because, nearest) = match self {
                PayloadUse::LineScan => {
                    ("line scanning needs a line scanner", "record stills or video with the camera")
                }
                _ => ("pictures need a camera", "record scan lines with the scanner"),
            };
            return Err(limit.refusal(0.0, 1.0, because, nearest.to_string()));
        }
        if let (PayloadUse::LineScan, Instrument::Scanner(scanner), false) = (self, instrument, craft.can_hover) {
            let limits = scanner.setting.roll;
            if let (Some(roll), Some(radius_m)) = (limits, curve_radius_m) {
                let bank_deg = super::craft::circle_bank_deg(craft.true_airspeed_mps, radius_m, 0.0);
                let least_m = craft.true_airspeed_mps * craft.true_airspeed_mps
                    / (super::craft::GRAVITY_MPS2 * libm::tan(roll.valid_deg * RAD_PER_DEG));
                let limit = Limit { manoeuvre, figure: "a bank", unit: "degrees" };
                limit.at_most(
                    bank_deg,
                    roll.valid_deg,
                    "lines of the scanner are valid only with the wings level",
                    || format!("a radius of {} m works, or a sweep", rounded_up(least_m, 0)),
                )?;
            }
        }
        Ok(())
    }
}
