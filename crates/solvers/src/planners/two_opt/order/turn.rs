//! Move that reverses a part of the cycle.

/// Returns the cycle with the part from `from` to `to` reversed.
pub(super) fn turned(cycle: &[usize], from: usize, to: usize) -> Vec<usize> {
    let mut turned = cycle.to_vec();
    if let Some(part) = turned.get_mut(from..=to) {
        part.reverse();
    }
    turned
}
