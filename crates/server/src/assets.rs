//! The web page, embedded into the program from `web/dist`.

use crate::answer::ApiError;
use axum::http::header::{ACCEPT_ENCODING, CACHE_CONTROL, CONTENT_ENCODING, CONTENT_TYPE, VARY};
use axum::http::{HeaderMap, StatusCode, Uri};
use axum::response::{Html, IntoResponse, Response};
use rust_embed::RustEmbed;

#[derive(RustEmbed)]
#[folder = "../../web/dist"]
#[allow_missing = true]
struct Pages;

/// Page that is sent if the program was built without the web page.
const NOT_BUILT: &str = "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><title>Sherpa</title>\
<body><h1>The page is not built in</h1>\
<p>This program was built before the web page. Run <code>make web</code>, then build it again.</p>\
<p>The data is here all the same: <a href=\"/api/mission\">/api/mission</a>.</p>";

/// Answers every path outside the API from the embedded page.
pub(crate) async fn page(uri: Uri, headers: HeaderMap) -> Response {
    let path = uri.path().trim_start_matches('/');
    if path.starts_with("api/") || path == "api" {
        return ApiError::not_found(
            format!("there is no `/{path}` in this API"),
            "docs/reference/server-api.md lists all addresses",
        )
        .into_response();
    }
    let name = if path.is_empty() { "index.html" } else { path };
    let about = [(CONTENT_TYPE, content_type(name)), (CACHE_CONTROL, caching(name)), (VARY, "accept-encoding")];
    // The compressed file was made when the page was built.
    let packed = if takes_gzip(&headers) { Pages::get(&format!("{name}.gz")) } else { None };
    if let Some(file) = packed {
        return (about, [(CONTENT_ENCODING, "gzip")], file.data.into_owned()).into_response();
    }
    match Pages::get(name) {
        Some(file) => (about, file.data.into_owned()).into_response(),
        None if name == "index.html" => Html(NOT_BUILT).into_response(),
        None => (StatusCode::NOT_FOUND, format!("there is no /{name} here\n")).into_response(),
    }
}

/// Returns true if the client accepts gzip: it lists gzip or everything, with a weight other than 0.
fn takes_gzip(headers: &HeaderMap) -> bool {
    let accepted = headers.get(ACCEPT_ENCODING).and_then(|value| value.to_str().ok()).unwrap_or_default();
    accepted.split(',').any(|one| {
        let (name, weight) = one.split_once(';').map_or((one, ""), |(name, weight)| (name, weight));
        matches!(name.trim(), "gzip" | "*") && weight.trim().trim_start_matches("q=").parse() != Ok(0.0_f64)
    })
}

/// Returns the rule for caches: names below `assets/` carry a hash of their content, all other files may change with the program.
fn caching(name: &str) -> &'static str {
    if name.starts_with("assets/") { "public, max-age=31536000, immutable" } else { "no-cache" }
}

fn content_type(name: &str) -> &'static str {
    match name.rsplit_once('.').map(|(_, extension)| extension) {
        Some("html") => "text/html; charset=utf-8",
        Some("js" | "mjs") => "text/javascript; charset=utf-8",
        Some("css") => "text/css; charset=utf-8",
        Some("json" | "geojson") => "application/json",
        Some("svg") => "image/svg+xml",
        Some("png") => "image/png",
        Some("woff2") => "font/woff2",
        _ => "application/octet-stream",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn compressed_files_go_to_clients_that_accept_them() {
        let takes = |text: &str| {
            let mut headers = HeaderMap::new();
            headers.insert(ACCEPT_ENCODING, text.parse().unwrap());
            takes_gzip(&headers)
        };
        assert!(takes("gzip, deflate, br") && takes("br;q=1, gzip;q=0.5") && takes("*"));
        assert!(!takes("br") && !takes("gzip;q=0") && !takes("identity") && !takes_gzip(&HeaderMap::new()));
    }
}
