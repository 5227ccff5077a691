//! Example 2 of the paper in whole flights: a link is lost, and the aircraft returns, waits, obeys commands, and remembers the place.
//! Distances and signal levels are computed here, from the recorded samples alone.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a failed test should stop")]
#![allow(clippy::disallowed_methods, reason = "this check computes distances apart from the product")]

#[path = "communication/flown.rs"]
mod flown;
#[path = "support/shipped.rs"]
mod shipped;

use flown::{Flown, World};

const SHADOW: &str = ":shadows ((:around mill :radius 700m :factor 0.05))";

/// Returns three sites; the mill lies in a shadow that the mission does not state.
fn hidden_shadow(vehicle: &str) -> World {
    World::new(vehicle)
        .site("barn", 900.0, 300.0)
        .site("mill", 2_600.0, 0.0)
        .site("farm", 600.0, -900.0)
        .modem(&format!(":station home :full-level 1500m {SHADOW}"))
}

/// After each loss the aircraft comes within 200 m of the last place with a good link before it makes any other statement.
fn assert_returned(flown: &Flown) {
    let after = |at_s: f64, heads: &[&str]| {
        let said = heads.iter().flat_map(|head| flown.said(head)).map(|said| said.0).filter(|said_s| *said_s > at_s);
        said.fold(f64::INFINITY, f64::min)
    };
    for (lost_s, _) in flown.said("communication-lost") {
        let good = flown.last_good_place(lost_s);
        let until_s = after(lost_s, &["communication-regained", "communication-not-regained"]);
        let nearest_m = flown.nearest_m(good, (lost_s, until_s));
        assert!(nearest_m <= 200.0, "{nearest_m:.0} m from the good place after {lost_s} s\n{}", flown.story());
    }
}

/// After each loss the aircraft comes within 200 m of the place that it names, and the link was good there: ten seconds of samples around
/// the pass before the loss have a mean above 0.3. Near the range of a radio, fading blurs the edge of the coverage.
fn assert_returned_to_the_goal(flown: &Flown) {
    // At 25 minutes the mission calls home, which outranks the return.
    for (lost_s, _) in flown.said("communication-lost").into_iter().filter(|(at_s, _)| *at_s < 1_500.0 - 300.0) {
        let goal = flown.goal_after(lost_s);
        let nearest_m = flown.nearest_m(goal, (lost_s, lost_s + 600.0));
        assert!(nearest_m <= 200.0, "{nearest_m:.0} m from the place after {lost_s} s\n{}", flown.story());
        let level = flown.mean_level_near(goal, lost_s);
        assert!(level > 0.3, "{level:.2} at the place after {lost_s} s\n{}", flown.story());
    }
}

fn first_s(flown: &Flown, head: &str) -> f64 {
    flown.said(head).first().map(|said| said.0).unwrap_or_else(|| panic!("no {head}\n{}", flown.story()))
}

fn assert_landed_at_home(flown: &Flown) {
    let (_, here, _) = *flown.track().last().unwrap();
    let nearest_m = flown::apart_m(here, flown::at(0.0, 0.0));
    // A fixed wing rolls out on its runway.
    assert!(flown.landed() && nearest_m < 600.0, "{nearest_m:.0} m from home\n{}", flown.story());
}

#[test]
fn the_default_comes_at_the_deadline_and_the_shadow_is_not_tried_again() {
    for vehicle in ["rmax", "fixed-wing-mapper"] {
        let flown = hidden_shadow(vehicle).fly();
        assert_eq!(flown.said("communication-lost").len(), 1, "{vehicle}\n{}", flown.story());
        assert_returned(&flown);
        let waited_s = first_s(&flown, "instructed") - first_s(&flown, "awaiting-instructions");
        assert!((waited_s - 120.0).abs() < 1.0, "{vehicle}: the deadline was {waited_s} s");
        assert!(first_s(&flown, "communication-lost") < first_s(&flown, "communication-regained"));
        assert!(first_s(&flown, "communication-regained") <= first_s(&flown, "awaiting-instructions"));
        let reason = flown.reason_left_out("mill");
        assert!(reason.contains("the link over 900MHzModem"), "{vehicle}: {reason}");
        // The others are visited again afterwards.
        let resumed_s = first_s(&flown, "instructed");
        assert!(flown.said("observed").iter().any(|(at_s, _)| *at_s > resumed_s), "{vehicle}\n{}", flown.story());
        flown.assert_replays();
    }
}

#[test]
fn a_fixed_wing_circles_through_the_good_place_while_it_waits() {
    let flown = hidden_shadow("fixed-wing-mapper").fly();
    let good = flown.last_good_place(first_s(&flown, "communication-lost"));
    let (from_s, until_s) = (first_s(&flown, "awaiting-instructions"), first_s(&flown, "instructed"));
    let middle_s = 0.5 * (from_s + until_s);
    for half in [(from_s, middle_s), (middle_s, until_s)] {
        let nearest_m = flown.nearest_m(good, half);
        assert!(nearest_m <= 200.0, "{nearest_m:.0} m from {half:?}\n{}", flown.story());
    }
    let farthest_m = flown.farthest_m(good, (from_s, until_s));
    assert!(farthest_m < 800.0, "{farthest_m:.0} m away");
}

/// A large fixed wing: its circle is 6 km across.
#[test]
fn a_large_fixed_wing_comes_by_the_good_place_in_every_circle() {
    let world = World::new("predator-b")
        .site("barn", 8_000.0, 3_000.0)
        .site("mill", 42_000.0, 0.0)
        .modem(":station home :full-level 20km :shadows ((:around mill :radius 14km :factor 0.05))")
        .options(":lost-link (:instructions-within 7min)")
        .lasting("2h");
    let flown = world.fly();
    assert!(!flown.said("communication-lost").is_empty(), "{}", flown.story());
    assert_returned(&flown);
    let good = flown.last_good_place(first_s(&flown, "communication-lost"));
    let passes = flown.passes(good, 600.0, (first_s(&flown, "communication-lost"), first_s(&flown, "instructed")));
    assert!(passes >= 2, "{passes} passes\n{}", flown.story());
}

#[test]
fn an_instruction_is_obeyed_before_the_deadline() {
    for vehicle in ["rmax", "fixed-wing-mapper"] {
        let told_s = (first_s(&hidden_shadow(vehicle).fly(), "awaiting-instructions") + 20.0).round();
        let flown = hidden_shadow(vehicle).event(told_s, "(instruction (skip mill))").fly();
        let at_s = first_s(&flown, "instructed");
        assert_eq!(at_s, told_s, "{vehicle}\n{}", flown.story());
        assert_eq!(flown.said("communication-lost").len(), 1, "{vehicle}\n{}", flown.story());
        assert!(flown.said("observing").iter().all(|(_, text)| !text.contains("mill")), "{vehicle}");

        let flown = hidden_shadow(vehicle).event(told_s, "(instruction go-home)").fly();
        assert_eq!(first_s(&flown, "contingency-route"), told_s, "{vehicle}\n{}", flown.story());
        assert_landed_at_home(&flown);
    }
}

#[test]
fn a_link_that_stays_silent_is_answered_by_the_contingency_route() {
    for vehicle in ["rmax", "fixed-wing-mapper"] {
        let world = hidden_shadow(vehicle)
            .site("ranch", -1_500.0, 800.0)
            .modem(":station home :full-level 1500m :dropouts ((300s 30min))")
            .options(":lost-link (:regain-within 90s :contingency ranch)");
        let flown = world.fly();
        assert_eq!(flown.said("communication-lost").len(), 1, "{vehicle}\n{}", flown.story());
        assert_returned(&flown);
        let waited_s = first_s(&flown, "communication-not-regained") - first_s(&flown, "communication-lost");
        assert!((90.0..200.0).contains(&waited_s), "{vehicle}: {waited_s}");
        assert!(flown.said("awaiting-instructions").is_empty(), "no operator can hear it");
        let (_, here, _) = *flown.track().last().unwrap();
        let off_m = flown::apart_m(here, flown::at(-1_500.0, 800.0));
        assert!(flown.landed() && off_m < 600.0, "{vehicle}: {off_m:.0} m from the ranch\n{}", flown.story());
        flown.assert_replays();
    }
}

#[test]
fn a_stated_shadow_is_never_entered() {
    for vehicle in ["rmax", "fixed-wing-mapper"] {
        let map = format!(":link-map ((900MHzModem :station home :full-level 1500m {SHADOW}))");
        let flown = hidden_shadow(vehicle).options(&map).fly();
        assert!(flown.said("communication-lost").is_empty(), "{vehicle}\n{}", flown.story());
        let reason = flown.reason_left_out("mill");
        assert!(reason.contains("predicted 0.0"), "{vehicle}: {reason}");
    }
}

/// SplitMix64 (Steele, Lea, Flood 2014), as a number from 0 to 1.
struct Draws(u64);

impl Draws {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }
}

/// Random ranges, shadows and sites. One flight has at most one loss for each site; all flights together have at most one loss for each
/// shadow and each range. Several sites may lie behind one shadow.
#[test]
fn losses_are_bounded_whatever_the_world_hides() {
    let seeds = std::env::var("APEX_LINK_SEEDS").ok().and_then(|text| text.parse().ok()).unwrap_or(6);
    let (mut total, mut expected) = (0, 0);
    for seed in 0u64..seeds {
        let vehicle = if seed % 2 == 0 { "rmax" } else { "fixed-wing-mapper" };
        let mut draws = Draws(seed.wrapping_mul(7_919));
        let mut world = World::new(vehicle);
        let mut sites = Vec::new();
        for number in 0..4 + (draws.between(0.0, 5.0) as usize) {
            let (east_m, north_m) = (draws.between(-3_500.0, 3_500.0), draws.between(-3_500.0, 3_500.0));
            world = world.site(&format!("site-{number}"), east_m, north_m);
            sites.push((east_m, north_m));
        }
        let shadows = draws.between(0.0, 3.99) as usize;
        let discs: Vec<String> = (0..shadows)
            .map(|_| {
                let (east_m, north_m) = loop {
                    let at = (draws.between(-3_500.0, 3_500.0), draws.between(-3_500.0, 3_500.0));
                    // The pad is not in a shadow.
                    if at.0.hypot(at.1) > 1_600.0 {
                        break at;
                    }
                };
                let (latitude, longitude) = flown::at(east_m, north_m);
                let (radius_m, factor) = (draws.between(250.0, 1_000.0), draws.between(0.0, 0.2));
                format!("(:around ({latitude:.5} {longitude:.5}) :radius {radius_m:.0}m :factor {factor:.2})")
            })
            .collect();
        let full_m = draws.between(60.0, 1_000.0);
        let modem = format!(":station home :full-level {full_m:.0}m :shadows ({})", discs.join(" "));
        let flown = world.modem(&modem).fly();
        let losses = flown.said("communication-lost").len();
        let most = sites.len().min(5);
        total += losses;
        expected += shadows + 1;
        let what = format!("seed {seed}, {vehicle}, {modem}\n{sites:?}");
        assert!(losses <= most, "{losses} losses, more than {most}: {what}\n{}", flown.story());
        assert_returned_to_the_goal(&flown);
        if seed % 4 == 0 {
            flown.assert_replays();
        }
    }
    assert!(total <= expected, "{total} losses in {seeds} flights, more than {expected}");
}

/// Every figure of the settings, wrong in each possible way: the error names the option, the key and the correction.
#[test]
fn impossible_figures_are_refused_by_name() {
    let with = |modem: &str, options: &str| {
        let folder = tempfile::tempdir().unwrap();
        let world = World::new("rmax").site("mill", 900.0, 0.0).modem(modem).options(options);
        world.load(folder.path()).map(|_| ()).map_err(|error| {
            let place = error.place.clone().unwrap_or_default();
            assert!(place.contains("mission.pdl:") && !place.ends_with(":1:1"), "the option: {place}");
            assert!(error.help.is_some_and(|help| help.starts_with("write ")));
            format!("{}: {}", error.message, error.reason.unwrap_or_default())
        })
    };
    let cases = [
        (":station", "", "expected keys, each with a value"),
        (":station nowhere", "", "`nowhere` is not a place of the mission"),
        (":station home :full-level -5m", "", "`:full-level -5m` is not a length in metres above 0"),
        (":station home :full-level 0m", "", "is not a length in metres above 0"),
        (":station home :full-level 3s", "", "is not a length"),
        (":station home :full-level 2km :range 1km", "", "is not beyond the 2000 m of full level"),
        (":station home :range 9km :exponent 3", "", "both determine how fast"),
        (":station home :exponent 0.5", "", "`:exponent 0.5` is below 1"),
        (":full-level 2km", "", "needs a `:station`"),
        (":station home :levels ((1km 1))", "", "expected two pairs or more"),
        (":station home :levels ((2km 1) (1km 0))", "", "distances must rise"),
        (":station home :levels ((1km 0.2) (2km 0.9))", "", "levels must not"),
        (":station home :levels ((1km 1) (2km 7))", "", "is not a number from 0 to 1"),
        (":station home :levels ((1km 1) (2km 0)) :range 9km", "", "`:levels` excludes"),
        (":station home :shadows ((:around mill))", "", "needs `:radius`"),
        (":station home :shadows ((:radius 3m))", "", "`:radius` belongs to a shadow with `:around`"),
        (":station home :shadows ((:factor 0.2))", "", "has no shape"),
        (":station home :shadows ((:around mill :radius 3m :factor 2))", "", "`:factor 2` is not a number from 0 to 1"),
        (":station home :shadows ((:around mill :radius 3m :below -1m))", "", "`:below -1m` is not a length"),
        (":station home :shadows ((:corners (mill home)))", "", "has 2 places"),
        (":station home :shadows ((:sector (40deg)))", "", "expected two directions"),
        (":station home :shadows ((:ridge (mill home)))", "", "needs `:top`"),
        (":station home :shadows ((:ridge (mill home) :top 90m :factor 0.5))", "", "leave `:factor` out"),
        (":station home :shadows ((:around mill :corners (mill home mill) :radius 3m))", "", "not both"),
        (":station home :shadows ((:hill mill))", "", "unknown key `:hill`"),
        (":station home :fading-db -1", "", "`:fading-db -1` is not a number from 0 to 30"),
        (":station home :dropouts ((5min 2min))", "", "is not a list of spans"),
        (":station home :station home", "", "`:station` is given twice"),
        (":station home :power 3", "", "unknown key `:power`"),
        (":station home", ":link-map ((900MHzModem :full-level 1km))", "needs a `:station`"),
        (":station home", ":link-map ((900MHzModem))", "it has no `:station`"),
        (":station home", ":link-map ((900MHzModem :station home :dropouts ((1h 2h))))", "unknown key `:dropouts`"),
        (":station home", ":lost-link (:nominal 1.2)", "`:nominal 1.2` is not a number from 0 to 1"),
        (":station home", ":lost-link (:nominal 0)", "never finds a link weak"),
        (":station home", ":lost-link (:nominal 0.5 :good 0.4)", "not above the nominal level"),
        (":station home", ":lost-link (:weak-for -3s)", "is not a duration in seconds above 0"),
        (":station home", ":lost-link (:default stay)", "is not resume or go-home"),
        (":station home", ":lost-link (:losses-max 1.5)", "is not a whole number"),
        (":station home", ":lost-link (:contingency nowhere)", "`nowhere` is not a place"),
        (":station home", ":lost-link (:patience 3s)", "unknown key `:patience`"),
    ];
    for (modem, options, wanted) in cases {
        let error = with(modem, options).expect_err(&format!("{modem} {options}"));
        assert!(error.contains(wanted), "{modem} {options}: {error}");
    }
    with(":station home :full-level 1km :range 8km :fading-db 0", ":lost-link (:good 0.4)").unwrap();
    with("", "").unwrap();
}

/// Wherever the shadow lies along the pipeline, only the points inside it are missed, and the rest of the mission is flown.
#[test]
fn a_pipeline_is_inspected_beyond_a_shadow() {
    use apex_mission::Mission;
    use apex_mission::deliberation::PlanningResources;
    use apex_mission::flight::MissionFlight;
    use apex_mission::report::MissionValue;
    for (middle, least_points) in [("flange-20", 310.0), ("crossing-23", 340.0)] {
        let around = format!(":around {middle}");
        let changes = [(":around crossing-23", around.as_str()), (":budget 2s", ":budget 200ms")];
        let folder = shipped::copy_with("pipeline-inspection", &changes);
        let mission = std::sync::Arc::new(Mission::load(folder.path()).unwrap());
        let mut vehicle = apex_simulation::world(&mission, None).unwrap();
        let means = PlanningResources::of(&std::sync::Arc::new(apex_solvers::shipped()));
        let terms = MissionFlight::terms(&mission, None);
        let flown =
            MissionFlight::new(std::sync::Arc::clone(&mission), means).fly(&mut vehicle, terms, &mut []).unwrap();
        let text = flown.report.text();
        assert_eq!(flown.report.end.1, "the initial task is done", "{middle}: {text}");
        let losses = flown.report.notes.iter().filter(|note| note.text.contains("lost: going back")).count();
        assert!((1..=2).contains(&losses), "{middle}: {losses} losses\n{text}");
        let MissionValue::Score(score) = &flown.report.value else { panic!("of another kind") };
        let points: f64 = score.looks.iter().map(|look| look.flown.points).sum();
        assert!(points >= least_points, "{middle}: {points:.0} points\n{text}");
    }
}
