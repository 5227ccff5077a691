//! Replay: executes the recorded inputs again and compares every effect byte for byte, and every row that is derived from
//! inputs and effects. With the mission's deliberator it also poses every planning problem again. Solvers never run again; their
//! answers are inputs, which must be those that the record states.

mod answers;

use crate::agent_group::Numbering;
use crate::effect_describer::{EffectDescriber, EffectRow};
use crate::error::RecordError;
use crate::outbox;
use crate::ports::{Deliberator, Input, Observer, SolverAnswer};
use crate::program::NoDeliberator;
use crate::record::{
    Derivable, LoadProgram, ProblemRow, RecordGap, RecordReader, RecordedStep, Recorder, RowDifference,
    SITUATION_LAYOUT, twin_recorder,
};
use answers::{OtherAnswer, RecordedAnswers};
use apex_executive::step;
use apex_model::effect::{Effect, SolveRequestId};
use apex_model::event::{Batch, SolverReport};
use apex_model::time::{Duration, Time};
use std::collections::BTreeMap;
use std::fmt;

/// Result of a replay.
#[derive(Clone, Debug, PartialEq)]
pub struct ReplayReport {
    /// Number of steps executed again.
    pub batches: u64,
    /// Number of effects compared.
    pub effects: u64,
    /// Planning problems posed again and compared; 0 without a mission.
    pub problems: u64,
    /// The last instant that was executed.
    pub end: Time,
    /// The first difference; `None` if the record is confirmed.
    pub difference: Option<Difference>,
    /// Steps that are missing because the disk accepted no writes: replay ends before them.
    pub gap: Option<RecordGap>,
}

/// Maximum number of printed characters of one side of a difference.
const SIDE_CHARS_MAX: usize = 600;

/// The first difference.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// Instant.
    pub at: Time,
    /// Number of the batch; 0 for rows that are of none.
    pub batch: i64,
    /// Kind of difference.
    pub what: Differing,
    /// The recorded side as text; `None` if the record lacks it.
    pub recorded: Option<String>,
    /// The replayed side as text; `None` if the replay did not make it.
    pub replayed: Option<String>,
}

/// Items that a replay compares.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Differing {
    /// The effect at this position among the step's effects, from 1.
    Effect(usize),
    /// The planning problem of this request.
    Problem(SolveRequestId),
    /// The answer to this request.
    Answer(SolveRequestId),
    /// The mission's situation after the step.
    Situation,
    /// A row that is derived from inputs and effects: its table and number, and the column that differs (empty: the whole row).
    Row(String, &'static str),
    /// An input that the mission derives from the preceding step: the batch does not contain it.
    Derived,
}

impl fmt::Display for Differing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Differing::Effect(position) => write!(f, "effect {position}"),
            Differing::Problem(request) => write!(f, "planning problem of request {}", request.0),
            Differing::Answer(request) => write!(f, "answer to request {}", request.0),
            Differing::Situation => f.write_str("situation of the mission"),
            Differing::Row(row, "") => write!(f, "row {row}"),
            Differing::Row(row, column) => write!(f, "column `{column}` of row {row}"),
            Differing::Derived => f.write_str("input that the mission derives"),
        }
    }
}

impl fmt::Display for ReplayReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(difference) = &self.difference else {
            let how = if self.gap.is_some() { "confirmed up to its gap" } else { "confirmed" };
            write!(
                f,
                "The record is {how}: {} steps up to {} gave the same {} effects",
                self.batches, self.end, self.effects
            )?;
            if let Some(gap) = &self.gap {
                return write!(f, ". What follows the gap ({gap}) cannot be replayed.");
            }
            return match self.problems {
                0 => f.write_str("."),
                1 => f.write_str(" and posed the same planning problem."),
                count => write!(f, " and posed the same {count} planning problems."),
            };
        };
        let Difference { at, batch, what, recorded, replayed } = difference;
        // Facts, targets and the report are of no batch.
        let batch = if *batch > 0 { format!("batch {batch}, ") } else { String::new() };
        write!(
            f,
            "The replay differs at {at}, {batch}{what}:\n  recorded: {}\n  replayed: {}",
            excerpt(recorded.as_deref(), replayed.as_deref()),
            excerpt(replayed.as_deref(), recorded.as_deref())
        )
    }
}

/// Returns a side of a difference as it is printed: the whole text if it is short, and the surroundings of the first difference otherwise,
/// because a planning problem has a hundred thousand characters.
fn excerpt(side: Option<&str>, other: Option<&str>) -> String {
    let text = side.unwrap_or("nothing");
    let length = text.chars().count();
    if length <= SIDE_CHARS_MAX {
        return text.to_owned();
    }
    let equal = text.chars().zip(other.unwrap_or_default().chars()).take_while(|(one, two)| one == two).count();
    let from = equal.saturating_sub(SIDE_CHARS_MAX / 2);
    let part: String = text.chars().skip(from).take(SIDE_CHARS_MAX).collect();
    format!("characters {} to {} of {length}: {part}", from + 1, length.min(from + SIDE_CHARS_MAX))
}

/// Executes all recorded batches of all agents again, up to the first difference.
///
/// # Errors
/// [`RecordError`] when the record cannot be read or its mission not loaded.
pub fn replay(reader: &RecordReader, load: LoadProgram<'_>) -> Result<ReplayReport, RecordError> {
    replay_steps(reader, load, None)
}

/// Like [`replay`]; `deliberator` observes the steps again, poses every recorded problem again and must be in the recorded situation at
/// each snapshot.
///
/// # Errors
/// Like [`replay`].
pub fn replay_with(
    reader: &RecordReader,
    load: LoadProgram<'_>,
    deliberator: &mut dyn Deliberator,
) -> Result<ReplayReport, RecordError> {
    let witness = Witness::new(reader, deliberator)?;
    replay_steps(reader, load, Some(witness))
}

fn replay_steps(
    reader: &RecordReader,
    load: LoadProgram<'_>,
    mut witness: Option<Witness<'_>>,
) -> Result<ReplayReport, RecordError> {
    let program = reader.load(load)?;
    let mut agents = Vec::new();
    for agent in 0..reader.agents().len().max(1) {
        agents.push((reader.fresh_agent_number(&program, agent)?, EffectDescriber::new(&program.0)));
    }
    let count = agents.len();
    let snapshots = reader.has_own_states()?;
    let situations = match &witness {
        Some(witness) => has_own_situations(reader, witness.deliberator)?,
        None => false,
    };
    let mut twin = twin_recorder(reader, &program.0, Derivable { mission: witness.is_some(), situations, snapshots })?;
    let mut report = ReplayReport { batches: 0, effects: 0, problems: 0, end: Time::ZERO, difference: None, gap: None };
    let gaps = reader.gaps()?;
    let answers = reader.answers()?;
    let recorded_answers = RecordedAnswers::new(&answers);
    for (expected, recorded) in (1..).zip(reader.steps_of_all(Time::END)?) {
        let recorded = recorded?;
        if recorded.batch_number != expected {
            report.gap = gaps.into_iter().find(|gap| gap.first_batch == expected);
            return match report.gap {
                Some(_) => Ok(report),
                None => Err(reader.garbled(format!("batch {expected} is missing"))),
            };
        }
        let Some((agent, describer)) = agents.get_mut(recorded.agent) else {
            return Err(reader.garbled(format!("batch {} is of an agent that does not exist", recorded.batch_number)));
        };
        let effects = step(agent, &recorded.batch);
        describer.hear(&recorded.batch);
        let seen = twin.turn(recorded.agent).and_then(|()| twin.observe(&recorded.batch, &effects));
        seen.map_err(|message| reader.garbled(message))?;
        report.batches += 1;
        report.effects += effects.len() as u64;
        report.end = recorded.batch.now;
        let numbering = Numbering::new(recorded.agent, count);
        report.difference = compare(&recorded, &effects, describer)
            .or_else(|| recorded_answers.check(&recorded.batch, numbering).map(|other| of_answer(other, &recorded)));
        if let (None, Some(witness)) = (&report.difference, &mut witness) {
            report.difference = witness.check(&recorded, &effects, numbering, &mut twin);
            report.problems = witness.posed;
        }
        if report.difference.is_none() {
            let deliberator: &dyn Deliberator =
                witness.as_ref().map_or(&NoDeliberator as _, |witness| &*witness.deliberator as _);
            let (now, batch) = (recorded.batch.now, recorded.batch_number);
            let seen = twin.inspect(agent, deliberator, now);
            seen.map_err(|message| reader.garbled(message))?;
            report.difference = twin.difference().map(|row| of_row(row, now, batch));
        }
        if report.difference.is_some() {
            return Ok(report);
        }
    }
    report.difference = witness.and_then(Witness::left_over);
    if report.difference.is_none() {
        store_answers(&mut twin, reader, answers)?;
        twin.finish(report.end, "")?;
        report.difference = twin.difference().map(|row| of_row(row, report.end, 0));
    }
    Ok(report)
}

/// Lets the twin compare the rows of answers with what follows from their reports.
fn store_answers(
    twin: &mut Recorder,
    reader: &RecordReader,
    answers: Vec<(SolveRequestId, Time, SolverReport)>,
) -> Result<(), RecordError> {
    for (request, due, answer) in answers {
        let result = match answer {
            SolverReport::Plan(plan) => Ok(plan),
            SolverReport::Failed(reason) => Err(reason),
        };
        let answered = twin.answered(request, due, &SolverAnswer { result, charged: Duration::ZERO });
        answered.map_err(|message| reader.garbled(message))?;
    }
    Ok(())
}

/// Returns an answer that differs, in the step in which the agent received it.
fn of_answer(other: OtherAnswer, step: &RecordedStep) -> Difference {
    let OtherAnswer { request, recorded, received } = other;
    let what = Differing::Answer(request);
    Difference { at: step.batch.now, batch: step.batch_number, what, recorded, replayed: Some(received) }
}

/// Returns a row that differs, found after a step.
fn of_row(row: &RowDifference, at: Time, batch: i64) -> Difference {
    let RowDifference { row, column, recorded, replayed } = row.clone();
    Difference { at, batch, what: Differing::Row(row, column), recorded, replayed }
}

/// Poses recorded problems again.
struct Witness<'a> {
    deliberator: &'a mut dyn Deliberator,
    problems: BTreeMap<SolveRequestId, ProblemRow>,
    situations: BTreeMap<i64, Vec<u8>>,
    /// Derived inputs of the steps so far that no batch has contained yet.
    derived: Vec<Input>,
    posed: u64,
}

/// Returns true if the situations in the record have the layout of this program.
fn has_own_situations(reader: &RecordReader, deliberator: &dyn Deliberator) -> Result<bool, RecordError> {
    let Some(layout) = deliberator.layout() else { return Ok(false) };
    Ok(reader.has_own_states()? && reader.has_layout(SITUATION_LAYOUT, layout)?)
}

impl<'a> Witness<'a> {
    fn new(reader: &RecordReader, deliberator: &'a mut dyn Deliberator) -> Result<Witness<'a>, RecordError> {
        let problems = reader.problems()?.into_iter().map(|row| (row.request, row)).collect();
        // Another build may encode the same situation in other bytes.
        let situations = if has_own_situations(reader, deliberator)? { reader.situations()? } else { Vec::new() };
        let situations = situations.into_iter().map(|row| (row.batch_number, row.body)).collect();
        Ok(Witness { deliberator, problems, situations, derived: Vec::new(), posed: 0 })
    }

    fn check(
        &mut self,
        recorded: &RecordedStep,
        effects: &[Effect],
        numbering: Numbering,
        twin: &mut Recorder,
    ) -> Option<Difference> {
        let (now, batch) = (recorded.batch.now, recorded.batch_number);
        let difference = |what, recorded: Option<String>, replayed: Option<String>| {
            Some(Difference { at: now, batch, what, recorded, replayed })
        };
        // Every agent receives the derived inputs; only those of the first agent are compared.
        if recorded.agent == 0
            && let Some(missing) = missing(&std::mem::take(&mut self.derived), &recorded.batch)
        {
            return difference(Differing::Derived, None, Some(missing));
        }
        self.deliberator.observe(recorded.agent, &recorded.batch, effects);
        self.derived.extend(self.deliberator.derive());
        for request in outbox::requests(effects, numbering) {
            let posed = self.deliberator.pose(&request, now).problem;
            // An error shows as a difference.
            let _ = twin.posed(&request, now, &posed);
            let what = Differing::Problem(request.request);
            match self.problems.remove(&request.request) {
                Some(row) if row.problem == posed && row.at == now => self.posed += 1,
                row => return difference(what, row.map(|row| row.problem), Some(posed)),
            }
        }
        let stored = self.situations.remove(&batch)?;
        match self.deliberator.snapshot() {
            Some(believed) if believed == stored => None,
            believed => {
                let size = |bytes: usize| Some(format!("{bytes} bytes"));
                let replayed = believed.and_then(|bytes| size(bytes.len()));
                difference(Differing::Situation, size(stored.len()), replayed)
            }
        }
    }

    /// Returns a recorded problem that no step of the replay posed.
    fn left_over(self) -> Option<Difference> {
        let (request, row) = self.problems.into_iter().next()?;
        let what = Differing::Problem(request);
        Some(Difference { at: row.at, batch: 0, what, recorded: Some(row.problem), replayed: None })
    }
}

/// Returns the first of the derived inputs that the next batch does not hold, as text.
fn missing(derived: &[Input], batch: &Batch) -> Option<String> {
    let holds = |input: &&Input| batch.events.iter().any(|event| event.at == input.at && event.kind == input.kind);
    derived.iter().find(|input| !holds(input)).map(|input| format!("{:?} at {}", input.kind, input.at))
}

fn compare(recorded: &RecordedStep, effects: &[Effect], describer: &mut EffectDescriber) -> Option<Difference> {
    let longest = recorded.effects.len().max(effects.len());
    for index in 0..longest {
        let (stored, made) = (recorded.effects.get(index), effects.get(index));
        let same = match (stored, made) {
            (Some(stored), Some(made)) => postcard::to_stdvec(made).is_ok_and(|body| body == stored.body),
            _ => false,
        };
        if !same {
            let mut twin = describer.clone();
            let recorded_words = stored.map(|stored| match stored.effect() {
                Ok(effect) => words(&twin.tell(&effect)),
                Err(fault) => fault,
            });
            let replayed_words = made.map(|made| words(&describer.tell(made)));
            // If both texts are equal although the effects differ, the full effects are shown instead.
            let (recorded_words, replayed_words) = if recorded_words == replayed_words {
                let whole = |effect: &Effect| format!("{effect:?}");
                (stored.and_then(|stored| stored.effect().ok()).as_ref().map(whole), made.map(whole))
            } else {
                (recorded_words, replayed_words)
            };
            return Some(Difference {
                at: recorded.batch.now,
                batch: recorded.batch_number,
                what: Differing::Effect(index + 1),
                recorded: recorded_words,
                replayed: replayed_words,
            });
        }
        if let Some(made) = made {
            describer.tell(made);
        }
    }
    None
}

/// Returns the effect as text: `transition T3 (power-up camera-1): enabled -> ongoing; it was granted camera-1; from file.pdl:14:3`
fn words(told: &EffectRow) -> String {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_sides_of_a_difference_are_cut_around_its_first_character() {
        let (recorded, replayed) = (format!("{}A{}", "é".repeat(5_000), "x".repeat(9)), "é".repeat(9_000));
        let shown = excerpt(Some(&recorded), Some(&replayed));
        assert!(shown.starts_with("characters 4701 to 5010 of 5010: é") && shown.ends_with("éAxxxxxxxxx"), "{shown}");
        let shown = excerpt(Some(&replayed), Some(&recorded));
        assert!(shown.starts_with("characters 4701 to 5300 of 9000: é"), "{shown}");
        assert_eq!(shown.chars().filter(|char| *char == 'é').count(), SIDE_CHARS_MAX);
        assert!(excerpt(Some(&recorded), None).starts_with("characters 1 to 600 of 5010: "));
        assert_eq!((&*excerpt(Some("short"), None), &*excerpt(None, Some(&recorded))), ("short", "nothing"));
    }
}
