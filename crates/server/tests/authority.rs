//! Authority over a flight, over real HTTP: sessions take it, offer it, refuse it and release it, and the record names each holder.

#![allow(clippy::unwrap_used, clippy::indexing_slicing)]

use apex_mission::deliberation::PlanningResources;
use apex_mission::recorded::replay;
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

/// Serves on a thread that ends with the test program.
fn start(records: &Path) -> SocketAddr {
    let (sender, receiver) = mpsc::channel();
    let options = ServeOptions {
        record: None,
        agent: 0,
        address: IpAddr::V4(Ipv4Addr::LOCALHOST),
        port: 0,
        load: None,
        door: None,
        others: Vec::new(),
        what_if: None,
        flights: Some(FlightOptions {
            missions: Path::new(env!("CARGO_MANIFEST_DIR")).join("../../missions"),
            records: records.into(),
            read: Arc::new(|text| apex_pdl::read_value(text).map_err(|diagnostic| diagnostic.message)),
            means: PlanningResources::of(&Arc::new(apex_solvers::shipped())),
        }),
        access: AccessOptions::default(),
        ready: Box::new(move |url| sender.send(url.to_owned()).unwrap()),
    };
    std::thread::spawn(move || serve(options).unwrap());
    let url = receiver.recv().unwrap();
    url.trim_start_matches("http://").trim_end_matches('/').parse().unwrap()
}

/// Returns the status of an answer, and its text.
fn ask_for_head(server: SocketAddr, method: &str, path: &str, headers: &str, body: &str) -> (u16, String) {
    let mut stream = TcpStream::connect(server).unwrap();
    let length = body.len();
    write!(
        stream,
        "{method} {path} HTTP/1.1\r\nHost: {server}\r\nConnection: close\r\nContent-Length: {length}\r\n{headers}\r\n{body}"
    )
    .unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    (answer.split(' ').nth(1).unwrap().parse().unwrap(), answer)
}

fn ask(server: SocketAddr, method: &str, path: &str, headers: &str, body: &str) -> (u16, Value) {
    let (status, answer) = ask_for_head(server, method, path, headers, body);
    (status, serde_json::from_str(answer.split_once("\r\n\r\n").unwrap().1).unwrap_or_default())
}

/// Waits for the end of a flight.
fn ended(server: SocketAddr, id: &Value) -> Value {
    loop {
        let flight = ask(server, "GET", &format!("/api/flights/{id}"), "", "").1;
        if flight["state"] != "flying" {
            return flight;
        }
        std::thread::sleep(Duration::from_millis(50));
    }
}

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

/// Stations are callers that may command, other than the requesting one.
fn check_stations(stations: &Value) {
    let van = json!({"name": "van", "role": "operator"});
    assert!(stations.as_array().unwrap().contains(&van), "{stations}");
    assert!(!stations.to_string().contains("guest") && !stations.to_string().contains("tower"), "{stations}");
}

/// Checks what the holder of authority is refused in epoch 1.
fn check_refusals(refused: &dyn Fn(Value, &str)) {
    refused(json!({"do": "offer-authority", "to": "mars"}), "no caller is called mars");
    refused(json!({"do": "offer-authority", "to": "guest"}), "guest is an observer");
    refused(json!({"do": "pause", "epoch": 7}), "epoch 7 of authority has not begun: this is epoch 1");
    for form in
        ["(operator-command 5 \"stop\" accepted)", "(authority 9 pia)", "(recording-lost x)", "(requirement-at-risk y)"]
    {
        refused(json!({"do": "message", "form": form}), "only Apex sends the message");
    }
}

#[test]
fn authority_is_offered_taken_refused_and_recorded() {
    let folder = tempfile::tempdir().unwrap();
    let server = start(folder.path());
    let session = |name: &str, role: &str| {
        let body = json!({"name": name, "role": role}).to_string();
        let (status, head) = ask_for_head(server, "POST", "/api/session", JSON, &body);
        assert_eq!(status, 201, "{head}");
        let cookie = head.lines().find_map(|line| line.strip_prefix("set-cookie: ")).unwrap();
        assert!(cookie.contains("HttpOnly") && cookie.contains("SameSite=Strict"), "{cookie}");
        format!("{JSON}Cookie: {}\r\n", cookie.split(';').next().unwrap())
    };
    let (tower, van) = (session("tower", "operator"), session("van", "operator"));
    let (pilot, guest) = (session("pilot", "pilot-in-command"), session("guest", "observer"));
    let (status, flight) =
        ask(server, "POST", "/api/flights", &tower, &json!({"mission": "structure-watch", "pace": 1}).to_string());
    assert_eq!(status, 201, "{flight}");
    let at = |what: &str| format!("/api/flights/{}/{what}", flight["id"]);
    let authority = |who: &str| ask(server, "GET", &at("operation"), who, "").1["authority"].clone();
    let ends = |who: &str, body: Value, state: &str, reason: &str| {
        let (status, end) = ask(server, "POST", &at("commands"), who, &body.to_string());
        assert_eq!((status, &end["state"]), (200, &json!(state)), "{body}: {end}");
        assert!(end["reason"].as_str().unwrap_or_default().contains(reason), "{body}: {end}");
    };
    let free = authority(&tower);
    assert_eq!((&free["holder"], &free["epoch"], &free["may_take"]), (&Value::Null, &json!(0), &json!(true)));
    ends(&tower, json!({"do": "pause"}), "accepted", "");
    let holder = json!({"name": "tower", "role": "operator"});
    assert_eq!(authority(&tower)["holder"], holder, "a command takes free authority");
    ends(&van, json!({"do": "resume"}), "rejected", "tower holds authority");
    ends(&van, json!({"do": "take-authority"}), "rejected", "tower holds authority");
    check_stations(&authority(&tower)["stations"]);
    check_refusals(&|body, reason| ends(&tower, body, "rejected", reason));
    ends(&tower, json!({"do": "offer-authority", "to": "van"}), "accepted", "");
    let offered = authority(&van);
    assert_eq!((&offered["offer"]["to"], &offered["may_take"]), (&json!("van"), &json!(true)), "{offered}");
    ends(&van, json!({"do": "refuse-authority"}), "accepted", "");
    ends(&tower, json!({"do": "offer-authority", "to": "van", "epoch": 1}), "accepted", "");
    ends(&van, json!({"do": "take-authority"}), "accepted", "");
    ends(
        &tower,
        json!({"do": "resume", "epoch": 1}),
        "rejected",
        "epoch 1 of authority is stale: this is epoch 2, van holds it",
    );
    ends(&van, json!({"do": "message", "form": "(hello)", "epoch": 2}), "accepted", "");
    ends(&pilot, json!({"do": "take-authority"}), "accepted", "");
    ends(&van, json!({"do": "pause"}), "rejected", "pilot holds authority");
    assert_eq!(ask(server, "POST", &at("commands"), &guest, "{\"do\": \"pause\"}").0, 403, "observers command nothing");
    assert_eq!(ask(server, "POST", &at("stop"), &van, "").0, 403);
    assert_eq!(ask(server, "POST", &at("commands"), &pilot, "{\"do\": \"pause\", \"epoch\": -1}").0, 422);
    ends(&pilot, json!({"do": "release-authority"}), "accepted", "");
    ends(&van, json!({"do": "stop", "epoch": 4}), "accepted", "");
    let ended = ended(server, &flight["id"]);

    let record = PathBuf::from(ended["record"].as_str().unwrap());
    let lines = trace(&record);
    for entry in [
        "(authority 1 \"tower\" operator taken)",
        "(operator-command 1 \"pause\" accepted :by \"tower\")",
        "(authority 1 \"tower\" operator offered \"van\")",
        "(authority 1 \"van\" operator refused)",
        "(authority 2 \"van\" operator handed-over)",
        ":by \"tower\" :epoch 1)",
        "(authority 3 \"pilot\" pilot-in-command overridden)",
        "(authority 4 \"pilot\" pilot-in-command released)",
    ] {
        let entry = entry.replace('"', "\\\"");
        assert!(lines.contains(&entry), "{entry} is not in\n{lines}");
    }
    assert!(replay(&RecordReader::open(&record).unwrap()).unwrap().difference.is_none());
}
