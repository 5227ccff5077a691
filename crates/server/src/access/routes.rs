//! `/api/session`: identifies the caller, and begins and ends sessions.

use super::sessions::Sessions;
use crate::answer::{ApiError, ApiResult};
use crate::state::{AppState, Shared};
use apex_runtime::authority::{Actor, ActorRole};
use axum::extract::State;
use axum::extract::rejection::JsonRejection;
use axum::http::header::SET_COOKIE;
use axum::http::{HeaderMap, StatusCode};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use axum::{Json, Router};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// The body of `POST /api/session`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Opening {
    /// A token, if this server needs tokens.
    token: Option<String>,
    /// A name, if this server needs no tokens.
    name: Option<String>,
    /// The requested role of a caller without a token; the default is operator.
    role: Option<String>,
}

/// The caller in the form of the API.
#[derive(Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(crate) struct SessionState {
    name: String,
    #[cfg_attr(test, ts(type = "'observer' | 'operator' | 'pilot-in-command'"))]
    role: &'static str,
    /// True if this server needs tokens.
    tokens: bool,
}

/// Returns the routes.
pub(crate) fn routes() -> Router<Arc<AppState>> {
    Router::new().route("/api/session", get(session).post(begin).delete(end))
}

fn state_of(sessions: &Sessions, actor: Actor) -> Json<SessionState> {
    Json(SessionState { role: actor.role.word(), name: actor.name, tokens: sessions.are_required() })
}

async fn session(State(state): Shared, headers: HeaderMap) -> ApiResult<Json<SessionState>> {
    Ok(state_of(&state.sessions, state.sessions.caller(&headers)?))
}

async fn begin(State(state): Shared, opening: Result<Json<Opening>, JsonRejection>) -> ApiResult<Response> {
    let help = "send `{\"token\": TOKEN}` as application/json, or `{\"name\": NAME, \"role\": ROLE}` where no tokens are needed";
    let Json(opening) = opening.map_err(|rejection| ApiError {
        status: rejection.status(),
        error: rejection.body_text(),
        help: help.into(),
    })?;
    let (actor, secret) = match opening {
        Opening { token: Some(token), name: None, role: None } => state.sessions.begin_by_token(&token)?,
        Opening { token: None, name: Some(name), role } => {
            let role = role.as_deref().map_or(Some(ActorRole::Operator), ActorRole::of_word);
            let role = role.ok_or_else(|| {
                let words: Vec<&str> = ActorRole::ALL.into_iter().map(ActorRole::word).collect();
                ApiError::bad_request(format!("unknown `role`: expected one of {}", words.join(", ")), help)
            })?;
            state.sessions.begin_by_name(&name, role)?
        }
        _ => return Err(ApiError::bad_request("a session begins by a `token` or by a `name`", help)),
    };
    let secure = if state.is_encrypted { "; Secure" } else { "" };
    let cookie = format!("{}={secret}; Path=/; HttpOnly; SameSite=Strict{secure}", state.sessions.cookie_name());
    Ok((StatusCode::CREATED, [(SET_COOKIE, cookie)], state_of(&state.sessions, actor)).into_response())
}

async fn end(State(state): Shared, headers: HeaderMap) -> Response {
    state.sessions.end(&headers);
    let cookie = format!("{}=; Path=/; HttpOnly; SameSite=Strict; Max-Age=0", state.sessions.cookie_name());
    (StatusCode::NO_CONTENT, [(SET_COOKIE, cookie)]).into_response()
}
