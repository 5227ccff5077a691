//! Serves a flight record without the `apex` command: `cargo run -p apex-server --example serve -- FILE.apex [--port PORT]`.

use apex_server::{AccessOptions, ServeOptions, serve};
use std::net::{IpAddr, Ipv4Addr};
use std::process::ExitCode;

fn main() -> ExitCode {
    // The arguments are those of `apex serve FILE --port N`, so that the page's tests can run either program.
    let words: Vec<String> = std::env::args().skip(1).filter(|word| word != "serve" && word != "--port").collect();
    let Some(record) = words.first() else {
        eprintln!("usage: serve FILE.apex [--port PORT]");
        return ExitCode::from(2);
    };
    let port = words.get(1).and_then(|text| text.parse().ok()).unwrap_or(8040);
    let options = ServeOptions {
        record: Some(record.into()),
        agent: 0,
        address: IpAddr::V4(Ipv4Addr::LOCALHOST),
        port,
        load: None,
        door: None,
        access: AccessOptions::default(),
        others: Vec::new(),
        what_if: None,
        flights: None,
        ready: Box::new(|url| println!("{url}")),
    };
    match serve(options) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}
