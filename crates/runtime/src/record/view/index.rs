//! The states of all tasks over time, kept in memory and extended with the record.
//!
//! Bound: each effect is read once; memory is one small entry per state change.

use super::goals::IndexedGoal;
use super::state::StateWord;
use crate::error::RecordError;
use crate::method_detail::MethodDetail;
use crate::record::{EffectKind, EffectNeed, Effects, Item, RecordReader};
use apex_model::effect::{Decision, DecisionKind, Effect};
use apex_model::task::{OUTCOME_WORDS, TaskState};
use apex_model::value::Value;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Word of the decision that selects a method.
const SELECTED: &str = "selected";

/// A task with the instants at which its properties became known, oldest first. Parent, tag and place are those of its creation.
#[derive(Clone, Debug, Default)]
pub(super) struct IndexedTask {
    pub(super) parent: Option<u64>,
    pub(super) tag: String,
    pub(super) place: Option<String>,
    pub(super) created_ns: i64,
    /// The instants of its changes. They are apart from the rest, because drawings search in them: four times as many fit a cache line.
    changed_ns: Vec<i64>,
    /// Its changes, without their instants.
    changes: Vec<IndexedChange>,
    /// Nanoseconds for which it was active before each change: enabled, ongoing or interrupted.
    active_before_ns: Vec<i64>,
    /// For each block of [`BLOCK_CHANGES`] changes, the longest interval to draw that begins in it, nanoseconds. The last interval, which
    /// is open, does not count.
    longest_ns: Vec<i64>,
    /// The instant of the first change of each block.
    block_ns: Vec<i64>,
    /// Its goal: as created, then with the bindings of each selection that changed it.
    goals: Vec<(i64, IndexedGoal)>,
    /// The method of each selection; none from a new start of the step until it is selected again.
    methods: Vec<(i64, Option<Arc<MethodDetail>>)>,
}

/// Number of changes of a task in one block of [`IndexedTask::longest_ns`].
pub(super) const BLOCK_CHANGES: usize = 16;

/// Sums over a task's intervals up to a change.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct IntervalSums {
    /// Nanoseconds for which the task was ongoing.
    pub(super) ongoing_ns: i64,
    /// Number of intervals to draw.
    pub(super) drawn: u32,
}

/// A change of a task's state with the sums over the intervals that end by it.
#[derive(Clone, Copy, Debug)]
struct IndexedChange {
    ongoing_ns: i64,
    drawn: u32,
    state: StateWord,
    outcome: OutcomeCode,
}

/// From `at_ns` on the task is in `state`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Change {
    pub(super) at_ns: i64,
    pub(super) state: StateWord,
    /// Outcome, if it has ended. A task of a repeating step leaves the ended state again.
    pub(super) outcome: OutcomeCode,
}

/// The outcome of a task in one byte: changes are many, and their size decides how fast they are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct OutcomeCode(u8);

impl OutcomeCode {
    /// Returns the code of an outcome; `None` has a code too.
    pub(super) fn of(word: Option<&str>) -> OutcomeCode {
        let place = OUTCOME_WORDS.iter().position(|outcome| Some(*outcome) == word);
        OutcomeCode(place.map_or(0, |place| place as u8 + 1))
    }

    /// Returns a word of [`OUTCOME_WORDS`]; `None` for a task that has not ended.
    pub(super) fn word(self) -> Option<&'static str> {
        usize::from(self.0).checked_sub(1).and_then(|place| OUTCOME_WORDS.get(place)).copied()
    }
}

/// All tasks by number.
#[derive(Default)]
pub(super) struct TaskIndex {
    /// Number of the last effect that was read or skipped.
    read_to: i64,
    tasks: BTreeMap<u64, IndexedTask>,
    /// By task: the signature of its last selection. A step that repeats is mostly selected as before, and is not decoded again.
    selected: BTreeMap<u64, Vec<u8>>,
}

/// A span of time in one state; the last one of a task that has not ended is open.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Interval {
    pub(super) state: StateWord,
    pub(super) from_ns: i64,
    pub(super) to_ns: i64,
}

impl TaskIndex {
    /// Returns all tasks by number.
    pub(super) fn tasks(&self) -> &BTreeMap<u64, IndexedTask> {
        &self.tasks
    }

    /// Returns one task.
    pub(super) fn get(&self, id: u64) -> Option<&IndexedTask> {
        self.tasks.get(&id)
    }

    /// Returns the number of the last effect that was read or skipped.
    pub(super) fn read_to(&self) -> i64 {
        self.read_to
    }

    /// Reads the effects that were written since the last call, up to effect `last`.
    pub(super) fn refresh(&mut self, reader: &RecordReader, last: i64) -> Result<(), RecordError> {
        let effects = reader.effects()?;
        let places = effects.table.place_after(self.read_to)..effects.table.place_after(last);
        let TaskIndex { tasks, selected, .. } = self;
        let mut signature = Vec::new();
        let wanted = |kind: &EffectKind, task: Option<u64>, item: &Item<'_>| {
            let need = kind.wanted_of_tasks();
            let Some(task) = task.filter(|_| need == EffectNeed::Effect) else { return need };
            if kind.word != SELECTED || !item.signature(&mut signature) {
                selected.remove(&task);
                return need;
            }
            let known = selected.entry(task).or_default();
            if *known == signature {
                return EffectNeed::Kind;
            }
            known.clone_from(&signature);
            need
        };
        effects.scan_items(places, wanted, |found| {
            let Some(id) = found.task else { return Ok(()) };
            let at_ns = found.at.0;
            let task = tasks.entry(id).or_default();
            match found.effect {
                None if found.kind.word == SELECTED => task.select_again(at_ns),
                None => {
                    let state = StateWord(found.kind.to.unwrap_or(TaskState::Pending));
                    task.change(Change { at_ns, state, outcome: OutcomeCode::of(found.kind.outcome) });
                }
                Some(Effect::Decided(decision)) => task.decide(at_ns, &decision, &effects),
                Some(_) => {}
            }
            Ok(())
        })?;
        self.read_to = self.read_to.max(last);
        Ok(())
    }
}

/// Returns the last entry that is not later than `at_ns`.
fn last_known<T>(known: &[(i64, T)], at_ns: i64) -> Option<&T> {
    let later = known.partition_point(|(since_ns, _)| *since_ns <= at_ns);
    later.checked_sub(1).and_then(|last| known.get(last)).map(|(_, value)| value)
}

impl IndexedTask {
    /// Takes its creation or a selection.
    fn decide(&mut self, at_ns: i64, decision: &Decision, effects: &Effects<'_>) {
        match &decision.kind {
            DecisionKind::Created { parent, tag, goal, .. } => {
                self.parent = parent.map(|parent| parent.0);
                self.tag = tag.to_string();
                self.place = effects.place(decision);
                self.created_ns = at_ns;
                self.push(Change { at_ns, state: StateWord(TaskState::Pending), outcome: OutcomeCode::default() });
                self.set_goal(at_ns, goal);
            }
            DecisionKind::Selected { method, goal, .. } => {
                self.set_goal(at_ns, goal);
                self.methods.push((at_ns, Some(Arc::new(effects.method(method)))));
            }
            _ => {}
        }
    }

    /// Takes a selection that is equal to the last one.
    fn select_again(&mut self, at_ns: i64) {
        let method = self.methods.iter().rev().find_map(|(_, method)| method.clone());
        self.methods.push((at_ns, method));
    }

    fn set_goal(&mut self, at_ns: i64, goal: &Value) {
        let goal = IndexedGoal::of(goal);
        if self.goals.last().is_none_or(|(_, known)| known.text != goal.text) {
            self.goals.push((at_ns, goal));
        }
    }

    fn change(&mut self, change: Change) {
        // A step that starts again forgets how its last instance was pursued.
        if change.state.0 == TaskState::Pending && self.methods.last().is_some_and(|(_, method)| method.is_some()) {
            self.methods.push((change.at_ns, None));
        }
        self.push(change);
    }

    /// Adds a change. Changes come in the order of time, so the last one was in force until the new one.
    fn push(&mut self, change: Change) {
        let Change { at_ns, state, outcome } = change;
        let last = self.changes.len().saturating_sub(1);
        let before = self.active_since(last, at_ns);
        self.active_before_ns.push(before);
        let IntervalSums { ongoing_ns, drawn } = self.sums_until(at_ns);
        if self.changes.len().is_multiple_of(BLOCK_CHANGES) {
            self.longest_ns.push(0);
            self.block_ns.push(at_ns);
        }
        self.changed_ns.push(at_ns);
        self.changes.push(IndexedChange { ongoing_ns, drawn, state, outcome });
    }

    /// Returns the sums up to the next change, at `at_ns`, and takes the length of the interval that it ends.
    fn sums_until(&mut self, at_ns: i64) -> IntervalSums {
        let Some(place) = self.changes.len().checked_sub(1) else { return IntervalSums::default() };
        let Some(change) = self.change_at(place) else { return IntervalSums::default() };
        let sums = self.sums_before(place);
        let last = Interval { state: change.state, from_ns: change.at_ns, to_ns: at_ns };
        if !change.state.is_alive() || !last.is_drawn() {
            return sums;
        }
        if let Some(longest_ns) = self.longest_ns.get_mut(place / BLOCK_CHANGES) {
            *longest_ns = last.length_ns().max(*longest_ns);
        }
        let ongoing_ns = if change.state.0 == TaskState::Ongoing { last.length_ns() } else { 0 };
        IntervalSums { ongoing_ns: sums.ongoing_ns + ongoing_ns, drawn: sums.drawn.saturating_add(1) }
    }

    /// Returns the sums over the intervals that begin before the change at place `end`; the change must not be later than the last one.
    pub(super) fn sums_before(&self, end: usize) -> IntervalSums {
        let change = self.changes.get(end);
        change.map_or_else(IntervalSums::default, |&IndexedChange { ongoing_ns, drawn, .. }| IntervalSums {
            ongoing_ns,
            drawn,
        })
    }

    /// Returns the instants of all changes, oldest first.
    pub(super) fn changed_ns(&self) -> &[i64] {
        &self.changed_ns
    }

    /// Returns the change at a place.
    pub(super) fn change_at(&self, place: usize) -> Option<Change> {
        let (at_ns, change) = (*self.changed_ns.get(place)?, self.changes.get(place)?);
        Some(Change { at_ns, state: change.state, outcome: change.outcome })
    }

    /// Returns the state from the change at a place on.
    pub(super) fn state_from(&self, place: usize) -> Option<StateWord> {
        self.changes.get(place).map(|change| change.state)
    }

    /// Returns the longest interval to draw that begins in the block of a change, nanoseconds; the open one does not count.
    pub(super) fn longest_ns(&self, place: usize) -> i64 {
        self.longest_ns.get(place / BLOCK_CHANGES).copied().unwrap_or(i64::MAX)
    }

    /// Returns the instant of the first change of each block of [`BLOCK_CHANGES`] changes.
    pub(super) fn block_ns(&self) -> &[i64] {
        &self.block_ns
    }

    /// Returns the nanoseconds for which it was active up to `at_ns`.
    fn active_until(&self, at_ns: i64) -> i64 {
        let Some(last) = self.changed_ns.partition_point(|since_ns| *since_ns <= at_ns).checked_sub(1) else {
            return 0;
        };
        self.active_since(last, at_ns)
    }

    /// Returns the nanoseconds that it was active up to `at_ns`, before which the change at place `last` is the last one.
    fn active_since(&self, last: usize, at_ns: i64) -> i64 {
        let (Some(change), Some(before)) = (self.change_at(last), self.active_before_ns.get(last)) else { return 0 };
        let is_active = change.state.is_alive() && change.state.0 != TaskState::Pending;
        if is_active { before + at_ns.saturating_sub(change.at_ns) } else { *before }
    }

    /// Returns the nanoseconds within `from_ns..=to_ns` in which it was active.
    pub(super) fn active_ns(&self, from_ns: i64, to_ns: i64) -> i64 {
        (self.active_until(to_ns) - self.active_until(from_ns)).max(0)
    }

    /// Returns its goal as known at `at_ns`; empty before its creation.
    pub(super) fn goal_at(&self, at_ns: i64) -> &str {
        self.known_goal(at_ns).map_or("", |goal| &goal.text)
    }

    /// Returns its goal as known at `at_ns`; `None` before its creation.
    pub(super) fn known_goal(&self, at_ns: i64) -> Option<&IndexedGoal> {
        last_known(&self.goals, at_ns)
    }

    /// Returns the method selected by `at_ns`.
    pub(super) fn method_at(&self, at_ns: i64) -> Option<&MethodDetail> {
        last_known(&self.methods, at_ns)?.as_deref()
    }

    /// Returns the state at `at_ns`, with the time it began; `None` before the task was created.
    pub(super) fn state_at(&self, at_ns: i64) -> Option<Change> {
        let later = self.changed_ns.partition_point(|since_ns| *since_ns <= at_ns);
        later.checked_sub(1).and_then(|last| self.change_at(last))
    }

    /// Returns the stretches in each state but the last (ended), cut to `from_ns..=to_ns`.
    pub(super) fn intervals(&self, from_ns: i64, to_ns: i64) -> impl Iterator<Item = Interval> + '_ {
        // The state before the window may end exactly at its beginning.
        let first = self.changed_ns.partition_point(|at_ns| *at_ns < from_ns).saturating_sub(1);
        let later = self.changed_ns.partition_point(|at_ns| *at_ns <= to_ns);
        let inside = self.changes.get(first..later).unwrap_or_default();
        let starts = self.changed_ns.get(first..later).unwrap_or_default();
        let ends = self.changed_ns.iter().skip(first + 1).copied().chain(std::iter::once(i64::MAX));
        inside.iter().zip(starts).zip(ends).filter_map(move |((change, start), end)| {
            let interval = Interval { state: change.state, from_ns: (*start).max(from_ns), to_ns: end.min(to_ns) };
            (change.state.is_alive() && interval.from_ns <= interval.to_ns).then_some(interval)
        })
    }

    /// Returns the begin of the first interval to draw and the end of the last one; `None` without any.
    pub(super) fn drawn_span(&self, from_ns: i64, to_ns: i64) -> Option<(i64, i64)> {
        let first = self.drawn(from_ns, to_ns).next()?;
        let mut until = self.changed_ns.partition_point(|at_ns| *at_ns <= to_ns);
        let mut end_ns = self.changed_ns.get(until).map_or(to_ns, |next_ns| to_ns.min(*next_ns));
        // Backwards to the last interval that is drawn.
        while let Some(change) = until.checked_sub(1).and_then(|last| self.change_at(last)) {
            let last = Interval { state: change.state, from_ns: change.at_ns.max(from_ns), to_ns: end_ns };
            if change.state.is_alive() && last.is_drawn() {
                break;
            }
            (until, end_ns) = (until - 1, change.at_ns);
        }
        Some((first.from_ns, end_ns))
    }

    /// Returns the intervals to draw: waiting of zero length is left out, work of zero length is drawn.
    pub(super) fn drawn(&self, from_ns: i64, to_ns: i64) -> impl Iterator<Item = Interval> + '_ {
        self.intervals(from_ns, to_ns).filter(Interval::is_drawn)
    }
}

impl Interval {
    /// Returns true if it is drawn.
    pub(super) fn is_drawn(&self) -> bool {
        self.length_ns() > 0 || self.state.0 == TaskState::Ongoing
    }

    /// Returns its length in nanoseconds.
    pub(super) fn length_ns(self) -> i64 {
        self.to_ns.saturating_sub(self.from_ns)
    }
}

#[cfg(test)]
impl TaskIndex {
    /// Adds a task with these changes of its state.
    pub(super) fn insert(&mut self, id: u64, parent: Option<u64>, tag: &str, changes: &[(i64, TaskState)]) {
        let mut task = IndexedTask {
            parent,
            tag: tag.into(),
            created_ns: changes.first().map_or(0, |(at_ns, _)| *at_ns),
            ..IndexedTask::default()
        };
        for &(at_ns, state) in changes {
            task.change(Change { at_ns, state: StateWord(state), outcome: OutcomeCode::default() });
        }
        self.tasks.insert(id, task);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn task(changes: &[(i64, TaskState)]) -> IndexedTask {
        let mut task = IndexedTask::default();
        for &(at_ns, state) in changes {
            task.push(Change { at_ns, state: StateWord(state), outcome: OutcomeCode::default() });
        }
        task
    }

    #[test]
    fn outcomes_come_back_from_their_codes() {
        for word in OUTCOME_WORDS.map(Some).into_iter().chain([None]) {
            assert_eq!(OutcomeCode::of(word).word(), word);
        }
        assert_eq!(std::mem::size_of::<IndexedChange>(), 16);
    }

    #[test]
    fn the_last_change_of_an_instant_counts() {
        let task = task(&[(5, TaskState::Pending), (5, TaskState::Enabled), (9, TaskState::Ongoing)]);
        assert!(task.state_at(4).is_none());
        assert_eq!(task.state_at(5).unwrap().state, StateWord(TaskState::Enabled));
        assert_eq!(task.state_at(8).unwrap().state, StateWord(TaskState::Enabled));
        assert_eq!(task.state_at(9).unwrap().state, StateWord(TaskState::Ongoing));
    }

    #[test]
    fn intervals_are_cut_to_the_window_and_leave_the_ended_state_out() {
        let task = task(&[(0, TaskState::Pending), (10, TaskState::Ongoing), (30, TaskState::Terminated)]);
        let seen: Vec<Interval> = task.intervals(5, 20).collect();
        assert_eq!(
            seen,
            [
                Interval { state: StateWord(TaskState::Pending), from_ns: 5, to_ns: 10 },
                Interval { state: StateWord(TaskState::Ongoing), from_ns: 10, to_ns: 20 },
            ]
        );
    }
}
