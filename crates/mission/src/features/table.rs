//! Reads the places of a CSV table: each row is a Point. Columns are properties with the names of docs/reference/mission-data.md.

use super::placed::{PlacedFeature, feature, typed};
use crate::error::{MissionError, MissionResult};
use crate::sources::DataFile;
use crate::tables::rows;
use geojson::{GeometryValue, JsonObject};

/// Names of the position columns in the tables of several programs.
const LATITUDE: &[&str] = &["latitude_deg", "latitude", "lat"];
const LONGITUDE: &[&str] = &["longitude_deg", "longitude", "lon", "lng"];

/// Reads a table with a header. An empty cell is a missing property. A cell that contains JSON (a number, `true`, a list) has that value;
/// any other cell is text.
///
/// # Errors
/// Text that is not a table, no columns of a position, a position that is not a number.
pub(super) fn read(file: &DataFile) -> MissionResult<Vec<PlacedFeature>> {
    let (header, rows) = rows(file)?;
    let place = &file.place;
    let column = |names: &[&str]| header.iter().position(|name| names.contains(&name.as_str()));
    let (Some(latitude), Some(longitude)) = (column(LATITUDE), column(LONGITUDE)) else {
        return Err(MissionError::data("a table of places needs the columns `latitude_deg` and `longitude_deg`")
            .at(place)
            .because(format!("its first line names {}", header.join(", ")))
            .help("give the columns these names; other columns are properties (docs/reference/mission-data.md)"));
    };
    rows.iter()
        .map(|(line, cells)| {
            let here = format!("{place}:{line}");
            let cell = |index: usize| cells.get(index).map_or("", String::as_str);
            let degrees = |index: usize, name: &str| {
                cell(index).parse::<f64>().map_err(|_| {
                    MissionError::data(format!("`{name}` is `{}`, not a number", cell(index)))
                        .at(&here)
                        .help("write degrees with a point: 34.716, -119.783")
                })
            };
            let position = vec![degrees(longitude, "longitude_deg")?, degrees(latitude, "latitude_deg")?];
            let mut properties = JsonObject::new();
            for (index, name) in header.iter().enumerate() {
                if index != latitude && index != longitude && !cell(index).is_empty() {
                    properties.insert(name.clone(), typed(name, cell(index)));
                }
            }
            Ok((here, feature(GeometryValue::Point { coordinates: position.into() }, properties)))
        })
        .collect()
}
