//! `repeating` and `responding`.

use crate::agent::Agent;
use crate::evidence::Proof;
use crate::program::Condition;
use crate::task::{Clause, Level, Origin, Outcome, State, Window};
use crate::value::{Bindings, Value};

impl Agent<'_> {
    /// Returns true if `:while` and `:until` allow another instance.
    fn is_allowed(&self, id: usize) -> bool {
        let Some(clause) = self.step_of(id).and_then(|step| step.repetition.as_ref()) else { return false };
        let says = |expr| self.evaluate(expr, id, Level::Step).map(|value| value.is_true());
        let goes_on = clause.while_true.as_ref().map_or(Ok(true), says);
        let is_over = clause.until.as_ref().map_or(Ok(false), says);
        matches!((goes_on, is_over), (Ok(true), Ok(false)))
    }

    /// Makes the ended task pending again when its step repeats.
    pub(crate) fn repeat(&mut self, id: usize) -> bool {
        let Some(clause) = self.own_step(id).and_then(|step| step.repetition.as_ref()) else { return false };
        let succeeded = matches!(self.tasks[id].outcome, Some(Outcome::Success(_)));
        if clause.responding || self.tasks[id].repeats_no_more || !succeeded || !self.is_allowed(id) {
            return false;
        }
        let started = self.tasks[id].started_at;
        self.transition(id, State::Pending, None, "repetition".into());
        let now = self.now;
        let serial = self.next_serial();
        let task = &mut self.tasks[id];
        task.created_at = now;
        task.first_created = now;
        task.started_at = None;
        task.waits_for_result = false;
        task.waits_for_condition = false;
        task.ended_before = Some(now);
        if !clause.enabled {
            task.bound = Bindings::new();
        }
        let next = clause.minimum_interval.zip(started).map(|(interval, started)| started + interval);
        task.waits_for_interval = next.filter(|at| *at > now).map(|at| (at, serial));
        if !clause.enabled {
            self.arm(id);
        }
        true
    }

    /// Keeps the messages that the repeated step, which is busy from now on, has not answered for its next repetitions.
    pub(crate) fn keep_missed(&mut self, id: usize, proof: &Proof) {
        let Some(step) = self.own_step(id) else { return };
        let repeats = step.repetition.as_ref().is_some_and(|clause| !clause.responding && !clause.drop_missed);
        if !repeats || !step.waitfor.iter().any(hears) {
            return;
        }
        let when = |arrival: u64| {
            let message = self.messages.iter().find(|message| message.arrival == arrival);
            (message.map_or(self.now, |message| message.at), arrival)
        };
        let newest = proof.messages().map(when).max();
        let after = self.tasks[id].answered;
        let mut missed = self.tasks[id].missed.take().unwrap_or_default();
        missed.retain(|arrival| newest.is_none_or(|newest| when(*arrival) > newest));
        let of_now = self.messages.iter().filter(|message| message.at >= self.now);
        let unanswered =
            of_now.map(|message| message.arrival).filter(|arrival| after.is_none_or(|after| *arrival > after));
        missed.extend(unanswered);
        self.tasks[id].missed = Some(missed);
    }

    /// Creates a new instance of a responding step, which waits next to the task that was enabled.
    pub(crate) fn respond(&mut self, id: usize) {
        let Origin::Step(procedure, step) = self.tasks[id].origin else { return };
        let Some(parent) = self.tasks[id].parent else { return };
        if !self.step_of(id).and_then(|step| step.repetition.as_ref()).is_some_and(|clause| clause.responding) {
            return;
        }
        self.adopt(parent, id, Some(step));
        if !self.is_allowed(id) {
            return;
        }
        let fresh = self.create(Some(parent), Origin::Step(procedure, step));
        self.tasks[fresh].answered = self.tasks[id].answered;
        self.tasks[fresh].known = std::mem::take(&mut self.tasks[id].known);
        self.adopt(parent, fresh, None);
        self.arm(fresh);
    }

    /// Returns whether this combination of `:for-new` variables was answered before, and marks it as answered.
    pub(crate) fn is_known(&mut self, id: usize, bound: &Bindings) -> bool {
        let Some(clause) = self.own_step(id).and_then(|step| step.repetition.as_ref()) else { return false };
        if clause.for_new.is_empty() {
            return false;
        }
        let values = clause.for_new.iter().map(|name| bound.get(name).cloned().unwrap_or(Value::Nil));
        let combination = crate::value::phrase(&values.collect::<Vec<_>>());
        !self.tasks[id].known.insert(combination)
    }

    pub(crate) fn wait_for_new(&mut self, id: usize, answered: Option<u64>) {
        self.tasks[id].answered = self.tasks[id].answered.max(answered);
        self.unwatch(id, |clause, _| clause == Clause::Waitfor);
        self.watch_waitfor(id);
        let window = Window { start: self.now, after: self.tasks[id].answered };
        if let Some(watch) = self.tasks[id].watches.iter_mut().find(|watch| watch.clause == Clause::Waitfor) {
            watch.window = window;
        }
    }
}

/// Returns true if the condition contains a message.
fn hears(condition: &Condition) -> bool {
    match condition {
        Condition::Event(_) => true,
        Condition::And(parts) | Condition::Or(parts) | Condition::InOrder(parts) => parts.iter().any(hears),
        _ => false,
    }
}
