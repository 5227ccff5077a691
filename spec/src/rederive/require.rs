//! A demand on a record, with what to say where it is not met.

/// # Errors
/// `otherwise`, unless it holds.
pub(super) fn require(holds: bool, otherwise: &str) -> Result<(), String> {
    if holds { Ok(()) } else { Err(otherwise.to_owned()) }
}
