//! Candidate altitudes for lines of a scanner over a target: where the useful swath is widest, where pixels are just fine enough or the
//! scan rate just fast enough, where the air is calmest, just above and below zones, and the vehicle's greatest altitude.

use super::air_limits::CalmBands;
use super::wish::Wish;
use apex_geo::geodesy;
use apex_model::problem::{AirspaceZone, Position, TimeWindow, ZoneKind};
use apex_observation::sensor::ScannerMode;
use std::f64::consts::FRAC_PI_4;

/// Altitudes that differ by less count as equal.
const APART_M: f64 = 50.0;
/// Height kept from the upper and lower faces of zones, at least.
const ZONE_HEIGHT_M: f64 = 150.0;
/// Height by which an aircraft may leave its altitude, in addition to the height that the mission requires from faces.
const LEVEL_M: f64 = 10.0;

/// Returns the altitudes to try, rising, above mean sea level.
///
/// # Errors
/// If no altitude is possible: the required altitude, and the obstacle.
pub(super) fn of(wish: &Wish<'_>, mode: &ScannerMode) -> Result<Vec<f64>, String> {
    let Wish { mission, look, .. } = wish;
    let model = &mission.model;
    let ground_m = wish.target.elevation_m;
    let ceiling_m = model.ceiling_m * model.planning.ceiling_share;
    // Above this altitude pixels are too large to have any value.
    let highest_m = ground_m + look.resolution.zero_multiple * look.resolution.wanted_m / mode.pixel_rad();
    let scan_m = ground_m + mode.height_m_min_any(model.true_airspeed_m_s_cruise);
    // Where the ground is not known, it lies at the elevation of the target.
    let flat_m = ground_m + mission.requirements.terrain_clearance_m.unwrap_or(0.0);
    let clear_m = mission.clear_altitude_m(wish.target.position, wish.fire.radius_m).unwrap_or(flat_m) + LEVEL_M;
    let lowest_m = clear_m.max(scan_m);
    let top_m = ceiling_m.min(highest_m);
    if lowest_m > top_m {
        let limit = if highest_m < ceiling_m {
            format!("pixels of {} m need less than {highest_m:.0} m", look.resolution.wanted_m)
        } else {
            format!("the vehicle flies no higher than {ceiling_m:.0} m")
        };
        let need = if lowest_m > scan_m {
            "the clearance of the terrain around it (requirement terrain)"
        } else {
            "scanning without gaps"
        };
        return Err(format!("{need} needs an altitude of {lowest_m:.0} m, {limit}"));
    }
    if top_m <= ground_m {
        return Err(format!("the ground lies at {ground_m:.0} m, the vehicle flies no higher than {ceiling_m:.0} m"));
    }
    let calm = CalmBands::between(wish, (lowest_m, top_m))?;
    let mut found = vec![lowest_m, ceiling_m];
    found.extend(calm.iter().flat_map(CalmBands::ends_m));
    if look.resolution.wanted_m.is_finite() {
        let half_rad = mode.half_field_rad();
        // The useful swath is widest where its edge is seen at 45 degrees, or at the edge of the field of view.
        let edge_rad = half_rad.min(FRAC_PI_4);
        let wanted_m = look.resolution.wanted_m;
        let angles_rad = [0.0, edge_rad, half_rad];
        found.extend(angles_rad.map(|angle_rad| ground_m + mode.height_m_max(wanted_m, angle_rad)));
    }
    let here = |area: Option<apex_model::problem::Area>| area.is_none_or(|area| area.contains(wish.target.position));
    let layers = mission.forecast.layers.iter().filter(|layer| here(layer.area) && layer.until_s > wish.from_s);
    found.extend(layers.map(|layer| 0.5 * (layer.altitude_m_min + layer.altitude_m_max)));
    let face_m = face_height_m(wish);
    for zone in zones_near(wish) {
        found.extend([zone.altitude_m_max + face_m, zone.altitude_m_min - face_m]);
    }
    let bands = permitted_bands(wish, face_m);
    found.extend(bands.iter().flat_map(|(low_m, high_m)| [*low_m, *high_m]));
    // At ground level nothing is seen, and the least height may be 0 if no scan rate is known.
    found.retain(|altitude_m| *altitude_m >= lowest_m && *altitude_m <= top_m && *altitude_m > ground_m + APART_M);
    found.retain(|altitude_m| calm.as_ref().is_none_or(|calm| calm.contain(*altitude_m)));
    if let Some((low_m, high_m)) = bands.first() {
        found.retain(|altitude_m| bands.iter().any(|(low_m, high_m)| (*low_m..=*high_m).contains(altitude_m)));
        if found.is_empty() {
            return Err(format!(
                "the permitted area leaves {low_m:.0} m to {high_m:.0} m, the scanner needs {lowest_m:.0} m to {top_m:.0} m"
            ));
        }
    }
    found.sort_by(f64::total_cmp);
    found.dedup_by(|next, before| *next - *before < APART_M);
    match found.is_empty() {
        true => Err(format!("no altitude between {lowest_m:.0} m and {top_m:.0} m is possible")),
        false => Ok(found),
    }
}

/// Returns the distance that lines keep from the faces of zones: the distance that the flight must keep, plus the altitude error of the
/// vehicle.
fn face_height_m(wish: &Wish<'_>) -> f64 {
    let required_m = wish.mission.requirements.airspace.map_or(0.0, |buffer| buffer.vertical_m);
    ZONE_HEIGHT_M.max(required_m + LEVEL_M)
}

/// Returns the altitude bands of the permitted zones around the target. Empty if there are none: then everything is permitted, or the
/// planner reports that the target is outside.
pub(super) fn permitted_bands(wish: &Wish<'_>, face_m: f64) -> Vec<(f64, f64)> {
    let here = wish.mission.zones.iter().filter(|zone| {
        zone.kind == ZoneKind::Permitted
            && zone.active.until_s > wish.from_s
            && distance_m(zone, wish.target.position) == 0.0
    });
    // A face at sea level is the ground.
    let low_m = |zone: &AirspaceZone| if zone.altitude_m_min > 0.0 { zone.altitude_m_min + face_m } else { 0.0 };
    here.map(|zone| (low_m(zone), zone.altitude_m_max - face_m)).collect()
}

/// Returns the restricted zones that the lines over the target may meet.
pub(super) fn zones_near<'a>(wish: &'a Wish<'_>) -> impl Iterator<Item = &'a AirspaceZone> {
    let reach_m = wish.fire.radius_m + wish.mission.settings.zone_margin_m;
    let near = move |zone: &&AirspaceZone| {
        zone.kind == ZoneKind::Restricted && distance_m(zone, wish.target.position) < 2.0 * reach_m
    };
    wish.mission.zones.iter().filter(near)
}

/// Returns the distance from a zone's outline, 0 inside.
fn distance_m(zone: &AirspaceZone, position: Position) -> f64 {
    use apex_geo::plane::{self, Plane, Point};
    let plane = Plane::new(position);
    let flat: Vec<Point> = zone.corners.iter().filter_map(|corner| plane.project(*corner)).collect();
    let here = Point::default();
    if plane::inside(here, &flat) { 0.0 } else { plane::segment_to_edges(here, here, &flat) }
}

/// Returns the zone that closes `lines` at `altitude_m` for the whole rest of the mission, if there is one.
pub(super) fn closed_by<'a>(
    wish: &'a Wish<'_>,
    lines: &[(Position, Position)],
    altitude_m: f64,
) -> Option<&'a AirspaceZone> {
    const STEPS: u32 = 20;
    let closes = |zone: &&AirspaceZone| {
        let met = |(from, to): &(Position, Position)| {
            let at = |step: u32| geodesy::interpolate(*from, *to, f64::from(step) / f64::from(STEPS));
            (0..=STEPS).any(|step| distance_m(zone, at(step)) == 0.0)
        };
        lines.iter().any(met)
    };
    zones_closed(wish, altitude_m).find(closes)
}

/// Returns the restricted zones near the target that are closed at `altitude_m` for the whole rest of the mission.
pub(super) fn zones_closed<'a>(wish: &'a Wish<'_>, altitude_m: f64) -> impl Iterator<Item = &'a AirspaceZone> {
    let rest = TimeWindow { from_s: wish.from_s, until_s: wish.mission.settings.duration.seconds() };
    zones_near(wish).filter(move |zone| {
        let always = zone.active.from_s <= rest.from_s && zone.active.until_s >= rest.until_s;
        always && zone.altitude_m_min <= altitude_m && altitude_m < zone.altitude_m_max
    })
}
