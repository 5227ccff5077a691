//! The choose phase: the method for the goal of an enabled task, and its resources.

use crate::agent::Agent;
use crate::program::{Activity, Need, Term};
use crate::task::{Choice, Level, Origin, State, Way, add};
use crate::value::{Bindings, Value, matches};
use std::cmp::Reverse;

/// Default interrupt cost of an ongoing task.
const INTERRUPT_COST: f64 = 0.1;

impl<'p> Agent<'p> {
    pub(crate) fn choose(&mut self) {
        for id in self.ids(|task| task.state == State::Enabled && task.choice.is_none() && task.work.is_none()) {
            let open = self.tasks[id].state == State::Enabled && self.tasks[id].choice.is_none();
            if !open || self.tasks[id].forgotten {
                continue;
            }
            self.changed = true;
            match self.choose_for(id) {
                Ok(()) => {
                    self.precondition_holds(id);
                }
                Err(cause) => self.fail(id, cause.into()),
            }
            self.settle();
        }
    }

    /// Returns the activity that a task pursues; the root has a separate goal.
    pub(crate) fn activity(&self, id: usize) -> Option<&'p Activity> {
        let step = self.step_of(id)?;
        match self.tasks[id].origin {
            Origin::Handler(..) => step.on_failure.as_ref(),
            _ => Some(&step.activity),
        }
    }

    fn choose_for(&mut self, id: usize) -> Result<(), &'static str> {
        const EXPRESSION: &str = "an expression";
        let (way, bound) = self.way(id)?;
        let choice = Choice {
            way: way.clone(),
            bound,
            needs: Vec::new(),
            interrupt_cost: INTERRUPT_COST,
            expected: None,
            refuses: false,
        };
        self.tasks[id].choice = Some(choice);
        let mut needs = Vec::new();
        let (mut cost, mut expected) = (None, None);
        let mut refuses = false;
        match &way {
            Way::Procedure(number) => {
                let procedure = &self.program.procedures[*number];
                refuses |= procedure.profile.iter().any(|need| need.refuse_if_busy);
                self.profile(id, Level::Procedure, &procedure.profile, &mut needs)?;
                cost = procedure.interrupt_cost.as_ref().map(|cost| (cost, Level::Procedure));
                expected = procedure.expected;
            }
            Way::Primitive(number) => {
                let primitive = &self.program.primitives[*number];
                refuses |= primitive.profile.iter().any(|need| need.refuse_if_busy);
                self.profile(id, Level::Procedure, &primitive.profile, &mut needs)?;
                let duration = primitive.duration.as_ref();
                let duration = duration.and_then(|expr| self.evaluate(expr, id, Level::Procedure).ok());
                expected = match duration {
                    Some(Value::Span(span)) => Some(span),
                    _ => None,
                };
            }
            Way::BuiltIn => {
                if let Some(Activity::Hold(name)) = self.activity(id) {
                    add(&mut needs, name, self.total(name));
                }
            }
            Way::Items(_) => {}
        }
        if let Some(step) = self.own_step(id) {
            refuses |= step.profile.iter().any(|need| need.refuse_if_busy);
            self.profile(id, Level::Step, &step.profile, &mut needs)?;
            cost = step.interrupt_cost.as_ref().map(|cost| (cost, Level::Step)).or(cost);
        }
        let cost = match cost {
            None => INTERRUPT_COST,
            Some((expr, level)) => match self.evaluate(expr, id, level) {
                Ok(Value::Number(number)) => number,
                _ => return Err(EXPRESSION),
            },
        };
        self.add_parts(&mut needs);
        if let Some(choice) = &mut self.tasks[id].choice {
            choice.refuses = refuses;
            choice.needs = needs;
            choice.interrupt_cost = cost;
            choice.expected = expected;
        }
        Ok(())
    }

    fn way(&mut self, id: usize) -> Result<(Way, Bindings), &'static str> {
        const EXPRESSION: &str = "an expression";
        if let Some((_, list)) = self.own_step(id).and_then(|step| step.forall.as_ref()) {
            return match self.evaluate(list, id, Level::Step) {
                Ok(Value::List(items)) => Ok((Way::Items(items), Bindings::new())),
                Ok(Value::Nil) => Ok((Way::Items(Vec::new()), Bindings::new())),
                _ => Err(EXPRESSION),
            };
        }
        let goal = match self.activity(id) {
            None => vec![Value::word("do-domain")],
            Some(Activity::Goal(words)) => self.filled(words, id, Level::Step).map_err(|_| EXPRESSION)?,
            Some(_) => return Ok((Way::BuiltIn, Bindings::new())),
        };
        self.method(&goal).ok_or("no method")
    }

    /// Returns the most specific match: fewest variables, then longest constant beginning, then written order.
    fn method(&self, goal: &[Value]) -> Option<(Way, Bindings)> {
        let procedures = self.program.procedures.iter().enumerate().map(|(n, each)| (Way::Procedure(n), &each.index));
        let primitives = self.program.primitives.iter().enumerate().map(|(n, each)| (Way::Primitive(n), &each.index));
        let mut found = Vec::new();
        for (way, index) in procedures.chain(primitives) {
            let mut bound = Bindings::new();
            if matches(index, goal, &|_| None, &mut bound) {
                let constant = index.iter().take_while(|term| matches!(term, Term::Is(_))).count();
                found.push(((bound.len(), Reverse(constant)), way, bound));
            }
        }
        let best = found.iter().map(|(key, ..)| *key).min()?;
        found.into_iter().find(|(key, ..)| *key == best).map(|(_, way, bound)| (way, bound))
    }

    fn profile(
        &mut self,
        id: usize,
        level: Level,
        profile: &[Need],
        needs: &mut Vec<(String, f64)>,
    ) -> Result<(), &'static str> {
        for need in profile {
            let name = self.word(&need.resource, id, level).map_err(|_| "an expression")?.to_string();
            let total = self.total(&name);
            add(needs, &name, need.amount.unwrap_or(total));
        }
        Ok(())
    }

    /// Adds the parts of each needed resource, and the parts of these: a task that holds a resource holds all its parts.
    pub(crate) fn add_parts(&mut self, needs: &mut Vec<(String, f64)>) {
        let mut next = 0;
        let mut wholes: Vec<String> = needs.iter().map(|need| need.0.clone()).collect();
        while let Some(whole) = wholes.get(next).cloned() {
            next += 1;
            for part in self.program.resources.iter().filter(|each| each.part_of.as_deref() == Some(&whole)) {
                wholes.push(part.name.clone());
                let total = self.total(&part.name);
                match needs.iter_mut().find(|need| need.0 == part.name) {
                    Some(need) => need.1 = total,
                    None => needs.push((part.name.clone(), total)),
                }
            }
        }
    }

    /// Returns the total of a resource; a resource without declaration has the total 1.
    pub(crate) fn total(&mut self, name: &str) -> f64 {
        *self.totals.entry(name.to_string()).or_insert(1.0)
    }
}
