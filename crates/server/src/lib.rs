//! The web server of Apex: serves one flight record, and the page (Sherpa) that draws it, over HTTP and WebSocket.
//!
//! Contents: addresses, parameters, status codes, and the page's files (`docs/reference/server-api.md`). Answers come unchanged from the
//! record view and the explainer of `apex-runtime`. A record that is still being written is read in the same way and polled, so that live
//! and recorded flights share one path. With a folder of missions the server also flies them, through `apex-simulation`. Out of scope:
//! SQL, decisions, planning, writing into the served record.

mod access;
mod answer;
mod assets;
mod flights;
mod guard;
mod hardening;
mod listening;
mod live;
mod mission_facts;
mod operation;
mod params;
mod prepared_access;
mod router;
mod scored_flight;
mod seen;
mod seen_ground;
mod serve;
mod shelf;
mod shelf_routes;
mod state;
#[cfg(test)]
mod typescript;
mod what_if;
mod why;

pub use access::{AccessToken, TokenError};
pub use flights::FlightOptions;
pub use listening::{TlsError, TlsIdentity};
pub use operation::{FlightDoor, FlightWatch, ReadDatum};
pub use prepared_access::AccessFiles;
pub use serve::{AccessOptions, ServeError, ServeOptions, serve};
pub use state::LoadSources;
