//! Missions whose structures have user-defined costs: points of a table, or a function of the program.

#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "a test stops at an unexpected result")]

mod common;

use common::{Desk, Said};
use serde_json::Value;

const FAMILY: &str = "\"importance\": 120, \"rate_per_h\": 0.06, \"cost\": \"saturating\", \"cost_growth_per_h\": 2.0";
/// The costs of the shipped barn, written as a function.
const HAY: &str = "\n(defun hay-cost (age) (* 60 (- 1 (exp (- (/ age 30min))))))\n";

fn costs(desk: &Desk) -> Vec<(String, Value)> {
    let said = desk.apex(&["plan", "m", "--problem"]).well();
    let problem: Value = serde_json::from_str(&said.out).unwrap();
    let targets = problem["Surveillance"]["targets"].as_array().unwrap().iter();
    targets.map(|target| (target["name"].as_str().unwrap().to_string(), target["cost"].clone())).collect()
}

fn cost_of(desk: &Desk, name: &str) -> Value {
    costs(desk).into_iter().find(|(target, _)| target == name).unwrap().1
}

fn with_points(points: &str) -> Desk {
    let desk = Desk::with_mission("plain-watch");
    let table = format!("\"rate_per_h\": 0.06, \"cost\": \"table\"{points}");
    desk.change("m/sites.geojson", FAMILY, &table);
    desk
}

fn with_program(costs: &str, functions: &str) -> Desk {
    let desk = Desk::with_mission("plain-watch");
    desk.change("m/mission.pdl", ":duration 1h", &format!(":duration 1h\n  :costs {costs}"));
    desk.write("m/mission.pdl", &(desk.read("m/mission.pdl") + functions));
    desk
}

#[test]
fn a_table_is_the_cost_that_is_planned_with() {
    let desk = with_points(", \"cost_points\": [[0, 0], [600, 10], [600, 80], [3600, 100]]");
    let cost = cost_of(&desk, "farmhouse");
    assert_eq!(cost["Delayed"]["response_s"], 500.0);
    let points = serde_json::json!([[0.0, 0.0], [600.0, 10.0], [600.0, 80.0], [3600.0, 100.0]]);
    assert_eq!(cost["Delayed"]["cost"]["Table"]["points"], points);
    desk.apex(&["plan", "m", "--budget", "20ms"]).well();
    let level = cost_of(&with_points(", \"cost_points\": [[0, 5], [600, 5]]"), "farmhouse");
    assert_eq!(level["Delayed"]["cost"]["Table"]["points"], serde_json::json!([[0.0, 5.0], [600.0, 5.0]]));
}

#[test]
fn a_likelihood_that_changes_is_planned_with() {
    let desk = Desk::with_mission("plain-watch");
    desk.change("m/sites.geojson", "\"rate_per_h\": 0.06", "\"rates_per_h\": [[0, 0.36], [0.5, 3.6]]");
    let said = desk.apex(&["plan", "m", "--problem"]).well();
    let problem: Value = serde_json::from_str(&said.out).unwrap();
    let steps = problem["Surveillance"]["targets"][0]["rate"]["steps"].as_array().unwrap().clone();
    let numbers: Vec<f64> = steps.iter().flat_map(|step| [0, 1].map(|at| step[at].as_f64().unwrap())).collect();
    assert!(numbers.iter().zip([0.0, 1e-4, 1800.0, 1e-3]).all(|(a, b)| (a - b).abs() < 1e-12), "{numbers:?}");
    desk.apex(&["plan", "m", "--budget", "20ms"]).well();
}

#[test]
fn tables_that_are_invalid_are_reported() {
    let told = |points: &str, phrases: &[&str]| -> Said {
        let name = ["sites.geojson: feature 2 `farmhouse`: "];
        let phrases: Vec<&str> = name.iter().chain(phrases).copied().collect();
        with_points(points).apex(&["plan", "m"]).complained(2, &phrases)
    };
    told("", &["`cost` is table and `cost_points` has 0 points", "help: write ages in seconds with their costs"]);
    told(", \"cost_points\": []", &["`cost_points` has 0 points"]);
    told(", \"cost_points\": [[0, 1, 2]]", &["not a list of pairs of numbers"]);
    told(", \"cost_points\": [[0, -1]]", &["has [0, -1]; ages and costs are between"]);
    told(", \"cost_points\": [[0, 5], [60, 4]]", &["has [60, 4] after [0, 5]", "cost never falls with age"]);
    told(", \"cost_points\": [[60, 4], [30, 5]]", &["has [30, 5] after [60, 4]", "ages rise"]);
    told(", \"cost_points\": [[-5, 0]]", &["has [-5, 0]; ages and costs are between"]);
    for idle in ["importance", "cost_growth_per_h", "cost_delay_s"] {
        let phrases = [format!("`{idle}` has no meaning where `cost` is table"), format!("help: leave `{idle}` out")];
        told(&format!(", \"cost_points\": [[0, 1]], \"{idle}\": 3"), &phrases.each_ref().map(String::as_str));
    }
    let many: Vec<String> = (0..1_001).map(|age| format!("[{age}, 1]")).collect();
    told(&format!(", \"cost_points\": [{}]", many.join(",")), &["`cost_points` has 1001 points; expected 1 to 1000"]);
    let desk = Desk::with_mission("plain-watch");
    desk.change("m/sites.geojson", "\"cost\": \"saturating\"", "\"cost\": \"linear\", \"cost_points\": [[0, 1]]");
    desk.apex(&["plan", "m"]).complained(2, &["`cost_points` have no meaning where `cost` is linear"]);
}

#[test]
fn a_function_of_the_program_is_a_cost() {
    let desk = with_program("((barn hay-cost))", HAY);
    let cost = cost_of(&desk, "barn");
    assert_eq!(cost["Delayed"]["response_s"], 520.0);
    let points = cost["Delayed"]["cost"]["Table"]["points"].as_array().unwrap();
    assert!((10..200).contains(&points.len()), "{points:?}");
    let number = |point: &Value, index: usize| point[index].as_f64().unwrap();
    for pair in points.windows(2) {
        let age_s = 0.5 * (number(&pair[0], 0) + number(&pair[1], 0));
        let line = 0.5 * (number(&pair[0], 1) + number(&pair[1], 1));
        let exact = 60.0 * (1.0 - (-age_s / 1_800.0).exp());
        assert!((line - exact).abs() <= 1e-3 * exact.max(0.06), "{line} {exact} at {age_s} s");
    }
    // The greatest age: an hour of flight, plus ten minutes before it, plus the 520 s until the firefighters arrive.
    assert_eq!(number(points.last().unwrap(), 0), 3_600.0 + 600.0 + 520.0);
    assert!(cost_of(&desk, "farmhouse")["Delayed"]["cost"]["Saturating"].is_object(), "others keep their families");
    let checked = desk.apex(&["check", "m"]).well();
    assert!(!checked.err.contains("never called") && !checked.out.contains("never called"), "{checked:?}");
}

#[test]
fn a_mission_with_a_function_as_cost_flies_and_is_replayed() {
    let desk = with_program("((barn hay-cost) (sawmill hay-cost))", HAY);
    desk.apex(&["fly", "m", "--record", "r.apex", "--no-progress", "--until", "2min"]).well();
    desk.apex(&["replay", "r.apex"]).well();
}

#[test]
fn functions_that_are_not_costs_are_reported() {
    let told = |costs: &str, functions: &str, phrases: &[&str]| {
        with_program(costs, functions).apex(&["plan", "m"]).complained(2, phrases);
    };
    let place = "m/mission.pdl:8:3: `:costs` names ";
    told("((shed hay-cost))", HAY, &[place, "`shed`, which is not a structure", "structures are: farmhouse, barn"]);
    told("((home hay-cost))", HAY, &[place, "`home`, which is not a structure"]);
    told("((barn straw-cost))", "", &[place, "`straw-cost`, which is not a function", "help: write for example"]);
    told("((barn hay-cost) (barn hay-cost))", HAY, &[place, "`barn` twice"]);
    told("(barn hay-cost)", HAY, &["`:costs (barn hay-cost)` cannot be read", "structures with functions"]);
    let hay = |body: &str| format!("\n(defun hay-cost (age) {body})\n");
    let barn = "((barn hay-cost))";
    told(
        barn,
        &hay("age"),
        &["`hay-cost` cannot be the cost of `barn`", "gives P1H18M40S, which is not a number; divide"],
    );
    told(barn, &hay("(- 5 (/ age 1h))"), &["`hay-cost` cannot be the cost of `barn`", "falls from 5 at 0 s"]);
    told(barn, &hay("(- (/ age 1h) 1)"), &["cannot be the cost of `barn`", "is -1; a cost is finite and not negative"]);
    told(barn, &hay("(/ 1 (- age age))"), &["cannot be the cost of `barn`", "cannot be computed: m/mission.pdl:"]);
    told(barn, "\n(defun hay-cost (age extra) 1)\n", &["cannot be the cost of `barn`", "m/mission.pdl:"]);
}
