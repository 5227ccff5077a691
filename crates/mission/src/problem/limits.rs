//! Limits on the time of a single-visit plan, and their names in reasons: the end of the mission, the closing of the base, the battery.

use crate::Mission;
use crate::closing::closing;
use crate::descent::Descent;
use crate::ways::time_error_s;
use apex_model::problem::{NamedLimit, SingleVisitVehicle};
use apex_model::time::Time;
use apex_vehicle::EnergyModel;

/// Returns the latest landing of a plan made at `now_s`: before the end of the mission and before the base closes until the end of the mission.
pub(crate) fn end_s(mission: &Mission, now_s: f64) -> f64 {
    latest_end_s(mission, now_s).min(base_open_until_s(mission, now_s))
}

/// Returns the latest end of the flight for a plan made at `now_s`.
pub(crate) fn latest_end_s(mission: &Mission, now_s: f64) -> f64 {
    end_before_margin_s(mission.settings.duration.seconds(), mission.settings.end_margin.seconds(), now_s)
}

/// Returns the end of a mission less its margin. The margin absorbs delays, and shrinks with the remaining time: delays of single legs are
/// assumed to be independent, so their sum grows with the root of the time.
pub(super) fn end_before_margin_s(duration_s: f64, margin_s: f64, now_s: f64) -> f64 {
    let left = ((duration_s - now_s) / duration_s).clamp(0.0, 1.0);
    duration_s - margin_s * left.sqrt()
}

/// Returns the instant until which plans made at `now_s` land at the base because it closes until the end of the mission, with the error of such times;
/// infinity for a base that stays open, and for one that is closed already, because the flight has no better place to land then.
pub(crate) fn base_open_until_s(mission: &Mission, now_s: f64) -> f64 {
    let closing = closing(mission, (mission.start, mission.start_altitude_m)).filter(|closing| closing.at_s > now_s);
    closing.map_or(f64::INFINITY, |closing| {
        let ahead_s = closing.at_s - now_s;
        closing.at_s - time_error_s(ahead_s).min(0.5 * ahead_s)
    })
}

/// Returns the name of the limit on the end of a plan made at `now_s`: the closing of the base if it comes before `mission_end_s`; `None`
/// for the end of the mission.
pub(crate) fn end(mission: &Mission, now_s: f64, mission_end_s: f64) -> Option<NamedLimit> {
    let closing = closing(mission, (mission.start, mission.start_altitude_m))?;
    (base_open_until_s(mission, now_s) < mission_end_s).then(|| NamedLimit {
        name: "the time until the base closes".to_string(),
        cause: format!(
            "zone {} closes the base at {} until the mission ends",
            closing.zone.name,
            Time::from_seconds(closing.at_s)
        ),
    })
}

/// Returns the name of the limit on endurance: the battery with its content; `None` for a vehicle that burns fuel.
pub(crate) fn endurance(mission: &Mission, vehicle: &SingleVisitVehicle) -> Option<NamedLimit> {
    if !matches!(mission.model.energy, EnergyModel::Battery(_)) {
        return None;
    }
    let has_s = (vehicle.endurance_s - vehicle.endurance_reserve_s).max(0.0);
    let landing_s = Descent::to_base(mission).energy / mission.model.drain_planned_per_s(mission.cruise_altitude_m());
    let reserve_s = vehicle.endurance_reserve_s - landing_s;
    Some(NamedLimit {
        name: "the battery".to_string(),
        cause: format!(
            "it has {:.0} min above its reserve of {:.0} min and its landing",
            has_s / 60.0,
            reserve_s / 60.0
        ),
    })
}
