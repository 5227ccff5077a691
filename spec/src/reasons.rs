//! A waiting task must state for what it waits: checked for every task after every step of every run.
//!
//! The list of reasons is compared with the obstacles according to the agent's state, so that an incomplete list is also found.

use apex_executive::explanation::{Reason, ReasonKind, waiting};
use apex_executive::state::agent::Agent;
use apex_executive::state::task::Task;
use apex_model::effect::Effect;
use apex_model::event::Batch;
use apex_model::task::{TaskId, TaskState};
use apex_model::time::Time;
use apex_runtime::ports::{Deliberator, Observer};
#[cfg(test)]
use apex_runtime::program::NoDeliberator;

/// Queries every living task for its reasons, and keeps the answers that are empty or incomplete.
#[derive(Debug, Default)]
pub struct Asker {
    missing: Vec<String>,
}

impl Asker {
    /// Returns the missing reasons, one line per task and instant.
    pub fn missing(&self) -> &[String] {
        &self.missing
    }

    fn ask(&mut self, agent: &Agent, task: &Task, now: Time) {
        let reasons = waiting(agent, task.id);
        let mut miss = |what: String| {
            let name = agent.tag(task);
            self.missing.push(format!("{now} {} ({name}) is {}: {what}", task.id, task.state));
        };
        if reasons.is_empty() {
            miss("it does not say what it waits for".into());
        }
        if let Some(mute) = reasons.iter().find(|reason| reason.text.trim().is_empty()) {
            miss(format!("a reason of kind {:?} has no words", mute.kind));
        }
        for kind in expected(agent, task) {
            if !reasons.iter().any(|reason| reason.kind == kind) {
                miss(format!("no reason of kind {kind:?} among {}", told(&reasons)));
            }
        }
    }
}

fn told(reasons: &[Reason]) -> String {
    let words: Vec<String> = reasons.iter().map(|reason| format!("`{}`", reason.text)).collect();
    if words.is_empty() { "none".into() } else { words.join(", ") }
}

/// Returns the kinds of reasons that the task's own state calls for.
fn expected(agent: &Agent, task: &Task) -> Vec<ReasonKind> {
    let mut kinds = Vec::new();
    match task.state {
        TaskState::Pending => {
            let held = &task.held_back;
            let flags = [
                (held.by_predecessor, ReasonKind::Predecessor),
                (held.by_result, ReasonKind::Result),
                (held.by_condition, ReasonKind::Condition),
                (held.by_interval, ReasonKind::Time),
            ];
            kinds.extend(flags.into_iter().filter(|(holds, _)| *holds).map(|(_, kind)| kind));
        }
        TaskState::Enabled | TaskState::Interrupted => {
            let needs = task.selection.iter().flat_map(|selection| &selection.needs);
            let taken = needs.filter_map(|need| agent.resources.get(need.resource)).any(|resource| {
                let used: f64 = resource.holders.iter().map(|holding| holding.amount).sum();
                used >= resource.total && resource.holders.iter().all(|holding| !is_family(agent, holding.task, task))
            });
            if taken {
                kinds.push(ReasonKind::Resource);
            }
        }
        TaskState::Ongoing | TaskState::Terminated => {}
    }
    if task.suspended {
        kinds.push(ReasonKind::Suspended);
    }
    kinds
}

/// Returns true if one of the holder and the task is an ancestor of the other, so that they share resources.
fn is_family(agent: &Agent, holder: TaskId, task: &Task) -> bool {
    is_above(agent, holder, task.id) || is_above(agent, task.id, holder)
}

fn is_above(agent: &Agent, upper: TaskId, lower: TaskId) -> bool {
    let mut next = Some(lower);
    while let Some(id) = next {
        if id == upper {
            return true;
        }
        next = agent.task(id).and_then(|task| task.parent);
    }
    false
}

impl Observer for Asker {
    fn observe(&mut self, _: &Batch, _: &[Effect]) -> Result<(), String> {
        Ok(())
    }

    fn inspect(&mut self, agent: &Agent, _: &dyn Deliberator, now: Time) -> Result<(), String> {
        if agent.is_finished() {
            return Ok(());
        }
        for (_, task) in agent.tasks.iter().filter(|(_, task)| !task.is_terminated()) {
            self.ask(agent, task, now);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario;

    #[test]
    fn a_task_that_cannot_say_what_it_waits_for_is_found() {
        let pdl = "(procedure (index (do-domain)) (step a (print \"x\") (waitfor (go))))";
        let (library, declaration, host) = scenario::program(pdl).expect("the program is right");
        let mut agent = apex_executive::load(library, &declaration, host).expect("it can be loaded");
        apex_executive::step(&mut agent, &Batch { now: Time::ZERO, events: Vec::new() });
        let mut asker = Asker::default();
        asker.inspect(&agent, &NoDeliberator, Time::ZERO).expect("inspection always continues");
        assert!(asker.missing().is_empty(), "{:?}", asker.missing());
        let waiting = agent.tasks.iter().map(|(_, task)| task.id).last().expect("there is a task");
        agent.task_mut(waiting).expect("it lives").monitors.clear();
        asker.inspect(&agent, &NoDeliberator, Time::ZERO).expect("inspection always continues");
        assert!(
            asker.missing().iter().any(|line| line.contains("no reason of kind Condition")),
            "{:?}",
            asker.missing()
        );
    }
}
