//! Missing tasks: from a step without a task, up through the procedures that no task pursues, to the first existing task. All missing
//! tasks wait for the requirements of that one.

use super::answer::Missing;
use super::log::Log;
use super::phrase::Phrase;
use super::snapshot::place_text;
use crate::limits::MISSING_STEPS_MAX;
use apex_executive::Agent;
use apex_executive::explanation;
use apex_forms::print::Style::Brief;

use apex_executive::state::controller::MethodBinding;
use apex_executive::state::task::{Origin, ProcedureRef, StepRef, Task};
use apex_model::procedure::{Procedure, Step};
use apex_model::task::TaskId;
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::sync::Arc;

/// A step of the program or of a plan.
#[derive(Clone)]
pub(super) struct ProgramStep {
    pub(super) step: StepRef,
    procedure: Arc<Procedure>,
}

impl ProgramStep {
    /// Returns the step itself.
    pub(super) fn get(&self) -> Option<&Step> {
        self.procedure.steps.get(self.step.step as usize)
    }

    fn activities(&self) -> impl Iterator<Item = Phrase> {
        let step = self.get();
        let own = step.map(|step| Phrase::of_activity(&step.activity));
        let handler = step.and_then(|step| step.on_failure.as_deref()).map(Phrase::of_activity);
        own.into_iter().chain(handler)
    }

    /// Returns the goal that the step pursues after a failure, if the phrase names it and not the step's own activity.
    pub(super) fn handler(&self, phrase: &Phrase) -> Option<String> {
        let step = self.get()?;
        let is_named = |activity: Phrase| activity.is_telling() && activity.fits(phrase);
        let handler = step.on_failure.as_deref().filter(|_| !is_named(Phrase::of_activity(&step.activity)))?;
        is_named(Phrase::of_activity(handler)).then(|| Brief.activity(handler))
    }

    /// Returns the step and its file and line.
    pub(super) fn text(&self, agent: &Agent) -> String {
        let place = self.get().map(|step| (step.tag.to_string(), place_text(agent, step.place)));
        place.map(|(tag, place)| format!("step `{tag}` at {place}")).unwrap_or_default()
    }
}

/// The path from the subject of the question up to the first existing task.
pub(super) struct Absence {
    /// The missing steps, from the subject of the question upwards.
    pub(super) missing: Vec<Missing>,
    /// The first task that exists.
    pub(super) task: Option<TaskId>,
}

/// Returns all steps of the program and of plans that serve now.
pub(super) fn program_steps(agent: &Agent) -> Vec<ProgramStep> {
    let stored = agent.library.procedures.iter().zip(0..).map(|(each, number)| (ProcedureRef::Stored(number), each));
    let current = agent.generated.iter().filter(|(_, plan)| plan.current || plan.users > 0);
    let plans = current.map(|(number, plan)| (ProcedureRef::Generated(number), &plan.procedure));
    let of = |(procedure, each): (ProcedureRef, &Arc<Procedure>)| {
        let steps = u32::try_from(each.steps.len()).unwrap_or(u32::MAX);
        let each = Arc::clone(each);
        (0..steps).map(move |step| ProgramStep { step: StepRef { procedure, step }, procedure: Arc::clone(&each) })
    };
    stored.chain(plans).flat_map(of).collect()
}

/// Returns the steps with this tag; if there is none, steps whose activity matches the phrase.
pub(super) fn named(sites: &[ProgramStep], name: &str, phrase: &Phrase) -> Vec<ProgramStep> {
    let tag = |site: &&ProgramStep| site.get().is_some_and(|step| step.tag.is(name));
    let by_tag: Vec<ProgramStep> = sites.iter().filter(tag).cloned().collect();
    if !by_tag.is_empty() || !phrase.is_telling() {
        return by_tag;
    }
    sites
        .iter()
        .filter(|site| site.activities().any(|activity| activity.is_telling() && activity.fits(phrase)))
        .cloned()
        .collect()
}

/// Returns the steps whose activities mention a word; the activities of planned steps mention their targets.
pub(super) fn mentioning(sites: &[ProgramStep], word: &str) -> Vec<ProgramStep> {
    sites.iter().filter(|site| site.activities().any(|activity| activity.mentions(word))).cloned().collect()
}

/// Returns the tasks by the step from which they were made.
fn by_step(agent: &Agent) -> BTreeMap<StepRef, Vec<&Task>> {
    let mut map: BTreeMap<StepRef, Vec<&Task>> = BTreeMap::new();
    for (_, task) in agent.tasks.iter() {
        if let Origin::Step(step) | Origin::OnFailure(step) = task.origin {
            map.entry(step).or_default().push(task);
        }
    }
    map
}

/// Returns the shortest path from one of `wanted` up to an existing task.
pub(super) fn absence(agent: &Agent, log: &Log<'_>, all: &[ProgramStep], wanted: &[ProgramStep]) -> Absence {
    let tasks = by_step(agent);
    let mut known: BTreeSet<StepRef> = wanted.iter().map(|site| site.step).collect();
    let mut paths: Vec<(ProgramStep, Option<usize>)> = wanted.iter().map(|site| (site.clone(), None)).collect();
    let mut queue: VecDeque<usize> = (0..paths.len()).collect();
    let mut last = None;
    while let Some(index) = queue.pop_front() {
        let Some((site, _)) = paths.get(index).cloned() else { break };
        last.get_or_insert(index);
        if let Some(task) = tasks.get(&site.step).and_then(|tasks| best(tasks)).or_else(|| beginning(agent, &site)) {
            return Absence { missing: told(agent, log, &paths, index, Some(task)), task: Some(task.id) };
        }
        if paths.len() > MISSING_STEPS_MAX {
            break;
        }
        let mut above = callers(all, &site.procedure);
        if above.is_empty() {
            // No step of the program pursues it; a plan may.
            above = planned(agent, all);
        }
        for caller in above {
            if known.insert(caller.step) {
                paths.push((caller, Some(index)));
                queue.push_back(paths.len() - 1);
            }
        }
        if serves_initial(agent, &site.procedure)
            && let Some((_, root)) = agent.tasks.iter().find(|(_, task)| task.parent.is_none())
        {
            return Absence { missing: told(agent, log, &paths, index, Some(root)), task: Some(root.id) };
        }
    }
    let missing = last.map(|index| told(agent, log, &paths, index, None)).unwrap_or_default();
    Absence { missing, task: None }
}

/// Returns the living task, otherwise the last one.
fn best<'a>(tasks: &[&'a Task]) -> Option<&'a Task> {
    tasks.iter().find(|task| !task.is_terminated()).or(tasks.last()).copied()
}

/// Returns a task that has chosen the step's procedure and has not begun it.
fn beginning<'a>(agent: &'a Agent, site: &ProgramStep) -> Option<&'a Task> {
    let chose = |task: &&Task| {
        let way = task.selection.as_ref().map(|selection| &selection.way);
        matches!(way, Some(MethodBinding::Procedure(reference, _)) if *reference == site.step.procedure)
    };
    agent.tasks.iter().map(|(_, task)| task).filter(|task| task.controller.is_none()).find(chose)
}

/// Returns the steps whose goals the procedure may serve.
fn callers(all: &[ProgramStep], procedure: &Procedure) -> Vec<ProgramStep> {
    let index = Phrase::of_pattern(&procedure.index);
    let calls = |site: &&ProgramStep| site.activities().any(|activity| activity.is_telling() && activity.fits(&index));
    all.iter().filter(calls).cloned().collect()
}

/// Returns the steps whose goals a solver serves: their plans may contain any step.
fn planned(agent: &Agent, all: &[ProgramStep]) -> Vec<ProgramStep> {
    let solvers: Vec<Phrase> = agent.library.solvers.iter().map(|solver| Phrase::of_pattern(&solver.index)).collect();
    let asks = |activity: &Phrase| activity.is_telling() && solvers.iter().any(|solver| solver.fits(activity));
    all.iter().filter(|site| site.activities().any(|activity| asks(&activity))).cloned().collect()
}

fn serves_initial(agent: &Agent, procedure: &Procedure) -> bool {
    Phrase::read(&agent.initial_task.to_string()).fits(&Phrase::of_pattern(&procedure.index))
}

/// Returns the chain of steps from the subject of the question to `index`, each with its missing requirement.
fn told(
    agent: &Agent,
    log: &Log<'_>,
    paths: &[(ProgramStep, Option<usize>)],
    index: usize,
    task: Option<&Task>,
) -> Vec<Missing> {
    let mut way = Vec::new();
    let mut next = Some(index);
    while let Some((site, below)) = next.and_then(|index| paths.get(index)) {
        way.push(site);
        next = *below;
    }
    way.reverse();
    let count = way.len();
    let mut missing = Vec::new();
    for (number, site) in way.into_iter().enumerate() {
        let Some(step) = site.get() else { continue };
        let procedure = Brief.pattern(&site.procedure.index);
        let because = match task.filter(|_| number + 1 == count) {
            Some(task) => reached(agent, site, task),
            None if number + 1 == count => format!("no step of the program pursues {procedure}, to which it belongs"),
            None => format!("no task pursues {procedure}, to which it belongs"),
        };
        let place = place_text(agent, step.place);
        missing.push(Missing {
            step: step.tag.to_string(),
            activity: Brief.activity(&step.activity),
            procedure,
            source: log.source_line(&place),
            place,
            because,
        });
    }
    missing
}

/// Returns the relation of the task at the end of the path to the step.
fn reached(agent: &Agent, site: &ProgramStep, task: &Task) -> String {
    let name = format!(
        "{} {}",
        task.id,
        explanation::describe_task(agent, task.id).map(|view| view.goal.to_string()).unwrap_or_default()
    );
    let own = matches!(task.origin, Origin::Step(step) | Origin::OnFailure(step) if step == site.step);
    match (own, task.controller.is_some()) {
        (true, _) => format!("its task is {name}, which is {}", task.state),
        (false, false) => {
            let procedure = Brief.pattern(&site.procedure.index);
            format!("{name} would pursue {procedure} and is {}", task.state)
        }
        (false, true) => format!("{name} does not pursue its procedure at {}", place_text(agent, site.procedure.place)),
    }
}
