//! Errors of requests for profiles, for operators.

use std::fmt;

/// A request that cannot be met: failure, reason and remedy.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ProfileError {
    /// Failed request.
    pub message: String,
    /// Reason, if the message does not state it.
    pub reason: Option<String>,
    /// Remedy.
    pub help: String,
}

impl ProfileError {
    pub(crate) fn new(message: impl Into<String>, help: impl Into<String>) -> ProfileError {
        ProfileError { message: message.into(), reason: None, help: help.into() }
    }

    pub(crate) fn because(self, reason: impl Into<String>) -> ProfileError {
        ProfileError { reason: Some(reason.into()), ..self }
    }
}

impl fmt::Display for ProfileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.message)?;
        self.reason.iter().try_for_each(|reason| write!(f, " ({reason})"))?;
        write!(f, ": {}", self.help)
    }
}

impl std::error::Error for ProfileError {}
