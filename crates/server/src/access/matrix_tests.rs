//! Tests all routes with all roles over real HTTP, and that no route is missing.

use super::table::rows;
use super::token::AccessToken;
use crate::serve::{AccessOptions, ServeOptions, serve};
use apex_runtime::authority::{Actor, ActorRole};
use std::collections::BTreeSet;
use std::io::{Read, Write};
use std::net::{IpAddr, Ipv4Addr, SocketAddr, TcpStream};
use std::sync::mpsc;

/// Files in which routes are written.
const ROUTERS: [&str; 7] = [
    include_str!("../router.rs"),
    include_str!("../flights/routes.rs"),
    include_str!("../operation/routes.rs"),
    include_str!("../seen.rs"),
    include_str!("../shelf_routes.rs"),
    include_str!("../what_if/routes.rs"),
    include_str!("routes.rs"),
];

fn secret(role: ActorRole) -> String {
    format!("{:-<20}", role.word())
}

fn start() -> SocketAddr {
    let (sender, receiver) = mpsc::channel();
    let token = |role: ActorRole| AccessToken::new(Actor { name: role.word().into(), role }, &secret(role)).unwrap();
    let options = ServeOptions {
        record: None,
        agent: 0,
        address: IpAddr::V4(Ipv4Addr::LOCALHOST),
        port: 0,
        load: None,
        door: None,
        others: Vec::new(),
        what_if: None,
        flights: None,
        access: AccessOptions { tokens: ActorRole::ALL.map(token).into(), ..AccessOptions::default() },
        ready: Box::new(move |url| sender.send(url.to_owned()).unwrap()),
    };
    std::thread::spawn(move || serve(options).unwrap());
    let url = receiver.recv().unwrap();
    url.trim_start_matches("http://").trim_end_matches('/').parse().unwrap()
}

fn status(server: SocketAddr, method: &str, path: &str, role: Option<ActorRole>) -> u16 {
    let token = role.map(|role| format!("Authorization: Bearer {}\r\n", secret(role))).unwrap_or_default();
    let mut stream = TcpStream::connect(server).unwrap();
    let head =
        format!("{method} {path} HTTP/1.1\r\nHost: {server}\r\nConnection: close\r\nContent-Length: 0\r\n{token}\r\n");
    stream.write_all(head.as_bytes()).unwrap();
    let mut answer = Vec::new();
    stream.read_to_end(&mut answer).unwrap();
    String::from_utf8_lossy(&answer).split(' ').nth(1).unwrap().parse().unwrap()
}

#[test]
fn every_route_takes_every_role_as_the_table_says() {
    let server = start();
    let mut cells = 0;
    for (method, route, least) in rows() {
        let path = route.replace("{id}", "1").replace("{name}", "none").replace("{*what}", "mission");
        for role in [None, Some(ActorRole::Observer), Some(ActorRole::Operator), Some(ActorRole::PilotInCommand)] {
            let status = status(server, method.as_str(), &path, role);
            let expected = match (least, role) {
                (None, _) => None,
                (Some(_), None) => Some(401),
                (Some(least), Some(role)) => (role < least).then_some(403),
            };
            match expected {
                Some(expected) => assert_eq!(status, expected, "{method} {path} as {role:?}"),
                None => assert!(
                    ![401, 403, 405].contains(&status) || least.is_none(),
                    "{method} {path} as {role:?}: {status}"
                ),
            }
            cells += 1;
        }
    }
    assert_eq!(cells, 4 * rows().len());
}

#[test]
fn what_the_table_does_not_have_is_refused_to_everybody() {
    let server = start();
    for role in [None, Some(ActorRole::PilotInCommand)] {
        for (method, path) in [("PUT", "/api/mission"), ("DELETE", "/api/flights"), ("PATCH", "/api/commands")] {
            assert_eq!(status(server, method, path, role), 405, "{method} {path} {role:?}");
        }
        assert_eq!(status(server, "GET", "/api/none", role), 404);
        assert_eq!(status(server, "HEAD", "/api/missions", role), if role.is_none() { 401 } else { 404 });
    }
    assert!([200, 404].contains(&status(server, "GET", "/", None)), "the page itself has no secrets");
}

#[test]
fn every_route_of_the_routers_is_in_the_table() {
    let written: BTreeSet<String> = ROUTERS
        .into_iter()
        .flat_map(|text| text.split(".route(\"").skip(1).filter_map(|rest| rest.split('"').next()))
        .map(str::to_owned)
        .collect();
    let listed: BTreeSet<String> = rows().into_iter().map(|(_, route, _)| route.to_owned()).collect();
    assert_eq!(written, listed);
    assert!(written.len() > 25);
}
