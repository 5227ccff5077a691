//! The descent from a high cruise costs time and energy.

use crate::harness::{Flown, collection, feature, fly, home, point, program};
use apex_model::event::EventKind;

/// Fuel in kg at each report, with its instant.
fn fuel(flown: &Flown) -> Vec<(f64, f64)> {
    let fuel = |(at_s, kind): (f64, EventKind)| match kind {
        EventKind::Measurement(variable, value) if variable.attribute.is("fuel") => Some((at_s, value.as_number()?.0)),
        _ => None,
    };
    flown.events().into_iter().filter_map(fuel).collect()
}

/// A Global Hawk whose tank allows four hours among more fires than it can see. Its descent from 18.3 km takes an hour, longer than its
/// reserve of 45 minutes lasts: plans and the energy requirement must count the descent, so that the reserve is left after the landing.
#[test]
fn a_high_aircraft_lands_with_its_reserve() {
    let shipped = include_str!("../../../../library/vehicles/global-hawk.json");
    let capacity =
        shipped.split("\"capacity_kg\": {\"value\": ").nth(1).and_then(|rest| rest.split(',').next()).unwrap();
    let small_kg = capacity.parse::<f64>().unwrap() * 4.5 / 33.0;
    let model = shipped
        .replace(
            &format!("\"capacity_kg\": {{\"value\": {capacity},"),
            &format!("\"capacity_kg\": {{\"value\": {small_kg},"),
        )
        .replace("\"cruise_min\": {\"value\": 1980.0,", "\"cruise_min\": {\"value\": 270.0,");
    let fires = (0..16).map(|number| {
        let properties = format!(r#""id": "fire-{number}", "kind": "fire", "acres": 3000, "value": 20"#);
        feature(&properties, &point(-120.0 + 0.9 * f64::from(number % 4), 36.0 + 0.8 * f64::from(number / 4)))
    });
    let targets = collection(&std::iter::once(home()).chain(fires).collect::<Vec<_>>());
    let options = ":vehicle (sim :model \"small.json\" :at home) :start \"2026-05-12T18:30:00Z\" :duration 24h \
                   :targets \"t.geojson\"";
    let flown = fly(&program(options, "18300m"), &[("t.geojson", &targets), ("small.json", &model)]);
    let text = flown.text();
    assert!(flown.outcome.end.reason.is_success(), "{text}");
    let landed_s = flown.said("landed").last().unwrap_or_else(|| panic!("{text}")).0;
    let fuel = fuel(&flown);
    let at = |instant_s: f64| fuel.iter().take_while(|(at_s, _)| *at_s <= instant_s).last().unwrap().1;
    let left_kg = at(landed_s);
    let reserve_kg = 0.75 / 4.5 * small_kg;
    assert!(left_kg >= 0.97 * reserve_kg, "{left_kg} of {reserve_kg} kg are left\n{text}");
    assert!(left_kg < 2.5 * reserve_kg, "the fuel is not the limit of this plan: {left_kg} kg are left\n{text}");
    let high_s = flown.track().iter().rfind(|at| at.3 > 18_200.0).unwrap().0;
    assert!(landed_s - high_s > 1_800.0, "{high_s} to {landed_s}");
}
