//! Flights continued with changes (`/api/forks`), and orders of visits planned and checked without flying them
//! (`/api/drafts`).

mod drafts;
mod fork_list;
mod forks;
mod request;
pub(crate) mod routes;
mod service;

pub(crate) use service::WhatIf;
