//! Failure: a step's `on-failure` goal handles it, or the task fails, too.

use crate::agent::Agent;
use crate::task::{Origin, Outcome, State, Work};

impl Agent<'_> {
    pub(crate) fn fail(&mut self, id: usize, cause: String) {
        self.fail_as(id, Outcome::Failure, cause);
    }

    pub(crate) fn fail_as(&mut self, id: usize, outcome: Outcome, cause: String) {
        if self.tasks[id].state != State::Terminated && !self.handle(id) {
            self.end(id, outcome, cause);
        }
    }

    fn handle(&mut self, id: usize) -> bool {
        let Origin::Step(procedure, step) = self.tasks[id].origin else { return false };
        let is_handling = matches!(self.tasks[id].work, Some(Work::Handling(_)));
        if is_handling || self.own_step(id).is_none_or(|step| step.on_failure.is_none()) {
            return false;
        }
        self.end_children(id, &format!("parent T{id} failed"));
        // The failed work has ended, and the trace reports it; the step continues with its handler.
        self.run_inner_hook(id, |hooks| &hooks.on_end);
        if self.tasks[id].state == State::Terminated {
            return true;
        }
        // Amounts used by the failed work are gone, and the handler claims again. All other state is kept for the handler.
        if self.tasks[id].state == State::Ongoing {
            self.consume(id);
            let spent: Vec<_> = self.tasks[id].needs().into_iter().filter(|need| self.is_depletable(&need.0)).collect();
            let stays = |need: &(String, f64)| spent.iter().all(|each| each.0 != need.0);
            self.tasks[id].held.retain(stays);
            if let Some(choice) = &mut self.tasks[id].choice {
                choice.needs.retain(stays);
            }
        }
        self.tasks[id].work = None;
        self.forget_clauses(id);
        let handler = self.create(Some(id), Origin::Handler(procedure, step));
        self.tasks[id].work = Some(Work::Handling(handler));
        let cause = format!("handled by T{handler}");
        if self.tasks[id].state == State::Pending {
            let task = &mut self.tasks[id];
            task.waits_for_result = false;
            task.waits_for_condition = false;
            task.waits_for_interval = None;
            self.transition(id, State::Enabled, None, cause.clone());
        }
        if self.tasks[id].state != State::Ongoing {
            // From now on the handler is the step's work, and the step needs nothing else.
            self.tasks[id].held.clear();
            if let Some(choice) = &mut self.tasks[id].choice {
                choice.needs.clear();
            }
            if self.is_eligible(id) {
                self.transition(id, State::Ongoing, None, cause);
            }
        }
        self.arm(handler);
        true
    }

    /// Ends the step in the same way as its handler has ended.
    pub(crate) fn handled(&mut self, id: usize, handler: usize) {
        match self.tasks[handler].outcome.clone() {
            Some(outcome) if outcome.is_failure() => {
                self.end(id, Outcome::Failure, format!("child T{handler} failed"));
            }
            None => self.end(id, Outcome::Failure, format!("child T{handler} failed")),
            Some(outcome) => self.end(id, outcome, format!("handler T{handler} ended")),
        }
    }
}
