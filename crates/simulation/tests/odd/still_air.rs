//! Small fires in still air: nothing but the plan decides what is seen.

use crate::harness::{collection, feature, fly, point, program};
use apex_mission::report::MissionValue;

/// One line sees each fire. Aircraft fly nose up, so that the scanner looks ahead, and it is on a second after the beginning of the line:
/// lines that begin at the edge of a fire would leave 3 % of the ground unseen.
#[test]
fn what_is_flown_is_what_was_predicted() {
    for (model, cruise, elevations) in [("predator-b", "6000m", [300, 1_500]), ("global-hawk", "16000m", [300, 1_500])]
    {
        let fire = |id: &str, elevation_m: i32, at: String| {
            let properties = format!(
                r#""id": "{id}", "kind": "fire", "elevation_m": {elevation_m}, "acres": 4000, "value": 100, "resolution_m": 25"#
            );
            feature(&properties, &at)
        };
        let base = feature(r#""id": "home", "kind": "base", "elevation_m": 700"#, &point(-117.9, 34.9));
        let targets = collection(&[
            base,
            fire("low", elevations[0], point(-119.2, 35.25)),
            fire("high", elevations[1], point(-118.6, 35.6)),
        ]);
        let options = format!(
            ":vehicle (sim :model {model} :at home) :start \"2026-08-01T18:00:00Z\" :duration 6h :targets \"t.geojson\""
        );
        let flown = fly(&program(&options, cruise), &[("t.geojson", &targets)]);
        let MissionValue::Score(score) = &flown.outcome.report.value else { panic!("{}", flown.text()) };
        assert_eq!(score.looks.len(), 2, "{}", flown.text());
        for look in &score.looks {
            let predicted = look.predicted.as_ref().unwrap().worth;
            let off = (look.flown.points - predicted).abs() / predicted;
            assert!(predicted > 50.0 && off <= 0.01, "{model} {}: {:.1} %\n{}", look.id, 100.0 * off, flown.text());
        }
    }
}
