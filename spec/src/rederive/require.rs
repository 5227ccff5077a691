//! A requirement on a record, with the message for a record that violates it.

/// # Errors
/// `otherwise`, unless it holds.
pub(super) fn require(holds: bool, otherwise: &str) -> Result<(), String> {
    if holds { Ok(()) } else { Err(otherwise.to_owned()) }
}
