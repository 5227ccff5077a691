//! Random steps with their clauses.

use crate::generate::{Argument, Goal, Maker, number, word};
use crate::rng::TestRng;
use apex_reference::Value;
use apex_reference::program::{
    Activity, Clauses, Condition, Expr, Kind, Need, Priority, Relation, Repetition, SECOND, Step, Term,
};

/// The surroundings to which a step can refer.
struct Around<'a> {
    tags: &'a [String],
    own: usize,
    about: Option<&'a str>,
    /// Variables that other steps bind by `=>`.
    results: &'a [String],
}

pub(crate) fn small_number(rng: &mut TestRng) -> Expr {
    let number = rng.pick(&[0.0, 0.05, 0.1, 0.2, 1.0, 1.0, 2.0, 3.0, 5.0]).unwrap_or(0.0);
    Expr::Is(Value::Number(number))
}

impl Maker<'_> {
    pub(crate) fn steps(&mut self, kind: Kind, about: Option<&str>, is_root: bool) -> Vec<Step> {
        let count = if is_root { self.rng.between(2, 6) } else { self.rng.between(1, 4) };
        let tags: Vec<String> = (0..count).map(|number| format!("s{number}")).collect();
        let mut results: Vec<String> = Vec::new();
        let mut steps = Vec::new();
        for own in 0..count {
            let step = self.step(&Around { tags: &tags, own, about, results: &results });
            results.extend(step.binds.clone());
            steps.push(step);
        }
        if self.rng.chance(self.taste.crowds) {
            steps.extend(self.crowd());
        }
        if kind == Kind::Concurrent && self.rng.chance(25) {
            let tags: Vec<String> = tags.clone();
            let mut last = Step::plain("stop", Activity::Terminate { tag: None, outcome: None, value: None });
            last.activity = self.end_of_procedure();
            let around = Around { tags: &tags, own: count, about, results: &results };
            let mut bound = Vec::new();
            last.waitfor = vec![self.condition(&around, &mut bound, 1)];
            steps.push(last);
        }
        steps
    }

    /// Returns many steps that need the same resource at once and state their durations.
    fn crowd(&mut self) -> Vec<Step> {
        let lasting: Vec<Goal> = self.primitives.iter().filter(|goal| goal.lasts).cloned().collect();
        let Some(goal) = self.rng.pick(&lasting) else { return Vec::new() };
        let urgent = self.rng.chance(30);
        let mut steps = Vec::new();
        for number in 0..self.rng.between(3, 8) {
            let activity = self.phrase(&goal, &[]);
            let mut step = Step::plain(&format!("c{number}"), activity);
            step.profile = self.profile(true);
            if urgent {
                let [urgency, importance] = [self.rng.between(6, 8) as f64, self.rng.between(1, 3) as f64];
                step.priority.push(Priority::Urgency(urgency, importance));
            } else if self.rng.chance(self.taste.priorities / 2) {
                step.priority.push(Priority::Number(small_number(self.rng)));
            }
            steps.push(step);
        }
        steps
    }

    fn end_of_procedure(&mut self) -> Activity {
        let failure = self.rng.chance(self.taste.failures);
        let value = (!failure && self.rng.chance(self.taste.values)).then(|| Expr::Is(Value::Word("b".into())));
        Activity::Terminate { tag: None, outcome: failure.then(|| "failure".into()), value }
    }

    fn step(&mut self, around: &Around<'_>) -> Step {
        let tag = around.tags.get(around.own).cloned().unwrap_or_default();
        let mut step = Step::plain(&tag, Activity::EndApplication);
        let mut bound: Vec<String> = around.about.map(ToString::to_string).into_iter().collect();
        if self.rng.chance(self.taste.waitfor) {
            step.waitfor.push(self.condition(around, &mut bound, 2));
            if self.rng.chance(15) {
                step.waitfor.push(self.condition(around, &mut bound, 1));
            }
        }
        let goal = self.activity(around, &mut step, &bound);
        self.importance(around, &mut step);
        self.repetition(goal.as_ref(), &mut step, &bound);
        if step.repetition.as_ref().is_none_or(|clause| !clause.responding)
            && goal.as_ref().is_some_and(|goal| goal.returns)
        {
            step.binds = self.rng.maybe(self.taste.values, |_| format!("z{}", around.own));
        }
        if goal.is_some() && self.rng.chance(self.taste.resources / 5) {
            step.profile = vec![Need { resource: word("r3"), amount: None, refuse_if_busy: false }];
        }
        step.hooks = self.hooks(None);
        if self.rng.chance(60) {
            step.clauses = self.clauses(around.tags, around.about, false);
        }
        if self.rng.chance(self.taste.failures) {
            step.on_failure = Some(self.handler());
        }
        step
    }

    fn handler(&mut self) -> Activity {
        match self.goal_among(false) {
            Some(goal) if goal.argument != Argument::Word && self.rng.chance(70) => self.phrase(&goal, &[]),
            _ => Activity::Inform(self.message(None)),
        }
    }

    fn goal_among(&mut self, nested: bool) -> Option<Goal> {
        if nested { self.rng.pick(&self.procedures.clone()) } else { self.rng.pick(&self.primitives.clone()) }
    }

    fn phrase(&mut self, goal: &Goal, variables: &[String]) -> Activity {
        let mut words = vec![word(&goal.head)];
        match goal.argument {
            Argument::None => {}
            Argument::Span => words.push(Term::Is(Value::Span(self.span()))),
            Argument::Word => words.push(match variables.last() {
                Some(name) if self.rng.chance(60) => Term::Variable(name.clone()),
                _ => word("a"),
            }),
        }
        Activity::Goal(words)
    }

    /// Sets the step's activity; returns its goal if the activity is one.
    fn activity(&mut self, around: &Around<'_>, step: &mut Step, bound: &[String]) -> Option<Goal> {
        if self.rng.chance(self.taste.built_ins) {
            step.activity = self.built_in(around);
            return None;
        }
        if self.rng.chance(self.taste.hold / 2) {
            let names = ["r1", "r2"];
            let name = self.rng.pick(&names).unwrap_or("r1").to_string();
            step.activity = if self.rng.chance(60) { Activity::Hold(name) } else { Activity::Release(name) };
            return None;
        }
        if self.rng.chance(self.taste.values) && !around.results.is_empty() {
            let result = self.rng.pick(around.results).unwrap_or_default();
            step.activity = Activity::Inform(vec![word("e1"), Term::Variable(result)]);
            return None;
        }
        let nested = !self.procedures.is_empty() && self.rng.chance(self.taste.nesting);
        let goal = self.goal_among(nested)?;
        let mut variables = bound.to_vec();
        if goal.argument == Argument::Word && self.rng.chance(self.taste.forall) {
            let words = ["a", "b", "c"];
            let items = words.into_iter().take(self.rng.below(4)).map(|word| Value::Word(word.into()));
            let items: Vec<Value> = items.collect();
            let list = if items.is_empty() { Expr::Is(Value::Nil) } else { Expr::Is(Value::List(items)) };
            step.forall = Some(("i".into(), list));
            variables.push("i".into());
        } else if goal.argument == Argument::Word && self.rng.chance(self.taste.values.max(self.taste.failures)) {
            let word = self.rng.pick(&["a", "a", "b", "c"]).unwrap_or("a");
            step.select.push(("k".into(), Expr::Is(Value::Word(word.into()))));
            variables.push("k".into());
        }
        step.activity = self.phrase(&goal, &variables);
        if goal.argument == Argument::Word && self.rng.chance(self.taste.failures / 5) {
            step.select.push(("bad".into(), number(7)));
            step.select.push(("worse".into(), Expr::First(Box::new(Expr::Variable("bad".into())))));
        }
        Some(goal)
    }

    fn built_in(&mut self, around: &Around<'_>) -> Activity {
        let others: Vec<&String> = around.tags.iter().filter(|tag| around.tags.get(around.own) != Some(*tag)).collect();
        let other = self.rng.pick(&others).cloned();
        match (self.rng.below(10), other) {
            (0 | 1, Some(tag)) => {
                let outcome = self.rng.pick(&[None, Some("success"), Some("failure"), Some("cut")]).flatten();
                let value = self.rng.maybe(self.taste.values, |_| Expr::Is(Value::Word("b".into())));
                let value = value.filter(|_| outcome.is_none_or(|outcome| outcome == "success"));
                Activity::Terminate { tag: Some(tag.clone()), outcome: outcome.map(Into::into), value }
            }
            (2, Some(tag)) => Activity::Reset(tag.clone()),
            (3 | 4, Some(tag)) => Activity::Suspend(tag.clone()),
            (5, Some(tag)) => Activity::Resume(tag.clone()),
            (6, Some(tag)) => Activity::Reprioritize(tag.clone()),
            (7, _) => Activity::Cogevent(self.message(around.about)),
            (8, _) if self.rng.chance(10) => Activity::EndApplication,
            (8, _) => Activity::Print(number(self.rng.below(9))),
            _ => Activity::Inform(self.message(around.about)),
        }
    }

    fn importance(&mut self, around: &Around<'_>, step: &mut Step) {
        if self.rng.chance(self.taste.priorities) {
            let priority = match self.rng.below(5) {
                0 => Expr::If(
                    Box::new(Expr::Current("x".into(), "v".into())),
                    Box::new(Expr::Current("x".into(), "v".into())),
                    Box::new(number(1)),
                ),
                1 => Expr::Sum(Box::new(small_number(self.rng)), Box::new(number(1))),
                _ => small_number(self.rng),
            };
            step.priority.push(Priority::Number(priority));
        }
        if self.rng.chance(self.taste.urgency) {
            let urgency = self.rng.between(5, 8) as f64;
            let importance = self.rng.between(1, 9) as f64;
            step.priority.push(Priority::Urgency(urgency, importance));
        }
        if self.rng.chance(self.taste.ranks) {
            step.rank = Some(number(self.rng.between(1, around.tags.len().max(2))));
        }
        if self.rng.chance(self.taste.costs) {
            step.interrupt_cost = Some(small_number(self.rng));
        }
    }

    fn repetition(&mut self, goal: Option<&Goal>, step: &mut Step, bound: &[String]) {
        let heard = step.waitfor.iter().any(|condition| matches!(condition, Condition::Event(_)));
        if heard && self.rng.chance(self.taste.responding) {
            let mut clause = Repetition { responding: true, ..Repetition::default() };
            clause.for_new = self.for_new(bound);
            self.limits(&mut clause);
            step.repetition = Some(clause);
            return;
        }
        let lasts = goal.is_some_and(|goal| goal.lasts) || heard;
        if lasts && self.rng.chance(self.taste.repeating) {
            let mut clause = Repetition::default();
            self.limits(&mut clause);
            clause.enabled = goal.is_some_and(|goal| goal.lasts) && self.rng.chance(15);
            if !step.priority.is_empty() && self.rng.chance(20) {
                clause.recovery = Some(self.span());
            }
            if self.rng.chance(30) {
                clause.minimum_interval = Some(self.span());
            }
            if heard && self.rng.chance(30) {
                clause.for_new = self.for_new(bound);
            }
            clause.drop_missed = heard && self.rng.chance(25);
            step.repetition = Some(clause);
        }
    }

    fn for_new(&mut self, bound: &[String]) -> Vec<String> {
        let fresh: Vec<String> = bound.iter().filter(|name| name.starts_with('n')).take(1).cloned().collect();
        if self.rng.chance(50) { fresh } else { Vec::new() }
    }

    fn limits(&mut self, clause: &mut Repetition) {
        let limit = Expr::Is(Value::Span(self.rng.between(2, 12) as i64 * SECOND));
        let before = |relation| Expr::Compare(relation, Box::new(Expr::MissionTime), Box::new(limit.clone()));
        match self.rng.below(4) {
            0 => clause.while_true = Some(before(Relation::Less)),
            1 => clause.until = Some(before(Relation::AtLeast)),
            _ => {}
        }
    }

    pub(crate) fn clauses(&mut self, tags: &[String], about: Option<&str>, own: bool) -> Clauses {
        let percent = self.taste.clauses;
        let around = Around { tags: if own { tags } else { &[] }, own: tags.len(), about, results: &[] };
        let mut bound = Vec::new();
        let mut some = |maker: &mut Self| {
            let wanted = maker.rng.chance(percent);
            wanted.then(|| maker.clause_condition(&around, &mut bound))
        };
        let end_when = some(self);
        let restart_when = some(self);
        let suspend_when = some(self).map(|when| (when, self.clause_condition(&around, &mut Vec::new())));
        let resume_when = some(self);
        let mut clauses = Clauses { end_when, restart_when, suspend_when, resume_when, ..Clauses::default() };
        let execution = self.taste.execution;
        if self.rng.chance(execution / 2) {
            clauses.exit_when = Some(self.clause_condition(&around, &mut Vec::new()));
        }
        if !own && self.rng.chance(execution) {
            clauses.skip_when = Some(self.clause_condition(&around, &mut Vec::new()));
        }
        if self.rng.chance(execution) {
            clauses.precondition = Some(self.state_of_things(&around, 1));
        }
        if self.rng.chance(execution) {
            clauses.invariant = Some(self.state_of_things(&around, 1));
        }
        clauses
    }

    /// Returns a condition that holds or not at an instant.
    fn state_of_things(&mut self, around: &Around<'_>, depth: usize) -> Condition {
        if depth > 0 && self.rng.chance(40) {
            let first = self.state_of_things(around, depth - 1);
            let second = self.state_of_things(around, depth - 1);
            return match self.rng.below(3) {
                0 => Condition::And(vec![first, second]),
                1 => Condition::Or(vec![first, second]),
                _ => Condition::Not(Box::new(first)),
            };
        }
        let others: Vec<String> =
            around.tags.iter().filter(|tag| around.tags.get(around.own) != Some(*tag)).cloned().collect();
        match self.rng.pick(&others) {
            Some(tag) if self.rng.chance(40) => {
                let words = ["pending", "ongoing", "interrupted", "terminated", "failed", "succeeded"];
                Condition::State(Some(tag), self.rng.pick(&words).unwrap_or("ongoing").into())
            }
            _ => self.measurement(),
        }
    }

    /// Returns a condition of a clause that moves a task.
    fn clause_condition(&mut self, around: &Around<'_>, bound: &mut Vec<String>) -> Condition {
        match self.rng.below(8) {
            0 if self.rng.chance(self.taste.task_conditions) => Condition::State(None, "resumed".into()),
            1 if self.rng.chance(self.taste.delays) => Condition::Delay(self.span(), None),
            _ => self.simple(around, bound),
        }
    }

    fn condition(&mut self, around: &Around<'_>, bound: &mut Vec<String>, depth: usize) -> Condition {
        if depth > 0 && self.rng.chance(self.taste.composites) {
            let first = self.condition(around, bound, depth - 1);
            let second = self.condition(around, bound, depth - 1);
            return match self.rng.below(6) {
                0 | 1 => Condition::And(vec![first, second]),
                2 => {
                    bound.retain(|name| Some(name.as_str()) == around.about);
                    Condition::Or(vec![first, second])
                }
                3 => {
                    let against = self.simple(around, &mut Vec::new());
                    Condition::And(vec![first, Condition::Not(Box::new(against))])
                }
                4 if self.rng.chance(self.taste.delays * 2) => {
                    let least = self.span();
                    let most = self.rng.maybe(50, |rng| least + rng.between(1, 6) as i64 * SECOND);
                    Condition::InOrder(vec![first, Condition::Delay(least, most), second])
                }
                _ => Condition::InOrder(vec![first, second]),
            };
        }
        if self.rng.chance(self.taste.delays / 2) {
            return Condition::Delay(self.span(), None);
        }
        self.simple(around, bound)
    }

    fn simple(&mut self, around: &Around<'_>, bound: &mut Vec<String>) -> Condition {
        // Mostly earlier steps, because steps that wait for each other in a circle are rejected.
        let before = if self.rng.chance(85) { around.own } else { around.tags.len() };
        let tags = around.tags.iter().take(before);
        let others: Vec<String> = tags.filter(|tag| around.tags.get(around.own) != Some(*tag)).cloned().collect();
        if self.rng.chance(self.taste.measurements) {
            return self.measurement();
        }
        if let Some(tag) = self.rng.pick(&others)
            && self.rng.chance(self.taste.task_conditions.max(15))
        {
            if self.rng.chance(self.taste.outcomes) {
                let words = ["succeeded", "failed", "failed", "skipped", "exited", "cut", "invariant-violated"];
                let word = self.rng.pick(&words).unwrap_or("failed");
                return Condition::State(Some(tag), word.into());
            }
            if self.rng.chance(60) {
                return Condition::Ended(tag);
            }
            let words = ["enabled", "ongoing", "interrupted", "terminated", "resumed"];
            let word = self.rng.pick(&words).unwrap_or("ongoing");
            return Condition::State(Some(tag), word.into());
        }
        let fresh = format!("n{}", bound.len());
        self.event(around.about, bound, &fresh)
    }
}
