//! Interruption, suspension, resumption and restart.

use crate::agent::Agent;
use crate::program::{Clauses, Form, Hooks};
use crate::task::{Clause, Level, State, Window, Work};

impl<'p> Agent<'p> {
    /// Returns the clauses of the task at this level; those of a procedure only once it has begun.
    fn clauses(&self, id: usize, level: Level) -> Option<&'p Clauses> {
        match level {
            Level::Step => Some(&self.own_step(id)?.clauses),
            Level::Procedure => match self.tasks[id].work {
                Some(Work::Procedure { procedure, .. }) => Some(&self.program.procedures[procedure].clauses),
                _ => None,
            },
        }
    }

    /// Watches for a suspension of the step, from the creation of the task or from the time at which all variables in the clauses are
    /// known.
    pub(crate) fn watch_step_suspension(&mut self, id: usize) {
        let Some(clauses) = self.clauses(id, Level::Step) else { return };
        let about = |clause| matches!(clause, Clause::SuspendWhen | Clause::SuspendUntil | Clause::ResumeWhen);
        let has = self.tasks[id].watches.iter().any(|watch| watch.level == Level::Step && about(watch.clause));
        if has || self.has_yet_to_learn(id, clauses) {
            return;
        }
        let pending = self.tasks[id].state == State::Pending;
        let start = if pending { self.tasks[id].created_at } else { self.now };
        let window = Window { start, after: None };
        if let Some(condition) = &clauses.resume_when {
            self.watch(id, Clause::ResumeWhen, Level::Step, condition, window);
        }
        if let Some((condition, _)) = &clauses.suspend_when {
            self.watch(id, Clause::SuspendWhen, Level::Step, condition, window);
            if let Some(watch) = self.tasks[id].watches.last_mut() {
                watch.at_once = true;
            }
        }
    }

    /// Returns true if a variable in the suspension clauses gets its value only when the task is enabled.
    fn has_yet_to_learn(&self, id: usize, clauses: &Clauses) -> bool {
        let mut named: Vec<_> = clauses.resume_when.iter().collect();
        if let Some((when, until)) = &clauses.suspend_when {
            named.extend([when, until]);
        }
        self.tasks[id].state == State::Pending && !self.all_known(id, &named)
    }

    /// After a suspension by a clause, watches the conditions of resumption.
    pub(crate) fn watch_resumption(&mut self, id: usize, level: Level, window: Window) {
        let Some(clauses) = self.clauses(id, level) else { return };
        self.unwatch(id, |clause, at| clause == Clause::ResumeWhen && at == level);
        if let Some((_, until)) = &clauses.suspend_when {
            self.watch(id, Clause::SuspendUntil, level, until, window);
        }
        if let Some(condition) = &clauses.resume_when {
            self.watch(id, Clause::ResumeWhen, level, condition, window);
        }
    }

    /// After a resumption, ends the watches of conditions of resumption and watches the conditions of suspension again.
    pub(crate) fn watch_suspension_anew(&mut self, id: usize, window: Window) {
        let about = |clause| matches!(clause, Clause::SuspendWhen | Clause::SuspendUntil | Clause::ResumeWhen);
        self.unwatch(id, |clause, _| about(clause));
        for level in [Level::Step, Level::Procedure] {
            let Some(clauses) = self.clauses(id, level) else { continue };
            if self.has_yet_to_learn(id, clauses) {
                continue;
            }
            if let Some((when, _)) = &clauses.suspend_when {
                self.watch(id, Clause::SuspendWhen, level, when, window);
            }
            if let Some(condition) = &clauses.resume_when {
                self.watch(id, Clause::ResumeWhen, level, condition, window);
            }
        }
        // A fact that is still true has already suspended the task once, and does not suspend it again.
        let anew = self.tasks[id].watches.iter_mut().filter(|watch| about(watch.clause));
        anew.for_each(|watch| watch.standing = false);
    }

    /// Interrupts the task and stops its clocks.
    pub(crate) fn stop(&mut self, id: usize, cause: String) {
        if self.tasks[id].state != State::Ongoing {
            return;
        }
        let now = self.now;
        if let Some(Work::Primitive { worked, since, end, update, update_left, .. }) = &mut self.tasks[id].work {
            *worked += since.take().map_or(0, |since| now - since);
            *end = None;
            if let Some((at, _)) = update.take() {
                *update_left = at - now;
            }
        }
        self.transition(id, State::Interrupted, None, cause);
        self.run_hooks(id, |hooks| &hooks.on_suspend);
    }

    /// Runs the hooks of the procedure or primitive that is at work for the task, then those of its step.
    pub(crate) fn run_hooks(&mut self, id: usize, which: impl Fn(&Hooks) -> &Vec<Form>) {
        self.run_inner_hook(id, &which);
        self.run_step_hook(id, which);
    }

    /// Runs a hook of the procedure or primitive. While a failure is handled, neither is at work.
    pub(crate) fn run_inner_hook(&mut self, id: usize, which: impl Fn(&Hooks) -> &Vec<Form>) {
        let program = self.program;
        let forms = match &self.tasks[id].work {
            Some(Work::Procedure { procedure, .. }) => which(&program.procedures[*procedure].hooks),
            Some(Work::Primitive { primitive, .. }) => which(&program.primitives[*primitive].hooks),
            _ => return,
        };
        let _ = self.run_forms(id, Level::Procedure, forms);
    }

    pub(crate) fn run_step_hook(&mut self, id: usize, which: impl Fn(&Hooks) -> &Vec<Form>) {
        if let Some(step) = self.own_step(id) {
            let _ = self.run_forms(id, Level::Step, which(&step.hooks));
        }
    }

    /// Returns the task and all tasks below it, ancestors first.
    fn subtree(&self, id: usize) -> Vec<usize> {
        let mut all = vec![id];
        for child in self.children(id) {
            all.extend(self.subtree(child));
        }
        all
    }

    /// Returns the children in order of creation.
    pub(crate) fn children(&self, id: usize) -> Vec<usize> {
        match &self.tasks[id].work {
            Some(Work::Procedure { children, .. } | Work::Items(children)) => children.iter().copied().collect(),
            Some(Work::Handling(handler)) => vec![*handler],
            Some(Work::Primitive { .. } | Work::BuiltIn) | None => Vec::new(),
        }
    }

    /// Suspends the subtree: no task in it works or begins until the task is resumed.
    pub(crate) fn suspend(&mut self, id: usize, cause: String) {
        if self.tasks[id].suspended || self.tasks[id].state == State::Terminated {
            return;
        }
        self.tasks[id].suspended = true;
        self.changed = true;
        for each in self.subtree(id) {
            let cause = if each == id { cause.clone() } else { format!("suspended T{id}") };
            self.stop(each, cause);
        }
    }

    pub(crate) fn resume(&mut self, id: usize, cause: String) {
        if !self.tasks[id].suspended {
            return;
        }
        self.tasks[id].suspended = false;
        self.changed = true;
        for each in self.subtree(id) {
            let cause = if each == id { cause.clone() } else { format!("resumed T{id}") };
            self.resumed.insert(each, cause);
        }
    }

    /// After the end of the task's work, before that of the task, ends the watches of clauses of its procedure, and a suspension by the
    /// procedure. A suspension by the step's clause or by an activity stays.
    pub(crate) fn forget_clauses(&mut self, id: usize) {
        let task = &mut self.tasks[id];
        let mut watches = task.watches.iter();
        if watches.any(|watch| watch.clause == Clause::SuspendUntil && watch.level == Level::Procedure) {
            task.suspended = false;
        }
        let suspended = task.suspended;
        self.unwatch(id, |clause, level| match clause {
            Clause::EndWhen | Clause::ExitWhen => level == Level::Procedure,
            Clause::SuspendWhen | Clause::SuspendUntil | Clause::ResumeWhen => level == Level::Procedure || !suspended,
            Clause::Waitfor | Clause::RestartWhen | Clause::SkipWhen => true,
        });
    }

    /// Restarts the task: its work is lost, its preconditions stay satisfied, and end hooks do not run.
    pub(crate) fn restart(&mut self, id: usize, cause: String) {
        if !matches!(self.tasks[id].state, State::Ongoing | State::Interrupted) {
            return;
        }
        self.end_children(id, &format!("parent T{id} restarted"));
        self.forget_clauses(id);
        self.tasks[id].work = None;
        self.transition(id, State::Pending, None, cause);
        let (now, newest) = (self.now, self.arrivals.checked_sub(1));
        let task = &mut self.tasks[id];
        task.started_at = None;
        // All arrivals up to now belong to the work that is restarted.
        task.answered = task.answered.max(newest);
        task.created_at = now;
        task.choice = None;
        task.held.clear();
        task.waits_for_result = false;
        task.waits_for_condition = false;
        task.waits_for_interval = None;
    }
}
