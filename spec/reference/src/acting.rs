//! The act phase: actions of tasks that became ongoing, and their timers.

use crate::agent::{Agent, Said};
use crate::program::{Activity, Form, Primitive};
use crate::task::{Alarm, Clause, Level, Origin, Outcome, State, Way, Work};
use crate::trace::What;
use crate::value::{Bindings, Value};
use std::collections::{BTreeMap, BTreeSet};

impl Agent<'_> {
    pub(crate) fn act(&mut self) {
        for id in std::mem::take(&mut self.resuming) {
            self.changed = true;
            if !self.finished && !self.tasks[id].forgotten && self.tasks[id].state == State::Ongoing {
                self.go_on(id);
                self.settle();
            }
        }
        for id in std::mem::take(&mut self.starting) {
            self.changed = true;
            if self.finished || self.tasks[id].forgotten || self.tasks[id].state != State::Ongoing {
                continue;
            }
            if self.tasks[id].work.is_none() {
                self.begin(id);
            } else if self.tasks[id].watches.iter().any(|watch| watch.clause == Clause::RestartWhen) {
                // Its `restart-when` is noticed first: a task that starts over does not resume.
                self.resuming.insert(id);
            } else {
                self.go_on(id);
            }
            self.settle();
        }
    }

    fn go_on(&mut self, id: usize) {
        let handling = matches!(self.tasks[id].work, Some(Work::Handling(_)));
        // The handler could not begin before this start of the task, so the start is not a resumption of the handler.
        if handling && self.tasks[id].started_at == Some(self.now) {
            return;
        }
        if !handling && !self.invariant_holds(id) {
            return;
        }
        if matches!(self.tasks[id].work, Some(Work::Primitive { .. })) {
            self.resume_primitive(id);
            self.run_step_hook(id, |hooks| &hooks.on_resume);
        } else {
            self.run_hooks(id, |hooks| &hooks.on_resume);
        }
    }

    fn begin(&mut self, id: usize) {
        self.unwatch(id, |clause, _| clause == Clause::SkipWhen);
        if !self.precondition_holds(id) || !self.invariant_holds(id) {
            return;
        }
        self.run_step_hook(id, |hooks| &hooks.on_start);
        if let Some(condition) = self.own_step(id).and_then(|step| step.clauses.restart_when.as_ref()) {
            // Before the work begins there is nothing to restart.
            let window = crate::task::Window { start: self.now, ..self.window(id) };
            self.watch(id, Clause::RestartWhen, Level::Step, condition, window);
        }
        if self.tasks[id].state != State::Ongoing {
            return;
        }
        let Some(choice) = self.tasks[id].choice.clone() else { return };
        match choice.way {
            Way::Procedure(procedure) => self.begin_procedure(id, procedure, choice.bound),
            Way::Primitive(primitive) => self.begin_primitive(id, primitive, choice.bound),
            Way::Items(items) => self.begin_items(id, &items),
            Way::BuiltIn => {
                self.tasks[id].work = Some(Work::BuiltIn);
                if self.carry_out(id).is_err() {
                    self.fail(id, "an expression".into());
                }
            }
        }
    }

    fn begin_procedure(&mut self, id: usize, number: usize, context: Bindings) {
        let procedure = &self.program.procedures[number];
        let current = vec![None; procedure.steps.len()];
        let (children, ended) = (BTreeSet::new(), BTreeSet::new());
        self.tasks[id].work = Some(Work::Procedure { procedure: number, context, current, children, ended });
        let _ = self.run_forms(id, Level::Procedure, &procedure.hooks.on_start);
        let clauses = &procedure.clauses;
        // These clauses count from the start of the procedure.
        let window = crate::task::Window { start: self.now, ..self.window(id) };
        let all = crate::task::Window { after: None, ..window };
        let suspension = clauses.suspend_when.as_ref().map(|(when, _)| when);
        let wanted = [
            (Clause::EndWhen, clauses.end_when.as_ref(), window),
            (Clause::ExitWhen, clauses.exit_when.as_ref(), window),
            (Clause::RestartWhen, clauses.restart_when.as_ref(), window),
            (Clause::SuspendWhen, suspension, all),
            (Clause::ResumeWhen, clauses.resume_when.as_ref(), all),
        ];
        for (clause, condition, window) in wanted {
            if let Some(condition) = condition {
                self.watch(id, clause, Level::Procedure, condition, window);
            }
        }
        self.create_steps(id, number);
    }

    fn begin_items(&mut self, id: usize, items: &[Value]) {
        let Origin::Step(procedure, step) = self.tasks[id].origin else { return };
        let name = self.step_of(id).and_then(|step| step.forall.as_ref()).map(|(name, _)| name.clone());
        let mut children = BTreeSet::new();
        for item in items {
            let child = self.create(Some(id), Origin::Item(procedure, step));
            if let Some(name) = &name {
                self.tasks[child].bound.insert(name.clone(), item.clone());
            }
            children.insert(child);
        }
        self.tasks[id].work = Some(Work::Items(children));
        if items.is_empty() {
            self.end(id, Outcome::Success(Value::Nil), "all items ended".into());
        }
    }

    fn begin_primitive(&mut self, id: usize, number: usize, context: Bindings) {
        let primitive = &self.program.primitives[number];
        self.tasks[id].work = Some(Work::Primitive {
            primitive: number,
            context,
            locals: BTreeMap::new(),
            duration: None,
            worked: 0,
            since: None,
            end: None,
            update: None,
            update_left: primitive.update.as_ref().map_or(0, |(interval, _)| *interval),
        });
        if self.prepare(id, primitive).is_err() {
            self.fail(id, "an expression".into());
        }
    }

    fn prepare(&mut self, id: usize, primitive: &Primitive) -> Result<(), crate::expression::Fails> {
        for (name, expr) in &primitive.locals {
            let first = self.evaluate(expr, id, Level::Procedure)?;
            if let Some(Work::Primitive { locals, .. }) = &mut self.tasks[id].work {
                locals.insert(name.clone(), first);
            }
        }
        let completed = self.run_forms(id, Level::Procedure, &primitive.hooks.on_start)?;
        if let Some(expr) = &primitive.duration {
            let Value::Span(span) = self.evaluate(expr, id, Level::Procedure)? else {
                return Err(crate::expression::Fails);
            };
            if let Some(Work::Primitive { duration, .. }) = &mut self.tasks[id].work {
                *duration = Some(span);
            }
        }
        match completed {
            Some(value) => self.complete(id, Some(value), "a form"),
            None => self.run_clock(id),
        }
        Ok(())
    }

    fn resume_primitive(&mut self, id: usize) {
        let Some(Work::Primitive { primitive, .. }) = self.tasks[id].work else { return };
        let forms: &[Form] = &self.program.primitives[primitive].hooks.on_resume;
        match self.run_forms(id, Level::Procedure, forms) {
            Ok(None) => self.run_clock(id),
            Ok(Some(value)) => self.complete(id, Some(value), "a form"),
            Err(_) => self.fail(id, "an expression".into()),
        }
    }

    /// Sets the clocks of a primitive for its remaining work; a primitive that waits for nothing is complete.
    fn run_clock(&mut self, id: usize) {
        let now = self.now;
        let (first, second) = (self.next_serial(), self.next_serial());
        let Some(Work::Primitive { primitive, duration, worked, since, end, update, update_left, .. }) =
            &mut self.tasks[id].work
        else {
            return;
        };
        let updates = self.program.primitives[*primitive].update.is_some();
        *since = Some(now);
        match duration {
            Some(duration) if *duration <= *worked => self.complete(id, None, "its duration"),
            None if !updates => self.complete(id, None, "at once"),
            duration => {
                *end = duration.map(|duration| (now + duration - *worked, first));
                *update = updates.then_some((now + *update_left, second));
            }
        }
    }

    /// Handles the instant of a clock: the end of the primitive's duration, or its next update.
    pub(crate) fn clock_rings(&mut self, id: usize, alarm: Alarm) {
        let now = self.now;
        let serial = self.next_serial();
        let Some(Work::Primitive { primitive, end, update, .. }) = &mut self.tasks[id].work else { return };
        if *end == Some(alarm) {
            *end = None;
            return self.complete(id, None, "its duration");
        }
        *update = None;
        let Some((interval, forms)) = &self.program.primitives[*primitive].update else { return };
        match self.run_forms(id, Level::Procedure, forms) {
            Err(_) => self.fail(id, "an expression".into()),
            Ok(Some(value)) => self.complete(id, Some(value), "a form"),
            Ok(None) => {
                let works = self.tasks[id].state == State::Ongoing;
                if let Some(Work::Primitive { update, .. }) = self.tasks[id].work.as_mut().filter(|_| works) {
                    *update = Some((now + interval, serial));
                }
            }
        }
    }

    fn complete(&mut self, id: usize, value: Option<Value>, cause: &str) {
        let Some(Work::Primitive { primitive, .. }) = self.tasks[id].work else { return };
        let primitive = &self.program.primitives[primitive];
        let _ = self.run_forms(id, Level::Procedure, &primitive.on_completion);
        let value = match &primitive.returns {
            None => Ok(value.unwrap_or(Value::Nil)),
            Some(expr) => self.evaluate(expr, id, Level::Procedure),
        };
        match value {
            Ok(value) => self.end(id, Outcome::Success(value), cause.into()),
            Err(_) => self.fail(id, "an expression".into()),
        }
    }

    /// Returns the task that a tag names.
    fn named(&self, id: usize, tag: &str) -> Result<usize, crate::expression::Fails> {
        match self.variable(id, Level::Step, tag) {
            Some(Value::Task(other)) => Ok(other),
            _ => Err(crate::expression::Fails),
        }
    }

    fn carry_out(&mut self, id: usize) -> Result<(), crate::expression::Fails> {
        let Some(activity) = self.activity(id) else { return Ok(()) };
        match activity {
            Activity::Goal(_) => {}
            Activity::Terminate { tag, outcome, value } => {
                return self.terminate(id, tag.as_deref(), outcome.as_deref(), value.as_ref());
            }
            Activity::Reset(tag) => self.restart(self.named(id, tag)?, format!("reset by T{id}")),
            Activity::Suspend(tag) => self.suspend(self.named(id, tag)?, format!("suspend by T{id}")),
            Activity::Resume(tag) => {
                let other = self.named(id, tag)?;
                self.resume(other, format!("resume by T{id}"));
                let window = crate::task::Window { start: self.now, after: self.arrivals.checked_sub(1) };
                self.watch_suspension_anew(other, window);
            }
            Activity::Reprioritize(tag) => {
                self.named(id, tag)?;
            }
            Activity::Inform(words) => {
                let words = self.filled(words, id, Level::Step)?;
                self.inform(id, words);
            }
            Activity::Cogevent(words) => {
                let words = self.filled(words, id, Level::Step)?;
                self.said.push(Said::Message(words));
            }
            Activity::Print(expr) => {
                let text = self.evaluate(expr, id, Level::Step)?.to_string();
                self.tell(id, What::Printed(text));
            }
            Activity::Hold(_) => self.hand_to_parent(id),
            Activity::Release(name) => self.release_of_parent(id, name),
            Activity::EndApplication => self.end_application(),
        }
        self.done(id);
        Ok(())
    }

    fn done(&mut self, id: usize) {
        if self.tasks[id].state == State::Ongoing {
            self.end(id, Outcome::Success(Value::Nil), "at once".into());
        }
    }

    /// Passes the resources granted to a hold step to its procedure.
    fn hand_to_parent(&mut self, id: usize) {
        let needs = self.tasks[id].needs();
        let Some(parent) = self.tasks[id].parent else { return };
        if let Some(choice) = &mut self.tasks[id].choice {
            choice.needs.clear();
        }
        let held = self.tasks[parent].needs();
        let new = needs.into_iter().filter(|(name, _)| held.iter().all(|(other, _)| other != name));
        self.tasks[parent].held.extend(new.collect::<Vec<_>>());
    }

    fn release_of_parent(&mut self, id: usize, name: &str) {
        let Some(parent) = self.tasks[id].parent else { return };
        let total = self.total(name);
        let mut whole = vec![(name.to_string(), total)];
        self.add_parts(&mut whole);
        let held = std::mem::take(&mut self.tasks[parent].held);
        let (released, kept) = held.into_iter().partition(|(other, _)| whole.iter().any(|(part, _)| part == other));
        self.tasks[parent].held = kept;
        let released: Vec<(String, f64)> = released;
        for (name, amount) in released {
            if self.tasks[parent].state == State::Ongoing {
                self.use_up(parent, &name, amount);
            }
        }
    }

    fn terminate(
        &mut self,
        id: usize,
        tag: Option<&str>,
        outcome: Option<&str>,
        value: Option<&crate::program::Expr>,
    ) -> Result<(), crate::expression::Fails> {
        let target = match tag {
            Some(tag) => Some(self.named(id, tag)?),
            None => self.procedure_above(id),
        };
        let value = value.map_or(Ok(Value::Nil), |expr| self.evaluate(expr, id, Level::Step))?;
        let outcome = match outcome {
            Some("failure") => Outcome::Failure,
            Some("cut") => Outcome::Cut,
            Some(_) => Outcome::Success(value),
            None if tag.is_some() && !value.is_true() => Outcome::Cut,
            None => Outcome::Success(value),
        };
        let answered = self.tasks[id].answered;
        self.done(id);
        let Some(target) = target else { return Ok(()) };
        if tag.is_some() {
            self.tasks[target].repeats_no_more = true;
        }
        self.tasks[target].answered = self.tasks[target].answered.max(answered);
        let cause = format!("terminate by T{id}");
        match outcome {
            Outcome::Failure => self.fail(target, cause),
            outcome => self.end(target, outcome, cause),
        }
        Ok(())
    }
}
