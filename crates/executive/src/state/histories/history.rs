//! Histories: samples and messages, as far back as a clause may still read (paper, section III).
//!
//! A history is a ring of samples in order of time. Its length follows from conditions, queries and log policies, within the hard limits
//! of [`apex_model::limits`]. What was dropped is remembered as one instant, so that a query about the time before it is answered with
//! "unknown", never with "no".

use crate::state::histories::event_log::EventLogs;
use crate::state::histories::history_table::HistoryTable;
use crate::state::recorded::Recorded;
use apex_model::agent_limits::{Limit, Limits};
use apex_model::event::StateVariable;
use apex_model::limits::{EVENT_HISTORY_MAX, HISTORY_SAMPLES_DEFAULT, HISTORY_SAMPLES_MAX, LATE_SAMPLES_MAX};
use apex_model::symbol::Symbol;
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, VecDeque};

/// One measurement.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sample {
    /// Instant of the measurement.
    pub at: Time,
    /// Arrival number of its event.
    pub sequence: u64,
    /// The value.
    pub value: Value,
}

/// One message.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Occurrence {
    /// Instant of the message.
    pub at: Time,
    /// Arrival number of its event.
    pub sequence: u64,
    /// Its form.
    pub form: Value,
}

impl Occurrence {
    /// Returns the symbol that the message begins with, or is.
    pub fn head(&self) -> Option<&Symbol> {
        let head = match &self.form {
            Value::List(items) => items.first()?,
            other => other,
        };
        head.as_symbol()
    }
}

/// The samples of one state variable, and the counts of unusual ones.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct History {
    samples: VecDeque<Sample>,
    late: VecDeque<Sample>,
    /// Number of samples that arrived later than the variable's lateness allows.
    pub late_count: u64,
    /// Number of samples that replaced another value of the same instant.
    pub replaced_count: u64,
    /// Number of samples whose value is not a number or could not be computed.
    pub missing_count: u64,
    /// The first arrival number of each instant whose sample was replaced.
    #[serde(with = "crate::state::pairs")]
    first_arrivals: BTreeMap<Time, u64>,
    /// The newest instant of a sample that is no longer kept.
    pub forgotten_until: Option<Time>,
    /// True if samples that conditions or logs require were dropped at the limit.
    #[serde(default)]
    overflowed: bool,
    retention: Retention,
}

/// Amount of history that is kept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Retention {
    lookback: Duration,
    lateness: Duration,
    log_time: Duration,
    log_count: u64,
    /// The smallest spacing of samples kept for logs alone; zero keeps all.
    log_spacing: Duration,
}

/// Limits of one open `(log ..)` policy.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OpenLog {
    /// Variable whose samples are logged.
    pub variable: StateVariable,
    /// Minimum time between kept samples; zero keeps all.
    pub spacing: Duration,
    /// Maximum age of kept samples.
    pub time: Duration,
    /// Maximum number of kept samples.
    pub count: u64,
}

/// Upper limits of the kept data; by default the limits of the executive.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Most {
    samples: usize,
    events: usize,
    /// Number of messages and samples from outside at the newest instant: that many more messages may be kept.
    #[serde(default)]
    burst: usize,
}

impl Default for Most {
    fn default() -> Most {
        Most { samples: HISTORY_SAMPLES_MAX, events: EVENT_HISTORY_MAX, burst: 0 }
    }
}

/// All histories of an agent.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Histories {
    #[serde(default)]
    most: Most,
    /// True if messages that conditions require were dropped at the limit.
    #[serde(default)]
    events_overflowed: bool,
    variables: HistoryTable,
    lookbacks: BTreeMap<Symbol, Duration>,
    lookback_of_all: Duration,
    logs: BTreeMap<u64, OpenLog>,
    next_log: u64,
    events: VecDeque<Occurrence>,
    events_forgotten_until: Option<Time>,
    event_lookback: Duration,
    #[serde(default)]
    event_logs: EventLogs,
}

impl Histories {
    /// Returns the number of samples and messages that are kept.
    pub(crate) fn sample_count(&self) -> usize {
        self.variables.iter().map(|(_, history)| history.samples.len()).sum::<usize>() + self.events.len()
    }
}

impl History {
    /// Returns all samples kept, oldest first.
    pub fn samples(&self) -> impl DoubleEndedIterator<Item = &Sample> + ExactSizeIterator {
        self.samples.iter()
    }

    /// Returns the samples kept aside because they came too late, in order of arrival.
    pub fn late_samples(&self) -> impl Iterator<Item = &Sample> {
        self.late.iter()
    }

    /// Returns the newest sample.
    pub fn newest(&self) -> Option<&Sample> {
        self.samples.back()
    }

    /// Returns the latest sample at or before `instant`.
    pub fn at(&self, instant: Time) -> Option<&Sample> {
        self.latest(|sample| sample.at <= instant)
    }

    /// Returns the latest sample strictly before `instant`.
    pub fn before(&self, instant: Time) -> Option<&Sample> {
        self.latest(|sample| sample.at < instant)
    }

    /// Returns the latest sample of those that are `early`, which are the first ones. Mostly that is one of the last two.
    fn latest(&self, early: impl Fn(&Sample) -> bool) -> Option<&Sample> {
        let near = self.samples.iter().rev().take(2).find(|sample| early(sample));
        near.or_else(|| self.samples.get(self.samples.partition_point(early).checked_sub(1)?))
    }

    /// Returns the samples with `start <= at <= end`, oldest first.
    pub fn between(&self, start: Time, end: Time) -> impl DoubleEndedIterator<Item = &Sample> {
        let first = self.samples.partition_point(|sample| sample.at < start);
        let last = self.samples.partition_point(|sample| sample.at <= end).max(first);
        self.samples.range(first..last)
    }

    /// Returns true if the limit forced out a sample that a condition may still need.
    pub fn has_overflowed(&self) -> bool {
        self.overflowed
    }

    /// Returns true when every sample at or after `instant` is still kept.
    pub fn covers(&self, instant: Time) -> bool {
        self.forgotten_until.is_none_or(|forgotten| forgotten < instant)
    }

    /// Returns the arrival number at which the variable was first known at the instant of `sample`: its own, unless it replaced an
    /// earlier sample of the same instant.
    pub fn first_arrival(&self, sample: &Sample) -> u64 {
        if self.first_arrivals.is_empty() {
            return sample.sequence;
        }
        self.first_arrivals.get(&sample.at).copied().unwrap_or(sample.sequence)
    }

    /// Records a sample within the lateness that was last required; at most `samples_max` are kept.
    pub fn record(&mut self, sample: Sample, samples_max: usize) -> Recorded {
        if matches!(&sample.value, Value::Real(real) if real.is_nan())
            || matches!(&sample.value, Value::Quantity(quantity) if quantity.si.is_nan())
        {
            self.missing_count = self.missing_count.saturating_add(1);
            return Recorded::Missing;
        }
        let newest = self.samples.back().map(|newest| newest.at);
        let recorded = match newest {
            Some(newest) if sample.at <= newest => self.record_out_of_order(sample, newest),
            _ => {
                self.samples.push_back(sample);
                Recorded::Appended
            }
        };
        self.trim(samples_max);
        recorded
    }

    fn record_out_of_order(&mut self, sample: Sample, newest: Time) -> Recorded {
        let index = self.samples.partition_point(|kept| kept.at < sample.at);
        if let Some(kept) = self.samples.get_mut(index).filter(|kept| kept.at == sample.at) {
            if kept.value.equals(&sample.value) {
                return Recorded::Repeated;
            }
            // A sample that arrives too late does not replace one either: the result would depend on which samples are still kept.
            if newest - sample.at <= self.retention.lateness {
                self.first_arrivals.entry(kept.at).or_insert(kept.sequence);
                *kept = sample;
                self.replaced_count = self.replaced_count.saturating_add(1);
                return Recorded::Replaced;
            }
        }
        if newest - sample.at > self.retention.lateness || !self.covers(sample.at) {
            self.late_count = self.late_count.saturating_add(1);
            self.late.push_back(sample);
            if self.late.len() > LATE_SAMPLES_MAX {
                self.late.pop_front();
            }
            return Recorded::TooLate;
        }
        self.samples.insert(index, sample);
        Recorded::Inserted
    }

    /// Returns true if recording a sample of the instant `at` once more changes nothing: it is the newest, equals itself, and no sample
    /// is thinned for a log meanwhile.
    pub(crate) fn ignores_repetition(&self, at: Time) -> bool {
        let Retention { lookback, log_spacing, .. } = self.retention;
        let is_thinned = lookback == Duration::ZERO && log_spacing > Duration::ZERO;
        let newest = self.samples.back().filter(|newest| newest.at == at);
        !is_thinned && newest.is_some_and(|newest| newest.value.equals(&newest.value))
    }

    /// Drops samples that no clause can need any longer; constant time on average.
    fn trim(&mut self, samples_max: usize) {
        self.thin();
        let Some(newest) = self.samples.back().map(|sample| sample.at) else { return };
        let Retention { lookback, lateness, log_time, log_count, .. } = self.retention;
        let needed_from = newest - (lookback + lateness);
        let log_from = newest - log_time;
        let log_count = usize::try_from(log_count).unwrap_or(usize::MAX);
        while self.samples.len() > HISTORY_SAMPLES_DEFAULT {
            let Some(oldest) = self.samples.front().map(|sample| sample.at) else { return };
            // The sample before the window's edge is kept too: its value holds at the edge.
            let next = self.samples.get(1).map_or(oldest, |sample| sample.at);
            let asked = lookback > Duration::ZERO && next > needed_from;
            let logged = log_count >= self.samples.len() && oldest >= log_from;
            if asked || logged {
                if self.samples.len() <= samples_max {
                    return;
                }
                self.overflowed = true;
            }
            self.samples.pop_front();
            self.forget(oldest);
        }
    }

    /// Thins samples that only logs require to the density of the densest log.
    fn thin(&mut self) {
        let Retention { lookback, log_spacing, .. } = self.retention;
        if lookback > Duration::ZERO || log_spacing == Duration::ZERO {
            return;
        }
        let Some(index) = self.samples.len().checked_sub(HISTORY_SAMPLES_DEFAULT + 1).filter(|index| *index > 0) else {
            return;
        };
        let close = match (self.samples.get(index - 1), self.samples.get(index)) {
            (Some(before), Some(sample)) => sample.at - before.at < log_spacing,
            _ => false,
        };
        // Not counted as dropped: the log requested a history of this density.
        if close {
            self.samples.remove(index);
        }
    }

    fn forget(&mut self, at: Time) {
        while self.first_arrivals.first_key_value().is_some_and(|(first, _)| *first <= at) {
            self.first_arrivals.pop_first();
        }
        self.forgotten_until = Some(self.forgotten_until.map_or(at, |before| before.max(at)));
    }
}

impl Histories {
    /// Keeps no more than an agent with these limits may.
    pub fn limit(&mut self, limits: &Limits) {
        self.most = Most {
            samples: limits.count(Limit::HistorySamples),
            events: limits.count(Limit::EventHistory),
            ..self.most
        };
    }

    /// Returns the history of `variable`, if it has samples.
    pub fn get(&self, variable: &StateVariable) -> Option<&History> {
        self.variables.get(variable)
    }

    /// Returns the history of `variable`, mutably, for callers that record many samples.
    pub fn get_mut(&mut self, variable: &StateVariable) -> Option<&mut History> {
        self.variables.get_mut(variable)
    }

    /// Returns all variables ever measured, in order, with their histories.
    pub fn iter(&self) -> impl Iterator<Item = (&StateVariable, &History)> {
        self.variables.iter()
    }

    /// Returns the variables of one attribute, in order of their objects.
    pub fn of_attribute(&self, attribute: &Symbol) -> impl Iterator<Item = (&StateVariable, &History)> {
        self.variables.of_attribute(attribute)
    }

    /// Records a sample of `variable`. `lateness` is the permitted lateness (zero: none). The flag is true if a sample that a clause may
    /// need was dropped at the limit for the first time.
    pub fn record(&mut self, variable: &StateVariable, sample: Sample, lateness: Duration) -> (Recorded, bool) {
        if let Some(history) = self.variables.get_mut(variable) {
            history.retention.lateness = lateness;
            let before = history.overflowed;
            let recorded = history.record(sample, self.most.samples);
            return (recorded, history.overflowed && !before);
        }
        let mut history = History { retention: self.retention_of(variable), ..History::default() };
        history.retention.lateness = lateness;
        let recorded = history.record(sample, self.most.samples);
        self.variables.insert(variable.clone(), history);
        (recorded, false)
    }

    /// Counts a value of `variable` that could not be computed as a missing measurement; returns the count.
    pub(crate) fn note_missing(&mut self, variable: &StateVariable) -> u64 {
        if self.variables.get(variable).is_none() {
            let history = History { retention: self.retention_of(variable), ..History::default() };
            self.variables.insert(variable.clone(), history);
        }
        self.variables.get_mut(variable).map_or(0, |history| {
            history.missing_count = history.missing_count.saturating_add(1);
            history.missing_count
        })
    }

    /// Records that a clause may need samples of `attribute` up to `lookback` before the newest.
    pub fn require_lookback(&mut self, attribute: &Symbol, lookback: Duration) {
        let slot = self.lookbacks.entry(attribute.clone()).or_default();
        *slot = (*slot).max(lookback);
        let lookback = (*slot).max(self.lookback_of_all);
        let of_attribute = |variable: &StateVariable| variable.attribute == *attribute;
        self.variables.change(of_attribute, |history| history.retention.lookback = lookback);
    }

    /// Records that a clause may need samples of any attribute up to `lookback` before the newest.
    pub fn require_lookback_of_all(&mut self, lookback: Duration) {
        self.lookback_of_all = self.lookback_of_all.max(lookback);
        self.variables
            .change(|_| true, |history| history.retention.lookback = history.retention.lookback.max(lookback));
    }

    /// Opens a log policy and returns the number that closes it.
    pub fn open_log(&mut self, log: OpenLog) -> u64 {
        let number = self.next_log;
        self.next_log = self.next_log.saturating_add(1);
        let variable = log.variable.clone();
        self.logs.insert(number, log);
        self.refresh(&variable);
        number
    }

    /// Closes a log policy. Samples that only it kept are dropped with the next sample that arrives.
    pub fn close_log(&mut self, number: u64) {
        if let Some(log) = self.logs.remove(&number) {
            self.refresh(&log.variable);
        }
        self.event_logs.close(number);
    }

    fn refresh(&mut self, variable: &StateVariable) {
        let retention = self.retention_of(variable);
        if let Some(history) = self.variables.get_mut(variable) {
            let lateness = history.retention.lateness;
            history.retention = Retention { lateness, ..retention };
        }
    }

    /// Returns the combined demand of the conditions and of the least restrictive open policies.
    fn retention_of(&self, variable: &StateVariable) -> Retention {
        let mut retention = Retention {
            lookback: self.lookbacks.get(&variable.attribute).copied().unwrap_or_default().max(self.lookback_of_all),
            ..Retention::default()
        };
        let mut spacing = None;
        for log in self.logs.values().filter(|log| log.variable == *variable) {
            retention.log_time = retention.log_time.max(log.time);
            retention.log_count = retention.log_count.max(log.count);
            spacing = Some(spacing.map_or(log.spacing, |least: Duration| least.min(log.spacing)));
        }
        retention.log_spacing = spacing.unwrap_or_default();
        retention
    }
}

mod events;
#[cfg(test)]
mod tests;
