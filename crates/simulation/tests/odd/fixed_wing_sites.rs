//! A fixed wing that watches sites from circles around them.

use crate::harness::{collection, feature, fly, home, point};
use apex_mission::report::MissionValue;

const PROGRAM: &str = r#"(defapplication "sites" :type native-sim
  :libraries ("vehicle" "aerial-observation" "contingencies" "replanning")
  :vehicle (sim :model predator-b :at home) :start "2026-06-01T20:00:00Z" :duration 2h :end-margin 20min :targets "t.geojson"
  :agents ((agent uav-1 :initial-task (watch))))
(solver auto (index (patrol the structures)) :budget 300ms)
(procedure (index (watch))
  (step up (take off to 2500m))
  (step patrol (patrol the structures) (waitfor (end ?up)) (restart-when (new plan)))
  (step plans (keep planning (patrol the structures)))
  (step guard (guard the flight))
  (step clock (wait 1h))
  (step home (return to home at 2500m) (waitfor (end ?clock)) (priority 10))
  (step finish (terminate) (waitfor (end ?home))))
"#;

/// From the height of its vehicle file, the camera saw the site 77 degrees from the vertical, and pictures need 75: no visit
/// observed anything, although the plan had halved the expected cost.
#[test]
fn visits_of_a_fixed_wing_are_steep_enough_for_pictures() {
    let site = |id: &str, at: String| {
        let kind = r#""kind": "structure", "importance": 100, "rate_per_h": 0.3, "dwell_s": 30"#;
        feature(&format!(r#""id": "{id}", {kind}"#), &at)
    };
    let targets = collection(&[home(), site("north", point(-121.0, 37.75)), site("east", point(-120.7, 37.5))]);
    let flown = fly(PROGRAM, &[("t.geojson", &targets)]);
    let MissionValue::Ignorance(_, sites) = &flown.outcome.report.value else { panic!("{}", flown.text()) };
    assert!(sites.len() == 2 && sites.iter().all(|site| site.seen > 0 && site.seen == site.visits), "{}", flown.text());
}
