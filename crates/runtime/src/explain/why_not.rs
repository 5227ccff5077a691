//! Explanation of absent events: a task not created, started, resumed, chosen or granted, a target not visited.

use super::absence::{self, ProgramStep};
use super::answer::{Missing, TargetMoment, Why, WhyNot};
use super::find::{self, TaskSearchError};
use super::phrase::Phrase;
use super::snapshot::{RecordSnapshot, place_text};
use super::{target, things, why};
use crate::error::RecordError;
use crate::method_detail::MethodDetail;
use crate::record::TaskRow;
use apex_executive::Agent;
use apex_forms::print::Style::Brief;
use apex_model::task::{Outcome, TaskId, TaskState};
use apex_model::time::Time;

/// Answers `why-not` about `asked`.
pub(super) fn answer(snapshot: RecordSnapshot<'_>, asked: &str) -> Result<WhyNot, RecordError> {
    let name = find::without_agent(asked, &snapshot.name)?.to_owned();
    if name.trim().is_empty() {
        return Err(RecordError::Question("The question is empty.".into()));
    }
    if let Some(id) = snapshot.decisions().target_called(name.trim())? {
        return of_target(snapshot, asked, &id);
    }
    if let Some(answer) = of_procedure(&snapshot, asked, &name)? {
        return finished(snapshot, answer);
    }
    if let Some(id) = instance(&snapshot, &name) {
        return of_task(snapshot, asked, id);
    }
    if let Some(answer) = of_resource(&snapshot, asked, &name)? {
        return finished(snapshot, answer);
    }
    if let Some(answer) = of_step(&snapshot, asked, &name)? {
        return finished(snapshot, answer);
    }
    match find::find_task(&snapshot.tasks, &name, snapshot.at).map(|row| row.id) {
        Ok(id) => of_task(snapshot, asked, id),
        Err(error) => Err(find::of_no_agent(near(&snapshot, &name, error)?, &name, &snapshot.name)),
    }
}

/// An answer, and the task that is still to be explained in it.
struct Draft {
    answer: WhyNot,
    task: Option<TaskId>,
}

fn finished(snapshot: RecordSnapshot<'_>, draft: Draft) -> Result<WhyNot, RecordError> {
    let Draft { mut answer, task } = draft;
    if let Some(task) = task {
        let asked = answer.about.asked.clone();
        answer.task = Some(Box::new(why::of_task(snapshot, task, "why-not", &asked)?));
    }
    Ok(answer)
}

fn draft(snapshot: &RecordSnapshot<'_>, kind: &'static str, asked: &str, answer: String) -> WhyNot {
    let about = snapshot.about("why-not", kind, asked);
    let (missing, target, others) = (Vec::new(), Vec::new(), Vec::new());
    WhyNot { about, answer, missing, task: None, target, others }
}

/// Returns the task that the question names: by number, tag or goal, where variables match anything. A living task precedes others, a
/// later one precedes earlier ones.
fn instance(snapshot: &RecordSnapshot<'_>, name: &str) -> Option<TaskId> {
    let number = name.trim().trim_start_matches(['T', 't']).parse::<u64>().ok();
    if let Some(number) = number {
        return snapshot.row(TaskId(number)).filter(|row| row.created <= snapshot.at).map(|row| row.id);
    }
    let phrase = Phrase::read(name);
    let listed = matches!(phrase, Phrase::List(_));
    let meant = |row: &&TaskRow| {
        row.created <= snapshot.at
            && (row.tag.eq_ignore_ascii_case(name.trim())
                || listed && phrase.is_telling() && Phrase::read(&row.goal).fits(&phrase))
    };
    let lives = |row: &TaskRow| row.ended.is_none_or(|ended| ended > snapshot.at);
    snapshot.tasks.iter().filter(meant).max_by_key(|row| (lives(row), row.id)).map(|row| row.id)
}

fn of_task(snapshot: RecordSnapshot<'_>, asked: &str, id: TaskId) -> Result<WhyNot, RecordError> {
    let mut answer = draft(&snapshot, "task", asked, String::new());
    let task = why::of_task(snapshot, id, "why-not", asked)?;
    answer.answer = sentence(&task);
    answer.task = Some(Box::new(task));
    Ok(answer)
}

/// States the event that the task lacks.
fn sentence(task: &Why) -> String {
    let name = format!("{} {}", task.task, task.goal);
    let (t, since) = (Time::from_seconds(task.about.t), Time::from_seconds(task.since));
    match task.state.as_str() {
        "pending" => format!("{name} has not been enabled by {t}: it is pending since {since}."),
        "enabled" => format!("{name} has not started by {t}: it is enabled since {since}."),
        "interrupted" => format!("{name} has not continued by {t}: it is interrupted since {since}."),
        "ongoing" => format!("{name} has started: it is ongoing since {since}. It has not ended by {t}."),
        _ => {
            let outcome = task.outcome.as_deref().map(|word| format!(" ({word})")).unwrap_or_default();
            format!("{name} is over by {t}: it ended at {since}{outcome}.")
        }
    }
}

/// Explains why a step or goal of the program has no task.
fn of_step(snapshot: &RecordSnapshot<'_>, asked: &str, name: &str) -> Result<Option<Draft>, RecordError> {
    let Some(agent) = snapshot.agent() else { return Ok(None) };
    let all = absence::program_steps(agent);
    let phrase = Phrase::read(name);
    let wanted = absence::named(&all, name.trim(), &phrase);
    if wanted.is_empty() {
        return Ok(unasked(snapshot, asked, &phrase));
    }
    let mut answer = draft(snapshot, "step", asked, String::new());
    let task = follow(snapshot, agent, &all, &wanted, &mut answer)?;
    if let Some(handler) = wanted.iter().map(|site| site.handler(&phrase)).reduce(Option::and).flatten() {
        return Ok(Some(of_handler(snapshot, agent, (answer, task), handler)));
    }
    let goal = answer.missing.first().map(|missing| missing.activity.clone()).unwrap_or_default();
    let state = task.and_then(|task| agent.task(task)).map(|task| task.state);
    let reason = match (task, state) {
        (None, _) => "nothing in the program leads to it".to_owned(),
        (Some(task), Some(TaskState::Terminated) | None) => format!("{task} {} has ended", snapshot.goal(task)),
        (Some(task), Some(TaskState::Ongoing)) => {
            format!("{task} {} is ongoing, and does not lead to it now", snapshot.goal(task))
        }
        (Some(task), Some(state)) => format!("{task} {}, which leads to it, is {state}", snapshot.goal(task)),
    };
    answer.answer = format!("No task pursues {goal} at {}: {reason}.", snapshot.at);
    Ok(Some(Draft { answer, task }))
}

/// Explains why no task pursues the goal `handler` of a step that has failed: the step has not failed.
fn of_handler(
    snapshot: &RecordSnapshot<'_>,
    agent: &Agent,
    (mut answer, task): (WhyNot, Option<TaskId>),
    handler: String,
) -> Draft {
    let of_task = |task: TaskId| Some((task, agent.task(task)?));
    let (is_begun, named) = (answer.missing.len() <= 1, task.and_then(of_task));
    let own = answer.missing.first().map(|missing| missing.activity.clone()).unwrap_or_default();
    let reason = match named {
        Some((task, data)) if is_begun && data.state == TaskState::Terminated => {
            let is_success = matches!(data.outcome, Some(Outcome::Success(_)));
            let outcome = if is_success { " with success" } else { "" };
            format!("{task} {} has ended{outcome}, and only its failure leads to it", snapshot.goal(task))
        }
        Some((task, data)) if is_begun => {
            format!("{task} {} is {}, and leads to it only if it fails", snapshot.goal(task), data.state)
        }
        Some((task, data)) => {
            let goal = snapshot.goal(task);
            format!(
                "only a failure of {own} leads to it, which no task pursues; {task} {goal}, which leads to that, is {}",
                data.state
            )
        }
        None => format!("only a failure of {own} leads to it, and nothing in the program leads to that"),
    };
    answer.answer = format!("No task pursues {handler} at {}: {reason}.", snapshot.at);
    if let Some(missing) = answer.missing.first_mut() {
        missing.activity = handler;
    }
    Draft { answer, task }
}

/// Follows the missing steps upwards; adds the missing steps and other possible readings of the question.
fn follow(
    snapshot: &RecordSnapshot<'_>,
    agent: &Agent,
    all: &[ProgramStep],
    wanted: &[ProgramStep],
    answer: &mut WhyNot,
) -> Result<Option<TaskId>, RecordError> {
    let log = snapshot.log()?;
    let found = absence::absence(agent, &log, all, wanted);
    let first = found.missing.first().map(|missing| missing.place.clone());
    let other = |site: &&ProgramStep| site.get().is_some_and(|step| Some(place_text(agent, step.place)) != first);
    answer.others =
        wanted.iter().filter(other).take(crate::limits::CANDIDATES_MAX).map(|site| site.text(agent)).collect();
    answer.missing = found.missing;
    Ok(found.task)
}

/// Returns the answer that a procedure or primitive serves this goal, but no step pursues it.
fn unasked(snapshot: &RecordSnapshot<'_>, asked: &str, phrase: &Phrase) -> Option<Draft> {
    let agent = snapshot.agent()?;
    let telling = matches!(phrase, Phrase::List(_)) && phrase.is_telling();
    let procedures = agent.library.procedures.iter().map(|each| (&each.index, each.place, "procedure"));
    let primitives = agent.library.primitives.iter().map(|each| (&each.index, each.place, "primitive"));
    let (index, place, word) =
        procedures.chain(primitives).find(|(index, ..)| telling && Phrase::of_pattern(index).fits(phrase))?;
    let (index, place) = (Brief.pattern(index), place_text(agent, place));
    let text = format!("No step of the program asks for {asked}; only the {word} {index} at {place} would serve it.");
    Some(Draft { answer: draft(snapshot, "procedure", asked, text), task: None })
}

/// Explains a procedure or primitive by its place: the steps that could pursue it, and the methods chosen instead.
fn of_procedure(snapshot: &RecordSnapshot<'_>, asked: &str, name: &str) -> Result<Option<Draft>, RecordError> {
    let Some((file, line)) = name.trim().rsplit_once(':') else { return Ok(None) };
    let (Ok(line), Some(agent)) = (line.parse::<u32>(), snapshot.agent()) else { return Ok(None) };
    let is_named = |name: &str| name == file || name.ends_with(&format!("/{file}"));
    let source = agent.library.sources.iter().find(|source| is_named(&source.name));
    let is_beyond = |lines: usize| usize::try_from(line).is_ok_and(|line| line > lines);
    if source.is_some_and(|source| is_beyond(source.text.lines().count())) {
        return Ok(None);
    }
    let procedures = agent.library.procedures.iter().map(|each| (&each.index, each.place));
    let primitives = agent.library.primitives.iter().map(|each| (&each.index, each.place));
    let here = |place: apex_model::source::Place| {
        let text = place_text(agent, place);
        place.line <= line && text.rsplitn(3, ':').nth(2).is_some_and(is_named)
    };
    let Some((index, place)) =
        procedures.chain(primitives).filter(|(_, place)| here(*place)).max_by_key(|(_, place)| place.line)
    else {
        return Ok(None);
    };
    let (phrase, words, place) = (Phrase::of_pattern(index), Brief.pattern(index), place_text(agent, place));
    let goals = snapshot.tasks.iter().filter(|row| row.created <= snapshot.at && Phrase::read(&row.goal).fits(&phrase));
    let method = |row: &&TaskRow| row.method.as_ref().is_some_and(|method| method.place.as_ref() == Some(&place));
    let (mine, others): (Vec<&TaskRow>, Vec<&TaskRow>) = goals.partition(method);
    let lives = |row: &&TaskRow| row.ended.is_none_or(|ended| ended > snapshot.at);
    let chosen = others.into_iter().max_by_key(|row| (lives(row), row.id));
    let text = match (mine.last(), chosen) {
        (_, Some(row)) => format!(
            "{} {} is not pursued by {words} at {place}, but by {}.",
            row.id,
            row.goal,
            row.method.as_ref().map_or_else(|| "nothing yet".to_owned(), MethodDetail::to_string)
        ),
        (Some(row), None) => format!("{words} at {place} was chosen for {} {}.", row.id, row.goal),
        (None, None) => return of_step(snapshot, asked, &words),
    };
    let task = chosen.or(mine.last().copied()).map(|row| row.id);
    Ok(Some(Draft { answer: draft(snapshot, "procedure", asked, text), task }))
}

/// Explains a resource with its holders.
fn of_resource(snapshot: &RecordSnapshot<'_>, asked: &str, name: &str) -> Result<Option<Draft>, RecordError> {
    let Some(explained) = things::of_resource(snapshot, name, "why-not")? else { return Ok(None) };
    let found = &explained.answer;
    let names = |list: &[super::Holder]| {
        let names: Vec<String> = list.iter().map(|each| format!("{} {}", each.task, each.goal)).collect();
        names.join(" and ")
    };
    let text = match (found.holders.as_slice(), found.waiting.as_slice()) {
        ([], []) => format!("{} is free at {}, and no task waits for it.", found.resource, snapshot.at),
        (some, []) => {
            format!("{} is held by {} at {}, and no task waits for it.", found.resource, names(some), snapshot.at)
        }
        ([], some) => format!(
            "{} is free at {}, and {} waits for it and for something else.",
            found.resource,
            snapshot.at,
            names(some)
        ),
        (holders, some) => {
            format!("{} is not granted to {}, because it is held by {}.", found.resource, names(some), names(holders))
        }
    };
    Ok(Some(Draft { answer: draft(snapshot, "resource", asked, text), task: explained.first }))
}

/// Explains a target: its history, and the step of the plan that is to visit it.
fn of_target(snapshot: RecordSnapshot<'_>, asked: &str, id: &str) -> Result<WhyNot, RecordError> {
    let moments = target::moments(&snapshot, id)?;
    let is_known = !moments.is_empty() || snapshot.decisions().announced(id)?.is_some_and(|known| known <= snapshot.at);
    let sentence = match is_known {
        true => target_sentence(id, snapshot.at, &moments),
        false => format!("{id} has not been announced by {}: no planner knows it yet.", snapshot.at),
    };
    let mut answer = draft(&snapshot, "target", asked, sentence);
    let done = moments.last().is_some_and(|last| last.state == "observed");
    answer.target = moments;
    let mut task = None;
    if let Some(agent) = snapshot.agent().filter(|_| !done) {
        let all = absence::program_steps(agent);
        let wanted = absence::mentioning(&all, id);
        if !wanted.is_empty() {
            task = follow(&snapshot, agent, &all, &wanted, &mut answer)?;
        }
    }
    finished(snapshot, Draft { answer, task })
}

fn target_sentence(id: &str, at: Time, moments: &[TargetMoment]) -> String {
    let Some(TargetMoment { t, state, detail }) = moments.last() else {
        return format!("{id} is a target, and no plan has said anything about it by {at}.");
    };
    let detail = match (state.as_str(), detail.as_str()) {
        (_, "") => String::new(),
        // The planned time.
        ("planned", detail) => format!(" {detail}"),
        (_, detail) => format!(": {detail}"),
    };
    let since = Time::from_seconds(*t);
    // A target of surveillance is visited again and again; a plan may leave out a further visit.
    let observed = moments.iter().rev().find(|moment| moment.state == "observed");
    let observed = observed.map(|moment| Time::from_seconds(moment.t));
    match state.as_str() {
        "observed" => format!("{id} was observed at {since}."),
        "observing" => format!("{id} is being observed at {at}, since {since}."),
        "skipped" => match observed {
            Some(seen) => format!("{id} was last observed at {seen}; a further visit was left out at {since}{detail}."),
            None => format!("{id} has not been visited by {at}: it was left out at {since}{detail}."),
        },
        _ => match observed {
            Some(seen) => format!("{id} was last observed at {seen}; at {since} it was {state}{detail}."),
            None => format!("{id} has not been visited by {at}: at {since} it was {state}{detail}."),
        },
    }
}

/// Returns the message; for an unknown name one with the similar names of the whole program.
fn near(snapshot: &RecordSnapshot<'_>, name: &str, error: TaskSearchError) -> Result<String, RecordError> {
    if let TaskSearchError::Number(text) | TaskSearchError::Ambiguous(text) = error {
        return Ok(text);
    }
    let mut known: Vec<String> = snapshot.decisions().target_ids()?;
    if let Some(agent) = snapshot.agent() {
        for site in absence::program_steps(agent) {
            if let Some(step) = site.get() {
                known.push(step.tag.to_string());
                known.push(Brief.activity(&step.activity));
            }
        }
        known.extend(agent.resources.iter().map(|(_, resource)| resource.name.to_string()));
    }
    known.sort();
    known.dedup();
    Ok(find::unknown(name, snapshot.at, &known))
}

impl Missing {
    /// Returns the step with its procedure, for operators.
    pub fn text(&self) -> String {
        format!("step `{}` of {} at {}", self.step, self.procedure, self.place)
    }
}
