//! Wind that is stronger than forecast, and stronger than the vehicle.

use crate::harness::{Flown, collection, feature, fly, home, point, program};

/// The quadrotor flies 17 m/s at most and the wind rises to 18: no way leads home, so it lands where it is, before its battery is empty.
#[test]
fn a_rotorcraft_that_cannot_get_home_against_the_wind_lands_in_time() {
    let mast = r#""id": "mast", "kind": "inspection", "elevation_m": 100, "value": 20, "resolution_m": 0.05"#;
    let tank = r#""id": "tank", "kind": "inspection", "elevation_m": 100, "value": 20, "resolution_m": 0.05"#;
    let targets = collection(&[home(), feature(mast, &point(-120.98, 37.415)), feature(tank, &point(-120.96, 37.41))]);
    let options = ":vehicle (sim :model quadrotor :at home) :start \"2026-05-12T18:30:00Z\" :duration 1h :end-margin 5min \
                   :targets \"t.geojson\" :forecast \"w.csv\" :weather \"a.csv\"";
    let header = "altitude_m_min,altitude_m_max,wind_from_deg,wind_speed_mps,edr,from_h,until_h";
    let flown = fly(
        &program(options, "180m"),
        &[
            ("t.geojson", &targets),
            ("w.csv", &format!("{header}\n0,5000,250,5,0.05,0,2\n")),
            ("a.csv", &format!("{header}\n0,5000,250,5,0.05,0,0.06\n0,5000,250,18,0.05,0.06,2\n")),
        ],
    );
    assert_eq!(flown.said("crashed"), [], "{}", flown.text());
    let landed = flown.said("landed");
    assert!(landed.first().is_some_and(|(at_s, _)| *at_s < 900.0), "{landed:?}\n{}", flown.text());
    let noted = flown.outcome.report.notes.iter().filter(|note| note.text.starts_with("energy at risk")).count();
    assert!((1..=3).contains(&noted), "one note for each response:\n{}", flown.text());
}

/// Flies to fires 90 to 370 km downwind. The wind of 15 m/s rises to 40 after 42 minutes, and the forecast does not know it.
fn downwind(fires: &[(&str, f64)]) -> Flown {
    let fire = |(id, longitude): &(&str, f64)| {
        let properties = format!(r#""id": "{id}", "kind": "fire", "acres": 4000, "value": 20"#);
        feature(&properties, &point(*longitude, 37.4))
    };
    let targets = collection(&std::iter::once(home()).chain(fires.iter().map(fire)).collect::<Vec<_>>());
    let flown = fly_downwind(&targets, ("3h", "10min", 40, 0.7), &[]);
    let text = flown.text();
    let landed_s = flown.said("landed").last().unwrap_or_else(|| panic!("{text}")).0;
    assert!((8_000.0..10_800.0).contains(&landed_s), "{landed_s}\n{text}");
    flown
}

/// Flies in a wind that rises to `strong_mps` above 1,000 m from `from_h` on; near the ground it stays as forecast, because nothing lands
/// in more.
fn fly_downwind(
    targets: &str,
    (duration, end_margin, strong_mps, from_h): (&str, &str, u32, f64),
    files: &[(&str, &str)],
) -> Flown {
    let airfields = if files.is_empty() { "" } else { ":airfields \"f.geojson\"" };
    let options = format!(
        ":vehicle (sim :model predator-b :at home) :start \"2026-05-12T18:30:00Z\" :duration {duration} :end-margin {end_margin} \
         :requirements ((mission-end :before 8min)) :targets \"t.geojson\" :forecast \"w.csv\" :weather \"a.csv\" {airfields}"
    );
    let header = "altitude_m_min,altitude_m_max,wind_from_deg,wind_speed_mps,edr,from_h,until_h";
    let forecast = format!("{header}\n0,20000,270,15,0.01,0,9\n");
    let actual = format!(
        "{header}\n0,20000,270,15,0.01,0,{from_h}\n0,1000,270,15,0.01,{from_h},9\n\
         1000,5000,270,{strong_mps},0.01,{from_h},9\n5000,20000,270,{strong_mps},0.01,{from_h},9\n"
    );
    let data = [("t.geojson", targets), ("w.csv", forecast.as_str()), ("a.csv", actual.as_str())];
    let flown = fly(&program(&options, "4000m"), &data.iter().chain(files).copied().collect::<Vec<_>>());
    assert!(flown.outcome.end.reason.is_success(), "{}", flown.text());
    flown
}

/// By the forecast there is time for the third fire; by the measured wind the aircraft would not be back before the end of the mission.
#[test]
fn a_plan_in_flight_leaves_out_what_the_measured_wind_does_not_allow() {
    let flown = downwind(&[("near", -120.0), ("far", -118.5), ("farther", -117.7)]);
    assert!(flown.observed_s("far").is_some() && flown.observed_s("farther").is_none(), "{}", flown.text());
    assert_eq!(flown.said("requirement-at-risk"), [], "the plan is in time:\n{}", flown.text());
}

/// No plan is made on the way to the only fire: the requirement turns the aircraft home.
#[test]
fn an_aircraft_turns_for_home_in_time_by_the_wind_that_it_measures() {
    let flown = downwind(&[("farther", -116.8)]);
    let alarms = flown.said("requirement-at-risk");
    let first = alarms.first().map_or("", |(_, alarm)| alarm);
    assert!(first.starts_with("(requirement-at-risk mission-end \"home\""), "{alarms:?}\n{}", flown.text());
    assert_eq!(flown.observed_s("farther"), None, "{}", flown.text());
}

/// With less than a third of the margin for delays left, the rest is planned again by the measured wind. No time is left for the second
/// fire, and the mission ends as its program says, where the response to the requirement would have ended it.
#[test]
fn a_small_margin_leads_to_a_new_plan_before_it_leads_home() {
    let fire = |id: &str, longitude: f64| {
        let properties = format!(r#""id": "{id}", "kind": "fire", "acres": 4000, "value": 20"#);
        feature(&properties, &point(longitude, 37.4))
    };
    let targets = collection(&[home(), fire("near", -120.8), fire("farther", -116.9)]);
    let flown = fly_downwind(&targets, ("240min", "60min", 55, 0.7), &[]);
    let noted = flown.outcome.report.notes.iter().find(|note| note.text == "replanning wanted: mission-end");
    let asked_s = noted.unwrap_or_else(|| panic!("{}", flown.text())).at.seconds();
    assert!((3_000.0..4_000.0).contains(&asked_s), "{asked_s}\n{}", flown.text());
    assert_eq!(flown.said("requirement-at-risk"), [], "{}", flown.text());
    assert!(flown.observed_s("near").is_some() && flown.observed_s("farther").is_none(), "{}", flown.text());
    assert!(flown.text().contains("because the initial task is done"), "{}", flown.text());
    assert!(flown.said("landed").last().is_some_and(|(at_s, _)| *at_s < 232.0 * 60.0), "{}", flown.text());
}

/// The wind rises when the aircraft is far downwind: the base cannot be reached before the mission ends, and a field behind it can. The
/// aircraft is on its way home when the field is the last one in reach; it flew on to the base before, because a landing in progress was
/// not outranked. The landing in this wind takes 19 minutes, ten more than the rate of descent tells: it ended 86 s after the instant that
/// is required.
#[test]
fn an_aircraft_that_cannot_be_home_in_time_lands_at_another_field() {
    let fire = r#""id": "farther", "kind": "fire", "acres": 4000, "value": 20"#;
    let targets = collection(&[home(), feature(fire, &point(-116.9, 37.4))]);
    let field = collection(&[feature(r#""id": "field""#, &point(-118.0, 37.3))]);
    let flown = fly_downwind(&targets, ("220min", "40min", 55, 1.0), &[("f.geojson", &field)]);
    let alarms = flown.said("requirement-at-risk");
    let is_elsewhere = |alarm: &str| {
        alarm.starts_with("(requirement-at-risk mission-end \"field\"") && alarm.contains("land-elsewhere")
    };
    assert!(alarms.iter().any(|(_, alarm)| is_elsewhere(alarm)), "{alarms:?}\n{}", flown.text());
    let landed_s = flown.said("landed").last().unwrap_or_else(|| panic!("{}", flown.text())).0;
    assert!(landed_s < 212.0 * 60.0, "{landed_s}\n{}", flown.text());
    let (_, latitude, longitude, _) = *flown.track().last().unwrap();
    assert!(
        (latitude - 37.3).abs() < 0.05 && (longitude + 118.0).abs() < 0.05,
        "{latitude} {longitude}\n{}",
        flown.text()
    );
}

/// The forecast of 40 m/s from the west leaves no time for the second fire; in the 15 m/s that are measured there is time for it,
/// and it is planned.
#[test]
fn a_wind_that_is_weaker_than_forecast_permits_what_the_forecast_does_not() {
    let fire = |id: &str, longitude: f64| {
        let properties = format!(r#""id": "{id}", "kind": "fire", "acres": 4000, "value": 20"#);
        feature(&properties, &point(longitude, 37.4))
    };
    let targets = collection(&[home(), fire("far", -119.3), fire("farther", -117.6)]);
    let options = ":vehicle (sim :model predator-b :at home) :start \"2026-05-12T18:30:00Z\" :duration 200min :end-margin 60min \
                   :scenario \"s.jsonl\" :targets \"t.geojson\" :forecast \"w.csv\" :weather \"a.csv\"";
    let wind = |speed_mps: u32| {
        let header = "altitude_m_min,altitude_m_max,wind_from_deg,wind_speed_mps,edr,from_h,until_h";
        format!(
            "{header}\n0,1000,270,15,0.01,0,9\n1000,5000,270,{speed_mps},0.01,0,9\n5000,20000,270,{speed_mps},0.01,0,9\n"
        )
    };
    let flown = fly(
        &program(options, "4000m"),
        &[
            ("t.geojson", &targets),
            ("w.csv", &wind(40)),
            ("a.csv", &wind(15)),
            ("s.jsonl", "{\"t\": 1200, \"event\": \"(violated wind-as-forecast)\"}\n"),
        ],
    );
    let plans = flown.outcome.report.notes.iter().filter(|note| note.text.starts_with("new plan: 1 of")).count();
    assert_eq!(plans, 2, "first by the forecast, then by the wind:\n{}", flown.text());
    assert!(flown.left_out("farther").starts_with("planned for"), "{}", flown.text());
}
