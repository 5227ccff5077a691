//! Travel matrices among zones: processor time and growth, compared with extremitypathfinder.
//!
//! `travel world FILE` writes the world of 100 places and 50 zones for the peer. `travel report PEER.json` prints our matrix of the same
//! world with a comparison of the lengths, matrices on the Earth with margins of zones and changing wind, and the growth.

use apex_geo::plane::{self, Plane, Point};
use apex_geo::travel::{Air, EndpointId, Network, PlaneZone, Setting};
use apex_model::problem::{AirspaceZone, Area, Position, TimeWindow, WindField, WindLayer, ZoneKind};
use apex_planning::random::Generator;
use std::fmt::Write;

/// Size of the world to which the bar applies.
const PLACES: usize = 100;
const ZONES: usize = 50;
/// Side of the grid's cells, each of which contains at most one zone.
const CELL_M: f64 = 120_000.0;
/// Bar, in seconds of processor time.
const BAR_S: f64 = 0.1;
const DAY_S: (f64, f64) = (0.0, 86_400.0);

/// Returns the CPU time of this thread, in nanoseconds.
fn cpu_ns() -> u64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    text.split(' ').next().and_then(|first| first.parse().ok()).unwrap_or(0)
}

/// Returns the median seconds of processor time over `rounds`, and the last answer.
fn timed<T>(rounds: usize, mut run: impl FnMut() -> T) -> (f64, T) {
    let mut once = || {
        let begin = cpu_ns();
        let answer = run();
        ((cpu_ns() - begin) as f64 * 1e-9, answer)
    };
    let mut seconds = Vec::new();
    let (first_s, mut answer) = once();
    seconds.push(first_s);
    for _ in 1..rounds {
        let (took_s, again) = once();
        seconds.push(took_s);
        answer = again;
    }
    seconds.sort_by(f64::total_cmp);
    (seconds.get(seconds.len() / 2).copied().unwrap_or(f64::NAN), answer)
}

struct World {
    boundary: Vec<Point>,
    zones: Vec<Vec<Point>>,
    places: Vec<Point>,
}

/// Returns ragged zones of five to eight corners in the cells of a grid, so that none overlap (a requirement of the peer), with places
/// between them.
fn world(places: usize, zones: usize, seed: u64) -> World {
    let mut random = Generator::new(seed);
    let columns = (zones as f64 * 1.12).sqrt().ceil() as usize;
    let rows = (zones * 28).div_ceil(25 * columns);
    let mut cells: Vec<usize> = (0..columns * rows).collect();
    while cells.len() > zones {
        let index = random.below(cells.len());
        cells.swap_remove(index);
    }
    let side = CELL_M;
    let zones: Vec<Vec<Point>> = cells
        .iter()
        .map(|cell| {
            let (x, y) = ((cell % columns) as f64 + 0.5, (cell / columns) as f64 + 0.5);
            let count = 5 + random.below(4);
            let corner = |index: usize, random: &mut Generator| {
                let angle = (index as f64 + 0.4 * random.unit()) * std::f64::consts::TAU / count as f64;
                let radius = side * (0.25 + 0.2 * random.unit());
                Point { x: x * side + radius * libm::cos(angle), y: y * side + radius * libm::sin(angle) }
            };
            (0..count).map(|index| corner(index, &mut random)).collect()
        })
        .collect();
    let (wide, high) = (columns as f64 * side, rows as f64 * side);
    let mut spots = Vec::new();
    while spots.len() < places {
        let spot = Point { x: random.unit() * wide, y: random.unit() * high };
        if !zones.iter().any(|zone| plane::inside(spot, zone) || plane::segment_to_edges(spot, spot, zone) < 4_000.0) {
            spots.push(spot);
        }
    }
    let (low, wide, high) = (-1000.0, wide + 1000.0, high + 1000.0);
    let boundary = [(low, low), (wide, low), (wide, high), (low, high)].map(|(x, y)| Point { x, y }).to_vec();
    World { boundary, zones, places: spots }
}

fn text(world: &World) -> String {
    let words = |points: &[Point]| points.iter().map(|p| format!(" {:?} {:?}", p.x, p.y)).collect::<String>();
    let mut text = format!("world bar\nboundary{}\n", words(&world.boundary));
    for zone in &world.zones {
        let _ = writeln!(text, "hole{}", words(zone));
    }
    for place in &world.places {
        let _ = writeln!(text, "place{}", words(&[*place]));
    }
    text
}

/// Lengths from every place to every place on the plane, as the peer measures.
fn flat(world: &World) -> Vec<Vec<Option<f64>>> {
    let zone = |(number, corners): (usize, &Vec<Point>)| PlaneZone {
        name: number.to_string(),
        corners: corners.clone(),
        ..PlaneZone::default()
    };
    let mut zones: Vec<PlaneZone> = world.zones.iter().enumerate().map(zone).collect();
    zones.push(PlaneZone { keep_in: true, corners: world.boundary.clone(), ..PlaneZone::default() });
    let Ok(mut network) = Network::on_plane(&zones, (0.0, 0.0), Air::still(1.0), DAY_S) else { return Vec::new() };
    let places: Vec<EndpointId> = world.places.iter().filter_map(|place| network.add_point(*place).ok()).collect();
    let trips = network.matrix(&places, &places, 0.0);
    trips.into_iter().map(|row| row.into_iter().map(|trip| Some(trip?.arrive_s)).collect()).collect()
}

/// The same world on the Earth.
struct Earth {
    zones: Vec<AirspaceZone>,
    places: Vec<Position>,
    wind: WindField,
}

fn earth(world: &World, windows: bool) -> Earth {
    let far = world.boundary.get(2).copied().unwrap_or_default();
    let middle = Point { x: 0.5 * far.x, y: 0.5 * far.y };
    let map = Plane::new(Position::new(42.0, -117.0));
    let position = |point: &Point| map.position(point.minus(middle));
    let zones = world.zones.iter().enumerate().map(|(number, corners)| AirspaceZone {
        name: format!("R-{number}"),
        kind: ZoneKind::Restricted,
        corners: corners.iter().map(position).collect(),
        altitude_m_min: 0.0,
        altitude_m_max: 18_000.0,
        active: if windows && number % 10 == 0 {
            TimeWindow { from_s: 7_200.0, until_s: 21_600.0 }
        } else {
            TimeWindow::ALWAYS
        },
    });
    let west = Area { south_deg: 20.0, north_deg: 60.0, west_deg: -140.0, east_deg: -117.5 };
    let mut layers = Vec::new();
    for hours in 0..4 {
        for (level, area) in [(0, None), (1, None), (0, Some(west)), (1, Some(west))] {
            let strong = 12.0 + 4.0 * f64::from(hours) + 6.0 * f64::from(level);
            layers.push(WindLayer {
                area,
                altitude_m_min: 5_000.0 * f64::from(level),
                altitude_m_max: 5_000.0 * f64::from(level + 1),
                from_s: f64::from(hours) * 21_600.0,
                until_s: f64::from(hours + 1) * 21_600.0,
                wind_east_mps: strong,
                wind_north_mps: if area.is_some() { -0.5 * strong } else { 0.3 * strong },
                edr: 0.0,
            });
        }
    }
    Earth {
        zones: zones.collect(),
        places: world.places.iter().map(position).collect(),
        wind: WindField { layers, blend: true },
    }
}

/// Computes the travel matrix for a departure at `ready_s`, with all preparations. Returns the numbers of reachable pairs and of bends.
fn flown(earth: &Earth, ready_s: f64) -> (usize, usize) {
    let setting = Setting {
        zones: &earth.zones,
        margin_m: 3_000.0,
        turn_radius_m: 0.0,
        circling: false,
        landing_places: &[],
        landing_distance_m_max: None,
        around: &earth.places,
        altitudes_m: (7_000.0, 7_000.0),
        time_s: DAY_S,
    };
    let air = Air::new(&earth.wind, 7_000.0, 95.0, DAY_S.0, DAY_S.1);
    let Ok(mut network) = Network::new(&setting, air) else { return (0, 0) };
    let places: Vec<EndpointId> = earth.places.iter().filter_map(|place| network.add(*place).ok()).collect();
    let trips = network.matrix(&places, &places, ready_s);
    (trips.iter().flatten().flatten().count(), network.path_vertices())
}

fn report(peer: &serde_json::Value) {
    let bar = world(PLACES, ZONES, 1);
    let (ours_s, lengths) = timed(9, || flat(&bar));
    let (mut compared, mut apart) = (0, 0.0_f64);
    for way in peer["ways"].as_array().into_iter().flatten() {
        let number = |index: usize| way[index].as_u64().unwrap_or(0) as usize;
        let ours = lengths.get(number(0)).and_then(|row| row.get(number(1)).copied().flatten());
        if let (Some(ours), Some(theirs)) = (ours, way[2].as_f64()) {
            apart = apart.max((ours - theirs).abs() / theirs);
            compared += 1;
        } else if ours.is_some() || way[2].as_f64().is_some() {
            apart = f64::INFINITY;
        }
    }
    let (prepare_s, ways_s) = (peer["prepare_s"].as_f64().unwrap_or(0.0), peer["ways_s"].as_f64().unwrap_or(0.0));
    // The peer's ways are symmetric and were computed for one direction only.
    let peer_s = prepare_s + ways_s;
    println!("| {PLACES} places, {ZONES} zones, processor time | s | bar |\n|---|---|---|");
    println!("| extremitypathfinder, no wind, half of the matrix | {peer_s:.2} | |");
    println!("| Apex, the same world, whole matrix | {ours_s:.4} (1/{:.0}) | |", peer_s / ours_s);
    println!("| greatest relative difference of {compared} lengths | {apart:.1e} | 1e-9 |");
    let still = earth(&bar, false);
    let (wind_s, (pairs, bends)) = timed(9, || flown(&still, 20_000.0));
    println!(
        "| Apex on the Earth, margin 3 km, wind by area and altitude that changes ({bends} bends, {pairs} pairs) | {wind_s:.4} | {BAR_S} |"
    );
    let windows = earth(&bar, true);
    let (shut_s, (pairs, _)) = timed(9, || flown(&windows, 6_000.0));
    println!("| the same, every tenth zone active for four hours ({pairs} pairs) | {shut_s:.4} | |");
    println!("\n| places | zones | bends | s |\n|---|---|---|---|");
    for (places, zones) in [(10, 50), (30, 50), (100, 50), (300, 50), (1000, 50), (100, 5), (100, 15), (100, 150)] {
        let grown = earth(&world(places, zones, 2), false);
        let (grown_s, (_, bends)) = timed(3, || flown(&grown, 20_000.0));
        println!("| {places} | {zones} | {bends} | {grown_s:.4} |");
    }
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let done = match words.as_slice() {
        ["world", file] => std::fs::write(file, text(&world(PLACES, ZONES, 1))).map_err(|error| error.to_string()),
        ["report", file] => std::fs::read_to_string(file)
            .map_err(|error| error.to_string())
            .and_then(|text| serde_json::from_str(&text).map_err(|error| error.to_string()))
            .map(|peer| report(&peer)),
        _ => Err("usage: travel world FILE | travel report PEER.json".to_string()),
    };
    if let Err(error) = done {
        eprintln!("{error}");
        std::process::exit(2);
    }
}
