//! Answers of the API: JSON bodies, and errors as `{error, help}` with the right status, and `remedy` where the page has other words.

use apex_runtime::RecordError;
use axum::Json;
use axum::http::header::WWW_AUTHENTICATE;
use axum::http::{HeaderValue, StatusCode};
use axum::response::{IntoResponse, Response};
use serde::Serialize;

/// Answer of the API to a request that it cannot fulfil.
#[derive(Debug)]
pub(crate) struct ApiError {
    /// The HTTP status.
    pub(crate) status: StatusCode,
    /// Failure, in one sentence.
    pub(crate) error: String,
    /// Remedy.
    pub(crate) help: Help,
}

/// Remedy of an error, as text for callers of the API.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Help {
    pub(crate) text: String,
    /// Kind of the remedy, if readers of the page need other words: they have panels instead of addresses.
    pub(crate) remedy: Option<Remedy>,
}

/// Kind of a remedy for which the page has words.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Remedy {
    /// Begin a session with a token.
    Session,
    /// Begin a session with the token of another role.
    Role,
    /// Choose a task that exists.
    Tasks,
    /// Choose a record that exists.
    Records,
}

impl Remedy {
    /// Returns the remedy with its text for callers of the API.
    pub(crate) fn help(self, text: &str) -> Help {
        Help { text: text.to_owned(), remedy: Some(self) }
    }
}

impl From<String> for Help {
    fn from(text: String) -> Help {
        Help { text, remedy: None }
    }
}

impl From<&str> for Help {
    fn from(text: &str) -> Help {
        text.to_owned().into()
    }
}

/// Every handler's result.
pub(crate) type ApiResult<T> = Result<T, ApiError>;

#[derive(Serialize)]
struct ErrorBody {
    error: String,
    help: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    remedy: Option<Remedy>,
}

impl ApiError {
    /// Returns the error for a request that is itself wrong (400).
    pub(crate) fn bad_request(error: impl Into<String>, help: impl Into<Help>) -> ApiError {
        ApiError { status: StatusCode::BAD_REQUEST, error: error.into(), help: help.into() }
    }

    /// Returns the error for something that does not exist (404).
    pub(crate) fn not_found(error: impl Into<String>, help: impl Into<Help>) -> ApiError {
        ApiError { status: StatusCode::NOT_FOUND, error: error.into(), help: help.into() }
    }

    /// Returns the error for a request that this caller may not make (403).
    pub(crate) fn forbidden(error: impl Into<String>, help: impl Into<Help>) -> ApiError {
        ApiError { status: StatusCode::FORBIDDEN, error: error.into(), help: help.into() }
    }
}

impl From<RecordError> for ApiError {
    fn from(error: RecordError) -> ApiError {
        if let RecordError::Question(error) = error {
            return ApiError::bad_request(error, "`/api/mission` states the first and the last instant of the record");
        }
        ApiError {
            status: StatusCode::INTERNAL_SERVER_ERROR,
            error: error.to_string(),
            help: "if the file was moved or replaced, serve it again; `apex recover` saves the valid part of a damaged file".into(),
        }
    }
}

impl IntoResponse for ApiError {
    fn into_response(self) -> Response {
        let is_challenge = self.status == StatusCode::UNAUTHORIZED;
        let Help { text: help, remedy } = self.help;
        let mut response = (self.status, Json(ErrorBody { error: self.error, help, remedy })).into_response();
        if is_challenge {
            response.headers_mut().insert(WWW_AUTHENTICATE, HeaderValue::from_static("Bearer"));
        }
        response
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_question_that_has_no_answer_is_no_fault_of_the_server() {
        let question = RecordError::Question("The flight begins at 0s; nothing was decided by -5s.".into());
        assert_eq!(ApiError::from(question).status, StatusCode::BAD_REQUEST);
        let damage = RecordError::Damaged { path: "f.apex".into(), what: "its schema cannot be read".into() };
        assert_eq!(ApiError::from(damage).status, StatusCode::INTERNAL_SERVER_ERROR);
    }
}
