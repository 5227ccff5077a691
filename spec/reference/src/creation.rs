//! The creation of tasks, and the watches with which they begin.

use crate::agent::Agent;
use crate::program::{Activity, Condition, Expr, Kind, Program, Step, Term};
use crate::task::{Clause, Level, Origin, State, Task, Watch, Window, Work};
use crate::trace::What;
use crate::value::Bindings;
use std::collections::BTreeSet;

/// Returns the program in which every sequential procedure without a stated end gets a final step that terminates it.
pub(crate) fn with_ends(program: &Program) -> Program {
    let mut program = program.clone();
    let ends = |step: &Step| matches!(step.activity, Activity::Terminate { tag: None, .. });
    for procedure in program.procedures.iter_mut().filter(|procedure| procedure.kind == Kind::Sequential) {
        if !procedure.steps.iter().any(ends) {
            let activity = Activity::Terminate { tag: None, outcome: None, value: None };
            procedure.steps.push(Step::plain("terminate", activity));
        }
    }
    program
}

impl<'p> Agent<'p> {
    /// Returns the steps of a procedure.
    pub(crate) fn steps(&self, procedure: usize) -> &'p [Step] {
        &self.program.procedures[procedure].steps
    }

    /// Returns the step that a task was made from.
    pub(crate) fn step_of(&self, id: usize) -> Option<&'p Step> {
        match self.tasks[id].origin {
            Origin::Root => None,
            Origin::Step(procedure, step) | Origin::Item(procedure, step) | Origin::Handler(procedure, step) => {
                self.steps(procedure).get(step)
            }
        }
    }

    /// Returns the step, for a task that carries its clauses: items and handlers have none.
    pub(crate) fn own_step(&self, id: usize) -> Option<&'p Step> {
        matches!(self.tasks[id].origin, Origin::Step(..)).then(|| self.step_of(id)).flatten()
    }

    /// Makes a pending task.
    pub(crate) fn create(&mut self, parent: Option<usize>, origin: Origin) -> usize {
        let id = self.tasks.len();
        self.tasks.push(Task::new(parent, origin, self.now));
        let tag = self.step_of(id).map_or("root".to_string(), |step| step.tag.clone());
        self.tell(id, What::Created(parent, tag));
        self.changed = true;
        id
    }

    /// Creates all tasks of a procedure before the first one watches anything, because tags may refer to later steps.
    pub(crate) fn create_steps(&mut self, parent: usize, procedure: usize) {
        let kind = self.program.procedures[procedure].kind;
        let count = self.steps(procedure).len();
        for step in 0..count {
            let child = self.create(Some(parent), Origin::Step(procedure, step));
            self.tasks[child].waits_for_step_before = kind == Kind::Sequential && step > 0;
            self.adopt(parent, child, Some(step));
        }
        let Some(Work::Procedure { children, .. }) = &self.tasks[parent].work else { return };
        for child in children.clone() {
            self.arm(child);
        }
        self.complete_when_done(parent);
    }

    /// Makes `child` a child of the procedure that `parent` runs, and the task that the tag of `step` names.
    pub(crate) fn adopt(&mut self, parent: usize, child: usize, step: Option<usize>) {
        if let Some(Work::Procedure { children, current, .. }) = &mut self.tasks[parent].work {
            children.insert(child);
            if let Some(step) = step {
                current[step] = Some(child);
                self.tasks[child].tagged = self.moves.len();
            }
        }
    }

    /// Starts the watches of a pending task.
    pub(crate) fn arm(&mut self, id: usize) {
        self.changed = true;
        let Some(step) = self.own_step(id) else { return };
        let clauses = &step.clauses;
        let ends = [
            (Clause::EndWhen, &clauses.end_when),
            (Clause::ExitWhen, &clauses.exit_when),
            (Clause::SkipWhen, &clauses.skip_when),
        ];
        for (clause, condition) in ends {
            if let Some(condition) = condition {
                self.watch(id, clause, Level::Step, condition, self.window(id));
            }
        }
        self.tasks[id].waits_for_result = self.awaited(id).is_some();
        self.watch_waitfor(id);
        self.watch_step_suspension(id);
    }

    pub(crate) fn watch_waitfor(&mut self, id: usize) {
        let Some(step) = self.own_step(id) else { return };
        let condition = match step.waitfor.as_slice() {
            [] => return,
            [one] => one.clone(),
            several => Condition::And(several.to_vec()),
        };
        self.tasks[id].waits_for_condition = true;
        self.watch(id, Clause::Waitfor, Level::Step, &condition, self.window(id));
    }

    /// Returns the window of the task's present instance.
    pub(crate) fn window(&self, id: usize) -> Window {
        Window { start: self.tasks[id].created_at, after: self.tasks[id].answered }
    }

    pub(crate) fn watch(&mut self, id: usize, clause: Clause, level: Level, condition: &Condition, window: Window) {
        let number = self.next_serial();
        let made = self.moves.len();
        // For work that begins in a state that would restart it, that state does not count as having begun before.
        let standing = clause != Clause::RestartWhen;
        let condition = condition.clone();
        let watch =
            Watch { number, clause, level, condition, window, made, made_at: self.now, standing, at_once: false };
        self.tasks[id].watches.push(watch);
        self.changed = true;
    }

    pub(crate) fn unwatch(&mut self, id: usize, unwanted: impl Fn(Clause, Level) -> bool) {
        self.tasks[id].watches.retain(|watch| !unwanted(watch.clause, watch.level));
    }

    /// Returns true if the step uses the result `name` of another step.
    pub(crate) fn uses(&self, id: usize, name: &str) -> bool {
        self.wanted(id).iter().any(|each| each == name)
    }

    /// Returns the first result of another step that the task needs and that is not there yet.
    pub(crate) fn awaited(&self, id: usize) -> Option<String> {
        let bound: &Bindings = &self.tasks[id].bound;
        let mut missing = self.wanted(id).into_iter();
        missing.find(|name| !bound.contains_key(name) && self.variable(id, Level::Step, name).is_none())
    }

    /// Results of other steps that the task needs.
    fn wanted(&self, id: usize) -> Vec<String> {
        let Origin::Step(procedure, number) = self.tasks[id].origin else { return Vec::new() };
        let steps = self.steps(procedure);
        let step = &steps[number];
        let sequential = self.program.procedures[procedure].kind == Kind::Sequential;
        let produced = |name: &String| {
            let mut others = steps.iter().enumerate();
            others.any(|(other, step)| {
                step.binds.as_ref() == Some(name) && other != number && (!sequential || other < number)
            })
        };
        let own: BTreeSet<&String> = step.select.iter().chain(&step.forall).map(|(name, _)| name).collect();
        used(step).into_iter().filter(|name| !own.contains(name) && produced(name)).collect()
    }

    /// Forgets a task, so that no clause refers to it any longer.
    pub(crate) fn forget(&mut self, id: usize) {
        self.tasks[id].forgotten = true;
        self.tasks[id].watches.clear();
        if self.tasks[id].state != State::Terminated {
            self.tasks[id].state = State::Terminated;
        }
    }
}

/// Variables that waitfor, activity, select and forall of a step mention.
fn used(step: &Step) -> Vec<String> {
    let mut names = Vec::new();
    step.waitfor.iter().for_each(|condition| in_condition(condition, &mut names));
    match &step.activity {
        Activity::Goal(words) | Activity::Inform(words) | Activity::Cogevent(words) => in_phrase(words, &mut names),
        Activity::Print(expr) | Activity::Terminate { value: Some(expr), .. } => in_expression(expr, &mut names),
        _ => {}
    }
    step.select.iter().chain(&step.forall).for_each(|(_, expr)| in_expression(expr, &mut names));
    names
}

fn in_phrase(words: &[Term], names: &mut Vec<String>) {
    names.extend(words.iter().filter_map(|word| match word {
        Term::Variable(name) => Some(name.clone()),
        _ => None,
    }));
}

/// Variables that a condition mentions, other than tags.
pub(crate) fn in_condition(condition: &Condition, names: &mut Vec<String>) {
    match condition {
        Condition::Event(words) => in_phrase(words, names),
        Condition::Measurement(_, object, ..) => in_phrase(std::slice::from_ref(object), names),
        Condition::Sample(_, object, value) => {
            in_phrase(std::slice::from_ref(object), names);
            names.push(value.clone());
        }
        Condition::And(parts) | Condition::Or(parts) | Condition::InOrder(parts) => {
            parts.iter().for_each(|part| in_condition(part, names));
        }
        Condition::Not(part) => in_condition(part, names),
        Condition::Ended(_) | Condition::State(..) | Condition::Delay(..) => {}
    }
}

fn in_expression(expr: &Expr, names: &mut Vec<String>) {
    match expr {
        Expr::Variable(name) => names.push(name.clone()),
        Expr::Sum(a, b) | Expr::Difference(a, b) | Expr::Compare(_, a, b) => {
            in_expression(a, names);
            in_expression(b, names);
        }
        Expr::If(a, b, c) => [a, b, c].into_iter().for_each(|expr| in_expression(expr, names)),
        Expr::First(a) => in_expression(a, names),
        Expr::Is(_) | Expr::Current(..) | Expr::MissionTime | Expr::StateOf(_) => {}
    }
}
