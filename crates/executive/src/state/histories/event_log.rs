//! Messages that are remembered by their first word, as far back as queries and log policies require, beyond the needs of conditions
//! (paper, section IV, policies on logged data quantity).

use crate::state::histories::history::Occurrence;
use apex_model::symbol::Symbol;
use apex_model::time::{Duration, Time};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, VecDeque};

/// Limits of one open `(log (:events HEAD) ..)` policy.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OpenEventLog {
    /// The first word of the messages.
    pub head: Symbol,
    /// Minimum time between kept messages; zero keeps all.
    pub spacing: Duration,
    /// Maximum age of kept messages.
    pub time: Duration,
    /// Maximum number of kept messages.
    pub count: u64,
}

/// Messages with one first word, in order of time.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Log {
    kept: VecDeque<Occurrence>,
    /// The newest instant of a message that is kept no longer.
    forgotten_until: Option<Time>,
    /// True if messages that a query or a policy requires were dropped at the limit.
    overflowed: bool,
}

/// Demand of all open policies and queries for one first word: the least restrictive one counts.
#[derive(Clone, Copy, Debug, Default)]
struct EventDemand {
    lookback: Option<Duration>,
    time: Duration,
    count: u64,
    spacing: Duration,
    logged: bool,
}

/// The logs of messages.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct EventLogs {
    asked: BTreeMap<Symbol, Duration>,
    open: BTreeMap<u64, OpenEventLog>,
    logs: BTreeMap<Symbol, Log>,
}

impl EventLogs {
    /// Records that a clause may need messages that begin with `head`, up to `lookback` before the newest of them.
    pub(crate) fn require(&mut self, head: &Symbol, lookback: Duration) {
        let slot = self.asked.entry(head.clone()).or_default();
        *slot = (*slot).max(lookback);
        self.logs.entry(head.clone()).or_default();
    }

    /// Opens a policy. `remembered` are messages that are known already, in order of time, all after `forgotten_until`.
    pub(crate) fn open<'a>(
        &mut self,
        number: u64,
        policy: OpenEventLog,
        remembered: impl Iterator<Item = &'a Occurrence>,
        forgotten_until: Option<Time>,
        most: usize,
    ) {
        let head = policy.head.clone();
        self.open.insert(number, policy);
        if self.logs.contains_key(&head) {
            return;
        }
        self.logs.insert(head, Log { forgotten_until, ..Log::default() });
        for event in remembered {
            self.record(event, most);
        }
    }

    /// Closes a policy, if it is one of messages. Messages that only it kept are dropped.
    pub(crate) fn close(&mut self, number: u64) {
        let Some(policy) = self.open.remove(&number) else { return };
        let wanted = self.asked.contains_key(&policy.head) || self.open.values().any(|open| open.head == policy.head);
        if !wanted {
            self.logs.remove(&policy.head);
        }
    }

    /// Records a message if a clause needs it; at most `most` of one first word are kept. Returns true if a required message was dropped
    /// for the first time.
    pub(crate) fn record(&mut self, event: &Occurrence, most: usize) -> bool {
        let Some(head) = event.head().filter(|head| self.logs.contains_key(*head)) else { return false };
        let wanted = self.wanted(head);
        let Some(log) = self.logs.get_mut(head) else { return false };
        let before = log.overflowed;
        log.insert(event, wanted);
        log.trim(wanted, most);
        log.overflowed && !before
    }

    fn wanted(&self, head: &Symbol) -> EventDemand {
        let mut wanted = EventDemand { lookback: self.asked.get(head).copied(), ..EventDemand::default() };
        for policy in self.open.values().filter(|policy| policy.head == *head) {
            wanted.spacing = if wanted.logged { wanted.spacing.min(policy.spacing) } else { policy.spacing };
            wanted.time = wanted.time.max(policy.time);
            wanted.count = wanted.count.max(policy.count);
            wanted.logged = true;
        }
        wanted
    }

    /// Returns the messages that begin with `head`, oldest first, and true if all of them since `start` are there; `None` if no clause
    /// required them.
    pub(crate) fn of<'a>(
        &'a self,
        head: &Symbol,
        start: Time,
    ) -> Option<(impl Iterator<Item = &'a Occurrence> + use<'a>, bool)> {
        let log = self.logs.get(head)?;
        Some((log.kept.iter(), log.forgotten_until.is_none_or(|forgotten| forgotten < start)))
    }
}

impl Log {
    fn insert(&mut self, event: &Occurrence, wanted: EventDemand) {
        let index = self.kept.partition_point(|kept| kept.at <= event.at);
        let close = |other: Option<&Occurrence>| {
            other.is_some_and(|other| (other.at - event.at).0.saturating_abs() < wanted.spacing.0)
        };
        let neighbours = [index.checked_sub(1).and_then(|before| self.kept.get(before)), self.kept.get(index)];
        // Not counted as dropped: where only logs need them, a log of this density was requested.
        if wanted.lookback.is_none() && neighbours.into_iter().any(close) {
            return;
        }
        self.kept.insert(index, event.clone());
    }

    fn trim(&mut self, wanted: EventDemand, most: usize) {
        let Some(newest) = self.kept.back().map(|newest| newest.at) else { return };
        let count = usize::try_from(wanted.count).unwrap_or(usize::MAX);
        while let Some(oldest) = self.kept.front().map(|oldest| oldest.at) {
            let asked = wanted.lookback.is_some_and(|lookback| newest - oldest <= lookback);
            let logged = wanted.logged && self.kept.len() <= count && newest - oldest <= wanted.time;
            if asked || logged {
                if self.kept.len() <= most {
                    return;
                }
                self.overflowed = true;
            }
            self.kept.pop_front();
            self.forgotten_until = self.forgotten_until.max(Some(oldest));
        }
    }
}

#[cfg(test)]
#[allow(clippy::indexing_slicing, reason = "a test stops at an unexpected result")]
mod tests {
    use super::*;
    use apex_model::value::Value;

    fn event(head: &str, at: i64) -> Occurrence {
        let form = Value::list([Value::symbol(head), Value::Integer(at)]);
        Occurrence { at: Time(at), sequence: at.unsigned_abs(), form }
    }

    fn policy(spacing: i64, time: i64, count: u64) -> OpenEventLog {
        OpenEventLog { head: Symbol::new("seen"), spacing: Duration(spacing), time: Duration(time), count }
    }

    /// Returns the messages at `instants` that a log with `policies` keeps, and the instant up to which it is incomplete.
    fn kept(policies: &[OpenEventLog], instants: &[i64]) -> (Vec<i64>, Option<Time>) {
        let mut logs = EventLogs::default();
        for (number, policy) in (0..).zip(policies) {
            logs.open(number, policy.clone(), std::iter::empty(), None, 100);
        }
        for at in instants {
            logs.record(&event("seen", *at), 100);
            logs.record(&event("other", *at), 100);
        }
        let log = &logs.logs[&Symbol::new("seen")];
        (log.kept.iter().map(|event| event.at.0).collect(), log.forgotten_until)
    }

    const ALL: i64 = i64::MAX;

    #[test]
    fn each_limit_drops_what_it_says_and_the_least_restrictive_counts() {
        let instants = [1, 2, 3, 6, 7, 12];
        assert_eq!(kept(&[policy(0, ALL, u64::MAX)], &instants), (instants.to_vec(), None));
        assert_eq!(kept(&[policy(0, 6, u64::MAX)], &instants), (vec![6, 7, 12], Some(Time(3))));
        assert_eq!(kept(&[policy(0, ALL, 2)], &instants), (vec![7, 12], Some(Time(6))));
        // Messages left out by thinning were not requested.
        assert_eq!(kept(&[policy(3, ALL, u64::MAX)], &instants), (vec![1, 6, 12], None));
        assert_eq!(kept(&[policy(3, 6, 2), policy(0, 5, 1)], &instants), (vec![7, 12], Some(Time(6))));
    }

    #[test]
    fn late_messages_come_in_order_and_no_denser_than_asked() {
        assert_eq!(kept(&[policy(0, ALL, u64::MAX)], &[5, 9, 7]).0, [5, 7, 9]);
        assert_eq!(kept(&[policy(3, ALL, u64::MAX)], &[5, 9, 7, 12]).0, [5, 9, 12]);
    }

    #[test]
    fn what_a_query_asks_for_is_kept_whatever_policies_say() {
        let mut logs = EventLogs::default();
        logs.require(&Symbol::new("seen"), Duration(6));
        logs.open(1, policy(5, ALL, 1), std::iter::empty(), None, 100);
        for at in [1, 2, 3, 6, 7] {
            logs.record(&event("seen", at), 100);
        }
        logs.close(1);
        let (kept, whole) = logs.of(&Symbol::new("seen"), Time(1)).unwrap();
        assert_eq!((kept.count(), whole), (5, true));
        logs.record(&event("seen", 12), 100);
        let (kept, whole) = logs.of(&Symbol::new("seen"), Time(6)).unwrap();
        assert_eq!((kept.map(|event| event.at.0).collect::<Vec<_>>(), whole), (vec![6, 7, 12], true));
        assert!(!logs.of(&Symbol::new("seen"), Time(3)).unwrap().1);
    }

    #[test]
    fn more_than_the_limit_is_reported_once() {
        let mut logs = EventLogs::default();
        logs.open(1, policy(0, ALL, u64::MAX), std::iter::empty(), None, 3);
        let told: Vec<bool> = (0..6).map(|at| logs.record(&event("seen", at), 3)).collect();
        assert_eq!(told, [false, false, false, true, false, false]);
        assert!(!logs.of(&Symbol::new("seen"), Time(1)).unwrap().1);
        logs.close(1);
        assert!(logs.of(&Symbol::new("seen"), Time(1)).is_none());
    }
}
