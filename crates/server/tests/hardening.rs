//! Requests of other sites, half-sent and endless ones, and an address that other machines reach.

#![allow(clippy::unwrap_used, clippy::indexing_slicing)]

mod flight;

use apex_runtime::authority::{Actor, ActorRole};
use apex_server::{AccessOptions, AccessToken, ServeError, ServeOptions, TlsIdentity, serve};
use rustls::pki_types::{CertificateDer, ServerName};
use rustls::{ClientConfig, ClientConnection, RootCertStore, StreamOwned};
use std::io::{Read, Write};
use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpStream};
use std::path::Path;
use std::sync::{Arc, mpsc};
use std::time::{Duration, Instant};

const SECRET: &str = "0123456789abcdef";

fn options(record: &Path, address: Ipv4Addr, access: AccessOptions) -> ServeOptions {
    ServeOptions {
        record: Some(record.into()),
        agent: 0,
        address: IpAddr::V4(address),
        port: 0,
        load: None,
        door: None,
        others: Vec::new(),
        what_if: None,
        flights: None,
        access,
        ready: Box::new(|_| ()),
    }
}

fn start(record: &Path, address: Ipv4Addr, access: AccessOptions) -> (SocketAddr, String) {
    let (sender, receiver) = mpsc::channel();
    let mut options = options(record, address, access);
    options.ready = Box::new(move |url| sender.send(url.to_owned()).unwrap());
    std::thread::spawn(move || serve(options).unwrap());
    let url = receiver.recv().unwrap();
    let bound: SocketAddr = url.split("//").nth(1).unwrap().trim_end_matches('/').parse().unwrap();
    (SocketAddr::from((Ipv4Addr::LOCALHOST, bound.port())), url)
}

fn local(access: AccessOptions) -> (tempfile::TempDir, SocketAddr) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("flight.apex");
    flight::write_complete(&path);
    let (server, _) = start(&path, Ipv4Addr::LOCALHOST, access);
    (folder, server)
}

fn answer(stream: &mut (impl Read + Write), request: &str) -> (u16, String) {
    stream.write_all(request.as_bytes()).unwrap();
    let mut answer = Vec::new();
    stream.read_to_end(&mut answer).unwrap_or_default();
    let answer = String::from_utf8_lossy(&answer).into_owned();
    (answer.split(' ').nth(1).unwrap_or("0").parse().unwrap(), answer)
}

fn ask(server: SocketAddr, head: &str, headers: &str) -> (u16, String) {
    let mut stream = TcpStream::connect(server).unwrap();
    answer(&mut stream, &format!("{head} HTTP/1.1\r\nConnection: close\r\n{headers}\r\n"))
}

#[test]
fn every_answer_has_the_security_headers() {
    let (_folder, server) = local(AccessOptions::default());
    let host = format!("Host: {server}\r\n");
    let large = format!("{host}Content-Type: application/json\r\nContent-Length: 70000\r\n\r\n{}", "x".repeat(70_000));
    let answers = [
        (200, ask(server, "GET /api/mission", &host)),
        (200, ask(server, "HEAD /api/mission", &host)),
        (400, ask(server, "GET /api/tasks?at=soon", &host)),
        (403, ask(server, "GET /api/mission", "Host: evil.example\r\n")),
        (403, ask(server, "GET /api/mission", "")),
        (404, ask(server, "GET /api/none", &host)),
        (404, ask(server, "GET /none.js", &host)),
        (405, ask(server, "PUT /api/mission", &host)),
        (413, ask(server, "POST /api/session", &large)),
        (415, ask(server, "POST /api/session", &host)),
    ];
    for (expected, (status, answer)) in answers {
        assert_eq!(status, expected, "{answer}");
        let head = answer.split("\r\n\r\n").next().unwrap().to_lowercase();
        for header in [
            "content-security-policy: default-src 'none'",
            "x-content-type-options: nosniff",
            "x-frame-options: deny",
            "referrer-policy: no-referrer",
            "cross-origin-opener-policy: same-origin",
            "cross-origin-resource-policy: same-origin",
            "cache-control: no-",
        ] {
            assert!(head.contains(header), "{header} is not in {head}");
        }
        let rules = head.split("content-security-policy: ").nth(1).unwrap().split("\r\n").next().unwrap();
        assert!(!rules.contains('*') && !rules.contains("ws:") && !rules.contains("http:"), "{rules}");
    }
}

#[test]
fn other_sites_are_refused_on_every_address() {
    let names = vec!["station.example".into()];
    let (_folder, server) = local(AccessOptions { names, ..AccessOptions::default() });
    let status = |path: &str, headers: &str| ask(server, &format!("GET {path}"), headers).0;
    for path in ["/", "/api/mission", "/api/live", "/api/operation"] {
        assert_eq!(status(path, "Host: evil.example\r\n"), 403, "{path}");
        assert_eq!(status(path, &format!("Host: {server}\r\nOrigin: http://evil.example\r\n")), 403, "{path}");
        assert_eq!(status(path, &format!("Host: {server}\r\nOrigin: null\r\n")), 403, "{path}");
    }
    assert_eq!(status("http://evil.example/api/mission", &format!("Host: {server}\r\n")), 403);
    assert_eq!(status("/api/mission", &format!("Host: {server}\r\nHost: evil.example\r\n")), 403);
    assert_eq!(status("/api/mission", &format!("Host: {server}\r\nSec-Fetch-Site: cross-site\r\n")), 403);
    for headers in [
        format!("Host: {server}\r\nOrigin: http://{server}\r\nSec-Fetch-Site: same-origin\r\n"),
        format!("Host: localhost:{}\r\nSec-Fetch-Site: none\r\n", server.port()),
        "Host: station.example\r\n".into(),
    ] {
        assert_eq!(status("/api/mission", &headers), 200, "{headers}");
    }
}

#[test]
fn answers_are_compressed_for_those_that_can_read_it() {
    let (_folder, server) = local(AccessOptions::default());
    let host = format!("Host: {server}\r\n");
    let mut stream = TcpStream::connect(server).unwrap();
    write!(stream, "GET /api/track HTTP/1.1\r\n{host}Connection: close\r\nAccept-Encoding: gzip\r\n\r\n").unwrap();
    let mut packed = Vec::new();
    stream.read_to_end(&mut packed).unwrap();
    let head = String::from_utf8_lossy(&packed).to_lowercase();
    assert!(head.contains("content-encoding: gzip"), "{}", head.split("\r\n\r\n").next().unwrap());
    let (_, plain) = ask(server, "GET /api/track", &host);
    assert!(packed.len() * 2 < plain.len(), "{} of {} bytes", packed.len(), plain.len());
}

#[test]
fn half_sent_requests_are_ended() {
    let (_folder, server) = local(AccessOptions::default());
    let ended = |text: String| {
        std::thread::spawn(move || {
            let mut stream = TcpStream::connect(server).unwrap();
            stream.set_read_timeout(Some(Duration::from_secs(25))).unwrap();
            let began = Instant::now();
            let (status, said) = answer(&mut stream, &text);
            (status, said, began.elapsed())
        })
    };
    let cases = [
        (0, ended("GET /api/mission HT".into())),
        (0, ended(String::new())),
        (408, ended(format!("POST /api/session HTTP/1.1\r\nHost: {server}\r\nContent-Length: 100\r\n\r\n{{"))),
        // An idle connection after an answer.
        (404, ended(format!("GET /api/none HTTP/1.1\r\nHost: {server}\r\n\r\n"))),
    ];
    for (expected, case) in cases {
        let (status, said, took) = case.join().unwrap();
        assert!(took < Duration::from_secs(20), "the server ends it, not the client: {took:?}");
        assert!(status == expected || (expected == 0 && status == 408), "{status}: {said}");
    }
    let long = format!("GET /{} HTTP/1.1\r\nHost: {server}\r\n\r\n", "x".repeat(100_000));
    let (status, _) = answer(&mut TcpStream::connect(server).unwrap(), &long);
    assert!([0, 414, 431].contains(&status), "{status}");
}

#[test]
fn connections_beyond_the_cap_are_turned_away_and_places_come_back() {
    let (_folder, server) = local(AccessOptions::default());
    let mut open: Vec<TcpStream> = (0..256).map(|_| TcpStream::connect(server).unwrap()).collect();
    let request = format!("GET /api/mission HTTP/1.1\r\nHost: {server}\r\nConnection: close\r\n\r\n");
    // The last place is served. It stays open: the server releases the place of a closed connection a moment later than the
    // client reads its end, and a connection made in that moment would be turned away.
    let last = open.last_mut().unwrap();
    write!(last, "GET /api/mission HTTP/1.1\r\nHost: {server}\r\n\r\n").unwrap();
    let mut head = [0; 12];
    last.read_exact(&mut head).unwrap();
    assert_eq!(&head, b"HTTP/1.1 200");
    let (status, said) = answer(&mut TcpStream::connect(server).unwrap(), &request);
    assert_eq!(status, 503, "{said}");
    assert!(said.contains("too many connections"), "{said}");
    drop(open);
    let served = (0..50).any(|_| {
        std::thread::sleep(Duration::from_millis(100));
        answer(&mut TcpStream::connect(server).unwrap(), &request).0 == 200
    });
    assert!(served);
}

fn token(role: ActorRole, secret: &str) -> AccessToken {
    AccessToken::new(Actor { name: role.word().into(), role }, secret).unwrap()
}

#[test]
fn an_open_address_needs_tokens_and_encryption() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("flight.apex");
    flight::write_complete(&path);
    let open = |access: AccessOptions| serve(options(&path, Ipv4Addr::UNSPECIFIED, access)).unwrap_err();
    let error = open(AccessOptions::default());
    assert!(matches!(error, ServeError::Open { missing: "tokens", .. }), "{error}");
    let tokens = vec![token(ActorRole::Observer, SECRET)];
    let error = open(AccessOptions { tokens: tokens.clone(), ..AccessOptions::default() });
    assert!(error.to_string().contains("without a certificate"), "{error}");

    let identity = TlsIdentity::generate(vec!["localhost".into()]).unwrap();
    assert_eq!(identity.fingerprint().len(), 95);
    let mut roots = RootCertStore::empty();
    roots.add(CertificateDer::from(identity.certificate().to_vec())).unwrap();
    let (server, url) =
        start(&path, Ipv4Addr::UNSPECIFIED, AccessOptions { tokens, tls: Some(identity), names: Vec::new() });
    assert!(url.starts_with("https://"), "{url}");

    let provider = Arc::new(rustls::crypto::ring::default_provider());
    let config = ClientConfig::builder_with_provider(provider).with_safe_default_protocol_versions().unwrap();
    let config = Arc::new(config.with_root_certificates(roots).with_no_client_auth());
    let ask = |headers: &str| {
        let name = ServerName::try_from("localhost").unwrap();
        let connection = ClientConnection::new(Arc::clone(&config), name).unwrap();
        let mut stream = StreamOwned::new(connection, TcpStream::connect(server).unwrap());
        let request = format!("GET /api/mission HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n{headers}\r\n");
        answer(&mut stream, &request)
    };
    let (status, said) = ask("");
    assert_eq!(status, 401);
    let said = said.to_lowercase();
    assert!(said.contains("www-authenticate: bearer") && said.contains("strict-transport-security: "), "{said}");
    assert_eq!(ask("Authorization: Bearer 0123456789abcdeX\r\n").0, 401);
    let (status, mission) = ask(&format!("Authorization: Bearer {SECRET}\r\n"));
    assert!(status == 200 && mission.contains("western-states"), "{mission}");
    // Without encryption nothing is answered.
    let plain = answer(&mut TcpStream::connect(server).unwrap(), "GET / HTTP/1.1\r\nHost: localhost\r\n\r\n");
    assert!(!plain.1.contains("HTTP/1.1 200"), "{}", plain.1);
}
