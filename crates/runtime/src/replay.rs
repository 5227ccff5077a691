//! Replay: executes the recorded inputs again and compares every effect byte for byte. Solvers never run again; their
//! answers are inputs.

use crate::error::RecordError;
use crate::narrator::{Narrator, Told};
use crate::record::{LoadProgram, RecordReader, RecordedStep};
use apex_executive::step;
use apex_model::effect::Effect;
use apex_model::time::Time;
use std::fmt;

/// What replay found.
#[derive(Clone, Debug, PartialEq)]
pub struct ReplayReport {
    /// Steps executed again.
    pub batches: u64,
    /// Effects compared.
    pub effects: u64,
    /// The last instant that was executed.
    pub end: Time,
    /// The first difference; none when the record is confirmed.
    pub difference: Option<Difference>,
}

/// The first effect that differs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// When.
    pub at: Time,
    /// In which batch.
    pub batch: i64,
    /// Its position among the step's effects, from 1.
    pub position: usize,
    /// The recorded effect in words; none when the record has no more.
    pub recorded: Option<String>,
    /// The effect of the replay in words; none when it made no more.
    pub replayed: Option<String>,
}

impl fmt::Display for ReplayReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(difference) = &self.difference else {
            return write!(
                f,
                "The record is confirmed: {} steps up to {} gave the same {} effects.",
                self.batches, self.end, self.effects
            );
        };
        let Difference { at, batch, position, recorded, replayed } = difference;
        let words = |side: &Option<String>| side.clone().unwrap_or_else(|| "nothing".into());
        write!(
            f,
            "The replay differs at {at}, batch {batch}, effect {position}:\n  recorded: {}\n  replayed: {}",
            words(recorded),
            words(replayed)
        )
    }
}

/// Executes all recorded batches of all agents again, up to the first difference.
///
/// # Errors
/// [`RecordError`] when the record cannot be read or its mission not loaded.
pub fn replay(reader: &RecordReader, load: LoadProgram<'_>) -> Result<ReplayReport, RecordError> {
    let program = reader.load(load)?;
    let mut agents = Vec::new();
    for agent in 0..reader.agents().len().max(1) {
        agents.push((reader.fresh_agent_number(&program, agent)?, Narrator::new(&program.0)));
    }
    let mut report = ReplayReport { batches: 0, effects: 0, end: Time::ZERO, difference: None };
    for recorded in reader.steps_of_all(Time::END)? {
        let recorded = recorded?;
        let Some((agent, narrator)) = agents.get_mut(recorded.agent) else {
            return Err(reader.garbled(format!("batch {} is of an agent that does not exist", recorded.batch_number)));
        };
        let effects = step(agent, &recorded.batch);
        narrator.hear(&recorded.batch);
        report.batches += 1;
        report.effects += effects.len() as u64;
        report.end = recorded.batch.now;
        report.difference = compare(&recorded, &effects, narrator);
        if report.difference.is_some() {
            break;
        }
    }
    Ok(report)
}

fn compare(recorded: &RecordedStep, effects: &[Effect], narrator: &mut Narrator) -> Option<Difference> {
    let longest = recorded.effects.len().max(effects.len());
    for index in 0..longest {
        let (stored, made) = (recorded.effects.get(index), effects.get(index));
        let same = match (stored, made) {
            (Some(stored), Some(made)) => postcard::to_stdvec(made).is_ok_and(|body| body == stored.body),
            _ => false,
        };
        if !same {
            let mut twin = narrator.clone();
            let recorded_words = stored.map(|stored| match stored.effect() {
                Ok(effect) => words(&twin.tell(&effect)),
                Err(fault) => fault,
            });
            let replayed_words = made.map(|made| words(&narrator.tell(made)));
            // Words that say the same leave the reader helpless: show everything then.
            let (recorded_words, replayed_words) = if recorded_words == replayed_words {
                let whole = |effect: &Effect| format!("{effect:?}");
                (stored.and_then(|stored| stored.effect().ok()).as_ref().map(whole), made.map(whole))
            } else {
                (recorded_words, replayed_words)
            };
            return Some(Difference {
                at: recorded.batch.now,
                batch: recorded.batch_number,
                position: index + 1,
                recorded: recorded_words,
                replayed: replayed_words,
            });
        }
        if let Some(made) = made {
            narrator.tell(made);
        }
    }
    None
}

/// `transition T3 (power-up camera-1): enabled -> ongoing; it was granted camera-1; from file.pdl:14:3`
fn words(told: &Told) -> String {
    let mut words = told.kind.to_owned();
    if let Some(task) = told.task {
        words.push_str(&format!(" {task} {}", told.goal));
    }
    if let (Some(from), Some(to)) = (told.from, told.to) {
        words.push_str(&format!(": {from} -> {to}"));
    } else if !told.subject.is_empty() {
        words.push_str(&format!(": {}", told.subject));
    }
    for part in [told.outcome, Some(&*told.text)].into_iter().flatten().filter(|part| !part.is_empty()) {
        words.push_str(&format!("; {part}"));
    }
    if let Some(place) = &told.place {
        words.push_str(&format!("; from {place}"));
    }
    words
}
