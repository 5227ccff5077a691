//! The knowledge at an instant, from all arrivals so far (rules 4, 17, 18, 23).

use crate::condition::{Span, Time};
use crate::value::Value;
use std::collections::BTreeMap;

/// Something that arrived.
#[derive(Clone, Debug, PartialEq)]
pub struct Arrival {
    /// Instant of arrival.
    pub arrives: Time,
    /// Instant of the measurement or event; at most the arrival.
    pub at: Time,
    /// Content.
    pub what: What,
}

/// Kinds of arrivals.
#[derive(Clone, Debug, PartialEq)]
pub enum What {
    /// A sample of `(attribute object)`; `None` is a missing measurement, and NaN is read as missing.
    Sample(String, String, Option<Value>),
    /// A message.
    Message(Vec<Value>),
    /// A task was created, or changed its state to this.
    Moved(String, String),
}

/// The cleaned past of one variable, object or agent, as known at an instant.
#[derive(Clone, Debug, Default)]
pub(crate) struct Past {
    /// The instant of the knowledge: all arrivals up to it are included.
    pub(crate) known_at: Time,
    /// Samples by attribute and object.
    pub(crate) variables: Vec<Series>,
    /// Messages in order of time; at equal instants, in order of arrival.
    pub(crate) messages: Vec<Message>,
    /// Changes of tasks.
    pub(crate) moves: Vec<Move>,
}

/// A variable's samples in order of time, one for each instant.
#[derive(Clone, Debug)]
pub(crate) struct Series {
    pub(crate) attribute: String,
    pub(crate) object: String,
    pub(crate) samples: Vec<Sample>,
    /// Instant and arrival number of all arrivals that counted when they came.
    pub(crate) appearances: Vec<(Time, usize)>,
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Sample {
    pub(crate) at: Time,
    pub(crate) value: Value,
}

#[derive(Clone, Debug)]
pub(crate) struct Message {
    pub(crate) at: Time,
    pub(crate) words: Vec<Value>,
}

#[derive(Clone, Debug)]
pub(crate) struct Move {
    pub(crate) at: Time,
    pub(crate) task: String,
    pub(crate) state: String,
}

/// Returns all that had arrived by `now`. `lateness` is by attribute; 0 for attributes not in it.
pub(crate) fn known(arrivals: &[Arrival], lateness: &BTreeMap<String, Span>, now: Time) -> Past {
    let mut past = Past { known_at: now, ..Past::default() };
    for (number, arrival) in arrivals.iter().enumerate().filter(|(_, arrival)| arrival.arrives <= now) {
        let at = arrival.at;
        match &arrival.what {
            // Rule 18: a missing measurement proves nothing and is treated as if nothing had arrived.
            What::Sample(_, _, None) => {}
            What::Sample(attribute, object, Some(value)) => {
                let late = lateness.get(attribute).copied().unwrap_or(0);
                let sample = Sample { at, value: value.clone() };
                past.series(attribute, object).add(sample, number, late);
            }
            What::Message(words) => past.messages.push(Message { at, words: words.clone() }),
            What::Moved(task, state) => past.moves.push(Move { at, task: task.clone(), state: state.clone() }),
        }
    }
    past.messages.sort_by_key(|message| message.at);
    past
}

impl Past {
    /// Returns the part that had happened by `now`.
    pub(crate) fn up_to(&self, now: Time) -> Past {
        let mut past = self.clone();
        past.variables.iter_mut().for_each(|series| series.samples.retain(|sample| sample.at <= now));
        past.variables.retain(|series| !series.samples.is_empty());
        past.messages.retain(|message| message.at <= now);
        past.moves.retain(|each| each.at <= now);
        past
    }

    fn series(&mut self, attribute: &str, object: &str) -> &mut Series {
        let found = self.variables.iter().position(|each| each.attribute == attribute && each.object == object);
        let index = found.unwrap_or_else(|| {
            let series = Series {
                attribute: attribute.into(),
                object: object.into(),
                samples: Vec::new(),
                appearances: Vec::new(),
            };
            self.variables.push(series);
            self.variables.len() - 1
        });
        &mut self.variables[index]
    }
}

impl Series {
    /// Rule 17: a late sample is inserted in order if the newest one is ahead of it by at most the lateness; otherwise it does not count.
    /// Of two samples at one instant the later arrival counts; the same value again is ignored.
    fn add(&mut self, sample: Sample, number: usize, lateness: Span) {
        let newest = self.samples.iter().map(|known| known.at).max();
        if newest.is_some_and(|newest| newest - sample.at > lateness) {
            return;
        }
        self.appearances.push((sample.at, number));
        match self.samples.iter_mut().find(|known| known.at == sample.at) {
            Some(known) if known.value == sample.value => {}
            Some(known) => *known = sample,
            None => self.samples.push(sample),
        }
        self.samples.sort_by_key(|sample| sample.at);
    }
}
