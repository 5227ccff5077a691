//! Second derivation of the causes of creation, enablement, selection, grants, rejections and interruptions of tasks.

use super::evidence::{self, ends_in, moves};
use super::require::require;
use super::step::Step;
use super::violations;
use super::world::{Known, World};
use super::{ends, probing};
use apex_model::because::{Because, Cause, ConflictRule, Share, Strength};
use apex_model::effect::{Decision, DecisionKind, Effect, Method};
use apex_model::task::{Outcome, TaskId, TaskState};
use apex_model::value::Value;

type Checked = Result<(), String>;

/// Checks the cause of this effect.
pub(super) fn check(world: &World<'_>, step: &Step, index: usize, effect: &Effect, because: &Because) -> Checked {
    let decision = match effect {
        Effect::Command { task, .. } => return of_command(world, *task, because),
        Effect::Decided(decision) => decision,
        _ => return Ok(()),
    };
    let Some(id) = decision.task else { return ends::of_nobody(world, step, because) };
    match because.cause {
        Cause::ConditionViolated { .. } => violations::check(world, step, id, because)?,
        _ => evidence::check(world, step, id, because)?,
    }
    let scene = Scene { world, step, index, id, because };
    match &decision.kind {
        DecisionKind::Created { parent, .. } => scene.created(*parent),
        DecisionKind::Transition { from, to, outcome } => scene.moved(*from, *to, outcome.as_ref()),
        DecisionKind::Satisfied { clause, interval } => scene.satisfied(clause, *interval),
        DecisionKind::Bound { variable, value } => scene.bound(variable.printed(), value),
        DecisionKind::Selected { method, goal, alternatives } => scene.selected(method, goal, alternatives.len()),
        DecisionKind::Refused { resource, winner } => scene.refused(resource, *winner),
        DecisionKind::ProcedureAdded { request, .. } => match &because.cause {
            Cause::PlanArrived { request: stated, .. } if stated == request => ends::plan_arrived(step, &because.cause),
            other => Err(format!("{} is no reason for a plan", other.kind())),
        },
        DecisionKind::Trouble { .. } => ends::trouble(&scene),
    }
}

/// A decision with its task, its step and its position in the step.
pub(super) struct Scene<'a> {
    pub(super) world: &'a World<'a>,
    pub(super) step: &'a Step,
    pub(super) index: usize,
    pub(super) id: TaskId,
    pub(super) because: &'a Because,
}

fn of_command(world: &World<'_>, task: TaskId, because: &Because) -> Checked {
    let known = world.task(task)?;
    let place = because.place.ok_or("it names no place")?;
    require(world.library.sources.get(place.file as usize).is_some(), "its place is in no file")?;
    match &because.cause {
        Cause::FormRan { clause } => {
            let line = world
                .library
                .sources
                .get(place.file as usize)
                .and_then(|source| source.text.lines().nth(place.line as usize - 1));
            require(line.is_some_and(|line| line.contains('(')), "no form is at its place")?;
            let text =
                world.library.sources.iter().any(|source| source.text.contains(&**clause) || clause == "on-start");
            require(text, "no such clause is written")?;
            require(known.began.is_some(), "its task never began")
        }
        Cause::SentAgain => {
            let resumed = known.moves.last() == Some(&(world.now, TaskState::Interrupted, TaskState::Ongoing));
            require(resumed, "its task was not resumed now")
        }
        other => Err(format!("{} is no reason for a command", other.kind())),
    }
}

impl Scene<'_> {
    pub(super) fn own(&self) -> Result<&Known, String> {
        self.world.task(self.id)
    }

    /// Returns the decisions about `task` in this step up to this one.
    pub(super) fn earlier(&self, task: TaskId) -> impl Iterator<Item = &Decision> {
        self.step.effects.iter().take(self.index).filter_map(move |effect| match effect {
            Effect::Decided(decision) if decision.task == Some(task) => Some(decision),
            _ => None,
        })
    }

    /// Returns true if `task` moves to `state` in this step.
    pub(super) fn moves_now(&self, task: TaskId, state: TaskState) -> bool {
        self.step.effects.iter().any(|effect| moves(effect, task) == Some(state))
    }

    fn created(&self, parent: Option<TaskId>) -> Checked {
        let world = self.world;
        let same = |stated: &TaskId| require(parent == Some(*stated), "it names another parent");
        let works = |id: &TaskId| require(world.task(*id)?.state == TaskState::Ongoing, "the parent is not ongoing");
        match &self.because.cause {
            Cause::InitialTask => require(parent.is_none() && world.tasks.is_empty(), "it is not the first task"),
            Cause::ParentStarted { parent } | Cause::ItemOf { parent } => {
                same(parent)?;
                works(parent)?;
                let known = world.task(*parent)?;
                require(known.since == world.now, "the parent started at another instant")?;
                let items = matches!(known.chosen, Some(Cause::ForAll { .. }));
                let item = matches!(self.because.cause, Cause::ItemOf { .. });
                require(items == item, "the parent's work is of another kind")
            }
            Cause::PlanPursued { parent } => {
                same(parent)?;
                works(parent)?;
                require(world.plans.contains(parent), "no plan arrived for the parent")
            }
            Cause::PlanBegunAgain { parent } => {
                same(parent)?;
                let other = world
                    .children(*parent)
                    .any(|(_, child)| child.since == world.now && child.state == TaskState::Terminated);
                require(other, "nothing of the plan ended now")
            }
            Cause::Meanwhile { parent } => {
                same(parent)?;
                works(parent)?;
                let asks = self
                    .step
                    .effects
                    .iter()
                    .any(|effect| matches!(effect, Effect::Solve(request) if request.task == *parent));
                require(asks, "the parent asks for no plan now")
            }
            Cause::Probes { waiting, number, limit } => probing::probes(self, parent, (*waiting, *number, *limit)),
            Cause::HandlesFailure { of } => {
                same(of)?;
                let failed = self.earlier(*of).any(|decision| matches!(decision.kind, DecisionKind::Trouble { .. }));
                require(failed, "the parent had no error now")
            }
            Cause::Responding { answered } => {
                let known = world.task(*answered)?;
                require(known.parent == parent, "that task has another parent")?;
                require(self.moves_now(*answered, TaskState::Enabled), "that task was not enabled now")
            }
            other => Err(format!("{} is no reason for a task to be created", other.kind())),
        }
    }

    fn moved(&self, from: TaskState, to: TaskState, outcome: Option<&Outcome>) -> Checked {
        let own = self.own()?;
        require(own.state == from, "the task was in another state")?;
        match (from, to) {
            (TaskState::Pending, TaskState::Enabled) => self.enabled(own),
            (TaskState::Terminated, TaskState::Pending) => {
                require(matches!(self.because.cause, Cause::Repetition), "only a repetition brings a task back")?;
                let well = matches!(own.outcome, Some(Outcome::Success(_)));
                require(well && own.since == self.world.now, "it did not end well now")
            }
            (_, TaskState::Pending) => self.clause_or_activity(own, &["restart-when"], &["reset"]),
            (_, TaskState::Ongoing) => self.started(from),
            (_, TaskState::Interrupted) => self.interrupted(own),
            (_, TaskState::Terminated) => ends::ended(self, own, from, outcome),
            (_, TaskState::Enabled) => Err("no task is enabled from there".into()),
        }
    }

    fn enabled(&self, own: &Known) -> Checked {
        let (world, now) = (self.world, self.world.now);
        let template = world.template(own);
        let satisfied = || {
            self.earlier(self.id)
                .any(|decision| matches!(&decision.kind, DecisionKind::Satisfied { clause, .. } if clause == "waitfor"))
        };
        match &self.because.cause {
            Cause::NoPreconditions => {
                let waits = template.is_some_and(|(_, _, step)| !step.waitfor.is_empty());
                require(!waits && !satisfied(), "its step has preconditions")
            }
            Cause::PreconditionsSatisfied => {
                let same = self.earlier(self.id).any(|decision| {
                    matches!(&decision.kind, DecisionKind::Satisfied { clause, .. } if clause == "waitfor")
                        && decision.because.evidence == self.because.evidence
                });
                require(same, "its waitfor did not become true now, or by something else")
            }
            Cause::PredecessorEnded { predecessor } => {
                let before = world.task(*predecessor)?;
                require(before.parent == own.parent, "that task has another parent")?;
                require(before.state == TaskState::Terminated && before.since == now, "that task did not end now")?;
                let places = world.template(own).zip(world.template(before)).map(|(own, before)| (own.1, before.1));
                require(places.is_none_or(|(own, before)| own > before), "that is not a step before it")?;
                let between = places.map(|(own, before)| before + 1..own).unwrap_or_default();
                let open = own.parent.into_iter().flat_map(|parent| world.children(parent)).any(|(_, each)| {
                    let place = world.template(each).map(|template| template.1);
                    each.state != TaskState::Terminated && place.is_some_and(|place| between.contains(&place))
                });
                require(!open, "a step between them has not ended")
            }
            Cause::ResultArrived { variable } => {
                let named = |decision: &Decision| matches!(&decision.kind, DecisionKind::Bound { variable: name, .. } if name == variable);
                let bound = self
                    .step
                    .effects
                    .iter()
                    .take(self.index)
                    .any(|effect| matches!(effect, Effect::Decided(decision) if named(decision)));
                require(bound, "no such variable was bound now")
            }
            Cause::IntervalElapsed => {
                let interval = template.and_then(|(_, _, step)| step.repeating.as_ref()?.minimum_interval.as_ref());
                require(interval.is_some() && own.since < now, "it has no least interval that could be over now")
            }
            Cause::StartsOver => {
                let over = own.moves.last().is_some_and(|(at, from, to)| {
                    *at == now && *to == TaskState::Pending && *from != TaskState::Terminated
                });
                require(over, "it does not start over now")
            }
            Cause::RepeatedEnabled => {
                let enabled = template
                    .is_none_or(|(_, _, step)| step.repeating.as_ref().is_some_and(|clause| clause.enabled.is_some()));
                let back = own.moves.last().is_some_and(|(_, from, _)| *from == TaskState::Terminated);
                require(enabled && back, "it does not repeat :enabled")
            }
            Cause::FailureHandled { by } => self.handled_by(*by),
            other => Err(format!("{} enables no task", other.kind())),
        }
    }

    fn handled_by(&self, by: TaskId) -> Checked {
        let handler = self.world.task(by)?;
        require(handler.parent == Some(self.id), "that task is not its own")?;
        require(handler.created == self.world.now, "that task was not created now")
    }

    fn started(&self, from: TaskState) -> Checked {
        match &self.because.cause {
            Cause::ResourcesGranted { resources } => resources.iter().try_for_each(|share| self.has_room(share)),
            Cause::FailureHandled { by } => self.handled_by(*by),
            Cause::AncestorResumed { ancestor } => {
                require(from == TaskState::Interrupted, "it was not interrupted")?;
                require(*ancestor != self.id && self.world.is_above(*ancestor, self.id), "that is not an ancestor")
            }
            Cause::ConditionSatisfied { .. } | Cause::Activity { .. } if from == TaskState::Interrupted => {
                self.clause_or_activity(self.own()?, &["until", "resume-when"], &["resume"])
            }
            other => Err(format!("{} starts no task", other.kind())),
        }
    }

    /// Checks that the shares held by tasks that are neither ancestors nor descendants leave enough of the resource.
    fn has_room(&self, share: &Share) -> Checked {
        let (world, name) = (self.world, share.resource.to_string());
        let total = world.total(&name);
        let amount = share.amount.as_ref().and_then(Value::as_number).map_or(total, |(number, _)| number);
        if total.is_infinite() {
            return require(share.amount.is_some(), "no amount of what can be used up");
        }
        require(amount <= total + 1e-9, "more than there is")?;
        let family = |a: TaskId, b: TaskId| world.is_above(a, b) || world.is_above(b, a);
        let holders = world.holders.get(&name).map(Vec::as_slice).unwrap_or_default();
        let strangers: Vec<&(TaskId, f64)> = holders.iter().filter(|(task, _)| !family(*task, self.id)).collect();
        let inside = |task: TaskId| strangers.iter().any(|(other, _)| *other != task && world.is_above(*other, task));
        let relative = holders.iter().any(|(task, _)| *task != self.id && world.is_above(*task, self.id));
        let used: f64 = strangers.iter().filter(|(task, _)| !inside(*task)).map(|(_, amount)| *amount).sum();
        require(relative || used + amount <= total + 1e-9, &format!("{name} is held by others"))
    }

    fn interrupted(&self, own: &Known) -> Checked {
        match &self.because.cause {
            Cause::Outranked { by, resource, rule, winner, loser } => {
                require(*by != self.id, "no task outranks itself")?;
                self.strengths(*rule, *winner, *loser)?;
                let gets = self.step.effects.iter().any(|effect| matches!(effect, Effect::Decided(decision)
                    if decision.task == Some(*by) && matches!(&decision.because.cause, Cause::ResourcesGranted { resources }
                        if resources.iter().any(|share| share.resource == *resource))));
                let resumed = self.moves_now(*by, TaskState::Ongoing);
                require(gets || resumed, "the winner does not get the resource now")
            }
            Cause::AncestorSuspended { ancestor } => {
                require(*ancestor != self.id && self.world.is_above(*ancestor, self.id), "that is not an ancestor")
            }
            _ => self.clause_or_activity(own, &["suspend-when"], &["suspend"]),
        }
    }

    /// Checks that the stated strengths let the winner win.
    fn strengths(&self, rule: ConflictRule, winner: Strength, loser: Strength) -> Checked {
        let (w, l) = (winner.total(), loser.total());
        let wins = match rule {
            ConflictRule::Rank => winner.priority < loser.priority,
            ConflictRule::Priority | ConflictRule::GoesBefore { .. } => w > l,
            ConflictRule::Incumbent => w >= l,
            ConflictRule::WrittenOrder | ConflictRule::CreationOrder => winner.priority == loser.priority,
            ConflictRule::Capacity | ConflictRule::Begun => true,
        };
        require(wins, &format!("{rule:?} does not let {w} win against {l}"))
    }

    fn refused(&self, resource: &Value, winner: TaskId) -> Checked {
        let Cause::Outranked { by, resource: stated, rule, winner: strong, loser } = &self.because.cause else {
            return Err(format!("{} refuses nothing", self.because.cause.kind()));
        };
        require(by == &winner && stated == resource && *by != self.id, "it names another winner or resource")?;
        self.strengths(*rule, *strong, *loser)?;
        let holders = self.world.holders.get(&resource.to_string()).map(Vec::as_slice).unwrap_or_default();
        let holds = holders.iter().any(|(task, _)| task == by);
        let claims = matches!(self.world.task(*by)?.state, TaskState::Enabled | TaskState::Interrupted);
        let written = matches!(rule, ConflictRule::Incumbent) && !holds;
        require((holds || claims) && !written, "the winner neither holds the resource nor claims it")
    }

    /// Checks that a clause of this name became true now, or that the named task did an activity of this name.
    pub(super) fn clause_or_activity(&self, own: &Known, clauses: &[&str], activities: &[&str]) -> Checked {
        match &self.because.cause {
            Cause::ConditionSatisfied { clause } => {
                require(clauses.contains(&&**clause), "that clause does something else")?;
                let came = self.earlier(self.id).any(|decision| {
                    matches!(&decision.kind, DecisionKind::Satisfied { clause: name, .. } if name == clause)
                        && decision.because.evidence == self.because.evidence
                });
                require(came, "that clause did not become true now, or by something else")
            }
            Cause::Activity { by, activity } => {
                require(activities.contains(&&**activity), "that activity does something else")?;
                let actor = self.world.task(*by)?;
                let says =
                    actor.goal.as_ref().is_some_and(|goal| goal.to_string().starts_with(&format!("({activity}")));
                require(says, "that task does something else")?;
                require(actor.since == self.world.now || ends_in(self.step, *by), "that task did nothing now")
            }
            other => Err(format!("{} does not move a task that is {}", other.kind(), own.state)),
        }
    }

    fn satisfied(&self, clause: &str, interval: (apex_model::time::Time, apex_model::time::Time)) -> Checked {
        let Cause::ConditionSatisfied { clause: stated } = &self.because.cause else {
            return Err(format!("{} satisfies no clause", self.because.cause.kind()));
        };
        require(stated == clause, "it names another clause")?;
        require(interval.0 <= interval.1 && interval.1 <= self.world.now, "its interval is not a past one")?;
        require(!self.because.evidence.is_empty(), "it rests on nothing")
    }

    fn bound(&self, variable: &str, value: &Value) -> Checked {
        let Cause::Binding { clause } = &self.because.cause else {
            return Err(format!("{} binds no variable", self.because.cause.kind()));
        };
        require(!variable.is_empty(), "it names no variable")?;
        match &**clause {
            "waitfor" => require(!self.because.evidence.is_empty(), "it rests on nothing"),
            "=>" => require(self.because.evidence.len() == 1, &format!("no task yielded {value}")),
            "select" | "setq" => require(self.because.place.is_some(), "it names no place"),
            other => Err(format!("no clause is called {other}")),
        }
    }

    fn selected(&self, method: &Method, goal: &Value, alternatives: usize) -> Checked {
        let head = |activity: &str| goal.to_string().starts_with(&format!("({activity}"));
        match (&self.because.cause, method) {
            (Cause::MostSpecific { candidates }, Method::Procedure(_) | Method::Primitive(_)) => {
                require(*candidates == alternatives as u64 + 1, "it counts others than are listed")
            }
            (Cause::FirstOfEquals { candidates, equals, .. }, Method::Procedure(_) | Method::Primitive(_)) => {
                require(*candidates == alternatives as u64 + 1, "it counts others than are listed")?;
                require((2..=*candidates).contains(equals), "so many cannot be as specific")
            }
            (Cause::BuiltIn { activity }, Method::BuiltIn) => require(head(activity), "the goal is another activity"),
            (Cause::ForAll { items }, Method::BuiltIn) => {
                let made = self.step.effects.iter().filter(|effect| {
                    matches!(effect, Effect::Decided(decision) if decision.because.cause == Cause::ItemOf { parent: self.id })
                });
                let count = made.count() as u64;
                // If the limit did not permit all of them, the task failed for that reason.
                let full = self.step.effects.iter().any(|effect| {
                    matches!(effect, Effect::Decided(decision) if decision.task == Some(self.id)
                        && matches!(&decision.because.cause, Cause::LimitReached { limit, .. } if limit == "TASKS_MAX" || limit == "MEMORY_MEBIBYTES_MAX"))
                });
                require(count == *items || count == 0 || count < *items && full, "it has another number of items")
            }
            (Cause::NoProcedureMatched, Method::Solver(_)) => Ok(()),
            (Cause::PlanArrived { .. }, Method::Procedure(_)) => ends::plan_arrived(self.step, &self.because.cause),
            (other, _) => Err(format!("{} does not choose this method", other.kind())),
        }
    }
}
