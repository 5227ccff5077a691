//! Paths in flight: from the vehicle's position to a place, a circle, a line or an airfield, within the mission's requirements.
//!
//! A flight command flies straight. Library `vehicle` calls the functions of this module before each command, and again when a task
//! continues after an interruption; the result is passed to the command as `:via`. If the straight path and the turns at its ends are
//! open, the result is nil. A function depends only on its arguments and the mission's data, so a replay gets the same results.
//! Bound: O(zones) where the straight way is open; else a network of travel for each altitude tried ([`apex_geo::travel`]).

mod answers;
mod areas;
mod circles;
mod crossed;
mod early_change;
mod landing;
mod landing_places;
mod least;
mod limits;
mod route;
mod segment;
mod straight;
mod take_off;
mod time_limits;
mod wait;

pub(crate) use answers::register;
pub(crate) use circles::STRAIGHT_CLIMB_M;
pub(crate) use landing_places::is_inside;
pub use limits::Limits;
pub(crate) use limits::lead_in_s;
pub(crate) use route::time_error_s;
pub(crate) use segment::Segment;
pub use take_off::check_take_offs;

use apex_model::problem::Position;

/// Start and destination of a path, as requested by a vehicle in flight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Request {
    /// Position of the vehicle.
    pub from: Position,
    /// Its altitude above mean sea level.
    pub from_altitude_m: f64,
    /// Its direction over ground, clockwise from north; `None` for a vehicle that may leave in any direction.
    pub from_track_rad: Option<f64>,
    /// Instant, since the mission's start.
    pub at_s: f64,
    /// Destination.
    pub to: Position,
    /// The altitude to be held there.
    pub to_altitude_m: f64,
    /// The direction in which the place must be reached; `None` for any.
    pub to_track_rad: Option<f64>,
    /// Room for circles around the place.
    pub circle_radius_m: f64,
    /// Duration of the stay there, in seconds.
    pub stay_s: f64,
}

/// A requirement of the mission that no way keeps.
#[derive(Clone, Debug, PartialEq)]
pub struct Broken {
    /// Violated requirements: names of zones, `permitted area`, `landing distance`, ..; at least one.
    pub names: Vec<String>,
    /// Reason, human-readable.
    pub why: String,
}

impl Broken {
    /// Returns the violation of one requirement.
    fn one(name: String, why: &str) -> Broken {
        Broken { names: vec![name], why: why.to_string() }
    }
}

/// A way that is not straight.
#[derive(Clone, Debug, PartialEq)]
pub struct Way {
    /// Places to fly over, without the beginning and the end.
    pub via: Vec<Position>,
    /// The altitude at which they are flown over.
    pub altitude_m: f64,
    /// Time to wait before leaving.
    pub hold_s: f64,
    /// Place around which the vehicle waits; `None`: its position.
    pub hold_around: Option<Position>,
    /// Duration after leaving.
    pub time_s: f64,
    /// Violations; `None` if every requirement is kept.
    pub broken: Option<Broken>,
}
