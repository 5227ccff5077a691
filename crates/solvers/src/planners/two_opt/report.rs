//! Type of the callback that receives each better cycle of the search.

/// Callback that receives the cost of each better cycle, and the cycle.
pub(super) type CycleObserver<'r> = &'r mut dyn FnMut(f64, &[usize]);
