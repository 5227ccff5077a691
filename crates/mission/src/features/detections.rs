//! Fire detections of satellites as FIRMS publishes them (NASA, Fire Information for Resource Management System): a CSV
//! table with one row per hot pixel. Pixels close to each other become one fire with the outline of its pixels.

use super::placed::{PlacedFeature, feature};
use crate::error::{MissionError, MissionResult};
use crate::sources::DataFile;
use crate::tables::rows;
use apex_geo::plane::{Plane, Point};
use apex_model::problem::Position;
use geojson::{GeometryValue, JsonObject, JsonValue};

/// Columns that distinguish the table of detections from other tables. The brightness has different names: `brightness` (MODIS),
/// `bright_ti4` (VIIRS).
const COLUMNS: &[&str] = &["latitude", "longitude", "scan", "track", "acq_date", "acq_time"];
/// Distance of the centres, in pixel sizes, below which two pixels belong to one fire: diagonal neighbours with one pixel missing between
/// them.
const GAP_PIXELS: f64 = 3.0;
/// Largest table: detections of a continent in a week are fewer.
const DETECTIONS_MAX: usize = 50_000;
const KM: f64 = 1_000.0;
const SQUARE_METRES_PER_ACRE: f64 = 4_046.856_422_4;

/// One hot pixel.
struct Pixel {
    line: u64,
    position: Position,
    /// Sizes of the pixel across and along the satellite's track; the file has no orientation.
    across_m: f64,
    along_m: f64,
    /// Fire radiative power, if the file contains it.
    power_mw: Option<f64>,
    /// `acq_date acq_time`.
    seen: String,
}

/// Returns true if the names of the columns show a table of detections.
pub(super) fn is_detections(file: &DataFile) -> bool {
    let first = file.bytes.split(|byte| *byte == b'\n').find(|line| !line.starts_with(b"#")).unwrap_or_default();
    let header = String::from_utf8_lossy(first).to_lowercase();
    let names: Vec<&str> = header.split(',').map(str::trim).collect();
    COLUMNS.iter().all(|column| names.contains(column))
}

/// Reads detections and merges them into fires, numbered by their first rows: `fire-1`, `fire-2`. Properties: `acres` (sum of the pixels'
/// areas), `frp_mw` (sum), `detections`, `first_seen` and `last_seen` (UTC, as in the file).
///
/// # Errors
/// A cell that is not a number or out of its range, more than 50,000 rows.
pub(super) fn read(file: &DataFile) -> MissionResult<Vec<PlacedFeature>> {
    let pixels = pixels(file)?;
    let fires = joined(&pixels);
    fires.iter().zip(1..).map(|(members, number)| fire(&file.place, members, number)).collect()
}

fn pixels(file: &DataFile) -> MissionResult<Vec<Pixel>> {
    let (header, rows) = rows(file)?;
    if rows.len() > DETECTIONS_MAX {
        return Err(MissionError::data(format!("{} has {} detections", file.place, rows.len()))
            .because(format!("at most {DETECTIONS_MAX} are read"))
            .help("cut the table to the area and the days of the mission"));
    }
    let column = |name: &str| header.iter().position(|known| known == name);
    let pixel = |(line, cells): &(u64, Vec<String>)| {
        let here = format!("{}:{line}", file.place);
        let text = |name: &str| column(name).and_then(|index| cells.get(index)).map_or("", String::as_str);
        let number = |name: &str, low: f64, high: f64| match text(name).parse::<f64>() {
            Ok(value) if (low..=high).contains(&value) => Ok(value),
            Ok(value) => Err(MissionError::data(format!("`{name}` is {value}, not from {low} to {high}")).at(&here)),
            Err(_) => Err(MissionError::data(format!("`{name}` is `{}`, not a number", text(name))).at(&here)),
        };
        Ok(Pixel {
            line: *line,
            position: Position::new(number("latitude", -90.0, 90.0)?, number("longitude", -180.0, 180.0)?),
            across_m: number("scan", 0.01, 20.0)? * KM,
            along_m: number("track", 0.01, 20.0)? * KM,
            power_mw: if text("frp").is_empty() { None } else { Some(number("frp", 0.0, 1e6)?) },
            seen: format!("{} {:0>4}", text("acq_date"), text("acq_time")),
        })
    };
    rows.iter().map(pixel).collect()
}

/// Returns groups of pixels, each connected by steps of at most [`GAP_PIXELS`] pixel sizes, in the order of their first rows. Bound:
/// quadratic in the pixels of one band of latitudes as high as the greatest step.
fn joined(pixels: &[Pixel]) -> Vec<Vec<&Pixel>> {
    let mut order: Vec<usize> = (0..pixels.len()).collect();
    let latitude = |index: usize| pixels.get(index).map_or(0.0, |pixel| pixel.position.latitude_deg);
    order.sort_by(|a, b| latitude(*a).total_cmp(&latitude(*b)).then(a.cmp(b)));
    let largest_m = pixels.iter().map(|pixel| pixel.across_m.max(pixel.along_m)).fold(0.0, f64::max);
    let band_deg = GAP_PIXELS * largest_m / METRES_PER_DEGREE;
    let mut leader: Vec<usize> = (0..pixels.len()).collect();
    for (place, a) in order.iter().enumerate() {
        for b in order.iter().skip(place + 1).take_while(|b| latitude(**b) - latitude(*a) <= band_deg) {
            let (Some(one), Some(other)) = (pixels.get(*a), pixels.get(*b)) else { continue };
            let step_m = GAP_PIXELS * one.across_m.max(one.along_m).min(other.across_m.max(other.along_m));
            if apex_geo::geodesy::distance_m(one.position, other.position) <= step_m {
                let (low, high) = (root(&leader, *a), root(&leader, *b));
                if let Some(slot) = leader.get_mut(low.max(high)) {
                    *slot = low.min(high);
                }
            }
        }
    }
    let mut groups: Vec<(usize, Vec<&Pixel>)> = Vec::new();
    for (index, pixel) in pixels.iter().enumerate() {
        let first = root(&leader, index);
        match groups.iter_mut().find(|(leader, _)| *leader == first) {
            Some((_, members)) => members.push(pixel),
            None => groups.push((first, vec![pixel])),
        }
    }
    groups.into_iter().map(|(_, members)| members).collect()
}

const METRES_PER_DEGREE: f64 = 111_195.0;

/// Returns the first pixel of the group of `index`. The loop ends because leaders have lower numbers than their followers.
fn root(leader: &[usize], mut index: usize) -> usize {
    while let Some(next) = leader.get(index).copied().filter(|next| *next != index) {
        index = next;
    }
    index
}

/// Returns a fire whose outline is the convex hull of its pixels.
fn fire(place: &str, members: &[&Pixel], number: usize) -> MissionResult<PlacedFeature> {
    let here = format!("{place}:{}", members.first().map_or(0, |pixel| pixel.line));
    let centres: Vec<Position> = members.iter().map(|pixel| pixel.position).collect();
    let plane = Plane::around(&centres);
    let corners = members.iter().filter_map(|pixel| {
        let centre = plane.project(pixel.position)?;
        // Without an orientation each pixel is taken as a square of its longer side: the outline holds the pixel.
        let half_m = 0.5 * pixel.across_m.max(pixel.along_m);
        let corner = |x: f64, y: f64| Point { x: centre.x + x * half_m, y: centre.y + y * half_m };
        Some([corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)])
    });
    let hull = hull(corners.flatten().collect());
    let mut ring: Vec<geojson::Position> = hull
        .iter()
        .map(|point| plane.position(*point))
        .map(|corner| vec![rounded(corner.longitude_deg), rounded(corner.latitude_deg)].into())
        .collect();
    let Some(first) = ring.first().cloned() else {
        return Err(MissionError::data("the detections of a fire span more than the map can show at once").at(here));
    };
    ring.push(first);
    let acres = members.iter().map(|pixel| pixel.across_m * pixel.along_m).sum::<f64>() / SQUARE_METRES_PER_ACRE;
    let mut properties = JsonObject::new();
    let mut set = |key: &str, value: JsonValue| properties.insert(key.to_string(), value);
    set("id", format!("fire-{number}").into());
    set("name", format!("Fire {number}").into());
    set("kind", "fire".into());
    set("acres", rounded(acres).into());
    set("detections", members.len().into());
    let power_mw: Vec<f64> = members.iter().filter_map(|pixel| pixel.power_mw).collect();
    if !power_mw.is_empty() {
        set("frp_mw", rounded(power_mw.iter().sum()).into());
    }
    let seen = || members.iter().map(|pixel| pixel.seen.as_str());
    set("first_seen", seen().min().unwrap_or_default().into());
    set("last_seen", seen().max().unwrap_or_default().into());
    Ok((here, feature(GeometryValue::Polygon { coordinates: vec![ring] }, properties)))
}

/// Rounds to six decimals; in degrees, about a tenth of a metre.
fn rounded(value: f64) -> f64 {
    (value * 1e6).round() / 1e6
}

/// Returns the convex hull counter-clockwise (monotone chain, Andrew 1979).
fn hull(mut points: Vec<Point>) -> Vec<Point> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let half = |points: &mut dyn Iterator<Item = Point>| {
        let mut chain: Vec<Point> = Vec::new();
        for point in points {
            while let [.., a, b] = chain.as_slice() {
                if (b.x - a.x) * (point.y - a.y) - (b.y - a.y) * (point.x - a.x) > 0.0 {
                    break;
                }
                chain.pop();
            }
            chain.push(point);
        }
        chain.pop();
        chain
    };
    let mut lower = half(&mut points.iter().copied());
    lower.extend(half(&mut points.iter().rev().copied()));
    lower
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str = "latitude,longitude,bright_ti4,scan,track,acq_date,acq_time,satellite,instrument,confidence,version,bright_ti5,frp,daynight";

    fn file(rows: &[&str]) -> DataFile {
        DataFile { place: "viirs.csv".into(), bytes: format!("{HEADER}\n{}\n", rows.join("\n")).into_bytes() }
    }

    #[test]
    fn pixels_that_touch_are_one_fire_and_distant_ones_are_two() {
        let file = file(&[
            "34.700,-119.700,330,0.4,0.4,2007-09-08,0942,N,VIIRS,n,2,290,5.5,N",
            "34.704,-119.700,335,0.4,0.4,2007-09-08,2130,N,VIIRS,n,2,290,4.5,D",
            "36.000,-119.700,320,0.5,0.4,2007-09-08,942,N,VIIRS,n,2,290,2,N",
        ]);
        assert!(is_detections(&file));
        let fires = read(&file).unwrap();
        assert_eq!(fires.len(), 2);
        let (place, first) = &fires[0];
        assert_eq!(place, "viirs.csv:2");
        let number = |key: &str| first.property(key).unwrap().as_f64().unwrap();
        assert_eq!((number("detections"), number("frp_mw")), (2.0, 10.0));
        assert!((number("acres") - 2.0 * 160_000.0 / SQUARE_METRES_PER_ACRE).abs() < 1e-3);
        assert_eq!(first.property("first_seen").unwrap(), "2007-09-08 0942");
        assert_eq!(fires[1].1.property("first_seen").unwrap(), "2007-09-08 0942", "times have four digits");
    }

    #[test]
    fn a_cell_that_is_not_a_number_names_its_line() {
        let error = read(&file(&["34.7,west,330,0.4,0.4,2007-09-08,942,N,VIIRS,n,2,290,5,N"])).unwrap_err();
        assert_eq!(error.place.as_deref(), Some("viirs.csv:2"));
        assert!(error.message.contains("`longitude` is `west`"), "{error:?}");
    }

    #[test]
    fn the_outline_holds_every_pixel() {
        let rows: Vec<String> = (0..40)
            .map(|n| {
                format!(
                    "{:.4},{:.4},330,0.4,0.4,2007-09-08,942,N,V,n,2,290,5,N",
                    34.7 + 0.003 * f64::from(n % 7),
                    -119.7 + 0.004 * f64::from(n % 11)
                )
            })
            .collect();
        let fires = read(&file(&rows.iter().map(String::as_str).collect::<Vec<_>>())).unwrap();
        assert_eq!(fires.len(), 1);
        let Some(GeometryValue::Polygon { coordinates }) = fires[0].1.geometry.as_ref().map(|g| &g.value) else {
            panic!()
        };
        // Each centre lies left of every edge of the counter-clockwise outline.
        for n in 0..40 {
            let (lat, lon) = (34.7 + 0.003 * f64::from(n % 7), -119.7 + 0.004 * f64::from(n % 11));
            for pair in coordinates[0].windows(2) {
                let ([ax, ay], [bx, by]) = ([pair[0][0], pair[0][1]], [pair[1][0], pair[1][1]]);
                assert!((bx - ax) * (lat - ay) - (by - ay) * (lon - ax) > 0.0);
            }
        }
    }
}
