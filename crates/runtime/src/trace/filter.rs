//! Selection of lines of a trace.

use super::line::TraceLine;
use apex_model::time::Time;
use std::collections::BTreeSet;

/// The kinds of trace lines.
pub const KINDS: &[&str] = &[
    "created",
    "transition",
    "satisfied",
    "bound",
    "selected",
    "refused",
    "plan",
    "trouble",
    "command",
    "withdraw",
    "acknowledged",
    "solve",
    "cancel-solve",
    "solver",
    "event",
    "measurement",
    "publish",
    "wake",
    "print",
    "ask",
    "withdraw-question",
    "answer",
    "tell",
    "note",
    "stop",
    "agent-ended",
    "end",
];

/// Selection of lines. The default selects all except wakes: the lines that follow a wake contain its information.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TraceFilter {
    /// Only these kinds, out of [`KINDS`]; empty is all but `wake`.
    pub kinds: BTreeSet<String>,
    /// Only lines of this agent, if several run.
    pub agent: Option<String>,
    /// Only lines about this task (`T12`, `pilot/T12`), or with this text in the goal, form or state variable, in any case.
    pub object: Option<String>,
    /// Not before this instant.
    pub from: Option<Time>,
    /// Not after this instant.
    pub to: Option<Time>,
    /// Only lines caused by this place: `file.pdl`, `file.pdl:14`; folders before the name are optional.
    pub place: Option<String>,
}

impl TraceFilter {
    /// Checks the names of kinds.
    ///
    /// # Errors
    /// A message that names the unknown kind and all known ones.
    pub fn check(&self) -> Result<(), String> {
        match self.kinds.iter().find(|kind| !KINDS.contains(&kind.as_str())) {
            None => Ok(()),
            Some(unknown) => {
                Err(format!("there are no trace lines of type `{unknown}`; known are {}", KINDS.join(", ")))
            }
        }
    }

    /// Returns true if lines of this kind and instant are selected, unless they are refused for another reason.
    pub(super) fn admits_kind(&self, kind: &str, at: Time) -> bool {
        let is_selected = if self.kinds.is_empty() { kind != "wake" } else { self.kinds.contains(kind) };
        is_selected && self.from.is_none_or(|from| at >= from) && self.to.is_none_or(|to| at <= to)
    }

    /// Returns true if kind, time, agent and object of this line are selected.
    pub(super) fn admits(&self, line: &TraceLine) -> bool {
        let agent = match (self.agent.as_deref(), line.agent.as_deref()) {
            (Some(wanted), Some(found)) => found.eq_ignore_ascii_case(wanted),
            (_, None) | (None, _) => true,
        };
        self.admits_kind(line.kind, line.at)
            && agent
            && self.object.as_deref().is_none_or(|object| concerns(line, object))
    }
}

fn concerns(line: &TraceLine, object: &str) -> bool {
    let object = object.to_lowercase();
    if let (Some((agent, rest)), Some(own)) = (object.split_once('/'), line.agent.as_deref())
        && own.to_lowercase() == agent
    {
        return concerns(line, rest);
    }
    let number = object.strip_prefix('t').and_then(|digits| digits.parse::<u64>().ok());
    match number {
        Some(number) => line.task.is_some_and(|task| task.0 == number),
        None => line.goal.to_lowercase().contains(&object) || line.subject.to_lowercase().contains(&object),
    }
}

/// Returns true if `found` (`missions/a/file.pdl:14:3`) is within `wanted` (`file.pdl:14`).
pub(super) fn is_place_within(found: &str, wanted: &str) -> bool {
    let tails = std::iter::once(found).chain(found.match_indices('/').filter_map(|(index, _)| found.get(index + 1..)));
    let within = |tail: &str| tail.strip_prefix(wanted).is_some_and(|rest| rest.is_empty() || rest.starts_with(':'));
    tails.into_iter().any(within)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_match_whole_parts_only() {
        assert!(is_place_within("missions/a/file.pdl:14:3", "file.pdl:14"));
        assert!(is_place_within("file.pdl:14:3", "file.pdl"));
        assert!(!is_place_within("file.pdl:14:3", "file.pdl:1"));
        assert!(!is_place_within("profile.pdl:14:3", "file.pdl"));
    }

    #[test]
    fn an_unknown_kind_is_answered_with_the_known_ones() {
        let filter = TraceFilter { kinds: BTreeSet::from(["transitions".to_owned()]), ..TraceFilter::default() };
        let message = filter.check().unwrap_err();
        assert!(message.contains("`transitions`") && message.contains("transition,"), "{message}");
    }
}
