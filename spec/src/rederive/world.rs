//! The history of a run in the simplest form.

use super::step::Step;
use apex_model::because::Cause;
use apex_model::effect::{Decision, DecisionKind, Effect, Method};
use apex_model::event::{EventKind, Message};
use apex_model::library::{Library, ResourceKind};
use apex_model::procedure::{Primitive, Procedure, Step as Template};
use apex_model::source::Place;
use apex_model::task::{Outcome, TaskId, TaskState};
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
use std::collections::BTreeMap;

/// A task as read from the record.
#[derive(Clone, Debug)]
pub(super) struct Known {
    pub(super) parent: Option<TaskId>,
    pub(super) tag: String,
    pub(super) place: Option<Place>,
    pub(super) made: Cause,
    pub(super) state: TaskState,
    pub(super) created: Time,
    pub(super) since: Time,
    /// Time ongoing before the present period, since the task last began.
    pub(super) worked: Duration,
    pub(super) began: Option<Time>,
    pub(super) moves: Vec<(Time, TaskState, TaskState)>,
    pub(super) outcome: Option<Outcome>,
    pub(super) goal: Option<Value>,
    pub(super) method: Option<Method>,
    pub(super) chosen: Option<Cause>,
}

/// Everything up to the effect under examination.
pub(super) struct World<'a> {
    pub(super) library: &'a Library,
    pub(super) now: Time,
    /// The effect under examination.
    pub(super) index: usize,
    pub(super) tasks: BTreeMap<TaskId, Known>,
    pub(super) samples: BTreeMap<String, Vec<(Time, Value)>>,
    pub(super) messages: Vec<(Time, Value)>,
    pub(super) holders: BTreeMap<String, Vec<(TaskId, f64)>>,
    pub(super) commands: BTreeMap<u64, (TaskId, Time)>,
    pub(super) requests: BTreeMap<u64, Time>,
    pub(super) questions: BTreeMap<u64, (Option<Time>, Option<Value>)>,
    pub(super) plans: Vec<TaskId>,
}

impl<'a> World<'a> {
    pub(super) fn new(library: &'a Library) -> World<'a> {
        World {
            library,
            now: Time::ZERO,
            index: 0,
            tasks: BTreeMap::new(),
            samples: BTreeMap::new(),
            messages: Vec::new(),
            holders: BTreeMap::new(),
            commands: BTreeMap::new(),
            requests: BTreeMap::new(),
            questions: BTreeMap::new(),
            plans: Vec::new(),
        }
    }

    /// Processes a step's inputs, and the agent's messages in the step: a message is seen at its instant.
    pub(super) fn hear(&mut self, step: &Step) {
        self.now = step.batch.now;
        for event in &step.batch.events {
            match &event.kind {
                EventKind::Measurement(variable, value) | EventKind::Told(_, Message::Measurement(variable, value)) => {
                    self.samples.entry(variable.to_string()).or_default().push((event.at, value.clone()));
                }
                EventKind::Occurrence(form) | EventKind::Told(_, Message::Occurrence(form)) => {
                    self.heard(event.at, form);
                }
                _ => {}
            }
        }
        for effect in &step.effects {
            match effect {
                Effect::Inform { form, .. } => self.heard(self.now, form),
                Effect::Publish { variable, value, .. } => {
                    self.published(variable.to_string(), value);
                }
                _ => {}
            }
        }
    }

    /// Adds a sample published by the agent: NaN counts as missing, and at equal instants the later one counts.
    fn published(&mut self, variable: String, value: &Value) {
        if value.as_number().is_some_and(|(number, _)| number.is_nan()) {
            return;
        }
        let known = self.samples.entry(variable).or_default();
        known.retain(|(at, _)| *at != self.now);
        known.push((self.now, value.clone()));
    }

    /// Adds a message; `(ATTRIBUTE OBJECT = VALUE)` is also a measurement.
    fn heard(&mut self, at: Time, form: &Value) {
        if let Some([attribute, object, relation, value]) = form.as_list()
            && relation.as_symbol().is_some_and(|name| name.is("="))
        {
            self.samples.entry(format!("({attribute} {object})")).or_default().push((at, value.clone()));
        }
        self.messages.push((at, form.clone()));
    }

    pub(super) fn task(&self, id: TaskId) -> Result<&Known, String> {
        self.tasks.get(&id).ok_or_else(|| format!("{id} was never created"))
    }

    /// Adds the consequences of an effect.
    pub(super) fn take(&mut self, index: usize, effect: &Effect) {
        self.index = index + 1;
        match effect {
            Effect::Decided(decision) => self.decided(decision),
            Effect::Command { command, task, .. } => {
                self.commands.insert(command.0, (*task, self.now));
            }
            Effect::Solve(request) => {
                self.requests.insert(request.request.0, self.now);
            }
            Effect::Ask { question, by, default, .. } => {
                self.questions.insert(question.0, (*by, default.clone()));
            }
            _ => {}
        }
    }

    fn decided(&mut self, decision: &Decision) {
        let Some(id) = decision.task else { return };
        let cause = &decision.because.cause;
        match &decision.kind {
            DecisionKind::Created { parent, tag, place, .. } => {
                let known = Known {
                    parent: *parent,
                    tag: tag.to_string(),
                    place: *place,
                    made: cause.clone(),
                    state: TaskState::Pending,
                    created: self.now,
                    since: self.now,
                    worked: Duration::ZERO,
                    began: None,
                    moves: Vec::new(),
                    outcome: None,
                    goal: None,
                    method: None,
                    chosen: None,
                };
                self.tasks.insert(id, known);
            }
            DecisionKind::Transition { from, to, outcome } => {
                self.moved(id, *from, *to, outcome.clone());
                if let Cause::ResourcesGranted { resources } = cause {
                    for share in resources {
                        let name = share.resource.to_string();
                        let amount = share.amount.as_ref().and_then(Value::as_number).map(|(number, _)| number);
                        let amount = amount.unwrap_or_else(|| self.total(&name));
                        self.holders.entry(name).or_default().push((id, amount));
                    }
                }
            }
            DecisionKind::Selected { method, goal, .. } => {
                if let Some(task) = self.tasks.get_mut(&id) {
                    (task.goal, task.method) = (Some(goal.clone()), Some(method.clone()));
                    task.chosen = Some(cause.clone());
                }
            }
            DecisionKind::ProcedureAdded { .. } => self.plans.push(id),
            _ => {}
        }
    }

    fn moved(&mut self, id: TaskId, from: TaskState, to: TaskState, outcome: Option<Outcome>) {
        let now = self.now;
        let Some(task) = self.tasks.get_mut(&id) else { return };
        if from == TaskState::Ongoing {
            task.worked = task.worked + (now - task.since);
            let parent = task.parent;
            // Resources granted to `(hold-resource ..)` belong to its procedure from now on.
            let handed = task.goal.as_ref().is_some_and(|goal| goal.to_string().starts_with("(hold-resource"));
            for holders in self.holders.values_mut() {
                match parent.filter(|_| handed && to == TaskState::Terminated) {
                    Some(parent) => holders.iter_mut().filter(|each| each.0 == id).for_each(|each| each.0 = parent),
                    None => holders.retain(|each| each.0 != id),
                }
            }
        }
        if to == TaskState::Terminated {
            self.let_go(id);
        }
        let Some(task) = self.tasks.get_mut(&id) else { return };
        match to {
            TaskState::Pending => {
                (task.created, task.worked, task.began) = (now, Duration::ZERO, None);
            }
            TaskState::Ongoing => {
                task.began.get_or_insert(now);
            }
            TaskState::Enabled | TaskState::Interrupted | TaskState::Terminated => {}
        }
        task.moves.push((now, from, to));
        (task.state, task.since, task.outcome) = (to, now, outcome);
    }

    /// `(release-resource R..)`: takes from its procedure the resources handed to it.
    fn let_go(&mut self, id: TaskId) {
        let Some(task) = self.tasks.get(&id) else { return };
        let Some([Value::Symbol(word), names @ ..]) = task.goal.as_ref().and_then(Value::as_list) else { return };
        if word.is("release-resource") {
            for name in names {
                let holders = self.holders.entry(name.to_string()).or_default();
                holders.retain(|each| Some(each.0) != task.parent);
            }
        }
    }

    /// Returns the total of a resource when no task holds a share.
    pub(super) fn total(&self, name: &str) -> f64 {
        let declared = self.library.resources.iter().find(|(known, _)| known.printed().eq_ignore_ascii_case(name));
        match declared.map(|(_, resource)| &resource.kind) {
            Some(ResourceKind::Capacity(units)) => *units as f64,
            Some(ResourceKind::Depletable(_) | ResourceKind::Renewable(_)) => f64::INFINITY,
            Some(ResourceKind::Unitary) | None => 1.0,
        }
    }

    /// Returns true if `above` is an ancestor of `below`, or the same task.
    pub(super) fn is_above(&self, above: TaskId, below: TaskId) -> bool {
        let mut next = Some(below);
        while let Some(id) = next {
            if id == above {
                return true;
            }
            next = self.tasks.get(&id).and_then(|task| task.parent);
        }
        false
    }

    /// Returns the step that a task was made from, with its procedure; steps of plans are not in the library.
    pub(super) fn template(&self, task: &Known) -> Option<(&Procedure, usize, &Template)> {
        let place = task.place?;
        if matches!(task.made, Cause::HandlesFailure { .. } | Cause::ItemOf { .. } | Cause::Meanwhile { .. }) {
            return None;
        }
        self.library.procedures.iter().find_map(|procedure| {
            let index =
                procedure.steps.iter().position(|step| step.place == place && step.tag.printed() == task.tag)?;
            Some((procedure.as_ref(), index, procedure.steps.get(index)?))
        })
    }

    /// Returns the primitive that a task was given.
    pub(super) fn primitive(&self, task: &Known) -> Option<&Primitive> {
        let Some(Method::Primitive(place)) = task.method else { return None };
        self.library.primitives.iter().find(|primitive| primitive.place == place).map(|primitive| primitive.as_ref())
    }

    /// Returns the children that the record contains.
    pub(super) fn children(&self, id: TaskId) -> impl Iterator<Item = (TaskId, &Known)> {
        self.tasks.iter().filter(move |(_, task)| task.parent == Some(id)).map(|(id, task)| (*id, task))
    }
}
