//! The outputs in guides are true: every `console` block is run and compared. `UPDATE=1` rewrites them.

#![allow(clippy::unwrap_used, reason = "a guide that cannot be played is a failed test")]

mod common;

use common::missions;
use std::fs;
use std::path::Path;
use std::process::Command;

/// Runs the commands of `text` in `folder` and returns the text with their actual outputs. Outputs of `--json` reports are left out,
/// because they are for programs; a block with a line `[..]` keeps only the lines that it shows.
fn played(text: &str, folder: &Path) -> String {
    let mut page = String::new();
    let mut lines = text.lines().peekable();
    while let Some(line) = lines.next() {
        page.push_str(line);
        page.push('\n');
        if line != "```console" {
            continue;
        }
        let command = lines.next().unwrap();
        page.push_str(command);
        page.push('\n');
        let real = output(command.strip_prefix("$ apex ").unwrap(), folder);
        let shown: Vec<&str> = std::iter::from_fn(|| lines.next_if(|line| *line != "```")).collect();
        page.push_str(&if shown.contains(&LEFT_OUT) { excerpt(&shown, &real) } else { real });
    }
    page
}

/// Line of a guide that represents lines of an output which the guide leaves out.
const LEFT_OUT: &str = "[..]";
/// Number of leading characters by which a line that has changed is recognised.
const LABEL: usize = 20;

/// Returns the present form of the output lines that the guide shows, with a mark wherever lines are left out.
fn excerpt(shown: &[&str], real: &str) -> String {
    let real: Vec<&str> = real.lines().collect();
    let label = |line: &str| line.chars().take(LABEL).collect::<String>();
    let (mut excerpt, mut next) = (Vec::new(), 0);
    for line in shown.iter().filter(|line| **line != LEFT_OUT) {
        let rest = real.get(next..).unwrap_or_default();
        let same = rest.iter().position(|other| other == line);
        let Some(ahead) = same.or_else(|| rest.iter().position(|other| label(other) == label(line))) else { continue };
        if ahead > 0 {
            excerpt.push(LEFT_OUT);
        }
        excerpt.extend(rest.get(ahead));
        next += ahead + 1;
    }
    if next < real.len() {
        excerpt.push(LEFT_OUT);
    }
    excerpt.iter().map(|line| format!("{line}\n")).collect()
}

#[test]
fn an_excerpt_marks_every_gap_and_shows_lines_as_they_are_now() {
    let real = "fork of a\n\n  ended at            0:59\n  plans               9\nRecord: a-fork.apex\n";
    let shown = ["fork of a", LEFT_OUT, "  plans               7", "  never printed"];
    assert_eq!(excerpt(&shown, real), "fork of a\n[..]\n  plans               9\n[..]\n");
    assert_eq!(excerpt(&real.lines().collect::<Vec<_>>(), real), real);
}

fn output(arguments: &str, folder: &Path) -> String {
    let mut words = Vec::new();
    for (index, part) in arguments.split('"').enumerate() {
        match index % 2 {
            0 => words.extend(part.split_whitespace().map(str::to_owned)),
            _ => words.push(part.to_owned()),
        }
    }
    let said = Command::new(env!("CARGO_BIN_EXE_apex")).args(&words).current_dir(folder).output().unwrap();
    if words.iter().any(|word| word == "--json") {
        assert!(said.status.success(), "{}", String::from_utf8_lossy(&said.stderr));
        return String::new();
    }
    let bytes = if said.status.success() { said.stdout } else { said.stderr };
    String::from_utf8(bytes).unwrap().lines().map(|line| format!("{}\n", line.trim_end())).collect()
}

/// Copies a mission that ships into `missions/NAME` of a folder.
fn copy_mission(desk: &Path, name: &str) {
    let mission = desk.join("missions").join(name);
    fs::create_dir_all(&mission).unwrap();
    for file in fs::read_dir(missions().join(name)).unwrap() {
        let file = file.unwrap();
        fs::copy(file.path(), mission.join(file.file_name())).unwrap();
    }
}

#[test]
fn the_guide_to_what_if_shows_what_is_printed() {
    let desk = tempfile::TempDir::new().unwrap();
    copy_mission(desk.path(), "structure-watch");
    let guide = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/guides/what-if.md");
    let text = fs::read_to_string(&guide).unwrap();
    let real = played(&text, desk.path());
    if std::env::var("UPDATE").is_ok_and(|value| value == "1") {
        fs::write(&guide, &real).unwrap();
    }
    assert!(text == real || std::env::var("UPDATE").is_ok(), "the guide differs; UPDATE=1 rewrites it:\n{real}");
    assert!(real.contains("The record is confirmed") && real.contains("fork the record that it continues"), "{real}");
}

#[test]
fn the_guide_to_asking_why_shows_what_is_answered() {
    let desk = tempfile::TempDir::new().unwrap();
    copy_mission(desk.path(), "first-picture");
    let guide = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/guides/asking-why.md");
    let text = fs::read_to_string(&guide).unwrap();
    let real = played(&text, desk.path());
    if std::env::var("UPDATE").is_ok_and(|value| value == "1") {
        fs::write(&guide, &real).unwrap();
    }
    assert!(text == real || std::env::var("UPDATE").is_ok(), "the guide differs; UPDATE=1 rewrites it:\n{real}");
    assert!(
        real.contains("(calibration-due camera-1) was received as an input") && real.contains("Near it are"),
        "{real}"
    );
}

#[test]
fn the_guide_to_monitoring_a_log_shows_what_is_printed() {
    let desk = tempfile::TempDir::new().unwrap();
    let guide = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/guides/monitoring-a-log.md");
    let text = fs::read_to_string(&guide).unwrap();
    for (mark, file) in [("```csv\n", "flight.csv"), ("```pdl\n", "names.pdl")] {
        let block = text.split(mark).nth(1).unwrap().split("```").next().unwrap();
        fs::write(desk.path().join(file), block).unwrap();
    }
    let real = played(&text, desk.path());
    if std::env::var("UPDATE").is_ok_and(|value| value == "1") {
        fs::write(&guide, &real).unwrap();
    }
    assert!(text == real || std::env::var("UPDATE").is_ok(), "the guide differs; UPDATE=1 rewrites it:\n{real}");
    assert!(real.contains("a gap of P3S > P1S cut it before"), "{real}");
}

#[test]
fn the_guide_to_diagnosis_shows_what_is_printed() {
    let desk = tempfile::TempDir::new().unwrap();
    let guide = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/guides/diagnosis.md");
    let text = fs::read_to_string(&guide).unwrap();
    let files = ["payload", "gimbal", "converter", "telemetry", "contradiction"];
    for (block, file) in text.split("```json\n").skip(1).zip(files) {
        fs::write(desk.path().join(format!("{file}.json")), block.split("```").next().unwrap()).unwrap();
    }
    let real = played(&text, desk.path());
    if std::env::var("UPDATE").is_ok_and(|value| value == "1") {
        fs::write(&guide, &real).unwrap();
    }
    assert!(text == real || std::env::var("UPDATE").is_ok(), "the guide differs; UPDATE=1 rewrites it:\n{real}");
    assert!(real.contains("consistent: {payload-voltage} or {gimbal-follows}"), "{real}");
}
