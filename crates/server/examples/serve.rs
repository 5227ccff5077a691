//! Serves a flight record without the `apex` command: `cargo run -p apex-server --example serve -- FILE.apex [PORT]`.

use apex_server::{ServeOptions, serve};
use std::net::{IpAddr, Ipv4Addr};
use std::process::ExitCode;

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    let Some(record) = arguments.next() else {
        eprintln!("usage: serve FILE.apex [PORT]");
        return ExitCode::from(2);
    };
    let port = arguments.next().and_then(|text| text.parse().ok()).unwrap_or(7070);
    let options = ServeOptions {
        record: record.into(),
        address: IpAddr::V4(Ipv4Addr::LOCALHOST),
        port,
        explainer: None,
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
