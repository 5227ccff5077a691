//! Hostile input cannot hang a command, write to the terminal, or be lost without a message; signals end flights
//! cleanly.

#![allow(clippy::unwrap_used, reason = "a test that cannot prepare its files has failed")]

mod common;

use common::{Desk, GREETINGS, mission};
use std::process::{Command, Stdio};
use std::time::Duration;

#[test]
fn devices_without_end_are_refused_with_a_reason() {
    let desk = Desk::new();
    for command in [&["check", "/dev/zero"][..], &["plan", "/dev/zero"], &["run", "/dev/zero"]] {
        desk.apex(command).complained(2, &["/dev/zero is too large to be read", "64 MiB"]);
    }
}

#[test]
fn control_characters_of_names_are_escaped() {
    let desk = Desk::new();
    let said = desk.apex(&["check", "\u{1b}]0;title\u{7}.pdl"]);
    assert!(!said.err.contains('\u{1b}') && !said.err.contains('\u{7}'), "{:?}", said.err);
    said.complained(2, &["\\u{1b}]0;title\\u{7}.pdl"]);
}

#[test]
fn messages_have_no_control_characters_and_no_endless_lines() {
    let desk = Desk::new();
    desk.write("escape.pdl", "(procedure (index (do-domain)) (st\u{1b}]0;x\u{7}ep a (b)))\n");
    let said = desk.apex(&["check", "escape.pdl"]);
    assert!(!said.out.contains('\u{1b}') && !said.out.contains('\u{7}'), "{:?}", said.out);
    desk.write("long", &"a".repeat(1_000_000));
    for command in [
        &["monitor", "--condition-file", "long"][..],
        &["run", "long"],
        &["diagnose", "long"],
        &["plan", "small-fixed-fixed-8-uniform", "--table", "long"],
        &["plan", "long"],
    ] {
        let said = desk.apex(command);
        assert_eq!(said.code, Some(2), "{command:?}: {said:?}");
        assert!(
            said.err.len() + said.out.len() < 20_000,
            "{command:?} prints {} bytes",
            said.err.len() + said.out.len()
        );
    }
}

#[test]
fn a_table_of_planners_that_is_something_else_is_refused() {
    let desk = Desk::new();
    for text in ["", "{}", "nonsense\n", "# cell,budget_units,best,verdict,next,effect_percent\n"] {
        desk.write("table.csv", text);
        desk.apex(&["plan", "small-fixed-fixed-8-uniform", "--table", "table.csv", "--budget", "1"])
            .complained(2, &["table.csv:1:1: this is not the heading of a profile table", "cell,budget_units"]);
    }
}

#[test]
fn nothing_is_expected_of_no_condition() {
    let desk = Desk::new();
    desk.write("none.pdl", "; (altitude uav > 5m)\n");
    desk.write("i.jsonl", "{\"t\": 1, \"event\": \"(go)\"}\n");
    for conditions in [&[""][..], &["; nothing"], &["--condition-file", "none.pdl"]] {
        let mut command = vec!["monitor", "--inputs", "i.jsonl", "--expect", "satisfied"];
        command.extend(conditions);
        desk.apex(&command).complained(2, &["there is no condition to watch", "hold none"]);
    }
}

/// The reader of the printed results ends at once; the table must not look complete.
#[test]
fn a_table_that_lacks_results_is_a_failure() {
    let desk = Desk::new();
    let lines = |second: u32| {
        let altitude = if second.is_multiple_of(2) { 9 } else { 1 };
        format!("{{\"t\": {second}, \"measurement\": \"(altitude uav)\", \"value\": {altitude}}}\n")
    };
    desk.write("i.jsonl", &(0..20_000).map(lines).collect::<String>());
    for name in ["results.csv", "results.parquet"] {
        let watch = ["monitor", "(altitude uav > 5)", "--inputs", "i.jsonl", "--json", "--results", name];
        let mut child = desk.command(&watch).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        let err = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{err}");
        assert!(err.contains(&format!("{name} is incomplete")), "{err}");
    }
}

#[test]
fn a_long_word_of_brackets_is_checked_in_linear_time() {
    let desk = Desk::new();
    desk.write("brackets.pdl", &"[".repeat(400_000));
    let began = std::time::Instant::now();
    assert_eq!(desk.apex(&["check", "brackets.pdl"]).code, Some(2));
    assert!(began.elapsed() < Duration::from_secs(60), "{:?}", began.elapsed());
}

#[test]
fn keys_given_twice_are_refused() {
    let desk = Desk::with_greetings();
    desk.write("twice.jsonl", "{\"t\": 7, \"event\": \"(stop)\", \"event\": \"(go)\"}\n");
    let said = desk.apex(&["run", "greetings.pdl", "--inputs", "twice.jsonl"]);
    said.complained(2, &["twice.jsonl:1:", "the key `event` is given twice"]);
}

#[test]
fn a_byte_order_mark_is_not_text() {
    let desk = Desk::with_greetings();
    desk.write("greetings.pdl", &format!("\u{feff}{GREETINGS}"));
    desk.write("go.jsonl", "\u{feff}{\"t\": 7, \"event\": \"(go)\"}\n");
    desk.apex(&["check", "greetings.pdl"]).complained(0, &[]);
    desk.apex(&["run", "greetings.pdl", "--inputs", "go.jsonl", "--text"])
        .complained(0, &[])
        .told(&["prints hello moon"]);
}

#[cfg(unix)]
#[test]
fn signals_end_a_flight_with_its_report_and_record() {
    for signal in ["-INT", "-TERM"] {
        let desk = Desk::new();
        let child = desk
            .command(&["fly", &mission("first-picture"), "--record", "cut.apex", "--no-progress", "--pace", "20"])
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let began = std::time::Instant::now();
        while !desk.apex(&["trace", "cut.apex", "--type", "command"]).out.contains("take off") {
            assert!(began.elapsed() < Duration::from_secs(60), "the flight does not begin");
            std::thread::sleep(Duration::from_millis(50));
        }
        assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
        let said = child.wait_with_output().unwrap();
        let out = String::from_utf8_lossy(&said.stdout);
        assert!(said.status.success(), "{signal}: {} {}", out, String::from_utf8_lossy(&said.stderr));
        assert!(out.contains("Flight record: cut.apex"), "{signal}: {out}");
        let trace = desk.apex(&["replay", "cut.apex"]);
        assert!(!trace.err.contains("incomplete"), "{signal}: {}", trace.err);
        trace.told(&["The record is confirmed"]);
    }
}

#[cfg(unix)]
#[test]
fn a_signal_ends_a_fork_with_its_reports_and_record() {
    let desk = Desk::new();
    desk.apex(&["fly", &mission("western-states"), "--record", "f.apex", "--no-progress", "--until", "5min"])
        .complained(0, &[]);
    let child = desk
        .command(&["fork", "f.apex", "--at", "4min", "--output", "cut.apex"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let began = std::time::Instant::now();
    while !desk.apex(&["trace", "cut.apex", "--from", "10min"]).out.contains("0:1") {
        assert!(began.elapsed() < Duration::from_secs(60), "the fork does not begin");
        std::thread::sleep(Duration::from_millis(20));
    }
    assert!(Command::new("kill").args(["-TERM", &child.id().to_string()]).status().unwrap().success());
    let said = child.wait_with_output().unwrap();
    let out = String::from_utf8_lossy(&said.stdout);
    assert!(said.status.success(), "{out} {}", String::from_utf8_lossy(&said.stderr));
    assert!(out.contains("Flight record: cut.apex") && out.contains("stopped from outside"), "{out}");
    let replayed = desk.apex(&["replay", "cut.apex"]);
    assert!(!replayed.err.contains("incomplete"), "{}", replayed.err);
    replayed.told(&["The record is confirmed"]);
}

/// Returns a folder with 4,000 ticks to answer. They take about 500 kB in a record: more than a file of 200 kB and its log of 200 kB hold
/// together.
#[cfg(unix)]
fn desk_with_ticks() -> Desk {
    let desk = Desk::new();
    desk.write(
        "ticks.pdl",
        "(procedure (index (do-domain)) (step see (print \"seen\" ?n) (waitfor (tick ?n)) (repeating)))\n",
    );
    let ticks: String = (1..=4_000).map(|tick| format!("{{\"t\": {tick}, \"event\": \"(tick {tick})\"}}\n")).collect();
    desk.write("ticks.jsonl", &ticks);
    desk
}

#[cfg(unix)]
#[test]
fn a_limit_on_the_size_of_files_leaves_segments_that_are_one_record() {
    let desk = desk_with_ticks();
    let run = "ulimit -f 200 && exec \"$0\" run ticks.pdl --inputs ticks.jsonl --record f.apex --trace /dev/null";
    let said =
        Command::new("bash").args(["-c", run, env!("CARGO_BIN_EXE_apex")]).current_dir(desk.path("")).output().unwrap();
    let err = String::from_utf8_lossy(&said.stderr);
    assert!(said.status.success(), "{:?}: {err}", said.status);
    assert!(err.contains("the flight is not being recorded"), "{err}");
    let last =
        (2..).map(|number| format!("f-segment-{number}.apex")).take_while(|name| desk.path(name).exists()).last();
    let last = last.expect("a segment");
    let verified = desk.apex(&["verify", &last]).complained(0, &[]).told(&["it continues", "f.apex"]);
    let steps = verified.out.split_once(" steps up to").and_then(|(before, _)| before.rsplit(' ').next()).unwrap();
    assert!(steps.parse::<u32>().unwrap() >= 4_000, "{steps}");
    let (confirmed, saved) = (format!("The record is confirmed: {steps} steps"), format!("{steps} steps"));
    desk.apex(&["replay", &last]).complained(0, &[]).told(&[&confirmed]);
    desk.apex(&["recover", &last, "--out", "whole.apex"]).complained(0, &[]).told(&[&saved]);
    std::fs::remove_file(desk.path("f.apex")).unwrap();
    desk.apex(&["trace", &last]).complained(
        0,
        &[
            "continues",
            "which is not there; put it back",
            "because the file that it continues is not there: steps 1 to",
        ],
    );
    desk.apex(&["replay", "whole.apex"]).complained(0, &[]).told(&[&confirmed]);
}

#[test]
fn a_spare_folder_that_cannot_be_used_is_refused_before_the_flight() {
    let desk = Desk::with_greetings();
    for folder in ["nowhere", "greetings.pdl"] {
        let said = desk.apex(&["run", "greetings.pdl", "--record", "f.apex", "--spare-folder", folder]);
        said.complained(2, &["the flight record cannot continue in", folder, "--spare-folder"]);
        assert!(!desk.path("f.apex").exists());
    }
}
