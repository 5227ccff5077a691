//! Reports of flights that do not end as planned.

use crate::harness::{area, collection, feature, fly, fly_with, home, point, program};
use apex_model::problem::{Plan, Problem};
use apex_planning::solver::{Environment, Solver};
use std::sync::Arc;

fn fire(id: &str, longitude: f64, latitude: f64, more: &str) -> String {
    let properties = format!(r#""id": "{id}", "kind": "fire", "acres": 4000, "value": 20{more}"#);
    feature(&properties, &point(longitude, latitude))
}

const OPTIONS: &str = ":vehicle (sim :model predator-b :at home) :start \"2026-05-12T18:30:00Z\" :duration 4h :end-margin 10min \
                       :targets \"t.geojson\"";

/// The way home fails, and the program has no answer to that. The report says that the vehicle is in the air, and why.
#[test]
fn a_flight_that_ends_in_the_air_states_it_in_its_report() {
    let targets = collection(&[home(), fire("near", -120.5, 37.4, "")]);
    let program = program(OPTIONS, "4000m").replace("(return to home at 4000m)", "(fail after 6s)");
    let program = format!("{program}(primitive (index (fail after ?span)) (duration (- 1s ?span)))\n");
    let flown = fly(&program, &[("t.geojson", &targets)]);
    let text = flown.text();
    assert!(!flown.outcome.end.reason.is_success(), "{text}");
    assert!(text.contains("the vehicle has not landed: it is in the air at"), "{text}");
    let end = flown.outcome.report.json()["end"].clone();
    assert!(end["not_landed"].is_string() && end["failed_because"].is_string(), "{end}");
}

/// No fire can be planned, for two reasons: pixels of a centimetre are impossible, and a fire is out of reach. The aircraft has taken off
/// before that is known: it flies home and lands, and the report has the reason.
#[test]
fn an_aircraft_without_a_plan_flies_home() {
    let sharp = fire("sharp", -120.5, 37.4, r#", "resolution_m": 0.01"#);
    for (targets, why) in [
        (vec![sharp.clone()], "no way to observe it"),
        (vec![fire("far", -95.0, 37.4, "")], "the end of the mission"),
        (vec![sharp, fire("far", -95.0, 37.4, "")], "the end of the mission"),
    ] {
        let targets = collection(&std::iter::once(home()).chain(targets).collect::<Vec<_>>());
        let flown = fly(&program(OPTIONS, "4000m"), &[("t.geojson", &targets)]);
        let text = flown.text();
        assert!(flown.outcome.end.reason.is_success() && text.contains(why), "{text}");
        assert!(flown.said("landed").len() == 1 && !text.contains("has not landed"), "{text}");
    }
}

/// A planner that no mission ships with, and that has no plan.
struct Helpless;

impl Solver for Helpless {
    fn name(&self) -> &str {
        "helpless"
    }

    fn serves(&self, _: &Problem) -> bool {
        true
    }

    fn solve(&self, _: &Problem, _: &mut Environment<'_>) -> Result<Plan, String> {
        Err("it has no idea".to_string())
    }
}

/// The program brings a planner that fails. What the program does about that comes first; a failure that nothing handles leads home.
#[test]
fn an_aircraft_whose_own_planner_fails_flies_home() {
    let targets = collection(&[home(), fire("near", -120.5, 37.4, "")]);
    let named = program(OPTIONS, "4000m").replace("(solver auto ", "(solver helpless ");
    let fly = |program: &str| {
        let mut planners = apex_solvers::shipped();
        planners.add(Arc::new(Helpless)).unwrap();
        fly_with(planners, program, &[("t.geojson", &targets)])
    };
    let flown = fly(&named);
    let text = flown.text();
    assert!(flown.outcome.end.reason.is_success() && text.contains("it has no idea"), "{text}");
    assert!(flown.said("landed").len() == 1 && !text.contains("has not landed"), "{text}");
    // Handled by the step itself, and by the step of the procedure around it: the aircraft climbs first.
    let climb = "(on-failure (fly to home at 5000m))";
    let own = named.replace("(step survey (see them) ", &format!("(step survey (see them) {climb} "));
    let around = named.replace("(step survey (see them) ", &format!("(step survey (work) {climb} "));
    let around = format!(
        "{around}(procedure (index (work)) (step see (see them)) (step finish (terminate) (waitfor (end ?see))))\n"
    );
    for program in [own, around] {
        let flown = fly(&program);
        let text = flown.text();
        assert!(flown.outcome.end.reason.is_success() && flown.said("landed").len() == 1, "{text}");
        let highest_m = flown.track().into_iter().map(|(.., altitude_m)| altitude_m).fold(0.0, f64::max);
        assert!(highest_m > 4_500.0, "{highest_m}\n{text}");
    }
}

/// A target is announced on the way home: the plan for it arrives after the survey has ended, and the report says that nothing flew it.
#[test]
fn a_plan_that_no_task_flies_is_named() {
    let targets = collection(&[
        home(),
        fire("near", -120.5, 37.4, ""),
        fire("late", -120.3, 37.7, r#", "announced": "by-event""#),
    ]);
    let program = program(&format!("{OPTIONS} :scenario \"s.jsonl\""), "4000m");
    let first = fly(&program, &[("t.geojson", &targets), ("s.jsonl", "")]);
    let seen_s = first.observed_s("near").unwrap();
    let news = format!(
        "{{\"t\": {}, \"event\": \"(new-target late)\"}}\n{{\"t\": {}, \"event\": \"(off-schedule late)\"}}\n",
        seen_s + 60.0,
        seen_s + 70.0
    );
    let flown = fly(&program, &[("t.geojson", &targets), ("s.jsonl", &news)]);
    let text = flown.text();
    assert!(flown.outcome.end.reason.is_success(), "{text}");
    assert!(flown.left_out("late").contains("but no task pursued (see them), which ended at"), "{text}");
    assert!(text.contains("this plan was not flown: no task pursued (see them)"), "{text}");
}

/// After a quarter of an hour a wind of 60 m/s blows down to the ground: the final approach, at 59 m/s, never ends, until its time limit.
/// The report names all.
#[test]
fn a_landing_that_the_wind_prevents_is_named() {
    let header = "altitude_m_min,altitude_m_max,wind_from_deg,wind_speed_mps,edr,from_h,until_h";
    let actual = format!("{header}\n0,20000,270,15,0.01,0,0.3\n0,20000,270,60,0.01,0.3,9\n");
    let forecast = format!("{header}\n0,20000,270,15,0.01,0,9\n");
    let targets = collection(&[home(), fire("near", -120.5, 37.4, "")]);
    let program = program(&format!("{OPTIONS} :forecast \"w.csv\" :weather \"a.csv\""), "4000m");
    let flown = fly(&program, &[("t.geojson", &targets), ("w.csv", &forecast), ("a.csv", &actual)]);
    let text = flown.text();
    assert!(
        text.contains("the vehicle has not landed") && text.contains("(land home) was not answered within"),
        "{text}"
    );
    assert!(text.contains("the wind there is 60 m/s, and the final approach is flown at 59 m/s"), "{text}");
}

/// A zone closes the base during the mission and until its end, from the ground up to below cruise altitude. Plans land before; where no
/// visit is possible in that time, no plan is made, and the reason names the zone.
#[test]
fn plans_land_before_the_base_closes() {
    let targets = collection(&[home(), fire("near", -120.7, 37.4, ""), fire("far", -119.5, 37.4, "")]);
    let fly_until = |closes_h: f64| {
        let properties =
            format!(r#""id": "closed", "kind": "restricted", "altitude_m_max": 3000, "active_h": [[{closes_h}, 9]]"#);
        let zones = collection(&[feature(&properties, &area((-121.2, 37.25, -120.8, 37.55)))]);
        let program = program(&format!("{OPTIONS} :airspace \"z.geojson\""), "4000m");
        fly(&program, &[("t.geojson", &targets), ("z.geojson", &zones)])
    };
    let flown = fly_until(1.25);
    let text = flown.text();
    assert!(flown.outcome.end.reason.is_success(), "{text}");
    assert!(flown.observed_s("near").is_some() && flown.observed_s("far").is_none(), "{text}");
    let landed_s = flown.said("landed").last().unwrap_or_else(|| panic!("{text}")).0;
    assert!(landed_s < 4_500.0, "{landed_s}\n{text}");
    assert!(flown.left_out("far").contains("zone closed closes the base at 1:15:00 until the mission ends"), "{text}");
    // Too little time for any visit: the aircraft is home before, and the report states the reason.
    let flown = fly_until(0.4);
    let text = flown.text();
    assert!(flown.outcome.report.visits.is_empty(), "{text}");
    let why = "zone closed closes the base at 0:24:00 until the mission ends";
    assert!(flown.outcome.report.notes.iter().any(|note| note.text.contains(why)), "{text}");
    let landed_s = flown.said("landed").last().unwrap_or_else(|| panic!("{text}")).0;
    assert!(landed_s < 1_440.0, "{landed_s}\n{text}");
}

/// In May the sun of Lapland is never low enough for a look by night.
#[test]
fn a_night_that_does_not_come_is_the_reason() {
    let base = feature(r#""id": "home", "kind": "base", "elevation_m": 100"#, &point(25.0, 68.5));
    let targets = collection(&[base, fire("dark", 26.0, 68.7, r#", "light": "night""#), fire("any", 24.5, 68.6, "")]);
    let flown = fly(&program(OPTIONS, "4000m"), &[("t.geojson", &targets)]);
    assert_eq!(flown.left_out("dark"), "it is not night there before the flight must end", "{}", flown.text());
    assert!(flown.observed_s("any").is_some(), "{}", flown.text());
}
