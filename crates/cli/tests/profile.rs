//! `apex profile`: measuring, completing, showing, comparing, and messages about mistakes.

#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "a test stops at an unexpected result")]

mod common;

use common::Desk;

const CELLS: &str = "large-fixed-fixed-4-uniform,small-clustered-clustered-8-two-cluster";

/// Measures two cells, six missions each.
fn measured(desk: &Desk, file: &str, planners: &str, threads: &str) {
    let arguments = ["profile", "build", file, "--cells", CELLS, "--missions", "6", "--budgets", "1ms,10ms"];
    let rest = ["--planners", planners, "--threads", threads, "--table", "table.csv", "--no-progress"];
    desk.apex(&[arguments.as_slice(), &rest].concat()).well();
}

#[test]
fn a_profile_is_the_same_for_any_number_of_threads_and_any_way_to_it() {
    let desk = Desk::new();
    measured(&desk, "one.txt", "two-opt,wam,anytime", "1");
    measured(&desk, "many.txt", "two-opt,wam,anytime", "3");
    assert_eq!(desk.read("one.txt"), desk.read("many.txt"));
    measured(&desk, "less.txt", "two-opt,wam", "2");
    desk.apex(&["profile", "update", "less.txt", "--planners", "anytime,two-opt", "--no-progress"]).well();
    assert_eq!(desk.read("less.txt"), desk.read("one.txt"));
    assert!(desk.read("table.csv").contains("large-fixed-fixed-4-uniform,10000,"));
}

#[test]
fn parts_that_were_measured_apart_make_the_profile_of_one_machine() {
    let desk = Desk::new();
    measured(&desk, "one.txt", "two-opt,wam", "2");
    let part = |file: &str, cell: &str, planners: &str, more: &[&str]| {
        let arguments = ["profile", "build", file, "--cells", cell, "--planners", planners, "--no-progress"];
        let budgets = if more.contains(&"--budgets") { &[][..] } else { &["--budgets", "1ms,10ms"] };
        desk.apex(&[arguments.as_slice(), budgets, more].concat()).well();
    };
    let six = ["--missions", "6"];
    let [first, second] = [0, 1].map(|at| CELLS.split(',').nth(at).unwrap());
    part("a.txt", second, "two-opt,wam", &six);
    part("b.txt", first, "two-opt", &six);
    part("c.txt", first, "wam", &six);
    desk.apex(&["profile", "merge", "whole.txt", "a.txt", "b.txt", "c.txt", "a.txt", "--table", "whole.csv"]).well();
    assert_eq!(desk.read("whole.txt"), desk.read("one.txt"));
    assert_eq!(desk.read("whole.csv"), desk.read("table.csv"));

    let refused = |parts: &[&str], told: &[&str]| {
        desk.apex(&[&["profile", "merge", "no.txt"], parts].concat()).complained(2, told);
    };
    refused(&["a.txt", "b.txt"], &["not parts of one", &format!("wam was not measured in {first}")]);
    part("d.txt", first, "wam", &["--missions", "5"]);
    refused(&["a.txt", "d.txt"], &["d.txt has other numbers of missions than a.txt"]);
    desk.write("e.txt", &desk.read("c.txt").replacen("planner wam ", "planner wam 9.", 1));
    refused(&["a.txt", "e.txt"], &["e.txt has wam 9."]);
    let text = desk.read("c.txt");
    let cost = text.lines().find(|line| line.starts_with("wam 1000 ")).and_then(|line| line.split(' ').nth(2)).unwrap();
    desk.write("f.txt", &text.replacen(cost, "1.0", 1));
    refused(&["c.txt", "f.txt"], &["f.txt: the costs of wam in", "differ from those in an earlier part"]);
    desk.write("g.txt", &text.replacen("generator 1", "generator 2", 1));
    refused(&["c.txt", "g.txt"], &["g.txt has other missions (by version"]);
    let hash = text.lines().find(|line| line.starts_with("cell ")).and_then(|line| line.split(' ').nth(2)).unwrap();
    desk.write("h.txt", &text.replacen(hash, &"0".repeat(hash.len()), 1));
    refused(&["c.txt", "h.txt"], &[&format!("h.txt: the missions of {first} differ from those in an earlier part")]);
    part("i.txt", first, "wam", &[&six[..], &["--budgets", "1ms,20ms"]].concat());
    refused(&["a.txt", "i.txt"], &["i.txt has other budgets than a.txt"]);
    desk.write("mine.txt", "my notes");
    desk.apex(&["profile", "merge", "mine.txt", "c.txt"]).complained(2, &["is not overwritten"]);
    assert_eq!(desk.read("mine.txt"), "my notes");
    refused(&[], &["PART"]);
}

#[test]
fn cells_of_ones_own_come_after_those_of_the_table() {
    let desk = Desk::new();
    let cells = ["small-fixed-fixed-7-uniform", "small-fixed-fixed-5-uniform", "large-fixed-fixed-4-uniform"];
    for (file, cell) in ["a.txt", "b.txt", "c.txt"].into_iter().zip(cells) {
        let arguments = ["profile", "build", file, "--cells", cell, "--planners", "two-opt", "--no-progress"];
        desk.apex(&[arguments.as_slice(), &["--missions", "2", "--budgets", "1ms"]].concat()).well();
    }
    desk.apex(&["profile", "merge", "whole.txt", "a.txt", "b.txt", "c.txt"]).well();
    let whole = desk.read("whole.txt");
    let order: Vec<&str> = whole.lines().filter_map(|line| line.strip_prefix("cell ")?.split(' ').next()).collect();
    assert_eq!(order, [cells[2], cells[0], cells[1]]);
}

#[test]
fn a_profile_is_shown_and_compared() {
    let desk = Desk::new();
    measured(&desk, "a.txt", "nearest-neighbour,two-opt,wam", "2");
    desk.apex(&["profile", "show", "a.txt"]).well().told(&[
        "2 cells, 6 missions each",
        "best planner at 10 ms",
        "  large",
    ]);
    desk.apex(&["profile", "show", "a.txt", "--cell", "large-fixed-fixed-4-uniform", "--budget", "10ms"])
        .well()
        .told(&["large-fixed-fixed-4-uniform at 10 ms", "% more (from ", "p = "]);
    let lines = desk.apex(&["profile", "show", "a.txt", "--json"]).well().json_lines();
    assert_eq!((lines.len(), lines[0]["cell"].as_str()), (4, Some("large-fixed-fixed-4-uniform")));
    desk.apex(&["profile", "show", "a.txt", "--svg", "a.svg"]).well();
    assert_eq!(desk.read("a.svg").matches("<title>").count(), 4);
    desk.apex(&["profile", "show", "a.txt", "--svg", "b.svg", "--figure-4"]).well();
    assert_eq!(desk.read("b.svg").matches("<title>").count(), 243 + 2);
    desk.apex(&["profile", "compare", "a.txt", "a.txt"]).well().told(&["at 10 ms: the same planner in 2 of 2 cells"]);
    desk.apex(&["profile", "compare", "a.txt"]).well().told(&[
        "Figure 4 (rows)",
        "of 1 cells",
        "in 1 the figure's best is a human planner",
    ]);
}

#[test]
fn the_shipped_profile_is_compared_with_figure_4() {
    let desk = Desk::new();
    let json = &desk.apex(&["profile", "compare", "--json"]).well().json_lines()[0];
    assert_eq!((json["comparable"].as_u64(), json["human"].as_u64()), (Some(219), Some(24)));
    let count =
        |row: usize| json["counts"][row].as_array().unwrap().iter().map(|one| one.as_u64().unwrap()).sum::<u64>();
    assert_eq!([0, 1, 2, 3].map(count), [24, 73, 130, 16]);
}

#[test]
fn regret_is_measured_on_other_counts() {
    let desk = Desk::new();
    let arguments =
        ["profile", "compare", "--regret", "--counts", "6", "--missions", "1", "--budgets", "2ms", "--no-progress"];
    desk.apex(&arguments)
        .well()
        .told(&["6 targets at 2 ms, 81 missions: regret ", "regret of a single planner in all missions: "]);
}

#[test]
fn mistakes_are_reported_before_anything_is_measured() {
    let desk = Desk::new();
    let build = |more: &[&str]| desk.apex(&[&["profile", "build", "new.txt"], more].concat());
    build(&["--planners", "three-opt"])
        .complained(2, &["surveillance planner `three-opt` not found", "known planners: nearest-neighbour"]);
    build(&["--planners", "single-visit"]).complained(2, &["surveillance planner `single-visit` not found"]);
    build(&["--planners", "wam,wam"]).complained(2, &["wam is named twice"]);
    build(&["--cells", "huge-fixed-fixed-4-uniform"])
        .complained(2, &["no cell huge-fixed", "large, medium or small", "test-missions.md"]);
    build(&["--cells", "subset,subset"]).complained(2, &["is named twice"]);
    build(&["--budgets", "10ms,1ms"]).complained(2, &["invalid budgets `10ms, 1ms`", "the shortest first"]);
    build(&["--budgets", "0s"]).complained(2, &["expected a duration greater than zero"]);
    build(&["--budgets", "soon"]).complained(2, &["is not a time"]);
    build(&["--missions", "0"]).complained(2, &["0 missions of each cell"]);
    build(&["--cells", "subset", "--missions", "1", "--threads", "0"])
        .complained(2, &["invalid value `0` for `--threads`"]);
    desk.write("new.txt", "my notes");
    build(&[]).complained(2, &["new.txt exists and is not a profile, so it is not overwritten"]);
    assert_eq!(desk.read("new.txt"), "my notes");
    desk.apex(&["profile", "show", "new.txt"])
        .complained(2, &["new.txt:1:1: this is not a profile", "my notes", "help: "]);
    desk.apex(&["profile", "show", "nowhere.txt"]).complained(2, &["cannot read nowhere.txt"]);
    desk.apex(&["profile", "show", "--budget", "7ms"]).complained(2, &["7ms was not measured", "this profile has"]);
    desk.apex(&["profile", "show", "--cell", "small-fixed-fixed-5-uniform"]).complained(2, &["was not measured"]);
    desk.apex(&["profile", "compare", "--regret", "--counts", "0"]).complained(2, &["no missions of 0 targets"]);
    measured(&desk, "a.txt", "wam", "1");
    desk.change("a.txt", "generator 1", "generator 2");
    desk.apex(&["profile", "update", "a.txt", "--planners", "wam"])
        .complained(2, &["a.txt cannot be updated", "version 2 of the generator", "apex profile build"]);
    desk.apex(&["profile", "compare", "a.txt"])
        .complained(2, &["cannot be compared with Figure 4", "two-opt or wam was not measured"]);
}
