//! Flights continued with changes (`/api/forks`), and orders of visits planned and checked without flying them
//! (`/api/drafts`).

mod drafts;
mod fork_list;
mod forks;
mod request;
pub(crate) mod routes;
mod service;

#[cfg(test)]
pub(crate) use drafts::{DraftAnswer, DraftViolation, Worth};
#[cfg(test)]
pub(crate) use fork_list::ForkState;
#[cfg(test)]
pub(crate) use request::{ForkRequest, InputRequest};
pub(crate) use service::WhatIf;
