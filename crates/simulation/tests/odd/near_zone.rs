//! A zone near the base that leaves most approaches open, and aircraft whose circles are wider than the space between the two.

use crate::harness::{Flown, collection, feature, fly, home, point, program};
use apex_geo::geodesy;
use apex_model::problem::Position;

const HOME: Position = Position { latitude_deg: 37.4, longitude_deg: -121.0 };
const RADIUS_M: f64 = 25_000.0;
/// Direction of the zone from the base.
const TOWARDS_DEG: f64 = 220.0;

/// A flight to one fire, 80 km away, and its distance from the round zone at its nearest, in metres.
struct NearZone {
    flown: Flown,
    nearest_m: f64,
}

/// Flies from a base with a round zone of 50 km whose nearest edge is `edge_m` away; the wind blows from the west.
fn fly_near(model: &str, edge_m: f64, wind_mps: f64) -> NearZone {
    fly_towards(model, TOWARDS_DEG, edge_m, wind_mps)
}

/// Flies like [`fly_near`] with the zone in a direction from the base.
fn fly_towards(model: &str, towards_deg: f64, edge_m: f64, wind_mps: f64) -> NearZone {
    let middle = geodesy::destination(HOME, towards_deg, edge_m + RADIUS_M);
    let corners = (0..=16).map(|number| {
        let corner = geodesy::destination(middle, 22.5 * f64::from(number % 16), RADIUS_M);
        format!("[{}, {}]", corner.longitude_deg, corner.latitude_deg)
    });
    let ring = corners.collect::<Vec<_>>().join(", ");
    let round = feature(
        r#""id": "round", "kind": "restricted", "altitude_m_max": 20000"#,
        &format!(r#"{{"type": "Polygon", "coordinates": [[{ring}]]}}"#),
    );
    let there = geodesy::destination(HOME, 40.0, 80_000.0);
    let fire = feature(
        r#""id": "fire", "kind": "fire", "acres": 3000, "value": 50, "resolution_m": 20"#,
        &point(there.longitude_deg, there.latitude_deg),
    );
    let options = format!(
        ":vehicle (sim :model {model} :at home) :start \"2026-05-12T18:30:00Z\" :duration 3h :end-margin 10min \
         :targets \"t.geojson\" :airspace \"z.geojson\" :forecast \"w.csv\""
    );
    let wind = format!("altitude_m_min,altitude_m_max,wind_from_deg,wind_speed_mps,edr\n0,20000,270,{wind_mps},0.02\n");
    let files = [("t.geojson", &collection(&[home(), fire])), ("z.geojson", &collection(&[round])), ("w.csv", &wind)];
    // Without a plan the aircraft returns.
    let replans = "(restart-when (new plan))";
    let program = program(&options, "6000m").replace(replans, &format!("{replans} (on-failure (inform (no plan)))"));
    let flown = fly(&program, &files.map(|(name, text)| (name, text.as_str())));
    let apart_m = |at: &(f64, f64, f64, f64)| {
        geodesy::distance_m(middle, Position { latitude_deg: at.1, longitude_deg: at.2 }) - RADIUS_M
    };
    let nearest_m = flown.track().iter().map(apart_m).fold(f64::INFINITY, f64::min);
    NearZone { flown, nearest_m }
}

impl NearZone {
    /// Stops the test unless the flight kept out of the zone, said that of itself, and landed at its base.
    fn keeps_out_and_lands(&self, case: &str) {
        let text = self.flown.text();
        let track = self.flown.track();
        let &(_, latitude_deg, longitude_deg, _) = track.last().unwrap();
        let off_m = geodesy::distance_m(HOME, Position { latitude_deg, longitude_deg });
        println!("{case}: {:.1} km from the zone, ended {off_m:.0} m from the base", self.nearest_m / 1_000.0);
        // The sides of the polygon are up to 480 m inside of the circle.
        assert!(self.nearest_m > 0.0, "{case}: inside of the zone by {} m\n{text}", -self.nearest_m);
        assert!(!text.contains("has to be broken"), "{case}: {text}");
        assert!(!text.contains("at risk"), "{case}: {text}");
        assert!(self.flown.observed_s("fire").is_some() && off_m < 3_000.0, "{case}: {off_m} m\n{text}");
    }
}

/// Every approach from the north and the east is open, but the circle of a descent over the base would meet the zone.
#[test]
fn approaches_of_a_base_are_open_where_a_descent_over_it_is_not() {
    for (model, edge_m, wind_mps) in
        [("global-hawk", 25_000.0, 0.0), ("global-hawk", 38_000.0, 18.0), ("predator-b", 15_000.0, 18.0)]
    {
        fly_near(model, edge_m, wind_mps).keeps_out_and_lands(&format!("{model}, {edge_m} m, {wind_mps} m/s"));
    }
}

/// The circle of the descent, and that of the climb, is wider than the space between base and zone.
#[test]
fn a_wide_circle_next_to_the_base_is_flown_away_from_a_zone() {
    for (model, edge_m, wind_mps) in
        [("global-hawk", 15_000.0, 0.0), ("global-hawk", 15_000.0, 18.0), ("predator-b", 8_000.0, 0.0)]
    {
        fly_near(model, edge_m, wind_mps).keeps_out_and_lands(&format!("{model}, {edge_m} m, {wind_mps} m/s"));
    }
}

/// The zone lies ahead of the take-off. A response below the height of the first turn brought the aircraft down to circles near the ground,
/// and the climb that continued failed when its altitude was changed: the mission ended in the air.
#[test]
fn a_take_off_towards_a_zone_is_not_interrupted_near_the_ground() {
    let near = fly_towards("global-hawk", 0.0, 9_000.0, 10.0);
    let text = near.flown.text();
    let (commands, track) = (near.flown.commands(), near.flown.track());
    let interrupted = commands.iter().find(|(_, command)| command.starts_with("(fly-to"));
    let (begins_s, _) = interrupted.unwrap_or_else(|| panic!("nothing led away from the zone: {commands:?}\n{text}"));
    let height_m = track.iter().rfind(|at| at.0 <= *begins_s).map_or(0.0, |at| at.3 - track[0].3);
    assert!(height_m >= 299.0, "turned away at {height_m} m over the base: {commands:?}\n{text}");
    let continued = commands.iter().find(|(at_s, command)| at_s > begins_s && command.starts_with("(loiter"));
    assert!(continued.is_some(), "the climb was not continued: {commands:?}\n{text}");
    let highest_m = track.iter().map(|at| at.3).fold(0.0, f64::max);
    assert!(highest_m > 5_900.0, "{highest_m} m\n{text}");
    assert!(!text.contains("has not landed") && !text.contains("the command"), "{text}");
}
