//! Several looks of one target, with intervals between them.

use crate::harness::{collection, feature, fly, home, loaded, point, program};
use apex_mission::report::MissionValue;

/// The second look is wanted one to two hours after the first one, and must be made. It was planned six minutes after it, for its full
/// value, and cost 30 instead.
#[test]
fn a_look_is_planned_at_its_interval_to_the_look_before() {
    let a = r#""id": "a", "kind": "fire", "acres": 4000, "looks": [
        {"id": "first", "value": 20, "resolution_m": 15},
        {"id": "second", "value": 15, "resolution_m": 15, "interval_h": [1, 2], "must": true, "must_cost": 30}]"#;
    let b = r#""id": "b", "kind": "fire", "acres": 4000, "looks": [
        {"id": "one", "value": 10, "resolution_m": 15}, {"id": "two", "value": 10, "resolution_m": 15, "interval_h": [0.5, 3]}]"#;
    let targets = collection(&[home(), feature(a, &point(-120.5, 37.8)), feature(b, &point(-120.0, 38.0))]);
    let options = ":vehicle (sim :model predator-b :at home) :start \"2026-05-12T18:30:00Z\" :duration 6h :end-margin 20min \
                   :targets \"t.geojson\" :scenario \"s.jsonl\"";
    // The second plan is made when some looks are over.
    let again = "{\"t\": 2400, \"event\": \"(violated wind-as-forecast)\"}\n";
    let flown = fly(&program(options, "4000m"), &[("t.geojson", &targets), ("s.jsonl", again)]);
    let at = |name: &str| {
        let visit = flown.outcome.report.visits.iter().find(|visit| visit.target == name);
        visit.unwrap_or_else(|| panic!("{name} was not observed:\n{}", flown.text())).begin.seconds() / 3_600.0
    };
    let (apart_a, apart_b) = (at("a/second") - at("a/first"), at("b/two") - at("b/one"));
    assert!((1.0..2.0).contains(&apart_a), "{apart_a} h\n{}", flown.text());
    assert!((0.5..3.0).contains(&apart_b), "{apart_b} h\n{}", flown.text());
    assert!(!flown.text().contains("missed"), "{}", flown.text());
}

/// The night look is wanted two to four hours after the day look, which was planned first, eight hours before the night: the night look was
/// left out, and the plan was proven to be the best.
#[test]
fn a_look_that_the_earliest_look_excludes_is_planned_first() {
    let a = r#""id": "a", "kind": "fire", "acres": 8000, "looks": [
        {"id": "day", "value": 40, "resolution_m": 10, "light": "day"},
        {"id": "night", "value": 60, "resolution_m": 10, "light": "night", "interval_h": [2, 4]}]"#;
    let targets = collection(&[home(), feature(a, &point(-120.5, 37.8))]);
    let options = ":vehicle (sim :model predator-b :at home) :start \"2026-06-01T22:00:00Z\" :duration 12h :targets \"t.geojson\"";
    let flown = fly(&program(options, "6000m"), &[("t.geojson", &targets)]);
    let begin =
        |name: &str| flown.outcome.report.visits.iter().find(|visit| visit.target == name).map(|visit| visit.begin);
    let (day, night) = (begin("a/day"), begin("a/night"));
    assert!(day.is_some() && night.is_some(), "{}", flown.text());
}

const OPTIONS: &str = ":vehicle (sim :model predator-b :at home) :start \"2026-05-12T18:30:00Z\" :duration 6h :end-margin 20min \
                       :targets \"t.geojson\"";

/// The first look can no longer be made: the interval to it does not count, and the second one is flown.
#[test]
fn a_look_is_flown_where_the_look_before_cannot_be_made() {
    let a = r#""id": "a", "kind": "fire", "acres": 4000, "looks": [
        {"id": "first", "value": 20, "resolution_m": 15, "windows_h": [[0, 0.05]]},
        {"id": "second", "value": 15, "resolution_m": 15, "interval_h": [1, 2]}]"#;
    let targets = collection(&[home(), feature(a, &point(-120.5, 37.8))]);
    let flown = fly(&program(OPTIONS, "4000m"), &[("t.geojson", &targets)]);
    let visits = &flown.outcome.report.visits;
    assert!(visits.iter().any(|visit| visit.target == "a/second"), "{}", flown.text());
}

/// A look that is not worth its time is left out for that reason, and not for a lack of time.
#[test]
fn a_look_that_is_not_worth_its_time_reports_it() {
    let a = r#""id": "a", "kind": "fire", "acres": 4000, "looks": [
        {"id": "first", "value": 20, "resolution_m": 15},
        {"id": "second", "value": 0.0001, "resolution_m": 15, "interval_h": [1, 2]}]"#;
    let targets = collection(&[home(), feature(a, &point(-120.5, 37.8))]);
    let options = format!("{OPTIONS} :failure (:probability-per-hour 0.01 :vehicle-cost 500)");
    let flown = fly(&program(&options, "4000m"), &[("t.geojson", &targets)]);
    let left_out = &flown.outcome.report.left_out;
    let (_, reason) = left_out.iter().find(|(target, _)| target == "a/second").unwrap();
    assert!(reason.contains("score") && !reason.contains("no time is left"), "{reason}\n{}", flown.text());
}

/// Two fires coincide, so that the visit of one sees both. A plan that is made after it does not visit the other one for nothing.
#[test]
fn a_fire_that_was_seen_in_passing_is_not_planned_again() {
    let fire = |id: &str, at: String| {
        feature(
            &format!(r#""id": "{id}", "kind": "fire", "acres": 200, "value": 20, "resolution_m": 20, "share": 0.9965"#),
            &at,
        )
    };
    let both = || point(-120.5, 37.8);
    let targets = collection(&[home(), fire("a", both()), fire("b", both()), fire("far", point(-119.5, 38.0))]);
    let flown = fly(&program(OPTIONS, "4000m"), &[("t.geojson", &targets)]);
    let pair = ["a", "b"].map(|id| flown.observed_s(id).is_some());
    assert!(pair[0] != pair[1] && flown.observed_s("far").is_some(), "{}", flown.text());
    let passed = if pair[0] { "b" } else { "a" };
    assert!(flown.left_out(passed).contains("in passing"), "{}", flown.text());
    let MissionValue::Score(score) = &flown.outcome.report.value else { panic!("the mission has no score") };
    assert!(score.benefits > 59.9, "{}", flown.text());
}

/// The sun that water mirrors moves, so that a look later in the mission has another worth than the one that is planned for the earliest
/// arrival. A plan was proven to be the best, and a later window of a target gave a better one.
#[test]
fn a_bound_over_water_in_the_sun_is_that_of_the_earliest_arrivals() {
    let changes = |more: &str, options: &str| {
        let fire = format!(r#""id": "a", "kind": "fire", "acres": 4000, "value": 20{more}"#);
        let targets = collection(&[home(), feature(&fire, &point(-120.5, 37.8))]);
        loaded(&program(options, "4000m"), &[("t.geojson", &targets)]).1.air_changes()
    };
    assert!(!changes("", OPTIONS));
    assert!(changes(r#", "water": true"#, OPTIONS));
    let without_sun = OPTIONS.replace(":start \"2026-05-12T18:30:00Z\" ", "");
    assert!(!changes(r#", "water": true"#, &without_sun));
}
