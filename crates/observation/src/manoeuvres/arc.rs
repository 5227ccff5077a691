//! Arc over the target with tilt tracking: at the tilt limit of the camera the vehicle slows, turns by 180 degrees and continues tail
//! first (the paper's example 3).
//!
//! Either an arch of constant distance in a vertical plane, or a level pass. `beta` is the elevation angle of the vehicle as seen from
//! the target; the camera is depressed by that angle, so a mount with a limit of -90 degrees reaches it overhead.

use super::refusal::{Limit, Refusal, positive, rounded_down};
use super::scene::{Scene, along};
use super::track::{Element, Sight, Track, TrackPoint};
use super::{Craft, Instrument};
use apex_geo::geodesy::RAD_PER_DEG;
use serde::{Deserialize, Serialize};

/// The shape of the path in its vertical plane.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ArcShape {
    /// Constant distance from the target.
    Arch {
        /// The distance.
        radius_m: f64,
    },
    /// Constant height above the target.
    Level {
        /// The height.
        height_m: f64,
    },
}

/// A path over the target that keeps it in view of a camera that only tilts.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Arc {
    /// Direction of motion, clockwise from north.
    pub azimuth_deg: f64,
    /// Shape.
    pub shape: ArcShape,
    /// Elevation angle at its beginning, and at its end on the other side.
    pub from_elevation_deg: f64,
    /// Speed on the path.
    pub speed_mps: f64,
    /// Speed while the vehicle turns.
    pub turn_speed_mps: f64,
    /// Rate at which it turns.
    pub yaw_rate_deg_s: f64,
    /// Change of speed before and after the turn.
    pub acceleration_mps2: f64,
}

/// Figures of an arc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArcFigures {
    /// Length of the path.
    pub length_m: f64,
    /// Time from end to end, both passed at `speed_mps`, with the braking, the turn and the acceleration between them.
    pub time_s: f64,
    /// Greatest tilt rate.
    pub tilt_rate_deg_s: f64,
    /// Distance flown while turning.
    pub turn_drift_m: f64,
    /// The drift during the turn as an angle seen from the target.
    pub turn_drift_deg: f64,
    /// Share of the path on which the target is in view, including the turn.
    pub tracked_share: f64,
    /// Share of the path in view without the turn, for a tilt limit of -90 degrees.
    pub tracked_share_without_turn: f64,
}

impl Arc {
    /// Name in PDL.
    pub const NAME: &'static str = "arc";
    /// Angle of a piece of the path as seen from the target.
    const STEP_DEG: f64 = 2.0;

    /// Returns the elevation angle at which the tilt limit is reached with a body pitch: `90 - theta - |tau_min + 90|`.
    pub fn limit_elevation_deg(tilt_deg_min: f64, pitch_deg: f64) -> f64 {
        90.0 - pitch_deg - (tilt_deg_min + 90.0).abs()
    }

    /// Returns the distance from the target to the path at an elevation angle.
    fn slant_m(&self, elevation_deg: f64) -> f64 {
        match self.shape {
            ArcShape::Arch { radius_m } => radius_m,
            ArcShape::Level { height_m } => height_m / libm::sin(elevation_deg * RAD_PER_DEG),
        }
    }

    /// Returns the least distance from the target: overhead.
    pub fn overhead_m(&self) -> f64 {
        self.slant_m(90.0)
    }

    /// Returns the figures for a camera with this vertical field of view.
    pub fn figures(&self, vertical_field_deg: f64) -> ArcFigures {
        let Arc { speed_mps: v, turn_speed_mps: slow, acceleration_mps2: a, .. } = *self;
        let sweep_rad = (180.0 - 2.0 * self.from_elevation_deg) * RAD_PER_DEG;
        let length_m = match self.shape {
            ArcShape::Arch { radius_m } => radius_m * sweep_rad,
            ArcShape::Level { height_m } => 2.0 * height_m / libm::tan(self.from_elevation_deg * RAD_PER_DEG),
        };
        let turn_s = 180.0 / self.yaw_rate_deg_s;
        let turn_drift_m = slow * turn_s;
        let changing_m = (v * v - slow * slow) / a;
        let time_s = 2.0 * (v - slow) / a + turn_s + (length_m - changing_m - turn_drift_m) / v;
        let overhead_m = self.overhead_m();
        let turn_drift_deg = turn_drift_m / overhead_m / RAD_PER_DEG;
        // Overhead, where the tilt rate is greatest, a level pass is flown slowly.
        let tilt_rate = match self.shape {
            ArcShape::Arch { radius_m } => v / radius_m,
            ArcShape::Level { .. } => self.level_tilt_rate_rad_s(),
        };
        let lost = (turn_drift_deg - vertical_field_deg).max(0.0) / (sweep_rad / RAD_PER_DEG);
        ArcFigures {
            length_m,
            time_s,
            tilt_rate_deg_s: tilt_rate / RAD_PER_DEG,
            turn_drift_m,
            turn_drift_deg,
            tracked_share: 1.0 - lost,
            tracked_share_without_turn: 0.5,
        }
    }

    /// Returns the greatest tilt rate of a level pass: `v sin^2 beta / h`, with the speed on the braked part.
    fn level_tilt_rate_rad_s(&self) -> f64 {
        let overhead_m = self.overhead_m();
        let rate = |distance_m: f64| {
            self.speed_at(distance_m) * overhead_m / (overhead_m * overhead_m + distance_m * distance_m)
        };
        (0..=200).map(|step| rate(f64::from(step) * 0.01 * self.half_length_m())).fold(0.0, f64::max)
    }

    fn half_length_m(&self) -> f64 {
        match self.shape {
            ArcShape::Arch { radius_m } => radius_m * (90.0 - self.from_elevation_deg) * RAD_PER_DEG,
            ArcShape::Level { height_m } => height_m / libm::tan(self.from_elevation_deg * RAD_PER_DEG),
        }
    }

    /// Returns the speed at a distance along the path from overhead: slow while turning, and as fast as the braking permits elsewhere.
    pub fn speed_at(&self, distance_m: f64) -> f64 {
        let turning_m = 0.5 * self.turn_speed_mps * 180.0 / self.yaw_rate_deg_s + 1e-9;
        let beyond_m = (distance_m.abs() - turning_m).max(0.0);
        let slow = self.turn_speed_mps;
        libm::sqrt(slow * slow + 2.0 * self.acceleration_mps2 * beyond_m).min(self.speed_mps)
    }

    /// Returns the distances from overhead of the points of the path, including the ends of the slow part.
    fn distances_m(&self) -> Vec<f64> {
        let (half_m, turning_m) = (self.half_length_m(), 0.5 * self.turn_speed_mps * 180.0 / self.yaw_rate_deg_s);
        let step_m = Self::STEP_DEG * RAD_PER_DEG * self.overhead_m();
        let near_m = turning_m.min(half_m);
        let count = (libm::ceil((half_m - near_m) / step_m) as usize).max(1);
        let part = |index: usize| near_m + (half_m - near_m) * index as f64 / count as f64;
        let ahead: Vec<f64> = (0..=count).map(part).collect();
        ahead.iter().rev().map(|along_m| -along_m).chain(ahead.iter().copied()).collect()
    }

    pub(crate) fn check(&self, craft: &Craft, instrument: &Instrument, scene: &Scene) -> Result<(), Refusal> {
        let limit = |figure, unit| Limit { manoeuvre: Self::NAME, figure, unit };
        positive(Self::NAME, "a distance", "m", self.overhead_m())?;
        positive(Self::NAME, "a speed", "m/s", self.speed_mps)?;
        positive(Self::NAME, "a turning speed", "m/s", self.turn_speed_mps)?;
        positive(Self::NAME, "an acceleration", "m/s2", self.acceleration_mps2)?;
        positive(Self::NAME, "a yaw rate", "deg/s", self.yaw_rate_deg_s)?;
        let elevation = limit("an elevation angle", "degrees");
        let low = || "30 degrees works".to_string();
        elevation.at_least(self.from_elevation_deg, 5.0, "the camera would see the target at too low an angle", low)?;
        elevation.at_most(self.from_elevation_deg, 85.0, "the arc would have almost no length", low)?;
        if !craft.can_hover {
            let because = format!("{} cannot turn in place and fly tail first", craft.name);
            let nearest = match instrument {
                Instrument::Camera(_) if !instrument.pans() => "fly straight over in two passes",
                _ => "fly straight over in two passes, or orbit",
            };
            let nearest = nearest.to_string();
            return Err(limit("a slowest airspeed", "m/s").refusal(
                craft.true_airspeed_mps_min,
                0.0,
                &because,
                nearest,
            ));
        }
        let most = craft.acceleration_mps2.min(craft.braking_mps2);
        let because = format!("{} cannot change its speed faster", craft.name);
        limit("an acceleration", "m/s2")
            .at_most(self.acceleration_mps2, most, &because, || format!("{} m/s2 works", rounded_down(most, 1)))?;
        let yaw = limit("a yaw rate", "deg/s");
        let most = craft.yaw_rate_deg_s;
        yaw.at_most(self.yaw_rate_deg_s, most, &format!("{} cannot turn its nose faster", craft.name), || {
            format!("{} deg/s works", rounded_down(most, 0))
        })?;
        self.check_climb(craft)?;
        self.check_tilt_rate(instrument)?;
        self.check_wind(craft, scene)
    }

    fn check_climb(&self, craft: &Craft) -> Result<(), Refusal> {
        let ArcShape::Arch { .. } = self.shape else { return Ok(()) };
        let share = libm::cos(self.from_elevation_deg * RAD_PER_DEG);
        let most = craft.climb_mps_max.min(craft.descent_mps_max);
        let limit = Limit { manoeuvre: Self::NAME, figure: "a climb", unit: "m/s" };
        limit.at_most(self.speed_mps * share, most, &format!("{} cannot climb or descend faster", craft.name), || {
            format!("a speed of {} m/s works, or a level pass", rounded_down(most / share, 1))
        })
    }

    fn check_tilt_rate(&self, instrument: &Instrument) -> Result<(), Refusal> {
        let Instrument::Camera(camera) = instrument else {
            let limit = Limit { manoeuvre: Self::NAME, figure: "a tilt range", unit: "degrees" };
            let because = "a line scanner does not tilt";
            return Err(limit.refusal(0.0, 90.0, because, "use a camera, or fly straight over".to_string()));
        };
        let limit = |figure, unit| Limit { manoeuvre: Self::NAME, figure, unit };
        let figures = self.figures(camera.high_deg);
        let most = camera.mount.rate_deg_s;
        limit("a tilt rate", "deg/s").at_most(figures.tilt_rate_deg_s, most, "the mount cannot tilt faster", || {
            format!("a speed of {} m/s works", rounded_down(self.speed_mps * most / figures.tilt_rate_deg_s, 1))
        })?;
        let drift = limit("an angle flown while turning", "degrees");
        drift.at_most(figures.turn_drift_deg, camera.high_deg, "the target leaves the picture", || {
            let slower = self.turn_speed_mps * camera.high_deg / figures.turn_drift_deg;
            format!("a turning speed of {} m/s works", rounded_down(slower, 1))
        })
    }

    /// Rejects a wind that is too strong for the second half, flown tail first (`|v - w_along| <= rearward limit`), or to the side.
    fn check_wind(&self, craft: &Craft, scene: &Scene) -> Result<(), Refusal> {
        let axis = along(self.azimuth_deg, 1.0);
        let tail = scene.wind.east_mps * axis.x + scene.wind.north_mps * axis.y;
        let across = (scene.wind.east_mps * axis.y - scene.wind.north_mps * axis.x).abs();
        let rearward = Limit { manoeuvre: Self::NAME, figure: "an airspeed tail first", unit: "m/s" };
        let because = format!("{} cannot fly faster tail first", craft.name);
        rearward.at_most((self.speed_mps - tail).abs(), craft.rearward_mps_max, &because, || {
            let (fastest_mps, from) = (craft.rearward_mps_max + tail, scene.wind_from_deg());
            let with_wind = from.map(|from| {
                let towards_deg = apex_geo::geodesy::wrap_360(from + 180.0);
                format!("a motion towards {towards_deg:.0} degrees, with the wind")
            });
            let slower = (fastest_mps > 0.0).then(|| format!("a speed of {} m/s works", rounded_down(fastest_mps, 1)));
            [slower, with_wind].into_iter().flatten().collect::<Vec<_>>().join(", or ")
        })?;
        let sideways = Limit { manoeuvre: Self::NAME, figure: "a crosswind", unit: "m/s" };
        let because = format!("{} cannot hold its position in a stronger crosswind", craft.name);
        sideways
            .at_most(across, craft.sideways_mps_max, &because, || "turn the plane of the arc into the wind".to_string())
    }

    pub(crate) fn track(
        &self,
        _: f64,
        craft: &Craft,
        instrument: &Instrument,
        scene: &Scene,
    ) -> Result<Track, Refusal> {
        self.check(craft, instrument, scene)?;
        let point = |along_m: f64| {
            let (ahead_m, height_m) = match self.shape {
                ArcShape::Arch { radius_m } => {
                    let angle_rad = along_m / radius_m;
                    (radius_m * libm::sin(angle_rad), radius_m * libm::cos(angle_rad))
                }
                ArcShape::Level { height_m } => (along_m, height_m),
            };
            TrackPoint { point: along(self.azimuth_deg, ahead_m), height_m, speed_mps_max: self.speed_at(along_m) }
        };
        let points = self.distances_m().into_iter().map(point).collect();
        Ok(Track { elements: vec![Element::Follow { points, is_observed: true }], sight: Sight::Target })
    }
}
