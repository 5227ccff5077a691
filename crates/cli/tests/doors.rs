//! The doors of a run refuse what only Apex says and what they cannot read, and records that were changed are not confirmed.

#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "a test stops at an unexpected result")]

mod common;

use common::Desk;
use std::io::Write;
use std::process::{Command, Stdio};

const BALLOON: &str = "(defapplication \"Balloon\" :type foreign-sim :agents ((agent balloonist :initial-task (ride))))
(procedure :sequential (index (ride)) (step up (burn until 300m)) (step on (look around)) (step tell (inform (landed))))
(primitive (index (burn until ?height)) (on-start (command (burn-until ?height))))
(primitive (index (look around)) (duration 1h))
";

/// Sends lines to a run at the clock of a simulator; returns its answers without the greeting.
fn answers(desk: &Desk, arguments: &[&str], lines: &[&[u8]]) -> Vec<String> {
    desk.write("balloon.pdl", BALLOON);
    let mut command = desk.command(&[&["run", "balloon.pdl"], arguments].concat());
    let mut run = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut input = run.stdin.take().unwrap();
    let bytes: Vec<u8> = lines.iter().flat_map(|line| [*line, b"\n"].concat()).collect();
    let writer = std::thread::spawn(move || input.write_all(&bytes).unwrap());
    let output = run.wait_with_output().unwrap();
    writer.join().unwrap();
    String::from_utf8(output.stdout).unwrap().lines().skip(1).map(str::to_string).collect()
}

#[test]
fn a_line_of_a_simulator_is_refused_as_a_whole() {
    let desk = Desk::new();
    let long = [" ".repeat((1 << 20) + 1).as_bytes(), b"{\"advance\": 50}"].concat();
    let told = answers(
        &desk,
        &[],
        &[
            &long,
            b"{\"advance\": 1, \"inputs\": [{\"event\": \"(a \xff)\"}]}",
            b"{\"advance\": 2, \"inputs\": [{\"event\": \"(operator-command 5)\"}]}",
            b"{\"advance\": 3, \"inputs\": [{\"event\": \"(requirement-at-risk energy)\"}]}",
            b"  ",
            b"{\"advance\": 4}",
        ],
    );
    assert_eq!(told.len(), 6, "one answer for each line: {told:?}");
    for (answer, part) in told.iter().zip([
        "longer than 1048576 bytes",
        "not UTF-8",
        "only Apex sends the message",
        "only Apex sends the message",
        "the line is empty",
        "\"t\":4",
    ]) {
        assert!(answer.contains(part), "{part}: {told:?}");
    }
}

#[test]
fn the_first_answer_to_a_command_counts() {
    let desk = Desk::new();
    let lines: [&[u8]; 4] = [
        b"{\"advance\": 1}",
        b"{\"advance\": 2, \"inputs\": [{\"acknowledge\": 0}, {\"acknowledge\": 0, \"error\": \"duplicate\"}, {\"event\": \"(a)\"}, {\"event\": \"(b)\"}]}",
        b"{\"advance\": 3, \"inputs\": [{\"acknowledge\": 0, \"error\": \"late\"}]}",
        b"{\"stop\": true}",
    ];
    answers(&desk, &["--record", "b.apex"], &lines);
    let trace = desk.apex(&["trace", "b.apex"]).well().out.clone();
    assert!(trace.contains("burn until 300m") && !trace.contains("(failure)"), "{trace}");
    for reason in ["duplicate", "late"] {
        let note = format!("command 0 has ended (done): the later answer (failed: {reason}) is ignored");
        assert!(trace.contains(&note), "{note}: {trace}");
    }
    let place = |event: &str| trace.find(event).unwrap();
    assert!(place("event (a)") < place("event (b)"), "inputs of one instant keep their order: {trace}");
    desk.apex(&["replay", "b.apex"]).well().told(&["The record is confirmed"]);
}

#[test]
fn scripts_may_not_forge_the_log_of_commands() {
    let desk = Desk::with_greetings();
    for event in ["(operator-command 5 \\\"stop\\\" accepted)", "(live-source nav gone)", "(recording-lost fake)"] {
        desk.write("in.jsonl", &format!("{{\"t\": 1, \"event\": \"{event}\"}}\n"));
        desk.apex(&["run", "greetings.pdl", "--inputs", "in.jsonl"]).complained(2, &["in.jsonl:1", "only Apex sends"]);
    }
}

/// Changes a fact of a closed record and makes the seal of the file again, as its page describes it.
const FORGE: &str = "
import hashlib, sqlite3, struct, sys
path, sql = sys.argv[1:]
data = open(path, 'rb').read()
open(path, 'wb').write(data[:-64])
db = sqlite3.connect(path)
db.execute(sql)
db.commit()
db.close()
data = open(path, 'rb').read()
seal = b'apex record file seal 1\\n' + struct.pack('<q', len(data)) + hashlib.sha256(data).digest()
assert len(seal) == 64
open(path, 'wb').write(data + seal)
";

#[test]
fn a_record_with_broken_chains_is_not_confirmed() {
    let desk = Desk::new();
    answers(&desk, &["--record", "b.apex"], &[b"{\"advance\": 1}", b"{\"stop\": true}"]);
    desk.apex(&["replay", "b.apex"]).well();
    let forge = ["-c", FORGE, "b.apex", "update meta set value = '9.9.9' where key = 'apex_version'"];
    let forged = Command::new("python3").args(forge).current_dir(desk.path(".")).output().unwrap();
    assert!(forged.status.success(), "{forged:?}");
    desk.apex(&["verify", "b.apex"]).complained(1, &["cannot be trusted as a whole"]);
    desk.apex(&["replay", "b.apex"]).complained(1, &["cannot be confirmed", "apex verify b.apex"]);
}
