//! Identification of a task: by number, or by words of its goal or tag.

use crate::error::RecordError;
use crate::limits::CANDIDATES_MAX;
use crate::record::TaskRow;
use apex_model::task::TaskId;
use apex_model::time::Time;

/// Least likeness of a suggested name; 1 means equal.
const LIKENESS_MIN: f64 = 0.5;

/// A name that refers to no single task, with the message for the asker.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TaskSearchError {
    /// No task has this number, or its task is created later.
    Number(String),
    /// No task has this tag or goal, or a part of it.
    Unknown(String),
    /// Several tasks may be meant; the message lists them.
    Ambiguous(String),
}

impl TaskSearchError {
    /// Returns the message.
    pub(super) fn into_text(self) -> String {
        match self {
            TaskSearchError::Number(text) | TaskSearchError::Unknown(text) | TaskSearchError::Ambiguous(text) => text,
        }
    }
}

impl From<TaskSearchError> for RecordError {
    fn from(error: TaskSearchError) -> RecordError {
        RecordError::Question(error.into_text())
    }
}

/// Returns the task called `name` among `tasks`: by `T12`, `12`, its tag, its goal, or a part of its goal that no other goal contains,
/// whole words before parts of words. Of several such tasks, a living one.
///
/// # Errors
/// None or several are meant; the message has candidates.
pub fn find_task<'a>(tasks: &'a [TaskRow], name: &str, at: Time) -> Result<&'a TaskRow, TaskSearchError> {
    let known: Vec<&TaskRow> = tasks.iter().filter(|task| task.created <= at).collect();
    let name = name.trim();
    let digits = name.strip_prefix(['T', 't']).unwrap_or(name);
    if let Ok(number) = digits.parse::<u64>() {
        return by_number(tasks, &known, TaskId(number), at);
    }
    let folded = name.to_lowercase();
    let same = |text: &str| text.to_lowercase() == folded;
    let bare = |goal: &str| goal.trim_start_matches('(').trim_end_matches(')').to_owned();
    let exact: Vec<&TaskRow> =
        known.iter().copied().filter(|task| same(&task.tag) || same(&task.goal) || same(&bare(&task.goal))).collect();
    // Whole words precede parts of words: `land` means `(land at home)` rather than `(observe skyland)`.
    let loose = || -> Vec<&TaskRow> {
        let containing = |whole: bool| -> Vec<&TaskRow> {
            known.iter().copied().filter(|task| contains(&task.goal.to_lowercase(), &folded, whole)).collect()
        };
        Some(containing(true)).filter(|found| !found.is_empty()).unwrap_or_else(|| containing(false))
    };
    let found = if exact.is_empty() { loose() } else { exact };
    let living: Vec<&TaskRow> =
        found.iter().copied().filter(|task| task.ended.is_none_or(|ended| ended > at)).collect();
    match (found.as_slice(), living.as_slice()) {
        ([one], _) | (_, [one]) => Ok(one),
        ([], _) => {
            let what = format!("No task is called `{name}` at {at}.");
            Err(TaskSearchError::Unknown(with_candidates(what, "Tasks are", &known)))
        }
        (several, _) => {
            let what = format!("`{name}` may be one of {} tasks.", several.len());
            Err(TaskSearchError::Ambiguous(with_candidates(what, "Say which", several)))
        }
    }
}

/// Returns true if the goal has these words; `whole`: as whole words, not inside of longer ones.
fn contains(goal: &str, words: &str, whole: bool) -> bool {
    let is_part = |letter: Option<char>| letter.is_some_and(|letter| letter.is_alphanumeric() || "-_".contains(letter));
    goal.match_indices(words).any(|(at, _)| {
        let before = goal.get(..at).and_then(|text| text.chars().next_back());
        let after = goal.get(at + words.len()..).and_then(|text| text.chars().next());
        !whole || !is_part(before) && !is_part(after)
    })
}

/// Returns the name without its agent: `pilot/T12` is T12 of the agent `pilot`, to which this record must belong.
///
/// # Errors
/// [`RecordError::Question`] when the record belongs to another agent.
pub(super) fn without_agent<'a>(name: &'a str, agent: &str) -> Result<&'a str, RecordError> {
    match name.trim().split_once('/') {
        Some((first, rest)) if first.eq_ignore_ascii_case(agent) => Ok(rest),
        Some((first, rest)) if is_number(rest) => Err(RecordError::Question(no_agent(first, agent))),
        _ => Ok(name),
    }
}

fn no_agent(name: &str, agent: &str) -> String {
    format!("No agent is called {name}; the record has {agent}.")
}

/// Returns the error with the message `text` about `name`, with a remark if the name begins with an agent that this record does not have.
pub(super) fn of_no_agent(text: String, name: &str, agent: &str) -> RecordError {
    RecordError::Question(match agent_meant(name) {
        Some(first) => format!("{text} {}", no_agent(first, agent)),
        None => text,
    })
}

/// Returns the agent that `pilot/take-off` seems to name; `None` if the `/` has another meaning, as in files and goals.
pub(super) fn agent_meant(name: &str) -> Option<&str> {
    let (first, rest) = name.trim().split_once('/')?;
    let is_word =
        |text: &str| !text.is_empty() && text.chars().all(|each| each.is_alphanumeric() || "-_".contains(each));
    (is_word(first) && !rest.is_empty() && !rest.contains(['/', ':'])).then_some(first)
}

/// Returns true for a task number: `T12` or `12`.
pub(super) fn is_number(name: &str) -> bool {
    name.trim_start_matches(['T', 't']).parse::<u64>().is_ok()
}

/// Returns the message that `name` is unknown, with similar names among `known`.
pub(super) fn unknown(name: &str, at: Time, known: &[String]) -> String {
    let folded = name.trim().to_lowercase();
    let bare = |text: &str| text.trim_start_matches('(').trim_end_matches(')').to_lowercase();
    let likeness = |text: &str| strsim::normalized_damerau_levenshtein(&bare(text), &bare(&folded));
    let mut ranked: Vec<(f64, &String)> = known.iter().map(|each| (likeness(each), each)).collect();
    ranked.retain(|(likeness, each)| *likeness >= LIKENESS_MIN || each.to_lowercase().contains(&folded));
    ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
    let near: Vec<&str> = ranked.iter().take(CANDIDATES_MAX).map(|(_, each)| each.as_str()).collect();
    match near.as_slice() {
        [] => format!(
            "Nothing is called `{name}` at {at}: no task, step, goal, resource or target. `apex trace` shows what there is."
        ),
        some => format!("Nothing is called `{name}` at {at}. Near it are: {}.", some.join(", ")),
    }
}

fn by_number<'a>(
    tasks: &'a [TaskRow],
    known: &[&'a TaskRow],
    id: TaskId,
    at: Time,
) -> Result<&'a TaskRow, TaskSearchError> {
    let text = match tasks.iter().find(|task| task.id == id) {
        Some(task) if task.created <= at => return Ok(task),
        Some(task) => {
            format!("{id} {} is created at {}, later than {at}. Ask for a later instant.", task.goal, task.created)
        }
        None => with_candidates(format!("There is no task {id} in this flight."), "Tasks are", known),
    };
    Err(TaskSearchError::Number(text))
}

/// Returns `what` with the list of candidates.
fn with_candidates(what: String, introduction: &str, candidates: &[&TaskRow]) -> String {
    if candidates.is_empty() {
        return format!("{what} There are no tasks at that instant.");
    }
    let mut text = format!("{what} {introduction}:");
    for task in candidates.iter().take(CANDIDATES_MAX) {
        text.push_str(&format!("\n  {} {}, created at {}", task.id, task.goal, task.created));
    }
    if candidates.len() > CANDIDATES_MAX {
        text.push_str(&format!("\n  and {} more", candidates.len() - CANDIDATES_MAX));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn task(id: u64, tag: &str, goal: &str, created_s: f64) -> TaskRow {
        TaskRow {
            id: TaskId(id),
            parent: None,
            tag: tag.into(),
            goal: goal.into(),
            created: Time::from_seconds(created_s),
            ended: None,
            outcome: None,
            method: None,
            place: None,
        }
    }

    fn ask(name: &str) -> String {
        let tasks = [
            task(1, "root", "(fly mission)", 0.0),
            task(2, "power", "(power-up camera-1)", 1.0),
            task(3, "power-2", "(power-up camera-2)", 1.0),
            task(4, "late", "(land)", 50.0),
        ];
        match find_task(&tasks, name, Time::from_seconds(10.0)) {
            Ok(task) => task.id.to_string(),
            Err(error) => error.into_text(),
        }
    }

    #[test]
    fn numbers_tags_goals_and_parts_of_goals_name_tasks() {
        let names = ["T2", "t2", "2", "power", "POWER-UP CAMERA-1", "(power-up camera-1)", "camera-1"];
        assert!(names.into_iter().all(|name| ask(name) == "T2"));
    }

    #[test]
    fn whole_words_precede_parts_of_words() {
        let tasks = [task(1, "see", "(observe skyland)", 0.0), task(2, "down", "(land at home)", 5.0)];
        let told = |name: &str| find_task(&tasks, name, Time::from_seconds(10.0)).map(|task| task.id.0).ok();
        assert_eq!((told("land"), told("LAND AT"), told("skyl")), (Some(2), Some(2), Some(1)));
    }

    #[test]
    fn of_tasks_with_one_name_the_living_is_meant() {
        let mut tasks = [task(1, "fly", "(fly to a)", 0.0), task(2, "fly", "(fly to b)", 5.0)];
        let told = |tasks: &[TaskRow]| find_task(tasks, "fly", Time::from_seconds(10.0)).map(|task| task.id.0).ok();
        assert_eq!(told(&tasks), None);
        tasks[0].ended = Some(Time::from_seconds(5.0));
        assert_eq!(told(&tasks), Some(2));
        tasks[0].ended = Some(Time::from_seconds(11.0));
        assert_eq!(told(&tasks), None);
        tasks.iter_mut().for_each(|task| task.ended = Some(Time::from_seconds(9.0)));
        assert_eq!(told(&tasks), None);
    }

    #[test]
    fn an_agent_before_a_name_is_distinguished_from_a_path() {
        assert_eq!(agent_meant("pilot/T0"), Some("pilot"));
        assert_eq!(agent_meant("pilot-2/camera-1"), Some("pilot-2"));
        for other in ["T0", "(fly a/b)", "lib/fire.pdl:12", "/T0", "pilot/"] {
            assert_eq!(agent_meant(other), None, "{other}");
        }
    }

    #[test]
    fn unclear_names_are_answered_with_candidates() {
        assert_eq!(
            ask("power-up"),
            "`power-up` may be one of 2 tasks. Say which:\n  T2 (power-up camera-1), created at 1s\n  T3 (power-up camera-2), created at 1s"
        );
        assert!(ask("dance").starts_with("No task is called `dance` at 10s. Tasks are:\n  T1 (fly mission)"));
        assert!(ask("T99").starts_with("There is no task T99 in this flight."));
        assert_eq!(ask("T4"), "T4 (land) is created at 50s, later than 10s. Ask for a later instant.");
    }
}
