//! Small aircraft over known terrain. Heights above the ground are computed here, from recorded locations and the formula of the ground.

use crate::harness::{Flown, collection, feature, fly, point, program};
use apex_mission::verification::Violation;
use std::fmt::Write;

const HOME: (f64, f64) = (46.0, 8.0);
const METRES_PER_DEGREE: f64 = 111_195.0;
const LEVELLED_M: f64 = 350.0;

/// A hill to the north of the base, or a slope of so many metres per metre to the north, over 400 m.
#[derive(Clone, Copy)]
struct Relief {
    hill_m: f64,
    /// Standard deviation of the hill.
    wide_m: f64,
    slope: f64,
}

const FLAT: Relief = Relief { hill_m: 0.0, wide_m: 800.0, slope: 0.0 };

impl Relief {
    fn ground_m(self, latitude_deg: f64, longitude_deg: f64) -> f64 {
        let north_m = (latitude_deg - HOME.0) * METRES_PER_DEGREE;
        let east_m = (longitude_deg - HOME.1) * METRES_PER_DEGREE * HOME.0.to_radians().cos();
        let from_top_m = (north_m - 1_200.0).hypot(east_m) / self.wide_m;
        400.0 + self.hill_m * (-0.5 * from_top_m * from_top_m).exp() + self.slope * north_m
    }

    /// Returns the ground as an ASCII grid of so many degrees around the base.
    fn grid(self, width_deg: f64) -> String {
        let (posts, step) = (241, width_deg / 240.0);
        let (west, south) = (HOME.1 - 0.5 * width_deg, HOME.0 - 0.5 * width_deg);
        let mut text = format!(
            "ncols {posts}\nnrows {posts}\nxllcenter {west:.6}\nyllcenter {south:.6}\ncellsize {step:.10}\nNODATA_value -9999\n"
        );
        for row in (0..posts).rev() {
            for column in 0..posts {
                let ground_m = self.ground_m(south + step * f64::from(row), west + step * f64::from(column));
                // Files of terrain hold no ground that is far below the sea.
                let elevation_m = ground_m.max(-300.0);
                write!(text, "{elevation_m:.2} ").unwrap();
            }
            text.push('\n');
        }
        text
    }

    fn place(north_m: f64, east_m: f64) -> String {
        let east_deg = east_m / (METRES_PER_DEGREE * HOME.0.to_radians().cos());
        point(HOME.1 + east_deg, HOME.0 + north_m / METRES_PER_DEGREE)
    }

    fn program(self, model: &str) -> String {
        let options = format!(
            ":vehicle (sim :model {model} :at home) :start \"2026-06-01T10:00:00Z\" :duration 40min :end-margin 3min \
             :terrain \"ground.asc\" :targets \"t.geojson\""
        );
        program(&options, &format!("{:.0}m", self.ground_m(HOME.0, HOME.1) + 60.0))
    }

    /// Flies a program with targets beyond the hill, on its top and to the east.
    fn fly(self, program: &str) -> Flown {
        let target = |id: &str, north_m: f64, east_m: f64| {
            let properties = format!(r#""id": "{id}", "kind": "inspection", "value": 20, "resolution_m": 0.05"#);
            feature(&properties, &Relief::place(north_m, east_m))
        };
        let home = feature(r#""id": "home", "kind": "base""#, &point(HOME.1, HOME.0));
        let targets = [home, target("far", 2_600.0, 0.0), target("top", 1_200.0, 0.0), target("side", 0.0, 1_500.0)];
        fly(program, &[("t.geojson", &collection(&targets)), ("ground.asc", &self.grid(0.08))])
    }

    /// Returns true if the check of the take-offs refuses a program over this ground.
    fn check(self, program: &str, width_deg: f64) -> bool {
        let folder = tempfile::tempdir().unwrap();
        let home = feature(r#""id": "home", "kind": "base""#, &point(HOME.1, HOME.0));
        let texts = [
            ("mission.pdl", program.to_string()),
            ("t.geojson", collection(&[home])),
            ("ground.asc", self.grid(width_deg)),
        ];
        for (name, text) in texts {
            std::fs::write(folder.path().join(name), text).unwrap();
        }
        let mission = apex_mission::Mission::load(folder.path()).unwrap_or_else(|error| panic!("{error:?}"));
        apex_mission::ways::check_take_offs(&mission).is_err()
    }

    /// Returns the positions of a flight at which the ground follows the formula: the simulator levels it around the base.
    fn away(flown: &Flown) -> impl Iterator<Item = (f64, f64, f64, f64)> {
        let is_away = |at: &(f64, f64, f64, f64)| {
            let north_m = (at.1 - HOME.0) * METRES_PER_DEGREE;
            let east_m = (at.2 - HOME.1) * METRES_PER_DEGREE * HOME.0.to_radians().cos();
            north_m.hypot(east_m) > LEVELLED_M
        };
        flown.track().into_iter().filter(is_away)
    }

    /// Returns the least height above the ground.
    fn least_m(self, flown: &Flown) -> f64 {
        let heights_m = Relief::away(flown)
            .map(|(_, latitude, longitude, altitude_m)| altitude_m - self.ground_m(latitude, longitude));
        heights_m.fold(f64::INFINITY, f64::min)
    }
}

/// A hill of 300 m whose top is 1.2 km to the north, where the aircraft points when it stands: it climbed into the slope.
#[test]
fn a_take_off_into_a_slope_is_refused_and_one_away_from_it_flies() {
    let relief = Relief { hill_m: 300.0, wide_m: 500.0, slope: 0.0 };
    let base_m = relief.ground_m(HOME.0, HOME.1);
    let up = |height_m: f64| format!("(take off to {:.0}m)", base_m + height_m);
    let program = relief.program("fixed-wing-mapper").replace(&up(60.0), &up(400.0));
    assert!(program.contains(&up(400.0)), "{program}");
    let refused = relief.fly(&program);
    let text = refused.text();
    assert!(refused.track().iter().all(|at| (at.3 - base_m).abs() < 1.0), "it left the ground:\n{text}");
    for words in ["towards 0 degrees meets the ground", "degrees is clear: `:heading"] {
        assert!(text.contains(words), "`{words}` is missing:\n{text}");
    }
    let flown = relief.fly(&program.replace(":at home", ":at home :heading 180deg"));
    let text = flown.text();
    assert!(flown.observed_s("side").is_some(), "{text}");
    assert_eq!(flown.check().violations(), 0, "{}\n{text}", flown.check());
}

/// The check of a take-off is compared with flown climbs over no terrain: their height over slopes is computed here. A climb that the check
/// permits is clear of the ground, and the check refuses no gentle slope.
#[test]
fn a_take_off_is_refused_where_the_flown_climb_meets_the_slope() {
    for (model, width_deg) in [("fixed-wing-mapper", 0.05), ("predator-b", 0.1), ("global-hawk", 0.1)] {
        let up = "(take off to 2400m)";
        let program = FLAT.program(model).replace("(take off to 460m)", up);
        assert!(program.contains(up), "{program}");
        let flat = FLAT.fly(&program.replace(":terrain \"ground.asc\"", ""));
        let track = flat.track();
        let base_m = track[0].3;
        let rises: Vec<(f64, f64)> = track
            .iter()
            .map(|at| ((at.1 - HOME.0) * METRES_PER_DEGREE, at.3 - base_m))
            .take_while(|(_, height_m)| *height_m < 300.0)
            .collect();
        // The ground is level up to the lift-off and a little beyond.
        let run_m = rises.iter().take_while(|(_, height_m)| *height_m < 0.5).map(|at| at.0).fold(0.0, f64::max);
        let level_m = run_m + LEVELLED_M;
        let (mut refused, mut gentlest) = (Vec::new(), f64::INFINITY);
        for number in 1..=30 {
            let slope = 0.01 * f64::from(number);
            let is_refused = Relief { slope, ..FLAT }.check(&program, width_deg);
            let beyond = rises.iter().filter(|(north_m, _)| *north_m > level_m);
            let clear_m = beyond.map(|(north_m, height_m)| height_m - slope * north_m).fold(f64::INFINITY, f64::min);
            assert!(is_refused || clear_m > 0.0, "{model} may take off into {slope} and flies {clear_m} m over it");
            if is_refused {
                gentlest = gentlest.min(slope);
                refused.push(slope);
            }
        }
        let steepest_flown =
            rises.iter().filter(|at| at.0 > level_m).map(|at| at.1 / at.0).fold(f64::INFINITY, f64::min);
        println!("{model}: {steepest_flown:.3} flown, refused from {gentlest:.3}");
        assert!(
            gentlest.is_finite() && gentlest > 0.5 * steepest_flown,
            "{model}: {steepest_flown} flown, {refused:?}"
        );
    }
}

/// Asserts that a flight observes every target, keeps all requirements and stays well above the ground.
fn assert_flown_over(model: &str, relief: Relief, height_m_min: f64) {
    let flown = relief.fly(&relief.program(model));
    let text = flown.text();
    for target in ["far", "top", "side"] {
        assert!(flown.observed_s(target).is_some(), "{model}: {target} was not observed:\n{text}");
    }
    assert!(!text.contains("has to be broken"), "{model}: {text}");
    let least_m = relief.least_m(&flown);
    assert!(least_m >= height_m_min, "{model}: {least_m} m over the ground\n{text}");
    assert_eq!(flown.check().violations(), 0, "{model}: {}", flown.check());
}

#[test]
fn a_rotorcraft_over_flat_terrain_breaks_no_requirement() {
    for model in ["quadrotor", "rmax"] {
        assert_flown_over(model, FLAT, 15.0);
    }
}

#[test]
fn a_rotorcraft_flies_over_a_hill_to_its_targets() {
    for (hill_m, wide_m) in [(100.0, 800.0), (200.0, 800.0), (300.0, 800.0), (100.0, 400.0)] {
        for model in ["quadrotor", "rmax"] {
            assert_flown_over(model, Relief { hill_m, wide_m, slope: 0.0 }, 15.0);
        }
    }
}

/// The height was that over the ground of the step before: of a second ago at best, of ten seconds ago in cruise.
#[test]
fn a_reported_height_is_that_over_the_ground_of_the_same_instant() {
    let relief = Relief { slope: 0.05, ..FLAT };
    let flown = relief.fly(&relief.program("fixed-wing-mapper"));
    let heights_m = flown.timed_numbers("height-above-ground");
    let mut compared = 0;
    for (at_s, latitude, longitude, altitude_m) in Relief::away(&flown) {
        let Some((_, height_m)) = heights_m.iter().find(|(reported_s, _)| *reported_s == at_s) else { continue };
        let expected_m = altitude_m - relief.ground_m(latitude, longitude);
        assert!(
            (height_m - expected_m).abs() < 0.1,
            "at {at_s} s: {height_m} m reported, {expected_m} m over the ground"
        );
        compared += 1;
    }
    assert!(compared > 100, "{compared} instants");
}

/// The lead-in before a line lies over higher ground than the target; the ways there broke requirement `ground`.
#[test]
fn a_mapping_aircraft_flies_over_a_hill_to_its_targets() {
    for (hill_m, wide_m) in [(50.0, 800.0), (100.0, 800.0), (100.0, 600.0)] {
        // The base is in front of the hill instead of on its slope.
        let relief = Relief { hill_m, wide_m: 0.5 * wide_m, slope: 0.0 };
        assert_flown_over("fixed-wing-mapper", relief, 25.0);
    }
}

#[test]
fn a_flight_that_ends_in_the_ground_is_found() {
    let relief = Relief { hill_m: 300.0, ..FLAT };
    let program = relief.program("quadrotor");
    let head = program.split("(solver").next().unwrap();
    let dash = format!(
        "{head}(primitive (index (dash to ?place)) (profile flight-path) (on-start (command (fly-to ?place) :timeout 1h)))\n\
         (procedure :sequential (index (fly the mission)) (step up (take off to 560m)) (step go (dash to (46.02 8.0 560))))"
    );
    let flown = relief.fly(&dash);
    assert!(!flown.said("crashed").is_empty(), "{}", flown.text());
    let check = flown.check();
    assert!(check.findings.iter().any(|finding| finding.violation == Violation::Crashed), "{check}");
    assert!(check.violations() > 0, "{check}");
}

/// Beyond its field the aircraft followed the ground that falls away, some metres above it, for 20 km.
#[test]
fn a_fixed_wing_lands_on_its_field_on_a_slope() {
    let relief = Relief { slope: 0.025, ..FLAT };
    let program = relief.program("predator-b").replace(":terrain", ":forecast \"w.csv\" :terrain");
    let head = program.split("(solver").next().unwrap();
    let there_and_back = format!(
        "{head}(procedure :sequential (index (fly the mission)) (step up (take off to 2500m)) (step go (fly to (46.15 8.0)))\n\
         (step home (return to home at 2500m)))"
    );
    let home = feature(r#""id": "home", "kind": "base""#, &point(HOME.1, HOME.0));
    // It lands to the south, down the slope.
    let wind = "altitude_m_min,altitude_m_max,wind_from_deg,wind_speed_mps\n0,20000,180,3\n";
    let ground = relief.grid(0.5);
    let flown = fly(&there_and_back, &[("t.geojson", &collection(&[home])), ("ground.asc", &ground), ("w.csv", wind)]);
    assert!(!flown.said("landed").is_empty(), "{}", flown.text());
    let (_, latitude, longitude, _) = *flown.track().last().unwrap();
    let (north_deg, east_deg) = (latitude - HOME.0, (longitude - HOME.1) * HOME.0.to_radians().cos());
    let off_m = METRES_PER_DEGREE * north_deg.hypot(east_deg);
    assert!(off_m < 4_000.0, "the aircraft stands {off_m:.0} m from the base");
}

/// The wind leads over the rising ground: the aircraft flew into it on its final approach, which was not examined.
#[test]
fn a_small_fixed_wing_lands_over_the_lower_ground() {
    let relief = Relief { slope: 0.1, ..FLAT };
    let program = relief.program("fixed-wing-mapper").replace(":terrain", ":forecast \"w.csv\" :terrain");
    let head = program.split("(solver").next().unwrap();
    let there_and_back = format!(
        "{head}(procedure :sequential (index (fly the mission)) (step up (take off to 480m)) (step go (fly to (45.99 8.01)))\n\
         (step home (return to home at 480m)))"
    );
    let home = feature(r#""id": "home", "kind": "base""#, &point(HOME.1, HOME.0));
    let wind = "altitude_m_min,altitude_m_max,wind_from_deg,wind_speed_mps\n0,20000,180,3\n";
    let ground = relief.grid(0.08);
    let flown = fly(&there_and_back, &[("t.geojson", &collection(&[home])), ("ground.asc", &ground), ("w.csv", wind)]);
    assert!(!flown.said("landed").is_empty(), "{}", flown.text());
    assert_eq!(flown.check().violations(), 0, "{}", flown.check());
}
