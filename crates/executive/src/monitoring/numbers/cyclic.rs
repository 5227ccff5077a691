//! Cyclic patterns (M&I)
//! What: detects that a value rises and falls in cycles of the required period and amplitude, often enough in sequence.
//! Runs: on every sample of the watched variable.
//! Reads: histories, evaluation context.
//! Writes: the cyclic part of a monitor.
//! Bound: O(1) per sample and object; a late sample looks back over the window again.
//! PDL: `(:cyclic (ATTR OBJ) :period C [:amplitude C] [:cycles C] [:hysteresis V])`.
//! Paper: section V.B, services for detecting cyclic patterns.

use crate::expression::declared_unit::unit_of;
use crate::expression::{EvalContext, EvaluationError, evaluate};
use crate::monitoring::constraints::{RightSide, all};
use crate::monitoring::part::{ConditionFaults, PartContext, Truth, remember};
use crate::monitoring::sampled::{Sampled, object_bindings};
use crate::monitoring::samples::{SampleView, known_variable};
use crate::monitoring::verdict_query::VerdictQuery;
use crate::planted::{self, Bug};
use crate::state::bindings::Bindings;
use crate::state::monitors::cyclic::{CycleRun, CyclicObject, CyclicPart, Extreme, Heading, Swing};
use crate::state::monitors::monitor::{Keep, Satisfaction};
use apex_model::because::Evidence;
use apex_model::condition::Constraint;
use apex_model::condition::CyclicCondition;
use apex_model::condition::VariablePattern;
use apex_model::estimate::Aggregate;
use apex_model::event::StateVariable;
use apex_model::evidence_list::EvidenceList;
use apex_model::limits::MONITOR_OBJECTS_MAX;
use apex_model::quantity::Dimension;
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Number of cycles that make a pattern when `:cycles` is not stated.
const CYCLES_DEFAULT: u64 = 2;

/// Returns the part for a condition; it has not processed remembered samples yet. The hysteresis is evaluated now.
///
/// # Errors
/// If it cannot be computed, or is not a number of the variable's unit.
pub(crate) fn create(
    condition: &Arc<CyclicCondition>,
    context: &dyn EvalContext,
) -> Result<CyclicPart, EvaluationError> {
    let unit = unit_of(&condition.variable.attribute, context.library());
    let mut hysteresis = 0.0;
    for constraint in constraints_of(condition, "hysteresis") {
        let Constraint::Compare { right, .. } = constraint else { continue };
        let found = evaluate(right, context)?;
        hysteresis = match (found.as_number(), unit) {
            (Some((number, Dimension::NONE)), Some(unit)) => number * unit.factor,
            (Some((number, _)), _) => number,
            (None, _) => {
                let message = format!("the :hysteresis {found} is not a number");
                return Err(EvaluationError { message, place: right.place });
            }
        };
    }
    Ok(CyclicPart {
        condition: Arc::clone(condition),
        variable: known_variable(&condition.variable, context),
        hysteresis,
        blind: false,
        settled: Vec::new(),
        objects: BTreeMap::new(),
    })
}

fn constraints_of<'a>(condition: &'a CyclicCondition, name: &str) -> &'a [Constraint] {
    condition.options.iter().find(|(option, _)| option.is(name)).map_or(&[], |(_, constraints)| constraints)
}

impl Sampled for CyclicPart {
    fn pattern(&self) -> &VariablePattern {
        &self.condition.variable
    }

    fn variable(&self) -> Option<&StateVariable> {
        self.variable.as_ref()
    }

    fn newest(&self, object: &Value) -> Option<Time> {
        self.objects.get(object).map(|object| object.newest.0)
    }

    fn begin_again(&mut self, _: PartContext, _: &dyn EvalContext, _: &mut ConditionFaults) {
        self.settled.clear();
        self.objects.clear();
    }

    fn note_blind(&mut self, blind: bool, _: Option<Time>) {
        self.blind = blind;
    }

    fn feed(
        &mut self,
        site: PartContext,
        sample: SampleView<'_>,
        context: &dyn EvalContext,
        troubles: &mut ConditionFaults,
    ) {
        feed(self, site, sample, context, troubles);
    }
}

fn feed(
    part: &mut CyclicPart,
    site: PartContext,
    sample: SampleView<'_>,
    context: &dyn EvalContext,
    troubles: &mut ConditionFaults,
) {
    if site.keep == Keep::First && !part.settled.is_empty() {
        return;
    }
    let (number, dimension) = sample.value.as_number().unwrap_or((f64::NAN, Dimension::NONE));
    let object = &sample.variable.object;
    match part.objects.get(object).map(|state| state.newest.0) {
        Some(newest) if sample.at > newest => settle(part, site, object, context, troubles),
        Some(_) => {}
        None if part.objects.len() >= MONITOR_OBJECTS_MAX => {
            return troubles.limit("MONITOR_OBJECTS_MAX", MONITOR_OBJECTS_MAX, site.place);
        }
        None => {
            let bindings = object_bindings(part, &[], site, sample, context, troubles);
            let newest = (sample.at, number);
            let state = CyclicObject { rank: sample.sequence, bindings, newest, swing: Swing::default() };
            part.objects.insert(object.clone(), state);
        }
    }
    let Some(state) = part.objects.get_mut(object) else { return };
    if dimension != state.swing.dimension {
        state.swing = Swing { dimension, contradicted: state.swing.contradicted, ..Swing::default() };
    }
    state.newest = (sample.at, number);
}

/// Adds the newest sample of an object to the past, because one of a later instant has arrived.
fn settle(
    part: &mut CyclicPart,
    site: PartContext,
    object: &Value,
    context: &dyn EvalContext,
    troubles: &mut ConditionFaults,
) {
    let judge = Judge { part, site, context };
    let Some(state) = part.objects.get(object) else { return };
    let (swing, found) = judge.with_newest(object, state, troubles);
    if let Some(state) = part.objects.get_mut(object) {
        state.swing = swing;
    }
    if let Some(result) = found {
        remember(&mut part.settled, result, site, troubles);
    }
}

/// Returns all results up to now, earliest recognised first.
pub(crate) fn results(part: &CyclicPart, site: PartContext, query: &mut VerdictQuery<'_>) -> Vec<Satisfaction> {
    let mut results = part.settled.clone();
    if site.keep == Keep::First && !results.is_empty() {
        return results;
    }
    let judge = Judge { part, site, context: query.context };
    let mut objects: Vec<(&Value, &CyclicObject)> = part.objects.iter().collect();
    objects.sort_by_key(|(_, state)| state.rank);
    results.extend(
        objects.into_iter().filter_map(|(object, state)| judge.with_newest(object, state, &mut query.troubles).1),
    );
    results.sort_by_key(|result| result.recognised_at);
    results
}

/// Returns true if it is undecided whether the required cycles continue.
pub(crate) fn in_doubt(part: &CyclicPart, site: PartContext, query: &mut VerdictQuery<'_>) -> bool {
    let judge = Judge { part, site, context: query.context };
    let mut open = part.blind || part.objects.is_empty();
    for (object, state) in &part.objects {
        let swing = judge.with_newest(object, state, &mut query.troubles).0;
        open |= state.bindings.is_some() && !swing.contradicted;
    }
    open
}

/// Returns satisfied; contradicted by a complete cycle; or unknown while too few cycles are complete.
pub(crate) fn truth(part: &CyclicPart, site: PartContext, query: &mut VerdictQuery<'_>) -> Truth {
    if !part.settled.is_empty() {
        return Truth::True;
    }
    let judge = Judge { part, site, context: query.context };
    let mut open = part.blind || part.objects.is_empty();
    for (object, state) in &part.objects {
        let (swing, found) = judge.with_newest(object, state, &mut query.troubles);
        if found.is_some() {
            return Truth::True;
        }
        open |= state.bindings.is_some() && !swing.contradicted;
    }
    if open { Truth::Unknown } else { Truth::False }
}

/// Returns the known facts for `apex why`: turning points, the last cycle, the number in sequence. `None` without a sample.
pub(crate) fn words(part: &CyclicPart, site: PartContext, query: &mut VerdictQuery<'_>) -> Option<String> {
    let judge = Judge { part, site, context: query.context };
    let wanted = part.objects.iter().filter(|(_, state)| state.bindings.is_some());
    let (object, state) = wanted.max_by_key(|(_, state)| state.newest.0)?;
    let (swing, _) = judge.with_newest(object, state, &mut query.troubles);
    let variable = StateVariable::new(part.condition.variable.attribute.clone(), object.clone());
    Some(match (swing.last, swing.run, swing.turns) {
        (Some((start, end, amplitude)), run, _) => {
            let amplitude = judge.in_unit(amplitude, swing.dimension);
            let row = run.map_or(0, |run| run.halves / 2);
            let cycles = if row == 1 { "cycle" } else { "cycles" };
            format!(
                "{row} {cycles} of {variable} in a row; the last one took {} with an amplitude of {amplitude}",
                end - start
            )
        }
        (None, _, [_, Some(turn)]) => {
            format!("the last turning point of {variable} was at {}; no cycle is complete", turn.at)
        }
        (None, ..) => format!("{variable} has no turning point yet"),
    })
}

struct Judge<'a> {
    part: &'a CyclicPart,
    site: PartContext,
    context: &'a dyn EvalContext,
}

impl Judge<'_> {
    /// Returns the state of the samples including the newest one, and the result that it completes.
    fn with_newest(
        &self,
        object: &Value,
        state: &CyclicObject,
        troubles: &mut ConditionFaults,
    ) -> (Swing, Option<Satisfaction>) {
        let mut swing = state.swing;
        let (at, number) = state.newest;
        let Some(bindings) = &state.bindings else { return (swing, None) };
        if !number.is_finite() {
            // A value that is not a number interrupts every cycle.
            let Swing { dimension, contradicted, .. } = swing;
            return (Swing { dimension, contradicted, ..Swing::default() }, None);
        }
        swing.samples = swing.samples.saturating_add(1);
        let sample = Extreme { at, value: number, number: swing.samples };
        let Some(turn) = turn(&mut swing, sample, self.part.hysteresis) else { return (swing, None) };
        match self.cycle(&mut swing, turn) {
            Ok(Some(run)) => {
                let result = self.result(object, bindings.clone(), run, swing.dimension, at);
                (swing, Some(result))
            }
            Ok(None) => (swing, None),
            Err(error) => {
                troubles.add(error);
                (swing, None)
            }
        }
    }

    /// Adds a turning point. Returns the run if the point completes the required number of cycles for the first time.
    fn cycle(&self, swing: &mut Swing, turn: Extreme) -> Result<Option<CycleRun>, EvaluationError> {
        let [before, middle] = swing.turns;
        swing.turns = [middle, Some(turn)];
        let (Some(before), Some(middle)) = (before, middle) else { return Ok(None) };
        let amplitude = libm::fabs((before.value + turn.value) / 2.0 - middle.value) / 2.0;
        swing.last = Some((before.at, turn.at, amplitude));
        if !self.satisfies(before.at, turn.at, amplitude, swing.dimension)? {
            swing.contradicted = true;
            swing.run = None;
            return Ok(None);
        }
        let fresh = CycleRun { start: before, end: turn, halves: 1, amplitudes: 0.0, told: false };
        let run = swing.run.get_or_insert(fresh);
        run.halves = run.halves.saturating_add(1);
        run.end = turn;
        run.amplitudes += amplitude;
        let complete = run.halves.is_multiple_of(2) && !run.told && self.is_enough(run.halves / 2)?;
        run.told |= complete;
        Ok(complete.then_some(*run))
    }

    fn satisfies(&self, start: Time, end: Time, amplitude: f64, dimension: Dimension) -> Result<bool, EvaluationError> {
        let unit = unit_of(&self.part.condition.variable.attribute, self.context.library());
        let period = Value::Duration(end - start);
        let amplitude = Value::measured(amplitude, dimension);
        Ok(self.hold("period", &period, RightSide::Span)?
            && self.hold("amplitude", &amplitude, RightSide::Value(unit))?)
    }

    fn is_enough(&self, cycles: u64) -> Result<bool, EvaluationError> {
        if constraints_of(&self.part.condition, "cycles").is_empty() {
            return Ok(cycles >= CYCLES_DEFAULT);
        }
        self.hold("cycles", &Value::Integer(i64::try_from(cycles).unwrap_or(i64::MAX)), RightSide::Value(None))
    }

    fn hold(&self, option: &str, value: &Value, reading: RightSide) -> Result<bool, EvaluationError> {
        let constraints = constraints_of(&self.part.condition, option);
        all(constraints, value, reading, &mut Bindings::new(), self.context, self.site.place)
    }

    fn result(
        &self,
        object: &Value,
        bindings: Bindings,
        run: CycleRun,
        dimension: Dimension,
        recognised_at: Time,
    ) -> Satisfaction {
        let variable = StateVariable::new(self.part.condition.variable.attribute.clone(), object.clone());
        let interval = (run.start.at, run.end.at);
        let samples = run.end.number.saturating_sub(run.start.number).saturating_add(1);
        let cycles = i64::try_from((run.halves / 2).max(1)).unwrap_or(i64::MAX);
        // Cycles begin at maxima and at minima.
        let overlapping = run.halves.saturating_sub(1).max(1) as f64;
        let period = Value::Duration(Duration((interval.1 - interval.0).0 / cycles));
        let fact = |name: &str, value: Value| {
            let variable = variable.clone();
            let aggregate = Aggregate { variable, name: name.to_string(), value, interval, samples };
            Evidence::Aggregate(Box::new(aggregate))
        };
        let facts = vec![
            fact("cycles", Value::Integer(cycles)),
            fact("period", period),
            fact("amplitude", self.in_unit(run.amplitudes / overlapping, dimension)),
        ];
        Satisfaction { interval, recognised_at, bindings, evidence: EvidenceList::from(facts) }
    }

    /// Returns an amplitude in the declared unit.
    fn in_unit(&self, amplitude: f64, dimension: Dimension) -> Value {
        match unit_of(&self.part.condition.variable.attribute, self.context.library()) {
            Some(unit) if unit.dimension == dimension => {
                crate::expression::arithmetic::with_unit(amplitude / unit.factor, unit)
            }
            _ => Value::measured(amplitude, dimension),
        }
    }
}

/// Adds a value and returns the turning point that it reveals: an extreme from which the values have returned by more than the
/// hysteresis. The first extreme is not a turning point, because the values before it are unknown.
fn turn(swing: &mut Swing, sample: Extreme, hysteresis: f64) -> Option<Extreme> {
    let highest = swing.highest.filter(|highest| highest.value >= sample.value).unwrap_or(sample);
    let lowest = swing.lowest.filter(|lowest| lowest.value <= sample.value).unwrap_or(sample);
    (swing.highest, swing.lowest) = (Some(highest), Some(lowest));
    let back = |distance: f64| distance > 0.0 && (distance >= hysteresis || planted::is(Bug::HysteresisForgotten));
    let (fell, rose) = (back(highest.value - sample.value), back(sample.value - lowest.value));
    let turned = match swing.heading {
        Heading::Rising if fell => Some((Heading::Falling, Some(highest))),
        Heading::Falling if rose => Some((Heading::Rising, Some(lowest))),
        Heading::Unknown if rose => Some((Heading::Rising, None)),
        Heading::Unknown if fell => Some((Heading::Falling, None)),
        _ => None,
    };
    let (heading, extreme) = turned?;
    swing.heading = heading;
    (swing.highest, swing.lowest) = (Some(sample), Some(sample));
    extreme
}
