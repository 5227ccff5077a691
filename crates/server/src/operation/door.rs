//! The connection to a run in progress: numbers commands, sends them, and returns the end of each.

use crate::operation::authority::AuthorityState;
use crate::operation::request::Wish;
use crate::operation::watch::{FlightWatch, Seen, SeenState};
use apex_mission::Mission;
use apex_model::time::Time;
use apex_model::value::Value;
use apex_runtime::Control;
use apex_runtime::authority::{Actor, AuthorityBoard};
use apex_runtime::commands::{Author, Command, CommandEnd, Order, Ticket};
use serde::Serialize;
use std::collections::{BTreeMap, VecDeque};
use std::fmt;
use std::sync::mpsc::{self, Receiver, Sender};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Wall time after which a command that the run has not taken expires.
pub(crate) const EXPIRES_AFTER: Duration = Duration::from_secs(10);
/// Maximum number of commands that have no end yet.
const OPEN_MAX: usize = 16;
/// Maximum number of remembered commands with their ends; the record contains all.
const REMEMBERED_MAX: usize = 50;

/// Reads one PDL datum from text; the server itself has no parser.
pub type ReadDatum = Arc<dyn Fn(&str) -> Result<Value, String> + Send + Sync>;

/// A command with what its caller states about it.
pub(crate) struct CommandRequest {
    pub(crate) wish: Wish,
    pub(crate) author: Author,
    /// Time of the door's clock until which the run may accept the command, as the caller estimates it; `None`: not stated.
    pub(crate) valid_until: Option<Duration>,
    /// Reason for which the run is not to execute it; `None`: no objection.
    pub(crate) objection: Option<String>,
}

/// The connection to one run in progress. Clones share it.
#[derive(Clone)]
pub struct FlightDoor {
    shared: Arc<Shared>,
}

struct Shared {
    /// Zero of the door's clock.
    began: Instant,
    controls: Mutex<Sender<Control>>,
    seen: Seen,
    sent: Mutex<Sent>,
    /// Targets of the mission; true if a target is known from the start.
    targets: BTreeMap<String, bool>,
    read: ReadDatum,
    authority: AuthorityBoard,
}

struct Sent {
    last_number: u64,
    entries: VecDeque<SourceEntry>,
    /// The pace that was set before the first remembered command.
    pace: Option<f64>,
    /// The last pace above 0.
    running: Option<f64>,
}

struct SourceEntry {
    number: u64,
    words: String,
    by: String,
    order: Order,
    at: Instant,
    ticket: Ticket,
}

/// A command in the form of the API.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(crate) struct CommandState {
    number: u64,
    words: String,
    /// The name of its author.
    by: String,
    #[cfg_attr(test, ts(type = "'sent' | 'accepted' | 'rejected' | 'expired'"))]
    state: &'static str,
    at_ns: Option<i64>,
    reason: Option<String>,
    age_s: f64,
}

/// The run in the form of the API.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(crate) struct Operation {
    now_ns: i64,
    /// Milliseconds of the server's clock, from which callers compute `until_ms` of their commands.
    clock_ms: f64,
    /// Mission seconds per second of wall time; `None` is as fast as possible.
    pace: Option<f64>,
    paused: bool,
    #[serde(flatten)]
    seen: SeenState,
    targets: Vec<TargetNews>,
    commands: Vec<CommandState>,
    authority: AuthorityState,
}

/// Change of a target by an operator.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub(crate) struct TargetNews {
    id: String,
    /// True while the mission treats it as a target to observe.
    known: bool,
}

impl FlightDoor {
    /// Returns a door to a run of `mission` that begins at `pace`, and the receiver of the door's commands for the run.
    pub fn new(mission: &Mission, pace: Option<f64>, read: ReadDatum) -> (FlightDoor, Receiver<Control>) {
        let (controls, receiver) = mpsc::channel();
        let targets = mission
            .targets
            .iter()
            .filter(|target| target.is_observable())
            .map(|target| (target.id.clone(), !target.announced_late))
            .collect();
        let running = pace.filter(|pace| *pace > 0.0);
        let sent = Sent { last_number: 0, entries: VecDeque::new(), pace, running };
        let (controls, sent, seen) = (Mutex::new(controls), Mutex::new(sent), Seen::default());
        let began = Instant::now();
        let shared = Shared { began, controls, seen, sent, targets, read, authority: AuthorityBoard::default() };
        (FlightDoor { shared: Arc::new(shared) }, receiver)
    }

    /// Returns the authority over the run; the run needs it in its terms.
    pub fn authority(&self) -> AuthorityBoard {
        self.shared.authority.clone()
    }

    /// Notes a request of an actor: a holder of authority that sends requests is not silent.
    pub(crate) fn hear(&self, name: &str) {
        self.shared.authority.hear(name);
    }

    /// Returns the name of the holder of authority, if it is another actor.
    pub(crate) fn other_holder(&self, actor: &Actor) -> Option<String> {
        let authority = self.shared.authority.authority();
        authority.holder.as_ref().filter(|holder| holder.name != actor.name).map(|holder| holder.name.clone())
    }

    /// Sets the pace at which a paused run continues, until another one is chosen.
    pub fn continues_at(&self, pace: Option<f64>) {
        self.sent().running = pace;
    }

    /// Returns an observer that stores the events of the run for the door.
    pub fn watch(&self) -> FlightWatch {
        FlightWatch::new(self.shared.seen.clone())
    }

    /// Returns true until the run has ended. A paused run writes nothing for a long time, but is still in progress.
    pub(crate) fn is_under_way(&self) -> bool {
        !self.shared.seen.state().is_over
    }

    /// Ends the run in an orderly way. The record has no command of an operator for it.
    pub fn stop(&self) {
        self.say(Control::Stop);
    }

    /// Lets a paused run continue if no operator can do it any longer. The record has no command of an operator for it.
    pub fn resume(&self) {
        let running = self.sent().running;
        self.say(Control::Pace(running));
    }

    /// Informs the run that it need not wait for commands of operators.
    pub fn be_quiet(&self) {
        self.say(Control::Quiet);
    }

    fn say(&self, control: Control) -> bool {
        self.shared.controls.lock().unwrap_or_else(PoisonError::into_inner).send(control).is_ok()
    }

    fn sent(&self) -> MutexGuard<'_, Sent> {
        // Every update is complete when the lock is released, even by a panic, so a poisoned lock is usable.
        self.shared.sent.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Sends a command. It ends at once if it is certain that the run would not execute it.
    pub(crate) fn send(&self, request: CommandRequest) -> u64 {
        let CommandRequest { wish, author, valid_until, objection } = request;
        let at = Instant::now();
        let latest = at + EXPIRES_AFTER;
        let until = valid_until.and_then(|clock| self.shared.began.checked_add(clock)).unwrap_or(latest).min(latest);
        let limit = limit_words(until.saturating_duration_since(at));
        let seen = self.shared.seen.state();
        let running = self.sent().running;
        let known = |id: &str| self.is_known(id, &seen);
        let (order, mut refusal) = match wish.order(&seen, running, &known, &*self.shared.read) {
            Ok(order) => (order, None),
            Err(reason) => (Order::Note, Some(reason)),
        };
        refusal = objection.or(refusal);
        let mut sent = self.sent();
        sent.forget_old();
        if sent.entries.iter().filter(|entry| entry.ticket.end().is_none()).count() >= OPEN_MAX {
            refusal.get_or_insert_with(|| format!("{OPEN_MAX} commands are in progress already"));
        }
        sent.last_number += 1;
        let (number, words, ticket) = (sent.last_number, wish.words(), Ticket::valid_until(until, &limit));
        let by = author.actor.name.clone();
        let entry = SourceEntry { number, words: words.clone(), by, order: order.clone(), at, ticket };
        let command = Command { number, words, order, author: Some(author), ticket: entry.ticket.clone() };
        if let Some(reason) = refusal {
            // The run records a command that it is not to execute.
            command.ticket.settle(CommandEnd::Rejected { reason });
        }
        sent.entries.push_back(entry);
        // A command that no run takes settles itself.
        self.say(Control::Command(Arc::new(command)));
        number
    }

    /// Returns true if the target is to be observed now; `None` if the mission has no such target.
    fn is_known(&self, id: &str, seen: &SeenState) -> Option<bool> {
        let from_start = self.shared.targets.get(id)?;
        Some(seen.news.get(id).copied().unwrap_or(*from_start))
    }

    /// Returns the state of command `number`; an open one that is too old expires now.
    pub(crate) fn command(&self, number: u64) -> Option<CommandState> {
        self.sent().entries.iter().find(|entry| entry.number == number).map(SourceEntry::state)
    }

    /// Returns the present state of the run for an actor, who can offer authority to `stations`.
    pub(crate) fn operation(&self, actor: &Actor, stations: Vec<Actor>) -> Operation {
        let seen = self.shared.seen.state();
        let sent = self.sent();
        let pace = sent.pace_now();
        let targets = self
            .shared
            .targets
            .keys()
            .map(|id| TargetNews { id: id.clone(), known: self.is_known(id, &seen).unwrap_or_default() });
        Operation {
            now_ns: seen.now_ns,
            clock_ms: self.shared.began.elapsed().as_secs_f64() * 1e3,
            pace,
            paused: pace == Some(0.0),
            targets: targets.collect(),
            commands: sent.entries.iter().map(SourceEntry::state).collect(),
            authority: AuthorityState::of(&self.shared.authority, actor, &stations),
            seen,
        }
    }
}

impl Sent {
    /// Returns the pace after all commands that were accepted. Commands are executed in the order of their numbers.
    fn pace_now(&self) -> Option<f64> {
        self.entries.iter().fold(self.pace, SourceEntry::pace_after)
    }

    fn forget_old(&mut self) {
        for entry in &self.entries {
            if let (Order::Pace(Some(pace)), Some(CommandEnd::Accepted { .. })) = (&entry.order, entry.ticket.end())
                && *pace > 0.0
            {
                self.running = Some(*pace);
            }
        }
        while self.entries.len() >= REMEMBERED_MAX
            && let Some(oldest) = self.entries.pop_front()
        {
            self.pace = SourceEntry::pace_after(self.pace, &oldest);
        }
    }
}

impl SourceEntry {
    fn pace_after(before: Option<f64>, entry: &SourceEntry) -> Option<f64> {
        match (&entry.order, entry.ticket.end()) {
            (Order::Pace(pace), Some(CommandEnd::Accepted { .. })) => *pace,
            (Order::Step, Some(CommandEnd::Accepted { .. })) => Some(0.0),
            _ => before,
        }
    }

    fn state(&self) -> CommandState {
        self.ticket.expire();
        let (state, at_ns, reason) = match self.ticket.end() {
            None => ("sent", None, None),
            Some(CommandEnd::Accepted { at: Time(at) }) => ("accepted", Some(at), None),
            Some(CommandEnd::Rejected { reason }) => ("rejected", None, Some(reason)),
            Some(CommandEnd::Expired { reason }) => ("expired", None, Some(reason)),
        };
        let age_s = self.at.elapsed().as_secs_f64();
        let (words, by) = (self.words.clone(), self.by.clone());
        CommandState { number: self.number, words, by, state, at_ns, reason, age_s }
    }
}

/// Returns the reason of a command that expires this long after it reached the server.
fn limit_words(limit: Duration) -> String {
    match limit.is_zero() {
        true => "it reached the server after the time until which it was valid".to_string(),
        false => format!("the run did not accept it within {} s", (limit.as_secs_f64() * 100.0).round() / 100.0),
    }
}

impl CommandState {
    /// Returns true until the command has an end.
    pub(crate) fn is_open(&self) -> bool {
        self.state == "sent"
    }
}

impl fmt::Debug for FlightDoor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("FlightDoor").finish_non_exhaustive()
    }
}
