//! Specification pages: Markdown that tells what the language means, and runs.
//!
//! A page is read into blocks ([`page`]), each `trace` block is one run of the program before it ([`scenario`]), told in a
//! few words a line ([`projection`]) and compared with what the page says ([`diff`]); a `why` block asks its record
//! ([`question`]). See `README.md` for the blocks.

pub mod coverage;
pub mod data_file;
pub mod diagnosis;
pub mod diff;
pub mod explained;
pub mod late;
pub mod outside;
pub mod page;
pub mod projection;
pub mod question;
pub mod reasons;
pub mod rederive;
pub mod rules;
pub mod scenario;
pub mod verdict;

/// The guide on functions of the host program: its example runs as a test.
#[cfg(doctest)]
#[doc = include_str!("../../docs/guides/host-functions.md")]
pub struct HostFunctionsGuide;
