//! `/api/live`: a WebSocket that reports the growth of the record.
//!
//! The server polls the record and not the program that writes it, so that a second, a crashed and a finished process need no
//! distinction. Bound: one small query per client and poll.

use crate::state::AppState;
use apex_runtime::record::view::Growth;
use axum::extract::ws::{Message, Utf8Bytes, WebSocket};
use std::sync::Arc;
use std::time::Duration;

/// Interval of polls: faster than a viewer needs, and cheap.
const POLL: Duration = Duration::from_millis(250);

/// Sends `{end_ns, batches, status}` at once and whenever it changes, until the client leaves or the record is
/// complete.
pub(crate) async fn tell_growth(mut socket: WebSocket, state: Arc<AppState>) {
    let mut sent: Option<Growth> = None;
    let mut tick = tokio::time::interval(POLL);
    loop {
        tokio::select! {
            message = socket.recv() => match message {
                Some(Ok(Message::Close(_)) | Err(_)) | None => return,
                Some(Ok(_)) => continue,
            },
            _ = tick.tick() => {}
        }
        let state = Arc::clone(&state);
        let look = tokio::task::spawn_blocking(move || state.read(|view| Ok(state.with_life(view.growth()?)))).await;
        let Ok(Ok(now)) = look else {
            // The record is temporarily busy or missing; the next poll may succeed.
            continue;
        };
        if sent.as_ref() == Some(&now) {
            continue;
        }
        let Ok(text) = serde_json::to_string(&now) else { return };
        if socket.send(Message::Text(Utf8Bytes::from(text))).await.is_err() {
            return;
        }
        if now.status.is_final() {
            let _ = socket.send(Message::Close(None)).await;
            return;
        }
        sent = Some(now);
    }
}
