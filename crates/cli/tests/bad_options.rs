//! Invalid options are reported before anything is changed, with exit code 2.

mod common;

use common::{Desk, mission};
use std::net::TcpListener;

#[test]
fn nothing_and_nonsense_are_answered_with_the_usage() {
    let desk = Desk::new();
    desk.apex(&[]).complained(2, &["Usage: apex <COMMAND>", "check", "serve"]);
    desk.apex(&["flyy"]).complained(2, &["'flyy'", "'fly'"]);
    desk.apex(&["fly"]).complained(2, &["<MISSION>"]);
    desk.apex(&["fly", "x", "--sped", "3"]).complained(2, &["'--sped'"]);
    desk.apex(&["help", "fly"]).well().told(&["--until", "--record", "--pace"]);
    desk.apex(&["--version"]).well().told(&["apex "]);
}

#[test]
fn impossible_paces_and_times_leave_an_older_record_alone() {
    let desk = Desk::with_flight();
    let before = std::fs::read(desk.path("flight.apex")).unwrap();
    let mission = mission("first-picture");
    let fly = |more: &[&str]| desk.apex(&[&["fly", &mission, "--record", "flight.apex"], more].concat());
    for pace in ["0", "-1", "NaN", "inf"] {
        fly(&["--pace", pace]).complained(2, &["is invalid", "1 is real time"]);
    }
    fly(&["--pace", "fast"]).complained(2, &["'fast'", "--pace"]);
    for until in ["NaN", "inf", "soon", "3kg", "1:2:3:4"] {
        fly(&["--until", until]).complained(2, &[&format!("`--until {until}` is not a time"), "P1M30S"]);
    }
    fly(&["--until", "-1"]).complained(2, &["`--until -1` is before the start", "begins at 0"]);
    fly(&["--until", "-20s"]).complained(2, &["`--until -20s` is before the start"]);
    fly(&["--seed", "-3"]).complained(2, &["--seed"]);
    fly(&["--port", "70000"]).complained(2, &["70000", "--port"]);
    fly(&["--port", "8041"]).complained(2, &["--serve"]);
    fly(&["--runs", "2", "--paused"]).complained(2, &["--runs", "--paused"]);
    assert_eq!(std::fs::read(desk.path("flight.apex")).unwrap(), before);
}

#[test]
fn a_time_limit_of_zero_is_a_flight_of_one_instant() {
    let desk = Desk::new();
    let said = desk.apex(&["fly", &mission("first-picture"), "--until", "0", "--no-progress"]).well();
    said.told(&["ended at 0s because the time limit was reached", "0 s of flight"]);
}

#[test]
fn a_port_in_use_is_reported_before_the_flight() {
    let desk = Desk::with_flight();
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().port().to_string();
    let phrases = [&*format!("cannot serve on 127.0.0.1:{port}"), "use", "choose another", "`--port`"];
    desk.apex(&["serve", "flight.apex", "--port", &port]).complained(1, &phrases);
    let arguments = ["fly", &mission("first-picture"), "--serve", "--port", &port, "--record", "new.apex"];
    desk.apex(&arguments).complained(1, &phrases);
    assert_eq!(desk.names(), ["flight.apex"], "nothing was flown");
}

#[test]
fn an_address_must_be_one() {
    let desk = Desk::with_flight();
    let said = desk.apex(&["serve", "flight.apex", "--address", "here"]);
    said.complained(2, &["`--address here` is not an address", "127.0.0.1"]);
    // An address of the documentation range never belongs to this machine.
    let said = desk.apex(&["serve", "flight.apex", "--address", "192.0.2.1", "--port", "0"]);
    said.complained(1, &["cannot serve on 192.0.2.1:0", "--address"]);
}
