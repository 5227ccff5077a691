//! What was asked of a profile that cannot be done, for operators.

use std::fmt;

/// A request that cannot be met: what, why, and what to do.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ProfileError {
    /// What cannot be done.
    pub message: String,
    /// Why, where the message does not say it.
    pub reason: Option<String>,
    /// What to do.
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
