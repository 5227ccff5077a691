//! The wind at the surface, compared with the limit of the vehicle for take-off and landing.

use crate::Mission;
use crate::error::{MissionError, MissionResult};
use apex_geo::wind;

/// Returns a statement about the wind at the start if it is stronger, as forecast for the surface, than that in which the vehicle may fly.
/// Requirement `wind` limits the wind of the whole flight; this limit is that of the vehicle file for take-off and landing.
pub(super) fn too_much_wind_at_start(mission: &Mission) -> Option<String> {
    let there = wind::at(&mission.forecast, mission.start, mission.start_altitude_m, 0.0);
    let (speed_mps, most_mps) = (libm::hypot(there.east_mps, there.north_mps), mission.model.wind_m_s_max);
    let name = &mission.model.name;
    (speed_mps > most_mps).then(|| {
        format!("the wind at the start is forecast at {speed_mps:.1} m/s; {name} may fly in at most {most_mps:.1} m/s at the surface")
    })
}

/// Checks the wind at the surface against the limit of the vehicle.
///
/// # Errors
/// A forecast at the start that exceeds it.
pub fn check_wind_at_start(mission: &Mission) -> MissionResult {
    let Some(reason) = too_much_wind_at_start(mission) else { return Ok(()) };
    Err(MissionError::vehicle("the wind at the start is too strong for the vehicle")
        .at(mission.settings.place_of("forecast"))
        .because(reason)
        .help("start at another time, or correct `wind_m_s_max` in a vehicle file of the mission"))
}
