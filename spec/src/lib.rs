//! Specification pages: Markdown that describes the meaning of the language and can be run.
//!
//! A page is parsed into blocks ([`page`]). Each `trace` block is one run of the program before it ([`scenario`]), reported in short
//! lines ([`projection`]) and compared with the page ([`diff`]); a `why` block queries the record of the run ([`question`]). See
//! `README.md` for the blocks.

pub mod coverage;
pub mod data_file;
pub mod diagnosis;
pub mod diff;
pub mod explained;
pub mod late;
pub mod observed;
pub mod outside;
pub mod page;
pub mod projection;
pub mod question;
pub mod reasons;
pub mod rederive;
pub mod rules;
pub mod scenario;
pub mod verdict;
