//! Access: tokens and sessions (`sessions`), the table of addresses and roles (`table`), the check of every request
//! (`check`), the address `/api/session` (`routes`).
//!
//! On a loopback address a caller without a session is this machine, as pilot in command. Elsewhere, and where tokens are
//! given, every address of the API but `/api/session` needs a session or a token.

mod check;
#[cfg(test)]
mod matrix_tests;
pub(crate) mod routes;
mod sessions;
mod stations;
mod table;
mod token;

pub(crate) use check::{Caller, check};
#[cfg(test)]
pub(crate) use routes::SessionState;
pub(crate) use sessions::Sessions;
pub use token::{AccessToken, TokenError};
