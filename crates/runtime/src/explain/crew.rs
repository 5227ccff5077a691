//! Questions about several agents: `pilot/T12` names a task of one agent; a name that only one agent has needs no prefix.

use super::{Question, find, find_task};
use crate::error::RecordError;
use crate::record::RecordReader;
use apex_model::time::Time;

/// For several agents: returns the record of the agent to which the question refers, and the question without the agent's name. The
/// question names the agent (`pilot/T12`, `pilot/camera-1`), or only one agent has such a task.
///
/// # Errors
/// [`RecordError::Question`] if the agent is ambiguous.
pub(super) fn addressed(
    reader: &RecordReader,
    question: &Question,
) -> Result<Option<(RecordReader, Question)>, RecordError> {
    if !reader.has_several_agents() {
        return Ok(None);
    }
    let (agent, what) = agent_and_name(reader, &question.what, question.at)?;
    Ok(Some((reader.of_agent(agent)?, Question { what: what.to_owned(), ..question.clone() })))
}

/// Returns the agent with which `name` begins, otherwise the only one with such a task; and the name without the agent.
fn agent_and_name<'n>(reader: &RecordReader, name: &'n str, at: Time) -> Result<(usize, &'n str), RecordError> {
    let named = name.trim().split_once('/');
    if let Some((agent, rest)) = named.and_then(|(agent, rest)| Some((reader.agent_called(agent).ok()?, rest))) {
        return Ok((agent, rest));
    }
    if let Some((agent, _)) = named.filter(|(_, rest)| find::is_number(rest)) {
        // The number belongs to this agent alone.
        reader.agent_called(agent)?;
    }
    let found = only_agent_with(reader, name, at);
    match (found, find::agent_meant(name).map(|agent| reader.agent_called(agent))) {
        (Err(_), Some(Err(no_agent))) => Err(no_agent),
        (found, _) => Ok((found?, name)),
    }
}

fn only_agent_with(reader: &RecordReader, name: &str, at: Time) -> Result<usize, RecordError> {
    let mut found = Vec::new();
    let mut refusal = None;
    for (agent, called) in reader.agents().iter().enumerate() {
        match find_task(&reader.of_agent(agent)?.tasks()?, name, at) {
            Ok(row) => found.push((agent, format!("{called}/{} {}", row.id, row.goal))),
            Err(error) => refusal = refusal.or_else(|| Some(format!("{called}: {}", error.into_text()))),
        }
    }
    match (found.as_slice(), refusal) {
        ([(agent, _)], _) => Ok(*agent),
        ([], Some(refusal)) => {
            let names = reader.agents().join(", ");
            Err(RecordError::Question(format!("{refusal} Several agents ran ({names}): write AGENT/TASK.")))
        }
        _ => {
            let names: Vec<&str> = found.iter().map(|(_, name)| name.as_str()).collect();
            Err(RecordError::Question(format!("Several agents have a task {name}: {}.", names.join(", "))))
        }
    }
}
