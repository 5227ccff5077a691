//! Obstacles of travel, as text.

use std::fmt;

/// Reason for which a place cannot be used or no path exists.
#[derive(Clone, Debug, PartialEq)]
pub enum TravelError {
    /// Inside this restricted zone.
    Inside(String),
    /// Every path crosses restricted zones; the straight one this zone.
    Crosses(String),
    /// The leg itself crosses this restricted zone while it is active, or comes closer to it than the margin.
    LegCrosses(String),
    /// The leg itself leaves the permitted zones.
    LegLeavesPermitted,
    /// Outside every permitted zone.
    Outside,
    /// No path stays inside the permitted zones.
    LeavesPermitted,
    /// Not on the map, or farther away than the projection reaches.
    TooFar,
    /// Too far from every emergency landing place; holds the distance of the nearest one in metres, infinite if there are none.
    NoLandingPlace(f64),
    /// Every path is too far from emergency landing places, of which one must be within this distance.
    LeavesReach(f64),
    /// There is not enough space for the required turns along the paths.
    NoRoomToTurn,
    /// The path is closed at every time at which it could still be flown.
    Shut,
    /// The ground under the path needs at least this altitude in metres above mean sea level.
    Ground(f64),
}

impl fmt::Display for TravelError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            TravelError::Inside(zone) => write!(f, "inside restricted area {zone}"),
            TravelError::Crosses(zone) => {
                write!(f, "every way leads through restricted areas, the straight one through {zone}")
            }
            TravelError::LegCrosses(zone) => {
                write!(f, "its lines lead through restricted area {zone} or too close to it")
            }
            TravelError::LegLeavesPermitted => f.write_str("its lines leave the permitted area of operation"),
            TravelError::Outside => f.write_str("outside the permitted area of operation"),
            TravelError::LeavesPermitted => f.write_str("every way leaves the permitted area of operation"),
            TravelError::TooFar => f.write_str("more than 8,000 km from the middle of the mission"),
            TravelError::NoLandingPlace(distance_m) if distance_m.is_finite() => {
                write!(f, "{:.0} km from the nearest emergency landing place", distance_m / 1000.0)
            }
            TravelError::NoLandingPlace(_) => f.write_str("there is no emergency landing place"),
            TravelError::LeavesReach(distance_m) => {
                write!(f, "every way leaves the reach of the emergency landing places ({:.0} km)", distance_m / 1000.0)
            }
            TravelError::NoRoomToTurn => {
                f.write_str("restricted areas leave too little space for turns of the vehicle")
            }
            TravelError::Shut => f.write_str("restricted areas or the wind leave no possible departure time"),
            TravelError::Ground(needs_m) => {
                write!(f, "the terrain under the way needs an altitude of {needs_m:.0} m or more")
            }
        }
    }
}
