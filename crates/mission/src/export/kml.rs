//! A plan as KML 2.2, for globes: the path in the air, targets with times, airspace with its upper face.

use super::chart::{Chart, ChartPoint, Target};
use super::civil::utc;
use apex_model::problem::{AirspaceZone, FOREVER_S, Position, ZoneKind};
use apex_model::time::Time;
use serde_json::Value;
use std::fmt::Write;

/// Zones that reach higher are drawn on the ground: a wall of that height would hide the rest.
const WALL_M_MAX: f64 = 30_000.0;

/// Colours are `aabbggrr`.
const STYLES: &[(&str, &str)] = &[
    ("path", "<LineStyle><color>ff00a5ff</color><width>3</width></LineStyle>"),
    ("target", "<IconStyle><color>ff50c878</color></IconStyle>"),
    ("left-out", "<IconStyle><color>ff808080</color></IconStyle>"),
    ("restricted", "<LineStyle><color>ff0000ff</color></LineStyle><PolyStyle><color>400000ff</color></PolyStyle>"),
    ("permitted", "<LineStyle><color>ff00aa00</color></LineStyle><PolyStyle><fill>0</fill></PolyStyle>"),
];

/// The chart as a document of KML.
pub fn write(chart: &Chart) -> String {
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = document(&mut out, chart);
    out
}

fn document(out: &mut String, chart: &Chart) -> std::fmt::Result {
    writeln!(out, "<?xml version=\"1.0\" encoding=\"UTF-8\"?>")?;
    writeln!(out, "<kml xmlns=\"http://www.opengis.net/kml/2.2\">\n<Document>")?;
    writeln!(out, "<name>{}</name>", escaped(&chart.name))?;
    writeln!(out, "<description>{}</description>", escaped(&chart.summary))?;
    for (name, style) in STYLES {
        writeln!(out, "<Style id=\"{name}\">{style}</Style>")?;
    }
    path(out, chart)?;
    for (name, place) in [("start", chart.start), ("base", chart.base)] {
        let Some(place) = place else { continue };
        writeln!(out, "<Placemark><name>{name}</name>{}</Placemark>", point(place))?;
    }
    folder(out, "targets", &chart.targets, |out, each| target(out, chart, each))?;
    folder(out, "airspace", &chart.zones, zone)?;
    writeln!(out, "</Document>\n</kml>")
}

fn folder<T>(
    out: &mut String,
    name: &str,
    things: &[T],
    write: impl Fn(&mut String, &T) -> std::fmt::Result,
) -> std::fmt::Result {
    if things.is_empty() {
        return Ok(());
    }
    writeln!(out, "<Folder><name>{name}</name>")?;
    things.iter().try_for_each(|thing| write(out, thing))?;
    writeln!(out, "</Folder>")
}

/// `&`, `<`, `>` and quotes as XML wants them; what XML cannot hold at all becomes a replacement character.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\t' | '\n' | '\r' => out.push(letter),
            letter if letter.is_control() || matches!(letter, '\u{fffe}' | '\u{ffff}') => out.push('\u{fffd}'),
            letter => out.push(letter),
        }
    }
    out
}

fn coordinates(place: &ChartPoint) -> String {
    let Position { latitude_deg, longitude_deg } = place.position;
    let altitude = place.altitude_m.map_or_else(String::new, |altitude_m| format!(",{altitude_m:.1}"));
    format!("{longitude_deg:.7},{latitude_deg:.7}{altitude}")
}

/// Heights count from mean sea level where they are known.
fn altitude_mode(known: bool) -> &'static str {
    if known { "<altitudeMode>absolute</altitudeMode>" } else { "<altitudeMode>clampToGround</altitudeMode>" }
}

fn point(place: ChartPoint) -> String {
    let mode = altitude_mode(place.altitude_m.is_some());
    format!("<Point>{mode}<coordinates>{}</coordinates></Point>", coordinates(&place))
}

fn path(out: &mut String, chart: &Chart) -> std::fmt::Result {
    let path = chart.path();
    if path.len() < 2 {
        return Ok(());
    }
    writeln!(out, "<Placemark><name>path</name>")?;
    if let Some((begin, end)) = utc(chart.zero_unix_s, 0.0).zip(utc(chart.zero_unix_s, chart.end_s)) {
        writeln!(out, "<TimeSpan><begin>{begin}</begin><end>{end}</end></TimeSpan>")?;
    }
    writeln!(out, "<styleUrl>#path</styleUrl>")?;
    data(out, chart.facts.iter())?;
    let known = path.iter().all(|place| place.altitude_m.is_some());
    // On the ground a line follows the terrain instead of cutting through it.
    let mode = format!("{}{}", if known { "" } else { "<tessellate>1</tessellate>" }, altitude_mode(known));
    let points: Vec<String> = path.iter().map(coordinates).collect();
    writeln!(out, "<LineString>{mode}<coordinates>\n{}\n</coordinates></LineString></Placemark>", points.join("\n"))
}

fn data<'a>(out: &mut String, facts: impl Iterator<Item = (&'a String, &'a Value)>) -> std::fmt::Result {
    writeln!(out, "<ExtendedData>")?;
    for (name, value) in facts.filter(|(_, value)| !value.is_null()) {
        let text = value.as_str().map_or_else(|| value.to_string(), str::to_string);
        writeln!(out, "<Data name=\"{}\"><value>{}</value></Data>", escaped(name), escaped(&text))?;
    }
    writeln!(out, "</ExtendedData>")
}

fn target(out: &mut String, chart: &Chart, target: &Target) -> std::fmt::Result {
    let visits: Vec<_> = chart.visits.iter().filter(|visit| visit.target == target.name).collect();
    writeln!(out, "<Placemark><name>{}</name>", escaped(&target.name))?;
    let clock = |seconds: f64| Time::from_seconds(seconds.round()).to_string();
    let spans: Vec<String> =
        visits.iter().map(|visit| format!("{} to {}", clock(visit.begin_s), clock(visit.end_s))).collect();
    let words = match &target.left_out {
        Some(reason) => format!("not visited: {reason}"),
        None => format!("observed from {}", spans.join(", ")),
    };
    writeln!(out, "<description>{}</description>", escaped(&words))?;
    if let [visit] = visits.as_slice()
        && let Some((begin, end)) = utc(chart.zero_unix_s, visit.begin_s).zip(utc(chart.zero_unix_s, visit.end_s))
    {
        writeln!(out, "<TimeSpan><begin>{begin}</begin><end>{end}</end></TimeSpan>")?;
    }
    writeln!(out, "<styleUrl>#{}</styleUrl>", if visits.is_empty() { "left-out" } else { "target" })?;
    data(out, target.facts.iter())?;
    writeln!(out, "{}</Placemark>", point(target.place))
}

fn zone(out: &mut String, zone: &AirspaceZone) -> std::fmt::Result {
    let style = match zone.kind {
        ZoneKind::Restricted => "restricted",
        ZoneKind::Permitted => "permitted",
    };
    let wall = style == "restricted" && zone.altitude_m_max <= WALL_M_MAX;
    let corner = |position: &Position| {
        coordinates(&ChartPoint { position: *position, altitude_m: wall.then_some(zone.altitude_m_max) })
    };
    let ring: Vec<String> = zone.corners.iter().chain(zone.corners.first()).map(corner).collect();
    writeln!(out, "<Placemark><name>{}</name>", escaped(&zone.name))?;
    let mut words =
        format!("{style} from {:.0} to {:.0} m above mean sea level", zone.altitude_m_min, zone.altitude_m_max);
    if zone.active.from_s > -FOREVER_S || zone.active.until_s < FOREVER_S {
        let clock = |seconds: f64| Time::from_seconds(seconds.clamp(0.0, 1e9)).to_string();
        write!(words, ", active from {} to {}", clock(zone.active.from_s), clock(zone.active.until_s))?;
    }
    writeln!(out, "<description>{}</description><styleUrl>#{style}</styleUrl>", escaped(&words))?;
    let extrude = if wall { "<extrude>1</extrude>" } else { "" };
    writeln!(
        out,
        "<Polygon>{extrude}{}<outerBoundaryIs><LinearRing><coordinates>\n{}\n</coordinates></LinearRing></outerBoundaryIs></Polygon></Placemark>",
        altitude_mode(wall),
        ring.join("\n")
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_escaped_and_stays_text() {
        assert_eq!(escaped("a<b> & \"c\"\u{1}"), "a&lt;b&gt; &amp; &quot;c&quot;\u{fffd}");
    }
}
