//! A camera on a tilt, or tilt and pan, mount: power-up, pointing and tracking, taking pictures.

use crate::arguments::Spot;
use crate::motion::{State, wrap_pi};
use crate::path::bearing;
use apex_geo::geodesy::RAD_PER_DEG;
use apex_model::effect::CommandId;
use apex_model::time::Time;
use apex_vehicle::CameraModel;
use libm::{atan2, cos, sin, sqrt};

/// Pointing is done within this angle.
const ALIGNED_RAD: f64 = 0.01;

/// What a camera is doing.
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
    /// The published word.
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

/// What the camera points at.
#[derive(Clone, Debug)]
pub(crate) struct Aim {
    pub(crate) spot: Spot,
    pub(crate) altitude_m: f64,
}

/// One camera.
#[derive(Clone, Debug)]
pub(crate) struct Camera {
    pub(crate) model: CameraModel,
    pub(crate) state: CameraState,
    pub(crate) tilt_rad: f64,
    pub(crate) pan_rad: f64,
    pub(crate) aim: Option<Aim>,
    /// The command it is carrying out.
    pub(crate) command: Option<CommandId>,
    /// When power-up or exposure is over.
    pub(crate) timer: Option<Time>,
}

/// What pointing came to in one step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Pointing {
    Same,
    Aligned,
    OutOfView,
}

/// Where the mount has to go to look at something.
struct Angles {
    tilt_rad: f64,
    pan_rad: f64,
    in_reach: bool,
}

impl Camera {
    pub(crate) fn new(model: CameraModel) -> Camera {
        Camera { model, state: CameraState::Off, tilt_rad: 0.0, pan_rad: 0.0, aim: None, command: None, timer: None }
    }

    /// Is it powered and through with powering up?
    pub(crate) fn is_ready(&self) -> bool {
        !matches!(self.state, CameraState::Off | CameraState::PoweringUp)
    }

    /// The direction the nose must have for this mount to see its target; none where the mount pans.
    pub(crate) fn nose_rad(&self, state: &State) -> Option<f64> {
        let aim = self.aim.as_ref().filter(|_| self.model.pan_deg_max == 0.0)?;
        let (azimuth_rad, distance_m) = bearing(state.position, aim.spot.position);
        (distance_m > 1.0).then_some(azimuth_rad)
    }

    /// Why the mount cannot ever see `aim` from here, however the aircraft turns.
    pub(crate) fn refusal(&self, aim: &Aim, state: &State) -> Option<String> {
        let (_, distance_m) = bearing(state.position, aim.spot.position);
        let elevation_deg = atan2(aim.altitude_m - state.altitude_m, distance_m.max(0.1)) / RAD_PER_DEG;
        let (low, high) = (self.model.tilt_deg_min, self.model.tilt_deg_max);
        let outside = elevation_deg > high || elevation_deg < low - 1.0;
        let name = &self.model.name;
        outside.then(|| {
            format!(
                "{name} tilts from {low} to {high} degrees and the target is at {elevation_deg:.0} degrees; fly higher or farther away"
            )
        })
    }

    fn angles(&self, aim: &Aim, state: &State) -> Angles {
        let (azimuth_rad, distance_m) = bearing(state.position, aim.spot.position);
        let below_m = state.altitude_m - aim.altitude_m;
        let relative = wrap_pi(azimuth_rad - state.heading_rad);
        let (low, high) = (self.model.tilt_deg_min * RAD_PER_DEG, self.model.tilt_deg_max * RAD_PER_DEG);
        // Straight down is in reach whatever the last digits say.
        let inside = |tilt: f64| tilt >= low - 1e-3 && tilt <= high + 1e-3;
        if self.model.pan_deg_max > 0.0 {
            let tilt_rad = -atan2(below_m, distance_m);
            let in_reach = inside(tilt_rad) && relative.abs() <= self.model.pan_deg_max * RAD_PER_DEG + 1e-9;
            return Angles { tilt_rad, pan_rad: relative, in_reach };
        }
        let (forward_m, aside_m) = (distance_m * cos(relative), distance_m * sin(relative));
        let tilt_rad = -atan2(below_m, forward_m);
        let off_rad = atan2(aside_m.abs(), sqrt(forward_m * forward_m + below_m * below_m));
        let in_reach = inside(tilt_rad) && off_rad <= 0.5 * self.model.field_of_view_deg * RAD_PER_DEG;
        Angles { tilt_rad, pan_rad: 0.0, in_reach }
    }

    /// Slews for `dt` seconds.
    pub(crate) fn follow(&mut self, state: &State, dt: f64) -> Pointing {
        let Some(aim) = &self.aim else { return Pointing::Same };
        if !self.is_ready() {
            return Pointing::Same;
        }
        let wanted = self.angles(aim, state);
        let most = self.model.slew_rate_deg_s * RAD_PER_DEG * dt;
        let low = self.model.tilt_deg_min * RAD_PER_DEG;
        let tilt = wanted.tilt_rad.clamp(low, (self.model.tilt_deg_max * RAD_PER_DEG).max(low));
        self.tilt_rad += (tilt - self.tilt_rad).clamp(-most, most);
        self.pan_rad = wrap_pi(self.pan_rad + wrap_pi(wanted.pan_rad - self.pan_rad).clamp(-most, most));
        let aligned = wanted.in_reach
            && (wanted.tilt_rad - self.tilt_rad).abs() < ALIGNED_RAD
            && wrap_pi(wanted.pan_rad - self.pan_rad).abs() < ALIGNED_RAD;
        match (self.state, aligned) {
            (CameraState::Slewing | CameraState::Ready, true) => {
                self.state = CameraState::Pointing;
                Pointing::Aligned
            }
            (CameraState::Pointing, false) if !wanted.in_reach => {
                self.state = CameraState::Slewing;
                Pointing::OutOfView
            }
            _ => Pointing::Same,
        }
    }
}
