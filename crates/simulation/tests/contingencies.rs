//! Contingencies of library "contingencies", each with an injected failure or weather: the response follows the failure within its time
//! limit, reaches its purpose, and ends when the cause is gone. The recorded flight is compared, not the plan.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a failed test should stop")]
#![allow(clippy::disallowed_methods, reason = "this check computes distances apart from the product")]

#[path = "contingencies/flown.rs"]
mod flown;

use flown::Flight;

/// To a place 60 km north, and back.
const NORTH: &str =
    "(step up (take off to 4000m)) (step out (fly to (37.5 -117.0 4000))) (step home (return to home at 4000m))";

/// To a place 100 km north, and back.
const FAR_NORTH: &str =
    "(step up (take off to 4000m)) (step out (fly to (37.9 -117.0 4000))) (step home (return to home at 4000m))";

#[test]
fn without_failures_no_contingency_is_raised() {
    let guards = "(step guard (guard against contingencies)) (step lease (guard the lease of pilot for 5h))";
    for vehicle in ["predator-b", "fixed-wing-mapper", "rmax", "quadrotor"] {
        let work =
            "(step up (take off to 400m)) (step out (fly to (37.05 -117.0 400))) (step home (return to home at 400m))";
        let flown = Flight { vehicle, guards, work, ..Flight::default() }.fly();
        let raised = [
            "(engine-out",
            "(leak-found",
            "(navigation-",
            "(reading-frozen",
            "(icing-",
            "(rough-",
            "(storm-",
            "(lease-",
            "(violated",
        ];
        for text in raised {
            assert_eq!(flown.count(text), 0, "{vehicle}: {text}\n{}", flown.story());
        }
        assert!(flown.count("(landed uav-1)") == 1, "{vehicle}\n{}", flown.story());
        flown.assert_replays();
    }
}

#[test]
fn without_engine_the_aircraft_glides_to_the_field_in_reach() {
    let flown = Flight {
        guards: "(step guard (guard against engine failure))",
        work: NORTH,
        world: r#""faults": [{"fault": "engine", "at_s": 900}]"#,
        ..Flight::default()
    }
    .fly();
    let out_s = flown.first_s("(engine-out uav-1");
    assert!((900.0..905.0).contains(&out_s), "{out_s}");
    let place = if flown.count("(engine-out uav-1 field)") == 1 { (37.54, -117.0) } else { (37.0, -117.0) };
    assert_eq!(flown.count("(engine-out uav-1 nil)"), 0, "{}", flown.story());
    assert!(flown.count("(landed uav-1)") == 1 && flown.count("(crashed") == 0, "{}", flown.story());
    let missed_m = flown.last_distance_m(place.0, place.1);
    assert!(missed_m < 3_000.0, "{missed_m} m from the field\n{}", flown.story());
    flown.assert_replays();
}

/// Another task takes the flight path during the climb; the take-off continues it, a helicopter on the spot.
#[test]
fn an_interrupted_take_off_climbs_to_its_altitude() {
    let halts = [
        ("rmax", "(step halt (hover for 10s) (waitfor (:delay 30s)) (priority 99))", "(hover ("),
        (
            "predator-b",
            "(step halt (loiter at (37.05 -117.0 900) for 60s) (waitfor (:delay 90s)) (priority 99))",
            "(loiter (",
        ),
    ];
    for (vehicle, guards, climb) in halts {
        let altitude_m = if vehicle == "rmax" { 300.0 } else { 3_000.0 };
        let work =
            format!("(step up (take off to {altitude_m}m)) (step home (return to home at {altitude_m}m))").leak();
        let flown = Flight { vehicle, guards, work, ..Flight::default() }.fly();
        let again = flown.commands.iter().skip(2).find(|(_, command)| command.starts_with(climb));
        let (begins_s, _) = again.unwrap_or_else(|| panic!("{vehicle}: no {climb}: {:?}", flown.commands));
        let home_s =
            flown.commands.iter().find(|(_, command)| command.starts_with("(fly-to home")).map(|(at_s, _)| *at_s);
        let reached_m = flown.number_at("(altitude uav-1)", home_s.unwrap_or_else(|| panic!("{:?}", flown.commands)));
        assert!(
            (reached_m - altitude_m).abs() < 20.0,
            "{vehicle}: {reached_m} m, continued at {begins_s} s: {:?}",
            flown.commands
        );
        assert_eq!(flown.count("(landed uav-1)"), 1, "{vehicle}\n{}", flown.story());
        flown.assert_replays();
    }
}

/// The glide led to the ground below, far from any field, although the engine ran again long before the ground was reached.
#[test]
fn with_power_again_the_aircraft_lands_at_a_field() {
    let fly = |engine: &str| {
        let world = format!(r#""faults": [{engine}]"#).leak();
        let work = "(step up (take off to 4000m)) (step out (fly to (38.6 -117.0 4000))) (step home (return to home at 4000m))";
        let flown =
            Flight { guards: "(step guard (guard against engine failure))", work, world, ..Flight::default() }.fly();
        assert!(flown.count("(landed uav-1)") == 1 && flown.count("(crashed") == 0, "{}", flown.story());
        flown.assert_replays();
        flown
    };
    let stopped = fly(r#"{"fault": "engine", "at_s": 2000}"#);
    let from_field_m = |flown: &flown::Flown| flown.last_distance_m(37.54, -117.0);
    assert!(from_field_m(&stopped) > 20_000.0, "a field is in reach: {}", stopped.story());
    let again = fly(r#"{"fault": "engine", "at_s": 2000, "for_s": 60}"#);
    assert!(from_field_m(&again) < 3_000.0, "{} m\n{}", from_field_m(&again), again.story());
    assert_eq!(again.count("(landing-because engine"), 1, "{}", again.story());
    let twice = fly(r#"{"fault": "engine", "at_s": 2000, "for_s": 60}, {"fault": "engine", "at_s": 2120}"#);
    assert!(from_field_m(&twice) > 3_000.0, "{}", twice.story());
}

/// Returns the instant at which the last phase of a name begins.
fn begins_s(flown: &flown::Flown, phase: &str) -> f64 {
    let phases = flown.words("(flight-phase uav-1)");
    let last = phases.iter().rposition(|(_, word)| word != phase && word != "landing" && word != "parked");
    let begins = last.and_then(|last| phases[last..].iter().find(|(_, word)| word == phase));
    begins.map(|(at_s, _)| *at_s).unwrap_or_else(|| panic!("no {phase}: {phases:?}"))
}

/// The altimeter freezes during the landing: the climb that the guard commanded led past the field.
#[test]
fn a_frozen_altimeter_does_not_raise_an_aircraft_that_lands() {
    let unhurt = Flight { work: NORTH, ..Flight::default() }.fly();
    let landing_s = begins_s(&unhurt, "approaching");
    let world =
        format!(r#""faults": [{{"fault": "freeze", "of": "altitude", "at_s": {}, "for_s": 600}}]"#, landing_s + 10.0)
            .leak();
    let guards = "(step guard (guard against frozen readings))";
    let flown = Flight { guards, work: NORTH, world, ..Flight::default() }.fly();
    assert!(flown.count("(reading-frozen altitude uav-1)") >= 1, "{}", flown.story());
    let raised = flown.commands.iter().find(|(_, command)| command.starts_with("(set-altitude"));
    assert_eq!(raised, None, "{}", flown.story());
    assert!(flown.last_distance_m(37.0, -117.0) < 3_000.0, "{}", flown.story());
    flown.assert_replays();
}

/// The acknowledgement that the aircraft is over home is lost: it circled for three hours, and the mission ended in the air.
#[test]
fn a_flight_home_without_an_answer_ends_with_a_landing() {
    let unhurt = Flight { work: NORTH, ..Flight::default() }.fly();
    let arrives_s = begins_s(&unhurt, "approaching");
    let world =
        format!(r#""faults": [{{"fault": "acknowledgements", "at_s": {}, "for_s": 120}}]"#, arrives_s - 60.0).leak();
    let flown = Flight { work: NORTH, world, ..Flight::default() }.fly();
    assert_eq!(flown.count("(landing-after-failed-flight home)"), 1, "{}", flown.story());
    assert_eq!(flown.count("(landed uav-1)"), 1, "{}", flown.story());
    assert!(flown.last_distance_m(37.0, -117.0) < 3_000.0, "{}", flown.story());
}

#[test]
fn a_leak_is_found_and_the_flight_ends_at_the_nearest_field() {
    let flown = Flight {
        guards: "(step guard (guard against leaks))",
        work: NORTH,
        world: r#""faults": [{"fault": "leak", "by": 60, "at_s": 800}]"#,
        ..Flight::default()
    }
    .fly();
    let found_s = flown.first_s("(leak-found uav-1");
    assert!((860.0..910.0).contains(&found_s), "{found_s}");
    assert_eq!(flown.count("(landing-because leak"), 1, "{}", flown.story());
    assert_eq!(flown.count("(landed uav-1)"), 1, "{}", flown.story());
    flown.assert_replays();
}

#[test]
fn lost_navigation_is_waited_for_and_resumed() {
    let flown = Flight {
        guards: "(step guard (guard against navigation failure))",
        work: NORTH,
        world: r#""faults": [{"fault": "navigation", "at_s": 900, "for_s": 120}]"#,
        ..Flight::default()
    }
    .fly();
    let (lost_s, regained_s) = (flown.first_s("(navigation-lost"), flown.first_s("(navigation-regained"));
    assert!((905.0..925.0).contains(&lost_s), "{lost_s}");
    assert!((1_050.0..1_080.0).contains(&regained_s), "{regained_s}");
    assert_eq!((flown.count("(navigation-lost"), flown.count("(landed uav-1)")), (1, 1), "{}", flown.story());
    flown.assert_replays();
}

#[test]
fn navigation_that_drifts_has_the_aircraft_fly_higher() {
    let flown = Flight {
        guards: "(step guard (guard against navigation failure))",
        work: NORTH,
        world: r#""faults": [{"fault": "navigation", "by": 5, "at_s": 900, "for_s": 100}]"#,
        ..Flight::default()
    }
    .fly();
    let at_s = flown.first_s("(navigation-degraded uav-1)");
    assert!((910.0..940.0).contains(&at_s), "50 m at 5 m/s, then 5 s: {at_s}");
    let (before_m, after_m) =
        (flown.number_at("(altitude uav-1)", at_s), flown.number_at("(altitude uav-1)", at_s + 90.0));
    assert!((after_m - before_m - 150.0).abs() < 20.0, "{before_m} m, then {after_m} m");
}

#[test]
fn a_frozen_altimeter_is_noticed_in_a_climb() {
    let flown = Flight {
        guards: "(step guard (guard against frozen readings))",
        work: NORTH,
        world: r#""faults": [{"fault": "freeze", "of": "altitude", "at_s": 200, "for_s": 60}]"#,
        ..Flight::default()
    }
    .fly();
    let at_s = flown.first_s("(reading-frozen altitude uav-1)");
    assert!((215.0..245.0).contains(&at_s), "{at_s}");
    let during: Vec<f64> =
        flown.numbers("(altitude uav-1)").iter().filter(|(s, _)| (201.0..259.0).contains(s)).map(|(_, m)| *m).collect();
    assert!(during.len() > 3 && during.windows(2).all(|pair| pair[0] == pair[1]), "{during:?}");
}

#[test]
fn ice_is_left_for_warmer_air_and_the_altitude_comes_back() {
    let flown = Flight {
        guards: "(step guard (guard against icing))",
        work: FAR_NORTH,
        world: r#""clouds": [{"latitude_deg": 37.25, "longitude_deg": -117.0, "radius_m": 15000, "base_m": 3000, "top_m": 6000, "cover": 0.9}]"#,
        ..Flight::default()
    }
    .fly();
    let (met_s, left_s) = (flown.first_s("(icing-met uav-1"), flown.first_s("(icing-left uav-1)"));
    assert!(left_s > met_s, "{}", flown.story());
    let exposures = flown.numbers("(ice-exposure uav-1)");
    let most_s = exposures.iter().map(|(_, seconds)| *seconds).fold(0.0, f64::max);
    assert!(most_s > 20.0 && most_s < 400.0, "{most_s} s of icing");
    // The aircraft waited for clear air above freezing, and is back at its altitude.
    let temperatures =
        flown.numbers("(outside-temperature uav-1)").into_iter().filter(|(at_s, _)| (met_s..left_s).contains(at_s));
    let warmest_k = temperatures.map(|(_, kelvin)| kelvin).fold(0.0, f64::max);
    assert!(warmest_k > 273.15, "{warmest_k}");
    let altitude_m = flown.number_at("(altitude uav-1)", left_s);
    assert!((altitude_m - 4_000.0).abs() < 30.0, "{altitude_m} m\n{}", flown.story());
    assert_eq!(flown.count("(landed uav-1)"), 1, "{}", flown.story());
    flown.assert_replays();
}

#[test]
fn rough_air_is_flown_slowly_until_it_is_smooth_for_a_while() {
    let flown = Flight {
        guards: "(step guard (guard against rough air))",
        work: NORTH,
        // A cell on the way is rough air without cloud.
        world: r#""storms": [{"latitude_deg": 37.25, "longitude_deg": -117.0, "radius_m": 6000, "edr": 0.35}]"#,
        ..Flight::default()
    }
    .fly();
    let (rough_s, smooth_s) = (flown.first_s("(rough-air uav-1)"), flown.first_s("(smooth-air uav-1)"));
    let speed = |at_s| flown.number_at("(true-airspeed uav-1)", at_s);
    assert!(
        (speed(smooth_s - 1.0) / speed(rough_s - 1.0) - 0.85).abs() < 0.02,
        "{} {}",
        speed(rough_s - 1.0),
        speed(smooth_s - 1.0)
    );
    assert!((speed(smooth_s + 60.0) / speed(rough_s - 1.0) - 1.0).abs() < 0.02);
    let rough = flown.numbers("(edr uav-1)").into_iter().filter(|(_, edr)| *edr > 0.3).map(|(at_s, _)| at_s);
    assert!(smooth_s - rough.fold(0.0, f64::max) < 90.0 || flown.count("(rough-air") == 2, "{}", flown.story());
}

#[test]
fn a_wrong_forecast_is_reported_and_not_again_at_once() {
    let flown = Flight {
        guards: "(step guard (guard against a wrong forecast))",
        work: FAR_NORTH,
        world: r#""wind_error": {"sigma_mps": 12}"#,
        ..Flight::default()
    }
    .fly();
    let reports: Vec<f64> =
        flown.said.iter().filter(|(_, said)| said == "(violated wind-as-forecast)").map(|(at_s, _)| *at_s).collect();
    assert!(!reports.is_empty(), "{}", flown.story());
    assert!(reports.windows(2).all(|pair| pair[1] - pair[0] > 1_800.0), "{reports:?}");
}

#[test]
fn a_camera_without_cooling_is_switched_off_before_it_is_too_hot() {
    let flown = Flight {
        vehicle: "rmax",
        guards: "(step guard (guard camera-1 against heat))",
        work: "(step on (power-up camera-1)) (step up (take off to 60m)) (step stay (hover for 25min)) (step down (land here))",
        world: r#""faults": [{"fault": "cooling", "of": "camera-1", "at_s": 300, "for_s": 600}]"#,
        ..Flight::default()
    }
    .fly();
    let (hot_s, cool_s) = (flown.first_s("(camera-hot camera-1)"), flown.first_s("(camera-cool camera-1)"));
    let most_k = flown.numbers("(detector-temperature camera-1)").iter().map(|(_, kelvin)| *kelvin).fold(0.0, f64::max);
    assert!((314.0..320.0).contains(&most_k), "{most_k}");
    assert!(hot_s > 400.0 && cool_s > hot_s, "{hot_s} {cool_s}");
    let ready = flown.said.iter().filter(|(_, said)| said == "(ready camera-1)").count();
    assert!(ready >= 2, "{}", flown.story());
}

#[test]
fn a_camera_rests_while_the_sun_is_near_its_sight_line() {
    // At 02:31 UTC the sun is 5 degrees high in the west-northwest; half an hour later it has set.
    let flown = Flight {
        vehicle: "rmax",
        start: "2026-06-02T02:30:00Z",
        guards: "(step guard (guard camera-1 against the sun))",
        work: "(step on (power-up camera-1)) (step up (take off to 60m)) \
               (step look (orient camera-1 to (37.0204 -117.0502 120)) (on-failure (wait 0s))) (step stay (hover for 36min)) (step down (land here))",
        ..Flight::default()
    }
    .fly();
    let (near_s, clear_s) = (flown.first_s("(sun-near camera-1)"), flown.first_s("(sun-clear camera-1)"));
    assert!(near_s < 120.0 && clear_s > 1_500.0, "{near_s} {clear_s}");
    let least_rad = flown.number_at("(sun-angle camera-1)", near_s);
    assert!(least_rad < 8.0_f64.to_radians(), "{least_rad}");
}

#[test]
fn the_run_waits_for_an_operator_that_does_not_renew_the_lease() {
    let guards = "(step guard (guard the lease of pilot for 10min))";
    let flown = Flight {
        guards,
        work: NORTH,
        scenario: "{\"t\": 300, \"event\": \"(lease-renewed pilot)\"}\n{\"t\": 960, \"event\": \"(lease-renewed pilot)\"}\n",
        ..Flight::default()
    }
    .fly();
    assert!((flown.first_s("(lease-ending pilot)") - 780.0).abs() < 1.0, "{}", flown.story());
    assert!((flown.first_s("(lease-expired pilot)") - 900.0).abs() < 1.0, "{}", flown.story());
    assert!((flown.first_s("(lease-regained pilot)") - 960.0).abs() < 1.0, "{}", flown.story());
    assert_eq!(flown.said.iter().filter(|(at_s, said)| *at_s < 960.0 && said.starts_with("(lease-ending")).count(), 1);
    let flown = Flight { guards, work: NORTH, ..Flight::default() }.fly();
    assert!((flown.first_s("(landing-because lease") - 900.0).abs() < 1.0, "{}", flown.story());
    assert_eq!(flown.count("(landed uav-1)"), 1, "{}", flown.story());
    flown.assert_replays();
}

/// Navigation drifts to the east by 16 m/s: an aircraft that reports to fly north enters a zone that begins some kilometres west.
#[test]
fn a_drifting_aircraft_is_judged_where_it_is_and_not_where_it_reports_to_be() {
    let zone = r#"{"type": "FeatureCollection", "features": [{"type": "Feature", "properties": {"id": "r-1", "name": "R-1", "kind": "restricted"},
        "geometry": {"type": "Polygon", "coordinates": [[[-117.3, 37.1], [-117.034, 37.1], [-117.034, 37.6], [-117.3, 37.6], [-117.3, 37.1]]]}}]}"#;
    let flight =
        |world| Flight { work: FAR_NORTH, world, options: ":airspace \"zone.geojson\"", zone, ..Flight::default() };
    let steady = flight("").fly().verified();
    assert_eq!((steady.inside_zones, steady.positions > 500), (0, true), "{steady}");
    let flown = flight(r#""faults": [{"fault": "navigation", "by": 16, "at_s": 500, "for_s": 600}]"#).fly();
    let drifted = flown.verified();
    assert!(drifted.inside_zones > 10, "{drifted}");
    let first = &drifted.findings[0];
    // 3 km at 16 m/s.
    assert!(first.t_s > 690.0 && first.position.longitude_deg < -117.034, "{first:?}");
    let reported = flown.places("(location uav-1)");
    let meanwhile: Vec<_> = reported.iter().filter(|(at_s, _)| (900.0..1_050.0).contains(at_s)).collect();
    assert!(meanwhile.len() > 10 && meanwhile.iter().all(|(_, place)| place[1] > -117.01), "{meanwhile:?}");
    flown.assert_replays();
}

/// At 4,500 m the air is 14 degrees below freezing; the clouds of the forecast reach up to 5,000 m.
#[test]
fn an_aircraft_leaves_the_level_of_ice_before_it_comes_to_the_clouds() {
    let cloud = r#""clouds": [{"latitude_deg": 37.7, "longitude_deg": -117.0, "radius_m": 55000, "base_m": 3000, "top_m": 5000, "cover": 0.9}]"#;
    let work =
        "(step up (take off to 4500m)) (step out (fly to (37.9 -117.0 4500))) (step home (return to home at 5500m))";
    let options = ":cloud-forecast \"clouds.csv\" :requirements ((icing :at-most 1min))";
    let flight = |guards| Flight { guards, work, world: cloud, options, ..Flight::default() }.fly();
    let most_s =
        |flown: &flown::Flown| flown.numbers("(ice-exposure uav-1)").iter().map(|(_, s)| *s).fold(0.0, f64::max);
    let careless = flight("");
    assert!(most_s(&careless) > 200.0, "{}", most_s(&careless));
    let flown = flight("(step guard (guard the flight))");
    let alarm_s = flown.first_s("(requirement-at-risk icing");
    let first_ice_s =
        flown.numbers("(ice-exposure uav-1)").iter().find(|(_, s)| *s > 0.0).map_or(f64::INFINITY, |(at_s, _)| *at_s);
    assert!(alarm_s < first_ice_s, "{alarm_s} {first_ice_s}");
    assert!(most_s(&flown) <= 60.0, "{} s\n{}", most_s(&flown), flown.story());
    assert_eq!(flown.count("(responding icing climb"), 1, "{}", flown.story());
    flown.assert_replays();
}

/// A helicopter flies towards a radio shadow known to its planner: it turns back to where the link was good.
#[test]
fn a_helicopter_turns_away_before_its_link_is_lost_for_too_long() {
    let radio =
        "radio :station home :full-level 2km :range 9km :shadows ((:around (37.03 -117.0) :radius 500m :factor 0.02))";
    let options: &'static str = Box::leak(
        format!(":modems (({radio})) :link-map (({radio})) :requirements ((link :lost-for 10s))").into_boxed_str(),
    );
    let work = "(step up (take off to 60m)) (step out (fly to (37.05 -117.0 60))) (step down (land here))";
    let weakest_s = |flown: &flown::Flown| {
        let (mut longest_s, mut since_s) = (0.0_f64, None);
        for (at_s, level) in flown.numbers("(signal-level radio)") {
            since_s = if level < 0.2 { since_s.or(Some(at_s)) } else { None };
            longest_s = longest_s.max(since_s.map_or(0.0, |since_s| at_s - since_s));
        }
        longest_s
    };
    let flight = |guards| Flight { vehicle: "rmax", guards, work, options, ..Flight::default() }.fly();
    let careless = flight("");
    assert!(weakest_s(&careless) > 30.0, "{}", weakest_s(&careless));
    let flown = flight("(step guard (guard the flight))");
    assert!(flown.count("(requirement-at-risk link \"radio\"") >= 1, "{}", flown.story());
    assert!(weakest_s(&flown) <= 10.0, "{} s\n{}", weakest_s(&flown), flown.story());
    let level = flown.number_at("(signal-level radio)", flown.first_s("(responded link)"));
    assert!(level >= 0.3, "it waits where the link is good: {level}\n{}", flown.story());
    assert_eq!(flown.count("(responding link land-at"), 1, "the fourth alarm ends the flight\n{}", flown.story());
    flown.assert_replays();
}

#[test]
fn a_camera_is_off_before_its_detector_is_as_hot_as_the_mission_permits() {
    let flown = Flight {
        vehicle: "rmax",
        guards: "(step guard (guard the flight))",
        options: ":requirements ((heat :at-most 315K))",
        work: "(step on (power-up camera-1)) (step up (take off to 60m)) (step stay (hover for 30min)) (step down (land here))",
        world: r#""faults": [{"fault": "cooling", "of": "camera-1", "at_s": 300, "for_s": 600}]"#,
        ..Flight::default()
    }
    .fly();
    let alarm_s = flown.first_s("(requirement-at-risk heat \"camera-1\"");
    assert!(alarm_s > 310.0, "{alarm_s}");
    let most_k = flown.numbers("(detector-temperature camera-1)").iter().map(|(_, kelvin)| *kelvin).fold(0.0, f64::max);
    assert!((312.0..315.0).contains(&most_k), "{most_k}");
    let ready = flown.said.iter().filter(|(_, said)| said == "(ready camera-1)").count();
    assert!(ready >= 2, "it is on again when it is cool\n{}", flown.story());
    flown.assert_replays();
}
