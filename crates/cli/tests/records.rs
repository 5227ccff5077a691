//! Flight records that cannot be written, are incomplete, were modified, or are other files.

#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "a test that cannot prepare its files has failed")]

mod common;

use common::{Desk, mission};
use std::fs;
use std::process::Command;

#[test]
fn other_files_are_never_overwritten() {
    let desk = Desk::with_greetings();
    let program = desk.read("greetings.pdl");
    fs::create_dir(desk.path("folder")).unwrap();
    let mission = mission("first-picture");
    let fly = |record: &str| desk.apex(&["fly", &mission, "--no-progress", "--record", record]);
    fly("greetings.pdl").complained(2, &["greetings.pdl is not a flight record", "left as it is"]);
    fly("folder").complained(2, &["folder is not a flight record", "it is a folder"]);
    fly("greetings.pdl/f.apex").complained(2, &["greetings.pdl/f.apex", "greetings.pdl is not a folder"]);
    fly("no/such/f.apex").complained(2, &["no/such/f.apex", "there is no folder no/such", "help: make the folder"]);
    let run = desk.apex(&["run", "greetings.pdl", "--record", "greetings.pdl"]);
    run.complained(2, &["greetings.pdl is not a flight record"]);
    assert_eq!(desk.read("greetings.pdl"), program);
    assert_eq!(desk.names(), ["folder", "go.jsonl", "greetings.pdl"]);
}

#[cfg(unix)]
#[test]
fn devices_and_pipes_are_refused_and_stay() {
    use std::os::unix::fs::FileTypeExt;
    let desk = Desk::with_greetings();
    assert!(Command::new("mkfifo").arg(desk.path("pipe")).status().unwrap().success());
    for record in ["pipe", "/dev/null"] {
        let said = desk.apex(&["run", "greetings.pdl", "--record", record]);
        said.complained(2, &["is not a flight record", "not an ordinary file"]);
        for command in ["trace", "replay", "serve"] {
            desk.apex(&[command, record]).complained(2, &["is not a flight record", "not an ordinary file"]);
        }
    }
    assert!(fs::metadata(desk.path("pipe")).unwrap().file_type().is_fifo());
    assert!(fs::metadata("/dev/null").unwrap().file_type().is_char_device());
}

#[test]
fn what_is_not_a_record_is_reported_by_every_command() {
    let desk = Desk::with_flight();
    desk.write("notes.apex", "not a record");
    desk.write("empty.apex", "");
    for command in [&["replay"][..], &["trace"], &["serve"]] {
        let apex = |file: &str| desk.apex(&[command, &[file]].concat());
        apex("notes.apex").complained(2, &["notes.apex is not a flight record", "help: give a file that `apex fly`"]);
        apex("empty.apex").complained(2, &["empty.apex is not a flight record", "it is empty"]);
        apex("fligth.apex")
            .complained(2, &["there is no flight record at fligth.apex", "this folder holds flight.apex"]);
    }
    desk.apex(&["why", "notes.apex", "T1"]).complained(2, &["notes.apex is not a flight record"]);
    assert_eq!(desk.read("notes.apex"), "not a record");
}

#[test]
fn a_record_cut_in_half_is_damaged_and_no_panic() {
    let desk = Desk::with_flight();
    let bytes = fs::read(desk.path("flight.apex")).unwrap();
    fs::write(desk.path("half.apex"), &bytes[..bytes.len() / 2]).unwrap();
    for command in [&["replay", "half.apex"][..], &["why", "half.apex", "T2"], &["trace", "half.apex"]] {
        let said = desk.apex(command);
        assert!(matches!(said.code, Some(1 | 2)), "{said:?}");
        said.complained_of(&["half.apex", "damaged"]);
    }
}

#[test]
fn a_tampered_record_is_refused_by_every_command_and_verify_says_where() {
    let desk = Desk::with_flight();
    desk.apex(&["verify", "flight.apex"])
        .told(&["Integrity: ", "are as they were written; the file is as it was closed"]);
    let intact = desk.apex(&["verify", "flight.apex", "--json"]).json_lines();
    assert_eq!((&intact[0]["integrity"]["intact"], &intact[0]["integrity"]["file"]), (&true.into(), &"intact".into()));
    let path = desk.path("flight.apex");
    let bytes = fs::read(&path).unwrap();
    let program = replaced(&bytes, b"(priority 5))", b"(priority 0))");
    assert_ne!(program, bytes, "the program is in the record");
    fs::write(&path, program).unwrap();
    for command in [
        &["replay", "flight.apex"][..],
        &["trace", "flight.apex"],
        &["why", "flight.apex", "T2"],
        &["why-not", "flight.apex", "T2"],
        &["score", "flight.apex"],
        &["export", "flight.apex"],
        &["serve", "flight.apex"],
    ] {
        let said = desk.apex(command);
        assert!(said.out.is_empty(), "{command:?}: {}", said.out);
        said.complained(2, &["flight.apex is damaged: group ", "is not as it was written", "`apex recover`"]);
    }
    let said = desk.apex(&["verify", "flight.apex"]);
    said.complained(1, &["cannot be trusted as a whole"]).told(&["Integrity: damaged; group "]);
    let json = desk.apex(&["verify", "flight.apex", "--json"]).json_lines();
    assert_eq!(json[0]["integrity"]["intact"], false);
    assert!(json[0]["integrity"]["damage"]["group"].as_i64().unwrap() > 0, "{}", json[0]);
}

#[test]
fn what_can_be_trusted_is_recovered_into_a_new_record() {
    let desk = Desk::with_flight();
    let path = desk.path("flight.apex");
    let bytes = fs::read(&path).unwrap();
    // The last group contains the report; the groups before it contain the flight.
    let forged = replaced(&bytes, b"\"reason\"", b"\"wish!!\"");
    assert_ne!(forged, bytes, "the report is in the record");
    fs::write(&path, &forged).unwrap();
    let said = desk.apex(&["recover", "flight.apex"]);
    said.complained(0, &["warning: flight.apex: group "]).told(&["steps up to", "are saved in flight-recovered.apex"]);
    assert_eq!(fs::read(&path).unwrap(), forged, "the old record stays as it is");
    let said = desk.apex(&["replay", "flight-recovered.apex"]);
    said.complained(0, &["flight-recovered.apex is incomplete"]).told(&["The record is confirmed"]);
    desk.apex(&["recover", "flight.apex"]).complained(2, &["flight-recovered.apex already exists", "`--out`"]);
}

#[test]
fn names_that_are_not_files_are_refused() {
    let desk = Desk::new();
    let mission = mission("first-picture");
    for name in [":memory:", "file:flight.apex", "file::memory:?cache=shared"] {
        let said = desk.apex(&["fly", &mission, "--no-progress", "--record", name]);
        said.complained(2, &["the flight record cannot be", "SQLite does not use this name", "./flight.apex"]);
    }
}

#[test]
fn a_record_of_another_version_is_reported_as_such() {
    let desk = Desk::with_flight();
    let path = desk.path("flight.apex");
    let bytes = fs::read(&path).unwrap();
    let mut newer = bytes;
    newer[60..64].copy_from_slice(&99_u32.to_be_bytes());
    fs::write(&path, newer).unwrap();
    desk.apex(&["replay", "flight.apex"]).complained(2, &["version 99 of the record format", "use a newer Apex"]);
}

/// Returns `bytes` with every `from` replaced by `to` of the same length.
fn replaced(bytes: &[u8], from: &[u8], to: &[u8]) -> Vec<u8> {
    assert_eq!(from.len(), to.len());
    let mut bytes = bytes.to_vec();
    let found: Vec<usize> =
        (0..bytes.len().saturating_sub(from.len())).filter(|at| bytes[*at..].starts_with(from)).collect();
    for at in found {
        bytes[at..at + from.len()].copy_from_slice(to);
    }
    bytes
}

/// A killed flight leaves a record that is marked as incomplete and that still explains its contents.
#[test]
fn a_flight_that_was_cut_off_is_marked_incomplete() {
    let desk = Desk::new();
    let mission = mission("first-picture");
    let mut child = desk
        .command(&["fly", &mission, "--record", "cut.apex", "--no-progress", "--pace", "20"])
        .stdout(std::process::Stdio::null())
        .spawn()
        .unwrap();
    let began = std::time::Instant::now();
    while !desk.apex(&["trace", "cut.apex", "--type", "command"]).out.contains("take off") {
        assert!(began.elapsed().as_secs() < 60, "the flight does not begin");
        assert!(child.try_wait().unwrap().is_none(), "the flight ends early");
        std::thread::sleep(std::time::Duration::from_millis(50));
    }
    let second = desk.apex(&["fly", &mission, "--record", "cut.apex", "--no-progress"]);
    second.complained(1, &["cut.apex cannot be replaced", "another run of apex", "`--record`"]);
    child.kill().unwrap();
    child.wait().unwrap();
    let warning = "warning: The flight record cut.apex is incomplete";
    desk.apex(&["trace", "cut.apex", "--type", "created"]).complained(0, &[warning]).told(&["take off to 40m"]);
    desk.apex(&["why", "cut.apex", "T1"]).complained(0, &[warning]).told(&["T1 (take off to 40m)"]);
    desk.apex(&["replay", "cut.apex"]).complained(0, &[warning]).told(&["The record is confirmed"]);
}

#[cfg(target_os = "linux")]
#[test]
fn output_on_a_full_disk_is_a_failure_and_no_panic() {
    let desk = Desk::with_flight();
    desk.write("p.pdl", common::GREETINGS);
    let commands: [&[&str]; 11] = [
        &["--help"],
        &["fly", "--help"],
        &["--version"],
        &["check", "p.pdl"],
        &["fmt", "-"],
        &["run", "p.pdl"],
        &["run", "p.pdl", "--trace", "/dev/full"],
        &["why", "flight.apex", "T2"],
        &["trace", "flight.apex"],
        &["replay", "flight.apex"],
        &["fly", &mission("first-picture"), "--json", "--until", "1"],
    ];
    for arguments in commands {
        let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
        let program = fs::File::open(desk.path("p.pdl")).unwrap();
        let output = desk.command(arguments).stdin(program).stdout(full).output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1), "{arguments:?}: {said}");
        assert!(said.contains("No space left on device") && !said.contains("panicked"), "{arguments:?}: {said}");
    }
}

/// Needs the right to mount a file system; without it there is no small disk to fill, and the runtime's tests fill a file instead.
#[cfg(target_os = "linux")]
#[test]
fn a_flight_outlives_a_full_disk_and_leaves_nothing_that_passes_for_whole() {
    let desk = Desk::new();
    let small = Small::mount(&desk, "200k");
    let Some(small) = small else { return };
    let mission = mission("first-picture");
    let fly = ["fly", &*mission, "--no-progress", "--record", "small/f.apex"];
    desk.apex(&fly).complained(1, &["the disk is full", "small/f.apex", "free some space"]);
    let warning = "warning: The flight record small/f.apex is incomplete";
    desk.apex(&["trace", "small/f.apex"]).complained(0, &[warning]);
    desk.apex(&["replay", "small/f.apex"]).complained_of(&[warning]);
    drop(small);
    let tiny = Small::mount(&desk, "8k");
    desk.apex(&fly).complained(1, &["cannot be begun", "the disk is full", "no record is left"]);
    desk.apex(&["fly", &*mission, "--no-progress", "--record", "whole.apex"]).well();
    let recover = ["recover", "whole.apex", "--out", "small/r.apex"];
    desk.apex(&recover).complained(1, &["the disk is full", "small/r.apex"]);
    assert_eq!(fs::read_dir(desk.path("small")).unwrap().count(), 0);
    drop(tiny);
}

/// A small disk in memory at `small`.
struct Small {
    at: std::path::PathBuf,
}

impl Small {
    fn mount(desk: &Desk, size: &str) -> Option<Small> {
        let at = desk.path("small");
        fs::create_dir_all(&at).unwrap();
        let size = format!("size={size}");
        let mounted = Command::new("mount").args(["-t", "tmpfs", "-o", &size, "none"]).arg(&at).output();
        mounted.is_ok_and(|output| output.status.success()).then_some(Small { at })
    }
}

impl Drop for Small {
    fn drop(&mut self) {
        let unmounted = Command::new("umount").arg(&self.at).status();
        assert!(unmounted.is_ok_and(|status| status.success()), "{} stays mounted", self.at.display());
    }
}

#[test]
fn a_signed_record_names_its_key_and_forgeries_are_found() {
    let desk = Desk::new();
    desk.write("flight.key", &format!("{}\n", "5a".repeat(32)));
    let fly = ["fly", &mission("first-picture"), "--until", "20", "--no-progress", "--record", "f.apex"];
    desk.apex(&[&fly[..], &["--sign", "flight.key"]].concat()).well();
    let said = desk.apex(&["verify", "f.apex"]).well();
    let key = said.out.split("valid, by key ").nth(1).unwrap().split_whitespace().next().unwrap().to_string();
    assert_eq!(key.len(), 64, "{}", said.out);
    desk.apex(&["verify", "f.apex", "--signer", &key]).well();
    desk.apex(&["verify", "f.apex", "--signer", &"0".repeat(64)]).complained(1, &["is not signed by", &key]);
    // Without its signature file, the record names the key whose signature is missing.
    fs::rename(desk.path("f.apex.sig"), desk.path("elsewhere")).unwrap();
    desk.apex(&["verify", "f.apex"]).complained(1, &["the signature of f.apex is invalid", "f.apex.sig"]);
    for reader in ["score", "trace", "replay"] {
        desk.apex(&[reader, "f.apex"]).complained(0, &["The signature of the flight record f.apex is invalid"]);
    }
    // The signature of another flight is invalid for this record.
    desk.apex(&[&fly[..], &["--sign", "flight.key", "--seed", "9"]].concat()).well();
    fs::rename(desk.path("elsewhere"), desk.path("f.apex.sig")).unwrap();
    desk.apex(&["verify", "f.apex"]).complained(1, &["the record is not as it was signed"]);
    desk.apex(&["score", "f.apex"]).complained(0, &["the record is not as it was signed"]);
    // The seal of the file is what was signed: a file that does not match it is not the signed one.
    desk.apex(&[&fly[..], &["--sign", "flight.key"]].concat()).well();
    let mut bytes = fs::read(desk.path("f.apex")).unwrap();
    bytes[99] ^= 1; // the version of SQLite in the header
    fs::write(desk.path("f.apex"), bytes).unwrap();
    desk.apex(&["verify", "f.apex"])
        .complained(1, &["the signature of f.apex is invalid", "changed after it was closed"]);
    desk.apex(&fly).well();
    desk.apex(&["verify", "f.apex"]).well().told(&["Signature: none"]);
    desk.apex(&["verify", "f.apex", "--signer", &key]).complained(1, &["it is not signed"]);
    desk.write("bad.key", "secret");
    desk.apex(&[&fly[..], &["--sign", "bad.key"]].concat())
        .complained(2, &["bad.key is not a signing key", "openssl rand -hex 32"]);
}
