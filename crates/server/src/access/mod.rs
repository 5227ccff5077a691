//! Access: tokens and sessions (`sessions`), the table of addresses and roles (`table`), the check of every request
//! (`check`), the address `/api/session` (`routes`).
//!
//! On a loopback address a caller without a session is the local user, as pilot in command. On other addresses, and if tokens are
//! configured, every address of the API except `/api/session` needs a session or a token.

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
