//! Texts that a program requires, and the answer to one that cannot be read.

/// A text that another text needs.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Requirement {
    /// `(require-apex-library "name")` or an entry of `:libraries`.
    Library(String),
    /// `(require-apex-file "name")` or an entry of `:files`.
    File {
        /// The name as written.
        name: String,
        /// The source that requires it, as named in its [`SourceText`](crate::SourceText).
        from: String,
    },
}

/// A required text that cannot be read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unresolved {
    /// The reason in one line.
    pub reason: String,
    /// Names that exist: one of them may be meant.
    pub names: Vec<String>,
}

impl From<String> for Unresolved {
    fn from(reason: String) -> Unresolved {
        Unresolved { reason, names: Vec::new() }
    }
}

impl From<&str> for Unresolved {
    fn from(reason: &str) -> Unresolved {
        reason.to_string().into()
    }
}
