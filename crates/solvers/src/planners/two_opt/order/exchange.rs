//! Move that exchanges two targets.

/// Returns the cycle with the targets at `from` and `to` exchanged.
pub(super) fn exchanged(cycle: &[usize], from: usize, to: usize) -> Vec<usize> {
    let mut exchanged = cycle.to_vec();
    exchanged.swap(from, to);
    exchanged
}
