//! The memory of messages: those that conditions need, and those that are logged by first words.

use super::{Histories, Occurrence};
use crate::state::histories::event_log::OpenEventLog;
use apex_model::symbol::Symbol;
use apex_model::time::{Duration, Time};

impl Histories {
    /// Records a message. Returns true if an earlier one that a clause may need was dropped at the limit for the first time.
    pub fn record_event(&mut self, event: Occurrence) -> bool {
        let before = self.events_overflowed;
        let log_overflows = self.event_logs.record(&event, self.most.events);
        self.keep_event(event);
        log_overflows || (self.events_overflowed && !before)
    }

    fn keep_event(&mut self, event: Occurrence) {
        let index = self.events.partition_point(|kept| kept.at <= event.at);
        self.events.insert(index, event);
        while let Some(oldest) = self.events.front().map(|event| event.at) {
            let newest = self.events.back().map_or(oldest, |event| event.at);
            if newest - oldest <= self.event_lookback {
                let burst = if self.most.burst > 1 { self.most.burst } else { 0 };
                if self.events.len() <= self.most.events.saturating_add(burst) {
                    return;
                }
                self.events_overflowed |= newest > oldest;
            }
            self.events.pop_front();
            self.events_forgotten_until = Some(self.events_forgotten_until.map_or(oldest, |before| before.max(oldest)));
        }
    }

    /// Records the number of further messages from outside at the same instant or a later one: all messages of one instant are kept.
    pub fn expect_events(&mut self, messages: usize, is_same_instant: bool) {
        let before = if is_same_instant { self.most.burst } else { 0 };
        self.most.burst = before.saturating_add(messages);
    }

    /// Returns the remembered messages with `start <= at`, in order of time and, within an instant, of arrival.
    pub fn events_from(&self, start: Time) -> impl Iterator<Item = &Occurrence> {
        let first = self.events.partition_point(|event| event.at < start);
        self.events.range(first..)
    }

    /// Returns true when every message at or after `instant` is still remembered.
    pub fn events_cover(&self, instant: Time) -> bool {
        self.events_forgotten_until.is_none_or(|forgotten| forgotten < instant)
    }

    /// Records that a clause may need messages up to `lookback` before the newest.
    pub fn require_event_lookback(&mut self, lookback: Duration) {
        self.event_lookback = self.event_lookback.max(lookback);
    }

    /// Records that a clause may need messages that begin with `head`, up to `lookback` before the newest of them.
    pub fn require_events_of(&mut self, head: &Symbol, lookback: Duration) {
        self.event_logs.require(head, lookback);
    }

    /// Returns the messages that begin with `head` with `start <= at <= end`, oldest first; `None` if they are no longer kept.
    pub fn events_of(&self, head: &Symbol, start: Time, end: Time) -> Option<Vec<&Occurrence>> {
        let of_it = |event: &&Occurrence| event.at <= end && event.head() == Some(head);
        if self.events_cover(start) {
            return Some(self.events_from(start).filter(of_it).collect());
        }
        let (kept, whole) = self.event_logs.of(head, start)?;
        whole.then(|| kept.filter(|event| event.at >= start).filter(of_it).collect())
    }

    /// Opens a policy of messages and returns the number that closes it. Messages that are still remembered count.
    pub fn open_event_log(&mut self, log: OpenEventLog) -> u64 {
        let number = self.next_log;
        self.next_log = self.next_log.saturating_add(1);
        let forgotten = self.events_forgotten_until;
        let remembered = self.events.iter().filter(|event| forgotten.is_none_or(|until| event.at > until));
        self.event_logs.open(number, log, remembered, forgotten, self.most.events);
        number
    }
}
