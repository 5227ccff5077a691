//! Surroundings of a mission: airspace, airfields, wind, crew (docs/reference/mission-data.md).

use super::{features, tables};
use crate::error::MissionResult;
use crate::sources::DataFile;
use apex_geo::plane::{Plane, Point};
use apex_geo::terrain::Terrain;
use apex_geo::travel::crossing;
use apex_model::problem::{
    AirspaceZone, Area, CrewMember, FOREVER_S, Position, TimeWindow, WindField, WindLayer, ZoneKind,
};

/// A place where the vehicle can land.
#[derive(Debug, Clone)]
pub struct Airfield {
    /// Its name in PDL.
    pub id: String,
    /// Position.
    pub position: Position,
    /// Above mean sea level.
    pub elevation_m: f64,
}

/// Reads airspace zones. A zone with several polygons or several spans of time becomes several zones.
///
/// # Errors
/// As docs/reference/mission-data.md lists them.
pub(crate) fn airspace(file: &DataFile) -> MissionResult<Vec<AirspaceZone>> {
    let mut zones = Vec::new();
    for feature in features::read(file)? {
        let kind = match feature.word("kind", &["restricted", "permitted"])? {
            Some("permitted") => ZoneKind::Permitted,
            _ => ZoneKind::Restricted,
        };
        let altitude_m_min = feature.number("altitude_m_min", -500.0, 1e6)?.unwrap_or(0.0);
        let altitude_m_max = feature.number("altitude_m_max", -500.0, 1e6)?.unwrap_or(100_000.0);
        if altitude_m_max <= altitude_m_min {
            return Err(feature.trouble(format!(
                "its upper face ({altitude_m_max} m) is not above its lower face ({altitude_m_min} m)"
            )));
        }
        let polygons = feature.polygons()?;
        if polygons.is_empty() {
            return Err(feature.trouble("airspace must be a Polygon or MultiPolygon"));
        }
        if feature.has_holes() {
            return Err(feature
                .trouble("airspace with a hole")
                .because("the hole would be ignored")
                .help("cut the area into polygons without holes, as a MultiPolygon or as separate features"));
        }
        for corners in &polygons {
            in_order(&feature, corners)?;
        }
        let mut spans = feature.spans_s("active_h")?;
        if spans.is_empty() {
            spans.push(TimeWindow::ALWAYS);
        }
        for corners in polygons {
            for active in &spans {
                zones.push(AirspaceZone {
                    name: feature.name.clone(),
                    kind,
                    corners: corners.clone(),
                    altitude_m_min,
                    altitude_m_max,
                    active: *active,
                });
            }
        }
    }
    Ok(zones)
}

/// Returns true if all points are within a centimetre of one straight line.
fn in_one_line(points: &[Point]) -> bool {
    let first = points.first().copied().unwrap_or_default();
    let distance = |point: &Point| point.minus(first).length();
    let farthest = points.iter().copied().max_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or_default();
    let Some(along) = farthest.minus(first).unit() else { return true };
    points.iter().all(|point| along.cross(point.minus(first)).abs() < 0.01)
}

/// Refuses an outline that crosses itself or encloses nothing.
fn in_order(feature: &features::NamedFeature, corners: &[Position]) -> MissionResult<()> {
    let plane = Plane::around(corners);
    let flat: Option<Vec<Point>> = corners.iter().map(|corner| plane.project(*corner)).collect();
    let Some(flat) = flat else {
        return Err(feature.trouble("its corners lie more than 8,000 km apart").help("cut the area into smaller ones"));
    };
    if in_one_line(&flat) {
        return Err(feature
            .trouble("its polygon encloses no area")
            .because("its corners lie in one line or at one place")
            .help("give three or more corners around an area"));
    }
    let Some((first, second)) = crossing(&flat) else { return Ok(()) };
    let edge = |number: usize| {
        let at = |index: usize| corners.get(index % corners.len()).copied().unwrap_or_default();
        let (from, to) = (at(number), at(number + 1));
        format!("[{} {}] to [{} {}]", from.longitude_deg, from.latitude_deg, to.longitude_deg, to.latitude_deg)
    };
    Err(feature
        .trouble("its outline crosses itself")
        .because(format!(
            "the edge from corner {} ({}) meets the edge from corner {} ({})",
            first + 1,
            edge(first),
            second + 1,
            edge(second)
        ))
        .help("give the corners in order around the area, each once; two areas are two polygons"))
}

/// Reads airfields on this ground.
///
/// # Errors
/// As docs/reference/mission-data.md lists them.
pub(crate) fn airfields(file: &DataFile, terrain: Option<&Terrain>) -> MissionResult<Vec<Airfield>> {
    features::read(file)?
        .iter()
        .map(|feature| {
            feature.word("kind", &["base", "landing-place"])?;
            Ok(Airfield {
                id: feature.id.clone(),
                position: feature.position()?,
                elevation_m: feature.elevation_m(terrain)?,
            })
        })
        .collect()
}

const WIND_COLUMNS: &[&str] = &["altitude_m_min", "altitude_m_max", "wind_from_deg", "wind_speed_mps"];
const WIND_COLUMNS_OPTIONAL: &[&str] =
    &["south_deg", "north_deg", "west_deg", "east_deg", "from_h", "until_h", "edr", "turbulence"];
/// EDR per unit of the former column `turbulence`, which ranged from 0 (smooth) to 1 (severe). ICAO Annex 3 calls an EDR above 0.45
/// severe.
const EDR_PER_TURBULENCE: f64 = 0.5;
/// Greatest EDR of a wind table, m^(2/3)/s: about twice the lower bound of severe turbulence.
const EDR_MAX: f64 = 1.0;

/// Reads a wind field.
///
/// # Errors
/// As docs/reference/mission-data.md lists them.
pub(crate) fn wind(file: &DataFile) -> MissionResult<WindField> {
    let table = tables::read(file, WIND_COLUMNS, WIND_COLUMNS_OPTIONAL)?;
    let layers = table.rows().map(|row| wind_layer(&row)).collect::<MissionResult<Vec<_>>>()?;
    Ok(WindField { layers, blend: true })
}

/// Returns the area of a row by its four edges; `None` if it has none.
pub(crate) fn area_of(row: &tables::TableRow<'_>) -> MissionResult<Option<Area>> {
    let edges = [
        row.number("south_deg", -90.0, 90.0)?,
        row.number("north_deg", -90.0, 90.0)?,
        row.number("west_deg", -180.0, 180.0)?,
        row.number("east_deg", -180.0, 180.0)?,
    ];
    match edges {
        [None, None, None, None] => Ok(None),
        [Some(south_deg), Some(north_deg), Some(west_deg), Some(east_deg)] if south_deg < north_deg => {
            Ok(Some(Area { south_deg, north_deg, west_deg, east_deg }))
        }
        [Some(_), Some(_), Some(_), Some(_)] => {
            Err(row.trouble("the area's southern edge is not south of its northern edge"))
        }
        _ => Err(row.trouble("an area needs all four edges, or none of them")),
    }
}

/// Returns the span of a row between `from_h` and `until_h`, in seconds; without them it has no beginning or end.
pub(crate) fn hours_of(row: &tables::TableRow<'_>) -> MissionResult<(f64, f64)> {
    let from_s = row.number("from_h", -1e6, 1e6)?.map_or(-FOREVER_S, |hours| hours * 3600.0);
    let until_s = row.number("until_h", -1e6, 1e6)?.map_or(FOREVER_S, |hours| hours * 3600.0);
    Ok((from_s, until_s))
}

fn wind_layer(row: &tables::TableRow<'_>) -> MissionResult<WindLayer> {
    let area = area_of(row)?;
    let altitude_m_min = row.required("altitude_m_min", -500.0, 1e6)?;
    let altitude_m_max = row.required("altitude_m_max", -500.0, 1e6)?;
    let (from_s, until_s) = hours_of(row)?;
    if altitude_m_max <= altitude_m_min {
        return Err(row.trouble("the layer's upper face is not above its lower face"));
    }
    if until_s <= from_s {
        return Err(row.trouble("the layer ends before it begins"));
    }
    let towards_rad = (row.required("wind_from_deg", 0.0, 360.0)? + 180.0).to_radians();
    let speed_mps = row.required("wind_speed_mps", 0.0, 150.0)?;
    Ok(WindLayer {
        area,
        altitude_m_min,
        altitude_m_max,
        from_s,
        until_s,
        wind_east_mps: speed_mps * libm::sin(towards_rad),
        wind_north_mps: speed_mps * libm::cos(towards_rad),
        edr: edr(row)?,
    })
}

/// Reads the turbulence of a row as EDR: from the column `edr`, otherwise from the former column `turbulence`.
fn edr(row: &tables::TableRow<'_>) -> MissionResult<f64> {
    let edr = row.number("edr", 0.0, EDR_MAX)?;
    let turbulence = row.number("turbulence", 0.0, 1.0)?;
    if edr.is_some() && turbulence.is_some() {
        return Err(row
            .trouble("both `edr` and `turbulence` are given")
            .because("they describe the same thing: `turbulence` is read as an EDR of half its number")
            .help("delete the column `turbulence`"));
    }
    Ok(edr.or(turbulence.map(|number| EDR_PER_TURBULENCE * number)).unwrap_or(0.0))
}

/// Reads the crew of the mission; wages are money, of which `money_per_point` makes a point.
///
/// # Errors
/// As docs/reference/mission-data.md lists them.
pub(crate) fn people(file: &DataFile, money_per_point: f64) -> MissionResult<Vec<CrewMember>> {
    let table = tables::read(file, &["role", "wage_per_hour"], &["fixed_hours", "flight_share"])?;
    table
        .rows()
        .map(|row| {
            Ok(CrewMember {
                role: row.text("role").ok_or_else(|| row.trouble("`role` is empty"))?.to_string(),
                wage_per_hour: row.required("wage_per_hour", 0.0, 1e9)? / money_per_point,
                fixed_hours: row.number("fixed_hours", 0.0, 1e6)?.unwrap_or(0.0),
                flight_share: row.number("flight_share", 0.0, 1.0)?.unwrap_or(1.0),
            })
        })
        .collect()
}
