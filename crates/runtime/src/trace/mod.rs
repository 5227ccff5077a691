//! The trace: every input, decision and output as one line, as JSON for programs or as text for operators.
//!
//! During a run the trace is an observer; afterwards [`trace_record`] makes the same lines from a flight record.

mod field;
mod filter;
mod line;

pub use field::seconds_text;
pub use filter::{KINDS, TraceFilter};

use crate::effect_describer::EffectDescriber;
use crate::error::RecordError;
use crate::ports::Observer;
use crate::record::RecordReader;
use apex_model::effect::{DecisionKind, Effect, Method};
use apex_model::event::{Batch, EventKind, Message};
use apex_model::library::{AgentDeclaration, Library};
use apex_model::task::TaskId;
use apex_model::time::Time;
use line::TraceLine;
use std::collections::BTreeMap;
use std::io::{self, Write};
use std::sync::Arc;

/// Format of lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TraceFormat {
    /// One JSON object per line; keys in a fixed order.
    JsonLines,
    /// One aligned sentence a line.
    Text,
}

/// Writes the trace of a run to `out`.
pub struct Tracer<W: Write> {
    out: W,
    format: TraceFormat,
    filter: TraceFilter,
    agents: Vec<AgentTrace>,
    /// Agent whose steps are written.
    turn: usize,
}

/// State of an agent that its lines need.
struct AgentTrace {
    /// Its name, where several agents run.
    name: Option<Arc<str>>,
    describer: EffectDescriber,
    tasks: BTreeMap<TaskId, Ancestry>,
}

/// State of a task that the filter by procedure needs.
#[derive(Default)]
struct Ancestry {
    parent: Option<TaskId>,
    method: Option<String>,
}

impl<W: Write> Tracer<W> {
    /// Returns a tracer for a run of `library` with all of its agents, from the run's first step on.
    pub fn new(out: W, format: TraceFormat, filter: TraceFilter, library: &Library) -> Tracer<W> {
        let several = library.has_several_agents();
        let agent = |agent: &AgentDeclaration| AgentTrace {
            name: several.then(|| Arc::from(agent.name.printed())),
            describer: EffectDescriber::new(library),
            tasks: BTreeMap::new(),
        };
        let agents = library.crew().iter().map(agent).collect();
        Tracer { out, format, filter, agents, turn: 0 }
    }

    /// Writes the rest and gives the output back.
    ///
    /// # Errors
    /// The output's own.
    pub fn into_inner(mut self) -> io::Result<W> {
        self.out.flush()?;
        Ok(self.out)
    }

    fn trace(&mut self, batch: &Batch, effects: &[Effect]) -> io::Result<()> {
        let Some(agent) = self.agents.get_mut(self.turn) else { return Ok(()) };
        agent.describer.hear(batch);
        for event in &batch.events {
            let is_sample =
                matches!(event.kind, EventKind::Measurement(..) | EventKind::Told(_, Message::Measurement(..)));
            // Most events are samples: those that the filter refuses by their kind or time are not put into words.
            if is_sample && !self.filter.admits_kind(line::MEASUREMENT, event.at) {
                continue;
            }
            self.write_own(TraceLine::of_event(event))?;
        }
        for effect in effects {
            let Some(agent) = self.agents.get_mut(self.turn) else { return Ok(()) };
            if self.filter.place.is_some() {
                agent.remember(effect);
            }
            let told = agent.describer.tell(effect);
            let line = TraceLine::of_effect(batch.now, effect, &told, &agent.describer);
            self.write_own(line)?;
        }
        Ok(())
    }

    /// Writes a line of the agent whose step it is.
    fn write_own(&mut self, mut line: TraceLine) -> io::Result<()> {
        line.agent = self.agents.get(self.turn).and_then(|agent| agent.name.clone());
        self.write(&line)
    }

    fn write(&mut self, line: &TraceLine) -> io::Result<()> {
        if !self.filter.admits(line) || !self.is_of_procedure(line) {
            return Ok(());
        }
        match self.format {
            TraceFormat::JsonLines => line.write_json(&mut self.out)?,
            TraceFormat::Text => self.out.write_all(line.text().as_bytes())?,
        }
        self.out.write_all(b"\n")
    }

    /// Returns true if the filter of places admits the effect: lines caused by the procedure's own text, by its tasks, or by the tasks of
    /// its steps.
    fn is_of_procedure(&self, line: &TraceLine) -> bool {
        let Some(place) = &self.filter.place else { return true };
        let Some(agent) = self.agents.get(self.turn) else { return true };
        let own = line.task.and_then(|task| agent.tasks.get(&task));
        let parent = own.and_then(|own| own.parent).and_then(|parent| agent.tasks.get(&parent));
        let methods = [own, parent].into_iter().flatten().filter_map(|ancestry| ancestry.method.as_deref());
        methods.chain(line.place.as_deref()).any(|found| filter::is_place_within(found, place))
    }
}

impl AgentTrace {
    fn remember(&mut self, effect: &Effect) {
        let Effect::Decided(decision) = effect else { return };
        let Some(task) = decision.task else { return };
        match &decision.kind {
            DecisionKind::Created { parent, .. } => {
                self.tasks.insert(task, Ancestry { parent: *parent, method: None });
            }
            DecisionKind::Selected { method: Method::Procedure(place) | Method::Primitive(place), .. } => {
                self.tasks.entry(task).or_default().method = Some(self.describer.place(*place));
            }
            _ => {}
        }
    }
}

impl<W: Write> Observer for Tracer<W> {
    fn turn(&mut self, agent: usize) -> Result<(), String> {
        self.turn = agent;
        Ok(())
    }

    fn observe(&mut self, batch: &Batch, effects: &[Effect]) -> Result<(), String> {
        self.trace(batch, effects).map_err(|error| unwritable(&error))
    }

    fn note(&mut self, at: Time, text: &str) -> Result<(), String> {
        self.write(&TraceLine::of_note(at, text)).map_err(|error| unwritable(&error))
    }

    fn flush(&mut self) -> Result<(), String> {
        self.out.flush().map_err(|error| unwritable(&error))
    }
}

fn unwritable(error: &io::Error) -> String {
    format!("the trace cannot be written: {error}; check where it goes, and the space there")
}

/// Writes the trace of a recorded flight to `out`.
///
/// # Errors
/// [`RecordError`] when the record cannot be read or the trace not written.
pub fn trace_record<W: Write>(
    reader: &RecordReader,
    out: W,
    format: TraceFormat,
    filter: TraceFilter,
) -> Result<W, RecordError> {
    let library = Library { sources: reader.pdl_sources()?, agents: reader.stand_ins(), ..Library::default() };
    let to = filter.to.unwrap_or(Time::END);
    let mut tracer = Tracer::new(out, format, filter, &library);
    let failed = |error: io::Error| RecordError::Question(unwritable(&error));
    let mut notes = reader.notes()?.into_iter().peekable();
    for step in reader.steps_of_all(to)? {
        let step = step?;
        while let Some((at, text)) = notes.next_if(|(at, _)| *at < step.batch.now) {
            tracer.write(&TraceLine::of_note(at, &text)).map_err(failed)?;
        }
        let effects = step.decoded_effects().map_err(|what| reader.garbled(what))?;
        tracer.turn = step.agent;
        tracer.trace(&step.batch, &effects).map_err(failed)?;
    }
    for (at, text) in notes {
        tracer.write(&TraceLine::of_note(at, &text)).map_err(failed)?;
    }
    tracer.into_inner().map_err(failed)
}

#[cfg(test)]
mod tests;
