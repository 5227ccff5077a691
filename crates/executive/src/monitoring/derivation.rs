//! Derived state variables (M&I)
//! What: computes samples of derived state variables from the samples of an instant.
//! Runs: after all samples of an instant are recorded, before monitors notice them.
//! Reads: library, histories.
//! Writes: histories; new stimuli.
//! Bound: O(inputs * log n) per derived sample.
//! PDL: `(state-variable (ATTR ?object) :derived EXPR :join J)`.
//! Paper: section IV, state variables that interpretation computes.

use crate::expression::{EvalContext, evaluate};
use crate::monitoring::memory::histories::{Recording, record_sample};
use crate::state::histories::history::{Histories, History, Sample};
use crate::state::recorded::Recorded;
use crate::state::variable_index::{InputReader, RankedDerivation, VariableIndex};
use apex_model::agent_limits::Limits;
use apex_model::derivation::{Derivation, DerivationInput, Join, Reading};
use apex_model::event::StateVariable;
use apex_model::host::HostFunctions;
use apex_model::library::Library;
use apex_model::pattern::Pattern;
use apex_model::quantity::{Dimension, Quantity};
use apex_model::symbol::Symbol;
use apex_model::task::{TaskId, TaskState};
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
use smallvec::{SmallVec, smallvec};

/// A sample that was recorded, of a variable that derivations read.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Changed {
    pub(crate) variable: StateVariable,
    pub(crate) at: Time,
}

/// A derived sample and the result of recording it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Derived {
    pub(crate) variable: StateVariable,
    pub(crate) at: Time,
    pub(crate) recording: Recording,
}

/// Context of derivations in addition to histories.
pub(crate) struct Surroundings<'a> {
    pub(crate) library: &'a Library,
    pub(crate) index: &'a VariableIndex,
    pub(crate) host: &'a HostFunctions,
    pub(crate) agent: &'a Symbol,
    pub(crate) limits: &'a Limits,
}

/// Histories of the inputs of a derivation for one object, in order of the inputs.
type InputHistories<'h> = SmallVec<[&'h History; 4]>;

/// The object and the inputs of a derivation at an instant, by name.
type BoundInputs<'l> = SmallVec<[(&'l Symbol, Value); 6]>;

/// Derives samples from `changed` and records them; `arrival` numbers them. Returns the result of recording each, in order. A value that
/// cannot be computed counts as a missing measurement; the first failure of a variable is reported.
pub(crate) fn derive(
    changed: Vec<Changed>,
    histories: &mut Histories,
    surroundings: &Surroundings<'_>,
    arrival: &mut dyn FnMut() -> u64,
) -> Vec<Derived> {
    let Surroundings { library, index, .. } = surroundings;
    let with_readers = |each: Changed| (index.readers(&each.variable.attribute), each);
    let mut changed: Vec<(&[InputReader], Changed)> = changed.into_iter().map(with_readers).collect();
    // Most samples concern few of the derivations.
    let mut concerned: SmallVec<[bool; 32]> = smallvec![false; index.ranked().len()];
    changed.iter().for_each(|(readers, _)| concern(&mut concerned, readers));
    let mut recordings = Vec::new();
    let mut due: Vec<(Time, Value)> = Vec::new();
    for (number, RankedDerivation { attribute, holds_numbers }) in index.ranked().iter().enumerate() {
        if !concerned.get(number).is_some_and(|concerned| *concerned) {
            continue;
        }
        let Some(derivation) = library.derivations.get(attribute) else { continue };
        let mut settled = Settled::new();
        for (readers, each) in &changed {
            for reader in readers.iter().filter(|reader| reader.derivation == number) {
                add_due(&mut due, derivation, (reader.input, each), histories, &mut settled);
            }
        }
        due.sort();
        due.dedup_by(|a, b| a.cmp(&b).is_eq());
        for (at, object) in due.drain(..) {
            let variable = StateVariable::new(attribute.clone(), object);
            let value = value_at((derivation, *holds_numbers), &variable, at, histories, surroundings);
            let recording = match value {
                None => continue,
                Some(Ok(value)) => record_sample(histories, index, variable.clone(), value, at, arrival()),
                Some(Err(message)) => {
                    Recording { stimulus: None, trouble: Some(message), recorded: None, overflows: false }
                }
            };
            let readers = index.readers(attribute);
            if recording.stimulus.is_some() && !readers.is_empty() {
                concern(&mut concerned, readers);
                changed.push((readers, Changed { variable: variable.clone(), at }));
            }
            let recording = first_trouble_only(recording, &variable, histories);
            recordings.push(Derived { variable, at, recording });
        }
    }
    recordings
}

/// Marks the derivations that read a variable.
fn concern(concerned: &mut [bool], readers: &[InputReader]) {
    for reader in readers {
        if let Some(concerned) = concerned.get_mut(reader.derivation) {
            *concerned = true;
        }
    }
}

/// Returns the number of samples that deriving once more from the same samples would record, if that changed nothing else. `derived` is
/// the result of the first time.
pub(crate) fn repetition(derived: &[Derived], histories: &Histories) -> Option<u64> {
    let changes_nothing = |each: &Derived| {
        let history = histories.get(&each.variable);
        each.recording.recorded == Some(Recorded::Appended)
            && history.is_some_and(|history| history.ignores_repetition(each.at))
    };
    derived.iter().all(changes_nothing).then_some(derived.len() as u64)
}

/// Objects for which no further input of an instant adds anything: an input has no sample, or the value of that instant is due and nothing
/// was sampled later.
type Settled = SmallVec<[(Value, Option<Time>); 2]>;

/// Adds the instants and objects at which a sample of an input gives a value, unless that is settled.
fn add_due(
    due: &mut Vec<(Time, Value)>,
    derivation: &Derivation,
    (input, changed): (usize, &Changed),
    histories: &Histories,
    settled: &mut Settled,
) {
    let Some(read) = derivation.inputs.get(input) else { return };
    for object in objects(derivation, read, &changed.variable.object, histories) {
        let is_settled = |(known, at): &(Value, Option<Time>)| at.is_none_or(|at| at == changed.at) && *known == object;
        if settled.iter().any(is_settled) {
            continue;
        }
        // Without a sample of each input there is no value at any instant.
        let Some(all) = input_histories(derivation, &object, histories) else {
            settled.push((object, None));
            continue;
        };
        let Some(own) = all.get(input) else { continue };
        affected(derivation.join, &all, own, changed.at, &mut |at| due.push((at, object.clone())));
        let is_newest = |history: &&History| history.newest().is_none_or(|newest| newest.at <= changed.at);
        if matches!(derivation.join, Join::Hold(_)) && all.iter().all(is_newest) {
            settled.push((object, Some(changed.at)));
        }
    }
}

/// Returns the instants and objects that add up for these changes if nothing is settled: the definition of what [`derive`] collects.
#[cfg(test)]
pub(crate) fn due_by_every_input(
    derivation: &Derivation,
    changes: &[(usize, Changed)],
    histories: &Histories,
) -> [Vec<(Time, Value)>; 2] {
    let (mut all, mut due, mut settled) = (Vec::new(), Vec::new(), Settled::new());
    for (input, changed) in changes {
        add_due(&mut all, derivation, (*input, changed), histories, &mut Settled::new());
        add_due(&mut due, derivation, (*input, changed), histories, &mut settled);
    }
    for due in [&mut all, &mut due] {
        due.sort();
        due.dedup_by(|a, b| a.cmp(&b).is_eq());
    }
    [all, due]
}

/// Counts a value that was not computed, or was refused, as missing, and drops all of its messages but the first.
fn first_trouble_only(mut recording: Recording, variable: &StateVariable, histories: &mut Histories) -> Recording {
    if recording.recorded.is_none() && histories.note_missing(variable) > 1 {
        recording.trouble = None;
    }
    recording
}

/// Returns the objects for which a sample of `input`, with the object `measured`, gives a value.
fn objects(
    derivation: &Derivation,
    input: &DerivationInput,
    measured: &Value,
    histories: &Histories,
) -> SmallVec<[Value; 1]> {
    match &input.object {
        Pattern::Literal(wanted) if wanted.matches(measured) => {
            let own = |input: &&DerivationInput| matches!(input.object, Pattern::Variable(_));
            let mut objects = SmallVec::new();
            for input in derivation.inputs.iter().filter(own).take(1) {
                objects.extend(histories.of_attribute(&input.attribute).map(|(variable, _)| variable.object.clone()));
            }
            objects
        }
        Pattern::Variable(_) => smallvec![measured.clone()],
        _ => SmallVec::new(),
    }
}

/// Returns the histories of all inputs; `None` if one has no sample.
fn input_histories<'h>(
    derivation: &Derivation,
    object: &Value,
    histories: &'h Histories,
) -> Option<InputHistories<'h>> {
    let of_input = |input: &DerivationInput| {
        let object = match &input.object {
            Pattern::Literal(literal) => literal,
            _ => object,
        };
        histories.get(&StateVariable::new(input.attribute.clone(), object.clone()))
    };
    derivation.inputs.iter().map(of_input).collect()
}

/// Notes the instants whose derived sample depends on the sample at `at` of `own`, an input among `all`: `at` itself, and the instants of
/// other inputs from there (with interpolation from its predecessor in `own`) to its successor. Without a successor, these are all later
/// instants if values are held, and none if they are interpolated.
fn affected(join: Join, all: &[&History], own: &History, at: Time, note: &mut dyn FnMut(Time)) {
    note(at);
    let is_newest = own.newest().is_none_or(|newest| newest.at <= at);
    let later = || own.between(Time(at.0.saturating_add(1)), Time::END).next().map(|sample| sample.at);
    let next = if is_newest { None } else { later() };
    let from = match join {
        Join::Hold(_) => at,
        Join::Interpolate(_) => own.before(at).map_or(at, |sample| sample.at),
    };
    let to = match (join, next) {
        (_, Some(next)) => next,
        // The newest sample of its variable, while other variables may have later samples.
        (Join::Hold(_), None) => {
            let has_later = |history: &&&History| history.newest().is_some_and(|newest| newest.at > at);
            for history in all.iter().filter(has_later) {
                history.between(at, Time::END).for_each(|sample| note(sample.at));
            }
            return;
        }
        (Join::Interpolate(_), None) => at,
    };
    for history in all {
        history.between(from, to).for_each(|sample| note(sample.at));
    }
}

/// Returns the derived value at an instant; `None` if an input has no value then.
fn value_at(
    (derivation, holds_numbers): (&Derivation, bool),
    variable: &StateVariable,
    at: Time,
    histories: &Histories,
    surroundings: &Surroundings<'_>,
) -> Option<Result<Value, String>> {
    let all = input_histories(derivation, &variable.object, histories)?;
    let mut bound: BoundInputs<'_> = smallvec![(&derivation.object, variable.object.clone())];
    for (input, history) in derivation.inputs.iter().zip(all) {
        bound.push((&input.name, input_at(input.reads, derivation.join, history, at)?));
    }
    let context = InstantView { surroundings, histories, bound: &bound, at };
    match evaluate(&derivation.value, &context) {
        // For a variable that holds numbers, `nil` means that the value is unknown.
        Ok(value) if holds_numbers && !value.is_true() => None,
        Ok(value) => Some(Ok(value)),
        Err(error) => {
            let place = surroundings.library.describe_place(error.place);
            let message = &error.message;
            Some(Err(format!(
                "the derived state variable {variable} has no value at {at}: {message} ({place}); further ones are counted as missing"
            )))
        }
    }
}

fn input_at(reads: Reading, join: Join, history: &History, at: Time) -> Option<Value> {
    let latest = history.at(at)?;
    let fresh = |sample: &Sample| match join {
        Join::Hold(Some(most)) => at - sample.at <= most,
        Join::Hold(None) => true,
        Join::Interpolate(most) => {
            sample.at == at || history.between(at, Time::END).next().is_some_and(|next| next.at - sample.at <= most)
        }
    };
    if !fresh(latest) {
        return None;
    }
    match reads {
        Reading::Value => match join {
            Join::Interpolate(_) if latest.at < at => {
                Some(interpolated(latest, history.between(at, Time::END).next()?, at))
            }
            _ => Some(latest.value.clone()),
        },
        Reading::Previous => history.before(latest.at).map(|sample| sample.value.clone()),
        Reading::Changed => history.before(latest.at).map(|sample| Value::truth(!sample.value.equals(&latest.value))),
        Reading::Rate => rate(history.before(latest.at)?, latest),
    }
}

/// Returns the value on the line between two samples; a value that is not a number holds.
fn interpolated(before: &Sample, after: &Sample, at: Time) -> Value {
    let (Some((low, dimension)), Some((high, same))) = (before.value.as_number(), after.value.as_number()) else {
        return before.value.clone();
    };
    if dimension != same {
        return before.value.clone();
    }
    let share = (at - before.at).0 as f64 / (after.at - before.at).0 as f64;
    number(low + (high - low) * share, dimension)
}

/// Returns the change per second; `None` if the values are not numbers of one dimension.
fn rate(before: &Sample, latest: &Sample) -> Option<Value> {
    let ((low, dimension), (high, same)) = (before.value.as_number()?, latest.value.as_number()?);
    let seconds = Duration((latest.at - before.at).0).seconds();
    let per_s = (high - low) / seconds;
    // The rate of bare numbers is a bare number.
    let dimension_per_s = if dimension == Dimension::NONE { dimension } else { dimension.over(Dimension::TIME) };
    (dimension == same).then(|| number(per_s, dimension_per_s))
}

fn number(si: f64, dimension: Dimension) -> Value {
    match dimension {
        Dimension::NONE => Value::Real(si),
        Dimension::TIME => Value::Duration(Duration::from_seconds(si)),
        _ => Value::Quantity(Quantity::si(si, dimension)),
    }
}

/// Context of the expression: its inputs, and the time of the sample.
struct InstantView<'a> {
    surroundings: &'a Surroundings<'a>,
    histories: &'a Histories,
    bound: &'a [(&'a Symbol, Value)],
    at: Time,
}

impl EvalContext for InstantView<'_> {
    fn variable(&self, name: &Symbol) -> Option<Value> {
        // An input hides an earlier one of its name.
        self.bound.iter().rev().find(|(bound, _)| *bound == name).map(|(_, value)| value.clone())
    }
    fn now(&self) -> Time {
        self.at
    }
    fn this_task(&self) -> Option<TaskId> {
        None
    }
    fn agent_name(&self) -> &Symbol {
        self.surroundings.agent
    }
    fn task_start(&self, _: TaskId) -> Option<Time> {
        None
    }
    fn task_end(&self, _: TaskId) -> Option<Time> {
        None
    }
    fn task_state(&self, _: TaskId) -> Option<TaskState> {
        None
    }
    fn task_time_ongoing(&self, _: TaskId) -> Option<Duration> {
        None
    }
    fn histories(&self) -> &Histories {
        self.histories
    }
    fn library(&self) -> &Library {
        self.surroundings.library
    }
    fn host(&self) -> &HostFunctions {
        self.surroundings.host
    }
    fn limits(&self) -> &Limits {
        self.surroundings.limits
    }
}
