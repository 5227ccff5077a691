//! The agent, with its instants and rounds.
//!
//! An instant is one cycle of the phases record, notice, enable, choose, contend, commit, act, repeated until nothing changes. All inputs
//! of an instant arrive before its first round.

use crate::program::{Program, Time};
use crate::task::{Alarm, Outcome, State, Task, Work};
use crate::trace::{Cut, Line, Run, What};
use crate::value::Value;
use std::collections::{BTreeMap, BTreeSet, VecDeque};

/// Rounds of one instant before it counts as restless.
const ROUNDS_MAX: u32 = 120;
/// Tasks in one run before the reference stops.
const TASKS_MAX: usize = 300;
/// Tasks created at one instant before the reference stops, because all compete with all in every round.
const TASKS_PER_INSTANT_MAX: usize = 100;

/// An input: a message or a measurement.
#[derive(Clone, Debug, PartialEq)]
pub enum Said {
    /// A message.
    Message(Vec<Value>),
    /// A sample: attribute, object, value.
    Sample(String, String, Value),
}

/// An input from outside the agent.
#[derive(Clone, Debug, PartialEq)]
pub struct Input {
    /// Arrival.
    pub arrives: Time,
    /// Instant of the event: the arrival or before.
    pub at: Time,
    /// Content.
    pub said: Said,
}

/// A remembered message.
pub(crate) struct Message {
    pub(crate) at: Time,
    pub(crate) arrival: u64,
    pub(crate) words: Vec<Value>,
}

/// A remembered sample.
pub(crate) struct Sample {
    pub(crate) at: Time,
    pub(crate) arrival: u64,
    pub(crate) attribute: String,
    pub(crate) object: String,
    pub(crate) value: Value,
}

/// A remembered change of state.
pub(crate) struct Move {
    pub(crate) task: usize,
    pub(crate) from: State,
    pub(crate) to: State,
    pub(crate) at: Time,
}

/// A remembered change of a variable that had a value.
pub(crate) struct Change {
    /// Owner of the variable.
    pub(crate) task: usize,
    pub(crate) name: String,
    pub(crate) before: Value,
    /// Position in the order of watches.
    pub(crate) number: u64,
    /// The messages and samples before this one have been noticed.
    pub(crate) noticed: u64,
}

pub(crate) struct Agent<'p> {
    pub(crate) program: &'p Program,
    pub(crate) now: Time,
    /// Arrival of the newest input: events caused by a late input are reported then.
    arrived: Time,
    pub(crate) tasks: Vec<Task>,
    pub(crate) messages: Vec<Message>,
    pub(crate) samples: Vec<Sample>,
    pub(crate) moves: Vec<Move>,
    pub(crate) changes: Vec<Change>,
    /// The number of the first message or sample that no task has noticed.
    pub(crate) noticed: u64,
    /// The number of the next message or sample.
    pub(crate) arrivals: u64,
    /// Messages of the agent to itself, recorded in the next round.
    pub(crate) said: Vec<Said>,
    /// Total of each resource.
    pub(crate) totals: BTreeMap<String, f64>,
    /// Tasks that became ongoing in this round, in order.
    pub(crate) starting: Vec<usize>,
    /// Tasks that continue in the next round unless they start over.
    pub(crate) resuming: BTreeSet<usize>,
    /// Tasks that ended and whose parents have not reacted yet.
    pub(crate) ended: VecDeque<usize>,
    /// Reasons for which suspended tasks resume in this round.
    pub(crate) resumed: BTreeMap<usize, String>,
    /// Competition at the last decision of the arbiter.
    pub(crate) competed: Option<crate::competition::Competition>,
    /// The next number of an alarm or a watch.
    pub(crate) serial: u64,
    pub(crate) lines: Vec<Line>,
    /// True if anything was done in this round.
    pub(crate) changed: bool,
    pub(crate) finished: bool,
    pub(crate) cut: Option<Cut>,
    /// Ends of steps while earlier steps of their sequence have not ended.
    pub(crate) early_ends: u64,
}

/// Runs `program` with `inputs`, in order of arrival, up to `until`.
pub fn run(program: &Program, inputs: &[Input], until: Time) -> Run {
    let program = &crate::creation::with_ends(program);
    let totals = program.resources.iter().map(|resource| (resource.name.clone(), resource.amount));
    let mut agent = Agent {
        program,
        now: 0,
        arrived: 0,
        tasks: Vec::new(),
        messages: Vec::new(),
        samples: Vec::new(),
        moves: Vec::new(),
        changes: Vec::new(),
        noticed: 0,
        arrivals: 0,
        said: Vec::new(),
        totals: totals.collect(),
        starting: Vec::new(),
        resuming: BTreeSet::new(),
        ended: VecDeque::new(),
        resumed: BTreeMap::new(),
        competed: None,
        serial: 0,
        lines: Vec::new(),
        changed: false,
        finished: false,
        cut: None,
        early_ends: 0,
    };
    agent.live(inputs, until);
    agent.told()
}

impl Agent<'_> {
    fn live(&mut self, inputs: &[Input], until: Time) {
        let mut inputs = inputs;
        let root = self.create(None, crate::task::Origin::Root);
        self.tasks[root].waits_for_condition = false;
        let mut begun = false;
        loop {
            let arrival = inputs.first().map(|input| input.arrives);
            let next = if begun { arrival.into_iter().chain(self.next_alarm()).min() } else { Some(0) };
            let Some(next) = next.filter(|next| *next <= until) else { return };
            self.arrived = next;
            let present = inputs.iter().take_while(|input| input.arrives <= next).count();
            let (batch, later) = inputs.split_at(present);
            inputs = later;
            self.pass(batch, next, begun);
            begun = true;
            if self.finished || self.cut.is_some() {
                return;
            }
        }
    }

    /// Executes all instants up to `end`: those of the inputs, and those of scheduled events. Late inputs count at the present instant.
    fn pass(&mut self, batch: &[Input], end: Time, begun: bool) {
        let mut batch = batch;
        let mut begun = begun;
        while !self.finished && self.cut.is_none() {
            let input = batch.first().map(|input| input.at.max(self.now).min(end));
            let alarm = if begun { self.next_alarm().filter(|at| *at <= end) } else { Some(0) };
            begun = true;
            let Some(instant) = input.into_iter().chain(alarm).min() else { return };
            let present = batch.iter().take_while(|input| input.at.max(self.now).min(end) <= instant).count();
            let (inputs, later) = batch.split_at(present);
            batch = later;
            self.now = instant;
            for input in inputs {
                self.record(input.said.clone(), input.at);
            }
            self.ring();
            self.come_to_rest();
        }
    }

    fn come_to_rest(&mut self) {
        let before = self.tasks.len();
        for _ in 0..ROUNDS_MAX {
            self.changed = false;
            for said in std::mem::take(&mut self.said) {
                self.changed = true;
                self.record(said, self.now);
            }
            self.noticed = self.arrivals;
            self.notice_and_enable();
            self.choose();
            self.contend_and_commit();
            self.settle();
            self.act();
            self.ring();
            if !self.changed || self.finished {
                return;
            }
            if self.tasks.len() > TASKS_MAX.min(before + TASKS_PER_INSTANT_MAX) {
                self.cut = Some(Cut::Long);
                return;
            }
        }
        self.cut = Some(Cut::Restless(self.arrived));
    }

    /// Remembers a message or a sample.
    fn record(&mut self, said: Said, at: Time) {
        let arrival = self.arrivals;
        self.arrivals += 1;
        match said {
            Said::Message(words) => {
                for task in self.tasks.iter_mut().filter(|task| !task.forgotten) {
                    let busy = task.watches.iter().all(|watch| watch.clause != crate::task::Clause::Waitfor);
                    if let Some(missed) = task.missed.as_mut().filter(|_| busy) {
                        missed.insert(arrival);
                    }
                }
                self.messages.push(Message { at, arrival, words });
            }
            Said::Sample(attribute, object, value) => {
                let repeated = |each: &&Sample| {
                    each.attribute == attribute && each.object == object && each.at == at && each.value == value
                };
                // The same value again at the same time is ignored.
                if self
                    .samples
                    .iter()
                    .rev()
                    .find(|each| each.attribute == attribute && each.object == object)
                    .filter(repeated)
                    .is_some()
                {
                    return;
                }
                let mut same = self.samples.iter().filter(|each| each.attribute == attribute && each.object == object);
                // A sample older than another one of its variable came too late.
                if same.all(|each| each.at <= at) {
                    self.samples.push(Sample { at, arrival, attribute, object, value });
                }
            }
        }
    }

    /// Returns the newest value of a state variable, including values published at this instant, which are not recorded yet.
    pub(crate) fn newest(&self, attribute: &str, object: &str) -> Option<Value> {
        let said = self.said.iter().rev().find_map(|said| match said {
            Said::Sample(of, what, value) if of == attribute && what == object => Some(value.clone()),
            _ => None,
        });
        let mut known = self.samples.iter().rev();
        let mut recorded = || known.find(|each| each.attribute == attribute && each.object == object);
        said.or_else(|| recorded().map(|sample| sample.value.clone()))
    }

    /// Returns every alarm that is set.
    fn alarms(&self) -> Vec<(Alarm, usize)> {
        let mut alarms = Vec::new();
        for (id, task) in self.living() {
            if let Some(Work::Primitive { end, update, .. }) = &task.work {
                alarms.extend(end.iter().chain(update).map(|alarm| (*alarm, id)));
            }
            alarms.extend(task.waits_for_interval.map(|alarm| (alarm, id)));
        }
        alarms.sort_unstable();
        alarms
    }

    /// Triggers every alarm that is due, in the order in which the alarms were set.
    fn ring(&mut self) {
        while let Some((alarm, id)) = self.alarms().first().copied().filter(|(alarm, _)| alarm.0 <= self.now) {
            self.changed = true;
            if self.tasks[id].waits_for_interval == Some(alarm) {
                self.tasks[id].waits_for_interval = None;
            } else {
                self.clock_rings(id, alarm);
            }
            self.settle();
        }
    }

    /// Returns the instant of the next event that needs no input.
    fn next_alarm(&self) -> Option<Time> {
        let clocks = self.alarms().into_iter().map(|(alarm, _)| alarm.0);
        let delays = self.delays_end();
        clocks.chain(delays).chain(self.priorities_cross()).filter(|at| *at > self.now).min()
    }

    /// Tasks that a clause may still refer to.
    pub(crate) fn living(&self) -> impl Iterator<Item = (usize, &Task)> {
        self.tasks.iter().enumerate().filter(|(_, task)| !task.forgotten)
    }

    pub(crate) fn ids(&self, wanted: impl Fn(&Task) -> bool) -> Vec<usize> {
        self.living().filter(|(_, task)| wanted(task)).map(|(id, _)| id).collect()
    }

    pub(crate) fn next_serial(&mut self) -> u64 {
        self.serial += 1;
        self.serial
    }

    pub(crate) fn tell(&mut self, task: usize, what: What) {
        self.lines.push(Line { at: self.arrived, task, what });
    }

    /// Changes the state of a task.
    pub(crate) fn transition(&mut self, id: usize, to: State, outcome: Option<Outcome>, cause: String) {
        self.changed = true;
        let from = self.tasks[id].state;
        if from == State::Ongoing {
            self.resuming.remove(&id);
        }
        let task = &mut self.tasks[id];
        task.state = to;
        if to == State::Ongoing && task.started_at.is_none() {
            task.started_at = Some(self.now);
        }
        self.moves.push(Move { task: id, from, to, at: self.now });
        let text = outcome.as_ref().map(Outcome::text);
        self.tasks[id].outcome = outcome;
        self.tell(id, What::Moved(from, to, text, cause));
    }

    fn told(self) -> Run {
        let states = self.living().map(|(id, task)| (id, task.state)).collect();
        let mut holders = BTreeSet::new();
        for (id, task) in self.living().filter(|(_, task)| task.state == State::Ongoing) {
            holders.extend(task.needs().into_iter().map(|(name, amount)| (name, id, amount.to_string())));
        }
        let totals = self.totals.iter().map(|(name, total)| (name.clone(), total.to_string())).collect();
        Run { lines: self.lines, states, holders, totals, cut: self.cut, early_ends: self.early_ends }
    }
}
