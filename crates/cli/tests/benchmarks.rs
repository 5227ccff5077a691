//! `apex plan` on benchmark files: input, output, and messages about mistakes.

#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "a test stops at an unexpected result")]

mod common;

use common::Desk;

const TOPTW: &str = "1 4 3 1\n0 200\n0 10 10 0 0 0 0 0 100\n1 13 13 5 20 1 2 1 2 30 40\n2 10 11 5 7 1 1 1 0 90\n3 90 90 1 50 1 1 1 0 99\n";
const TSP: &str = "NAME: four\nTYPE: TSP\nDIMENSION: 4\nEDGE_WEIGHT_TYPE: EUC_2D\nNODE_COORD_SECTION\n1 0 0\n2 10 10\n3 0 10\n4 10 0\nEOF\n";

#[test]
fn orienteering_with_windows_is_planned_and_reported() {
    let desk = Desk::new();
    desk.write("small.txt", TOPTW);
    let table = desk.apex(&["plan", "small.txt", "--budget", "5ms"]).well();
    table.told(&[
        "small: TOPTW, distances cut to 1 decimal",
        "the file names 4 vehicles",
        "2 of 3 targets",
        "not visited:",
    ]);
    let json = &desk.apex(&["plan", "small.txt", "--budget", "5ms", "--json"]).well().json_lines()[0];
    assert_eq!((json["value"].as_f64(), json["vehicles"].as_u64()), (Some(27.0), Some(4)));
    assert!(json["bound"].as_f64().unwrap() >= 27.0 && json["cpu_s"].is_number() | json["cpu_s"].is_null(), "{json}");
    let visits = json["plan"]["SingleVisit"]["visits"].as_array().unwrap();
    // 1 s to target 2, 5 s there, 3.6 s to target 1, which opens at 30.
    assert_eq!((visits[0]["target"].as_str(), visits[1]["begin_s"].as_f64()), (Some("2"), Some(30.0)));
    desk.apex(&["plan", "small.txt", "--vehicles", "2"])
        .complained(2, &["2 vehicles cannot", "the file names 4", "help: "]);
}

#[test]
fn a_tour_is_described_by_its_length() {
    let desk = Desk::new();
    desk.write("four.tsp", TSP);
    desk.apex(&["plan", "four.tsp", "--budget", "5ms"]).well().told(&[
        "four: TSPLIB",
        "the shortest tour of all",
        "3 of 3 targets",
        "length 40.00, proven to be the best",
    ]);
    let json = &desk.apex(&["plan", "four.tsp", "--budget", "5ms", "--json"]).well().json_lines()[0];
    assert_eq!(json["value"].as_f64(), Some(40.0));
    assert_eq!(
        (json["bound"].as_f64(), json["gap"].as_f64(), json["proven_optimal"].as_bool()),
        (Some(40.0), Some(0.0), Some(true))
    );
}

#[test]
fn mistakes_are_reported_with_their_line_and_what_to_do() {
    let desk = Desk::new();
    desk.write("bad.txt", &TOPTW.replace("20 1 2", "x 1 2"));
    desk.apex(&["plan", "bad.txt"]).complained(
        2,
        &["bad.txt:4:11: x is not a number", "1 13 13 5 x 1 2 1 2 30 40", "why: expected S, the profit", "help: "],
    );
    desk.write("bad.oplib", &TSP.replace("TYPE: TSP", "TYPE: CVRP"));
    desk.apex(&["plan", "bad.oplib"])
        .complained(2, &["bad.oplib:2:7: problems of type CVRP", "supported types are TSP, ATSP and OP"]);
    desk.write("cut.tsp", "NAME: four\nTYPE: TSP\nDIMENSION: 4\n");
    desk.apex(&["plan", "cut.tsp"]).complained(2, &["cut.tsp:3:13: EDGE_WEIGHT_TYPE is missing", "cut off"]);
    desk.write("empty.txt", "");
    desk.apex(&["plan", "empty.txt"]).complained(2, &["empty.txt:0:1: the file is empty"]);
}
