//! `apex plan --survival`: the cost of a plan if events are not rare.
#![allow(clippy::expect_used, clippy::indexing_slicing, reason = "a test")]

mod common;

use common::Desk;
use serde_json::{Value, json};

/// Returns a plan with one target that is seen every 300 s, with an event every `mean_s`.
fn watched(mean_s: f64) -> Value {
    json!({"Surveillance": {
        "targets": [{
            "name": "barn", "position": {"latitude_deg": 37.4, "longitude_deg": -121.1}, "dwell_s": 300.0,
            "rate": {"steps": [[0.0, 1.0 / mean_s]]}, "cost": {"Linear": {"cost_per_s": 2.0}}, "initial_age_s": 0.0
        }],
        "travel": {"from_start_s": [0.0], "between_s": [[0.0]], "to_base_s": []},
        "horizon_s": 600.0, "return_to_base": false
    }})
}

#[test]
fn the_first_event_alone_costs_less_the_likelier_it_is() {
    let desk = Desk::new();
    // Two intervals of 300 s, each age of the event weighted by the probability that no event came before: one event per 1,000 s, then per
    // 100 s.
    for (mean_s, all, first) in [(1_000.0, 180.0, 163.273), (100.0, 1_800.0, 819.915), (1e9, 1.8e-4, 1.8e-4)] {
        desk.write("p.json", &watched(mean_s).to_string());
        let said = desk.apex(&["plan", "p.json", "--visits", "barn", "--repeat", "--survival", "--json"]).well().out;
        let answer: Value = serde_json::from_str(&said).expect("JSON");
        let near = |found: &Value, cost: f64| (found.as_f64().expect("a number") / cost - 1.0).abs() < 1e-5;
        assert!(near(&answer["value"], all), "{}", answer["value"]);
        assert!(near(&answer["survival_cost"], first), "{}", answer["survival_cost"]);
    }
    desk.write("p.json", &watched(1_000.0).to_string());
    let said = desk.apex(&["plan", "p.json", "--survival"]).well().out;
    assert!(said.contains("  if only the first event after an observation counts: 163.2729, 9.3 % less\n"), "{said}");
    let said = desk.apex(&["plan", "p.json", "--json"]).well().out;
    assert!(said.contains(r#""survival_cost":null"#), "{said}");
}

#[test]
fn what_has_no_such_cost_is_reported() {
    let desk = Desk::new();
    desk.write("p.json", &watched(1_000.0).to_string());
    desk.apex(&["plan", "p.json", "--survival", "--format", "geojson"])
        .complained(2, &["`--survival` is for tables and JSON", "leave `--survival` or `--format` out"]);
    desk.apex(&["plan", "p.json", "--survival", "--problem"]).complained(2, &["cannot be used with"]);
    desk.write("p.tsp", "NAME : t\nTYPE : TSP\nDIMENSION : 3\nEDGE_WEIGHT_TYPE : EUC_2D\nNODE_COORD_SECTION\n1 0 0\n2 3 0\n3 0 4\nEOF\n");
    desk.apex(&["plan", "p.tsp", "--survival"])
        .complained(2, &["`--survival` is for plans of surveillance", "single visits have no cost of ignorance"]);
}
