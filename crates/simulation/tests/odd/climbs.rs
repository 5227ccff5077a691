//! Climbs between visits, whose fuel counts in plans.

use crate::harness::{collection, feature, fly, home, point, program};

/// Eight fires that are seen from low and high altitudes in turns, with little fuel and a vehicle whose climbs take much of it. All eight
/// were planned for 101 kg of level flight, "proven to be the best"; the flight saw two, and landed early for energy.
#[test]
fn climbs_between_visits_leave_the_reserve() {
    let vehicle = include_str!("../../../../library/vehicles/predator-b.json");
    let changes = [
        ("\"capacity_kg\": {\"value\": 1769.0", "\"capacity_kg\": {\"value\": 200.0"),
        ("\"cruise_min\": {\"value\": 1680.0", "\"cruise_min\": {\"value\": 187.5"),
        ("\"duration_min\": {\"value\": 45.0", "\"duration_min\": {\"value\": 20.0"),
        ("\"climb_penalty\": 0.6", "\"climb_penalty\": 8.0"),
        ("\"climb_share\": {\"value\": 0.5", "\"climb_share\": {\"value\": 1.0"),
    ];
    let mut changed = vehicle.to_owned();
    for (old, new) in changes {
        assert_eq!(changed.matches(old).count(), 1, "{old}");
        changed = changed.replace(old, new);
    }
    let places = [
        (-121.27, 37.43, 14),
        (-121.13, 37.48, 3),
        (-120.88, 37.05, 14),
        (-121.49, 37.66, 3),
        (-121.24, 37.18, 14),
        (-120.51, 37.38, 3),
        (-120.72, 37.70, 14),
        (-121.07, 37.24, 3),
    ];
    let fire = |(number, (longitude, latitude, resolution_m)): (usize, &(f64, f64, i32))| {
        let data = format!(
            "\"id\": \"f{number}\", \"kind\": \"fire\", \"acres\": 1200, \"value\": 20, \"resolution_m\": {resolution_m}"
        );
        feature(&data, &point(*longitude, *latitude))
    };
    let mut features = vec![home()];
    features.extend(places.iter().enumerate().map(fire));
    let options =
        ":vehicle (sim :model \"v.json\" :at home) :start \"2026-08-01T18:30:00Z\" :duration 6h :targets \"t.geojson\"";
    let flown = fly(&program(options, "6000m"), &[("t.geojson", &collection(&features)), ("v.json", &changed)]);
    let fuel_kg = flown.numbers("fuel");
    // 20 minutes of 64 kg/h.
    let reserve_kg = 64.0 / 3.0;
    assert!(
        fuel_kg.last().is_some_and(|left_kg| *left_kg >= reserve_kg),
        "{:?} kg left\n{}",
        fuel_kg.last(),
        flown.text()
    );
    assert!(!flown.text().contains("landed early"), "{}", flown.text());
    assert!(flown.outcome.report.visits.len() >= 3, "{}", flown.text());
}
