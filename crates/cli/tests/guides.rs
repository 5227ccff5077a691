//! Guides show what really happens: every `console` block is run and compared. `UPDATE=1` rewrites them.

#![allow(clippy::unwrap_used, reason = "a guide that cannot be played is a failed test")]

mod common;

use common::missions;
use std::fs;
use std::path::Path;
use std::process::Command;

/// Runs the commands of `text` in `folder` and returns the text with their real outputs. The outputs of `--json` reports are
/// left out: they are for programs.
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
        page.push_str(&output(command.strip_prefix("$ apex ").unwrap(), folder));
        while lines.next_if(|line| *line != "```").is_some() {}
    }
    page
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

#[test]
fn the_guide_to_asking_why_shows_what_is_answered() {
    let desk = tempfile::TempDir::new().unwrap();
    let mission = desk.path().join("missions/first-picture");
    fs::create_dir_all(&mission).unwrap();
    for file in fs::read_dir(missions().join("first-picture")).unwrap() {
        let file = file.unwrap();
        fs::copy(file.path(), mission.join(file.file_name())).unwrap();
    }
    let guide = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/guides/asking-why.md");
    let text = fs::read_to_string(&guide).unwrap();
    let real = played(&text, desk.path());
    if std::env::var("UPDATE").is_ok_and(|value| value == "1") {
        fs::write(&guide, &real).unwrap();
    }
    assert!(text == real || std::env::var("UPDATE").is_ok(), "the guide differs; UPDATE=1 rewrites it:\n{real}");
    assert!(real.contains("(calibration-due camera-1) came from outside") && real.contains("Near it are"), "{real}");
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
