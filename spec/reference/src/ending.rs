//! The end of tasks, and the reaction of their parents.

use crate::agent::Agent;
use crate::program::{Kind, Step};
use crate::task::{Origin, Outcome, State, Work};
use crate::trace::What;
use crate::value::Value;

/// Returns false for a step that repeats without bound or responds repeatedly, and so never ends without a clause.
fn ends_by_itself(step: &Step) -> bool {
    step.repetition
        .as_ref()
        .is_none_or(|clause| !clause.responding && (clause.while_true.is_some() || clause.until.is_some()))
}

impl Agent<'_> {
    /// Ends the task with its subtree.
    pub(crate) fn end(&mut self, id: usize, outcome: Outcome, cause: String) {
        if self.tasks[id].state == State::Terminated {
            return;
        }
        self.end_children(id, &format!("parent T{id} ended"));
        self.tasks[id].watches.clear();
        if let (Outcome::Success(value), Some(name)) = (&outcome, self.step_of(id).and_then(|step| step.binds.clone()))
            && let Some(parent) = self.tasks[id].parent
        {
            self.bind_result(parent, &name, value.clone());
        }
        if self.tasks[id].started_at.is_some() {
            self.run_hooks(id, |hooks| &hooks.on_end);
        }
        if self.tasks[id].state == State::Terminated {
            return;
        }
        if outcome != Outcome::Cut {
            self.consume(id);
        }
        self.tasks[id].work = None;
        self.early_ends += u64::from(self.tasks[id].waits_for_step_before && outcome != Outcome::Cut);
        self.transition(id, State::Terminated, Some(outcome), cause);
        let task = &mut self.tasks[id];
        task.choice = None;
        task.held.clear();
        task.suspended = false;
        task.waits_for_interval = None;
        let (parent, answered) = (task.parent, task.answered);
        if let Some(parent) = parent {
            self.tasks[parent].answered = self.tasks[parent].answered.max(answered);
        }
        self.ended.push_back(id);
    }

    /// Removes the ongoing task's share of a resource that is used up, if its work has begun.
    pub(crate) fn consume(&mut self, id: usize) {
        if self.tasks[id].state != State::Ongoing || self.tasks[id].work.is_none() {
            return;
        }
        for (name, amount) in self.tasks[id].needs() {
            self.use_up(id, &name, amount);
        }
    }

    pub(crate) fn use_up(&mut self, id: usize, name: &str, amount: f64) {
        if !self.is_depletable(name) {
            return;
        }
        if let Some(total) = self.totals.get_mut(name) {
            *total = (*total - amount).max(0.0);
        }
        // Ancestors that reserved the same resource have used that much of it already.
        for above in self.line(id).into_iter().filter(|above| *above != id) {
            let task = &mut self.tasks[above];
            if task.state == State::Ongoing {
                let chosen = task.choice.iter_mut().flat_map(|choice| &mut choice.needs);
                chosen
                    .chain(&mut task.held)
                    .filter(|need| need.0 == name)
                    .for_each(|need| need.1 -= amount.min(need.1));
            }
        }
    }

    pub(crate) fn is_depletable(&self, name: &str) -> bool {
        self.program.resources.iter().any(|resource| resource.depletable && resource.name == name)
    }

    pub(crate) fn end_children(&mut self, id: usize, cause: &str) {
        for child in self.children(id) {
            self.end(child, Outcome::Cut, cause.to_string());
            self.forget(child);
        }
    }

    /// Lets the parents of ended tasks react, in order.
    pub(crate) fn settle(&mut self) {
        while let Some(id) = self.ended.pop_front() {
            if self.tasks[id].forgotten || self.tasks[id].state != State::Terminated {
                continue;
            }
            match self.tasks[id].parent {
                Some(parent) => self.react(parent, id),
                None => self.finish(),
            }
        }
    }

    fn react(&mut self, parent: usize, child: usize) {
        let failed = self.tasks[child].outcome.as_ref().is_some_and(Outcome::is_failure);
        let failed = failed && !self.failure_is_named(child);
        let cause = format!("child T{child} failed");
        match self.tasks[parent].work {
            Some(Work::Procedure { .. } | Work::Items(_)) if failed => self.fail(parent, cause),
            Some(Work::Procedure { .. }) => {
                if !self.repeat(child) {
                    self.skip_who_waits_in_vain(parent, child);
                    self.step_ended(parent, child);
                }
            }
            Some(Work::Items(_)) => self.item_ended(parent, child),
            Some(Work::Handling(_)) => self.handled(parent, child),
            Some(Work::Primitive { .. } | Work::BuiltIn) | None => {}
        }
    }

    fn step_ended(&mut self, parent: usize, child: usize) {
        let Origin::Step(procedure, step) = self.tasks[child].origin else { return };
        self.tasks[child].over = true;
        self.changed = true;
        let Some(Work::Procedure { current, children, ended, .. }) = &mut self.tasks[parent].work else { return };
        ended.insert(step);
        // In a sequence a step waits until all steps before it have ended.
        let first_open = (0..current.len()).find(|number| !ended.contains(number));
        let next = first_open.and_then(|number| current[number]);
        if !current.contains(&Some(child)) {
            children.remove(&child);
            self.forget(child);
        }
        if let Some(next) = next.filter(|_| self.program.procedures[procedure].kind == Kind::Sequential) {
            self.tasks[next].waits_for_step_before = false;
        }
        self.complete_when_done(parent);
    }

    /// Ends a procedure when all of its steps have ended that end without a clause, if there are any.
    pub(crate) fn complete_when_done(&mut self, id: usize) {
        let Some(Work::Procedure { procedure, children, .. }) = &self.tasks[id].work else { return };
        if !matches!(self.tasks[id].state, State::Ongoing | State::Interrupted) {
            return;
        }
        let endless_only = self.steps(*procedure).iter().all(|step| !ends_by_itself(step));
        let counts = |child: usize| endless_only || self.step_of(child).is_none_or(ends_by_itself);
        let open = children.iter().any(|child| counts(*child) && !self.tasks[*child].over);
        let procedure = &self.program.procedures[*procedure];
        // A concurrent procedure with an end-when ends itself when its goal is reached.
        let says_itself = procedure.kind == Kind::Concurrent && procedure.clauses.end_when.is_some();
        if !open && !says_itself {
            self.end(id, Outcome::Success(Value::Nil), "all steps ended".into());
        }
    }

    fn item_ended(&mut self, parent: usize, child: usize) {
        let Some(Work::Items(children)) = &mut self.tasks[parent].work else { return };
        children.remove(&child);
        let done = children.is_empty();
        self.forget(child);
        if done {
            self.end(parent, Outcome::Success(Value::Nil), "all items ended".into());
        }
    }

    fn finish(&mut self) {
        if !self.finished {
            self.finished = true;
            self.tell(0, What::Finished);
        }
    }

    /// `(end-application)`: the root task is cut, together with all tasks below it.
    pub(crate) fn end_application(&mut self) {
        if self.finished {
            return;
        }
        self.finished = true;
        self.end(0, Outcome::Cut, "the application ended".into());
        self.ended.clear();
        self.tell(0, What::Finished);
    }
}
