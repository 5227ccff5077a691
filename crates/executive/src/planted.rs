//! Bugs planted on purpose, to measure what finds them. Only with the feature `planted-bugs`, which no shipped build has.

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
    /// A duration that must be longer than a limit need only reach it.
    LongerIsAtLeast,
    /// A value counts as held beyond the gap that is allowed.
    GapToNowForgotten,
    /// A sample that comes late, but not too late, is not considered.
    LateSampleIgnored,
    /// Of two samples of one instant the first counts.
    FirstDuplicateWins,
    /// A line is trusted across a gap that is too long.
    GapOfLineForgotten,
    /// A value turns as soon as it comes back at all.
    HysteresisForgotten,
    /// Something counts as absent while it continues.
    AbsentWhileItGoesOn,
    /// A sample just at a bound is not reported to the conditions that wait for it.
    ThresholdMisses,
}

/// All in the monitors of conditions.
pub const IN_MONITORS: [Bug; 7] = [
    Bug::LongerIsAtLeast,
    Bug::GapToNowForgotten,
    Bug::LateSampleIgnored,
    Bug::FirstDuplicateWins,
    Bug::GapOfLineForgotten,
    Bug::HysteresisForgotten,
    Bug::AbsentWhileItGoesOn,
];

/// All in the control of tasks, and in how tasks receive samples.
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

/// Plants `bug` in this process; none takes out what was planted.
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
