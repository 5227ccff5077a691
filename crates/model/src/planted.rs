//! A bug planted on purpose, to measure what finds it. Only with the feature `planted-bugs`, which no shipped build has;
//! those of the executive stand in its own list.

#[cfg(feature = "planted-bugs")]
static THRESHOLD_MISSES: std::sync::atomic::AtomicBool = std::sync::atomic::AtomicBool::new(false);

/// From now on in this process, or no more: a sample that is just at an upper threshold is told to nobody there.
#[cfg(feature = "planted-bugs")]
pub fn let_thresholds_miss(miss: bool) {
    THRESHOLD_MISSES.store(miss, std::sync::atomic::Ordering::SeqCst);
}

#[cfg(feature = "planted-bugs")]
pub(crate) fn threshold_misses() -> bool {
    THRESHOLD_MISSES.load(std::sync::atomic::Ordering::Relaxed)
}

/// Nothing is planted in a build without the feature.
#[cfg(not(feature = "planted-bugs"))]
pub(crate) const fn threshold_misses() -> bool {
    false
}
