//! Planning again in flight: each kind of update alone, several times by the clock, and adopted plans.

#![allow(clippy::unwrap_used, reason = "a test stops at an unexpected result")]

mod common;

use common::Desk;

#[test]
fn every_cause_is_one_and_every_new_plan_is_said() {
    let desk = Desk::with_mission("plain-watch");
    desk.change("m/mission.pdl", ":libraries (", ":libraries (\"replanning\" ");
    let step = "(step again (keep planning (patrol the structures) every 7min))";
    desk.change("m/mission.pdl", "  (step touch", &format!("  {step}\n  (step touch"));
    let forecast = ":forecast (\"winds.csv\" \"winds-actual.csv\") :scenario \"scenario.jsonl\"";
    desk.change("m/mission.pdl", ":forecast \"winds.csv\"", forecast);
    desk.change("m/mission.pdl", ":duration 1h", ":duration 25min");
    desk.change("m/mission.pdl", "for 55min", "for 18min");
    desk.change("m/mission.pdl", ":budget 500ms", ":budget 20ms");
    let scenario = [
        r#"{"t": 200, "event": "(new-forecast \"winds-actual.csv\")"}"#,
        r#"{"t": 600, "event": "(off-schedule barn)"}"#,
    ];
    desk.write("m/scenario.jsonl", &scenario.join("\n"));
    let report = desk.apex(&["fly", "m", "--record", "flown.apex", "--no-progress"]).well().out;
    let wanted = |why: &str| report.matches(&format!("replanning wanted: {why}")).count();
    assert_eq!([wanted("\"winds-actual.csv"), wanted("barn"), wanted("clock")], [1, 1, 3], "{report}");
    assert!(!report.contains("0:03:20  replanning wanted"), "not before an observation has ended: {report}");
    let said = desk.apex(&["trace", "flown.apex", "--object", "new", "--json"]).well().out;
    let new = said.lines().filter(|line| line.contains("\"form\":\"(new plan)\"")).count();
    assert_eq!((new, report.matches("new plan: ").count()), (5, 6), "{said}");
}
