//! Sessions: identifies a caller by the cookie of a session or by a token in the request.

use super::stations::Stations;
use super::token::{AccessToken, check_name, digest, new_secret};
use crate::answer::{ApiError, ApiResult, Remedy};
use apex_runtime::authority::{Actor, ActorRole};
use axum::http::header::{AUTHORIZATION, COOKIE};
use axum::http::{HeaderMap, StatusCode};
use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Beginning of the name of a session's cookie, followed by the port, because cookies do not distinguish ports of one machine.
const COOKIE_NAME: &str = "apex-session";
/// Maximum number of sessions; a further one replaces the one that has been silent longest.
const SESSIONS_MAX: usize = 200;
/// Time without a request after which a session is over.
const IDLE_MAX: Duration = Duration::from_secs(12 * 3600);
/// The name of callers of this machine without a session.
const THIS_MACHINE: &str = "this-machine";

/// The sessions of one server.
pub(crate) struct Sessions {
    tokens: Vec<AccessToken>,
    /// True if callers need a session or a token.
    required: bool,
    /// The name of the cookie.
    cookie: String,
    open: Mutex<BTreeMap<[u8; 32], Session>>,
    /// Callers with a request in the last seconds.
    pub(crate) stations: Stations,
}

struct Session {
    actor: Actor,
    heard: Instant,
}

impl Sessions {
    /// Returns an empty set of sessions for a server at `port`. Without `tokens` on a `loopback` address, callers need no session.
    pub(crate) fn new(tokens: Vec<AccessToken>, loopback: bool, port: u16) -> Sessions {
        let required = !loopback || !tokens.is_empty();
        let cookie = format!("{COOKIE_NAME}-{port}");
        Sessions { tokens, required, cookie, open: Mutex::default(), stations: Stations::default() }
    }

    /// Returns the name of the cookie that holds a session's secret.
    pub(crate) fn cookie_name(&self) -> &str {
        &self.cookie
    }

    /// Returns the secret in the session's cookie.
    fn secret<'a>(&self, headers: &'a HeaderMap) -> Option<&'a str> {
        let all = headers.get_all(COOKIE).into_iter().filter_map(|value| value.to_str().ok());
        all.flat_map(|value| value.split(';'))
            .find_map(|pair| pair.trim().strip_prefix(&self.cookie)?.strip_prefix('='))
    }

    /// Returns true if callers need a session or a token.
    pub(crate) fn are_required(&self) -> bool {
        self.required
    }

    /// Returns the sender of a request with these headers.
    ///
    /// # Errors
    /// 401 if the headers identify no session and callers need one, or if their token is wrong.
    pub(crate) fn caller(&self, headers: &HeaderMap) -> ApiResult<Actor> {
        if let Some(value) = headers.get(AUTHORIZATION) {
            let secret = value.to_str().ok().and_then(bearer);
            return secret.and_then(|secret| self.actor_of(secret)).ok_or_else(wrong_token);
        }
        if let Some(actor) = self.secret(headers).and_then(|secret| self.session(secret)) {
            return Ok(actor);
        }
        if self.required {
            return Err(ApiError {
                status: StatusCode::UNAUTHORIZED,
                error: "this server requires a session".into(),
                help: Remedy::Session
                    .help("send the header `Authorization: Bearer TOKEN`, or begin a session with POST /api/session"),
            });
        }
        Ok(Actor { name: THIS_MACHINE.into(), role: ActorRole::PilotInCommand })
    }

    fn actor_of(&self, secret: &str) -> Option<Actor> {
        let digest = digest(secret.trim());
        // All tokens are compared, so that the duration reveals nothing.
        let found = self.tokens.iter().fold(None, |found, token| if token.fits(&digest) { Some(token) } else { found });
        found.map(|token| token.actor.clone())
    }

    fn session(&self, secret: &str) -> Option<Actor> {
        let key = digest(secret);
        let mut open = self.open();
        let session = open.get_mut(&key)?;
        if session.heard.elapsed() > IDLE_MAX {
            open.remove(&key);
            return None;
        }
        session.heard = Instant::now();
        Some(session.actor.clone())
    }

    /// Begins a session by a token, and returns the actor and the secret for its cookie.
    ///
    /// # Errors
    /// 401 for a wrong token.
    pub(crate) fn begin_by_token(&self, token: &str) -> ApiResult<(Actor, String)> {
        let actor = self.actor_of(token).ok_or_else(wrong_token)?;
        self.begin(actor)
    }

    /// Begins a session of this machine under another name, where no tokens are needed.
    ///
    /// # Errors
    /// 401 if tokens are needed, 400 for an invalid name, 409 if a session of another role has the name.
    pub(crate) fn begin_by_name(&self, name: &str, role: ActorRole) -> ApiResult<(Actor, String)> {
        if self.required {
            return Err(wrong_token());
        }
        let help = "choose another `name`";
        check_name(name).map_err(|fault| ApiError::bad_request(fault, help))?;
        let taken = |session: &Session| {
            session.actor.name == name && session.actor.role != role && session.heard.elapsed() <= IDLE_MAX
        };
        if name == THIS_MACHINE || self.open().values().any(taken) {
            return Err(ApiError {
                status: StatusCode::CONFLICT,
                error: format!("the name {name} belongs to a caller with another role"),
                help: help.into(),
            });
        }
        self.begin(Actor { name: name.into(), role })
    }

    fn begin(&self, actor: Actor) -> ApiResult<(Actor, String)> {
        let secret = new_secret().map_err(|error| ApiError {
            status: StatusCode::INTERNAL_SERVER_ERROR,
            error,
            help: "try again".into(),
        })?;
        let mut open = self.open();
        if open.len() >= SESSIONS_MAX
            && let Some(oldest) = open.iter().min_by_key(|(_, session)| session.heard).map(|(key, _)| *key)
        {
            open.remove(&oldest);
        }
        open.insert(digest(&secret), Session { actor: actor.clone(), heard: Instant::now() });
        Ok((actor, secret))
    }

    /// Returns the reason for which the caller of this name cannot hold authority: it is unknown, or an observer.
    pub(crate) fn objection_to_holder(&self, name: &str) -> Option<String> {
        let open = self.open();
        let sessions =
            open.values().filter(|session| session.heard.elapsed() <= IDLE_MAX).map(|session| &session.actor);
        let known = self.tokens.iter().map(|token| &token.actor).chain(sessions).filter(|actor| actor.name == name);
        let local = (!self.required && name == THIS_MACHINE).then_some(ActorRole::PilotInCommand);
        match known.map(|actor| actor.role).chain(local).max() {
            None => {
                Some(format!("no caller is called {name}: authority is offered to a caller with a session or a token"))
            }
            Some(ActorRole::Observer) => Some(format!("{name} is an observer, and holds no authority")),
            Some(_) => None,
        }
    }

    /// Ends the session of a request, if it has one.
    pub(crate) fn end(&self, headers: &HeaderMap) {
        if let Some(secret) = self.secret(headers) {
            self.open().remove(&digest(secret));
        }
    }

    fn open(&self) -> MutexGuard<'_, BTreeMap<[u8; 32], Session>> {
        // Every update is complete when the lock is released, even by a panic, so a poisoned lock is usable.
        self.open.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn wrong_token() -> ApiError {
    ApiError {
        status: StatusCode::UNAUTHORIZED,
        error: "unknown token".into(),
        help: "tokens are in the file of `--tokens`, or printed when the server starts".into(),
    }
}

/// Returns the token of an `Authorization` header with the scheme `Bearer`, in any case (RFC 9110, section 11.1).
fn bearer(value: &str) -> Option<&str> {
    let (scheme, token) = value.split_once(' ')?;
    scheme.eq_ignore_ascii_case("bearer").then_some(token)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn headers(name: axum::http::HeaderName, value: &str) -> HeaderMap {
        let mut headers = HeaderMap::new();
        headers.insert(name, value.parse().unwrap());
        headers
    }

    #[test]
    fn a_session_begins_by_a_token_and_ends() {
        let (token, secret) = AccessToken::generate(Actor { name: "tower".into(), role: ActorRole::Operator }).unwrap();
        let sessions = Sessions::new(vec![token], true, 8040);
        assert_eq!(sessions.caller(&HeaderMap::new()).unwrap_err().status, StatusCode::UNAUTHORIZED);
        let lower = headers(AUTHORIZATION, &format!("bearer {secret}"));
        assert!(sessions.caller(&lower).is_ok(), "names of schemes have no case");
        let bearer = headers(AUTHORIZATION, &format!("Bearer {secret}"));
        assert_eq!(sessions.caller(&bearer).unwrap().name, "tower");
        assert!(sessions.caller(&headers(AUTHORIZATION, "Bearer wrong")).is_err());
        assert!(sessions.begin_by_token("wrong").is_err() && sessions.begin_by_name("x", ActorRole::Observer).is_err());
        let (actor, cookie) = sessions.begin_by_token(&secret).unwrap();
        assert_eq!(actor.role, ActorRole::Operator);
        let cookies = headers(COOKIE, &format!("a=b; {COOKIE_NAME}-8040={cookie}"));
        assert_eq!(sessions.caller(&cookies).unwrap(), actor);
        sessions.end(&cookies);
        assert!(sessions.caller(&cookies).is_err());
        assert!(
            sessions.caller(&headers(COOKIE, &format!("{COOKIE_NAME}-8040={secret}"))).is_err(),
            "a token is not a session"
        );
    }

    #[test]
    fn this_machine_needs_no_session_and_may_have_one_by_name() {
        let sessions = Sessions::new(Vec::new(), true, 8040);
        assert_eq!(sessions.caller(&HeaderMap::new()).unwrap().role, ActorRole::PilotInCommand);
        assert!(sessions.caller(&headers(AUTHORIZATION, "Bearer wrong")).is_err());
        let (actor, _) = sessions.begin_by_name("van", ActorRole::Observer).unwrap();
        assert_eq!((actor.name.as_str(), actor.role), ("van", ActorRole::Observer));
        assert_eq!(sessions.begin_by_name("van", ActorRole::Operator).unwrap_err().status, StatusCode::CONFLICT);
        assert!(sessions.begin_by_name("this-machine", ActorRole::Operator).is_err());
        assert!(sessions.begin_by_name("a b", ActorRole::Operator).is_err());
        assert!(
            Sessions::new(Vec::new(), false, 8040).caller(&HeaderMap::new()).is_err(),
            "an open address needs tokens"
        );
    }
}
