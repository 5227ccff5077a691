//! A plan as KML 2.2, for globes: the path in the air, targets with times, airspace with its upper face.
//! `quick-xml` writes and escapes; elements that belong together share a line.

use super::chart::{Chart, ChartPoint, ChartTarget};
use super::civil::utc;
use apex_model::problem::{AirspaceZone, FOREVER_S, Position, ZoneKind};
use apex_model::time::Time;
use quick_xml::events::{BytesDecl, BytesText, Event};
use serde_json::Value;
use std::fmt::Write;
use std::io;

type Xml = quick_xml::Writer<Vec<u8>>;

/// Zones that reach higher are drawn on the ground: a wall of that height would hide the rest.
const WALL_M_MAX: f64 = 30_000.0;

/// Name of a style, its parts, and their values.
type KmlStyle = (&'static str, &'static [(&'static str, &'static [(&'static str, &'static str)])]);

/// Colours are `aabbggrr`.
const STYLES: &[KmlStyle] = &[
    ("path", &[("LineStyle", &[("color", "ff00a5ff"), ("width", "3")])]),
    ("target", &[("IconStyle", &[("color", "ff50c878")])]),
    ("left-out", &[("IconStyle", &[("color", "ff808080")])]),
    ("restricted", &[("LineStyle", &[("color", "ff0000ff")]), ("PolyStyle", &[("color", "400000ff")])]),
    ("permitted", &[("LineStyle", &[("color", "ff00aa00")]), ("PolyStyle", &[("fill", "0")])]),
];

/// Returns the chart as a document of KML.
pub fn write(chart: &Chart) -> String {
    let mut xml = Xml::new(Vec::new());
    // Writing to memory cannot fail.
    let _ = document(&mut xml, chart);
    String::from_utf8_lossy(&xml.into_inner()).into_owned()
}

fn document(xml: &mut Xml, chart: &Chart) -> io::Result<()> {
    xml.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
    line(xml)?;
    let root = xml.create_element("kml").with_attribute(("xmlns", "http://www.opengis.net/kml/2.2"));
    root.write_inner_content(|xml| {
        line(xml)?;
        element(xml, "Document", |xml| {
            line(xml)?;
            content(xml, chart)
        })?;
        line(xml)
    })?;
    line(xml)
}

fn content(xml: &mut Xml, chart: &Chart) -> io::Result<()> {
    leaf(xml, "name", &chart.name)?;
    line(xml)?;
    leaf(xml, "description", &chart.summary)?;
    line(xml)?;
    STYLES.iter().try_for_each(|each| style(xml, each))?;
    path(xml, chart)?;
    for (name, place) in [("start", chart.start), ("base", chart.base)] {
        let Some(place) = place else { continue };
        element(xml, "Placemark", |xml| {
            leaf(xml, "name", name)?;
            point(xml, place)
        })?;
        line(xml)?;
    }
    folder(xml, "targets", &chart.targets, |xml, each| target(xml, chart, each))?;
    folder(xml, "airspace", &chart.zones, zone)
}

fn style(xml: &mut Xml, (name, parts): &KmlStyle) -> io::Result<()> {
    xml.create_element("Style").with_attribute(("id", *name)).write_inner_content(|xml| {
        parts.iter().try_for_each(|(part, values)| {
            element(xml, part, |xml| values.iter().try_for_each(|(key, value)| leaf(xml, key, value)))
        })
    })?;
    line(xml)
}

fn folder<T>(
    xml: &mut Xml,
    name: &str,
    things: &[T],
    write: impl Fn(&mut Xml, &T) -> io::Result<()>,
) -> io::Result<()> {
    if things.is_empty() {
        return Ok(());
    }
    element(xml, "Folder", |xml| {
        leaf(xml, "name", name)?;
        line(xml)?;
        things.iter().try_for_each(|thing| write(xml, thing))
    })?;
    line(xml)
}

fn element(xml: &mut Xml, name: &str, write: impl FnOnce(&mut Xml) -> io::Result<()>) -> io::Result<()> {
    xml.create_element(name).write_inner_content(write).map(|_| ())
}

/// Writes an element that holds a text.
fn leaf(xml: &mut Xml, name: &str, text: &str) -> io::Result<()> {
    xml.create_element(name).write_text_content(BytesText::new(&plain(text))).map(|_| ())
}

/// Ends the line.
fn line(xml: &mut Xml) -> io::Result<()> {
    xml.write_event(Event::Text(BytesText::new("\n")))
}

/// Returns `text` with a replacement character for each character that XML cannot represent.
fn plain(text: &str) -> String {
    let fits = |letter: char| {
        matches!(letter, '\t' | '\n' | '\r') || !(letter.is_control() || matches!(letter, '\u{fffe}' | '\u{ffff}'))
    };
    text.chars().map(|letter| if fits(letter) { letter } else { '\u{fffd}' }).collect()
}

fn coordinates(place: &ChartPoint) -> String {
    let Position { latitude_deg, longitude_deg } = place.position;
    let altitude = place.altitude_m.map_or_else(String::new, |altitude_m| format!(",{altitude_m:.1}"));
    format!("{longitude_deg:.7},{latitude_deg:.7}{altitude}")
}

/// Writes the altitude mode: above mean sea level if altitudes are known.
fn altitude_mode(xml: &mut Xml, known: bool) -> io::Result<()> {
    leaf(xml, "altitudeMode", if known { "absolute" } else { "clampToGround" })
}

fn point(xml: &mut Xml, place: ChartPoint) -> io::Result<()> {
    element(xml, "Point", |xml| {
        altitude_mode(xml, place.altitude_m.is_some())?;
        leaf(xml, "coordinates", &coordinates(&place))
    })
}

fn time_span(xml: &mut Xml, chart: &Chart, begin_s: f64, end_s: f64) -> io::Result<()> {
    let Some((begin, end)) = utc(chart.zero_unix_s, begin_s).zip(utc(chart.zero_unix_s, end_s)) else { return Ok(()) };
    element(xml, "TimeSpan", |xml| {
        leaf(xml, "begin", &begin)?;
        leaf(xml, "end", &end)
    })?;
    line(xml)
}

fn path(xml: &mut Xml, chart: &Chart) -> io::Result<()> {
    let path = chart.path();
    if path.len() < 2 {
        return Ok(());
    }
    element(xml, "Placemark", |xml| {
        leaf(xml, "name", "path")?;
        line(xml)?;
        time_span(xml, chart, 0.0, chart.end_s)?;
        leaf(xml, "styleUrl", "#path")?;
        line(xml)?;
        data(xml, chart.facts.iter())?;
        let known = path.iter().all(|place| place.altitude_m.is_some());
        let points: Vec<String> = path.iter().map(coordinates).collect();
        element(xml, "LineString", |xml| {
            // On the ground a line follows the terrain.
            if !known {
                leaf(xml, "tessellate", "1")?;
            }
            altitude_mode(xml, known)?;
            leaf(xml, "coordinates", &format!("\n{}\n", points.join("\n")))
        })
    })?;
    line(xml)
}

fn data<'a>(xml: &mut Xml, facts: impl Iterator<Item = (&'a String, &'a Value)>) -> io::Result<()> {
    element(xml, "ExtendedData", |xml| {
        line(xml)?;
        for (name, value) in facts.filter(|(_, value)| !value.is_null()) {
            let text = value.as_str().map_or_else(|| value.to_string(), str::to_string);
            let name = plain(name);
            let each = xml.create_element("Data").with_attribute(("name", name.as_str()));
            each.write_inner_content(|xml| leaf(xml, "value", &text))?;
            line(xml)?;
        }
        Ok(())
    })?;
    line(xml)
}

fn target(xml: &mut Xml, chart: &Chart, target: &ChartTarget) -> io::Result<()> {
    let visits: Vec<_> = chart.visits.iter().filter(|visit| visit.target == target.name).collect();
    let clock = |seconds: f64| Time::from_seconds(seconds.round()).to_string();
    let spans: Vec<String> =
        visits.iter().map(|visit| format!("{} to {}", clock(visit.begin_s), clock(visit.end_s))).collect();
    let words = match &target.left_out {
        Some(reason) => format!("not visited: {reason}"),
        None => format!("observed from {}", spans.join(", ")),
    };
    element(xml, "Placemark", |xml| {
        leaf(xml, "name", &target.name)?;
        line(xml)?;
        leaf(xml, "description", &words)?;
        line(xml)?;
        if let [visit] = visits.as_slice() {
            time_span(xml, chart, visit.begin_s, visit.end_s)?;
        }
        leaf(xml, "styleUrl", if visits.is_empty() { "#left-out" } else { "#target" })?;
        line(xml)?;
        data(xml, target.facts.iter())?;
        point(xml, target.place)
    })?;
    line(xml)
}

fn zone(xml: &mut Xml, zone: &AirspaceZone) -> io::Result<()> {
    let style = match zone.kind {
        ZoneKind::Restricted => "restricted",
        ZoneKind::Permitted => "permitted",
    };
    let wall = style == "restricted" && zone.altitude_m_max <= WALL_M_MAX;
    let corner = |position: &Position| {
        coordinates(&ChartPoint { position: *position, altitude_m: wall.then_some(zone.altitude_m_max) })
    };
    let ring: Vec<String> = zone.corners.iter().chain(zone.corners.first()).map(corner).collect();
    let mut words =
        format!("{style} from {:.0} to {:.0} m above mean sea level", zone.altitude_m_min, zone.altitude_m_max);
    if zone.active.from_s > -FOREVER_S || zone.active.until_s < FOREVER_S {
        let clock = |seconds: f64| Time::from_seconds(seconds.clamp(0.0, 1e9)).to_string();
        // Writing to a string cannot fail.
        let _ = write!(words, ", active from {} to {}", clock(zone.active.from_s), clock(zone.active.until_s));
    }
    element(xml, "Placemark", |xml| {
        leaf(xml, "name", &zone.name)?;
        line(xml)?;
        leaf(xml, "description", &words)?;
        leaf(xml, "styleUrl", &format!("#{style}"))?;
        line(xml)?;
        element(xml, "Polygon", |xml| {
            if wall {
                leaf(xml, "extrude", "1")?;
            }
            altitude_mode(xml, wall)?;
            element(xml, "outerBoundaryIs", |xml| {
                element(xml, "LinearRing", |xml| leaf(xml, "coordinates", &format!("\n{}\n", ring.join("\n"))))
            })
        })
    })?;
    line(xml)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_escaped_and_stays_text() {
        let mut xml = Xml::new(Vec::new());
        leaf(&mut xml, "name", "a<b> & \"c\"\u{1}").unwrap();
        let written = String::from_utf8(xml.into_inner()).unwrap();
        assert_eq!(written, "<name>a&lt;b&gt; &amp; &quot;c&quot;\u{fffd}</name>");
    }
}
