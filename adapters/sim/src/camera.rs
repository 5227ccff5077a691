//! A camera on a tilt, or tilt and pan, mount: power-up, pointing and tracking, taking pictures.
//!
//! The mount is stabilised: tilt is measured from the horizon (straight down is -90 deg) and pan from the heading, independently of the
//! roll. Pointing is judged by the angle between the sight line and the target, never by tilt and pan alone, because pan is meaningless
//! straight down.

use crate::arguments::{PictureStep, Spot};
use crate::living::downlink::DataOrder;
use crate::motion::{State, wrap_pi};
use crate::path::bearing;
use apex_geo::geodesy::RAD_PER_DEG;
use apex_model::effect::CommandId;
use apex_model::time::Time;
use apex_model::value::Value;
use apex_vehicle::CameraModel;
use libm::{atan2, cos, sin, sqrt};
use std::f64::consts::FRAC_PI_2;

/// The sight line is on the target within this share of the field of view, but never needs to be closer than the angle below.
const ALIGNED_SHARE_OF_VIEW: f64 = 0.05;
const ALIGNED_RAD_MIN: f64 = 0.001;
/// The camera must be aligned for this long before pointing is acknowledged: usual settling time of stabilised mounts.
const SETTLE_S: f64 = 0.4;
/// A slew that has not ended this long after its expected end has failed.
const SLEW_MARGIN_S: f64 = 2.0;
/// Within this angle from straight down, or a quarter of the field of view if that is less, pan is held.
const NADIR_CONE_RAD: f64 = 3.0 * RAD_PER_DEG;
/// A tilt beyond the limits of the mount by less than this counts as inside, because the limits are rounded.
const LIMIT_RAD: f64 = 1e-3;

/// The activity of a camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CameraState {
    Off,
    PoweringUp,
    Ready,
    Slewing,
    Pointing,
    Exposing,
}

impl CameraState {
    /// Returns the published word.
    pub(crate) fn word(self) -> &'static str {
        match self {
            CameraState::Off => "off",
            CameraState::PoweringUp => "powering-up",
            CameraState::Ready => "ready",
            CameraState::Slewing => "slewing",
            CameraState::Pointing => "pointing",
            CameraState::Exposing => "exposing",
        }
    }
}

/// The object at which a camera points.
#[derive(Clone, Debug)]
pub(crate) enum Aim {
    /// Straight down, rows of the picture across the heading.
    Down,
    /// A place at this altitude.
    At(Spot, f64),
    /// A fixed direction.
    Along(FixedDirection),
}

/// A direction that does not depend on where the camera is.
#[derive(Clone, Debug)]
pub(crate) struct FixedDirection {
    /// Clockwise from north.
    pub(crate) azimuth_rad: f64,
    /// Above the horizon; negative below it.
    pub(crate) tilt_rad: f64,
    /// As written, for the answer.
    pub(crate) given: Value,
}

impl Aim {
    /// Returns the aim as given in the command.
    pub(crate) fn given(&self) -> Value {
        match self {
            Aim::Down => Value::symbol(DOWN),
            Aim::At(spot, _) => spot.given.clone(),
            Aim::Along(direction) => direction.given.clone(),
        }
    }
}

/// The word of commands and events for [`Aim::Down`].
pub(crate) const DOWN: &str = "down";

/// A series of pictures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PictureRun {
    pub(crate) step: PictureStep,
    /// Distance flown since the last picture was due.
    pub(crate) flown_m: f64,
    /// Time since the last picture was due, s.
    pub(crate) waited_s: f64,
    /// Instant of the last picture.
    pub(crate) last: Option<Time>,
}

/// One camera.
#[derive(Clone, Debug)]
pub(crate) struct Camera {
    pub(crate) model: CameraModel,
    pub(crate) state: CameraState,
    pub(crate) tilt_rad: f64,
    pub(crate) pan_rad: f64,
    pub(crate) aim: Option<Aim>,
    /// The command that the camera is executing.
    pub(crate) command: Option<CommandId>,
    /// End of power-up or exposure.
    pub(crate) timer: Option<Time>,
    /// Instant from which the slew in progress counts as failed.
    pub(crate) slew_until: Option<Time>,
    /// The present series of pictures.
    pub(crate) run: Option<PictureRun>,
    /// Handling of the pictures of the present command; `None`: that of the world.
    pub(crate) data: Option<DataOrder>,
    /// Pictures that the present command still requires after the one in progress.
    pub(crate) pictures_left: u32,
    /// Time for which the sight line has been on the target without a break.
    aligned_s: f64,
    /// Angle between the sight line and the target.
    pub(crate) error_rad: f64,
    /// The mount is stuck and does not move.
    pub(crate) stuck: bool,
    /// True while the camera delivers no images.
    pub(crate) broken: bool,
}

/// Result of one pointing step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Pointing {
    Same,
    Aligned,
    OutOfView,
}

/// Direction of the target seen from the camera: forward (along the heading), right and down.
#[derive(Clone, Copy, Debug)]
struct TargetDirection {
    forward: f64,
    right: f64,
    down: f64,
}

impl TargetDirection {
    /// Returns the direction of a sight line with this tilt and pan.
    fn of(tilt_rad: f64, pan_rad: f64) -> TargetDirection {
        let level = cos(tilt_rad);
        TargetDirection { forward: level * cos(pan_rad), right: level * sin(pan_rad), down: -sin(tilt_rad) }
    }

    /// Returns the angle between two directions; zero if one has no length.
    fn angle_rad(self, other: TargetDirection) -> f64 {
        let along = self.forward * other.forward + self.right * other.right + self.down * other.down;
        let (x, y, z) = (
            self.right * other.down - self.down * other.right,
            self.down * other.forward - self.forward * other.down,
            self.forward * other.right - self.right * other.forward,
        );
        atan2(sqrt(x * x + y * y + z * z), along)
    }
}

/// Mount angles that point at a target, and the angle that then remains between sight line and target.
#[derive(Clone, Copy, Debug)]
struct Angles {
    tilt_rad: f64,
    pan_rad: f64,
    /// Angle between sight line and target at this tilt and pan.
    left_rad: f64,
}

impl Camera {
    pub(crate) fn new(model: CameraModel) -> Camera {
        Camera {
            model,
            state: CameraState::Off,
            tilt_rad: 0.0,
            pan_rad: 0.0,
            aim: None,
            command: None,
            timer: None,
            slew_until: None,
            run: None,
            data: None,
            pictures_left: 0,
            aligned_s: 0.0,
            error_rad: 0.0,
            stuck: false,
            broken: false,
        }
    }

    /// Returns true if the camera is powered and its power-up is over.
    pub(crate) fn is_ready(&self) -> bool {
        !matches!(self.state, CameraState::Off | CameraState::PoweringUp)
    }

    /// Returns true while the pointing affects the recorded view: the camera points, or takes a picture.
    pub(crate) fn is_looking(&self) -> bool {
        matches!(self.state, CameraState::Slewing | CameraState::Pointing | CameraState::Exposing)
    }

    /// Returns the heading at which this mount sees its target; `None` if the mount pans, or if the target is so near the nadir that the
    /// picture contains it at any heading.
    pub(crate) fn nose_rad(&self, state: &State) -> Option<f64> {
        let (spot, altitude_m) = match self.aim.as_ref().filter(|_| !self.pans())? {
            Aim::Down => return None,
            Aim::Along(direction) => return Some(direction.azimuth_rad),
            Aim::At(spot, altitude_m) => (spot, altitude_m),
        };
        let (azimuth_rad, distance_m) = bearing(state.position, spot.position);
        let below_m = state.altitude_m - altitude_m;
        let off_nadir_rad = atan2(distance_m, below_m);
        (distance_m > 1.0 && off_nadir_rad > self.nadir_cone_rad()).then_some(azimuth_rad)
    }

    fn pans(&self) -> bool {
        self.model.pan_deg_max > 0.0
    }

    fn half_view_rad(&self) -> f64 {
        0.5 * self.model.field_of_view_deg * RAD_PER_DEG
    }

    fn nadir_cone_rad(&self) -> f64 {
        NADIR_CONE_RAD.min(0.5 * self.half_view_rad())
    }

    /// Returns the greatest angle between sight line and target at which the camera counts as pointing at the target.
    fn tolerance_rad(&self) -> f64 {
        (ALIGNED_SHARE_OF_VIEW * self.model.field_of_view_deg * RAD_PER_DEG).max(ALIGNED_RAD_MIN)
    }

    /// Returns the permitted angle to the target for a mount that cannot move closer. A tilt-only mount has the target in the picture but
    /// not at its centre; near the nadir the pan is held.
    fn left_rad_max(&self, sight: TargetDirection) -> f64 {
        if !self.pans() {
            return self.half_view_rad();
        }
        let nadir = TargetDirection { forward: 0.0, right: 0.0, down: 1.0 }.angle_rad(sight) < self.nadir_cone_rad();
        if nadir { self.tolerance_rad().max(self.nadir_cone_rad()) } else { self.tolerance_rad() }
    }

    /// Returns the reason if the mount cannot see `aim` from here at any attitude of the aircraft.
    pub(crate) fn refusal(&self, aim: &Aim, state: &State) -> Option<String> {
        let elevation_deg = match aim {
            Aim::Down => -90.0,
            Aim::At(spot, altitude_m) => {
                let (_, distance_m) = bearing(state.position, spot.position);
                atan2(altitude_m - state.altitude_m, distance_m.max(0.1)) / RAD_PER_DEG
            }
            Aim::Along(direction) => direction.tilt_rad / RAD_PER_DEG,
        };
        let (low, high) = (self.model.tilt_deg_min, self.model.tilt_deg_max);
        let outside = elevation_deg > high || elevation_deg < low - 1.0;
        let name = &self.model.name;
        let works = match () {
            () if low >= high => "fly over the target, and point the camera down",
            () if elevation_deg > high => "fly higher, or nearer to the target",
            () => "fly lower, or farther away from the target",
        };
        outside.then(|| {
            format!(
                "{name} tilts from {low} to {high} degrees and the target is at {elevation_deg:.0} degrees; {works}"
            )
        })
    }

    /// Returns the direction of the target.
    fn sight(aim: &Aim, state: &State) -> TargetDirection {
        let (spot, altitude_m) = match aim {
            Aim::Down => return TargetDirection { forward: 0.0, right: 0.0, down: 1.0 },
            Aim::Along(direction) => {
                return TargetDirection::of(direction.tilt_rad, direction.azimuth_rad - state.heading_rad);
            }
            Aim::At(spot, altitude_m) => (spot, altitude_m),
        };
        let (azimuth_rad, distance_m) = bearing(state.position, spot.position);
        let relative = azimuth_rad - state.heading_rad;
        let down = state.altitude_m - altitude_m;
        TargetDirection { forward: distance_m * cos(relative), right: distance_m * sin(relative), down }
    }

    /// Returns the tilt and pan, within the limits of the mount, that bring the sight line closest to the target.
    fn angles(&self, sight: TargetDirection) -> Angles {
        let pan_max = self.model.pan_deg_max * RAD_PER_DEG;
        let level = sqrt(sight.forward * sight.forward + sight.right * sight.right);
        let near_nadir = atan2(level, sight.down) < self.nadir_cone_rad();
        let is_down = matches!(self.aim, Some(Aim::Down));
        let pan_rad = match (self.pans(), near_nadir) {
            (false, _) => 0.0,
            // Pictures have their rows across the heading. The mount turns when time permits, and its sight line stays in place.
            (true, true) if is_down => 0.0,
            (true, true) => self.pan_rad,
            (true, false) => atan2(sight.right, sight.forward).clamp(-pan_max, pan_max),
        };
        // The tilt is in the vertical plane of the pan. A target behind the mount needs a tilt beyond straight down.
        let ahead = sight.forward * cos(pan_rad) + sight.right * sin(pan_rad);
        let wanted = -atan2(sight.down, ahead);
        let (low, high) = (self.model.tilt_deg_min * RAD_PER_DEG, self.model.tilt_deg_max * RAD_PER_DEG);
        // Behind and above: the nearer limit is the highest tilt, not the lowest.
        let wanted = if wanted > FRAC_PI_2 { high } else { wanted };
        let tilt_rad = wanted.clamp(low - LIMIT_RAD, high + LIMIT_RAD);
        Angles { tilt_rad, pan_rad, left_rad: TargetDirection::of(tilt_rad, pan_rad).angle_rad(sight) }
    }

    /// Begins to slew towards `aim`, and returns the seconds after which the slew has failed: the time of the slew, the time in which a
    /// rotorcraft turns its nose for a tilt-only mount (at `yaw_rate_rad_s`), settling and a margin.
    pub(crate) fn begin_slew(&mut self, aim: Aim, state: &State, yaw_rate_rad_s: Option<f64>) -> f64 {
        let sight = Camera::sight(&aim, state);
        self.aim = Some(aim);
        self.state = CameraState::Slewing;
        (self.timer, self.aligned_s) = (None, 0.0);
        let wanted = self.angles(sight);
        self.error_rad = TargetDirection::of(self.tilt_rad, self.pan_rad).angle_rad(sight);
        let turn_rad = (wanted.tilt_rad - self.tilt_rad).abs().max(wrap_pi(wanted.pan_rad - self.pan_rad).abs());
        let nose_s = match (self.nose_rad(state), yaw_rate_rad_s) {
            (Some(nose_rad), Some(rate)) => wrap_pi(nose_rad - state.heading_rad).abs() / rate,
            _ => 0.0,
        };
        // The required tilt will differ once the nose has turned.
        let tilt_rad = if nose_s > 0.0 { FRAC_PI_2 } else { turn_rad };
        nose_s + tilt_rad.max(turn_rad) / (self.model.slew_rate_deg_s * RAD_PER_DEG) + SETTLE_S + SLEW_MARGIN_S
    }

    /// Ends a slew that took too long: the camera is ready again and points at nothing. Returns the reason.
    pub(crate) fn fail_slew(&mut self, state: &State) -> String {
        let name = &self.model.name;
        let reason = match &self.aim {
            None => format!("{name} has nothing to point at"),
            Some(aim) => {
                let left = self.angles(Camera::sight(aim, state)).left_rad;
                let (off, limit) = (self.error_rad / RAD_PER_DEG, self.tolerance_rad() / RAD_PER_DEG);
                let target = aim.given();
                let why = if self.stuck {
                    "the mount does not move".to_owned()
                } else if left > self.left_rad_max(Camera::sight(aim, state)) {
                    format!(
                        "the mount cannot come closer than {:.1} degrees from here; turn or fly another way",
                        left / RAD_PER_DEG
                    )
                } else {
                    "the target moves faster past the aircraft than the mount slews; fly slower or farther away"
                        .to_owned()
                };
                format!(
                    "{name} does not point at {target} in time: its sight line is {off:.1} degrees off, {limit:.1} are allowed; {why}"
                )
            }
        };
        self.rest();
        reason
    }

    /// Stops pointing and taking pictures.
    pub(crate) fn rest(&mut self) {
        (self.state, self.aim, self.slew_until, self.run) = (CameraState::Ready, None, None, None);
    }

    /// Stops the present activity, and switches the camera off if `is_off`. A camera that is powering up continues unless it is switched
    /// off.
    pub(crate) fn stop(&mut self, is_off: bool) {
        if is_off || self.is_ready() {
            self.rest();
            self.timer = None;
        }
        if is_off {
            self.state = CameraState::Off;
        }
    }

    /// Counts the distance flown in `dt` seconds at this speed over ground; true when a picture of a run is due.
    pub(crate) fn is_picture_due(&mut self, ground_speed: f64, dt: f64, now: Time) -> bool {
        let Some(run) = &mut self.run else { return false };
        run.flown_m += ground_speed * dt;
        run.waited_s += dt;
        let rested = run.last.is_none_or(|last| (now - last).seconds() >= self.model.interval_s_min);
        let is_over = match run.step {
            PictureStep::Distance(every_m) => run.flown_m >= every_m,
            PictureStep::Time(every_s) => run.waited_s >= every_s,
        };
        let due = run.last.is_none() || is_over;
        if !due || !rested || self.state != CameraState::Pointing {
            return false;
        }
        // What exceeds the step counts towards the next picture, so that the mean step is kept.
        match run.step {
            PictureStep::Distance(every_m) => run.flown_m = (run.flown_m - every_m).clamp(0.0, every_m),
            PictureStep::Time(every_s) => run.waited_s = (run.waited_s - every_s).clamp(0.0, every_s),
        }
        run.last = Some(now);
        true
    }

    /// Slews for `dt` seconds.
    pub(crate) fn follow(&mut self, state: &State, dt: f64) -> Pointing {
        let Some(aim) = &self.aim else { return Pointing::Same };
        if !self.is_ready() {
            return Pointing::Same;
        }
        let sight = Camera::sight(aim, state);
        let wanted = self.angles(sight);
        let most = if self.stuck { 0.0 } else { self.model.slew_rate_deg_s * RAD_PER_DEG * dt };
        self.tilt_rad += (wanted.tilt_rad - self.tilt_rad).clamp(-most, most);
        // A mount with stops cannot slew through them.
        let pan_error = wanted.pan_rad - self.pan_rad;
        let free = self.model.pan_deg_max >= 180.0;
        let pan_error = if free { wrap_pi(pan_error) } else { pan_error };
        self.pan_rad = wrap_pi(self.pan_rad + pan_error.clamp(-most, most));
        self.error_rad = TargetDirection::of(self.tilt_rad, self.pan_rad).angle_rad(sight);
        let left_max = self.left_rad_max(sight);
        let in_reach = wanted.left_rad <= left_max;
        // A mount that cannot move closer points as well as possible; a mount that can has to be on the target.
        let aligned = in_reach && self.error_rad <= self.tolerance_rad().max(wanted.left_rad + ALIGNED_RAD_MIN);
        self.aligned_s = if aligned { self.aligned_s + dt } else { 0.0 };
        match self.state {
            CameraState::Slewing | CameraState::Ready if self.aligned_s >= SETTLE_S => {
                (self.state, self.slew_until) = (CameraState::Pointing, None);
                Pointing::Aligned
            }
            CameraState::Pointing if !in_reach || self.error_rad > self.half_view_rad() => {
                self.state = CameraState::Slewing;
                Pointing::OutOfView
            }
            _ => Pointing::Same,
        }
    }
}

#[cfg(test)]
#[path = "camera/tests.rs"]
mod tests;
