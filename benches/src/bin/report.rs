//! Compares the measurements of Criterion with the bars and the peers, as a Markdown table.
//!
//! `report CRITERION_FOLDER ROWS_FOLDER [PEER.json]..` reads the medians of the last run, so it must follow a run, and the figures stored
//! by other programs.
#![allow(clippy::print_stdout, reason = "the table is what the program is for")]

use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;
use std::process::ExitCode;

/// The group with figures in bytes; all others are in nanoseconds.
const MEMORY: &str = "memory";

/// A bar: the measurement, its count, and the maximum of its median.
struct Bar {
    quantity: &'static str,
    group: &'static str,
    function: &'static str,
    count: &'static str,
    at_most: f64,
    /// The peer's row for the same work.
    peer: Option<&'static str>,
}

const fn bar(
    quantity: &'static str,
    [group, function, count]: [&'static str; 3],
    at_most: f64,
    peer: Option<&'static str>,
) -> Bar {
    Bar { quantity, group, function, count, at_most, peer }
}

/// Bars in nanoseconds, or bytes where memory is counted; per element where a row has elements.
const BARS: &[Bar] = &[
    bar("event to command, own variable", ["event to command", "one step", "1000"], 700.0, Some("event to command")),
    bar("event to command, own variable", ["event to command", "one step", "100000"], 2_000.0, None),
    bar("sample without a monitor", ["event to nothing", "no task watches", "100000"], 235.0, None),
    bar(
        "one variable, bounds of many tasks",
        ["event to nothing", "one variable, all bounds above", "10000"],
        5_000.0,
        None,
    ),
    bar(
        "one variable, one bound passed",
        ["one of many bounds", "to command", "10000"],
        5_000.0,
        Some("shared variable"),
    ),
    bar("across threads, inbox to outbox", ["across threads", "inbox to outbox", "1"], 20_000.0, None),
    bar("task life, flat", ["task life", "flat", "1000"], 1_000.0, Some("task life")),
    bar("task life, flat", ["task life", "flat", "100000"], 1_000.0, None),
    bar("task life, nested", ["task life", "nested", "100000"], 1_000.0, None),
    bar("task life, sequence", ["task life", "one sequence", "100000"], 1_000.0, None),
    bar("task life, chain of waitfors", ["task life", "one chain of waitfors", "100000"], 1_000.0, None),
    bar("task life, concurrent", ["task life", "concurrent", "100000"], 1_000.0, None),
    bar("task life, ranked", ["task life", "ranked", "100000"], 1_000.0, None),
    bar("hand-off", ["hand-off", "interruption and resumption", "1000"], 3_000.0, Some("hand-off")),
    bar("hand-off", ["hand-off", "interruption and resumption", "100000"], 10_000.0, None),
    bar("hand-off, known durations", ["hand-off of each kind", "known durations", "1000"], 10_000.0, None),
    bar("hand-off, known durations", ["hand-off of each kind", "known durations", "100000"], 20_000.0, None),
    bar("hand-off, two resources", ["hand-off of each kind", "two resources", "1000"], 10_000.0, None),
    bar("hand-off, two resources", ["hand-off of each kind", "two resources", "100000"], 20_000.0, None),
    bar(
        "hand-off, two resources, known durations",
        ["hand-off of each kind", "two resources, known durations", "1000"],
        10_000.0,
        None,
    ),
    bar(
        "hand-off, two resources, known durations",
        ["hand-off of each kind", "two resources, known durations", "100000"],
        20_000.0,
        None,
    ),
    bar(
        "hand-off, a shared and a separate resource",
        ["hand-off of each kind", "a shared and a separate resource", "1000"],
        10_000.0,
        None,
    ),
    bar(
        "hand-off, a shared and a separate resource",
        ["hand-off of each kind", "a shared and a separate resource", "100000"],
        20_000.0,
        None,
    ),
    bar("hand-off, capacity 2", ["hand-off of each kind", "capacity 2", "1000"], 10_000.0, None),
    bar("hand-off, capacity 2", ["hand-off of each kind", "capacity 2", "100000"], 20_000.0, None),
    bar("hand-off, urgency", ["hand-off of each kind", "urgency", "1000"], 10_000.0, None),
    bar("hand-off, urgency", ["hand-off of each kind", "urgency", "100000"], 20_000.0, None),
    bar("hand-off, ranked steps", ["hand-off of each kind", "ranked steps", "1000"], 10_000.0, None),
    bar("hand-off, ranked steps", ["hand-off of each kind", "ranked steps", "100000"], 20_000.0, None),
    bar(
        "hand-off, ranked steps, two resources",
        ["hand-off of each kind", "ranked steps, two resources", "1000"],
        10_000.0,
        None,
    ),
    bar(
        "hand-off, ranked steps, two resources",
        ["hand-off of each kind", "ranked steps, two resources", "100000"],
        20_000.0,
        None,
    ),
    bar("hand-off, ranked steps, urgency", ["hand-off of each kind", "ranked steps, urgency", "1000"], 10_000.0, None),
    bar(
        "hand-off, ranked steps, urgency",
        ["hand-off of each kind", "ranked steps, urgency", "100000"],
        20_000.0,
        None,
    ),
    bar(
        "memory of a waiting task",
        [MEMORY, "steps of one procedure, each for its own variable", "1000"],
        800.0,
        Some("memory"),
    ),
    bar(
        "memory of a waiting task",
        [MEMORY, "steps of one procedure, each for its own variable", "100000"],
        800.0,
        None,
    ),
    bar("load one sequence of 100,000 steps", ["load", "one sequence", "100000"], 0.5e9, None),
    bar("load one chain of 100,000 waitfors", ["load", "one chain of waitfors", "100000"], 0.5e9, None),
    bar("synthesis of a manoeuvre", ["acquisition", "targets", "1"], 50e6, None),
    bar("synthesis of manoeuvres for 40 targets", ["acquisition", "targets", "40"], 1e9, None),
    bar("load 25,000 procedures of 4 steps", ["load", "many procedures", "100000"], 0.5e9, None),
];

/// (group, function) -> count -> median in nanoseconds, per element for rows that have elements.
type Medians = BTreeMap<(String, String), BTreeMap<u64, f64>>;

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    let (Some(folder), Some(others)) = (arguments.next(), arguments.next()) else {
        eprintln!("usage: report CRITERION_FOLDER ROWS_FOLDER [PEER.json]..");
        return ExitCode::FAILURE;
    };
    let mut rows = Medians::new();
    collect(Path::new(&folder), &mut rows);
    collect_others(Path::new(&others), &mut rows);
    if rows.is_empty() {
        eprintln!("no measurements under {folder}: run `cargo bench -p apex-benches` first");
        return ExitCode::FAILURE;
    }
    let peers: Vec<Value> = arguments.filter_map(|path| read_json(Path::new(&path))).collect();
    print_growth(&rows);
    print_bars(&rows, &peers);
    ExitCode::SUCCESS
}

fn read_json(path: &Path) -> Option<Value> {
    serde_json::from_str(&std::fs::read_to_string(path).ok()?).ok()
}

/// Adds the medians of all rows below `folder`. Criterion keeps `new/benchmark.json` and `new/estimates.json` for each row, at varying
/// depth.
fn collect(folder: &Path, rows: &mut Medians) {
    let new = folder.join("new");
    let row = read_json(&new.join("benchmark.json")).zip(read_json(&new.join("estimates.json")));
    if let Some((benchmark, estimates)) = row {
        let word = |key: &str| benchmark.get(key).and_then(Value::as_str).unwrap_or_default().to_string();
        let count = word("value_str").parse().unwrap_or(0);
        let elements = benchmark.pointer("/throughput/Elements").and_then(Value::as_f64).unwrap_or(1.0);
        // Criterion times one iteration, which in `task life` has many lives: its time is divided by their number. Other groups time one
        // piece.
        let divisor = if word("group_id") == "task life" { elements } else { 1.0 };
        if let Some(median) = estimates.pointer("/median/point_estimate").and_then(Value::as_f64) {
            rows.entry((word("group_id"), word("function_id"))).or_default().insert(count, median / divisor);
        }
        return;
    }
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    entries.flatten().filter(|entry| entry.path().is_dir()).for_each(|entry| collect(&entry.path(), rows));
}

/// Adds the figures that programs other than Criterion stored.
fn collect_others(folder: &Path, rows: &mut Medians) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    for row in entries.flatten().filter_map(|entry| read_json(&entry.path())) {
        let word = |key: &str| row.get(key).and_then(Value::as_str).unwrap_or_default().to_string();
        let figures = row.get("rows").and_then(Value::as_object).into_iter().flatten();
        let figures = figures.filter_map(|(count, figure)| Some((count.parse().ok()?, figure.as_f64()?)));
        rows.entry((word("group"), word("function"))).or_default().extend(figures);
    }
}

/// Prints every row with its growth: the ratio of the times for the greatest and the least count.
fn print_growth(rows: &Medians) {
    println!("| measured | median at each count | growth |\n|---|---|---|");
    for ((group, function), counts) in rows {
        let cells: Vec<String> = counts
            .iter()
            .map(|(count, figure)| (count, in_words(group, *figure)))
            .map(|(count, figure)| if *count == 0 { figure } else { format!("{count}: {figure}") })
            .collect();
        let growth = match (counts.first_key_value(), counts.last_key_value()) {
            (Some((least, first)), Some((most, last))) if most > least => {
                format!("{:.2} x for {} x count", last / first, most / (*least).max(1))
            }
            _ => String::new(),
        };
        println!("| {group}: {function} | {} | {growth} |", cells.join(", "));
    }
    println!();
}

fn print_bars(rows: &Medians, peers: &[Value]) {
    println!("| quantity | count | bar | measured | | peer in the same run | ratio |\n|---|---|---|---|---|---|---|");
    for bar in BARS {
        let count = bar.count.parse().unwrap_or(0);
        let row = rows.get(&(bar.group.to_string(), bar.function.to_string()));
        let Some(measured) = row.and_then(|counts| counts.get(&count)) else {
            println!(
                "| {} | {} | {} | not measured | | | |",
                bar.quantity,
                bar.count,
                in_words(bar.group, bar.at_most)
            );
            continue;
        };
        let verdict = if *measured <= bar.at_most { "met" } else { "MISSED" };
        let peer = peers.iter().find_map(|peer| {
            let ns = peer.get("rows")?.get(bar.peer?)?.get(bar.count)?.as_f64()?;
            Some((
                format!("{} {}", peer.get("name")?.as_str()?, in_words(bar.group, ns)),
                format!("{:.0} x", ns / measured),
            ))
        });
        let (peer, ratio) = peer.unwrap_or_default();
        let (quantity, at_most) = (bar.quantity, in_words(bar.group, bar.at_most));
        let measured = in_words(bar.group, *measured);
        println!("| {quantity} | {count} | {at_most} | {measured} | {verdict} | {peer} | {ratio} |");
    }
}

fn in_words(group: &str, figure: f64) -> String {
    if group == MEMORY { format!("{figure:.0} B") } else { time(figure) }
}

fn time(ns: f64) -> String {
    match ns {
        ns if ns >= 1e9 => format!("{:.2} s", ns / 1e9),
        ns if ns >= 1e6 => format!("{:.1} ms", ns / 1e6),
        ns if ns >= 1e3 => format!("{:.2} us", ns / 1e3),
        ns => format!("{ns:.0} ns"),
    }
}
