//! The API over real HTTP, on a record that is complete, one that grows, and files that are not records.

#![allow(clippy::unwrap_used, clippy::indexing_slicing)]

mod flight;

use apex_model::source::SourceFile;
use apex_runtime::record::RestoredProgram;
use apex_server::{AccessOptions, ServeError, ServeOptions, serve};
use flight::Writer;
use flight::story::Story;
use serde_json::{Value, json};
use std::io::{Read, Write};
use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::path::Path;
use std::sync::{Arc, mpsc};

/// Represents a command that cannot load the recorded sources.
fn unloadable(_: &[SourceFile]) -> Result<RestoredProgram, String> {
    Err("the sources are not PDL".into())
}

fn options(record: &Path) -> ServeOptions {
    ServeOptions {
        record: Some(record.into()),
        agent: 0,
        address: IpAddr::V4(Ipv4Addr::LOCALHOST),
        port: 0,
        load: Some(Arc::new(unloadable)),
        door: None,
        access: AccessOptions::default(),
        others: Vec::new(),
        what_if: None,
        flights: None,
        ready: Box::new(|_| ()),
    }
}

/// Serves on a thread that ends with the test program.
fn start(record: &Path) -> SocketAddr {
    start_with(options(record))
}

fn start_with(mut options: ServeOptions) -> SocketAddr {
    let (sender, receiver) = mpsc::channel();
    options.ready = Box::new(move |url| sender.send(url.to_owned()).unwrap());
    std::thread::spawn(move || serve(options).unwrap());
    let url = receiver.recv().unwrap();
    url.trim_start_matches("http://").trim_end_matches('/').parse().unwrap()
}

fn request(server: SocketAddr, path: &str, host: &str, more: &str) -> (u16, String) {
    let mut stream = TcpStream::connect(server).unwrap();
    write!(stream, "GET {path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n{more}\r\n").unwrap();
    let mut answer = Vec::new();
    stream.read_to_end(&mut answer).unwrap();
    let answer = String::from_utf8_lossy(&answer).into_owned();
    let status = answer.split(' ').nth(1).unwrap().parse().unwrap();
    let body = answer.split_once("\r\n\r\n").unwrap().1.to_owned();
    (status, body)
}

fn get(server: SocketAddr, path: &str) -> (u16, Value) {
    let (status, body) = request(server, path, &server.to_string(), "");
    (status, serde_json::from_str(&body).unwrap_or(Value::String(body)))
}

fn complete_record() -> (tempfile::TempDir, SocketAddr, Story) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("flight.apex");
    let story = flight::write_complete(&path);
    let server = start(&path);
    (folder, server, story)
}

#[test]
fn a_complete_record_tells_its_mission() {
    let (_folder, server, story) = complete_record();
    let (status, mission) = get(server, "/api/mission");
    assert_eq!(status, 200);
    assert_eq!(mission["mission"], "western-states");
    assert_eq!(mission["status"], "complete");
    assert_eq!(mission["end_ns"], story.end_ns());
    assert_eq!(mission["from_ns"], 0);
    assert_eq!((&mission["score"], &mission["observed"]), (&json!(0.87), &json!(9)));
    assert_eq!(mission["ending"], json!({"reason": "the root task ended", "failed": false}));
    assert_eq!(mission["record"], "flight.apex");
    let (_, report) = get(server, "/api/report");
    assert_eq!(report["sections"][1]["body"]["skipped"], 1);
}

#[test]
fn the_end_is_unknown_before_it() {
    let (_folder, server, story) = complete_record();
    let before = story.end_ns() - 1;
    let (_, mission) = get(server, &format!("/api/mission?at={before}"));
    assert_eq!((&mission["score"], &mission["ending"]), (&Value::Null, &Value::Null));
    assert_eq!(get(server, &format!("/api/report?at={before}")).1["sections"], json!([]));
    let (_, troubles) = get(server, &format!("/api/troubles?at={}", story.end_ns())); // english: allow
    let rows = troubles["troubles"].as_array().unwrap(); // english: allow
    let kinds: Vec<&str> = rows.iter().map(|row| row["kind"].as_str().unwrap()).collect();
    assert_eq!(kinds, ["interrupted", "failed", "failed", "left-out"]);
    assert_eq!(get(server, "/api/troubles?at=0").1["troubles"], json!([])); // english: allow
    assert_eq!(get(server, "/api/plan").1, Value::Null);
    assert_eq!(get(server, "/api/surroundings").1, json!({"zones": [], "landing_places": []}));
}

#[test]
fn the_track_is_thinned_and_keeps_its_ends() {
    let (_folder, server, story) = complete_record();
    let (_, track) = get(server, "/api/track?points=100");
    let times = track["t_ns"].as_array().unwrap();
    assert!(times.len() <= 100 && times.len() >= 50, "{}", times.len());
    assert_eq!(times.first().unwrap(), 0);
    assert_eq!(times.last().unwrap(), story.end_ns());
    assert_eq!(track["recorded"], story.samples.len());
    assert_eq!(track["latitude_deg"].as_array().unwrap().len(), times.len());
    for (points, most) in [(0, 2), (2, 2), (3, 3), (7, 7)] {
        let (_, track) = get(server, &format!("/api/track?points={points}"));
        let times = track["t_ns"].as_array().unwrap();
        assert!(times.len() <= most && times.len() >= 2, "{points} points: {} rows", times.len());
        assert_eq!((times.first(), times.last()), (Some(&0.into()), Some(&story.end_ns().into())), "{points}");
    }
}

#[test]
fn tasks_have_the_states_of_the_instant_asked_for() {
    let (_folder, server, story) = complete_record();
    let state = |at: i64, task: u64| {
        let (_, answer) = get(server, &format!("/api/tasks?at={at}"));
        let tasks = answer["tasks"].as_array().unwrap().clone();
        tasks.iter().find(|row| row["id"] == task).map(|row| row["state"].clone())
    };
    assert_eq!(state(0, 1), Some("ongoing".into()));
    assert_eq!(state(0, 4), Some("pending".into()));
    assert_eq!(state(story.end_ns(), 1), Some("terminated".into()));
    assert_eq!(state(-1, 1), None);

    let (_, all) = get(server, "/api/tasks");
    assert_eq!(all["at_ns"], story.end_ns(), "without `at` the instant is the end of the record");
    let (_, few) = get(server, "/api/tasks?limit=3");
    let left = few["left_out"].as_u64().unwrap() as usize;
    assert_eq!(left + 3, all["tasks"].as_array().unwrap().len());
    let (_, found) = get(server, "/api/tasks?find=SCAN-LINES%20ZACA");
    let goals: Vec<&str> = found["tasks"].as_array().unwrap().iter().map(|row| row["goal"].as_str().unwrap()).collect();
    assert_eq!(goals, ["(fly-mission plan-7)", "(survey plan-7)", "(observe zaca)", "(scan-lines zaca)"]);
    let (_, ongoing) = get(server, &format!("/api/tasks?ended=false&at={}", story.end_ns()));
    assert!(ongoing["tasks"].as_array().unwrap().iter().all(|row| row["state"] != "terminated"));
}

#[test]
fn the_timeline_keeps_a_repeated_step_in_one_lane() {
    let (_folder, server, _) = complete_record();
    let (_, timeline) = get(server, "/api/timeline?lanes=100");
    let lanes = timeline["lanes"].as_array().unwrap();
    assert_eq!(lanes[0]["goal"], "(fly-mission plan-7)");
    let line = lanes.iter().find(|lane| lane["tag"] == "line").unwrap();
    assert_eq!(line["tasks"], 4);
    assert_eq!(line["depth"], 4);
    let (_, few) = get(server, "/api/timeline?lanes=5");
    assert_eq!(few["lanes"].as_array().unwrap().len(), 5);
    assert_eq!(few["more"]["lanes"].as_u64().unwrap() as usize + 5, lanes.len());
}

#[test]
fn events_are_the_last_of_the_time_asked_for() {
    let (_folder, server, story) = complete_record();
    let (_, events) = get(server, &format!("/api/events?to={}&limit=2", story.end_ns()));
    let rows = events["events"].as_array().unwrap();
    assert_eq!(rows.len(), 2);
    assert_eq!(rows[1]["outcome"], "success");
    assert_eq!(events["more"], true);
    let (_, solved) = get(server, "/api/events?kind=solve,print&find=2-opt");
    assert_eq!(solved["events"].as_array().unwrap().len(), 1);
}

#[test]
fn why_gives_the_decisions_in_order_and_the_error_of_restoring() {
    let (_folder, server, story) = complete_record();
    let (status, why) = get(server, &format!("/api/why?task=1&at={}", story.end_ns()));
    assert_eq!(status, 200);
    let moment =
        |moment: &Value| (moment["kind"].as_str().unwrap().to_owned(), moment["to"].as_str().map(str::to_owned));
    let moments: Vec<_> = why["explanation"]["history"].as_array().unwrap().iter().map(moment).collect();
    let to = |state: &str| ("transition".to_owned(), Some(state.to_owned()));
    let selected = ("selected".to_owned(), None);
    assert_eq!(moments, [("created".to_owned(), None), to("enabled"), selected, to("ongoing"), to("terminated")]);
    assert_eq!(why["now"], "T1 has ended (success) because all of its steps have ended");
    assert_eq!((&why["task"]["id"], &why["explanation"]["task"]), (&json!(1), &json!("T1")));
    assert_eq!(why["explanation_error"], Value::Null);
    // The restored agent explains a task that continues; if it cannot be restored, the decisions alone do.
    let middle = story.end_ns() / 2;
    let (_, full) = get(server, &format!("/api/why?task=1&at={middle}"));
    let error = full["explanation_error"].as_str().unwrap();
    assert!(error.contains("the sources are not PDL"), "{error}");
    assert_eq!(full["explanation"]["state"], "ongoing");
    let (_, quick) = get(server, &format!("/api/why?task=1&at={middle}&explain=false"));
    assert_eq!((&quick["explanation_error"], &quick["now"]), (&Value::Null, &full["now"]));
    let (_, source) = get(server, "/api/source?place=western-states.pdl:6:3");
    assert_eq!(source["lines"][2], "  (step s1 (take-off))");
}

#[test]
fn targets_have_the_state_of_the_instant_and_their_history() {
    let (_folder, server, story) = complete_record();
    let state = |at: i64, id: &str| {
        let (_, answer) = get(server, &format!("/api/targets?at={at}"));
        let targets = answer["targets"].as_array().unwrap().clone();
        targets.into_iter().find(|target| target["id"] == id).unwrap()
    };
    assert_eq!(state(0, "zaca")["state"], "planned");
    assert_eq!(state(story.end_ns(), "zaca")["state"], "observed");
    assert_eq!(state(story.end_ns(), "gw")["state"], "skipped");
    assert_eq!(state(0, "zaca")["history"].as_array().unwrap().len(), 1);
    assert_eq!(state(story.end_ns(), "zaca")["history"].as_array().unwrap().len(), 3);
}

#[test]
fn wrong_requests_are_told_what_to_do() {
    let (_folder, server, _) = complete_record();
    for (path, status) in [
        ("/api/tasks?at=noon", 400),
        ("/api/tasks?att=5", 400),
        ("/api/why?task=1", 400),
        ("/api/why?task=99999&at=0", 404),
        ("/api/why?task=4&at=-5", 404),
        ("/api/source?place=x", 400),
        ("/api/source?place=x:1:1", 404),
        ("/api/nothing", 404),
    ] {
        let (found, body) = get(server, path);
        assert_eq!(found, status, "{path}: {body}");
        assert!(body["error"].as_str().is_some_and(|text| !text.is_empty()), "{path}: {body}");
        assert!(body["help"].as_str().is_some_and(|text| !text.is_empty()), "{path}: {body}");
    }
}

#[test]
fn other_names_and_other_sites_are_refused() {
    let (_folder, server, _) = complete_record();
    assert_eq!(request(server, "/api/mission", "evil.example", "").0, 403);
    assert_eq!(request(server, "/api/mission", "localhost", "").0, 200);
    let upgrade = "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n\
                   Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nOrigin: https://evil.example\r\n";
    let mut stream = TcpStream::connect(server).unwrap();
    write!(stream, "GET /api/live HTTP/1.1\r\nHost: localhost\r\n{upgrade}\r\n").unwrap();
    let mut head = [0; 12];
    stream.read_exact(&mut head).unwrap();
    assert_eq!(&head, b"HTTP/1.1 403");
}

/// Reads text frames of a WebSocket that are shorter than 126 bytes.
fn next_text(stream: &mut TcpStream) -> Option<Value> {
    let mut head = [0; 2];
    stream.read_exact(&mut head).unwrap();
    let mut body = vec![0; usize::from(head[1] & 0x7f)];
    stream.read_exact(&mut body).unwrap();
    (head[0] == 0x81).then(|| serde_json::from_slice(&body).unwrap())
}

#[test]
fn a_growing_record_is_told_live_until_it_is_complete() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("flight.apex");
    let story = Story::western_states();
    let half = story.end_ns() / 2;
    let mut writer = Writer::new(&path, &story);
    writer.write(&story, i64::MIN, half);
    let server = start(&path);
    let (_, mission) = get(server, "/api/mission");
    assert_eq!(mission["status"], "live");
    let before = get(server, "/api/tasks").1["tasks"].as_array().unwrap().len();

    let mut stream = TcpStream::connect(server).unwrap();
    stream.set_read_timeout(Some(std::time::Duration::from_secs(20))).unwrap();
    write!(
        stream,
        "GET /api/live HTTP/1.1\r\nHost: {server}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n\
         Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
    )
    .unwrap();
    let mut head = Vec::new();
    while !head.ends_with(b"\r\n\r\n") {
        let mut byte = [0; 1];
        stream.read_exact(&mut byte).unwrap();
        head.push(byte[0]);
    }
    assert!(head.starts_with(b"HTTP/1.1 101"), "{}", String::from_utf8_lossy(&head));
    let first = next_text(&mut stream).unwrap();
    assert_eq!(first["status"], "live");
    assert!(first["end_ns"].as_i64().unwrap() < half);

    writer.write(&story, half, i64::MAX);
    writer.complete(&story);
    let last = std::iter::from_fn(|| next_text(&mut stream)).last().unwrap();
    assert_eq!(last["status"], "complete");
    assert_eq!(last["end_ns"], story.end_ns());
    let after = get(server, "/api/tasks").1["tasks"].as_array().unwrap().len();
    assert!(after > before, "{after} > {before}");
}

#[test]
fn a_record_without_a_writer_is_incomplete() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("flight.apex");
    let story = Story::western_states();
    Writer::new(&path, &story).write(&story, i64::MIN, story.end_ns() / 3);
    let long_ago = std::time::SystemTime::now() - std::time::Duration::from_secs(3_600);
    let file = std::fs::File::options().write(true).open(&path).unwrap();
    file.set_modified(long_ago).unwrap();
    let server = start(&path);
    assert_eq!(get(server, "/api/mission").1["status"], "incomplete");
}

/// The file of a record next to the served one is replaced before the first query about it.
#[test]
fn a_record_that_another_one_replaces_is_not_shown_as_the_old_one() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    for name in ["flight.apex", "other.apex", "kept.apex", "new.apex"] {
        flight::write_complete(&path(name));
    }
    let others = vec![path("other.apex"), path("kept.apex")];
    let server = start_with(ServeOptions { others, ..options(&path("flight.apex")) });
    std::fs::rename(path("new.apex"), path("other.apex")).unwrap();
    let (status, answer) = get(server, "/api/records/1/mission");
    assert_ne!(status, 200, "{answer}");
    assert!(answer["error"].as_str().is_some_and(|error| error.contains("other.apex")), "{answer}");
    assert_eq!(get(server, "/api/records/2/mission").0, 200);
}

#[test]
fn a_port_in_use_and_files_that_are_no_records_are_named() {
    let (folder, ..) = complete_record();
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let mut busy = options(&folder.path().join("flight.apex"));
    busy.port = taken.local_addr().unwrap().port();
    let error = serve(busy).unwrap_err();
    assert!(matches!(error, ServeError::PortInUse(_)));
    assert!(error.to_string().contains("--port"), "{error}");

    let missing = serve(options(&folder.path().join("none.apex"))).unwrap_err().to_string();
    assert!(missing.contains("there is no flight record at"), "{missing}");

    let text = folder.path().join("notes.apex");
    std::fs::write(&text, "these are notes, and more than a header of a hundred bytes long ".repeat(20)).unwrap();
    let foreign = serve(options(&text)).unwrap_err().to_string();
    assert!(
        foreign.contains("is not a flight record of Apex (its first bytes are not those of a record)"),
        "{foreign}"
    );

    let other = folder.path().join("other.apex");
    rusqlite::Connection::open(&other).unwrap().execute_batch("CREATE TABLE a (b)").unwrap();
    let foreign = serve(options(&other)).unwrap_err().to_string();
    assert!(
        foreign.contains("is not a flight record of Apex (it is an SQLite database of another program)"),
        "{foreign}"
    );
}

#[test]
fn other_paths_give_the_page_or_say_how_to_build_it() {
    let (_folder, server, _) = complete_record();
    let (status, page) = request(server, "/", &server.to_string(), "");
    assert_eq!(status, 200);
    assert!(page.contains("<html"), "{page}");
    assert_eq!(request(server, "/no-such-file.js", &server.to_string(), "").0, 404);
}
