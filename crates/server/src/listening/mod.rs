//! Listening: limited numbers of connections, with time-outs, encrypted if the address is public.
//!
//! `connections` accepts and serves; `stream` is a connection that ends if its peer does not read; `tls` sets up encryption with the
//! user's certificate or a new one.

mod connections;
mod stream;
mod tls;

pub(crate) use connections::{Endpoint, serve_connections};
pub use tls::{TlsError, TlsIdentity};
