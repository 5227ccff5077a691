//! Continues a recorded flight from an instant on. The recorded steps are executed again, and the vehicle obeys the recorded commands
//! again, so that agents, vehicle and mission are in the state of that instant; from there on the flight is live.
//!
//! Requests that are open at the instant keep their recorded answers, because these were computed from the situation before it.

use crate::agent_group::Numbering;
use crate::error::{RecordError, RunError};
use crate::flight::{Flight, OpenAnswer};
use crate::outbox;
use crate::pool::SolverPool;
use crate::ports::{Deliberator, Input, Observer, Posed, SolverAnswer, Vehicle};
use crate::record::{ProblemRow, RecordReader, RecordedStep, RestoredProgram};
use crate::run_settings::{RunEnd, RunSettings};
use crate::solver_thread::SolverThread;
use apex_executive::{Agent, step};
use apex_model::effect::{Effect, SolveRequest, SolveRequestId};
use apex_model::event::{EventKind, SolverReport};
use apex_model::time::{Duration, Time};
use std::collections::BTreeMap;
use thiserror::Error;

/// Reason for which a recorded flight cannot be continued.
#[derive(Debug, Error)]
pub enum ForkError {
    /// The record cannot be read.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// The continued flight stopped before its end.
    #[error(transparent)]
    Run(#[from] RunError),
    /// This program does not repeat the recorded decisions.
    #[error(
        "the recorded step of batch {batch} at {at} gives other effects now: the record was written by another version of Apex; `apex replay` shows the first difference"
    )]
    OtherDecisions {
        /// Instant.
        at: Time,
        /// The batch's number.
        batch: i64,
    },
    /// The simulated vehicle does not repeat the recorded measurements.
    #[error(
        "the simulated vehicle does not repeat the record at {at}: it reports {simulated}, which the record does not hold there"
    )]
    OtherVehicle {
        /// Instant.
        at: Time,
        /// Report of the simulated vehicle.
        simulated: String,
    },
}

/// Executes the steps of `reader` up to `at` again, applies `change` to the vehicle, and continues with `options`.
///
/// The observers receive all steps from the beginning, so that a recorder writes a whole record. Of `options.inputs`, those later than
/// `at` are used.
///
/// # Errors
/// [`ForkError`].
pub fn fork<V: Vehicle>(
    (reader, program): (&RecordReader, &RestoredProgram),
    at: Time,
    vehicle: &mut V,
    change: impl FnOnce(&mut V),
    deliberator: &mut dyn Deliberator,
    observers: &mut [&mut dyn Observer],
    options: RunSettings,
) -> Result<RunEnd, ForkError> {
    let mut agents = Vec::new();
    for agent in 0..reader.agents().len().max(1) {
        agents.push(reader.fresh_agent_number(program, agent)?);
    }
    let mut past = Past::new(reader, agents.len())?;
    for recorded in reader.steps_of_all(at)? {
        past.repeat(&recorded?, &mut agents, vehicle, deliberator, observers)?;
    }
    past.show_notes(at, observers)?;
    let Past { problems, open, last_sequences, steps, events, effects, .. } = past;
    change(vehicle);
    let queue = Box::new(SolverThread::new(options.solver_timeout));
    let mut flight = Flight::new(step, &mut agents, vehicle, deliberator, observers, queue, options)?;
    let (answered, unanswered) = split(open, &problems);
    flight.resume(at, &last_sequences, answered);
    for (request, asked, posed) in unanswered {
        flight.ask_again(&request, posed.job, asked)?;
    }
    let reason = flight.run()?;
    let end = flight.close(reason)?;
    Ok(RunEnd { steps: end.steps + steps, events: end.events + events, effects: end.effects + effects, ..end })
}

type OpenRequests = BTreeMap<SolveRequestId, (SolveRequest, Time, Posed)>;

/// Splits open requests into those with a recorded answer and those without.
fn split(
    open: OpenRequests,
    problems: &BTreeMap<SolveRequestId, ProblemRow>,
) -> (Vec<OpenAnswer>, Vec<(SolveRequest, Time, Posed)>) {
    let (mut answered, mut unanswered) = (Vec::new(), Vec::new());
    for (id, (request, asked, posed)) in open {
        match problems.get(&id).and_then(|row| row.answer.clone()) {
            Some((due, report)) => {
                answered.push(OpenAnswer { solver: request.solver, request: id, due, report });
            }
            None => unanswered.push((request, asked, posed)),
        }
    }
    (answered, unanswered)
}

/// The recorded part of the flight.
struct Past {
    problems: BTreeMap<SolveRequestId, ProblemRow>,
    /// Requests without an answer so far.
    open: OpenRequests,
    /// Reports of the vehicle that no batch has held yet.
    reported: Vec<Input>,
    /// Notes of the record that are still to be shown, the latest first.
    notes: Vec<(Time, String)>,
    last_sequences: Vec<u64>,
    /// Only for cancellations: the requests of the past are answered by the record.
    pool: SolverPool,
    steps: u64,
    events: u64,
    effects: u64,
}

impl Past {
    fn new(reader: &RecordReader, agents: usize) -> Result<Past, RecordError> {
        let mut notes = reader.notes()?;
        notes.reverse();
        Ok(Past {
            problems: reader.problems()?.into_iter().map(|row| (row.request, row)).collect(),
            open: OpenRequests::new(),
            reported: Vec::new(),
            notes,
            last_sequences: vec![0; agents],
            pool: SolverPool::new(Box::new(SolverThread::new(std::time::Duration::ZERO))),
            steps: 0,
            events: 0,
            effects: 0,
        })
    }

    /// Executes one recorded step again, with the vehicle and the observers.
    fn repeat(
        &mut self,
        recorded: &RecordedStep,
        agents: &mut [Agent],
        vehicle: &mut dyn Vehicle,
        deliberator: &mut dyn Deliberator,
        observers: &mut [&mut dyn Observer],
    ) -> Result<(), ForkError> {
        let (index, now) = (recorded.agent, recorded.batch.now);
        let several = agents.len() > 1;
        self.show_notes(Time(now.0 - 1), observers)?;
        self.advance(vehicle, recorded)?;
        let Some(agent) = agents.get_mut(index) else { return Ok(()) };
        each(observers, now, |observer| if several { observer.turn(index) } else { Ok(()) })?;
        each(observers, now, |observer| observer.begin(&recorded.batch))?;
        let effects = step(agent, &recorded.batch);
        let same = effects.len() == recorded.effects.len()
            && effects
                .iter()
                .zip(&recorded.effects)
                .all(|(made, stored)| postcard::to_stdvec(made).is_ok_and(|body| body == stored.body));
        if !same {
            return Err(ForkError::OtherDecisions { at: now, batch: recorded.batch_number });
        }
        each(observers, now, |observer| observer.observe(&recorded.batch, &effects))?;
        deliberator.observe(index, &recorded.batch, &effects);
        self.send(&effects, Numbering::new(index, self.last_sequences.len()), now, vehicle, deliberator, observers)?;
        each(observers, now, |observer| observer.inspect(agent, deliberator, now))?;
        (self.steps, self.effects) = (self.steps + 1, self.effects + effects.len() as u64);
        Ok(())
    }

    /// Advances the vehicle to the step; its reports must be among the recorded inputs.
    fn advance(&mut self, vehicle: &mut dyn Vehicle, recorded: &RecordedStep) -> Result<(), ForkError> {
        let now = recorded.batch.now;
        if let Some(missing) = self.reported.iter().find(|input| input.at < now) {
            let simulated = format!("{:?}", missing.kind);
            return Err(ForkError::OtherVehicle { at: missing.at, simulated });
        }
        let broken = |message| RunError::Vehicle { at: now, message };
        vehicle.advance(now, &mut self.reported).map_err(broken)?;
        let numbering = Numbering::new(recorded.agent, self.last_sequences.len());
        for event in &recorded.batch.events {
            let outer = outside(&event.kind, numbering);
            if let EventKind::SolverReported(request, _) = &outer {
                self.open.remove(request);
            }
            let place = self.reported.iter().position(|input| input.kind == outer);
            if let Some(place) = place {
                self.reported.remove(place);
            }
            if let Some(last) = self.last_sequences.get_mut(recorded.agent) {
                *last = event.sequence;
            }
        }
        self.events += recorded.batch.events.len() as u64;
        Ok(())
    }

    fn send(
        &mut self,
        effects: &[Effect],
        numbering: Numbering,
        now: Time,
        vehicle: &mut dyn Vehicle,
        deliberator: &mut dyn Deliberator,
        observers: &mut [&mut dyn Observer],
    ) -> Result<(), ForkError> {
        let sent = outbox::send(effects, numbering, now, vehicle, &mut self.pool);
        for effect in effects {
            if let Effect::CancelSolve(request) = effect {
                self.open.remove(&SolveRequestId(numbering.outer(request.0)));
            }
        }
        for request in sent.requests {
            let posed = deliberator.pose(&request, now);
            each(observers, now, |observer| observer.posed(&request, now, &posed.problem))?;
            if let Some((due, report)) = self.problems.get(&request.request).and_then(|row| row.answer.clone()) {
                let result = match report {
                    SolverReport::Plan(plan) => Ok(plan),
                    SolverReport::Failed(reason) => Err(reason),
                };
                let answer = SolverAnswer { result, charged: Duration::ZERO };
                each(observers, now, |observer| observer.answered(request.request, due, &answer))?;
            }
            self.open.insert(request.request, (request, now, posed));
        }
        Ok(())
    }

    /// Shows the record's notes up to `to`.
    fn show_notes(&mut self, to: Time, observers: &mut [&mut dyn Observer]) -> Result<(), ForkError> {
        while let Some((at, text)) = self.notes.pop_if(|(at, _)| *at <= to) {
            each(observers, at, |observer| observer.note(at, &text))?;
        }
        Ok(())
    }
}

/// Returns an event with its numbers as outside of the agents.
fn outside(kind: &EventKind, numbering: Numbering) -> EventKind {
    match kind {
        EventKind::CommandAcknowledged(command, result) => {
            let outer = apex_model::effect::CommandId(numbering.outer(command.0));
            EventKind::CommandAcknowledged(outer, result.clone())
        }
        EventKind::CommandProgressed(command, progress) => {
            EventKind::CommandProgressed(apex_model::effect::CommandId(numbering.outer(command.0)), *progress)
        }
        EventKind::SolverReported(request, report) => {
            EventKind::SolverReported(SolveRequestId(numbering.outer(request.0)), report.clone())
        }
        other => other.clone(),
    }
}

fn each(
    observers: &mut [&mut dyn Observer],
    at: Time,
    mut call: impl FnMut(&mut dyn Observer) -> Result<(), String>,
) -> Result<(), RunError> {
    observers
        .iter_mut()
        .try_for_each(|observer| call(&mut **observer).map_err(|message| RunError::Observer { at, message }))
}
