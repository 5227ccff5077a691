//! `/api/why`: how a task came to be as it is, from the causes in the record.

use crate::answer::{Answer, ApiError};
use crate::index::State;
use crate::queries::events::{COLUMNS, EventRow};
use crate::queries::tasks::TaskRow;
use crate::record::Reader;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// Causes in one answer: a task that restarts for hours has more than anybody reads.
const CAUSES_MAX: usize = 60;
/// Children in one answer.
const CHILDREN_MAX: usize = 100;

/// Parameters.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct WhyQuery {
    /// The task's number.
    pub(crate) task: u64,
    /// Mission time, nanoseconds.
    pub(crate) at: i64,
    /// False leaves the command's explainer out: it restores an instant, the rows are there at once.
    pub(crate) explain: Option<bool>,
}

/// The answer.
#[derive(Debug, Serialize)]
pub(crate) struct Why {
    at_ns: i64,
    task: TaskRow,
    /// One sentence on the state now.
    now: String,
    /// All decisions about the task up to then, oldest first.
    because: Vec<Cause>,
    /// Older causes that were left out.
    left_out: bool,
    children: Vec<TaskRow>,
    /// What the command's explainer adds; see [`crate::Explainer`].
    pub(crate) explainer: Option<Value>,
    /// Why the explainer could not.
    pub(crate) explainer_error: Option<String>,
}

#[derive(Debug, Serialize)]
struct Cause {
    /// Two or three words: `created`, `started`, `interrupted`, `ended: success`.
    heading: String,
    #[serde(flatten)]
    event: EventRow,
}

/// Answers `/api/why` but for the explainer's part.
pub(crate) fn why(reader: &mut Reader, query: &WhyQuery) -> Answer<Why> {
    let index = reader.tasks()?;
    let task = index.get(query.task).ok_or_else(|| {
        ApiError::not_found(
            format!("there is no task T{} in this record", query.task),
            "`/api/tasks` lists the tasks of an instant",
        )
    })?;
    let row = TaskRow::at(query.task, task, query.at).ok_or_else(|| {
        ApiError::not_found(
            format!("task T{} did not exist yet at {} ns", query.task, query.at),
            format!("it was created at {} ns", task.created_ns),
        )
    })?;
    let children = index
        .tasks()
        .range(query.task..)
        .filter(|(_, child)| child.parent == Some(query.task))
        .filter_map(|(&id, child)| TaskRow::at(id, child, query.at))
        .take(CHILDREN_MAX)
        .collect();
    let (because, left_out) = causes(reader, query)?;
    let now = now_sentence(&row, &because);
    let at_ns = query.at;
    Ok(Why { at_ns, task: row, now, because, left_out, children, explainer: None, explainer_error: None })
}

fn causes(reader: &Reader, query: &WhyQuery) -> Result<(Vec<Cause>, bool), rusqlite::Error> {
    let mut statement = reader.connection.prepare_cached(&format!(
        "SELECT {COLUMNS} FROM effect WHERE task = ?1 AND t_ns <= ?2 ORDER BY id DESC LIMIT {}",
        CAUSES_MAX + 1
    ))?;
    let rows = statement.query_map((query.task.cast_signed(), query.at), EventRow::read)?;
    let mut events: Vec<EventRow> = rows.collect::<Result<_, _>>()?;
    let left_out = events.len() > CAUSES_MAX;
    events.truncate(CAUSES_MAX);
    events.reverse();
    Ok((events.into_iter().map(|event| Cause { heading: heading(&event), event }).collect(), left_out))
}

fn heading(event: &EventRow) -> String {
    let states = (event.from_state.as_deref(), event.to_state.as_deref());
    match (event.kind.as_str(), states) {
        ("transition", (_, Some("terminated"))) => match event.outcome.as_deref() {
            Some(outcome) => format!("ended: {outcome}"),
            None => "ended".into(),
        },
        ("transition", (Some("interrupted"), Some("ongoing"))) => "resumed".into(),
        ("transition", (_, Some("ongoing"))) => "started".into(),
        ("transition", (_, Some(state))) => state.into(),
        ("satisfied", _) => "condition satisfied".into(),
        ("bound", _) => "variable bound".into(),
        ("selected", _) => "method selected".into(),
        ("refused", _) => "resource refused".into(),
        (kind, _) => kind.into(),
    }
}

fn now_sentence(row: &TaskRow, because: &[Cause]) -> String {
    let last = |wanted: fn(&EventRow) -> bool| {
        because
            .iter()
            .rev()
            .map(|cause| &cause.event)
            .find(|event| wanted(event))
            .and_then(|event| event.text.as_deref())
    };
    let transition = last(|event| matches!(event.kind.as_str(), "transition" | "created"));
    let (state, reason) = match row.state {
        State::Pending => return format!("T{} is pending: it waits for its preconditions", row.id),
        State::Enabled => ("waits for its resources", last(|event| event.kind == "refused").or(transition)),
        State::Ongoing => ("is ongoing", transition),
        State::Interrupted => ("is interrupted", transition),
        State::Terminated => ("has ended", transition),
    };
    let outcome = row.outcome.as_ref().map_or_else(String::new, |word| format!(" ({word})"));
    match reason {
        Some(reason) => format!("T{} {state}{outcome} {}{reason}", row.id, because_word(reason)),
        None => format!("T{} {state}{outcome}", row.id),
    }
}

/// The record's texts are fragments after "because"; some writers put the word in.
fn because_word(reason: &str) -> &'static str {
    if reason.starts_with("because") { "" } else { "because " }
}
