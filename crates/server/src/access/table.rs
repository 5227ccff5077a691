//! The addresses of the API, with the least role for each method. A request that is not in the table is refused.

use apex_runtime::authority::ActorRole;
use axum::http::Method;

/// One route: method, path in the router's notation, least role; `None` for an address that needs no session.
pub(crate) type RouteRow = (Method, &'static str, Option<ActorRole>);

/// Returns all rows.
pub(crate) fn rows() -> Vec<RouteRow> {
    let read = |path| (Method::GET, path, Some(ActorRole::Observer));
    let command = |path| (Method::POST, path, Some(ActorRole::Operator));
    vec![
        read("/api/mission"),
        read("/api/track"),
        read("/api/tasks"),
        read("/api/timeline"),
        read("/api/events"),
        read("/api/why"),
        read("/api/targets"),
        read("/api/surroundings"),
        read("/api/plan"),
        read("/api/plans"),
        read("/api/troubles"), // english: allow
        read("/api/questions"),
        read("/api/signals"),
        read("/api/samples"),
        read("/api/report"),
        read("/api/score"),
        read("/api/source"),
        read("/api/live"),
        read("/api/footprints"),
        read("/api/facts"),
        read("/api/holdings"),
        read("/api/monitors"),
        read("/api/program"),
        read("/api/program-text"),
        read("/api/command-log"),
        read("/api/records"),
        read("/api/records/{id}/{*what}"),
        read("/api/forks"),
        // A fork flies, and a draft is checked: both take a core.
        command("/api/forks"),
        command("/api/forks/{id}/stop"),
        command("/api/drafts"),
        read("/api/operation"),
        command("/api/commands"),
        read("/api/missions"),
        // Planning takes a core for up to a minute.
        (Method::GET, "/api/missions/{name}/plan", Some(ActorRole::Operator)),
        read("/api/flights"),
        command("/api/flights"),
        read("/api/flights/{id}"),
        read("/api/flights/{id}/report"),
        read("/api/flights/{id}/operation"),
        command("/api/flights/{id}/commands"),
        command("/api/flights/{id}/stop"),
        read("/api/session"),
        (Method::POST, "/api/session", None),
        (Method::DELETE, "/api/session", None),
    ]
}

/// Returns the least role of a route: `Some(None)` if it needs no session; `None` if the table does not contain it.
pub(crate) fn least_role(method: &Method, path: &str) -> Option<Option<ActorRole>> {
    // HEAD is GET without a body.
    let method = if method == Method::HEAD { &Method::GET } else { method };
    rows().into_iter().find(|(each, route, _)| each == method && *route == path).map(|(_, _, role)| role)
}

/// Returns true if the table has the path with any method.
pub(crate) fn has_path(path: &str) -> bool {
    rows().iter().any(|(_, route, _)| *route == path)
}
