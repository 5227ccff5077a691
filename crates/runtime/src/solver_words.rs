//! Texts of solvers that enter the record, cut to a bounded length.

use crate::limits::SOLVER_WORDS_MAX;
use std::any::Any;

/// Shortens a reason: no solver fills the record.
pub(crate) fn short(reason: &str) -> String {
    match reason.char_indices().nth(SOLVER_WORDS_MAX) {
        None => reason.to_string(),
        Some((end, _)) => {
            let kept = reason.get(..end).unwrap_or_default();
            format!("{kept}.. ({} bytes more)", reason.len().saturating_sub(end))
        }
    }
}

/// Returns the message of a panic.
pub(crate) fn panic_text(payload: &(dyn Any + Send)) -> String {
    let text = payload.downcast_ref::<&str>().map(|text| (*text).to_owned());
    text.or_else(|| payload.downcast_ref::<String>().cloned()).unwrap_or_else(|| "it gave no message".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reason_is_kept_short() {
        assert_eq!(short("no way"), "no way");
        let long = short(&"é".repeat(100_000));
        assert!(long.chars().count() < SOLVER_WORDS_MAX + 40 && long.contains("bytes more"), "{long}");
    }
}
