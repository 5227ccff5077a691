//! Messages and states of tasks (rules 4 and 23).

use crate::condition::{Relation, Term, Time};
use crate::value::{Bindings, matches};
use crate::ways::{View, Way, Ways, instant_fits};

/// Returns every message within the window that matches the pattern.
pub(crate) fn messages(pattern: &[Term], when: &[(Relation, Time)], view: View<'_>) -> Ways {
    let mut found = Vec::new();
    for message in &view.past.messages {
        let counts = if when.is_empty() { message.at >= view.created } else { instant_fits(message.at, when) };
        let mut bound = Bindings::new();
        if counts
            && message.words.len() == pattern.len()
            && pattern.iter().zip(&message.words).all(|(term, word)| matches(term, word, &mut bound))
        {
            found.push(Way::over((message.at, message.at), message.at, bound));
        }
    }
    found.into()
}

/// Returns the instants since the creation at which the task was found in, or came to, the state.
pub(crate) fn task_states(task: &str, state: &str, view: View<'_>) -> Ways {
    let moves: Vec<_> = view.past.moves.iter().filter(|each| each.task == task && each.at <= view.now).collect();
    let mut found = Vec::new();
    if moves.iter().rev().find(|each| each.at < view.created).is_some_and(|each| each.state == state) {
        found.push(Way::at(view.created, view.created));
    }
    let mut before = "";
    for each in moves {
        let resumed = state == "resumed" && before == "interrupted" && each.state == "ongoing";
        if each.at >= view.created && (each.state == state || resumed) {
            found.push(Way::at(each.at, each.at));
        }
        before = &each.state;
    }
    found.into()
}
