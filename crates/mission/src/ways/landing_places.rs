//! The host functions that choose a landing place: the nearest one, and the one that a glide reaches with most height.
//!
//! With the time of the flight, places whose landing breaks a requirement on airspace are chosen only where no other one is in reach.

use super::limits::{Limits, PERMITTED};
use super::{Request, Way};
use apex_geo::geodesy;
use apex_geo::location::Location;
use apex_geo::plane::{Plane, inside};
use apex_model::problem::{AirspaceZone, LandingPlace, Position, ZoneKind};
use apex_model::quantity::Dimension;
use apex_model::value::Value;

/// Evaluates `(landing-place-near LOCATION REACH [TIME])`: the name of the nearest landing place within REACH, otherwise nil. With TIME,
/// since the start of the mission, places outside of restricted zones come first. Places under a storm come last.
pub(super) fn near(limits: &Limits, arguments: &[Value]) -> Result<Value, String> {
    let [location, reach, time @ ..] = arguments else { return Err("a location and a reach are missing".to_string()) };
    let here = Location::of(location)?.position;
    let reach_m = length(reach, "reach")?;
    let at_s = time.first().filter(|time| time.is_true()).map(seconds).transpose()?;
    let places = limits.landing_places.iter().map(|place| (geodesy::distance_m(here, place.position), place));
    let is_open = |(distance_m, place): &(f64, &LandingPlace)| {
        let arrives_s = at_s.map(|at_s| at_s + distance_m / limits.true_airspeed_mps);
        arrives_s.is_none_or(|arrives_s| limits.zones_of_landing(place, arrives_s).is_empty())
    };
    let is_stormy = |place: &LandingPlace| limits.is_under_storm(place.position);
    let rank = |place: &(f64, &LandingPlace)| (is_stormy(place.1), !is_open(place));
    let nearest = places
        .filter(|(distance_m, _)| *distance_m <= reach_m)
        .min_by(|a, b| rank(a).cmp(&rank(b)).then(a.0.total_cmp(&b.0)));
    Ok(nearest.map_or_else(Value::nil, |(_, place)| Value::symbol(&place.name)))
}

/// Evaluates `(landing-place-in-glide LOCATION RATIO MARGIN [TIME])`: the name of the landing place over which a glide arrives highest, if
/// that is at least MARGIN above it; else nil. With TIME, places to which a straight glide enters no restricted zone come first.
pub(super) fn in_glide(limits: &Limits, arguments: &[Value]) -> Result<Value, String> {
    let [location, ratio, margin, time @ ..] = arguments else {
        return Err("a location, a ratio and a margin are missing".to_string());
    };
    if !location.is_true() {
        return Ok(Value::nil());
    }
    let here = Location::of(location)?;
    let ratio = match ratio.as_number() {
        Some((ratio, Dimension::NONE)) if ratio > 0.0 => ratio,
        // Without a glide ratio above zero, no place is in reach.
        Some((_, Dimension::NONE)) => return Ok(Value::nil()),
        _ => return Err(format!("the glide ratio must be a number; got {ratio}")),
    };
    let margin_m = length(margin, "margin")?;
    let at_s = time.first().map(seconds).transpose()?;
    let altitude_m = here.altitude_m.unwrap_or(0.0);
    let is_open = |place: &LandingPlace| {
        at_s.is_none_or(|at_s| limits.zones_of_glide((here.position, altitude_m, at_s), place).is_empty())
    };
    let places = limits.landing_places.iter().map(|place| {
        let down_m = geodesy::distance_m(here.position, place.position) / ratio;
        (altitude_m - limits.field_elevation_m(place) - down_m, place)
    });
    let highest = places
        .filter(|(over_m, _)| *over_m >= margin_m)
        .max_by(|a, b| is_open(a.1).cmp(&is_open(b.1)).then(a.0.total_cmp(&b.0)));
    Ok(highest.map_or_else(Value::nil, |(_, place)| Value::symbol(&place.name)))
}

/// Evaluates `(landing-place-zones PLACE TIME)`: the names of the restricted zones, and `permitted area`, that a landing at PLACE breaks
/// at TIME, as a list of texts; nil for none and for a place that is not a landing place.
pub(super) fn zones(limits: &Limits, arguments: &[Value]) -> Result<Value, String> {
    let [place, time] = arguments else { return Err("a place and a time are missing".to_string()) };
    let at_s = seconds(time)?;
    let name = place.as_symbol().map(|name| name.folded().to_string());
    let place = limits.landing_places.iter().find(|known| Some(&known.name) == name.as_ref());
    let names = place.map(|place| limits.zones_of_landing(place, at_s)).unwrap_or_default();
    Ok(Value::list(names.iter().map(|name| Value::text(name))))
}

impl Limits {
    fn field_elevation_m(&self, place: &LandingPlace) -> f64 {
        self.place(&place.name).map_or(0.0, |(_, elevation_m)| elevation_m)
    }

    /// Returns the requirements on airspace that a final approach to a place breaks at an instant.
    fn zones_of_landing(&self, place: &LandingPlace, at_s: f64) -> Vec<String> {
        let field_m = self.field_elevation_m(place);
        let holds = |zone: &&AirspaceZone| zone.active.contains(at_s) && is_inside(place.position, &zone.corners);
        let of_kind = |kind: ZoneKind| self.zones.iter().filter(move |zone| zone.kind == kind);
        let is_on_final = |zone: &&AirspaceZone| {
            zone.altitude_m_min < field_m + self.final_approach_height_m && field_m < zone.altitude_m_max
        };
        let restricted = of_kind(ZoneKind::Restricted).filter(is_on_final).filter(holds);
        let mut names: Vec<String> = restricted.map(|zone| zone.name.clone()).collect();
        if self.must_stay() && !of_kind(ZoneKind::Permitted).filter(is_on_final).any(|zone| holds(&zone)) {
            names.push(PERMITTED.to_string());
        }
        names
    }

    /// Returns the requirements on airspace that a straight glide from a position and an altitude breaks, if it begins at `at_s`.
    fn zones_of_glide(&self, (from, from_altitude_m, at_s): (Position, f64, f64), place: &LandingPlace) -> Vec<String> {
        let request = Request {
            from,
            from_altitude_m,
            from_track_rad: None,
            at_s,
            to: place.position,
            to_altitude_m: self.field_elevation_m(place),
            to_track_rad: None,
            circle_radius_m: 0.0,
            stay_s: 0.0,
        };
        let altitude_m = from_altitude_m;
        let way = Way { via: Vec::new(), altitude_m, hold_s: 0.0, hold_around: None, time_s: 0.0, broken: None };
        self.crossed(&request, &way, (0.0, false))
    }
}

fn length(value: &Value, what: &str) -> Result<f64, String> {
    match value.as_number() {
        Some((metres, Dimension::LENGTH | Dimension::NONE)) => Ok(metres),
        _ => Err(format!("expected a length for the {what}, found {value}")),
    }
}

fn seconds(value: &Value) -> Result<f64, String> {
    match value.as_number() {
        Some((seconds, Dimension::TIME | Dimension::NONE)) if seconds.is_finite() => Ok(seconds),
        _ => Err(format!("the time must be a duration since the mission's start; got {value}")),
    }
}

/// Returns true if a position is inside an outline.
pub(crate) fn is_inside(position: Position, corners: &[Position]) -> bool {
    let plane = Plane::new(position);
    let corners: Option<Vec<_>> = corners.iter().map(|corner| plane.project(*corner)).collect();
    corners.is_some_and(|corners| inside(Default::default(), &corners))
}
