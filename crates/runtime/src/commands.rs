//! Commands of an operator to a run in progress; each ends exactly once: accepted, rejected or expired.
//!
//! The run decides about a command when it receives it, at one instant of mission time. It records the command with its end as an input:
//! the event `(operator-command NUMBER WORDS accepted)`, `(.. rejected REASON)` or `(.. expired REASON)`, with `:by NAME :epoch NUMBER` if its
//! author is known, with `:answers NUMBER` if it answers a question, and with `:alarm TEXT` if it acknowledges an alarm. If the sender has ended the command as expired before, or its time
//! is over, the run does not execute it.

use crate::authority::{Actor, AuthorityRequest};
use apex_model::event::EventKind;
use apex_model::symbol::Symbol;
use apex_model::time::Time;
use apex_model::value::Value;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

/// The head of the event that records a command.
pub(crate) const HEAD: &str = "operator-command";

/// Keyword before the name of a command's author.
const BY: &str = ":by";
/// Keyword before the number of the question that a command answers.
const ANSWERS: &str = ":answers";
/// Keyword before the alarm that a command acknowledges.
const ALARM: &str = ":alarm";

/// Order of a command to the run.
#[derive(Clone, Debug, PartialEq)]
pub enum Order {
    /// An input for one agent (`None`: for all): an answer, a message, updates of a target.
    Input(Option<Symbol>, EventKind),
    /// Another pace; see [`crate::RunSettings::pace`].
    Pace(Option<f64>),
    /// Continue to the next instant with a visible effect (a decision, a command, a question, output), then pause.
    Step,
    /// End the run cleanly.
    Stop,
    /// Only the entry in the record.
    Note,
    /// The operator acknowledges this alarm of the page: only the entry in the record.
    Acknowledge(String),
    /// A request about the authority over the run.
    Authority(AuthorityRequest),
}

/// The operator or program that gives a command.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Author {
    /// Name and role of the author.
    pub actor: Actor,
    /// Epoch of authority that the command states; a command of another epoch is refused. `None`: not stated.
    pub epoch: Option<u64>,
}

/// End of a command.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum CommandEnd {
    /// The run executed it at this instant.
    Accepted {
        /// Mission time.
        at: Time,
    },
    /// The run did not execute it.
    Rejected {
        /// Reason, in one clause.
        reason: String,
    },
    /// The run did not receive it in time.
    Expired {
        /// The limit that was over, in one clause.
        reason: String,
    },
}

/// The end of a command, shared by all clones; empty until it is set.
#[derive(Clone, Debug, Default)]
pub struct Ticket {
    end: Arc<Mutex<Option<CommandEnd>>>,
    valid_until: Option<(Instant, Arc<str>)>,
}

impl Ticket {
    /// Returns the ticket of a command that the run may accept before this instant only. A process that stands still for a while finds
    /// old commands when it continues, and the run may see them before the sender has ended them. `reason` states the limit.
    pub fn valid_until(instant: Instant, reason: &str) -> Ticket {
        Ticket { valid_until: Some((instant, reason.into())), ..Ticket::default() }
    }

    /// Ends the command as expired if its time is over and it has no end yet.
    pub fn expire(&self) {
        if let Some(reason) = self.overdue() {
            // No effect if the run has settled the command already.
            self.settle(CommandEnd::Expired { reason });
        }
    }

    /// Returns the limit that is over.
    fn overdue(&self) -> Option<String> {
        let (instant, reason) = self.valid_until.as_ref()?;
        (Instant::now() >= *instant).then(|| reason.to_string())
    }

    /// Sets the end. Returns false if the command has another one: that which it had already, or expired instead of accepted too late.
    pub fn settle(&self, end: CommandEnd) -> bool {
        let mut slot = self.end.lock().unwrap_or_else(PoisonError::into_inner);
        if slot.is_some() {
            return false;
        }
        let overdue = self.overdue().filter(|_| matches!(end, CommandEnd::Accepted { .. }));
        let is_refused = overdue.is_some();
        *slot = Some(overdue.map_or(end, |reason| CommandEnd::Expired { reason }));
        !is_refused
    }

    /// Returns the end; `None` before it is set.
    pub fn end(&self) -> Option<CommandEnd> {
        self.end.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

/// A command on its way to a run.
#[derive(Debug)]
pub struct Command {
    /// Number, from 1, in the order of sending.
    pub number: u64,
    /// The command as text, for the record.
    pub words: String,
    /// The order.
    pub order: Order,
    /// Its author, who needs authority; `None` for a program that owns the run.
    pub author: Option<Author>,
    /// Its end.
    pub ticket: Ticket,
}

impl Command {
    /// Returns the event that records the command with its end.
    pub(crate) fn entry(&self, end: &CommandEnd) -> EventKind {
        let number = Value::Integer(i64::try_from(self.number).unwrap_or(i64::MAX));
        let mut parts = vec![Value::symbol(HEAD), number, Value::text(&self.words)];
        match end {
            CommandEnd::Accepted { .. } => parts.push(Value::symbol("accepted")),
            CommandEnd::Rejected { reason } => parts.extend([Value::symbol("rejected"), Value::text(reason)]),
            CommandEnd::Expired { reason } => parts.extend([Value::symbol("expired"), Value::text(reason)]),
        }
        if let Some(Author { actor, epoch }) = &self.author {
            parts.extend([Value::symbol(BY), Value::text(&actor.name)]);
            let epoch = epoch.map(|epoch| Value::Integer(i64::try_from(epoch).unwrap_or(i64::MAX)));
            parts.extend(epoch.into_iter().flat_map(|epoch| [Value::symbol(":epoch"), epoch]));
        }
        if let Order::Input(_, EventKind::OperatorAnswered(question, _)) = &self.order {
            let question = Value::Integer(i64::try_from(question.0).unwrap_or(i64::MAX));
            parts.extend([Value::symbol(ANSWERS), question]);
        }
        if let Order::Acknowledge(alarm) = &self.order {
            parts.extend([Value::symbol(ALARM), Value::text(alarm)]);
        }
        EventKind::Occurrence(Value::list(parts))
    }
}

/// Returns the author of the accepted command that answered a question, from the event that records it; `None` for every other event.
pub(crate) fn author_of_answer(kind: &EventKind, question: u64) -> Option<String> {
    let EventKind::Occurrence(form) = kind else { return None };
    let [head, _, _, end, rest @ ..] = form.as_list()? else { return None };
    if !head.as_symbol()?.is(HEAD) || !end.as_symbol()?.is("accepted") {
        return None;
    }
    let answers = matches!(after(rest, ANSWERS)?, Value::Integer(number) if u64::try_from(*number) == Ok(question));
    match after(rest, BY)? {
        Value::Text(name) if answers => Some(name.to_string()),
        _ => None,
    }
}

/// Returns the alarm that a command acknowledges, from the parts of its event after the end of the command.
pub(crate) fn acknowledged_alarm(rest: &[Value]) -> Option<&str> {
    match after(rest, ALARM)? {
        Value::Text(alarm) => Some(alarm),
        _ => None,
    }
}

/// Returns the value after a keyword.
fn after<'v>(rest: &'v [Value], keyword: &str) -> Option<&'v Value> {
    let mut pairs = rest.iter().zip(rest.iter().skip(1));
    pairs.find(|(word, _)| word.as_symbol().is_some_and(|word| word.is(keyword))).map(|(_, value)| value)
}

impl PartialEq for Command {
    fn eq(&self, other: &Command) -> bool {
        Arc::ptr_eq(&self.ticket.end, &other.ticket.end)
    }
}

impl Drop for Command {
    fn drop(&mut self) {
        // Commands that the run has not received when it ends are rejected.
        self.ticket.settle(CommandEnd::Rejected { reason: "the flight ended before it received the command".into() });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run_settings::Control;
    use std::sync::mpsc::channel;

    #[test]
    fn a_command_whose_time_is_over_is_not_accepted() {
        let accepted = CommandEnd::Accepted { at: Time::from_seconds(3.0) };
        let ticket = Ticket::valid_until(Instant::now(), "2 s are over");
        assert!(!ticket.settle(accepted.clone()));
        assert_eq!(ticket.end(), Some(CommandEnd::Expired { reason: "2 s are over".into() }));
        let ticket = Ticket::valid_until(Instant::now() + std::time::Duration::from_secs(60), "60 s are over");
        assert!(ticket.settle(accepted.clone()));
        assert_eq!(ticket.end(), Some(accepted));
    }

    #[test]
    fn the_author_of_an_answer_is_that_of_the_accepted_command_which_answers_the_question() {
        use crate::authority::ActorRole;
        use apex_model::effect::QuestionId;
        let answer =
            |question: u64| Order::Input(None, EventKind::OperatorAnswered(QuestionId(question), Value::nil()));
        let given = |order: Order, name: Option<&str>| Command {
            number: 1,
            words: "answers question 3".into(),
            order,
            author: name
                .map(|name| Author { actor: Actor { name: name.into(), role: ActorRole::Operator }, epoch: Some(3) }),
            ticket: Ticket::default(),
        };
        let accepted = CommandEnd::Accepted { at: Time::ZERO };
        let rejected = CommandEnd::Rejected { reason: "no".into() };
        let author = |command: Command, end: &CommandEnd| author_of_answer(&command.entry(end), 3);
        assert_eq!(author(given(answer(3), Some("ann")), &accepted).as_deref(), Some("ann"));
        assert_eq!(author(given(answer(3), Some("ann")), &rejected), None);
        assert_eq!(author(given(answer(4), Some("ann")), &accepted), None);
        assert_eq!(author(given(answer(3), None), &accepted), None);
        assert_eq!(author(given(Order::Note, Some("ann")), &accepted), None);
    }

    #[test]
    fn a_command_that_the_run_does_not_take_is_rejected_at_its_end() {
        let ticket = Ticket::default();
        let command =
            Command { number: 1, words: "late".into(), order: Order::Note, author: None, ticket: ticket.clone() };
        let (operators, controls) = channel();
        operators.send(Control::Command(Arc::new(command))).unwrap();
        drop((operators, controls));
        let end = ticket.end().unwrap();
        assert!(matches!(&end, CommandEnd::Rejected { reason } if reason.contains("ended before")), "{end:?}");
        assert!(!ticket.settle(CommandEnd::Expired { reason: String::new() }), "one end only");
    }
}
