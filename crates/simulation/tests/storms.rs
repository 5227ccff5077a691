//! Storms on the way, over a target and over home: flights with `(guard against storms)` keep away from the cells, fly what is open, and
//! land where no storm is. The recorded flight is compared, not the plan.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a failed test should stop")]
#![allow(clippy::disallowed_methods, reason = "this check computes distances apart from the product")]

#[path = "contingencies/flown.rs"]
mod flown;

use flown::Flight;

/// To a place 100 km north, and back.
const FAR_NORTH: &str =
    "(step up (take off to 4000m)) (step out (fly to (37.9 -117.0 4000))) (step home (return to home at 4000m))";

#[test]
fn a_storm_on_the_way_is_flown_around() {
    // It begins when the aircraft is on the way to it.
    let world = r#""storms": [{"latitude_deg": 37.55, "longitude_deg": -117.02, "radius_m": 8000, "from_h": 0.17}]"#;
    let nearest_m = |guards: &'static str| {
        let flown = Flight { guards, work: FAR_NORTH, world, ..Flight::default() }.fly();
        let distances = flown.numbers("(storm-distance uav-1)");
        let least_m = distances.iter().map(|(_, metres)| *metres).fold(f64::INFINITY, f64::min);
        assert_eq!(flown.count("(landed uav-1)"), 1, "{}", flown.story());
        (least_m, flown)
    };
    let (without_m, _) = nearest_m("");
    assert!(without_m < 0.0, "{without_m}");
    let (with_m, flown) = nearest_m("(step guard (guard against storms))");
    assert!(with_m > 4_000.0, "{with_m} m\n{}", flown.story());
    // Once on the outbound leg and once on the return.
    assert!((1..=4).contains(&flown.count("(storm-passed uav-1)")), "{}", flown.story());
    flown.assert_replays();
}

/// A storm that stands over home from 0:18 on.
const OVER_HOME: &str =
    r#""storms": [{"latitude_deg": 37.0, "longitude_deg": -117.05, "radius_m": 20000, "from_h": 0.3}]"#;

fn least_distance_m(flown: &flown::Flown) -> f64 {
    flown.numbers("(storm-distance uav-1)").iter().map(|(_, metres)| *metres).fold(f64::INFINITY, f64::min)
}

/// The aircraft waited for home until the mission ended, next to the cell.
#[test]
fn a_storm_that_stays_over_home_leads_to_another_landing_place() {
    let guards = "(step guard (guard against storms)) (step safe (guard the flight))";
    let flown = Flight { guards, work: FAR_NORTH, world: OVER_HOME, ..Flight::default() }.fly();
    assert_eq!(flown.count("(landing-because storm field)"), 1, "{}", flown.story());
    assert_eq!(flown.count("(landed uav-1)"), 1, "{}", flown.story());
    assert!(flown.last_distance_m(37.54, -117.0) < 3_000.0, "{}", flown.story());
    assert!(least_distance_m(&flown) > 0.0 && flown.count("(storm-passed") <= 1, "{}", flown.story());
    flown.assert_replays();
}

#[test]
fn the_end_of_the_mission_counts_a_storm_over_home() {
    // The contingency without its limit on the time of waiting.
    let guards = "(step begin (inform (avoiding-storms uav-1))) (step safe (guard the flight)) \
                  (step avoid (get past the storm) (waitfor (:episode (storm-time uav-1) :value (< 300) \
                    :timing (:duration (> 10s)) :quality (:max-gap 15s))) (repeating :missed-messages drop) (priority 53))";
    let options = ":requirements ((mission-end :before 5min))";
    let flown = Flight { guards, work: FAR_NORTH, options, world: OVER_HOME, ..Flight::default() }.fly();
    let elsewhere_s = flown.first_s("(responding mission-end land-elsewhere");
    assert!(elsewhere_s > 5.0 * 3_600.0, "it waits for home as long as another place is in reach: {elsewhere_s}");
    assert_eq!(flown.count("(landed uav-1)"), 1, "{}", flown.story());
    assert!(flown.last_distance_m(37.54, -117.0) < 3_000.0, "{}", flown.story());
    assert!(least_distance_m(&flown) > 0.0, "{}", flown.story());
    flown.assert_replays();
}

/// Three fires; the second one is under a storm that drifts over it and leaves within the mission.
#[test]
fn a_target_under_a_storm_loses_its_turn() {
    let fires = "id,name,kind,latitude_deg,longitude_deg,elevation_m,acres,value,resolution_m\n\
                 f1,f1,fire,37.6,-117.0,0,800,60,10\nf2,f2,fire,37.9,-117.0,0,800,60,10\nf3,f3,fire,37.2,-116.4,0,800,60,10\n";
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("fires.csv", fires);
    write("fields.csv", "id,name,kind,latitude_deg,longitude_deg,elevation_m\nhome,Home,base,37.0,-117.0,0\n");
    write(
        "world.json",
        r#"{"format": "apex-world-1", "storms": [{"latitude_deg": 37.9, "longitude_deg": -117.4, "radius_m": 20000, "east_mps": 6}]}"#,
    );
    write(
        "mission.pdl",
        r#"(defapplication "Storms" :type native-sim
  :libraries ("vehicle" "aerial-observation" "contingencies" "replanning")
  :vehicle (sim :model predator-b :at home) :start "2026-08-01T16:00:00Z" :duration 8h
  :targets "fires.csv" :airfields "fields.csv" :world "world.json"
  :agents ((agent uav-1 :initial-task (fly the mission))))
(solver auto (index (map the fires)) :budget 1s)
(procedure (index (fly the mission))
  (step up (take off to 6000m))
  (step survey (map the fires) (waitfor (end ?up)) (restart-when (new plan)))
  (step again (keep planning (map the fires)))
  (step storms (guard against storms))
  (step home (return to home at 6000m) (waitfor (end ?survey)))
  (step finish (terminate) (waitfor (end ?home))))
"#,
    );
    let path = folder.path().to_path_buf();
    let flown = flown::fly_mission(&path, folder);
    let observed_s = ["f1", "f2", "f3"].map(|name| flown.first_s(&format!("(observed {name})")));
    assert!(observed_s[1] > observed_s[0] && observed_s[1] > observed_s[2], "{observed_s:?}\n{}", flown.story());
    assert!(observed_s[2] < 5_400.0, "{observed_s:?}");
    assert!(least_distance_m(&flown) > 4_000.0 && flown.count("(storm-passed") <= 1, "{}", flown.story());
    assert_eq!(flown.count("(landed uav-1)"), 1, "{}", flown.story());
    flown.assert_replays();
}
