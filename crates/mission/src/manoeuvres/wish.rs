//! A look that is to be observed.

use crate::{Fire, Mission, Target};
use apex_model::problem::Position;
use apex_observation::target::WantedLook;

/// An observation to plan: look, approach and earliest begin.
pub(crate) struct Wish<'a> {
    /// The mission as it is assumed.
    pub(crate) mission: &'a Mission,
    /// The target.
    pub(crate) target: &'a Target,
    /// Its ground and looks.
    pub(crate) fire: &'a Fire,
    /// The wanted look.
    pub(crate) look: &'a WantedLook,
    /// Position from which the vehicle comes.
    pub(crate) approach: Position,
    /// The earliest time of the observation.
    pub(crate) from_s: f64,
    /// The causes of what sweeps lose are wanted, too: that takes as long as their prediction.
    pub(crate) is_explained: bool,
}
