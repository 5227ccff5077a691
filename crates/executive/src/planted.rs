//! Deliberate bugs that measure which tests find them. They exist only with the feature `planted-bugs`, which no shipped build has.

/// A bug that can be planted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bug {
    /// A newcomer of equal priority takes the resource from its holder.
    EqualNewcomerWins,
    /// The work of a primitive before its interruption is forgotten.
    ClockStartsOver,
    /// An interrupted task does not end when its `end-when` is satisfied.
    DeafWhileInterrupted,
    /// The steps of a procedure that continues do not claim.
    ChildrenStayBehind,
    /// The higher rank wins.
    RanksReversed,
    /// Ancestors continue before their descendants.
    AncestorsFirst,
    /// A duration that must exceed a limit counts when it equals the limit.
    LongerIsAtLeast,
    /// A value counts as held beyond the gap that is allowed.
    GapToNowForgotten,
    /// A late sample within the permitted lateness is ignored.
    LateSampleIgnored,
    /// Of two samples of one instant, the first one counts.
    FirstDuplicateWins,
    /// A line is trusted across a gap that is too long.
    GapOfLineForgotten,
    /// Any return of a value counts as a turning point, whatever the hysteresis.
    HysteresisForgotten,
    /// A part counts as absent while it continues.
    AbsentWhileItGoesOn,
    /// A sample equal to a bound is not passed to the conditions that wait for it.
    ThresholdMisses,
}

/// All bugs in the monitors of conditions.
pub const IN_MONITORS: [Bug; 7] = [
    Bug::LongerIsAtLeast,
    Bug::GapToNowForgotten,
    Bug::LateSampleIgnored,
    Bug::FirstDuplicateWins,
    Bug::GapOfLineForgotten,
    Bug::HysteresisForgotten,
    Bug::AbsentWhileItGoesOn,
];

/// All bugs in the control of tasks, and in how tasks receive samples.
pub const IN_CONTROL: [Bug; 7] = [
    Bug::EqualNewcomerWins,
    Bug::ClockStartsOver,
    Bug::DeafWhileInterrupted,
    Bug::ChildrenStayBehind,
    Bug::RanksReversed,
    Bug::AncestorsFirst,
    Bug::ThresholdMisses,
];

#[cfg(feature = "planted-bugs")]
static PLANTED: std::sync::atomic::AtomicU8 = std::sync::atomic::AtomicU8::new(0);

/// Activates `bug` in this process; `None` deactivates it.
#[cfg(feature = "planted-bugs")]
pub fn plant(bug: Option<Bug>) {
    let number = bug.map_or(0, |bug| bug as u8 + 1);
    PLANTED.store(number, std::sync::atomic::Ordering::SeqCst);
}

/// Returns true if `bug` is planted.
#[cfg(feature = "planted-bugs")]
pub(crate) fn is(bug: Bug) -> bool {
    PLANTED.load(std::sync::atomic::Ordering::Relaxed) == bug as u8 + 1
}

/// Returns false: builds without the feature have no planted bugs.
#[cfg(not(feature = "planted-bugs"))]
pub(crate) const fn is(_: Bug) -> bool {
    false
}
