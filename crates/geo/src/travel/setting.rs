//! Constraints of paths, as data: from a mission on the Earth, or drawn on a plane.

use super::ground::{PathConstraints, Zone};
use super::path_vertices::crossing;
use super::solid::Solid;
use super::spans::{Span, merged};
use crate::landing::Reach;
use crate::plane::{Plane, Point};
use apex_model::problem::{AirspaceZone, LandingPlace, Position, ZoneKind};

/// Constraints of a flight in a range of altitudes and a span of time.
#[derive(Clone, Copy, Debug)]
pub struct Setting<'a> {
    /// Zones of airspace.
    pub zones: &'a [AirspaceZone],
    /// Distance kept from the edges of restricted zones, if the ends of a leg keep it.
    pub margin_m: f64,
    /// Least turn radius of the vehicle: paths bend around corners of zones on arcs of at least this radius.
    pub turn_radius_m: f64,
    /// True if the vehicle may circle around places ([`super::Network::circle`]). Ways then keep space for circles next to the margin.
    pub circling: bool,
    /// Emergency landing places.
    pub landing_places: &'a [LandingPlace],
    /// Greatest distance to the nearest of them; `None`: no limit.
    pub landing_distance_m_max: Option<f64>,
    /// Positions around whose centre the projection is placed.
    pub around: &'a [Position],
    /// Lowest and highest altitude of the flight above mean sea level: zones above and below play no part.
    pub altitudes_m: (f64, f64),
    /// Begin and end of the considered time: zones active at other times are ignored.
    pub time_s: (f64, f64),
}

/// A zone drawn on a plane.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlaneZone {
    /// Its name.
    pub name: String,
    /// True for a permitted zone, false for a restricted one.
    pub keep_in: bool,
    /// Corners in order, either sense, not closed.
    pub corners: Vec<Point>,
    /// Active times; empty for always.
    pub active_s: Vec<(f64, f64)>,
}

/// Returns the constraints of a setting, with all zones on one projection around its positions. Paths keep `room_m` more than the margin
/// from zones.
pub(crate) fn ground(setting: &Setting<'_>, room_m: f64) -> Result<PathConstraints, String> {
    let plane = Plane::around(setting.around);
    let (low_m, high_m) = setting.altitudes_m;
    let mut flat: Vec<(PlaneZone, f64)> = Vec::new();
    let mut must_stay = false;
    for zone in setting.zones {
        let keep_in = zone.kind == ZoneKind::Permitted;
        must_stay |= keep_in;
        let counts = if keep_in {
            zone.altitude_m_min <= low_m && high_m < zone.altitude_m_max
        } else {
            zone.altitude_m_min <= high_m && low_m < zone.altitude_m_max
        };
        let corners = corners(zone, &plane)?;
        if !counts {
            continue;
        }
        let active_s = vec![(zone.active.from_s, zone.active.until_s)];
        let stretch = corners.iter().fold(1.0, |most: f64, corner| most.max(plane.stretch(*corner)));
        let same = |(other, _): &&mut (PlaneZone, f64)| {
            other.keep_in == keep_in && other.name == zone.name && other.corners == corners
        };
        match flat.iter_mut().find(same) {
            Some((other, _)) => other.active_s.extend(active_s),
            None => flat.push((PlaneZone { name: zone.name.clone(), keep_in, corners, active_s }, stretch)),
        }
    }
    let zones = flat.iter().filter_map(|(zone, stretch)| {
        made(zone, ((setting.margin_m + room_m) * stretch, setting.turn_radius_m * stretch), *stretch, setting.time_s)
    });
    let reach = setting.landing_distance_m_max.map(|limit_m| Reach::new(setting.landing_places.to_vec(), limit_m));
    Ok(PathConstraints::new(zones.collect(), must_stay, reach, Some(plane), setting.time_s))
}

/// Returns the constraints of zones on a plane, each kept at `margin`.
pub(crate) fn drawn(
    zones: &[PlaneZone],
    margin: f64,
    turn_radius: f64,
    time_s: Span,
) -> Result<PathConstraints, String> {
    if let Some(zone) = zones.iter().find(|zone| Solid::new(&zone.corners).is_none()) {
        return Err(no_polygon(&zone.name, zone.corners.len()));
    }
    let must_stay = zones.iter().any(|zone| zone.keep_in);
    let zones = zones.iter().filter_map(|zone| made(zone, (margin, turn_radius), 1.0, time_s));
    Ok(PathConstraints::new(zones.collect(), must_stay, None, None, time_s))
}

fn no_polygon(name: &str, corners: usize) -> String {
    format!("zone {name} has {corners} corners, of which fewer than three differ; a polygon needs three")
}

fn corners(zone: &AirspaceZone, plane: &Plane) -> Result<Vec<Point>, String> {
    let name = &zone.name;
    let flat = zone.corners.iter().map(|corner| {
        plane.project(*corner).ok_or_else(|| {
            let (latitude, longitude) = (corner.latitude_deg, corner.longitude_deg);
            format!("zone {name} has a corner at ({latitude} {longitude}), too far from the mission")
        })
    });
    let flat: Vec<Point> = flat.collect::<Result<_, String>>()?;
    if Solid::new(&flat).is_none() {
        return Err(no_polygon(name, flat.len()));
    }
    if let Some((first, second)) = crossing(&flat) {
        return Err(format!(
            "zone {name} crosses itself: its edge from corner {} and its edge from corner {} meet; give its corners in order around it",
            first + 1,
            second + 1
        ));
    }
    Ok(flat)
}

/// Returns the zone with its times within `time_s`; `None` if it is never active then.
fn made(zone: &PlaneZone, (margin, turn_radius): (f64, f64), stretch: f64, time_s: Span) -> Option<Zone> {
    let (begin_s, end_s) = time_s;
    let inside = |(from_s, until_s): &(f64, f64)| {
        let meets = *from_s <= end_s && *until_s > begin_s && until_s > from_s;
        let from_s = if *from_s <= begin_s { f64::NEG_INFINITY } else { *from_s };
        let until_s = if *until_s > end_s { f64::INFINITY } else { *until_s };
        meets.then_some((from_s, until_s))
    };
    let always = vec![(f64::NEG_INFINITY, f64::INFINITY)];
    let active_s =
        if zone.active_s.is_empty() { always } else { merged(zone.active_s.iter().filter_map(inside).collect(), 0.0) };
    let solid = Solid::new(&zone.corners)?;
    let margin = if zone.keep_in { 0.0 } else { margin.max(0.0) };
    let bend_radius = margin.max(turn_radius);
    (!active_s.is_empty()).then(|| Zone {
        name: zone.name.clone(),
        keep_in: zone.keep_in,
        solid,
        margin,
        bend_radius,
        stretch,
        active_s,
    })
}
