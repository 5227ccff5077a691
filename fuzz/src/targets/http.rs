//! Fuzz target of the server: sends the bytes over a connection unchanged, as HTTP, or as WebSocket frames after an upgrade.
//!
//! Properties: the server answers or closes the connection, no answer is a server error, and the server then still answers a valid
//! request. A panic of the server's threads ends the process, because libFuzzer sets a hook for panics.

use crate::planted;
use crate::sample;
use apex_server::{AccessOptions, ServeOptions, serve};
use std::io::{Read, Write};
use std::net::{IpAddr, Ipv4Addr, Shutdown, SocketAddr, TcpStream};
use std::sync::{LazyLock, mpsc};
use std::time::Duration;

const BYTES_MAX: usize = 65_536;
const PATIENCE: Duration = Duration::from_secs(5);

static SERVER: LazyLock<SocketAddr> = LazyLock::new(|| {
    let (sender, receiver) = mpsc::channel();
    let options = ServeOptions {
        record: Some(sample::record_path()),
        agent: 0,
        address: IpAddr::V4(Ipv4Addr::LOCALHOST),
        port: 0,
        load: None,
        door: None,
        others: Vec::new(),
        what_if: None,
        flights: None,
        access: AccessOptions::default(),
        ready: Box::new(move |url| sender.send(url.to_owned()).unwrap_or_default()),
    };
    std::thread::spawn(move || serve(options).unwrap_or_else(|error| panic!("the server ended: {error}")));
    let url = receiver.recv_timeout(PATIENCE).unwrap_or_default();
    let address = url.trim_start_matches("http://").trim_end_matches('/').parse();
    address.unwrap_or_else(|error| panic!("`{url}` is not an address: {error}"))
});

/// Sends the bytes and returns the answer until the server closes.
fn exchange(bytes: &[u8]) -> Vec<u8> {
    let mut answer = Vec::new();
    let Ok(mut stream) = TcpStream::connect(*SERVER) else { return answer };
    let _ = stream.set_read_timeout(Some(PATIENCE));
    // The server may close the connection before it has read everything.
    let _ = stream.write_all(bytes);
    let _ = stream.shutdown(Shutdown::Write);
    let _ = stream.read_to_end(&mut answer);
    answer
}

/// Returns the three digits of the status, or `None` for an answer that is not HTTP.
fn status(answer: &[u8]) -> Option<u16> {
    let digits = answer.strip_prefix(b"HTTP/1.1 ").or_else(|| answer.strip_prefix(b"HTTP/1.0 "))?.get(..3)?;
    std::str::from_utf8(digits).ok()?.parse().ok()
}

/// Runs the target.
pub(crate) fn run(bytes: &[u8]) {
    if bytes.len() > BYTES_MAX {
        return;
    }
    let answer = exchange(bytes);
    assert!(status(&answer).is_none_or(|status| status < 500), "a server error: {}", String::from_utf8_lossy(&answer));
    if planted::ARE_IN {
        // Planted bug: the client assumes that every answer has a status line.
        assert!(bytes.is_empty() || answer.len() >= 12, "the answer ends before its status");
    }
    let good = format!("GET /api/mission HTTP/1.1\r\nHost: {}\r\nConnection: close\r\n\r\n", *SERVER);
    if bytes.len().is_multiple_of(64) {
        let again = status(&exchange(good.as_bytes()));
        assert_eq!(again, Some(200), "the server does not answer a good request any longer");
    }
}
