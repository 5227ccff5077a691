//! Planning again in flight: the plan from which planners start.

mod common;

use common::Desk;

/// Plans again after ten minutes, and flies the new plan.
const AGAIN: &str = r#"  (step patrol (patrol the structures) (waitfor (end ?up)) (restart-when (new plan)))
  (step while (wait 10min) (waitfor (end ?up)))
  (step replan (plan (patrol the structures)) (waitfor (end ?while)))
  (step use (inform (new plan)) (waitfor (end ?replan)))
"#;

/// Returns a copy of the mission that plans again while it flies.
fn watch_again() -> Desk {
    let desk = Desk::with_mission("plain-watch");
    desk.change("m/mission.pdl", "  (step patrol (patrol the structures) (waitfor (end ?up)))\n", AGAIN);
    desk
}

/// Returns the summaries of the plans that were taken.
fn summaries(desk: &Desk) -> Vec<String> {
    let lines = desk.apex(&["trace", "r.apex", "--type", "plan", "--json"]).well().json_lines();
    lines.iter().filter_map(|line| line["summary"].as_str()).map(str::to_string).collect()
}

#[test]
fn a_printed_plan_that_is_flown_is_where_the_first_replan_begins() {
    let desk = watch_again();
    desk.apex(&["plan", "m", "--visits", "barn,winery,farmhouse", "--repeat", "--out", "m/plan.pdl"]).well();
    desk.change("m/mission.pdl", "  :targets", "  :files (\"plan.pdl\")\n  :targets");
    desk.change("m/mission.pdl", ":budget 500ms", ":budget 20ms");
    let fly = || desk.apex(&["fly", "m", "--until", "25min", "--record", "r.apex", "--no-progress"]).well();
    fly();
    let plans = summaries(&desk);
    assert!(plans.len() == 1 && plans[0].contains("Begun from the stored plan that is flown."), "{plans:?}");
    desk.apex(&["replay", "r.apex"]).well().told(&["The record is confirmed: "]);
    fly();
    assert_eq!(summaries(&desk), plans, "the same flight again");
}

#[test]
fn a_plan_that_was_made_is_where_the_next_one_begins() {
    let desk = watch_again();
    desk.change("m/mission.pdl", ":budget 500ms", ":budget 20ms");
    desk.apex(&["fly", "m", "--until", "25min", "--record", "r.apex", "--no-progress"]).well();
    let plans = summaries(&desk);
    assert_eq!(plans.len(), 2, "{plans:?}");
    assert!(!plans[0].contains("Begun from") && plans[1].contains("Begun from the plan that is flown."), "{plans:?}");
}
