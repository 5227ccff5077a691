//! Listening: connections within caps, with time-outs, encrypted where the address is open.
//!
//! `connections` accepts and serves; `stream` is a connection that ends when its peer does not read; `tls` makes the
//! encryption from a certificate of the user or a new one.

mod connections;
mod stream;
mod tls;

pub(crate) use connections::{Endpoint, serve_connections};
pub use tls::{TlsError, TlsIdentity};
