//! Clauses that became true, and tasks that nothing holds back: the notice and enable phases.

use crate::agent::Agent;
use crate::task::{Clause, Level, Origin, Outcome, State, Watch, Window};
use crate::value::Value;

impl Agent<'_> {
    pub(crate) fn notice_and_enable(&mut self) {
        // All clauses that became true are noticed before any of them takes effect.
        let noticed = self.noticed(|_| true);
        self.judge_invariants();
        self.fire_all(noticed);
        let ready = self.ids(|task| task.is_free());
        for id in ready {
            if self.tasks[id].is_free() && !self.tasks[id].forgotten {
                self.enable(id);
                self.settle();
            }
        }
        // A task whose suspension became true while it was pending does not begin.
        let at_once = self.noticed(|watch| watch.at_once);
        self.fire_all(at_once);
        for task in &mut self.tasks {
            task.watches.iter_mut().for_each(|watch| watch.at_once = false);
        }
    }

    fn fire_all(&mut self, noticed: Vec<(usize, Watch)>) {
        for (id, watch) in noticed {
            if !self.finished && self.tasks[id].watches.iter().any(|each| each.number == watch.number) {
                self.fire(id, &watch);
                self.settle();
            }
        }
    }

    fn fire(&mut self, id: usize, watch: &Watch) {
        let Some(proof) = self.proof(id, watch) else { return };
        self.changed = true;
        let answered = self.answered(&proof);
        // Evidence that one task has answered need not be answered by its ancestors.
        for above in self.line(id) {
            if let Some(missed) = &mut self.tasks[above].missed {
                missed.retain(|arrival| !proof.messages().any(|message| message == *arrival));
            }
        }
        if watch.clause == Clause::Waitfor && self.is_known(id, &proof.bound) {
            return self.wait_for_new(id, answered);
        }
        self.tasks[id].answered = self.tasks[id].answered.max(answered);
        self.unwatch(id, |clause, level| clause == watch.clause && level == watch.level);
        let cause = format!("clause {}", watch.clause.word());
        // A watch that begins now counts evidence from the end of this proof on, or from the beginning of the window of the fired watch if
        // that is later.
        let end = proof.end(self.now).max(watch.window.start);
        let newest = self.arrivals.checked_sub(1).filter(|_| end >= self.now);
        let after = Window { start: end.min(self.now), after: answered.or(newest) };
        match watch.clause {
            Clause::Waitfor => {
                self.keep_missed(id, &proof);
                self.tasks[id].bound.extend(proof.bound);
                self.tasks[id].waits_for_condition = false;
            }
            Clause::EndWhen => {
                if watch.level == Level::Step {
                    self.tasks[id].repeats_no_more = true;
                }
                self.end(id, Outcome::Success(Value::Nil), cause);
            }
            Clause::SkipWhen => {
                if matches!(self.tasks[id].state, State::Pending | State::Enabled) {
                    self.end(id, Outcome::Skipped, cause);
                }
            }
            Clause::ExitWhen => {
                let begun = matches!(self.tasks[id].state, State::Ongoing | State::Interrupted);
                self.end(id, if begun { Outcome::Exited } else { Outcome::Skipped }, cause);
            }
            Clause::RestartWhen => self.restart(id, cause),
            Clause::SuspendWhen => {
                // The consequences of the suspension itself can end it.
                self.watch_resumption(id, watch.level, after);
                self.suspend(id, cause);
            }
            Clause::SuspendUntil | Clause::ResumeWhen => {
                self.resume(id, cause);
                self.watch_suspension_anew(id, after);
            }
        }
    }

    fn enable(&mut self, id: usize) {
        self.transition(id, State::Enabled, None, "nothing holds it back".into());
        self.respond(id);
        // A handler sees the variables selected for the step that it handles.
        let handles = matches!(self.tasks[id].origin, Origin::Handler(..));
        let step = self.step_of(id).filter(|_| !handles);
        for (name, expr) in step.map(|step| step.select.as_slice()).unwrap_or_default() {
            match self.evaluate(expr, id, Level::Step) {
                Ok(value) => self.tasks[id].bound.insert(name.clone(), value),
                Err(_) => return self.fail(id, "an expression".into()),
            };
        }
        self.watch_step_suspension(id);
    }
}
