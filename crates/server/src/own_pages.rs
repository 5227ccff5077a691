//! Lets only this machine command flights.

use crate::answer::ApiError;
use crate::guard;
use crate::state::Shared;
use axum::extract::{Request, State};
use axum::http::Method;
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

/// Lets only programs and pages of this machine start and stop flights.
pub(crate) async fn own_pages_only(State(state): Shared, request: Request, next: Next) -> Response {
    if request.method() == Method::POST {
        let refused = if !guard::same_origin(request.headers()) {
            Some(("this page comes from another site", "open the page that this server serves"))
        } else if !state.loopback {
            Some((
                "this server flies no missions: it answers to other machines, and has no password",
                "start it without `--address`, or with 127.0.0.1",
            ))
        } else {
            None
        };
        if let Some((error, help)) = refused {
            return ApiError::forbidden(error, help).into_response();
        }
    }
    next.run(request).await
}
