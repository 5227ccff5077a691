//! Requirements that cannot be judged: the vehicle does not report what their margins are computed from.

use super::readings::Scene;
use apex_model::value::Value;
use std::sync::LazyLock;

/// The value of `(requirement-state ..)` of a requirement that cannot be judged.
pub(super) static UNKNOWN: LazyLock<Value> = LazyLock::new(|| Value::symbol("unknown"));

/// A requirement, and the report without which it cannot be judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Unjudged {
    pub(super) name: &'static str,
    /// For operators: `fuel` and the like, in backticks.
    pub(super) missing: &'static str,
}

impl Scene<'_> {
    /// Returns the requirements of the mission that the vehicle's reports do not allow to judge. Those of cameras are left out: a camera
    /// that rests may report nothing, and endangers nothing.
    pub(super) fn unjudged(&self) -> Vec<Unjudged> {
        let stated = self.requirements();
        let of = |is_missing: bool, name: &'static str, missing: &'static str| {
            is_missing.then_some(Unjudged { name, missing })
        };
        let lacks_height = !self.is_near_ground() && self.ground_below_m().is_none();
        let is_link_silent = !self.mission.link_map.is_empty() && !self.flown.has_signal_level;
        [
            of(stated.terrain_clearance_m.is_some() && lacks_height, "terrain", "`height-above-ground`"),
            of(
                stated.energy_reserve_s.is_some() && self.endurance_s().is_none(),
                "energy",
                "`endurance-remaining`, `fuel` or `battery-charge`",
            ),
            of(stated.edr_max.is_some() && self.flown.edr.is_none(), "turbulence", "`edr`"),
            of(stated.wind_mps_max.is_some() && self.flown.wind_mps.is_none(), "wind", "`wind-speed`"),
            of(stated.icing_s.is_some() && self.flown.ice_s.is_none(), "icing", "`ice-exposure`"),
            of(stated.link_lost_s.is_some() && is_link_silent, "link", "`signal-level`"),
        ]
        .into_iter()
        .flatten()
        .collect()
    }
}
