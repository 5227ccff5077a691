//! The web face of Apex: serves one flight record, and the page (Sherpa) that draws it, over HTTP and WebSocket.
//!
//! What lives here: the only JSON that the web knows (`docs/reference/server-api.md`), read from a flight record
//! (`docs/reference/flight-record.md`) by read-only queries. A record that is still being written is read the same
//! way and polled, so that live and recorded flights have one path. What does not live here: decisions, planning,
//! any writing into the record.

mod answer;
mod assets;
pub mod explain;
mod guard;
mod index;
mod live;
mod queries;
mod record;
mod router;
mod serve;

pub use explain::Explainer;
pub use serve::{ServeError, ServeOptions, serve};
