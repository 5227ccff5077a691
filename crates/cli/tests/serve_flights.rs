//! A stopped server that flies missions ends its flights in an orderly way.

#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "a test that cannot start its program has failed")]

mod common;

use common::{Desk, missions};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Command, Stdio};

#[test]
fn a_server_that_is_stopped_closes_the_records_of_its_flights() {
    let desk = Desk::new();
    let folder = missions().display().to_string();
    let mut command = desk.command(&["serve", "--missions", &folder, "--port", "0"]);
    let mut server = command.stdout(Stdio::piped()).spawn().unwrap();
    let mut said = String::new();
    BufReader::new(server.stdout.take().unwrap()).read_line(&mut said).unwrap();
    let address = said.split("http://").nth(1).unwrap().split('/').next().unwrap();
    let mut stream = TcpStream::connect(address).unwrap();
    let body = "{\"mission\": \"first-picture\", \"pace\": 1}";
    let length = body.len();
    write!(
        stream,
        "POST /api/flights HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\nContent-Type: application/json\r\n\
         Content-Length: {length}\r\n\r\n{body}"
    )
    .unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    assert!(answer.starts_with("HTTP/1.1 201"), "{answer}");
    let stopped = Command::new("kill").args(["-TERM", &server.id().to_string()]).status().unwrap();
    assert!(stopped.success());
    assert!(server.wait().unwrap().success());
    desk.apex(&["replay", "first-picture-1.apex"]).well().told(&["The record is confirmed: "]);
    desk.apex(&["trace", "first-picture-1.apex"]).well().told(&["it was stopped from outside"]);
}

#[test]
fn folders_that_do_not_exist_are_reported_before_a_port_is_taken() {
    let desk = Desk::new();
    desk.apex(&["serve"]).complained(2, &["needs a flight record", "--missions"]);
    desk.apex(&["serve", "--missions", "nowhere"]).complained(2, &["`--missions nowhere` is not a folder", "help: "]);
    let folder = missions().display().to_string();
    let said = desk.apex(&["serve", "--missions", &folder, "--records", "nowhere"]);
    said.complained(2, &["`--records nowhere` is not a folder", "help: make the folder"]);
    desk.apex(&["serve", "--records", "."]).complained(2, &["--missions"]);
}
