//! A requirement on a record, with the message for a record that violates it.

/// Checks that `holds` is true.
///
/// # Errors
/// `otherwise`, if `holds` is false.
pub(super) fn require(holds: bool, otherwise: &str) -> Result<(), String> {
    if holds { Ok(()) } else { Err(otherwise.to_owned()) }
}
