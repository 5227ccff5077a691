//! The interruption matrix: every cell of {holder, challenger} x {higher, equal, lower} x {arrives before, with, after} x {behaviour} is
//! on a page of `interruption/`, and the program there has the properties of the cell.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at an unexpected result")]

use apex_executive::state::clause::Clause;
use apex_model::effect::{DecisionKind, Effect};
use apex_model::event::Batch;
use apex_model::expression::{ExprKind, Template};
use apex_model::library::Library;
use apex_model::pattern::Pattern;
use apex_model::procedure::{Activity, PriorityClause, Procedure, Step, Transitions};
use apex_model::task::TaskState;
use apex_model::time::Time;
use apex_runtime::ports::Observer;
use apex_spec::scenario::{self, Scenario};
use apex_spec::verdict;
use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::path::Path;

const BEHAVIOURS: [&str; 5] = ["resume", "restart", "end-when", "suspended-parent", "failing-child"];
const RELATIONS: [(&str, Ordering); 3] =
    [("higher", Ordering::Greater), ("equal", Ordering::Equal), ("lower", Ordering::Less)];
const SUBJECTS: [&str; 2] = ["holder", "challenger"];
const ARRIVALS: [(&str, Ordering); 3] =
    [("before", Ordering::Less), ("with", Ordering::Equal), ("after", Ordering::Greater)];

/// Instants at which the tasks of the two steps became enabled, and the conditions that became true with their owners.
#[derive(Default)]
struct Log {
    tags: BTreeMap<u64, String>,
    enabled: BTreeMap<String, Time>,
    states: Vec<(String, TaskState)>,
    satisfied: Vec<(String, String)>,
}

impl Observer for Log {
    fn observe(&mut self, batch: &Batch, effects: &[Effect]) -> Result<(), String> {
        for effect in effects {
            let Effect::Decided(decision) = effect else { continue };
            let Some(task) = decision.task else { continue };
            let tag = self.tags.get(&task.0).cloned().unwrap_or_default();
            match &decision.kind {
                DecisionKind::Created { tag, .. } => {
                    self.tags.insert(task.0, tag.printed().to_string());
                }
                DecisionKind::Transition { to, .. } => {
                    if *to == TaskState::Enabled {
                        self.enabled.entry(tag.clone()).or_insert(batch.now);
                    }
                    self.states.push((tag, *to));
                }
                DecisionKind::Satisfied { clause, .. } => self.satisfied.push((tag, clause.to_string())),
                _ => {}
            }
        }
        Ok(())
    }
}

/// Returns the scenario below `## The {subject}`, `### The challenger arrives {arrival}`.
fn cell(text: &str, subject: &str, arrival: &str) -> Option<Scenario> {
    let lines: Vec<&str> = text.lines().collect();
    let find = |heading: String, from: usize| {
        let found = lines.iter().skip(from).position(|line| line.eq_ignore_ascii_case(&heading));
        found.map(|index| index + from)
    };
    let section = find(format!("## The {subject}"), 0)?;
    let start = find(format!("### The challenger arrives {arrival}"), section)?;
    // A heading between the two begins the section of the other subject, whose cell is not wanted.
    if lines.get(section + 1..start)?.iter().any(|line| line.starts_with("## ")) {
        return None;
    }
    let end =
        lines.iter().skip(start + 1).position(|line| line.starts_with('#')).map_or(lines.len(), |n| n + start + 1);
    let prose = lines.get(start + 1..end)?.iter().find(|line| !line.is_empty())?;
    assert!(!prose.starts_with("```"), "the cell has no prose");
    let inside = |line: usize| (start + 1..=end).contains(&line);
    let runs = verdict::scenarios(text).into_iter();
    let (_, scenario) = runs.filter(|(block, _)| block.kind == "trace").find(|(block, _)| inside(block.line))?;
    Some(scenario)
}

fn steps<'l>(library: &'l Library, tag: &str) -> (&'l Procedure, &'l Step) {
    let mut all = library.procedures.iter().flat_map(|each| each.steps.iter().map(move |step| (each.as_ref(), step)));
    all.find(|(_, step)| step.tag.is(tag)).unwrap()
}

fn priority(step: &Step) -> f64 {
    let [PriorityClause::Number(expr)] = step.priority.as_slice() else { panic!("one priority, a number") };
    let ExprKind::Constant(value) = &expr.kind else { panic!("a constant priority") };
    value.as_number().unwrap().0
}

/// Returns the procedure that serves the step's goal, if there is one.
fn serving<'l>(library: &'l Library, step: &Step) -> Option<&'l Procedure> {
    let Activity::Goal(Template::Constant(goal)) = &step.activity else { return None };
    let serves = |each: &&'l std::sync::Arc<Procedure>| matches!(&each.index, Pattern::Literal(index) if index == goal);
    library.procedures.iter().find(serves).map(AsRef::as_ref)
}

/// Returns true if the program gives the subject this behaviour.
fn behaves(library: &Library, subject: &str, behaviour: &str) -> bool {
    let (holder, step) = steps(library, subject);
    let own = serving(library, step);
    let any = |which: fn(&Transitions) -> bool| {
        which(&step.transitions) || own.is_some_and(|procedure| which(&procedure.transitions))
    };
    let fails = |step: &Step| {
        let inner = serving(library, step).map(|procedure| procedure.steps.as_slice()).unwrap_or_default();
        inner.iter().any(|step| matches!(&step.activity, Activity::Terminate { outcome: Some(_), .. }))
    };
    match behaviour {
        "resume" => !any(|it| it.restart_when.is_some() || it.end_when.is_some() || it.suspend_when.is_some()),
        "restart" => any(|it| it.restart_when.is_some()),
        "end-when" => any(|it| it.end_when.is_some()),
        "suspended-parent" => holder.transitions.suspend_when.is_some(),
        "failing-child" => own.is_some_and(|procedure| procedure.steps.iter().any(fails)),
        _ => false,
    }
}

/// Returns true if the subject's states in this run show what follows an interruption with this behaviour.
fn meets(log: &Log, subject: &str, behaviour: &str) -> bool {
    let states: Vec<TaskState> = log.states.iter().filter(|(tag, _)| tag == subject).map(|(_, state)| *state).collect();
    let after_interruption = |wanted: TaskState| states.windows(2).any(|pair| pair == [TaskState::Interrupted, wanted]);
    match behaviour {
        "resume" | "suspended-parent" => after_interruption(TaskState::Ongoing),
        "restart" => states.windows(2).any(|pair| pair == [TaskState::Ongoing, TaskState::Pending]),
        "end-when" => {
            let clause = Clause::EndWhen.word().to_string();
            after_interruption(TaskState::Terminated) && log.satisfied.contains(&(subject.to_string(), clause))
        }
        // The task continues with the handler of its failure.
        _ => after_interruption(TaskState::Ongoing) && log.states.iter().any(|(tag, _)| tag == "alarm"),
    }
}

fn check_cell(
    text: &str,
    behaviour: &str,
    relation: Ordering,
    subject: &str,
    arrival: (&str, Ordering),
) -> Result<bool, String> {
    let scenario = cell(text, subject, arrival.0).ok_or("no such section with prose and trace")?;
    let program = scenario::program(&scenario.pdl)?;
    let (holder, challenger) = (steps(&program.0, "holder").1, steps(&program.0, "challenger").1);
    if priority(challenger).total_cmp(&priority(holder)) != relation {
        return Err("the priorities are not in that relation".into());
    }
    if !behaves(&program.0, subject, behaviour) {
        return Err(format!("the {subject} has no such behaviour"));
    }
    let mut log = Log::default();
    scenario::run_observed(&scenario, &program, &mut [&mut log])?.map_err(|error| error.to_string())?;
    let enabled = |tag: &str| log.enabled.get(tag).copied().ok_or(format!("{tag} is never enabled"));
    if enabled("challenger")?.cmp(&enabled("holder")?) != arrival.1 {
        return Err("the challenger does not arrive then".into());
    }
    Ok(meets(&log, subject, behaviour))
}

#[test]
fn every_cell_has_a_page() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("interruption");
    let (mut cells, mut wrong, mut met) = (0, Vec::new(), BTreeMap::new());
    for behaviour in BEHAVIOURS {
        for (relation, order) in RELATIONS {
            let text = std::fs::read_to_string(folder.join(format!("{behaviour}-{relation}.md"))).unwrap_or_default();
            for subject in SUBJECTS {
                for arrival in ARRIVALS {
                    cells += 1;
                    match check_cell(&text, behaviour, order, subject, arrival) {
                        Ok(meets) => *met.entry((behaviour, subject)).or_insert(0) += u32::from(meets),
                        Err(reason) => {
                            wrong.push(format!("{behaviour}, {subject}, {relation}, arrives {}: {reason}", arrival.0));
                        }
                    }
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{} of {cells} cells:\n{}", wrong.len(), wrong.join("\n"));
    assert_eq!(cells, 90);
    let idle: Vec<_> = met.iter().filter(|(_, times)| **times == 0).collect();
    assert!(idle.is_empty(), "never interrupted and then so: {idle:?}");
}
