//! A plan as GeoJSON (RFC 7946): the path as a line, targets as points, airspace as polygons.

use super::chart::{Chart, ChartPoint, ChartTarget, digits, milliseconds};
use super::civil::utc;
use apex_geo::geodesy::wrap_180;
use apex_model::problem::{AirspaceZone, FOREVER_S, Position, ZoneKind};
use serde_json::{Map, Value, json};

/// Returns the chart as a FeatureCollection.
pub fn write(chart: &Chart) -> String {
    let mut features = vec![path(chart)];
    features.extend(chart.start.map(|start| place("start", &chart.name, start)));
    features.extend(chart.base.map(|base| place("base", &chart.name, base)));
    features.extend(chart.targets.iter().map(|each| target(chart, each)));
    features.extend(chart.zones.iter().map(zone));
    // One feature per line, so that files of two plans can be compared.
    let lines: Vec<String> = features.iter().map(Value::to_string).collect();
    format!("{{\"type\": \"FeatureCollection\", \"features\": [\n{}\n]}}\n", lines.join(",\n"))
}

fn feature(kind: &str, name: &str, geometry: Value, more: Map<String, Value>) -> Value {
    let mut properties = Map::new();
    properties.insert("kind".into(), json!(kind));
    properties.insert("name".into(), json!(name));
    properties.extend(more);
    json!({"type": "Feature", "geometry": geometry, "properties": properties})
}

/// Returns coordinates in the order of GeoJSON: longitude first, and altitude last if known.
fn coordinates(place: &ChartPoint) -> Value {
    let Position { latitude_deg, longitude_deg } = place.position;
    let (east, north) = (digits(longitude_deg), digits(latitude_deg));
    place.altitude_m.map_or_else(|| json!([east, north]), |up| json!([east, north, (up * 10.0).round() / 10.0]))
}

fn path(chart: &Chart) -> Value {
    let mut lines = split_at_the_date_line(&chart.path());
    let geometry = match lines.len() {
        // A line has two points at least; a plan without any has no path.
        0 => Value::Null,
        1 => json!({"type": "LineString", "coordinates": lines.remove(0)}),
        _ => json!({"type": "MultiLineString", "coordinates": lines}),
    };
    let mut facts = chart.facts.clone();
    facts.insert("summary".into(), json!(chart.summary));
    facts.insert("end_s".into(), json!(milliseconds(chart.end_s)));
    if let Some(begin) = utc(chart.zero_unix_s, 0.0) {
        facts.insert("zero_utc".into(), json!(begin));
    }
    feature("path", &chart.name, geometry, facts)
}

/// Returns lines that are cut at the 180th meridian, as RFC 7946 requires.
fn split_at_the_date_line(path: &[ChartPoint]) -> Vec<Vec<Value>> {
    let mut lines: Vec<Vec<Value>> = Vec::new();
    let mut line: Vec<Value> = path.first().map(coordinates).into_iter().collect();
    for (from, to) in path.iter().zip(path.iter().skip(1)) {
        let (west, east) = (from.position.longitude_deg, to.position.longitude_deg);
        if (east - west).abs() > 180.0 {
            let edge = 180.0_f64.copysign(west);
            let whole = east + 2.0 * edge - west;
            let share = if whole == 0.0 { 0.5 } else { (edge - west) / whole };
            let between = |a: f64, b: f64| a + share * (b - a);
            let latitude_deg = between(from.position.latitude_deg, to.position.latitude_deg);
            let altitude_m = from.altitude_m.zip(to.altitude_m).map(|(a, b)| between(a, b));
            let at = |longitude_deg| {
                coordinates(&ChartPoint { position: Position::new(latitude_deg, longitude_deg), altitude_m })
            };
            line.push(at(edge));
            lines.push(std::mem::replace(&mut line, vec![at(-edge)]));
        }
        line.push(coordinates(to));
    }
    lines.push(line);
    lines.retain(|line| line.len() > 1);
    lines
}

fn place(kind: &str, name: &str, place: ChartPoint) -> Value {
    feature(kind, name, json!({"type": "Point", "coordinates": coordinates(&place)}), Map::new())
}

/// Returns a target with its observations; the first observation's data are direct members, so that the tables of map programs show them.
fn target(chart: &Chart, target: &ChartTarget) -> Value {
    let mut facts = target.facts.clone();
    let visits = chart.visits.iter().enumerate().filter(|(_, visit)| visit.target == target.name);
    let visits: Vec<_> = visits.map(|(index, visit)| (index + 1, visit)).collect();
    if let Some((number, visit)) = visits.first() {
        facts.insert("visit".into(), json!(number));
        facts.insert("arrive_s".into(), json!(milliseconds(visit.arrive_s)));
        facts.insert("begin_s".into(), json!(milliseconds(visit.begin_s)));
        facts.insert("end_s".into(), json!(milliseconds(visit.end_s)));
        if let Some(begin) = utc(chart.zero_unix_s, visit.begin_s) {
            facts.insert("begin_utc".into(), json!(begin));
        }
    }
    if visits.len() > 1 {
        let each = |of: fn(&super::chart::ChartVisit) -> f64| {
            visits.iter().map(|(_, visit)| milliseconds(of(visit))).collect::<Vec<_>>()
        };
        facts.insert("begins_s".into(), json!(each(|visit| visit.begin_s)));
        facts.insert("ends_s".into(), json!(each(|visit| visit.end_s)));
    }
    if let Some(reason) = &target.left_out {
        facts.insert("left_out".into(), json!(reason));
    }
    let kind = if visits.is_empty() { "left-out" } else { "target" };
    feature(kind, &target.name, json!({"type": "Point", "coordinates": coordinates(&target.place)}), facts)
}

fn zone(zone: &AirspaceZone) -> Value {
    let corner = |corner: &Position| json!([digits(corner.longitude_deg), digits(corner.latitude_deg)]);
    let ring = |corners: &Vec<Position>| {
        let mut ring: Vec<Value> = corners.iter().map(corner).collect();
        if clockwise(corners) {
            ring.reverse();
        }
        // A ring ends at its first point.
        ring.extend(ring.first().cloned());
        json!([ring])
    };
    let parts: Vec<Value> = parts_beside_the_date_line(&zone.corners).iter().map(ring).collect();
    let geometry = match parts.as_slice() {
        [part] => json!({"type": "Polygon", "coordinates": part}),
        parts => json!({"type": "MultiPolygon", "coordinates": parts}),
    };
    let mut facts = Map::new();
    facts.insert("altitude_m_min".into(), json!(zone.altitude_m_min));
    facts.insert("altitude_m_max".into(), json!(zone.altitude_m_max));
    let bounded = |time_s: f64| (time_s.abs() < FOREVER_S).then_some(time_s);
    facts.insert("active_from_s".into(), json!(bounded(zone.active.from_s)));
    facts.insert("active_until_s".into(), json!(bounded(zone.active.until_s)));
    let kind = match zone.kind {
        ZoneKind::Restricted => "restricted",
        ZoneKind::Permitted => "permitted",
    };
    feature(kind, &zone.name, geometry, facts)
}

/// Returns the polygon, or its parts on both sides of the 180th meridian if it crosses that.
fn parts_beside_the_date_line(corners: &[Position]) -> Vec<Vec<Position>> {
    let mut unrolled: Vec<Position> = Vec::with_capacity(corners.len());
    for corner in corners {
        let before_deg = unrolled.last().map_or(corner.longitude_deg, |before| before.longitude_deg);
        let longitude_deg = before_deg + wrap_180(corner.longitude_deg - before_deg);
        unrolled.push(Position { longitude_deg, ..*corner });
    }
    let Some(outside) = unrolled.iter().find(|corner| corner.longitude_deg.abs() > 180.0) else {
        return vec![corners.to_vec()];
    };
    let sense = 1.0_f64.copysign(outside.longitude_deg);
    let beyond_deg = |corner: &Position| sense * corner.longitude_deg - 180.0;
    let here = clip(&unrolled, |corner| -beyond_deg(corner));
    let mut there = clip(&unrolled, beyond_deg);
    there.iter_mut().for_each(|corner| corner.longitude_deg -= sense * 360.0);
    let is_wide = |part: &Vec<Position>| part.iter().any(|corner| corner.longitude_deg.abs() < 180.0);
    [here, there].into_iter().filter(is_wide).collect()
}

/// Returns the part of a polygon where `side` is not negative (Sutherland and Hodgman).
fn clip(corners: &[Position], side: impl Fn(&Position) -> f64) -> Vec<Position> {
    let mut kept = Vec::with_capacity(corners.len() + 2);
    for (from, to) in corners.iter().zip(corners.iter().cycle().skip(1)) {
        let (from_side, to_side) = (side(from), side(to));
        if from_side >= 0.0 {
            kept.push(*from);
        }
        if from_side * to_side < 0.0 {
            let share = from_side / (from_side - to_side);
            let between = |a: f64, b: f64| a + share * (b - a);
            kept.push(Position {
                latitude_deg: between(from.latitude_deg, to.latitude_deg),
                longitude_deg: between(from.longitude_deg, to.longitude_deg),
            });
        }
    }
    kept
}

/// Returns true if the ring is clockwise; RFC 7946 requires outer rings counterclockwise.
fn clockwise(corners: &[Position]) -> bool {
    let next = corners.iter().skip(1).chain(corners.first());
    let doubled = |(a, b): (&Position, &Position)| a.longitude_deg * b.latitude_deg - b.longitude_deg * a.latitude_deg;
    corners.iter().zip(next).map(doubled).sum::<f64>() < 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(latitude_deg: f64, longitude_deg: f64) -> ChartPoint {
        ChartPoint { position: Position::new(latitude_deg, longitude_deg), altitude_m: None }
    }

    #[test]
    fn a_path_over_the_180th_meridian_is_cut_there() {
        let lines = split_at_the_date_line(&[at(0.0, 170.0), at(0.0, 179.0), at(2.0, -179.0), at(2.0, -170.0)]);
        let expected =
            json!([[[170.0, 0.0], [179.0, 0.0], [180.0, 1.0]], [[-180.0, 1.0], [-179.0, 2.0], [-170.0, 2.0]]]);
        assert_eq!(json!(lines), expected);
        let back = split_at_the_date_line(&[at(2.0, -179.0), at(0.0, 179.0)]);
        assert_eq!(json!(back), json!([[[-179.0, 2.0], [-180.0, 1.0]], [[180.0, 1.0], [179.0, 0.0]]]));
        assert_eq!(json!(split_at_the_date_line(&[at(0.0, 180.0), at(0.0, -180.0)])).as_array().map(Vec::len), Some(2));
        assert!(split_at_the_date_line(&[at(0.0, 1.0)]).is_empty() && split_at_the_date_line(&[]).is_empty());
    }

    #[test]
    fn a_zone_over_the_180th_meridian_is_two_polygons() {
        let corners = [(0.0, 179.0), (0.0, -178.0), (1.0, -178.0), (1.0, 179.0)];
        let active = apex_model::problem::TimeWindow { from_s: -FOREVER_S, until_s: FOREVER_S };
        let zone_of = |corners: &[(f64, f64)]| AirspaceZone {
            name: "range".into(),
            kind: ZoneKind::Restricted,
            corners: corners.iter().map(|(north, east)| Position::new(*north, *east)).collect(),
            altitude_m_min: 0.0,
            altitude_m_max: 9000.0,
            active,
        };
        let expected = json!({"type": "MultiPolygon", "coordinates": [
            [[[179.0, 0.0], [180.0, 0.0], [180.0, 1.0], [179.0, 1.0], [179.0, 0.0]]],
            [[[-180.0, 0.0], [-178.0, 0.0], [-178.0, 1.0], [-180.0, 1.0], [-180.0, 0.0]]],
        ]});
        assert_eq!(zone(&zone_of(&corners))["geometry"], expected);
        let back: Vec<(f64, f64)> = corners.iter().rev().copied().collect();
        assert_eq!(zone(&zone_of(&back))["geometry"]["type"], "MultiPolygon");
        let touching = [(0.0, 180.0), (0.0, -178.0), (1.0, -178.0), (1.0, 180.0)];
        assert_eq!(zone(&zone_of(&touching))["geometry"]["type"], "Polygon");
        let west = [(0.0, 170.0), (0.0, 180.0), (1.0, 180.0)];
        assert_eq!(zone(&zone_of(&west))["geometry"]["type"], "Polygon");
    }

    #[test]
    fn the_sense_of_a_ring_is_seen() {
        let square = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)].map(|(north, east)| Position::new(north, east));
        assert!(!clockwise(&square));
        let turned: Vec<Position> = square.into_iter().rev().collect();
        assert!(clockwise(&turned));
    }
}
