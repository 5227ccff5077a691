//! Fires that are reported larger after they were seen: the growth is planned for what it is worth, and the score counts what burns.

use crate::harness::{Flown, area, collection, feature, fly, home, program};
use apex_mission::report::MissionValue;

/// As planned, and as it burns later: a third of it lies in the east.
const BRUSH: (f64, f64, f64, f64) = (-121.05, 37.75, -120.95, 37.83);
const GROWN: (f64, f64, f64, f64) = (-121.05, 37.75, -120.90, 37.83);
/// Fires that are observed afterwards: updates are planned for between two of them.
const MOSS: (f64, f64, f64, f64) = (-121.05, 38.1, -120.99, 38.14);
const FERN: (f64, f64, f64, f64) = (-120.6, 38.1, -120.56, 38.14);

fn report_at(at_s: u32, (west, south, east, north): (f64, f64, f64, f64)) -> String {
    let outline = format!("(({south} {west}) ({south} {east}) ({north} {east}) ({north} {west}))");
    format!("{{\"t\": {at_s}, \"event\": \"(new-perimeter brush {outline})\"}}\n")
}

/// Flies to three fires of 45 to 85 km distance; the first is reported larger at `reported_s`.
fn survey(reported_s: u32, duration: &str) -> Flown {
    survey_with(reported_s, duration, GROWN)
}

fn survey_with(reported_s: u32, duration: &str, grown: (f64, f64, f64, f64)) -> Flown {
    let fire = |id: &str, value: u32, ground| {
        let properties = format!(r#""id": "{id}", "kind": "fire", "value": {value}, "resolution_m": 5"#);
        feature(&properties, &area(ground))
    };
    let targets = collection(&[home(), fire("brush", 100, BRUSH), fire("moss", 60, MOSS), fire("fern", 40, FERN)]);
    let options = format!(
        ":vehicle (sim :model predator-b :at home) :start \"2026-05-12T18:30:00Z\" :duration {duration} \
         :end-margin 5min :targets \"t.geojson\" :scenario \"s.jsonl\""
    );
    fly(&program(&options, "4000m"), &[("t.geojson", &targets), ("s.jsonl", &report_at(reported_s, grown))])
}

/// Value, coverage and points of a look as scored; `None` if the score has no such row.
fn scored(flown: &Flown, id: &str) -> Option<(f64, f64, f64)> {
    let MissionValue::Score(score) = &flown.outcome.report.value else { panic!("{}", flown.text()) };
    let look = score.looks.iter().find(|look| look.id == id)?;
    Some((look.flown.value, look.flown.factors.coverage, look.flown.points))
}

fn visit(flown: &Flown, id: &str) -> Option<(f64, f64)> {
    let visit = flown.outcome.report.visits.iter().find(|visit| visit.target == id)?;
    Some((visit.begin.seconds(), visit.end?.seconds()))
}

/// The report comes during the visit, whose lines are for the old outline, or on the way to the next fire: in either case the aircraft
/// flies over the new ground alone, and both are scored by the area at their instant.
#[test]
fn the_growth_of_a_fire_is_seen_by_a_second_visit() {
    let (begin_s, end_s) = visit(&survey(50_000, "4h"), "brush").unwrap();
    for reported_s in [0.5 * (begin_s + end_s), end_s + 60.0] {
        let flown = survey(reported_s as u32, "4h");
        let before = visit(&flown, "brush").unwrap();
        let after = visit(&flown, "brush/growth-1").unwrap_or_else(|| panic!("{}", flown.text()));
        assert!(after.1 - after.0 < 0.7 * (before.1 - before.0), "{}", flown.text());
        let lines: Vec<f64> =
            flown.scanned().iter().filter(|at| at.0 > after.0 && at.0 < after.1).map(|at| at.2).collect();
        let new_ground = lines.iter().filter(|east| **east > -120.96).count();
        assert!(lines.len() > 30 && new_ground as f64 > 0.95 * lines.len() as f64, "old ground again: {lines:?}");
        let (value, coverage, points) = scored(&flown, "brush/growth-1").unwrap();
        assert!((value - 100.0 / 3.0).abs() < 0.5 && coverage > 0.97 && points > 30.0, "{value} {coverage} {points}");
        let (value, coverage, _) = scored(&flown, "brush").unwrap();
        assert!(value == 100.0 && coverage > 0.97, "the first look keeps its points: {coverage}");
        assert!(flown.observed_s("moss").is_some(), "{}", flown.text());
    }
}

/// A quarter of an hour before the landing there is no time for the growth: the report lists it, and the first look keeps its points.
#[test]
fn growth_for_which_no_time_is_left_is_named() {
    let landed_s = survey(50_000, "4h").said("landed").last().unwrap().0;
    let flown = survey(landed_s as u32 - 900, "150min");
    assert_eq!(visit(&flown, "brush/growth-1"), None, "{}", flown.text());
    assert!(scored(&flown, "brush").is_some_and(|(_, coverage, _)| coverage > 0.97), "{}", flown.text());
    assert_eq!(flown.left_out("brush/growth-1"), "no plan included it", "{}", flown.text());
}

/// The other fire has a window hours later: the aircraft sees the growth in the time that it would wait.
#[test]
fn growth_that_is_reported_during_a_wait_is_planned_at_once() {
    let brush = r#""id": "brush", "kind": "fire", "value": 100, "resolution_m": 5"#;
    let moss = r#""id": "moss", "kind": "fire", "value": 60, "resolution_m": 5, "windows_h": [[3, 3.6]]"#;
    let targets = collection(&[home(), feature(brush, &area(BRUSH)), feature(moss, &area(MOSS))]);
    let options = ":vehicle (sim :model predator-b :at home) :start \"2026-05-12T18:30:00Z\" :duration 6h :end-margin 5min \
                   :targets \"t.geojson\" :scenario \"s.jsonl\"";
    let flown = fly(&program(options, "4000m"), &[("t.geojson", &targets), ("s.jsonl", &report_at(5_400, GROWN))]);
    let (_, seen_s) = visit(&flown, "brush").unwrap();
    assert!(seen_s < 5_400.0, "the aircraft waits when the growth is reported: {seen_s} s");
    let (_, grown_s) = visit(&flown, "brush/growth-1").unwrap_or_else(|| panic!("{}", flown.text()));
    assert!(grown_s < 2.5 * 3_600.0, "seen at {grown_s} s\n{}", flown.text());
    assert!(flown.observed_s("moss").is_some(), "{}", flown.text());
}

/// Growth by less than a hundredth is within the accuracy of outlines.
#[test]
fn a_little_growth_is_not_a_target() {
    let (_, end_s) = visit(&survey(50_000, "4h"), "brush").unwrap();
    let (west, south, east, north) = BRUSH;
    let flown = survey_with(end_s as u32 + 60, "4h", (west, south, east + 0.0005, north));
    assert!(!flown.text().contains("brush/growth"), "{}", flown.text());
}
