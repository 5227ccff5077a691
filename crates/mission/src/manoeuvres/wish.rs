//! A look to be observed, with the conditions of its observation.

use crate::{Fire, Mission, Target};
use apex_model::problem::Position;
use apex_observation::target::WantedLook;

/// An observation to plan: look, approach and earliest begin.
pub(crate) struct Wish<'a> {
    /// The mission as assumed at this time.
    pub(crate) mission: &'a Mission,
    /// The target.
    pub(crate) target: &'a Target,
    /// Its ground and looks.
    pub(crate) fire: &'a Fire,
    /// The wanted look.
    pub(crate) look: &'a WantedLook,
    /// Position from which the vehicle arrives.
    pub(crate) approach: Position,
    /// The earliest time of the observation.
    pub(crate) from_s: f64,
    /// True if the causes of losses of sweeps are requested; they take as long as the prediction.
    pub(crate) is_explained: bool,
}
