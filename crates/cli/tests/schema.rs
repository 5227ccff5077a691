//! The JSON of problems and plans against their schemas: output is valid, and the reader is as strict as the schemas.

#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "a test stops at an unexpected result")]

mod common;

use apex_planning::random::Generator;
use common::{Desk, mission};
use jsonschema::Validator;
use serde_json::{Value, json};

const TOPTW: &str = "1 1 3 1\n0 200\n0 10 10 0 0 0 0 0 100\n1 13 13 5 20 1 2 1 2 30 40\n2 10 11 5 7 1 1 1 0 90\n3 90 90 1 50 1 1 1 0 99\n";
const TSP: &str = "NAME: four\nTYPE: TSP\nDIMENSION: 4\nEDGE_WEIGHT_TYPE: EUC_2D\nNODE_COORD_SECTION\n1 0 0\n2 10 10\n3 0 10\n4 10 0\nEOF\n";
const FLOWN: &str = include_str!("plan_output/two.json");

fn schema(name: &str) -> Validator {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/reference/schema").join(name);
    let schema: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    jsonschema::meta::validate(&schema).unwrap();
    jsonschema::draft202012::new(&schema).unwrap()
}

#[track_caller]
fn obeys(schema: &Validator, text: &str) -> Value {
    let value: Value = serde_json::from_str(text).unwrap();
    let wrong: Vec<String> =
        schema.iter_errors(&value).map(|error| format!("{}: {error}", error.instance_path())).collect();
    assert_eq!(wrong, Vec::<String>::new(), "{text}");
    value
}

#[test]
fn every_printed_problem_and_plan_obeys_its_schema() {
    let (problems, plans) = (schema("planning-problem.schema.json"), schema("plan.schema.json"));
    let desk = Desk::new();
    desk.write("windows.txt", TOPTW);
    desk.write("four.tsp", TSP);
    desk.write("flown.json", FLOWN);
    let (fires, structures) = (mission("western-states"), mission("structure-watch"));
    let questions: [&[&str]; 9] = [
        &[&fires],
        &[&structures],
        &[&structures, "--solver", "nearest-neighbour"],
        &[&structures, "--solver", "two-opt"],
        &[&structures, "--solver", "wam"],
        &["large-clustered-uniform-6-globular@2"],
        &["windows.txt"],
        &["four.tsp"],
        &["flown.json"],
    ];
    for question in questions {
        let plan = |more: &[&str]| desk.apex(&[&["plan"], question, more].concat()).well().out;
        if question.len() == 1 {
            obeys(&problems, &plan(&["--problem"]));
        }
        obeys(&plans, &plan(&["--json", "--budget", "2ms"]));
    }
}

#[test]
fn every_shipped_vehicle_file_obeys_the_schema() {
    let vehicles = schema("vehicle.schema.json");
    for shipped in apex_vehicle::SHIPPED {
        let file = obeys(&vehicles, shipped.text);
        for (section, member) in [("flight", "wheel_base_m"), ("planning", "mood"), ("reserve", "colour")] {
            let mut wrong = file.clone();
            wrong[section][member] = json!(1.0);
            assert!(!vehicles.is_valid(&wrong), "{section}.{member}");
        }
        let mut wrong = file;
        wrong["flight"].as_object_mut().unwrap().remove("ceiling_m");
        assert!(!vehicles.is_valid(&wrong));
    }
}

#[test]
fn every_shipped_sensor_file_obeys_the_schema() {
    let sensors = schema("sensor.schema.json");
    for shipped in apex_vehicle::SHIPPED_SENSORS {
        let file = obeys(&sensors, shipped.text);
        for (section, member) in [("motion", "wheel_base_m"), ("data", "mood")] {
            let mut wrong = file.clone();
            wrong[section][member] = json!(1.0);
            assert!(!sensors.is_valid(&wrong), "{section}.{member}");
        }
        let mut wrong = file;
        wrong["kind"] = json!(if wrong["kind"] == "frame" { "video" } else { "frame" });
        assert!(!sensors.is_valid(&wrong));
    }
}

/// Returns problems that together contain every kind of member.
fn examples() -> Vec<Value> {
    let desk = Desk::new();
    let text = desk.apex(&["plan", "small-fixed-uniform-3-globular", "--problem"]).well().out;
    let mut watched: Value = serde_json::from_str(&text).unwrap();
    let costs = [
        json!({"Table": {"points": [[0.0, 0.0], [60.0, 1.0]]}}),
        json!({"Delayed": {"response_s": 30.0, "cost": {"Step": {"deadline_s": 100.0, "maximum": 2.0}}}}),
        json!({"Logistic": {"maximum": 3.0, "rate_per_s": 0.01, "midpoint_s": 300.0}}),
    ];
    for (target, cost) in watched["Surveillance"]["targets"].as_array_mut().unwrap().iter_mut().zip(costs) {
        target["cost"] = cost;
    }
    desk.write("windows.txt", TOPTW);
    let given = desk.apex(&["plan", "windows.txt", "--problem"]).well().out;
    let mut flown: Value = serde_json::from_str(FLOWN).unwrap();
    let layer = json!({"area": {"south_deg": 36.0, "north_deg": 38.0, "west_deg": -123.0, "east_deg": -121.0}, "altitude_m_min": 0.0,
        "altitude_m_max": 900.0, "from_s": 0.0, "until_s": 1e18, "wind_east_mps": 2.0, "wind_north_mps": -1.0, "edr": 0.1});
    let problem = &mut flown["SingleVisit"];
    problem["wind"]["layers"] = json!([layer]);
    problem["landing_places"] = json!([{"name": "field", "position": {"latitude_deg": 37.0, "longitude_deg": -122.0}}]);
    problem["crew"] = json!([{"role": "pilot", "wage_per_hour": 1.0, "fixed_hours": 0.5, "flight_share": 1.0}]);
    problem["precedence"] = json!([["pond", "tower <A> & B"]]);
    vec![watched, serde_json::from_str(&given).unwrap(), flown]
}

/// Pointers to every value inside `value`.
fn pointers(value: &Value, at: &str, found: &mut Vec<String>) {
    let members: Vec<(String, &Value)> = match value {
        Value::Object(members) => members.iter().map(|(name, value)| (name.clone(), value)).collect(),
        Value::Array(items) => items.iter().enumerate().map(|(index, value)| (index.to_string(), value)).collect(),
        _ => Vec::new(),
    };
    for (name, value) in members {
        let inside = format!("{at}/{name}");
        pointers(value, &inside, found);
        found.push(inside);
    }
}

/// Makes one random change: a value of another kind or size, a member removed, added or misspelt, a list shortened or extended.
fn mutate(value: &mut Value, rng: &mut Generator) -> String {
    let mut below = |count: usize| rng.below(count);
    let mut places = Vec::new();
    pointers(value, "", &mut places);
    let place = places[below(places.len())].clone();
    let kind = below(8);
    let target = value.pointer_mut(&place).unwrap();
    match (kind, &mut *target) {
        (0, Value::Object(members)) => {
            let name = members.keys().nth(below(members.len())).unwrap().clone();
            members.remove(&name);
        }
        (1, Value::Object(members)) => {
            members.insert("dwell".into(), json!(1.0));
        }
        (2, Value::Object(members)) => {
            let name = members.keys().nth(below(members.len())).unwrap().clone();
            let moved = members.remove(&name).unwrap();
            members.insert(format!("{name}s"), moved);
        }
        (0..3, Value::Array(items)) => {
            items.pop();
        }
        (3, Value::Array(items)) => items.push(json!(1.0)),
        (3 | 4, Value::Number(number)) => {
            let less = -number.as_f64().unwrap() - 1.0;
            *target = json!(less);
        }
        (5, other) => *other = json!("text"),
        (6, other) => *other = Value::Null,
        (_, other) => *other = json!(2.0),
    }
    format!("{kind} at {place}")
}

#[test]
fn what_the_schema_refuses_the_reader_refuses() {
    let problems = schema("planning-problem.schema.json");
    let desk = Desk::new();
    let mut rng = Generator::new(20_060_312);
    let (mut both, mut neither, mut senseless) = (0, 0, 0);
    for round in 0..400 {
        let mut examples = examples_once().clone();
        let number = round % examples.len();
        let problem = &mut examples[number];
        obeys(&problems, &problem.to_string());
        let change = mutate(problem, &mut rng);
        desk.write("changed.json", &problem.to_string());
        let read = desk.apex(&["plan", "changed.json", "--problem"]);
        let allowed = problems.is_valid(problem);
        match (allowed, read.code) {
            (true, Some(0)) => neither += 1,
            (false, Some(2)) => both += 1,
            // Constraints that a schema cannot express: unique names, matching sizes of tables, increasing times.
            (true, Some(2)) if read.err.contains("is invalid") => senseless += 1,
            _ => panic!("{change}: the schema {allowed}, the reader {read:?}\n{problem}"),
        }
        if read.err.contains("is not a planning problem") {
            assert!(read.err.contains("changed.json:1:"), "{read:?}");
        }
    }
    assert!(both > 150 && neither > 20 && senseless > 3, "{both} {neither} {senseless}");
}

fn examples_once() -> &'static Vec<Value> {
    static EXAMPLES: std::sync::OnceLock<Vec<Value>> = std::sync::OnceLock::new();
    EXAMPLES.get_or_init(examples)
}
