//! Keeps other web sites away from a record that is served on this machine only.
//!
//! A page from elsewhere can make a browser ask `localhost` under a foreign name (DNS rebinding) or open a WebSocket
//! across sites. A server bound to a loopback address therefore answers only to loopback names, and a WebSocket only
//! to pages of the same origin.

use crate::answer::ApiError;
use axum::extract::Request;
use axum::http::HeaderMap;
use axum::http::header::{HOST, ORIGIN};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

/// Middleware of a server on a loopback address: refuses requests whose `Host` is another name.
pub(crate) async fn loopback_names_only(request: Request, next: Next) -> Response {
    match host(request.headers()) {
        Some(host) if is_loopback_name(host) => next.run(request).await,
        other => ApiError::forbidden(
            format!("this server answers to localhost only, not to {}", other.unwrap_or("a request without Host")),
            "open the address that `apex serve` printed, or give `--address` to serve other machines",
        )
        .into_response(),
    }
}

/// True unless a browser says that the page that asks came from another host than the one asked.
pub(crate) fn same_origin(headers: &HeaderMap) -> bool {
    let Some(origin) = headers.get(ORIGIN).and_then(|value| value.to_str().ok()) else {
        return true;
    };
    let asked = headers.get(HOST).and_then(|value| value.to_str().ok());
    origin.split_once("://").map(|(_, host)| host) == asked
}

fn host(headers: &HeaderMap) -> Option<&str> {
    headers.get(HOST).and_then(|value| value.to_str().ok())
}

fn is_loopback_name(host: &str) -> bool {
    let name = match host.rsplit_once(':') {
        Some((name, port)) if port.bytes().all(|digit| digit.is_ascii_digit()) => name,
        _ => host,
    };
    let address = name.trim_start_matches('[').trim_end_matches(']');
    name.eq_ignore_ascii_case("localhost")
        || address.parse::<std::net::IpAddr>().is_ok_and(|address| address.is_loopback())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn loopback_names_are_known_and_others_are_not() {
        for host in ["localhost", "localhost:8080", "127.0.0.1:9", "[::1]:9", "[::1]", "LOCALHOST:1", "127.0.0.2"] {
            assert!(is_loopback_name(host), "{host}");
        }
        for host in ["example.com", "localhost.example.com:80", "192.168.0.2:80", "", "127.0.0.1.nip.io"] {
            assert!(!is_loopback_name(host), "{host}");
        }
    }

    #[test]
    fn a_page_of_another_host_is_another_origin() {
        let mut headers = HeaderMap::new();
        headers.insert(HOST, "localhost:7070".parse().unwrap());
        assert!(same_origin(&headers));
        headers.insert(ORIGIN, "http://localhost:7070".parse().unwrap());
        assert!(same_origin(&headers));
        headers.insert(ORIGIN, "https://example.com".parse().unwrap());
        assert!(!same_origin(&headers));
    }
}
