//! Conditions at the beginning of a task and during its work, and consequences of the outcomes of steps.

use crate::agent::Agent;
use crate::expression::compare;
use crate::program::{Clauses, Condition, Step, Term};
use crate::task::{Level, OUTCOMES, Origin, Outcome, State, Way, Work};
use crate::value::Value;

impl<'p> Agent<'p> {
    /// Returns the clauses of the step, then those of the selected procedure.
    fn own_clauses(&self, id: usize) -> Vec<(&'p Clauses, Level)> {
        let step = self.own_step(id).map(|step| (&step.clauses, Level::Step));
        let chosen = match self.tasks[id].choice.as_ref().map(|choice| &choice.way) {
            Some(Way::Procedure(number)) => Some((&self.program.procedures[*number].clauses, Level::Procedure)),
            _ => None,
        };
        step.into_iter().chain(chosen).collect()
    }

    /// Checks the preconditions: if one does not hold, or is not known to hold, the task fails.
    pub(crate) fn precondition_holds(&mut self, id: usize) -> bool {
        for (clauses, level) in self.own_clauses(id) {
            if let Some(condition) = &clauses.precondition
                && self.holds_now(condition, id, level) != Some(true)
            {
                self.fail_as(id, Outcome::PreconditionFailed, "precondition does not hold".into());
                return false;
            }
        }
        true
    }

    /// Checks the invariants: if one is known not to hold, the task fails.
    pub(crate) fn invariant_holds(&mut self, id: usize) -> bool {
        for (clauses, level) in self.own_clauses(id) {
            if let Some(condition) = &clauses.invariant
                && self.holds_now(condition, id, level) == Some(false)
            {
                self.fail_as(id, Outcome::InvariantViolated, "invariant does not hold".into());
                return false;
            }
        }
        true
    }

    /// Checks the invariants of all tasks that work.
    pub(crate) fn judge_invariants(&mut self) {
        let works = self.ids(|task| {
            task.state == State::Ongoing && task.work.is_some() && !matches!(task.work, Some(Work::Handling(_)))
        });
        for id in works {
            let works = self.tasks[id].state == State::Ongoing && !self.tasks[id].forgotten;
            if works && !self.resuming.contains(&id) && !matches!(self.tasks[id].work, None | Some(Work::Handling(_))) {
                self.invariant_holds(id);
                self.settle();
            }
        }
    }

    fn holds_now(&self, condition: &Condition, id: usize, level: Level) -> Option<bool> {
        match condition {
            Condition::Measurement(attribute, Term::Is(object), relation, number) => {
                let value = self.newest(attribute, &object.to_string())?;
                compare(*relation, &value, &Value::Number(*number)).ok()
            }
            Condition::Ended(tag) => Some(self.tasks[self.tagged_task(id, level, tag)?].state == State::Terminated),
            Condition::State(tag, word) => {
                let other = tag.as_ref().map_or(Some(id), |tag| self.tagged_task(id, level, tag))?;
                let task = &self.tasks[other];
                Some(match OUTCOMES.contains(&word.as_str()) {
                    true => {
                        task.state == State::Terminated && task.outcome.as_ref().is_some_and(|outcome| outcome.is(word))
                    }
                    false => task.state.word() == word,
                })
            }
            Condition::Not(part) => self.holds_now(part, id, level).map(|holds| !holds),
            Condition::And(parts) => self.judged(parts, false, id, level),
            Condition::Or(parts) => self.judged(parts, true, id, level),
            _ => None,
        }
    }

    fn tagged_task(&self, id: usize, level: Level, tag: &str) -> Option<usize> {
        match self.variable(id, level, tag) {
            Some(Value::Task(other)) => Some(other),
            _ => None,
        }
    }

    /// Combines the parts of `:and` or `:or`: one with the deciding truth value decides; otherwise an unknown part makes the result
    /// unknown.
    fn judged(&self, parts: &[Condition], deciding: bool, id: usize, level: Level) -> Option<bool> {
        let truths: Vec<Option<bool>> = parts.iter().map(|part| self.holds_now(part, id, level)).collect();
        if truths.contains(&Some(deciding)) {
            return Some(deciding);
        }
        if truths.contains(&None) { None } else { Some(!deciding) }
    }

    /// Returns true if a clause of the procedure, or of another step, names a failure of the step.
    pub(crate) fn failure_is_named(&self, child: usize) -> bool {
        let Origin::Step(procedure, number) = self.tasks[child].origin else { return false };
        let steps = self.steps(procedure);
        let tag = &steps[number].tag;
        let named = |clauses: &Clauses| all_of(clauses).iter().any(|each| names_failure(each, tag));
        let by_step = |step: &Step| {
            step.tag != *tag && (step.waitfor.iter().any(|each| names_failure(each, tag)) || named(&step.clauses))
        };
        named(&self.program.procedures[procedure].clauses) || steps.iter().any(by_step)
    }

    /// Skips the siblings that wait for another outcome, or for the result, of a step that has ended finally.
    pub(crate) fn skip_who_waits_in_vain(&mut self, parent: usize, child: usize) {
        let Some(Work::Procedure { procedure, current, .. }) = &self.tasks[parent].work else { return };
        let (procedure, current) = (*procedure, current.clone());
        let Origin::Step(_, number) = self.tasks[child].origin else { return };
        if current.get(number).copied().flatten() != Some(child) {
            return;
        }
        let steps = self.steps(procedure);
        let tag = &steps[number].tag;
        let mut skipped = Vec::new();
        for (other, step) in steps.iter().enumerate() {
            let Some(id) = current[other].filter(|_| other != number) else { continue };
            let task = &self.tasks[id];
            let waits = task.state == State::Pending && task.waits_for_condition;
            let concerned = step.waitfor.iter().any(|condition| names_outcome(condition, tag));
            if waits && concerned && step.waitfor.iter().any(|condition| self.is_vain(condition, steps, &current)) {
                skipped.push((id, "its outcome is missed"));
            }
        }
        let succeeded = matches!(self.tasks[child].outcome, Some(Outcome::Success(_)));
        let missing = steps[number].binds.as_ref().filter(|_| !succeeded);
        for (name, other) in missing.into_iter().flat_map(|name| (0..steps.len()).map(move |other| (name, other))) {
            let Some(id) = current[other] else { continue };
            let open = |step: usize| current[step].is_some_and(|task| self.tasks[task].state != State::Terminated);
            let gives = |step: &usize| steps[*step].binds.as_ref() == Some(name);
            let uses = self.tasks[id].state == State::Pending
                && (self.tasks[id].waits_for_result || self.tasks[id].waits_for_step_before)
                && self.uses(id, name)
                && self.variable(id, Level::Step, name).is_none();
            if uses && !(0..steps.len()).filter(gives).any(open) {
                skipped.push((id, "its result is missed"));
            }
        }
        for (id, cause) in skipped {
            self.end(id, Outcome::Skipped, cause.into());
        }
    }

    /// Returns true if the condition can never hold, because steps ended otherwise.
    fn is_vain(&self, condition: &Condition, steps: &[Step], current: &[Option<usize>]) -> bool {
        match condition {
            Condition::State(Some(tag), word) if OUTCOMES.contains(&word.as_str()) => {
                let number = steps.iter().position(|step| step.tag == *tag);
                let task = number.and_then(|number| current[number]).map(|task| &self.tasks[task]);
                task.is_some_and(|task| {
                    let ended = task.state == State::Terminated;
                    ended && task.outcome.as_ref().is_some_and(|outcome| !outcome.is(word))
                })
            }
            Condition::And(parts) | Condition::InOrder(parts) => {
                parts.iter().any(|part| self.is_vain(part, steps, current))
            }
            Condition::Or(parts) => parts.iter().all(|part| self.is_vain(part, steps, current)),
            _ => false,
        }
    }
}

fn all_of(clauses: &Clauses) -> Vec<&Condition> {
    let suspend = clauses.suspend_when.iter().flat_map(|(when, until)| [when, until]);
    let others = [
        &clauses.end_when,
        &clauses.restart_when,
        &clauses.resume_when,
        &clauses.skip_when,
        &clauses.exit_when,
        &clauses.precondition,
        &clauses.invariant,
    ];
    others.into_iter().flatten().chain(suspend).collect()
}

fn names(condition: &Condition, tag: &str, words: &[&str]) -> bool {
    match condition {
        Condition::State(Some(other), word) => other == tag && words.contains(&word.as_str()),
        Condition::And(parts) | Condition::Or(parts) | Condition::InOrder(parts) => {
            parts.iter().any(|part| names(part, tag, words))
        }
        Condition::Not(part) => names(part, tag, words),
        _ => false,
    }
}

fn names_failure(condition: &Condition, tag: &str) -> bool {
    names(condition, tag, &["failed", "precondition-failed", "invariant-violated"])
}

fn names_outcome(condition: &Condition, tag: &str) -> bool {
    names(condition, tag, OUTCOMES)
}
