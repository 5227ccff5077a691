//! The addresses of forks and drafts.

use crate::state::AppState;
use crate::what_if::{drafts, forks};
use axum::Router;
use axum::extract::DefaultBodyLimit;
use axum::routing::{get, post};
use std::sync::Arc;

/// Bytes of the largest body: an order of a thousand visits.
const BODY_MAX_BYTES: usize = 64 << 10;

/// Returns the routes.
pub(crate) fn routes() -> Router<Arc<AppState>> {
    Router::new()
        .route("/api/forks", get(forks::list).post(forks::begin))
        .route("/api/forks/{id}/stop", post(forks::stop))
        .route("/api/drafts", post(drafts::draft))
        .layer(DefaultBodyLimit::max(BODY_MAX_BYTES))
}
