//! Placemarks of a KML 2.2 document (OGC 07-147r2), or of the one inside a KMZ archive: Point, Polygon and MultiGeometry
//! with the data of `ExtendedData` as properties.

use super::placed::{PlacedFeature, feature, typed};
use crate::error::{MissionError, MissionResult};
use geojson::{GeometryValue, JsonObject};
use quick_xml::events::{BytesStart, Event};
use quick_xml::{Reader, XmlVersion};
use std::io::{Cursor, Read};

/// Largest document inside an archive: a small archive can unpack to more than memory holds.
const DOCUMENT_BYTES_MAX: u64 = 64 << 20;
/// Elements inside each other; real documents have about ten.
const DEPTH_MAX: usize = 100;

type Ring = Vec<geojson::Position>;

/// Reads a KML document.
///
/// # Errors
/// Text that is not KML, a link to another document (whose content is missing), or coordinates that are not numbers.
pub(super) fn read(place: &str, bytes: &[u8]) -> MissionResult<Vec<PlacedFeature>> {
    let text = std::str::from_utf8(bytes).map_err(|error| {
        MissionError::data(format!("{place} is not a KML document"))
            .because(error)
            .help("save it as UTF-8, which is what KML uses")
    })?;
    let mut document =
        Document { place, source: text, found: Vec::new(), path: Vec::new(), mark: None, text: String::new() };
    document.read()?;
    Ok(document.found)
}

/// Reads the first KML document of a KMZ archive, which the standard defines as the main one.
///
/// # Errors
/// Bytes that are not an archive, an archive without a document or with one of more than 64 MiB, and every error of [`read`].
pub(super) fn read_archive(place: &str, bytes: &[u8]) -> MissionResult<Vec<PlacedFeature>> {
    let broken = |error: zip::result::ZipError| {
        MissionError::data(format!("{place} is not a KMZ archive"))
            .because(error)
            .help("a KMZ file is a zip archive with a KML document; save it again, or unpack it and name the .kml")
    };
    let mut archive = zip::ZipArchive::new(Cursor::new(bytes)).map_err(broken)?;
    let mut names = archive.file_names().filter_map(|name| name.ok().map(std::borrow::Cow::into_owned));
    let name = names.find(|name| name.to_lowercase().ends_with(".kml"));
    drop(names);
    let Some(name) = name else {
        return Err(MissionError::data(format!("{place} holds no .kml document")));
    };
    let mut text = Vec::new();
    let entry = archive.by_name(&name).map_err(broken)?;
    entry
        .take(DOCUMENT_BYTES_MAX + 1)
        .read_to_end(&mut text)
        .map_err(|error| MissionError::data(format!("{name} in {place} cannot be unpacked")).because(error))?;
    if text.len() as u64 > DOCUMENT_BYTES_MAX {
        return Err(MissionError::data(format!("{name} in {place} is larger than 64 MiB"))
            .help("keep the placemarks of the mission and remove the others"));
    }
    read(&format!("{place}/{name}"), &text)
}

/// State of a placemark while it is read.
#[derive(Default)]
struct Mark {
    line: usize,
    properties: JsonObject,
    /// Name of the datum of `ExtendedData` that is being read.
    datum: Option<String>,
    points: Vec<geojson::Position>,
    lines: Vec<Vec<geojson::Position>>,
    /// Rings of each polygon, the outer one first.
    polygons: Vec<Vec<Ring>>,
}

impl Mark {
    fn has_other_than_lines(&self) -> bool {
        !self.points.is_empty() || self.polygons.iter().any(|rings| !rings.is_empty())
    }
}

struct Document<'a> {
    place: &'a str,
    source: &'a str,
    found: Vec<PlacedFeature>,
    /// Names of the open elements, without prefixes.
    path: Vec<String>,
    mark: Option<Mark>,
    text: String,
}

impl Document<'_> {
    fn read(&mut self) -> MissionResult {
        let mut reader = Reader::from_str(self.source);
        let mut rooted = false;
        loop {
            let event = reader.read_event();
            let offset = usize::try_from(reader.buffer_position()).unwrap_or(usize::MAX);
            match event.map_err(|error| self.not_kml(reader.error_position(), &error))? {
                Event::Start(start) => {
                    rooted |= self.begin(&start, offset)?;
                    if self.path.len() > DEPTH_MAX {
                        return Err(self.wrong(offset, format!("elements are nested deeper than {DEPTH_MAX}")));
                    }
                }
                Event::Empty(start) => {
                    rooted |= self.begin(&start, offset)?;
                    self.end(offset)?;
                }
                Event::End(_) => self.end(offset)?,
                Event::Text(text) => self.text.push_str(&text.xml_content(XmlVersion::default())),
                Event::CData(text) => self.text.push_str(&text),
                Event::GeneralRef(name) => {
                    let text = reference(&name);
                    let text = text.ok_or_else(|| self.wrong(offset, "an entity that XML does not define".into()))?;
                    self.text.push_str(&text);
                }
                Event::Eof => break,
                _ => {}
            }
        }
        if !rooted {
            return Err(MissionError::data(format!("{} is not a KML document", self.place))
                .because("it has no element `kml`")
                .help("export it as KML 2.2, or as a GeoJSON FeatureCollection"));
        }
        if let Some(open) = self.path.last() {
            return Err(self.wrong(self.source.len(), format!("the document ends inside of `{open}`")));
        }
        Ok(())
    }

    /// Returns the line of a place in the document.
    fn line(&self, offset: usize) -> usize {
        1 + self.source.bytes().take(offset).filter(|byte| *byte == b'\n').count()
    }

    fn wrong(&self, offset: usize, what: String) -> MissionError {
        MissionError::data(what).at(format!("{}:{}", self.place, self.line(offset)))
    }

    fn not_kml(&self, offset: u64, error: &dyn std::fmt::Display) -> MissionError {
        let offset = usize::try_from(offset).unwrap_or(usize::MAX);
        self.wrong(offset, format!("{} is not a KML document", self.place)).because(error)
    }

    fn inside(&self, name: &str) -> bool {
        self.path.iter().any(|open| open == name)
    }

    /// Opens an element; true for the root.
    fn begin(&mut self, start: &BytesStart<'_>, offset: usize) -> MissionResult<bool> {
        let name = start.local_name().as_ref().to_string();
        self.text.clear();
        let line = self.line(offset);
        match (name.as_str(), &mut self.mark) {
            ("NetworkLink", _) => {
                return Err(self
                    .wrong(offset, "a NetworkLink refers to another document".to_string())
                    .because("nothing is loaded from a network, and what it would show is unknown")
                    .help("open the document where it is loaded (Google Earth, QGIS) and save its places as KML"));
            }
            ("Placemark", None) => self.mark = Some(Mark { line, ..Mark::default() }),
            ("Data" | "SimpleData", Some(mark)) => {
                let name = start.attributes().flatten().find(|attribute| attribute.key.as_ref() == "name");
                mark.datum = name.map(|name| match name.normalized_value(XmlVersion::default()) {
                    Ok(value) => value.into_owned(),
                    Err(_) => name.value.into_owned(),
                });
            }
            ("Polygon", Some(mark)) => mark.polygons.push(Vec::new()),
            _ => {}
        }
        self.path.push(name);
        Ok(self.path.len() == 1 && self.path.first().is_some_and(|root| root == "kml"))
    }

    /// Ends an element and uses its content.
    fn end(&mut self, offset: usize) -> MissionResult {
        let name = self.path.pop().unwrap_or_default();
        let text = std::mem::take(&mut self.text).trim().to_string();
        let parent = self.path.last().map_or("", String::as_str);
        let Some(mut mark) = self.mark.take() else { return Ok(()) };
        match (name.as_str(), parent) {
            ("name", "Placemark") if !text.is_empty() => {
                mark.properties.insert("name".to_string(), text.into());
            }
            ("value", "Data") | ("SimpleData", _) => {
                if let Some(key) = mark.datum.clone().filter(|_| !text.is_empty()) {
                    let value = typed(&key, &text);
                    // The element `name` of the placemark may also be a datum.
                    if mark.properties.contains_key(&key) && key != "name" {
                        return Err(self
                            .wrong(offset, format!("the placemark states `{key}` twice"))
                            .help("remove one of the two data"));
                    }
                    mark.properties.insert(key, value);
                }
            }
            ("coordinates", "Point") => mark.points.extend(self.coordinates(&text, offset)?.into_iter().next()),
            ("coordinates", "LineString") => {
                let line = self.coordinates(&text, offset)?;
                mark.lines.push(line);
            }
            ("coordinates", "LinearRing") if self.inside("Polygon") => {
                let ring = self.coordinates(&text, offset)?;
                let rings = mark.polygons.last_mut();
                match rings {
                    Some(rings) if self.inside("outerBoundaryIs") => rings.insert(0, ring),
                    Some(rings) => rings.push(ring),
                    None => {}
                }
            }
            ("Track" | "Model", _) => {
                return Err(self
                    .wrong(offset, format!("a {name} cannot be used"))
                    .help("draw a Point, a LineString or a Polygon; remove other placemarks from the file"));
            }
            ("Placemark", _) if mark.lines.len() > 1 || !mark.lines.is_empty() && mark.has_other_than_lines() => {
                return Err(self
                    .wrong(offset, "a placemark mixes a LineString with another geometry".to_string())
                    .because("a target or zone has one geometry, and the others would be left out")
                    .help("make a placemark of each"));
            }
            ("Placemark", _) => {
                self.finish(mark);
                return Ok(());
            }
            _ => {}
        }
        self.mark = Some(mark);
        Ok(())
    }

    /// Reads `longitude,latitude[,height]` separated by white space.
    fn coordinates(&self, text: &str, offset: usize) -> MissionResult<Vec<geojson::Position>> {
        let tuple = |tuple: &str| {
            let mut numbers = tuple.split(',').map(|number| number.trim().parse::<f64>().ok());
            match (numbers.next().flatten(), numbers.next().flatten()) {
                (Some(longitude), Some(latitude)) => Ok(vec![longitude, latitude].into()),
                _ => Err(self
                    .wrong(offset, format!("`{tuple}` is not a position"))
                    .help("KML writes longitude,latitude[,height] in degrees, positions separated by spaces")),
            }
        };
        text.split_whitespace().map(tuple).collect()
    }

    fn finish(&mut self, mut mark: Mark) {
        mark.polygons.retain(|rings| !rings.is_empty());
        let geometry = match (mark.polygons.len(), mark.points.into_iter().next()) {
            (0, None) if !mark.lines.is_empty() => {
                GeometryValue::LineString { coordinates: mark.lines.pop().unwrap_or_default() }
            }
            (0, Some(coordinates)) => GeometryValue::Point { coordinates },
            (0, None) => {
                return self.found.push((
                    self.named(mark.line),
                    geojson::Feature { properties: Some(mark.properties), ..geojson::Feature::default() },
                ));
            }
            (1, _) => GeometryValue::Polygon { coordinates: mark.polygons.pop().unwrap_or_default() },
            _ => GeometryValue::MultiPolygon { coordinates: mark.polygons },
        };
        self.found.push((self.named(mark.line), feature(geometry, mark.properties)));
    }

    fn named(&self, line: usize) -> String {
        format!("{}:{line}: placemark {}", self.place, self.found.len() + 1)
    }
}

/// Returns the text of `&name;`: the five entities of XML and character numbers.
fn reference(name: &quick_xml::events::BytesRef<'_>) -> Option<String> {
    if let Ok(Some(character)) = name.resolve_char_ref() {
        return Some(character.to_string());
    }
    let text = match name.as_ref() {
        "amp" => "&",
        "lt" => "<",
        "gt" => ">",
        "quot" => "\"",
        "apos" => "'",
        _ => return None,
    };
    Some(text.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    const ZACA: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<kml xmlns="http://www.opengis.net/kml/2.2"><Document><Folder>
<Placemark><name>Zaca &amp; north</name>
<ExtendedData><Data name="value"><value>90</value></Data><Data name="light"><value>night</value></Data></ExtendedData>
<Polygon><outerBoundaryIs><LinearRing><coordinates>
-119.8,34.6,0 -119.7,34.6,0 -119.7,34.7,0 -119.8,34.6,0
</coordinates></LinearRing></outerBoundaryIs></Polygon></Placemark>
<Placemark><name>Lick</name><Point><coordinates>-121.45,37.15</coordinates></Point></Placemark>
</Folder></Document></kml>"#;

    #[test]
    fn placemarks_have_names_data_and_geometry() {
        let found = read("fires.kml", ZACA.as_bytes()).unwrap();
        assert_eq!(found.len(), 2);
        let (place, zaca) = &found[0];
        assert_eq!(place, "fires.kml:3: placemark 1");
        assert_eq!(zaca.property("name").unwrap(), "Zaca & north");
        assert_eq!(zaca.property("value").unwrap().as_f64(), Some(90.0));
        assert_eq!(zaca.property("light").unwrap(), "night");
        assert!(
            matches!(&zaca.geometry.as_ref().unwrap().value, GeometryValue::Polygon { coordinates } if coordinates[0].len() == 4)
        );
    }

    #[test]
    fn a_line_is_read_with_its_positions() {
        let text = "<kml><Placemark><name>Pipe</name><LineString><coordinates>-120,40,5 -120.1,40.1</coordinates>\
                    </LineString></Placemark></kml>";
        let found = read("a.kml", text.as_bytes()).unwrap();
        let geometry = &found[0].1.geometry.as_ref().unwrap().value;
        let GeometryValue::LineString { coordinates } = geometry else { panic!("{geometry:?}") };
        assert_eq!(
            coordinates.iter().map(|place| place.as_slice().to_vec()).collect::<Vec<_>>(),
            [vec![-120.0, 40.0], vec![-120.1, 40.1]]
        );
    }

    #[test]
    fn an_archive_is_read_like_its_document() {
        let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
        archive.start_file("doc.kml", zip::write::SimpleFileOptions::default()).unwrap();
        archive.write_all(ZACA.as_bytes()).unwrap();
        let bytes = archive.finish().unwrap().into_inner();
        let found = read_archive("fires.kmz", &bytes).unwrap();
        assert_eq!(found[1].0, "fires.kmz/doc.kml:8: placemark 2");
        assert!(read_archive("fires.kmz", &bytes[..40]).is_err());
    }

    #[test]
    fn links_lines_and_broken_text_are_errors_with_their_line() {
        let wrong = |text: &str| read("a.kml", text.as_bytes()).unwrap_err();
        let link = wrong("<kml>\n<NetworkLink><Link><href>http://x/y.kml</href></Link></NetworkLink></kml>");
        assert_eq!(link.place.as_deref(), Some("a.kml:2"));
        assert!(link.message.contains("NetworkLink"));
        assert!(wrong("<kml><Placemark><Track/></Placemark></kml>").message.contains("a Track cannot be used"));
        let mixed = "<kml><Placemark><MultiGeometry><Point><coordinates>1,2</coordinates></Point>\n\
                     <LineString><coordinates>1,2 1,3</coordinates></LineString></MultiGeometry></Placemark></kml>";
        assert_eq!(wrong(mixed).place.as_deref(), Some("a.kml:2"));
        assert!(wrong(mixed).message.contains("mixes a LineString"));
        let twice = "<kml><Placemark><ExtendedData>\n<Data name='acres'><value>400</value></Data>\n\
                     <Data name='acres'><value>4000</value></Data></ExtendedData></Placemark></kml>";
        assert_eq!(wrong(twice).place.as_deref(), Some("a.kml:3"));
        assert!(wrong(twice).message.contains("`acres` twice"));
        assert!(
            wrong("<kml><Placemark><Point><coordinates>north</coordinates></Point></Placemark></kml>")
                .message
                .contains("`north`")
        );
        assert!(wrong("<kml><Placemark>").message.contains("ends inside"));
        assert!(wrong("<gpx></gpx>").message.contains("not a KML"));
        assert!(wrong("<kml><a></b></kml>").message.contains("not a KML"));
        assert!(wrong("").message.contains("not a KML"));
        assert!(wrong(&format!("<kml>{}", "<a>".repeat(200))).message.contains("deeper"));
    }
}
