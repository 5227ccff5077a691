//! Blocks other web sites: every request must name this server, and must not come from a page of another site.
//!
//! A page of another site can make a browser contact this server under a foreign name (DNS rebinding), open a WebSocket across sites or
//! post a form. So `Host` must be the address of the connection, a loopback name on a loopback connection, or a name that the user
//! states; `Origin`, if a browser sends it, must be the requested host; and a request that a browser marks as cross-site gets no answer
//! of the API.

use crate::answer::ApiError;
use crate::listening::Endpoint;
use crate::state::Shared;
use axum::extract::{Request, State};
use axum::http::header::{HOST, ORIGIN};
use axum::http::{HeaderMap, HeaderName};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use std::net::IpAddr;

/// The header by which browsers state the relation between the requesting page and the server.
const FETCH_SITE: HeaderName = HeaderName::from_static("sec-fetch-site");

/// Middleware of all addresses: refuses requests of other web sites and under other names.
pub(crate) async fn own_site_only(State(state): Shared, request: Request, next: Next) -> Response {
    let endpoint = request.extensions().get::<Endpoint>().map(|endpoint| endpoint.0);
    let headers = request.headers();
    let named = request.uri().authority().map(|authority| authority.as_str());
    // A proxy could take another of several hosts than this server.
    let hosts: Vec<&str> = texts(headers, &HOST).chain(named).collect();
    let strange = match hosts.iter().find(|host| !is_ours(host, endpoint, &state.names)) {
        Some(host) => Some(format!("this server does not answer to the name {}", host.escape_debug())),
        None if hosts.is_empty() => Some("this server does not answer to a request without Host".into()),
        None => None,
    };
    if let Some(error) = strange {
        let help = "open the address that `apex serve` printed, or give the name with `--host-name`";
        return ApiError::forbidden(error, help).into_response();
    }
    let from_elsewhere = !same_origin(headers)
        || (request.uri().path().starts_with("/api")
            && text(headers, &FETCH_SITE).is_some_and(|site| !is_own_site(site)));
    if from_elsewhere {
        return ApiError::forbidden("this page comes from another site", "open the page that this server serves")
            .into_response();
    }
    next.run(request).await
}

fn is_own_site(site: &str) -> bool {
    matches!(site, "same-origin" | "none")
}

/// Returns true unless a browser states that the requesting page came from another host than the requested one.
fn same_origin(headers: &HeaderMap) -> bool {
    let Some(origin) = headers.get(ORIGIN) else { return true };
    let origin = origin.to_str().ok().and_then(|origin| origin.split_once("://")).map(|(_, host)| host);
    origin.is_some() && origin == text(headers, &HOST)
}

fn text<'a>(headers: &'a HeaderMap, name: &HeaderName) -> Option<&'a str> {
    texts(headers, name).next()
}

fn texts<'h>(headers: &'h HeaderMap, name: &HeaderName) -> impl Iterator<Item = &'h str> {
    headers.get_all(name).into_iter().map(|value| value.to_str().unwrap_or("?"))
}

/// Returns true if `host` names this server on a connection to `endpoint`, or is one of `names`.
fn is_ours(host: &str, endpoint: Option<IpAddr>, names: &[String]) -> bool {
    let name = match host.rsplit_once(':') {
        Some((name, port)) if !port.is_empty() && port.bytes().all(|digit| digit.is_ascii_digit()) => name,
        _ => host,
    };
    let endpoint = endpoint.map(|endpoint| endpoint.to_canonical());
    let is_local = endpoint.is_some_and(|endpoint| endpoint.is_loopback());
    if names.iter().any(|each| each.eq_ignore_ascii_case(name)) || (is_local && name.eq_ignore_ascii_case("localhost"))
    {
        return true;
    }
    let address = name.strip_prefix('[').and_then(|name| name.strip_suffix(']')).unwrap_or(name);
    address.parse::<IpAddr>().is_ok_and(|address| {
        let address = address.to_canonical();
        Some(address) == endpoint || (is_local && address.is_loopback())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hosts_are_the_address_of_the_connection_loopback_names_and_stated_names() {
        let local = Some("127.0.0.1".parse().unwrap());
        for host in ["localhost", "localhost:8080", "127.0.0.1:9", "[::1]:9", "[::1]", "LOCALHOST:1", "127.0.0.2"] {
            assert!(is_ours(host, local, &[]), "{host}");
        }
        for host in
            ["example.com", "localhost.example.com:80", "192.168.0.2:80", "", "127.0.0.1.nip.io", "localhost:", "?"]
        {
            assert!(!is_ours(host, local, &[]), "{host}");
        }
        let open = Some("192.168.0.2".parse().unwrap());
        let names = ["station.example".to_owned()];
        assert!(is_ours("192.168.0.2:8040", open, &names) && is_ours("Station.example:8040", open, &names));
        assert!(is_ours("192.168.0.2", Some("::ffff:192.168.0.2".parse().unwrap()), &[]));
        for host in ["localhost", "127.0.0.1", "192.168.0.3", "other.example"] {
            assert!(!is_ours(host, open, &names), "{host}");
        }
        assert!(!is_ours("127.0.0.1", None, &[]));
    }

    #[test]
    fn a_page_of_another_host_is_another_origin() {
        let mut headers = HeaderMap::new();
        headers.insert(HOST, "localhost:7070".parse().unwrap());
        assert!(same_origin(&headers));
        headers.insert(ORIGIN, "http://localhost:7070".parse().unwrap());
        assert!(same_origin(&headers));
        for origin in ["https://example.com", "null", "http://localhost:7071", "localhost:7070"] {
            headers.insert(ORIGIN, origin.parse().unwrap());
            assert!(!same_origin(&headers), "{origin}");
        }
    }
}
