//! Move that relocates one target to another position of the cycle.

/// Returns the cycle with the target at `from` moved to `to`.
pub(super) fn relocated(cycle: &[usize], from: usize, to: usize) -> Vec<usize> {
    let mut moved = cycle.to_vec();
    let target = moved.remove(from);
    moved.insert(to.min(moved.len()), target);
    moved
}
