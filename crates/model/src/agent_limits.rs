//! Limits that an agent may set lower for itself: `(agent NAME .. :limits (:tasks 200 :event-history 50))`.
//!
//! The constants and the reasons for their values are in [`crate::limits`]. An agent on a small computer lowers them,
//! and tests lower them to reach them. The word in PDL is the constant's name without its `_MAX`.

use crate::cause::Cause;
use crate::limits;
use serde::{Deserialize, Serialize};

/// A limit that an agent may lower.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Limit {
    /// [`limits::TASKS_MAX`]
    Tasks,
    /// [`limits::TASK_DEPTH_MAX`]
    TaskDepth,
    /// [`limits::FORALL_ITEMS_MAX`]
    ForallItems,
    /// [`limits::REPETITIONS_PER_INSTANT_MAX`]
    RepetitionsPerInstant,
    /// [`limits::CASCADE_ROUNDS_MAX`]
    CascadeRounds,
    /// [`limits::HISTORY_SAMPLES_MAX`]
    HistorySamples,
    /// [`limits::EVENT_HISTORY_MAX`]
    EventHistory,
    /// [`limits::SOLVE_REQUESTS_MAX`]
    SolveRequests,
    /// [`limits::MONITOR_OBJECTS_MAX`]
    MonitorObjects,
    /// [`limits::MONITOR_RESULTS_MAX`]
    MonitorResults,
    /// [`limits::MONITOR_COMBINATIONS_MAX`]
    MonitorCombinations,
    /// [`limits::CUSTOM_VALUES_MAX`]
    CustomValues,
    /// [`limits::MEDIAN_NUMBERS_MAX`]
    MedianNumbers,
    /// [`limits::REPETITIONS_PER_SECOND_MAX`]
    RepetitionsPerSecond,
    /// [`limits::MEMORY_MEBIBYTES_MAX`], which an agent may also raise.
    MemoryMebibytes,
}

impl Limit {
    /// All limits, in the order of messages.
    pub const ALL: [Limit; 15] = [
        Limit::Tasks,
        Limit::TaskDepth,
        Limit::ForallItems,
        Limit::RepetitionsPerInstant,
        Limit::RepetitionsPerSecond,
        Limit::CascadeRounds,
        Limit::HistorySamples,
        Limit::EventHistory,
        Limit::SolveRequests,
        Limit::MonitorObjects,
        Limit::MonitorResults,
        Limit::MonitorCombinations,
        Limit::CustomValues,
        Limit::MedianNumbers,
        Limit::MemoryMebibytes,
    ];

    /// Returns the constant's name, the word in PDL, and the values between which the limit may be set.
    fn facts(self) -> (&'static str, &'static str, u64, u64) {
        let samples_least = limits::HISTORY_SAMPLES_DEFAULT as u64;
        match self {
            Limit::Tasks => ("TASKS_MAX", "tasks", 1, limits::TASKS_MAX as u64),
            Limit::TaskDepth => ("TASK_DEPTH_MAX", "task-depth", 1, u64::from(limits::TASK_DEPTH_MAX)),
            Limit::ForallItems => ("FORALL_ITEMS_MAX", "forall-items", 1, limits::FORALL_ITEMS_MAX as u64),
            Limit::RepetitionsPerInstant => (
                "REPETITIONS_PER_INSTANT_MAX",
                "repetitions-per-instant",
                1,
                u64::from(limits::REPETITIONS_PER_INSTANT_MAX),
            ),
            Limit::RepetitionsPerSecond => (
                "REPETITIONS_PER_SECOND_MAX",
                "repetitions-per-second",
                1,
                u64::from(limits::REPETITIONS_PER_SECOND_MAX),
            ),
            // With fewer rounds than an ordinary instant takes, correct programs would be stopped.
            Limit::CascadeRounds => {
                ("CASCADE_ROUNDS_MAX", "cascade-rounds", 100, u64::from(limits::CASCADE_ROUNDS_MAX))
            }
            Limit::HistorySamples => {
                ("HISTORY_SAMPLES_MAX", "history-samples", samples_least, limits::HISTORY_SAMPLES_MAX as u64)
            }
            Limit::EventHistory => ("EVENT_HISTORY_MAX", "event-history", 1, limits::EVENT_HISTORY_MAX as u64),
            Limit::SolveRequests => ("SOLVE_REQUESTS_MAX", "solve-requests", 1, limits::SOLVE_REQUESTS_MAX as u64),
            Limit::MonitorObjects => ("MONITOR_OBJECTS_MAX", "monitor-objects", 1, limits::MONITOR_OBJECTS_MAX as u64),
            Limit::MonitorResults => ("MONITOR_RESULTS_MAX", "monitor-results", 4, limits::MONITOR_RESULTS_MAX as u64),
            Limit::MonitorCombinations => {
                ("MONITOR_COMBINATIONS_MAX", "monitor-combinations", 1, limits::MONITOR_COMBINATIONS_MAX)
            }
            Limit::CustomValues => ("CUSTOM_VALUES_MAX", "custom-values", 1, limits::CUSTOM_VALUES_MAX as u64),
            Limit::MemoryMebibytes => ("MEMORY_MEBIBYTES_MAX", "memory-mebibytes", 1, 1 << 20),
            Limit::MedianNumbers => ("MEDIAN_NUMBERS_MAX", "median-numbers", 1, limits::MEDIAN_NUMBERS_MAX),
        }
    }

    /// Returns the constant's name in [`crate::limits`], as used in causes.
    pub fn constant(self) -> &'static str {
        self.facts().0
    }

    /// Returns the word in PDL.
    pub fn word(self) -> &'static str {
        self.facts().1
    }

    /// Returns the least permitted value.
    pub fn least(self) -> u64 {
        self.facts().2
    }

    /// Returns the greatest permitted value.
    pub fn most(self) -> u64 {
        self.facts().3
    }

    /// Returns the executive's own limit for an agent that states none: the greatest value, except for memory, because computers differ.
    pub fn usual(self) -> u64 {
        if self == Limit::MemoryMebibytes { limits::MEMORY_MEBIBYTES_MAX } else { self.most() }
    }
}

/// Items of one kind that a log may contain: more than fit into memory.
const LOG_ITEMS_MAX: u64 = 1 << 40;

/// The limits of one agent, or of the monitors of a log.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Limits {
    /// The limits that differ from the executive's, each once.
    set: Vec<(Limit, u64)>,
}

/// The executive's own limits, for code without an agent.
pub const UNLOWERED: &Limits = &Limits { set: Vec::new() };

impl Limits {
    /// Returns the value of `limit`.
    pub fn of(&self, limit: Limit) -> u64 {
        self.set.iter().find(|(each, _)| *each == limit).map_or_else(|| limit.usual(), |(_, value)| *value)
    }

    /// Returns the limit as a number of items in memory.
    pub fn count(&self, limit: Limit) -> usize {
        usize::try_from(self.of(limit)).unwrap_or(usize::MAX)
    }

    /// Sets `limit` to `value`, within the permitted range.
    pub fn lower(&mut self, limit: Limit, value: u64) {
        self.set.retain(|(each, _)| *each != limit);
        let value = value.clamp(limit.least(), limit.most());
        if value != limit.usual() {
            self.set.push((limit, value));
        }
    }

    /// Returns limits for monitors that read a finite log: samples, messages, objects and results are bounded by the log itself, so none
    /// is dropped. The limits of computation remain.
    pub fn of_a_log() -> Limits {
        let kept = [Limit::HistorySamples, Limit::EventHistory, Limit::MonitorObjects, Limit::MonitorResults];
        Limits { set: kept.map(|limit| (limit, LOG_ITEMS_MAX)).to_vec() }
    }

    /// Returns the cause of effects of a reached `limit`.
    pub fn reached(&self, limit: Limit) -> Cause {
        Cause::LimitReached { limit: limit.constant().into(), value: self.of(limit) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_limit_is_the_executives_until_it_is_lowered_and_is_never_raised() {
        let mut limits = Limits::default();
        assert!(Limit::ALL.iter().all(|limit| limits.of(*limit) == limit.usual() && limit.least() < limit.most()));
        limits.lower(Limit::Tasks, 20);
        limits.lower(Limit::HistorySamples, 0);
        assert_eq!((limits.of(Limit::Tasks), limits.of(Limit::HistorySamples)), (20, 2));
        assert_eq!(limits.reached(Limit::Tasks).text(), "the limit TASKS_MAX = 20 was reached");
        limits.lower(Limit::Tasks, u64::MAX);
        assert_eq!(limits, {
            let mut other = Limits::default();
            other.lower(Limit::HistorySamples, 2);
            other
        });
    }

    #[test]
    fn a_log_bounds_what_is_kept_of_it() {
        let limits = Limits::of_a_log();
        let raised = |limit: &Limit| limits.of(*limit) > limit.usual();
        let kept: Vec<&str> = Limit::ALL.iter().filter(|limit| raised(limit)).map(|limit| limit.word()).collect();
        assert_eq!(kept, ["history-samples", "event-history", "monitor-objects", "monitor-results"]);
    }

    #[test]
    fn the_word_is_the_constants_name() {
        for limit in Limit::ALL {
            assert_eq!(limit.word().to_uppercase().replace('-', "_") + "_MAX", limit.constant());
        }
    }
}
