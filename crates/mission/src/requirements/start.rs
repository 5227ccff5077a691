//! Requirements that are violated at the start: errors when the mission is loaded.

use super::statement::{LandingReach, Requirements};
use crate::error::{MissionError, MissionResult};
use apex_geo::landing;
use apex_geo::plane::{Plane, inside};
use apex_geo::wind;
use apex_model::problem::{AirspaceZone, LandingPlace, Position, WindField, ZoneKind};
use apex_vehicle::VehicleModel;

/// The part of a mission that determines whether its requirements hold at the start.
pub(crate) struct StartConditions<'a> {
    /// Place of the application, for errors.
    pub(crate) place: &'a str,
    /// The requirements.
    pub(crate) requirements: &'a Requirements,
    /// The vehicle.
    pub(crate) model: &'a VehicleModel,
    /// Airspace.
    pub(crate) zones: &'a [AirspaceZone],
    /// Emergency landing places.
    pub(crate) landing_places: Vec<LandingPlace>,
    /// Wind as assumed at the start.
    pub(crate) forecast: &'a WindField,
    /// Length of the mission, s.
    pub(crate) duration_s: f64,
    /// Place of the landing distance in the program.
    pub(crate) landing_place: &'a str,
    /// Diameter of the circles that the vehicle flies, m, without wind; 0 for a vehicle that hovers.
    pub(crate) circle_m: f64,
    /// Start of the vehicle.
    pub(crate) start: Position,
    /// Altitude of the start above mean sea level.
    pub(crate) start_altitude_m: f64,
}

/// Name of the requirement that also has an option of the application.
const LANDING_DISTANCE: &str = "landing-distance";

/// Checks the conditions before the first second of flight.
///
/// # Errors
/// - The mission starts inside a restricted zone, outside of the permitted area, or too far from every landing place.
/// - It starts in weather beyond its limits, or with less energy than its reserve.
/// - Its clearance exceeds the vehicle's ceiling, or its landing is required before time 0.
pub(crate) fn check_start(mission: &StartConditions<'_>) -> MissionResult<()> {
    airspace(mission)?;
    let requirements = mission.requirements;
    if let Some(LandingReach::Disc { distance_m_max }) = requirements.landing {
        let places = &mission.landing_places;
        let nearest = landing::nearest(places, mission.start);
        match nearest {
            Some((place, distance_m)) if distance_m <= distance_m_max => {
                // Turns that the vehicle flies around the landing place, without wind.
                let circle_m = mission.circle_m;
                if distance_m_max < circle_m {
                    let why = format!(
                        "the distance may be {:.2} km, and {} needs {:.1} km to circle at the landing place {}",
                        distance_m_max / 1e3,
                        mission.model.name,
                        circle_m / 1e3,
                        place.name
                    );
                    return Err(unmet(
                        mission,
                        LANDING_DISTANCE,
                        why,
                        "raise the distance; a number without a unit is in metres, and nautical miles are written as `120nm`",
                    ));
                }
            }
            Some((place, distance_m)) => {
                let why = format!(
                    "the nearest landing place, {}, is {:.1} km from the start; the distance may be {:.1} km",
                    place.name,
                    distance_m / 1e3,
                    distance_m_max / 1e3
                );
                return Err(unmet(
                    mission,
                    LANDING_DISTANCE,
                    why,
                    "raise the distance, or add a landing place to `:airfields`",
                ));
            }
            None => {
                let why = "the mission has no landing place".to_string();
                return Err(unmet(mission, LANDING_DISTANCE, why, "add `:airfields`, or a target of kind `base`"));
            }
        }
    }
    if let Some(clearance_m) = requirements.terrain_clearance_m
        && mission.start_altitude_m + clearance_m > mission.model.ceiling_m
    {
        let why = format!(
            "a clearance of {clearance_m:.0} m over the start at {:.0} m is above the ceiling of {}, {:.0} m",
            mission.start_altitude_m, mission.model.name, mission.model.ceiling_m
        );
        return Err(unmet(mission, "terrain", why, "state a smaller clearance, or another vehicle"));
    }
    weather(mission)?;
    mission_end(mission)?;
    energy(mission)
}

fn airspace(mission: &StartConditions<'_>) -> MissionResult<()> {
    if mission.requirements.airspace.is_none() {
        return Ok(());
    }
    let is_in = |zone: &AirspaceZone| {
        let plane = Plane::new(mission.start);
        let corners: Option<Vec<_>> = zone.corners.iter().map(|corner| plane.project(*corner)).collect();
        zone.active.contains(0.0) && corners.is_some_and(|corners| inside(Default::default(), &corners))
    };
    let is_at_height = |zone: &AirspaceZone| {
        zone.altitude_m_min <= mission.start_altitude_m && mission.start_altitude_m <= zone.altitude_m_max
    };
    let shut = mission.zones.iter().find(|zone| zone.kind == ZoneKind::Restricted && is_in(zone) && is_at_height(zone));
    if let Some(zone) = shut {
        let why = format!("the start lies inside of the restricted zone `{}`, which is active at the start", zone.name);
        return Err(unmet(
            mission,
            "airspace",
            why,
            "move the start, or change the zone or its `active_h` in `:airspace`",
        ));
    }
    let permitted = || mission.zones.iter().filter(|zone| zone.kind == ZoneKind::Permitted);
    // The start may be below the permitted band: the vehicle climbs into it.
    if permitted().next().is_some() && !permitted().any(is_in) {
        let why = "the start lies outside of every permitted zone that is active at the start".to_string();
        return Err(unmet(mission, "airspace", why, "move the start, or extend the permitted zone in `:airspace`"));
    }
    Ok(())
}

/// Checks the forecast at the start against the weather limits: the vehicle could otherwise not take off.
fn weather(mission: &StartConditions<'_>) -> MissionResult<()> {
    let requirements = mission.requirements;
    let there = wind::at(mission.forecast, mission.start, mission.start_altitude_m, 0.0);
    let speed_mps = libm::hypot(there.east_mps, there.north_mps);
    let figures = [
        ("turbulence", there.edr, requirements.edr_max, "m^(2/3)/s"),
        ("wind", speed_mps, requirements.wind_mps_max, "m/s"),
    ];
    let stated = figures.into_iter().filter_map(|(name, forecast, most, unit)| Some((name, forecast, most?, unit)));
    let unmet_one = stated.into_iter().find(|(_, forecast, most, _)| forecast > most);
    let Some((name, forecast, most, unit)) = unmet_one else { return Ok(()) };
    let why =
        format!("`:forecast` has {forecast:.2} {unit} at the start at time 0; at most {most:.2} {unit} may be met");
    Err(unmet(mission, name, why, "state a greater `:at-most` in :requirements, or start at another time"))
}

fn mission_end(mission: &StartConditions<'_>) -> MissionResult<()> {
    let before_s = mission.requirements.landed_before_end_s.unwrap_or(0.0);
    if before_s < mission.duration_s {
        return Ok(());
    }
    let why = format!(
        "the landing is required {:.0} min before the end of a mission of {:.0} min",
        before_s / 60.0,
        mission.duration_s / 60.0
    );
    Err(unmet(mission, "mission-end", why, "state a smaller `:before` in :requirements, or a longer `:duration`"))
}

fn energy(mission: &StartConditions<'_>) -> MissionResult<()> {
    let Some(reserve_s) = mission.requirements.energy_reserve_s else { return Ok(()) };
    let endurance_s = super::statement::endurance_s(mission.model);
    if reserve_s < endurance_s {
        return Ok(());
    }
    let why = format!(
        "the reserve of {:.0} min is not less than the endurance of {}, {:.0} min",
        reserve_s / 60.0,
        mission.model.name,
        endurance_s / 60.0
    );
    Err(unmet(mission, "energy", why, "state a smaller `:reserve` in :requirements, or another vehicle"))
}

fn unmet(mission: &StartConditions<'_>, name: &str, why: String, help: &str) -> MissionError {
    let place = if name == LANDING_DISTANCE { mission.landing_place } else { mission.place };
    MissionError::setting(format!("the requirement `{name}` cannot be met from the start"))
        .at(place)
        .because(why)
        .help(help)
}
