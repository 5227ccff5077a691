//! Flights that the server flies, over real HTTP: list, plan, fly, report, replay, stop, and everything that is refused.

#![allow(clippy::unwrap_used, clippy::indexing_slicing)]

use apex_mission::Mission;
use apex_mission::deliberation::PlanningResources;
use apex_mission::flight::MissionFlight;
use apex_mission::recorded::replay;
use apex_model::time::Time;
use apex_runtime::record::RecordReader;
use apex_runtime::trace::{TraceFilter, TraceFormat, trace_record};
use apex_server::{AccessOptions, FlightOptions, ServeOptions, serve};
use serde_json::{Value, json};
use std::io::{Read, Write};
use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpStream};
use std::path::{Path, PathBuf};
use std::sync::{Arc, mpsc};
use std::time::Duration;

const JSON: &str = "Content-Type: application/json\r\n";

fn missions() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../missions")
}

fn read() -> apex_server::ReadDatum {
    Arc::new(|text| apex_pdl::read_value(text).map_err(|diagnostic| diagnostic.message))
}

fn means() -> PlanningResources {
    PlanningResources::of(&Arc::new(apex_solvers::shipped()))
}

/// Serves on a thread that ends with the test program; `missions: None` flies nothing.
fn start(missions: Option<PathBuf>, records: &Path, address: Ipv4Addr) -> SocketAddr {
    let (sender, receiver) = mpsc::channel();
    let options = ServeOptions {
        record: None,
        agent: 0,
        address: IpAddr::V4(address),
        port: 0,
        load: None,
        door: None,
        access: AccessOptions::default(),
        others: Vec::new(),
        what_if: None,
        flights: missions.map(|missions| FlightOptions {
            missions,
            records: records.into(),
            read: read(),
            means: means(),
        }),
        ready: Box::new(move |url| sender.send(url.to_owned()).unwrap()),
    };
    std::thread::spawn(move || serve(options).unwrap());
    let url = receiver.recv().unwrap();
    let bound: SocketAddr = url.trim_start_matches("http://").trim_end_matches('/').parse().unwrap();
    SocketAddr::from((Ipv4Addr::LOCALHOST, bound.port()))
}

fn ask(server: SocketAddr, method: &str, path: &str, headers: &str, body: &str) -> (u16, Value) {
    let mut stream = TcpStream::connect(server).unwrap();
    let length = body.len();
    write!(
        stream,
        "{method} {path} HTTP/1.1\r\nHost: {server}\r\nConnection: close\r\nContent-Length: {length}\r\n{headers}\r\n{body}"
    )
    .unwrap();
    let mut answer = Vec::new();
    stream.read_to_end(&mut answer).unwrap();
    let answer = String::from_utf8_lossy(&answer).into_owned();
    let status = answer.split(' ').nth(1).unwrap().parse().unwrap();
    let body = answer.split_once("\r\n\r\n").unwrap().1;
    (status, serde_json::from_str(body).unwrap_or(Value::String(body.to_owned())))
}

fn get(server: SocketAddr, path: &str) -> (u16, Value) {
    ask(server, "GET", path, "", "")
}

fn fly(server: SocketAddr, request: &Value) -> (u16, Value) {
    ask(server, "POST", "/api/flights", JSON, &request.to_string())
}

fn stop(server: SocketAddr, id: &Value) -> (u16, Value) {
    ask(server, "POST", &format!("/api/flights/{id}/stop"), "", "")
}

/// Polls until the flight is over.
fn ended(server: SocketAddr, id: &Value) -> Value {
    loop {
        let (status, flight) = get(server, &format!("/api/flights/{id}"));
        assert_eq!(status, 200, "{flight}");
        if flight["state"] != "flying" {
            return flight;
        }
        std::thread::sleep(Duration::from_millis(50));
    }
}

/// Returns every line of a record's trace.
fn trace(record: &Path) -> String {
    #[derive(Clone, Default)]
    struct Shared(Arc<std::sync::Mutex<Vec<u8>>>);
    impl Write for Shared {
        fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
            self.0.lock().unwrap().extend_from_slice(bytes);
            Ok(bytes.len())
        }
        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }
    let text = Shared::default();
    let reader = RecordReader::open(record).unwrap();
    trace_record(&reader, text.clone(), TraceFormat::JsonLines, TraceFilter::default()).unwrap();
    let bytes = text.0.lock().unwrap().clone();
    String::from_utf8(bytes).unwrap()
}

#[test]
fn a_flight_is_recorded_reported_and_equal_to_one_of_the_command() {
    let folder = tempfile::tempdir().unwrap();
    let server = start(Some(missions()), folder.path(), Ipv4Addr::LOCALHOST);
    std::fs::write(folder.path().join("structure-watch-1.apex"), "a record of another run").unwrap();
    let (status, flight) = fly(server, &json!({"mission": "structure-watch", "seed": 7, "until_s": 200}));
    assert_eq!(status, 201, "{flight}");
    assert_eq!((&flight["id"], &flight["state"], &flight["seed"]), (&json!(2), &json!("flying"), &json!(7)));
    let record = folder.path().join("structure-watch-2.apex");
    assert_eq!(flight["record"], record.display().to_string());
    let flight = ended(server, &flight["id"]);
    assert_eq!((&flight["state"], &flight["now_ns"]), (&json!("ended"), &json!(200_000_000_000_i64)), "{flight}");
    assert_eq!(flight["end_reason"], "the time limit was reached");
    let (status, report) = get(server, "/api/flights/2/report");
    assert_eq!((status, &report["sections"]), (200, &flight["sections"]));
    assert_eq!(report["sections"][0]["body"]["mission"], "Structure Watch");
    assert_eq!(get(server, "/api/flights").1["flights"], json!([flight]));
    assert_eq!(
        std::fs::read_to_string(folder.path().join("structure-watch-1.apex")).unwrap(),
        "a record of another run"
    );

    let reader = RecordReader::open(&record).unwrap();
    assert_eq!(reader.warning().unwrap(), None);
    let replayed = replay(&reader).unwrap();
    assert!(replayed.difference.is_none() && replayed.batches > 0, "{replayed}");

    let other = folder.path().join("command.apex");
    let mission = Arc::new(Mission::load(&missions().join("structure-watch")).unwrap());
    let mut recorder = apex_simulation::create_record(&other, &mission, Some(7)).unwrap();
    let terms = MissionFlight::terms(&mission, Some(Time::from_seconds(200.0)));
    apex_simulation::fly(mission, means(), Some(7), terms, &mut recorder, &mut []).unwrap();
    drop(recorder);
    let lines = trace(&record);
    assert!(lines.lines().count() > 100, "{lines}");
    assert!(lines == trace(&other), "the traces differ");
}

#[test]
fn flights_at_a_pace_are_stopped_and_counted() {
    let folder = tempfile::tempdir().unwrap();
    let server = start(Some(missions()), folder.path(), Ipv4Addr::LOCALHOST);
    let slow = json!({"mission": "first-picture", "pace": 1});
    let (first, second) = (fly(server, &slow).1, fly(server, &slow).1);
    let (status, refused) = fly(server, &slow);
    assert_eq!(status, 429, "{refused}");
    assert_eq!(refused["error"], "2 missions are being flown, which is the limit");
    assert_eq!(get(server, &format!("/api/flights/{}/report", first["id"])).0, 409);
    assert_eq!(stop(server, &first["id"]).0, 202);
    let flight = ended(server, &first["id"]);
    assert_eq!((&flight["state"], &flight["end_reason"]), (&json!("ended"), &json!("it was stopped from outside")));
    let reader = RecordReader::open(Path::new(flight["record"].as_str().unwrap())).unwrap();
    assert_eq!(reader.warning().unwrap(), None);
    assert!(replay(&reader).unwrap().difference.is_none());
    assert_eq!(stop(server, &first["id"]).0, 200);
    let (status, third) = fly(server, &slow);
    assert_eq!(status, 201, "{third}");
    for flight in [second, third] {
        stop(server, &flight["id"]);
        ended(server, &flight["id"]);
    }
}

#[test]
fn missions_are_listed_and_planned_and_broken_ones_are_explained() {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in [("broken", "(procedure (index"), ("no-mission", "(procedure (index (go)))")] {
        std::fs::create_dir(folder.path().join(name)).unwrap();
        std::fs::write(folder.path().join(name).join("mission.pdl"), text).unwrap();
    }
    let server = start(Some(folder.path().into()), folder.path(), Ipv4Addr::LOCALHOST);
    let (status, listed) = get(server, "/api/missions");
    assert_eq!(status, 200);
    let broken = &listed["missions"][0];
    assert_eq!((&broken["name"], &broken["loads"]), (&json!("broken"), &json!(false)), "{listed}");
    assert!(broken["failure"]["place"].as_str().unwrap().contains("mission.pdl:1:"), "{broken}");
    assert_eq!(listed["missions"].as_array().unwrap().len(), 2);
    let (status, refused) = fly(server, &json!({"mission": "broken"}));
    assert_eq!(status, 422, "{refused}");
    assert!(refused["error"].as_str().unwrap().contains("mission.pdl:1:"), "{refused}");
    assert_eq!(get(server, "/api/flights").1, json!({"flights": []}));
    assert!(!folder.path().join("broken-1.apex").exists());

    let server = start(Some(missions()), folder.path(), Ipv4Addr::LOCALHOST);
    let (_, listed) = get(server, "/api/missions");
    let watch = listed["missions"].as_array().unwrap().iter().find(|each| each["name"] == "structure-watch").unwrap();
    assert_eq!((&watch["title"], &watch["loads"]), (&json!("Structure Watch"), &json!(true)));
    let (status, plan) = get(server, "/api/missions/structure-watch/plan?budget_s=0.05");
    assert_eq!(status, 200, "{plan}");
    assert_eq!(plan["mission"], "Structure Watch");
    assert!(plan["plan"].is_object() && plan["value"].as_f64().unwrap() > 0.0, "{plan}");
}

#[test]
fn wrong_requests_are_refused_with_help() {
    let folder = tempfile::tempdir().unwrap();
    let server = start(Some(missions()), folder.path(), Ipv4Addr::LOCALHOST);
    let refused = |status: u16, (found, body): (u16, Value)| {
        assert_eq!(found, status, "{body}");
        assert!(body["error"].as_str().is_some_and(|text| !text.is_empty()), "{body}");
        assert!(body["help"].as_str().is_some_and(|text| !text.is_empty()), "{body}");
    };
    for name in ["../missions", "..", "a/b", "", "/etc", "first-picture/"] {
        refused(400, fly(server, &json!({"mission": name})));
    }
    refused(400, get(server, "/api/missions/..%2Fmissions%2Ffirst-picture/plan"));
    refused(404, get(server, "/api/missions/nothing/plan"));
    refused(404, fly(server, &json!({"mission": "nothing"})));
    for body in [json!({"until_s": 0}), json!({"until_s": 1e12}), json!({"pace": -1}), json!({"pace": 0})] {
        let mut request = json!({"mission": "first-picture"});
        request.as_object_mut().unwrap().extend(body.as_object().unwrap().clone());
        refused(400, fly(server, &request));
    }
    for body in ["{\"mission\": \"first-picture\", \"wings\": 2}", "{\"seed\": 1}", "[]"] {
        refused(422, ask(server, "POST", "/api/flights", JSON, body));
    }
    refused(400, ask(server, "POST", "/api/flights", JSON, "{"));
    refused(415, ask(server, "POST", "/api/flights", "", "{\"mission\": \"first-picture\"}"));
    let long = format!("{{\"mission\": \"{}\"}}", "a".repeat(5_000));
    refused(413, ask(server, "POST", "/api/flights", JSON, &long));
    refused(400, get(server, "/api/missions/first-picture/plan?budget_s=-1"));
    refused(400, get(server, "/api/missions/first-picture/plan?budget=1"));
    refused(404, get(server, "/api/flights/9"));
    refused(404, stop(server, &json!(9)));
    refused(400, get(server, "/api/flights/first"));
    refused(405, ask(server, "PUT", "/api/flights", JSON, "{}"));
    refused(404, get(server, "/api/mission"));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn other_sites_start_no_flights() {
    let folder = tempfile::tempdir().unwrap();
    let request = json!({"mission": "first-picture", "until_s": 1}).to_string();
    let server = start(Some(missions()), folder.path(), Ipv4Addr::LOCALHOST);
    let foreign = format!("{JSON}Origin: https://evil.example\r\n");
    for path in ["/api/flights", "/api/flights/1/stop"] {
        let (status, refused) = ask(server, "POST", path, &foreign, &request);
        assert_eq!((status, &refused["error"]), (403, &json!("this page comes from another site")));
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);

    let own = format!("{JSON}Origin: http://{server}\r\n");
    let (status, flight) = ask(server, "POST", "/api/flights", &own, &request);
    assert_eq!(status, 201, "{flight}");
    ended(server, &flight["id"]);
}

#[test]
fn a_server_without_missions_says_how_to_fly() {
    let folder = tempfile::tempdir().unwrap();
    let server = start(None, folder.path(), Ipv4Addr::LOCALHOST);
    let post = |path: &str| ask(server, "POST", path, JSON, "{\"mission\": \"first-picture\"}");
    let answers = [
        get(server, "/api/missions"),
        get(server, "/api/missions/first-picture/plan"),
        get(server, "/api/flights"),
        get(server, "/api/flights/1"),
        post("/api/flights"),
        post("/api/flights/1/stop"),
    ];
    for (status, body) in answers {
        assert_eq!(status, 404, "{body}");
        assert!(body["help"].as_str().unwrap().contains("--missions"), "{body}");
    }
}

#[test]
fn every_command_to_a_flight_has_one_end_and_is_in_its_record() {
    let folder = tempfile::tempdir().unwrap();
    let server = start(Some(missions()), folder.path(), Ipv4Addr::LOCALHOST);
    let flight = fly(server, &json!({"mission": "structure-watch", "pace": 1})).1;
    let at = |what: &str| format!("/api/flights/{}/{what}", flight["id"]);
    let command = |body: &Value| ask(server, "POST", &at("commands"), JSON, &body.to_string());
    let ends = |body: &Value, state: &str, reason: &str| {
        // On a busy machine a command can expire before the run takes it. It then has no effect and is sent again.
        let (status, end) = (0..12).map(|_| command(body)).find(|(_, end)| end["state"] != "expired").unwrap();
        assert_eq!((status, &end["state"]), (200, &json!(state)), "{body}: {end}");
        assert!(end["reason"].as_str().unwrap_or_default().contains(reason), "{body}: {end}");
    };
    ends(&json!({"do": "pause"}), "accepted", "");
    let (_, paused) = get(server, &at("operation"));
    assert_eq!((&paused["paused"], &paused["pace"]), (&json!(true), &json!(0.0)), "{paused}");
    std::thread::sleep(Duration::from_millis(200));
    assert_eq!(get(server, &at("operation")).1["now_ns"], paused["now_ns"], "mission time stands still");
    let camp = |operation: &Value| {
        let targets = operation["targets"].as_array().unwrap().clone();
        targets.into_iter().find(|target| target["id"] == "camp").unwrap()["known"].clone()
    };
    assert_eq!(camp(&paused), json!(false));
    ends(&json!({"do": "add-target", "target": "camp"}), "accepted", "");
    ends(&json!({"do": "step"}), "accepted", "");
    assert_eq!(camp(&get(server, &at("operation")).1), json!(true));
    ends(&json!({"do": "add-target", "target": "camp"}), "rejected", "is a target of the flight already");
    ends(&json!({"do": "value-target", "target": "moon", "value": 1.0}), "rejected", "has no target `moon`");
    ends(&json!({"do": "value-target", "target": "camp", "value": -1.0}), "rejected", "is not from 0");
    ends(&json!({"do": "message", "form": "(unbalanced"}), "rejected", "cannot be read");
    ends(&json!({"do": "answer", "agent": "rotorcraft-1", "question": 99, "answer": "x"}), "rejected", "is not open");
    ends(&json!({"do": "pace", "pace": 0.0}), "rejected", "is not above 0");
    assert_eq!(command(&json!({"do": "fly-away"})).0, 422);
    // A request that waited while the server was stopped has expired when it arrives.
    let clock = get(server, &at("operation")).1["clock_ms"].as_f64().unwrap();
    let late = command(&json!({"do": "resume", "until_ms": clock - 1.0})).1;
    assert_eq!((&late["state"], &late["at_ns"]), (&json!("expired"), &Value::Null), "{late}");
    assert!(late["reason"].as_str().unwrap().contains("reached the server after the time"), "{late}");
    assert_eq!(get(server, &at("operation")).1["paused"], json!(true), "an expired command has no effect");
    ends(&json!({"do": "pace", "pace": 0.5, "until_ms": clock + 60_000.0}), "accepted", "");
    ends(&json!({"do": "pause"}), "accepted", "");
    // Nothing has been raised so far: an alarm that nobody saw cannot be acknowledged. english: allow
    ends(&json!({"do": "acknowledge", "alarm": "x", "at_ns": 0}), "rejected", "raised no alarm at 0s, and none before");
    let signal = json!({"do": "acknowledge", "alarm": "x", "at_ns": 0, "signal": "(moon rotorcraft-1)"});
    ends(&signal, "rejected", "`(moon rotorcraft-1)` has no sample");
    assert_eq!(command(&json!({"do": "pause", "until_ms": "soon"})).0, 422);
    assert_eq!(ask(server, "POST", &at("commands"), "", "{}").0, 415);
    ends(&json!({"do": "stop"}), "accepted", "");
    let ended = ended(server, &flight["id"]);
    ends(&json!({"do": "pause"}), "rejected", "the flight ended");

    let record = PathBuf::from(ended["record"].as_str().unwrap());
    let lines = trace(&record);
    let entries = lines.lines().filter(|line| line.contains("operator-command")).count();
    assert_eq!(entries, 15, "each command that the run could take is one input:\n{lines}");
    assert!(replay(&RecordReader::open(&record).unwrap()).unwrap().difference.is_none());
    let (_, none) = get(server, "/api/operation");
    assert_eq!(none, Value::Null, "this server shows no record");
    assert_eq!(ask(server, "POST", "/api/commands", JSON, "{\"do\": \"pause\"}").0, 404);
}

#[test]
fn commands_of_other_sites_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let server = start(Some(missions()), folder.path(), Ipv4Addr::LOCALHOST);
    let headers = format!("{JSON}Origin: http://example.com\r\n");
    let (status, refused) = ask(server, "POST", "/api/flights/1/commands", &headers, "{\"do\": \"stop\"}");
    assert_eq!(status, 403, "{refused}");
}

#[test]
fn plans_ground_seen_and_holders_are_those_of_the_instant_also_for_many_callers() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("watch.apex");
    let mission = Arc::new(Mission::load(&missions().join("structure-watch")).unwrap());
    let mut recorder = apex_simulation::create_record(&path, &mission, Some(7)).unwrap();
    let terms = MissionFlight::terms(&mission, Some(Time::from_seconds(600.0)));
    apex_simulation::fly(mission, means(), Some(7), terms, &mut recorder, &mut []).unwrap();
    drop(recorder);
    let (sender, receiver) = mpsc::channel();
    let options = ServeOptions {
        record: Some(path),
        agent: 0,
        address: IpAddr::V4(Ipv4Addr::LOCALHOST),
        port: 0,
        load: None,
        door: None,
        access: AccessOptions::default(),
        others: Vec::new(),
        what_if: None,
        flights: None,
        ready: Box::new(move |url| sender.send(url.to_owned()).unwrap()),
    };
    std::thread::spawn(move || serve(options).unwrap());
    let url = receiver.recv().unwrap();
    let server: SocketAddr = url.trim_start_matches("http://").trim_end_matches('/').parse().unwrap();

    let (_, facts) = get(server, "/api/facts");
    assert_eq!((&facts["kind"], &facts["windows"]), (&json!("rotorcraft"), &json!([])));
    let plans = |at: i64| get(server, &format!("/api/plans?at={at}")).1["plans"].as_array().unwrap().clone();
    assert!(plans(0).is_empty(), "no plan before the first one");
    let all = plans(600_000_000_000);
    let numbers: Vec<u64> = all.iter().map(|plan| plan["number"].as_u64().unwrap()).collect();
    assert_eq!(numbers, (1..=all.len() as u64).collect::<Vec<_>>());
    let first_plan = all[0]["adopted_ns"].as_i64().unwrap();
    assert_eq!((plans(first_plan - 1).len(), plans(first_plan).len()), (0, 1), "a plan is known from its adoption");
    assert_eq!(get(server, "/api/plan").1, *all.last().unwrap(), "the last one is in force");

    let pictures = |at: i64| get(server, &format!("/api/footprints?at={at}")).1["pictures"].as_array().unwrap().clone();
    let taken = pictures(600_000_000_000);
    assert!(taken.len() >= 2, "{taken:?}");
    assert_eq!(pictures(0).len(), 0);
    let first = taken[0]["t_ns"].as_i64().unwrap();
    assert_eq!(pictures(first), taken[..1], "a picture is seen from its exposure");
    let (_, window) = get(server, &format!("/api/footprints?from={first}&to={first}"));
    assert_eq!(window["pictures"], json!(taken[..1]));

    let (_, holdings) = get(server, "/api/holdings?at=300000000000");
    let rows = holdings["resources"].as_array().unwrap();
    let path = rows.iter().find(|row| row["resource"].as_str().unwrap().contains("flight-path")).unwrap();
    let held = path["holdings"].as_array().unwrap();
    assert!(held.iter().all(|one| one["to_ns"].as_i64().unwrap() <= 300_000_000_000), "{held:?}");
    assert!(held.windows(2).all(|pair| pair[0]["from_ns"].as_i64() <= pair[1]["from_ns"].as_i64()), "by begin");
    assert!(
        held.iter().any(|one| one["open"] == json!(true)),
        "a helicopter in the air has a task that holds its path"
    );
    assert_eq!(get(server, "/api/holdings?at=soon").0, 400);

    // With more callers than connections, each gets the answer that a single caller gets.
    let alone = get(server, "/api/tasks").1;
    let callers: Vec<_> = (0..12).map(|_| std::thread::spawn(move || get(server, "/api/tasks").1)).collect();
    for caller in callers {
        assert_eq!(caller.join().unwrap(), alone);
    }
}
