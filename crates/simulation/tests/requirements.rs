//! Requirements that are guarded in whole flights. Distances are computed here, from the recorded locations alone.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a failed test should stop")]
#![allow(clippy::disallowed_methods, reason = "this check computes distances apart from the product")]

use apex_mission::Mission;
use apex_mission::deliberation::PlanningResources;
use apex_mission::flight::MissionFlight;
use apex_mission::recorded;
use apex_model::event::EventKind;
use apex_model::time::Time;
use apex_model::value::Value;
use apex_runtime::record::RecordReader;
use std::path::PathBuf;
use std::sync::Arc;
use tempfile::TempDir;

/// A recorded flight.
struct Flown {
    _folder: TempDir,
    record: PathBuf,
    mission: Arc<Mission>,
    end: String,
}

/// Flies a mission: its application's options, the body of its program, and its data files.
fn fly(options: &str, body: &str, files: &[(&str, &str)]) -> Flown {
    let folder = tempfile::tempdir().unwrap();
    let text = format!(
        "(defapplication \"Guarded\" :type native-sim :libraries (\"vehicle\" \"contingencies\") {options}\n \
         :agents ((agent uav-1 :initial-task (fly the mission))))\n\
         (primitive (index (dash to ?place)) (profile flight-path) (on-start (command (fly-to ?place) :timeout 10h)))\n{body}"
    );
    std::fs::write(folder.path().join("mission.pdl"), text).unwrap();
    for (name, text) in files {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let mission = Arc::new(Mission::load(folder.path()).unwrap_or_else(|error| panic!("{error:?}")));
    let record = folder.path().join("flight.apex");
    let mut recorder = apex_simulation::create_record(&record, &mission, None).unwrap();
    let terms = MissionFlight::terms(&mission, None);
    let means = PlanningResources::of(&Arc::new(apex_solvers::shipped()));
    let outcome = apex_simulation::fly(Arc::clone(&mission), means, None, terms, &mut recorder, &mut []).unwrap();
    Flown { _folder: folder, record, mission, end: outcome.end.reason.text() }
}

impl Flown {
    fn reader(&self) -> RecordReader {
        RecordReader::open(&self.record).unwrap()
    }

    /// Returns all events with their instants.
    fn events(&self) -> Vec<(f64, EventKind)> {
        let mut events = Vec::new();
        for step in self.reader().steps_of_all(Time::END).unwrap() {
            events.extend(step.unwrap().batch.events.into_iter().map(|event| (event.at.seconds(), event.kind)));
        }
        events
    }

    /// Returns time, latitude, longitude and altitude of each reported location.
    fn track(&self) -> Vec<(f64, f64, f64, f64)> {
        let location = |(at_s, kind): (f64, EventKind)| match kind {
            EventKind::Measurement(variable, Value::List(items)) if variable.attribute.is("location") => {
                let number = |index: usize| items[index].as_number().unwrap().0;
                Some((at_s, number(0), number(1), number(2)))
            }
            _ => None,
        };
        self.events().into_iter().filter_map(location).collect()
    }

    /// Returns the messages that begin with `head`, as text.
    fn said(&self, head: &str) -> Vec<(f64, String)> {
        let message = |(at_s, kind): (f64, EventKind)| match kind {
            EventKind::Occurrence(form) => {
                form.head().is_some_and(|word| word.is(head)).then(|| (at_s, form.to_string()))
            }
            _ => None,
        };
        self.events().into_iter().filter_map(message).collect()
    }

    /// Replay poses the problems, derives the readings and repeats the decisions.
    fn assert_replays(&self) {
        let report = recorded::replay(&self.reader()).unwrap();
        assert_eq!(report.difference, None, "{report}");
    }
}

/// Returns metres north and east of a place, on a sphere.
fn offset_m(from: (f64, f64), to: (f64, f64)) -> (f64, f64) {
    const DEGREE_M: f64 = 111_195.0;
    ((to.0 - from.0) * DEGREE_M, (to.1 - from.1) * DEGREE_M * from.0.to_radians().cos())
}

const BASE: &str = r#"{"type": "FeatureCollection", "features": [{"type": "Feature", "properties": {"id": "home", "kind": "base"},
    "geometry": {"type": "Point", "coordinates": [-117.0, 37.0]}}]}"#;

fn zone(kind: &str, west: f64, south: f64, east: f64, north: f64) -> String {
    format!(
        r#"{{"type": "FeatureCollection", "features": [{{"type": "Feature", "properties": {{"id": "r-1", "name": "R-1", "kind": "{kind}"}},
        "geometry": {{"type": "Polygon", "coordinates": [[[{west}, {south}], [{east}, {south}], [{east}, {north}], [{west}, {north}], [{west}, {south}]]]}}}}]}}"#
    )
}

/// Outside distance from a box of degrees, in metres; 0 inside.
fn outside_m(at: (f64, f64), west: f64, south: f64, east: f64, north: f64) -> f64 {
    let nearest = (at.0.clamp(south, north), at.1.clamp(west, east));
    let (dy, dx) = offset_m(at, nearest);
    dx.hypot(dy)
}

#[test]
fn an_aircraft_that_is_sent_into_a_zone_turns_away_before() {
    let flown = fly(
        ":vehicle (sim :model predator-b :at home) :duration 3h :targets \"base.geojson\" :airspace \"zone.geojson\"",
        "(procedure :sequential (index (fly the mission)) (step up (take off to 3000m)) (step work (work)))\n\
         (procedure (index (work)) (step guard (guard the flight)) (step go (dash to (37.6 -117.0 3000))) \
           (step end (terminate) (waitfor (:delay 30min))))",
        &[("base.geojson", BASE), ("zone.geojson", &zone("restricted", -117.5, 37.25, -116.5, 37.5))],
    );
    let alarms = flown.said("requirement-at-risk");
    assert!(alarms[0].1.starts_with("(requirement-at-risk airspace \"R-1\""), "{}", alarms[0].1);
    let least_m = |(_, lat, lon, _): &(f64, f64, f64, f64)| outside_m((*lat, *lon), -117.5, 37.25, -116.5, 37.5);
    let nearest_m = flown.track().iter().map(least_m).fold(f64::INFINITY, f64::min);
    assert!(nearest_m > 400.0, "it came within {nearest_m} m of the zone");
    assert!(nearest_m < 12_000.0, "it turned away {nearest_m} m before the zone: too early");
    flown.assert_replays();
}

#[test]
fn an_aircraft_stays_inside_of_what_is_permitted() {
    let flown = fly(
        ":vehicle (sim :model predator-b :at home) :duration 2h :targets \"base.geojson\" :airspace \"zone.geojson\"",
        "(procedure :sequential (index (fly the mission)) (step up (take off to 3000m)) (step work (work)))\n\
         (procedure (index (work)) (step guard (guard the flight)) (step go (dash to (37.0 -116.0 3000))) \
           (step end (terminate) (waitfor (:delay 20min))))",
        &[("base.geojson", BASE), ("zone.geojson", &zone("permitted", -117.5, 36.5, -116.6, 37.5))],
    );
    assert!(!flown.said("requirement-at-risk").is_empty());
    let inside =
        flown.track().iter().all(|(_, lat, lon, _)| (36.5..37.5).contains(lat) && (-117.5..-116.6).contains(lon));
    assert!(inside, "it left what is permitted");
    flown.assert_replays();
}

/// An upper face that covers everything around cannot be avoided sideways: the aircraft levels off below it and continues.
#[test]
fn an_aircraft_that_climbs_towards_the_upper_face_of_what_is_permitted_stays_below() {
    let area = zone("permitted", -119.0, 35.5, -115.0, 38.5)
        .replace("\"kind\": \"permitted\"", "\"kind\": \"permitted\", \"altitude_m_max\": 4000");
    let flown = fly(
        ":vehicle (sim :model predator-b :at home) :duration 2h :targets \"base.geojson\" :airspace \"zone.geojson\"",
        "(procedure :sequential (index (fly the mission)) (step up (take off to 3000m)) (step work (work)))\n\
         (procedure (index (work)) (step guard (guard the flight)) (step go (dash to (37.9 -117.0 3950))) \
           (step end (terminate) (waitfor (:delay 20min))))",
        &[("base.geojson", BASE), ("zone.geojson", &area)],
    );
    let alarms = flown.said("requirement-at-risk");
    assert!(
        alarms.len() == 1 && alarms[0].1.contains(" climb "),
        "a climb that ends below the face is enough: {alarms:?}"
    );
    let buffer = flown.mission.requirements.airspace.unwrap();
    let track = flown.track();
    let highest_m = track.iter().map(|(.., altitude_m)| *altitude_m).fold(0.0, f64::max);
    assert!(highest_m < 4000.0 - 0.9 * buffer.vertical_m, "{highest_m} m");
    let northmost_deg = track.iter().map(|(_, latitude_deg, ..)| *latitude_deg).fold(0.0, f64::max);
    assert!(northmost_deg > 37.8, "it continues to its place: {northmost_deg}");
    flown.assert_replays();
}

#[test]
fn a_hovering_helicopter_returns_and_lands_with_its_reserve() {
    let flown = fly(
        ":vehicle (sim :model rmax :at home) :duration 2h :targets \"base.geojson\"",
        "(procedure :sequential (index (fly the mission)) (step up (take off to 60m)) (step work (work)))\n\
         (procedure (index (work)) (step guard (guard the flight)) (step stay (hover at (37.03 -117.0 60))))",
        &[("base.geojson", BASE)],
    );
    let alarms = flown.said("requirement-at-risk");
    assert!(alarms.len() == 1 && alarms[0].1.contains("energy \"home\""), "{alarms:?}");
    assert_eq!(flown.said("crashed"), []);
    assert_eq!(flown.said("landed").len(), 1);
    let (_, lat, lon, _) = *flown.track().last().unwrap();
    let (north_m, east_m) = offset_m((37.0, -117.0), (lat, lon));
    assert!(north_m.hypot(east_m) < 20.0, "it landed {north_m} m north and {east_m} m east of home");
    let left = flown.events().into_iter().rev().find_map(|(_, kind)| match kind {
        EventKind::Measurement(variable, Value::Duration(left)) if variable.attribute.is("endurance-remaining") => {
            Some(left.seconds())
        }
        _ => None,
    });
    let reserve_s = flown.mission.requirements.energy_reserve_s.unwrap();
    assert!(left.unwrap() > 0.9 * reserve_s, "{left:?} s are left of a reserve of {reserve_s} s");
    assert_eq!(flown.end, "the aircraft landed early at home: energy");
    flown.assert_replays();
}

#[test]
fn an_aircraft_stays_within_reach_of_its_landing_place() {
    let flown = fly(
        ":vehicle (sim :model predator-b :at home) :duration 3h :targets \"base.geojson\" :landing-distance 60km",
        "(procedure :sequential (index (fly the mission)) (step up (take off to 3000m)) (step work (work)))\n\
         (procedure (index (work)) (step guard (guard the flight)) (step go (dash to (38.5 -117.0 3000))) \
           (step end (terminate) (waitfor (:delay 40min))))",
        &[("base.geojson", BASE)],
    );
    let track = flown.track();
    let farthest_m = track.iter().map(|(_, lat, lon, _)| {
        let (north_m, east_m) = offset_m((37.0, -117.0), (*lat, *lon));
        north_m.hypot(east_m)
    });
    let farthest_m = farthest_m.fold(0.0, f64::max);
    // Distances on the sphere of this test are wrong by 0.3 %.
    assert!((50e3..60.2e3).contains(&farthest_m), "{farthest_m} m");
    flown.assert_replays();
}

#[test]
fn an_aircraft_that_descends_too_low_climbs() {
    let flown = fly(
        ":vehicle (sim :model predator-b :at home) :duration 2h :targets \"base.geojson\"",
        "(procedure :sequential (index (fly the mission)) (step up (take off to 1500m)) (step work (work)))\n\
         (procedure (index (work)) (step guard (guard the flight)) (step go (dash to (37.8 -117.0 120))) \
           (step end (terminate) (waitfor (:delay 15min))))",
        &[("base.geojson", BASE)],
    );
    assert!(flown.said("requirement-at-risk")[0].1.contains("terrain"));
    let airborne_s = flown.said("airborne")[0].0;
    let track = flown.track();
    let lowest_m = track.iter().filter(|(at_s, ..)| *at_s > airborne_s + 120.0).map(|(.., altitude_m)| *altitude_m);
    let lowest_m = lowest_m.fold(f64::INFINITY, f64::min);
    let clearance_m = flown.mission.requirements.terrain_clearance_m.unwrap();
    assert!(lowest_m >= clearance_m, "{lowest_m} m above ground; clearance {clearance_m} m");
    flown.assert_replays();
}

#[test]
fn what_is_kept_is_reported_and_raises_no_alarm() {
    let flown = fly(
        ":vehicle (sim :model rmax :at home) :duration 1h :targets \"base.geojson\" :airspace \"zone.geojson\"",
        "(procedure :sequential (index (fly the mission)) (step up (take off to 60m)) (step work (work)))\n\
         (procedure (index (work)) (step guard (guard the flight)) (step go (dash to (37.01 -117.0 60))) \
           (step home (dash to (37.0 -117.0 60)) (waitfor (end ?go))) (step end (terminate) (waitfor (end ?home))))",
        &[("base.geojson", BASE), ("zone.geojson", &zone("restricted", -117.5, 37.02, -116.5, 37.5))],
    );
    assert_eq!(flown.said("requirement-at-risk"), []);
    let names = |attribute: &str| {
        let named = flown.events().into_iter().filter_map(|(_, kind)| match kind {
            EventKind::Measurement(variable, _) if variable.attribute.is(attribute) => {
                Some(variable.object.to_string())
            }
            _ => None,
        });
        named.collect::<std::collections::BTreeSet<String>>()
    };
    let expected: Vec<&str> = vec!["airspace", "energy", "terrain"];
    for attribute in ["margin", "time-to-violation", "requirement-state"] {
        assert_eq!(names(attribute).iter().map(String::as_str).collect::<Vec<_>>(), expected);
    }
    flown.assert_replays();
}

/// Returns the flight of a helicopter with a camera in the evening: at 01:30 UTC of the equinox the sun is 5 degrees above the western
/// horizon.
fn evening(target: &str) -> Flown {
    fly(
        ":vehicle (sim :model rmax :at home) :start \"2026-03-20T01:30:00Z\" :duration 1h :targets \"base.geojson\"",
        &format!(
            "(procedure :sequential (index (fly the mission)) (step up (take off to 60m)) (step work (work)))\n\
             (procedure (index (work)) (step guard (guard the flight)) (step power (power-up camera-1)) \
               (step look (orient camera-1 to {target}) (waitfor (end ?power)) (on-failure (wait 0s))) \
               (step end (terminate) (waitfor (:delay 2min))))"
        ),
        &[("base.geojson", BASE)],
    )
}

#[test]
fn a_camera_that_looks_into_the_sun_rests() {
    let flown = evening("(37.0 -117.05 60)");
    let alarms = flown.said("requirement-at-risk");
    assert!(alarms[0].1.starts_with("(requirement-at-risk sun \"camera-1\""), "{alarms:?}");
    assert!(alarms[0].1.ends_with("stow camera-1)"), "{alarms:?}");
    let states: Vec<(f64, String)> = flown
        .events()
        .into_iter()
        .filter_map(|(at_s, kind)| match kind {
            EventKind::Measurement(variable, value) if variable.attribute.is("camera-state") => {
                Some((at_s, value.to_string()))
            }
            _ => None,
        })
        .collect();
    let rested = states.iter().find(|(at_s, state)| *at_s >= alarms[0].0 && state == "ready");
    assert!(rested.is_some_and(|(at_s, _)| at_s - alarms[0].0 < 5.0), "{states:?}, {alarms:?}");
    flown.assert_replays();
}

#[test]
fn a_camera_that_looks_down_needs_no_response_to_the_sun() {
    let flown = evening("(37.001 -117.001 0)");
    assert_eq!(flown.said("requirement-at-risk"), []);
}

#[test]
fn a_requirement_that_cannot_be_met_from_the_start_is_an_error() {
    let load = |options: &str, files: &[(&str, &str)]| {
        let folder = tempfile::tempdir().unwrap();
        let text = format!(
            "(defapplication \"Unmet\" :type native-sim :libraries (\"vehicle\") :vehicle (sim :model rmax :at (37.0 -117.0)) \
             {options} :agents ((agent uav-1 :initial-task (stay))))\n(procedure (index (stay)) (step wait (terminate)))"
        );
        std::fs::write(folder.path().join("mission.pdl"), text).unwrap();
        for (name, text) in files {
            std::fs::write(folder.path().join(name), text).unwrap();
        }
        let error = Mission::load(folder.path()).unwrap_err();
        assert!(error.help.is_some() && error.place.is_some(), "{error:?}");
        format!("{} {}", error.message, error.reason.unwrap_or_default())
    };
    let airspace = ":airspace \"zone.geojson\"";
    let inside = load(airspace, &[("zone.geojson", &zone("restricted", -117.5, 36.5, -116.5, 37.5))]);
    assert!(inside.contains("`airspace`") && inside.contains("R-1"), "{inside}");
    let outside = load(airspace, &[("zone.geojson", &zone("permitted", -117.5, 37.2, -116.5, 37.5))]);
    assert!(outside.contains("outside of every permitted zone"), "{outside}");
    let reserve = load(":requirements ((energy :reserve 90min))", &[]);
    assert!(reserve.contains("`energy`") && reserve.contains("90 min"), "{reserve}");
    let late = load(":duration 2h :requirements ((mission-end :before 3h))", &[]);
    assert!(
        late.contains("`mission-end`") && late.contains("180 min before the end of a mission of 120 min"),
        "{late}"
    );
    let far = load(":landing-distance 5km", &[]);
    assert!(far.contains("no landing place"), "{far}");
    let high = load(":requirements ((terrain :clearance 9km))", &[]);
    assert!(high.contains("`terrain`") && high.contains("ceiling"), "{high}");
    let windy = "altitude_m_min,altitude_m_max,wind_from_deg,wind_speed_mps,edr\n0,20000,270,20,0.3\n";
    let wind = load(":forecast \"wind.csv\" :requirements ((wind :at-most 15m/s))", &[("wind.csv", windy)]);
    assert!(wind.contains("`wind`") && wind.contains("20.00 m/s"), "{wind}");
    let edr = load(":forecast \"wind.csv\" :requirements ((turbulence :at-most 0.2))", &[("wind.csv", windy)]);
    assert!(edr.contains("`turbulence`") && edr.contains("0.30"), "{edr}");
    for wrong in
        ["(airspaces :off)", "(energy :reserve 5m)", "(wind :at-most -3m/s)", "(terrain)", "(airspace :time)", "wind"]
    {
        let text = load(&format!(":requirements ({wrong})"), &[]);
        assert!(text.contains("in :requirements") && text.contains(wrong), "{text}");
    }
    let twice = load(":requirements ((wind :at-most 5m/s) (wind :at-most 6m/s))", &[]);
    assert!(twice.contains("stated twice"), "{twice}");
}

/// Dusk (the sun 6 degrees below the horizon) at Zaca on 7 September 2007 is at 19:43:00 PDT: 1 h 43 min after this start.
#[test]
fn a_fire_wanted_by_night_is_waited_for_until_dusk() {
    let fire = r#"{"type": "FeatureCollection", "features": [{"type": "Feature", "properties": {"id": "zaca", "kind": "fire", "acres": 2000,
        "value": 10, "light": "night"}, "geometry": {"type": "Point", "coordinates": [-119.783, 34.716]}},
        {"type": "Feature", "properties": {"id": "home", "kind": "base"}, "geometry": {"type": "Point", "coordinates": [-118.0, 34.9]}}]}"#;
    let flown = fly(
        ":vehicle (sim :model predator-b :at home) :start \"2007-09-08T01:00:00Z\" :duration 4h :targets \"fires.geojson\"",
        "(solver auto (index (map the fires)) :budget 20ms)\n\
         (procedure :sequential (index (fly the mission)) (step up (take off to 5000m)) (step survey (map the fires)))",
        &[("fires.geojson", fire)],
    );
    let begins = |(at_s, kind): (f64, EventKind)| match kind {
        EventKind::Measurement(variable, Value::Symbol(word)) if variable.attribute.is("scanner-state") => {
            word.is("on").then_some(at_s)
        }
        _ => None,
    };
    let observing_s = flown.events().into_iter().find_map(begins);
    let dusk_s = 3600.0 + 43.0 * 60.0;
    assert!(observing_s.is_some_and(|at_s| (dusk_s..dusk_s + 1_800.0).contains(&at_s)), "{observing_s:?}");
    flown.assert_replays();
}
