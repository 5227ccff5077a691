//! Places in source text, so that every decision can name the line of PDL it comes from.

use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A position in a source file of the library. Line and column count from 1; columns count characters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize)]
pub struct Place {
    /// Index into [`crate::library::Library::sources`].
    pub file: u32,
    /// Line, from 1.
    pub line: u32,
    /// Column, from 1.
    pub column: u32,
}

/// One source text of a library, kept so that messages and the flight record can show it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SourceFile {
    /// The name to print: a path as the user wrote it, or `<plan 3>` for a generated procedure.
    pub name: Arc<str>,
    /// The whole text.
    pub text: Arc<str>,
}
