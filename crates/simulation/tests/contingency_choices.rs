//! Choices of library "contingencies": where to land, what to do without a link that no place improves, and what to do without readings.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a failed test should stop")]
#![allow(clippy::disallowed_methods, reason = "this check computes distances apart from the product")]

#[path = "contingencies/flown.rs"]
mod flown;

use flown::{Flight, Flown};

/// To a place 100 km north, beyond the second airfield, and back.
const FAR_NORTH: &str =
    "(step up (take off to 4000m)) (step out (fly to (37.9 -117.0 4000))) (step home (return to home at 4000m))";

/// Returns a restricted zone of 20 km around a latitude on the meridian of the airfields.
fn zone(name: &str, latitude_deg: f64) -> String {
    let (south, north) = (latitude_deg - 0.09, latitude_deg + 0.09);
    format!(
        r#"{{"type": "Feature", "properties": {{"id": "{name}", "name": "{name}", "kind": "restricted", "altitude_m_min": 0, "altitude_m_max": 20000}},
            "geometry": {{"type": "Polygon", "coordinates": [[[-117.1, {south}], [-116.9, {south}], [-116.9, {north}], [-117.1, {north}], [-117.1, {south}]]]}}}}"#
    )
}

fn zones(features: &[String]) -> &'static str {
    format!(r#"{{"type": "FeatureCollection", "features": [{}]}}"#, features.join(", ")).leak()
}

fn fly(guards: &'static str, faults: &'static str, zone: &'static str) -> Flown {
    let guards = format!("(step safe (guard the flight)) {guards}").leak();
    let world = format!(r#""faults": [{faults}]"#).leak();
    let flown =
        Flight { guards, work: FAR_NORTH, world, zone, options: ":airspace \"zone.geojson\"", ..Flight::default() }
            .fly();
    assert_eq!((flown.count("(landed uav-1)"), flown.count("(crashed")), (1, 0), "{}", flown.story());
    flown.assert_replays();
    flown
}

const LEAK: (&str, &str) = ("(step guard (guard against leaks))", r#"{"fault": "leak", "by": 300, "at_s": 1000}"#);
const ENGINE: (&str, &str) = ("(step guard (guard against engine failure))", r#"{"fault": "engine", "at_s": 720}"#);

/// The nearest airfield is inside a restricted zone; the other one is in reach.
#[test]
fn a_landing_avoids_places_inside_restricted_zones() {
    for (guards, fault) in [LEAK, ENGINE] {
        let flown = fly(guards, fault, zones(&[zone("north", 37.54)]));
        let from_home_m = flown.last_distance_m(37.0, -117.0);
        assert!(from_home_m < 3_000.0, "{fault}: {from_home_m} m from home\n{}", flown.story());
        assert_eq!(flown.count("(requirement-broken"), 0, "{}", flown.story());
        assert_eq!(flown.verified().inside_zones, 0, "{fault}: {}", flown.verified());
        let why = if fault == LEAK.1 { "leak" } else { "the engine has stopped" };
        assert_eq!(flown.end, format!("the aircraft landed early at home: {why}"));
    }
}

/// Both airfields are inside restricted zones: the landing breaks one on purpose, and the guard of the airspace does not turn it away.
#[test]
fn a_landing_that_must_break_a_zone_reports_it_and_is_not_turned_away() {
    let features = [zone("north", 37.54), zone("south", 37.0)];
    for (guards, fault) in [LEAK, ENGINE] {
        let guards = format!("(step idle (wait 1s)) {guards}").leak();
        // The zone around home begins after the take-off.
        let south = features[1].replace(r#""kind""#, r#""active_h": [[0.17, 10]], "kind""#);
        let flown = fly(guards, fault, zones(&[features[0].clone(), south]));
        let landing_s = flown
            .said
            .iter()
            .find(|(_, said)| said.contains("landing-because leak") || said.contains("engine-out"))
            .unwrap()
            .0;
        let turned = flown
            .said
            .iter()
            .filter(|(at_s, said)| *at_s > landing_s && said.starts_with("(requirement-at-risk airspace"))
            .count();
        assert_eq!(turned, 0, "{fault}\n{}", flown.story());
        assert!(flown.count("(requirement-broken") >= 1, "{fault}\n{}", flown.story());
        let missed_m = flown.last_distance_m(37.54, -117.0).min(flown.last_distance_m(37.0, -117.0));
        assert!(missed_m < 3_000.0, "{missed_m} m from a field\n{}", flown.story());
    }
}

/// A satellite link that drops out during the climb: no place improves it, so the aircraft climbs to its altitude while it waits.
#[test]
fn a_lost_satellite_link_does_not_interrupt_the_climb() {
    let flown = Flight {
        guards: "(step talk (keep in touch over sat))",
        work: FAR_NORTH,
        options: ":modems ((sat :dropouts ((1min 2min))))",
        ..Flight::default()
    }
    .fly();
    assert_eq!(flown.count("(communication-lost"), 1, "{}", flown.story());
    let lost_s = flown.first_s("(communication-lost");
    let back = flown.commands.iter().find(|(at_s, command)| *at_s >= lost_s && command.starts_with("(fly-to"));
    assert!(back.is_none_or(|(at_s, _)| *at_s > lost_s + 180.0), "{:?}", flown.commands);
    for after_s in [60.0, 120.0, 180.0] {
        let [before_m, now_m] =
            [lost_s + after_s - 60.0, lost_s + after_s].map(|at_s| flown.number_at("(altitude uav-1)", at_s));
        assert!(now_m > before_m + 60.0, "{after_s} s: {before_m} to {now_m} m: {:?}", flown.commands);
    }
    assert_eq!(flown.count("(landed uav-1)"), 1, "{}", flown.story());
    flown.assert_replays();
}

/// Two losses on the way to the same place end a flight, unless the place has no influence on the link.
#[test]
fn losses_of_a_satellite_link_are_not_those_of_a_place() {
    let flown = Flight {
        guards: "(step talk (keep in touch over sat))",
        work: FAR_NORTH,
        options: ":modems ((sat :dropouts ((20min 21min) (28min 29min))))",
        ..Flight::default()
    }
    .fly();
    assert_eq!((flown.count("(communication-lost"), flown.count("(contingency-route")), (2, 0), "{}", flown.story());
    assert_eq!(flown.count("(instructed sat resume)"), 2, "{}", flown.story());
    assert!(flown.last_distance_m(37.0, -117.0) < 3_000.0, "{}", flown.story());
    flown.assert_replays();
}

/// The vehicle reports no position, or always the same one: it waits for positions, and lands.
#[test]
fn a_flight_without_positions_ends() {
    for fault in ["silence", "freeze"] {
        let world = format!(r#""faults": [{{"fault": "{fault}", "of": "location", "at_s": 600}}]"#).leak();
        let guards = "(step guard (guard against navigation failure))";
        let flown = Flight { guards, work: FAR_NORTH, world, ..Flight::default() }.fly();
        let said = if fault == "silence" { "(reading-silent location" } else { "(reading-frozen location" };
        let found_s = flown.first_s(said);
        assert!((650.0..720.0).contains(&found_s), "{fault}: {found_s}");
        assert_eq!(flown.count("(landing-because position"), 1, "{}", flown.story());
        assert_eq!(flown.count("(landed uav-1)"), 1, "{}", flown.story());
        let verified = flown.verified();
        assert!(!verified.is_verified() && verified.violations() == 0, "{verified}");
        let (from_s, until_s) = verified.unverified_s[0];
        assert!((590.0..=610.0).contains(&from_s) && until_s > 1_200.0, "{verified}");
        flown.assert_replays();
    }
    // A reading that returns: the flight continues.
    let world = r#""faults": [{"fault": "silence", "of": "location", "at_s": 600, "for_s": 200}]"#;
    let flown = Flight {
        guards: "(step guard (guard against navigation failure))",
        work: FAR_NORTH,
        world,
        ..Flight::default()
    }
    .fly();
    assert_eq!(
        (flown.count("(reading-regained location"), flown.count("(landing-because")),
        (1, 0),
        "{}",
        flown.story()
    );
    assert!(flown.last_distance_m(37.0, -117.0) < 3_000.0, "{}", flown.story());
}

/// No positions on the ground: the take-off waits for them, and nothing is commanded meanwhile.
#[test]
fn an_aircraft_on_the_ground_waits_for_positions_without_a_command() {
    let flown = Flight {
        guards: "(step guard (guard against navigation failure))",
        work: "(step pause (wait 3min)) (step up (take off to 4000m)) (step home (return to home at 4000m))",
        world: r#""faults": [{"fault": "silence", "of": "location", "at_s": 30, "for_s": 300}]"#,
        ..Flight::default()
    }
    .fly();
    assert!(flown.first_s("(reading-silent location") < 100.0, "{}", flown.story());
    assert_eq!((flown.count("(landed uav-1)"), flown.count("(landing-because")), (1, 0), "{}", flown.story());
    let (first_s, first) = &flown.commands[0];
    assert!(*first_s > 330.0 && first.starts_with("(take-off"), "{first_s} {first}\n{}", flown.story());
}

/// Without a reading of the fuel no leak can be found.
#[test]
fn a_flight_without_a_reading_of_the_fuel_ends() {
    for (fault, said) in [("silence", "(reading-silent fuel"), ("freeze", "(reading-frozen fuel")] {
        let world = format!(r#""faults": [{{"fault": "{fault}", "of": "fuel", "at_s": 600}}]"#).leak();
        let guards = "(step guard (guard against frozen readings))";
        let flown = Flight { guards, work: FAR_NORTH, world, ..Flight::default() }.fly();
        let found_s = flown.first_s(said);
        assert!((890.0..1_230.0).contains(&found_s), "{fault}: {found_s}");
        assert_eq!(flown.count("(landing-because reading"), 1, "{}", flown.story());
        assert_eq!(flown.count("(landed uav-1)"), 1, "{}", flown.story());
        flown.assert_replays();
    }
}

/// A battery whose charge falls faster than its power explains leaks as a tank does. The quadrotor flew on until it was empty, and crashed.
#[test]
fn a_slow_leak_of_a_battery_is_found_and_the_flight_ends() {
    let work =
        "(step up (take off to 400m)) (step out (fly to (37.1 -117.0 400))) (step home (return to home at 400m))";
    let world = r#""faults": [{"fault": "leak", "by": 900, "at_s": 300}]"#;
    let flight = |guards| Flight { vehicle: "quadrotor", guards, work, world, ..Flight::default() }.fly();
    let careless = flight("");
    assert_eq!((careless.count("(landed uav-1)"), careless.count("(crashed")), (0, 1), "{}", careless.story());
    let flown = flight("(step guard (guard against leaks))");
    let found_s = flown.first_s("(leak-found uav-1");
    assert!((360.0..400.0).contains(&found_s), "{found_s}");
    assert_eq!((flown.count("(leak-found"), flown.count("(landing-because leak")), (1, 1), "{}", flown.story());
    assert_eq!((flown.count("(landed uav-1)"), flown.count("(crashed")), (1, 0), "{}", flown.story());
    flown.assert_replays();
}

/// The usable charge falls in cold air: a long climb, a descent and flight in frost are not a leak.
#[test]
fn a_climb_into_the_cold_is_not_a_leak() {
    for vehicle in ["quadrotor", "fixed-wing-mapper"] {
        let work = "(step up (take off to 2500m)) (step out (fly to (37.03 -117.0 2500))) (step down (fly to (37.03 -117.0 900))) \
                    (step home (return to home at 900m))";
        let flown = Flight { vehicle, guards: "(step guard (guard against leaks))", work, ..Flight::default() }.fly();
        let told = flown.numbers("(battery-charge uav-1)");
        assert!(told.len() > 30, "{vehicle}: {}", told.len());
        assert_eq!((flown.count("(leak-found"), flown.count("(landed uav-1)")), (0, 1), "{vehicle}\n{}", flown.story());
    }
}
