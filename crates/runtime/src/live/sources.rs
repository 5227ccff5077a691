//! All live sources of a run: readers add their inputs, the flight takes them by class and in turn.

use super::class::{RANKS, SourceClass};
use super::introduction::Introduction;
use super::queue::{LiveInput, Pushed, SourceQueue};
use super::rate_limit::RateLimit;
use crate::limits::{LIVE_REPORT_INTERVAL, LIVE_REST, LIVE_SOURCES_MAX, LIVE_TAKE_MAX};
use apex_model::event::EventKind;
use apex_model::value::Value;
use std::collections::{BTreeMap, VecDeque};
use std::fmt;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// First word of the events that record facts about a source.
const HEAD: &str = "live-source";

/// The live sources of one run. Clones share them.
#[derive(Clone)]
pub struct LiveSources(Arc<SharedSources>);

struct SharedSources {
    state: Mutex<SourcesState>,
    /// Notified when queues have space again, or the run is over.
    space: Condvar,
    /// Wakes a flight that waits because no input was ready.
    wake: Box<dyn Fn() + Send + Sync>,
    began: Instant,
}

struct SourcesState {
    sources: BTreeMap<u64, QueuedSource>,
    last_id: u64,
    ranks: [RateLimit; RANKS],
    /// Before this time, no input of vehicles and feeds is taken: later ones join the same step.
    rests_until: Duration,
    /// The source that had its turn last; the next turn begins after it.
    last_heard: u64,
    /// Events about sources that wait to be taken.
    reports: VecDeque<EventKind>,
    /// Time at which the flight looks for inputs at the latest; `None` if only when it is woken.
    looks_at: Option<Duration>,
    is_over: bool,
}

struct QueuedSource {
    class: SourceClass,
    /// Its name; `None` before it has introduced itself.
    name: Option<String>,
    queue: SourceQueue,
    limit: RateLimit,
    not_understood: u64,
    reported_at: Option<Duration>,
    is_gone: bool,
}

/// One source, for its reader. Dropping it ends the source; its waiting inputs are still taken.
pub struct LiveSource {
    sources: LiveSources,
    id: u64,
}

impl LiveSources {
    /// Returns a registry without sources; threads of readers call `wake` when the flight must look for inputs.
    pub fn new(wake: impl Fn() + Send + Sync + 'static) -> LiveSources {
        let rank = |class: SourceClass| RateLimit::new(class.rank_rate());
        let state = SourcesState {
            sources: BTreeMap::new(),
            last_id: 0,
            ranks: [rank(SourceClass::Operator), rank(SourceClass::Vehicle), rank(SourceClass::Feed)],
            rests_until: Duration::ZERO,
            last_heard: 0,
            reports: VecDeque::new(),
            looks_at: None,
            is_over: false,
        };
        let (state, space) = (Mutex::new(state), Condvar::new());
        LiveSources(Arc::new(SharedSources { state, space, wake: Box::new(wake), began: Instant::now() }))
    }

    /// Admits a source that has not introduced itself, with class `class`.
    ///
    /// # Errors
    /// The remedy as text, if there are too many sources.
    pub fn admit(&self, class: SourceClass) -> Result<LiveSource, String> {
        let mut state = self.state();
        let others = state.sources.values().filter(|source| !source.class.is_always_admitted()).count();
        if !class.is_always_admitted() && others >= LIVE_SOURCES_MAX {
            return Err(format!(
                "{LIVE_SOURCES_MAX} sources are connected, which is the limit; close one of them, or introduce an operator \
                 or a safing program in the first line"
            ));
        }
        state.last_id += 1;
        let id = state.last_id;
        let limit = RateLimit::new(class.source_rate());
        let queue = SourceQueue::default();
        let source =
            QueuedSource { class, name: None, queue, limit, not_understood: 0, reported_at: None, is_gone: false };
        state.sources.insert(id, source);
        Ok(LiveSource { sources: self.clone(), id })
    }

    /// Returns true if any input waits, whether its rate permits it or not.
    pub(crate) fn has_waiting(&self) -> bool {
        let state = self.state();
        !state.reports.is_empty() || state.sources.values().any(|source| !source.queue.is_empty())
    }

    /// Returns the time until an input may be taken; `None` if none waits.
    pub(crate) fn ready_in(&self) -> Option<Duration> {
        let now = self.0.began.elapsed();
        let mut state = self.state();
        let ready = state.ready_in(now);
        state.looks_at = ready.map(|span| now + span);
        ready
    }

    /// Takes the permitted inputs: all those of operators and safing within their limits, otherwise of vehicles, otherwise of feeds.
    /// Sources of one class take turns; at most [`LIVE_TAKE_MAX`] inputs are taken.
    pub(crate) fn take(&self) -> Vec<LiveInput> {
        let now = self.0.began.elapsed();
        let mut state = self.state();
        state.report(now);
        let mut taken: Vec<LiveInput> = state.reports.drain(..).map(|kind| LiveInput::Event(None, kind)).collect();
        for rank in 0..RANKS {
            let before = taken.len();
            state.take_rank(rank, now, &mut taken);
            if taken.len() > before {
                if rank > 0 {
                    state.rests_until = now + LIVE_REST;
                }
                break;
            }
        }
        state.bury();
        drop(state);
        self.0.space.notify_all();
        taken
    }

    /// Ends the wait of all readers: the run is over.
    pub(crate) fn close(&self) {
        self.state().is_over = true;
        self.0.space.notify_all();
    }

    fn state(&self) -> MutexGuard<'_, SourcesState> {
        // Every update is complete when the lock is released, even by a panic, so a poisoned lock is usable.
        self.0.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Wakes the flight if an input can be taken before the flight's next look.
    fn wake(&self, mut state: MutexGuard<'_, SourcesState>) {
        let now = self.0.began.elapsed();
        let soon = |at: &Duration| *at <= now;
        if state.looks_at.as_ref().is_some_and(soon) {
            return;
        }
        let Some(at) = state.ready_in(now).map(|span| now + span) else { return };
        if state.looks_at.is_some_and(|looks_at| looks_at <= at) {
            return;
        }
        state.looks_at = Some(now);
        drop(state);
        (self.0.wake)();
    }
}

impl SourcesState {
    fn ready_in(&mut self, now: Duration) -> Option<Duration> {
        if !self.reports.is_empty() {
            return Some(Duration::ZERO);
        }
        let SourcesState { sources, ranks, rests_until, .. } = self;
        let rest = rests_until.saturating_sub(now);
        ranks.iter_mut().for_each(|rank| _ = rank.available(now));
        let wait = |source: &mut QueuedSource| {
            if source.queue.is_empty() && source.is_gone {
                return Some(Duration::ZERO);
            }
            if source.queue.is_empty() {
                return source.has_news().then(|| source.report_in(now));
            }
            source.limit.available(now);
            let rank = ranks.get(source.class.rank()).map_or(Duration::ZERO, RateLimit::ready_in);
            let rest = if source.class.rank() > 0 { rest } else { Duration::ZERO };
            Some(source.limit.ready_in().max(rank).max(rest))
        };
        sources.values_mut().filter_map(wait).min()
    }

    /// Takes inputs from the sources of a rank, one from each in turn.
    fn take_rank(&mut self, rank: usize, now: Duration, taken: &mut Vec<LiveInput>) {
        let SourcesState { sources, ranks, last_heard, .. } = self;
        let Some(limit) = ranks.get_mut(rank).filter(|_| rank == 0 || self.rests_until <= now) else { return };
        let mut left = limit.available(now).min(LIVE_TAKE_MAX);
        let mut turn: VecDeque<(u64, usize)> = sources
            .iter_mut()
            .filter(|(_, source)| source.class.rank() == rank && !source.queue.is_empty())
            .map(|(id, source)| (*id, source.limit.available(now)))
            .collect();
        // The turn continues after the source that was served last.
        let first = turn.iter().position(|(id, _)| *id > *last_heard).unwrap_or(0);
        turn.rotate_left(first);
        while left > 0
            && let Some((id, may)) = turn.pop_front()
        {
            let Some(source) = sources.get_mut(&id).filter(|_| may > 0) else { continue };
            let Some(input) = source.queue.pop() else { continue };
            source.limit.spend(1);
            limit.spend(1);
            left -= 1;
            *last_heard = id;
            taken.extend(source.attribution(&input));
            taken.push(input);
            turn.push_back((id, may - 1));
        }
    }

    /// Adds the pending reports about sources: at most one a second for each.
    fn report(&mut self, now: Duration) {
        let SourcesState { sources, reports, .. } = self;
        for source in sources.values_mut() {
            if source.has_news() && (source.is_gone || source.report_in(now).is_zero()) {
                source.reported_at = Some(now);
                source.news(reports);
            }
        }
    }

    /// Removes introduced sources that have ended and whose inputs were all taken, and reports their end to the run.
    fn bury(&mut self) {
        let SourcesState { sources, reports, .. } = self;
        sources.retain(|_, source| {
            let stays = !source.is_gone || !source.queue.is_empty() || source.has_news();
            if !stays && let Some(name) = &source.name {
                reports.push_back(event([Value::symbol(name), Value::symbol("gone")]));
            }
            stays
        });
    }
}

impl QueuedSource {
    fn has_news(&self) -> bool {
        self.queue.has_lost() || self.not_understood > 0
    }

    /// Returns the time until a report about the source is permitted.
    fn report_in(&self, now: Duration) -> Duration {
        self.reported_at.map_or(Duration::ZERO, |at| (at + LIVE_REPORT_INTERVAL).saturating_sub(now))
    }

    fn printed_name(&self) -> &str {
        self.name.as_deref().unwrap_or("unnamed")
    }

    /// Adds events about inputs lost and lines not understood since the last report.
    fn news(&mut self, reports: &mut VecDeque<EventKind>) {
        let name = Value::symbol(self.printed_name());
        let lost = self.queue.take_lost();
        if lost.count > 0 {
            let variable = lost.variable.map_or_else(Value::nil, |variable| variable.form());
            reports.push_back(event([name.clone(), Value::symbol("lost"), count(lost.count), variable]));
        }
        let not_understood = std::mem::take(&mut self.not_understood);
        if not_understood > 0 {
            reports.push_back(event([name, Value::symbol("not-understood"), count(not_understood)]));
        }
    }

    /// Returns the event that names the author of an input other than telemetry, if the author has introduced itself.
    fn attribution(&self, input: &LiveInput) -> Option<LiveInput> {
        let name = self.name.as_deref()?;
        match input {
            LiveInput::Event(_, EventKind::Measurement(..)) => None,
            _ => Some(LiveInput::Event(None, event([Value::symbol(name), Value::symbol("says")]))),
        }
    }
}

fn event<const N: usize>(parts: [Value; N]) -> EventKind {
    EventKind::Occurrence(Value::list([Value::symbol(HEAD)].into_iter().chain(parts)))
}

fn count(number: u64) -> Value {
    Value::Integer(i64::try_from(number).unwrap_or(i64::MAX))
}

impl LiveSource {
    /// Adopts the name and the class that the source states, and reports them to the run. Stating the same again changes nothing.
    ///
    /// # Errors
    /// The source has stated another name or class before, or another source has the name.
    pub fn introduce(&self, introduction: &Introduction) -> Result<(), String> {
        let Introduction { name, class } = introduction;
        let mut state = self.sources.state();
        if let Some(QueuedSource { name: Some(known), class: stated, .. }) = state.sources.get(&self.id) {
            return match known.eq_ignore_ascii_case(name) && stated == class {
                true => Ok(()),
                false => Err(format!(
                    "this connection has introduced itself as {known} of class {}; open another connection for {name} of class {}",
                    stated.word(),
                    class.word()
                )),
            };
        }
        let same = |other: &QueuedSource| other.name.as_ref().is_some_and(|other| other.eq_ignore_ascii_case(name));
        if state.sources.iter().any(|(id, other)| *id != self.id && !other.is_gone && same(other)) {
            return Err(format!("another source is called {name}; choose another name, or close the other connection"));
        }
        if let Some(source) = state.sources.get_mut(&self.id) {
            (source.name, source.class) = (Some(name.clone()), *class);
            source.limit = RateLimit::new(class.source_rate());
        }
        let parts = [Value::symbol(name), Value::symbol("connected"), Value::symbol(class.word())];
        state.reports.push_back(event(parts));
        self.sources.wake(state);
        Ok(())
    }

    /// Adds inputs in their order; waits while the queue is full of inputs that must not be lost. Returns false once the run is over.
    pub fn say(&self, inputs: impl IntoIterator<Item = LiveInput>) -> bool {
        let mut state = self.sources.state();
        for input in inputs {
            let mut next = Some(input);
            while let Some(input) = next.take() {
                if state.is_over {
                    return false;
                }
                let Some(source) = state.sources.get_mut(&self.id) else { return false };
                if let Pushed::Refused(input) = source.queue.push(input) {
                    next = Some(input);
                    self.sources.wake(state);
                    let full = |state: &mut SourcesState| {
                        !state.is_over && state.sources.get(&self.id).is_some_and(|source| !source.queue.has_space())
                    };
                    let waited = self.sources.0.space.wait_while(self.sources.state(), full);
                    state = waited.unwrap_or_else(PoisonError::into_inner);
                }
            }
        }
        self.sources.wake(state);
        true
    }

    /// Counts unreadable lines, and reports the count to the run.
    pub fn not_understood(&self, lines: u64) {
        let mut state = self.sources.state();
        if let Some(source) = state.sources.get_mut(&self.id) {
            source.not_understood += lines;
        }
        self.sources.wake(state);
    }

    /// Returns the class that the source has stated; `None` before it has introduced itself.
    pub(super) fn stated_class(&self) -> Option<SourceClass> {
        let state = self.sources.state();
        state.sources.get(&self.id).filter(|source| source.name.is_some()).map(|source| source.class)
    }

    /// Returns the name under which the source is known.
    pub fn name(&self) -> Option<String> {
        self.sources.state().sources.get(&self.id)?.name.clone()
    }
}

impl Drop for LiveSource {
    fn drop(&mut self) {
        let mut state = self.sources.state();
        if let Some(source) = state.sources.get_mut(&self.id) {
            source.is_gone = true;
        }
        self.sources.wake(state);
    }
}

impl fmt::Debug for LiveSources {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("LiveSources").finish_non_exhaustive()
    }
}

#[cfg(test)]
#[path = "sources_tests.rs"]
mod tests;
