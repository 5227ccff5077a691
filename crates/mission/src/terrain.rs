//! The terrain of a mission (`:terrain`): grids of elevations from files, and the check that places agree with them.
//!
//! Files are ESRI ASCII grids in degrees (`.asc`) and SRTM tiles (`.hgt`). Each place of a mission must lie on the grids, and a stated
//! elevation must agree with the grid there, because only one of two different elevations can be right.

use crate::error::{MissionError, MissionResult};
use crate::sources::DataFile;
use apex_geo::geodesy::Position;
use apex_geo::terrain::{Terrain, TerrainGrid};
use std::str::FromStr;

/// Keys of the header of an ASCII grid.
const KEYS: &str =
    "ncols, nrows, xllcorner or xllcenter, yllcorner or yllcenter, cellsize (or dx and dy), NODATA_value";
/// Posts along a side of SRTM tiles of 3 and of 1 arc seconds.
const TILE_POSTS: [usize; 2] = [1_201, 3_601];
/// Number in a tile for a post without a known elevation.
const TILE_VOID: i16 = -32_768;
/// Difference allowed between a stated elevation and the ground there: geoids, levelled airfields, coarse grids.
const STATED_M: f64 = 150.0;

/// Reads one file of elevations. The file name's extension determines the format.
///
/// # Errors
/// Another format; a header or number that is invalid, with its line; a tile of another size or name.
pub(crate) fn grid(file: &DataFile) -> MissionResult<TerrainGrid> {
    let extension = file.place.rsplit_once('.').map(|(_, end)| end.to_lowercase());
    match extension.as_deref() {
        Some("asc") => ascii_grid(&file.place, &file.text()?),
        Some("hgt") => tile(&file.place, &file.bytes),
        _ => Err(MissionError::data("the format of a terrain file is not known")
            .at(&file.place)
            .because("its name ends in neither `.asc` nor `.hgt`")
            .help("convert it, for example: gdal_translate -of AAIGrid ground.tif ground.asc")),
    }
}

/// Header of an ASCII grid.
#[derive(Default)]
struct Header {
    columns: Option<usize>,
    rows: Option<usize>,
    /// Longitude and latitude of the south-western post or corner; true for a corner.
    west: Option<(f64, bool)>,
    south: Option<(f64, bool)>,
    east_step: Option<f64>,
    north_step: Option<f64>,
    void: Option<f64>,
}

fn ascii_grid(place: &str, text: &str) -> MissionResult<TerrainGrid> {
    let mut header = Header::default();
    let mut lines = text.lines().enumerate().map(|(index, line)| (index + 1, line)).peekable();
    while let Some((number, line)) = lines.peek().copied() {
        let mut words = line.split_whitespace();
        let Some(key) = words.next() else {
            lines.next();
            continue;
        };
        if f64::from_str(key).is_ok() {
            break;
        }
        header.take(place, number, key, words.next())?;
        lines.next();
    }
    let missing = |key: &str| {
        MissionError::data(format!("the header of the terrain file lacks `{key}`"))
            .at(place)
            .help(format!("an ASCII grid begins with {KEYS}, each on its own line"))
    };
    let (columns, rows) =
        (header.columns.ok_or_else(|| missing("ncols"))?, header.rows.ok_or_else(|| missing("nrows"))?);
    let east_step = header.east_step.ok_or_else(|| missing("cellsize"))?;
    let north_step = header.north_step.ok_or_else(|| missing("cellsize"))?;
    // A header with a corner gives the corner of the cell; the elevation belongs to its middle.
    let (west, at_corner) = header.west.ok_or_else(|| missing("xllcorner"))?;
    let longitude_deg = west + if at_corner { 0.5 * east_step } else { 0.0 };
    let (south, at_corner) = header.south.ok_or_else(|| missing("yllcorner"))?;
    let latitude_deg = south + if at_corner { 0.5 * north_step } else { 0.0 };
    if south.abs() > 90.0 && west.abs() <= 90.0 && south.abs() <= 180.0 {
        return Err(MissionError::data("the terrain file has its south-western corner at no latitude")
            .at(place)
            .because(format!("`yllcorner` is {south}, and latitudes are from -90 to 90; `xllcorner` is {west}"))
            .help("the two are probably exchanged: `xllcorner` is the longitude, `yllcorner` the latitude"));
    }
    if west.abs() > 360.0 || south.abs() > 90.0 {
        return Err(MissionError::data("the terrain file is not in degrees of latitude and longitude")
            .at(place)
            .because(format!("its south-western corner is at {west} and {south}, as in a projection in metres"))
            .help("project it, for example: gdalwarp -t_srs EPSG:4326 ground.tif degrees.tif"));
    }
    let posts = columns.saturating_mul(rows);
    if posts > apex_geo::terrain::POSTS_MAX {
        return Err(MissionError::data(format!("the terrain file has {columns} x {rows} posts"))
            .at(place)
            .because(format!("at most {} are read", apex_geo::terrain::POSTS_MAX))
            .help("cut out the area of the mission, or take a coarser grid"));
    }
    let mut from_north: Vec<f32> = Vec::with_capacity(posts.min(text.len() / 2 + 1));
    for (number, line) in lines {
        for word in line.split_whitespace() {
            let elevation_m =
                f32::from_str(word).ok().filter(|elevation_m| elevation_m.is_finite()).ok_or_else(|| {
                    MissionError::data(format!("`{word}` is not an elevation"))
                        .at(format!("{place}:{number}"))
                        .help("write metres above mean sea level, or the number of NODATA_value")
                })?;
            let is_void = header.void.is_some_and(|void| f64::from(elevation_m) == f64::from(void as f32));
            from_north.push(if is_void { f32::NAN } else { elevation_m });
        }
    }
    if from_north.len() != posts {
        return Err(MissionError::data(format!("the terrain file has {} elevations", from_north.len()))
            .at(place)
            .because(format!("its header states {columns} columns and {rows} rows, which are {posts}"))
            .help("check whether the file is complete"));
    }
    made(place, Position::new(latitude_deg, longitude_deg), (north_step, east_step), (rows, columns), &from_north)
}

impl Header {
    fn take(&mut self, place: &str, line: usize, key: &str, value: Option<&str>) -> MissionResult {
        let number = value.and_then(|value| f64::from_str(value).ok()).filter(|number| number.is_finite());
        let wrong =
            |what: String| MissionError::data(what).at(format!("{place}:{line}")).help(format!("known are {KEYS}"));
        let number = number.ok_or_else(|| wrong(format!("`{key} {}` is not a number", value.unwrap_or_default())))?;
        let count = || {
            let is_count = (2.0..=1e6).contains(&number) && libm::floor(number) == number;
            is_count
                .then_some(number as usize)
                .ok_or_else(|| wrong(format!("`{key} {number}` is not a whole number from 2 to 1e6")))
        };
        let step = || (number > 0.0).then_some(number).ok_or_else(|| wrong(format!("`{key} {number}` is not above 0")));
        match key.to_lowercase().as_str() {
            "ncols" => self.columns = Some(count()?),
            "nrows" => self.rows = Some(count()?),
            "xllcorner" => self.west = Some((number, true)),
            "xllcenter" => self.west = Some((number, false)),
            "yllcorner" => self.south = Some((number, true)),
            "yllcenter" => self.south = Some((number, false)),
            "cellsize" => (self.east_step, self.north_step) = (Some(step()?), Some(step()?)),
            "dx" => self.east_step = Some(step()?),
            "dy" => self.north_step = Some(step()?),
            "nodata_value" => self.void = Some(number),
            _ => return Err(wrong(format!("`{key}` is not a key of an ASCII grid"))),
        }
        Ok(())
    }
}

/// Returns a tile of the Shuttle Radar Topography Mission: big-endian 16-bit metres from the north-western post on; its name states the
/// south-western post.
fn tile(place: &str, bytes: &[u8]) -> MissionResult<TerrainGrid> {
    let name = place.rsplit(['/', '\\']).next().unwrap_or(place);
    let corner = tile_corner(name).ok_or_else(|| {
        MissionError::data(format!("the name `{name}` does not state the position of the tile"))
            .at(place)
            .help("name a tile by its south-western corner, for example N34W118.hgt")
    })?;
    let Some(posts) = TILE_POSTS.into_iter().find(|posts| 2 * posts * posts == bytes.len()) else {
        let sizes = TILE_POSTS.map(|posts| (2 * posts * posts).to_string()).join(" or ");
        return Err(MissionError::data(format!("the tile has {} bytes", bytes.len()))
            .at(place)
            .because(format!("a tile of 3 or 1 arc seconds has {sizes}"))
            .help("unpack it, and check whether it is complete"));
    };
    let elevation = |pair: &[u8]| {
        let metres = i16::from_be_bytes([pair.first().copied().unwrap_or(0), pair.get(1).copied().unwrap_or(0)]);
        if metres == TILE_VOID { f32::NAN } else { f32::from(metres) }
    };
    let from_north: Vec<f32> = bytes.chunks_exact(2).map(elevation).collect();
    let step_deg = 1.0 / (posts - 1) as f64;
    made(place, corner, (step_deg, step_deg), (posts, posts), &from_north)
}

/// `N34W118.hgt`
fn tile_corner(name: &str) -> Option<Position> {
    let stem = name.get(..7)?;
    let sign = |letter: &str, plus: &str, minus: &str| match letter.to_uppercase() {
        letter if letter == plus => Some(1.0),
        letter if letter == minus => Some(-1.0),
        _ => None,
    };
    let number = |digits: &str| digits.parse::<u32>().ok().map(f64::from);
    let latitude_deg = sign(stem.get(..1)?, "N", "S")? * number(stem.get(1..3)?)?;
    let longitude_deg = sign(stem.get(3..4)?, "E", "W")? * number(stem.get(4..7)?)?;
    (latitude_deg.abs() <= 90.0 && longitude_deg.abs() <= 180.0).then(|| Position::new(latitude_deg, longitude_deg))
}

/// Returns the grid of posts that a file gives from the northern row on.
fn made(
    place: &str,
    south_west: Position,
    step_deg: (f64, f64),
    (rows, columns): (usize, usize),
    from_north: &[f32],
) -> MissionResult<TerrainGrid> {
    let elevations_m: Vec<f32> = from_north.chunks(columns).rev().flatten().copied().collect();
    TerrainGrid::new(south_west, step_deg, (rows, columns), elevations_m).map_err(|reason| {
        MissionError::data("the terrain file is invalid")
            .at(place)
            .because(reason)
            .help("check the header and the elevations; they are metres above mean sea level")
    })
}

/// Returns the elevation of a place of the mission: the stated one, which must agree with the terrain, or that of the terrain; 0 if
/// neither is known.
///
/// # Errors
/// If the terrain does not cover the place, or has another elevation there.
pub(crate) fn elevation_m(
    terrain: Option<&Terrain>,
    position: Position,
    stated_m: Option<f64>,
) -> Result<f64, Mismatch> {
    let Some(terrain) = terrain else { return Ok(stated_m.unwrap_or(0.0)) };
    let ground_m = terrain.elevation_m_at(position).ok_or(Mismatch::NotCovered { position })?;
    match stated_m {
        Some(stated_m) if (stated_m - ground_m).abs() > STATED_M => Err(Mismatch::Other { stated_m, ground_m }),
        Some(stated_m) => Ok(stated_m),
        None => Ok(ground_m),
    }
}

/// Disagreement of a place and the terrain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Mismatch {
    /// The terrain does not reach the place.
    NotCovered {
        /// The place.
        position: Position,
    },
    /// The stated elevation differs from that of the terrain.
    Other {
        /// Elevation in the file of the place.
        stated_m: f64,
        /// Elevation of the terrain there.
        ground_m: f64,
    },
}

impl Mismatch {
    /// Returns the error for `what`, whose place in the data is `place`.
    pub(crate) fn error(self, what: &str, place: &str) -> MissionError {
        match self {
            Mismatch::NotCovered { position } => {
                MissionError::data(format!("the terrain of `:terrain` does not cover {what}"))
                    .at(place)
                    .because(format!(
                        "no elevation is known at ({:.5} {:.5})",
                        position.latitude_deg, position.longitude_deg
                    ))
                    .help("add a file that covers it to `:terrain`, or take it out of the mission")
            }
            Mismatch::Other { stated_m, ground_m } => {
                MissionError::data(format!("`elevation_m` of {what} differs from the terrain"))
                    .at(place)
                    .because(format!(
                        "it is {stated_m:.0} m, and the ground of `:terrain` lies at {ground_m:.0} m there; they may differ by {STATED_M:.0} m"
                    ))
                    .help("leave `elevation_m` out, correct it, or correct the position")
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(place: &str, bytes: &[u8]) -> DataFile {
        DataFile { place: place.to_string(), bytes: bytes.to_vec() }
    }

    const GRID: &str =
        "ncols 3\nnrows 2\nxllcorner -120.5\nyllcorner 34\ncellsize 1\nNODATA_value -9999\n10 20 30\n40 -9999 60\n";

    #[test]
    fn an_ascii_grid_begins_in_the_north_west_and_its_posts_are_middles_of_cells() {
        let grid = |text: &str| super::grid(&file("a.asc", text.as_bytes())).unwrap();
        assert_eq!(grid(GRID).elevation_m_at(Position::new(35.0, -119.5)), None, "next to the unknown post");
        let whole = GRID.replace("-9999 60", "50 60");
        assert_eq!(grid(&whole).elevation_m_at(Position::new(35.5, -120.0)), Some(10.0));
        assert_eq!(grid(&whole).elevation_m_at(Position::new(34.5, -118.0)), Some(60.0));
        let centred = whole.replace("xllcorner -120.5", "XLLCENTER -120");
        assert_eq!(grid(&centred).elevation_m_at(Position::new(35.0, -119.0)), Some(35.0));
    }

    #[test]
    fn a_tile_is_named_by_its_south_western_corner() {
        let mut bytes = vec![0; 2 * 1_201 * 1_201];
        bytes[0..2].copy_from_slice(&1_234i16.to_be_bytes());
        let grid = grid(&file("data/N34W118.hgt", &bytes)).unwrap();
        assert_eq!(grid.elevation_m_at(Position::new(35.0, -118.0)), Some(1_234.0));
        assert_eq!(tile_corner("S01E033.hgt"), Some(Position::new(-1.0, 33.0)));
        assert_eq!(tile_corner("ground.hgt"), None);
    }

    #[test]
    fn what_is_wrong_in_a_file_is_named_with_its_line() {
        let refused =
            |from: &str, to: &str| grid(&file("a.asc", GRID.replace(from, to).as_bytes())).unwrap_err().to_string();
        assert!(refused("40 -9999", "40 x").contains("a.asc:8"));
        assert!(refused("40 -9999 60", "40").contains("4 elevations"));
        assert!(refused("ncols 3", "ncols 2.5").contains("a.asc:1"));
        assert!(refused("cellsize 1", "cellsize 0").contains("above 0"));
        assert!(refused("cellsize 1\n", "").contains("lacks `cellsize`"));
        assert!(refused("yllcorner 34", "yllcorner 3800000").contains("gdalwarp"));
        assert!(refused("NODATA_value", "nonsense").contains("`nonsense`"));
        assert!(refused("30\n", "30000\n").contains("30000 m"));
        assert!(grid(&file("a.tif", b"")).unwrap_err().to_string().contains(".asc"));
        assert!(grid(&file("N34W118.hgt", b"12")).unwrap_err().to_string().contains("2 bytes"));
    }
}
