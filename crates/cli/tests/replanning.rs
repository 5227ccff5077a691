//! Planning again in flight: after updates, by the clock, and by operators (library `replanning`, docs/guides/replanning.md).

#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, reason = "a test stops at an unexpected result")]

mod common;

use common::Desk;

/// Returns the mission that watches structures, shortened, with the library and one additional step.
fn watched(step: &str) -> Desk {
    let desk = Desk::with_mission("plain-watch");
    desk.change("m/mission.pdl", ":libraries (", ":libraries (\"replanning\" ");
    desk.change("m/mission.pdl", "  (step touch", &format!("  {step}\n  (step touch"));
    let patrol = "(step patrol (patrol the structures) (waitfor (end ?up))";
    desk.change("m/mission.pdl", patrol, &format!("{patrol} (restart-when (new plan))"));
    let forecast = ":forecast (\"winds.csv\" \"winds-actual.csv\") :scenario \"scenario.jsonl\"";
    desk.change("m/mission.pdl", ":forecast \"winds.csv\"", forecast);
    desk.change("m/mission.pdl", ":duration 1h", ":duration 25min");
    desk.change("m/mission.pdl", "for 55min", "for 16min");
    desk.change("m/mission.pdl", ":budget 500ms", ":budget 20ms");
    desk
}

fn flown(desk: &Desk, more: &[&str]) -> String {
    let arguments = ["fly", "m", "--record", "flown.apex", "--no-progress"];
    let report = desk.apex(&[arguments.as_slice(), more].concat()).well().out;
    desk.apex(&["replay", "flown.apex"]).well();
    report
}

/// Returns the line of the report that names `what`, and the following lines.
fn after<'r>(report: &'r str, what: &str) -> &'r str {
    report.split_once(what).map_or_else(|| panic!("no {what:?} in {report}"), |(_, after)| after)
}

#[test]
fn updates_and_the_clock_have_the_mission_planned_again() {
    let desk = watched("(step again (keep planning (patrol the structures) every 7min))");
    let scenario = [
        r#"{"t": 100, "event": "(new-likelihood barn 50)"}"#,
        r#"{"t": 101, "event": "(target-gone winery)"}"#,
        r#"{"t": 102, "event": "(target-gone castle)"}"#,
        r#"{"t": 103, "event": "(new-value barn much)"}"#,
        r#"{"t": 500, "event": "(new-forecast \"winds-actual.csv\")"}"#,
        r#"{"t": 501, "event": "(new-forecast \"winds-of-mars.csv\")"}"#,
    ];
    desk.write("m/scenario.jsonl", &scenario.join("\n"));
    let report = flown(&desk, &[]);
    for told in [
        "barn: 50 events per hour counted for the whole mission",
        "no longer a target: winery",
        "castle is not a target of this mission",
        "(new-value barn ..) has no number from 0 to 1000000000, and is ignored",
        "winds-of-mars.csv is not one of the mission's forecasts, winds.csv, winds-actual.csv",
    ] {
        assert_eq!(report.matches(told).count(), 1, "{told}: {report}");
    }
    let again = after(&report, "replanning wanted: barn");
    assert!(after(again, "new plan: ").contains("of 15 targets"), "the winery still counts: {report}");
    assert!(report.contains("replanning wanted: clock"), "{report}");
    assert!(after(&report, "Not observed").contains("winery          no longer a target"), "{report}");
    let plans = desk.apex(&["trace", "flown.apex", "--type", "plan"]).well().out;
    assert!(plans.lines().count() >= 4, "{plans}");
}

const PEOPLE: &str = "cell,budget_units,best,verdict,next,effect_percent\n\
                      large-uniform-uniform-16-uniform,1000,human,better,two-opt,4.2\n";

#[test]
fn where_operators_plan_better_they_are_asked_and_their_plan_is_flown() {
    let desk = watched("(step people (let people plan (patrol the structures) within 5min))"); // english: allow
    desk.write("people.csv", PEOPLE);
    desk.write("m/scenario.jsonl", r#"{"t": 100, "answer": 0, "value": ["repeat", "barn", "school"]}"#);
    let report = flown(&desk, &["--table", "people.csv"]);
    assert!(report.contains("planned by an operator: barn, school, again and again"), "{report}");
    let plans = desk.apex(&["trace", "flown.apex", "--type", "plan"]).well().out;
    assert_eq!(plans.lines().count(), 2, "{plans}");
    assert!(plans.contains("because two-opt answered") && plans.contains("because human answered"), "{plans}");
    let asked = desk.apex(&["trace", "flown.apex", "--type", "ask"]).well().out;
    assert!(asked.lines().count() == 1 && asked.contains("Operators plan such missions better"), "{asked}");
    let told = desk.apex(&["plan", "m", "--table", "people.csv"]).well().out;
    assert!(told.contains("two-opt plans until an operator does"), "{told}");
    let json = desk.apex(&["plan", "m", "--table", "people.csv", "--json"]).well().json_lines();
    assert_eq!(json[0]["people_plan_better"], true);
}

#[test]
fn without_an_answer_or_with_one_that_cannot_be_flown_the_planners_plan_stays() {
    let desk = watched("(step people (let people plan (patrol the structures) within 2min))"); // english: allow
    desk.write("people.csv", PEOPLE);
    desk.write("m/scenario.jsonl", "");
    let report = flown(&desk, &["--table", "people.csv"]);
    assert!(!report.contains("planned by an operator"), "{report}"); // english: allow
    assert_eq!(report.matches("new plan: ").count(), 1, "{report}");
    desk.write("m/scenario.jsonl", r#"{"t": 60, "answer": 0, "value": ["barn", "castle"]}"#);
    let report = flown(&desk, &["--table", "people.csv"]);
    let refused = "no plan: there is no target `castle`";
    assert!(report.contains(refused) && report.matches("new plan: ").count() == 1, "{report}");
    let said = desk.apex(&["trace", "flown.apex", "--object", "no-better-plan"]).well().out;
    assert!(said.contains("(no-better-plan people)"), "{said}"); // english: allow
}
