//! Statistics (M&I)
//! What: detects a run, or a window of the required length, whose statistics and trends satisfy the constraints.
//! Runs: on every sample of the watched variable, and at instants that the sampling quality licenses.
//! Reads: histories, evaluation context.
//! Writes: the statistical part of a monitor.
//! Bound: amortised O(1) per sample and object, a median O(log n); a late sample looks back over the window again.
//! PDL: `:episode` with `:stats` or `:trend`.
//! Paper: Table 1, rows 8 and 9.

use crate::expression::declared_unit::unit_of;
use crate::expression::{EvalContext, EvaluationError};
use crate::monitoring::constraints::{RightSide, all, prepare, satisfies_all};
use crate::monitoring::numbers::aggregates::{CriterionResult, criteria, name};
use crate::monitoring::numbers::regression::declared_scale;
use crate::monitoring::numbers::statistic_runs::{CriteriaVerdict, Evaluated, Evaluation, contradicted, take_in};
use crate::monitoring::part::{ConditionFaults, PartContext, Truth, remember};
use crate::monitoring::sampled::Sampled;
use crate::monitoring::samples::{SampleView, known_variable, object_holds};
use crate::monitoring::time_bounds::duration_of;
use crate::monitoring::verdict_query::VerdictQuery;
use crate::state::bindings::Bindings;
use crate::state::monitors::moments::MAGNITUDE_MAX;
use crate::state::monitors::monitor::{Keep, Satisfaction};
use crate::state::monitors::numbers::{Measure, NumberRun, NumberSample, StatisticalPart, Totals};
use apex_forms::print::Style::Brief;
use apex_model::agent_limits::Limit;
use apex_model::because::Evidence;
use apex_model::condition::VariablePattern;
use apex_model::condition::{Constraint, EpisodeCondition, Quality, Relation};
use apex_model::estimate::computed;
use apex_model::event::StateVariable;
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Returns the part for `condition`; it has not processed remembered samples yet. Gap and durations are evaluated now.
///
/// # Errors
/// When the gap or a duration cannot be evaluated.
pub(crate) fn create(
    condition: &Arc<EpisodeCondition>,
    context: &dyn EvalContext,
) -> Result<StatisticalPart, EvaluationError> {
    let unit = unit_of(&condition.variable.attribute, context.library());
    let gap_max = match &condition.quality {
        Quality::NoConstraints => None,
        Quality::MaximumGap(gap) => Some(duration_of(gap, context)?),
    };
    let timing = &condition.timing;
    let mut duration_min = Duration::ZERO;
    for constraint in &timing.duration {
        duration_min = duration_min.max(least_duration(constraint, context)?);
    }
    let slides = condition.value.is_empty() && duration_min > Duration::ZERO;
    let lower = |constraint: &Constraint| crate::monitoring::constraints::is_lower_bound(constraint);
    Ok(StatisticalPart {
        tests: prepare(&condition.value, unit, context)?,
        criteria: criteria(condition, context)?,
        variable: known_variable(&condition.variable, context),
        dimension: declared_scale(&condition.variable.attribute, context).1,
        gap_max,
        duration_min,
        slides,
        at_close: !slides && !timing.duration.iter().chain(&timing.end).all(lower),
        blind: false,
        first_known: None,
        settled: Vec::new(),
        objects: BTreeMap::new(),
        condition: Arc::clone(condition),
    })
}

/// Returns the least duration that a constraint allows; for a sliding window the required one.
fn least_duration(constraint: &Constraint, context: &dyn EvalContext) -> Result<Duration, EvaluationError> {
    let tick = Duration(1);
    Ok(match constraint {
        Constraint::Compare { relation: Relation::Greater, right, .. } => duration_of(right, context)? + tick,
        Constraint::Compare { relation: Relation::Equal, right, tolerance: Some(around) } => {
            duration_of(right, context)? - duration_of(around, context)?
        }
        Constraint::Compare { relation: Relation::GreaterOrEqual | Relation::Equal, right, .. }
        | Constraint::Range(Some(right), _) => duration_of(right, context)?,
        _ => Duration::ZERO,
    })
}

impl Sampled for StatisticalPart {
    fn pattern(&self) -> &VariablePattern {
        &self.condition.variable
    }

    fn variable(&self) -> Option<&StateVariable> {
        self.variable.as_ref()
    }

    fn newest(&self, object: &Value) -> Option<Time> {
        self.objects.get(object).map(|state| state.newest.at)
    }

    fn begin_again(&mut self, _: PartContext, _: &dyn EvalContext, _: &mut ConditionFaults) {
        self.settled.clear();
        self.objects.clear();
    }

    fn note_blind(&mut self, blind: bool, first: Option<Time>) {
        self.blind = blind;
        self.first_known = first.filter(|_| blind);
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
    part: &mut StatisticalPart,
    site: PartContext,
    sample: SampleView<'_>,
    context: &dyn EvalContext,
    troubles: &mut ConditionFaults,
) {
    if site.keep == Keep::First && !part.settled.is_empty() {
        return;
    }
    let object = &sample.variable.object;
    let objects = part.objects.len();
    let mut state = match part.objects.get_mut(object).map(std::mem::take) {
        Some(state) if sample.at > state.newest.at => settle(part, site, sample, state, context, troubles),
        Some(state) => state,
        None if objects >= context.limits().count(Limit::MonitorObjects) => {
            return troubles.reached(Limit::MonitorObjects, context, site.place);
        }
        None => NumberRun { rank: sample.sequence, ..NumberRun::default() },
    };
    state.newest = judge(part, site, sample, state.run.as_deref(), context, troubles);
    match part.objects.get_mut(object) {
        Some(slot) => *slot = state,
        None => drop(part.objects.insert(object.clone(), state)),
    }
}

/// Adds the newest sample to the past, because one of a later instant, `next`, has arrived.
fn settle(
    part: &mut StatisticalPart,
    site: PartContext,
    next: SampleView<'_>,
    mut state: NumberRun,
    context: &dyn EvalContext,
    troubles: &mut ConditionFaults,
) -> NumberRun {
    let evaluation = Evaluation { part, site, object: &next.variable.object, context };
    let Evaluated { found, over, .. } = evaluation.up_to(&state, next.at - Duration(1), troubles);
    for result in over {
        remember(&mut part.settled, result, site, troubles);
    }
    state.found = match found {
        Some(result) if site.keep == Keep::First => {
            remember(&mut part.settled, result, site, troubles);
            None
        }
        found => found,
    };
    take_in(part, site, &mut state, next.at, context, troubles);
    state
}

/// Returns the sample with its number, and with its bindings if it satisfies the value constraints; also whether it belongs to the run and
/// satisfies the constraints on the first and last values and on steps.
fn judge(
    part: &mut StatisticalPart,
    site: PartContext,
    sample: SampleView<'_>,
    run: Option<&Totals>,
    context: &dyn EvalContext,
    troubles: &mut ConditionFaults,
) -> NumberSample {
    let mut newest = NumberSample {
        at: sample.at,
        number: number(part, site, sample, troubles),
        holds: None,
        joins: run.is_some(),
        first_holds: true,
        last_holds: true,
        bad_step: false,
    };
    if run.is_some_and(|run| part.gap_max.is_some_and(|most| sample.at - run.last > most)) {
        newest.joins = false;
    }
    match held_values(part, site, sample, run.filter(|_| newest.joins), context) {
        Ok(Some((bindings, joins))) => {
            newest.joins &= joins;
            newest.holds = Some(bindings);
        }
        Ok(None) => {}
        Err(error) => troubles.add(error),
    }
    let unit = unit_of(&part.condition.variable.attribute, context.library());
    let Some(bindings) = &mut newest.holds else { return newest };
    for (constraints, holds) in
        [(&part.condition.first_value, &mut newest.first_holds), (&part.condition.last_value, &mut newest.last_holds)]
    {
        *holds = all(constraints, sample.value, RightSide::Value(unit), bindings, context, site.place).unwrap_or_else(
            |error| {
                troubles.add(error);
                false
            },
        );
    }
    if let (Some((_, before)), Some(number), true) = (run.and_then(|run| run.previous), newest.number, newest.joins) {
        let evaluation = Evaluation { part, site, object: &sample.variable.object, context };
        newest.bad_step = !evaluation.step_holds(before, number, troubles);
    }
    newest
}

/// Returns the bindings of a sample that satisfies the value constraints, and true if they agree with the preceding run.
fn held_values(
    part: &StatisticalPart,
    site: PartContext,
    sample: SampleView<'_>,
    run: Option<&Totals>,
    context: &dyn EvalContext,
) -> Result<Option<(Bindings, bool)>, EvaluationError> {
    let condition = &part.condition;
    let known = part.variable.is_some();
    let attempt = |mut bindings: Bindings| -> Result<Option<Bindings>, EvaluationError> {
        let SampleView { variable, value, .. } = sample;
        let attribute = &variable.attribute;
        let holds =
            object_holds(&condition.variable, &condition.object, known, variable, &mut bindings, site, context)?
                && satisfies_all(&part.tests, &condition.value, value, attribute, &mut bindings, context, site.place)?;
        Ok(holds.then_some(bindings))
    };
    if let Some(run) = run
        && let Some(joined) = attempt(run.bindings.clone())?
    {
        return Ok(Some((joined, true)));
    }
    match run {
        Some(run) if run.bindings.is_empty() => Ok(None),
        _ => Ok(attempt(Bindings::new())?.map(|bindings| (bindings, false))),
    }
}

/// Returns the sample's number in SI; `None` if it is missing or not finite. If only samples are counted, any value is a number.
fn number(
    part: &mut StatisticalPart,
    site: PartContext,
    sample: SampleView<'_>,
    troubles: &mut ConditionFaults,
) -> Option<f64> {
    let counts = |measure: &Measure| matches!(measure, Measure::Count | Measure::Frequency | Measure::Custom);
    match sample.value.as_number() {
        Some((number, _)) if number.is_nan() || libm::fabs(number) > MAGNITUDE_MAX => None,
        Some((number, dimension)) if *part.dimension.get_or_insert(dimension) == dimension => Some(number),
        _ if part.criteria.iter().all(|criterion| counts(&criterion.measure)) => Some(0.0),
        _ => {
            let names: Vec<&str> = part.criteria.iter().map(|criterion| name(&criterion.measure)).collect();
            let SampleView { variable, value, .. } = sample;
            let message = format!(
                "{variable} = {value} is not a number with the dimension of the values before it: it is left out of the {}",
                names.join(", ")
            );
            troubles.add(EvaluationError { message, place: site.place });
            None
        }
    }
}

/// Returns all results up to now, earliest recognised first.
pub(crate) fn results(part: &StatisticalPart, site: PartContext, query: &mut VerdictQuery<'_>) -> Vec<Satisfaction> {
    let mut results = part.settled.clone();
    if site.keep == Keep::First && !results.is_empty() {
        return results;
    }
    for (object, state) in in_order(part) {
        let evaluation = Evaluation { part, site, object, context: query.context };
        let evaluated = evaluation.up_to(state, query.now, &mut query.troubles);
        results.extend(evaluated.over);
        results.extend(evaluated.closed_by_time);
        results.extend(evaluated.found);
    }
    // Results of one instant, in the order in which their objects first occurred.
    let rank = |result: &Satisfaction| {
        let object = result.evidence.iter().find_map(|evidence| match evidence {
            Evidence::Run { variable, .. } => Some(&variable.object),
            Evidence::Aggregate(aggregate) => Some(&aggregate.variable.object),
            _ => None,
        });
        object.and_then(|object| part.objects.get(object)).map(|state| state.rank)
    };
    results.sort_by_key(|result| (result.recognised_at, rank(result)));
    results
}

/// Returns the results that grow as long as their statistics hold.
pub(crate) fn open_results(
    part: &StatisticalPart,
    site: PartContext,
    query: &mut VerdictQuery<'_>,
) -> Vec<Satisfaction> {
    open(part, site, query).into_iter().map(|(_, result)| result).collect()
}

fn open<'a>(
    part: &'a StatisticalPart,
    site: PartContext,
    query: &mut VerdictQuery<'_>,
) -> Vec<(&'a Value, Satisfaction)> {
    let mut open = Vec::new();
    for (object, state) in &part.objects {
        let evaluation = Evaluation { part, site, object, context: query.context };
        let found = evaluation.up_to(state, query.now, &mut query.troubles).found;
        open.extend(found.map(|result| (object, result)));
    }
    open
}

/// Returns the open runs, each with its variable.
pub(crate) fn open_of_variables(
    part: &StatisticalPart,
    site: PartContext,
    query: &mut VerdictQuery<'_>,
) -> Vec<(StateVariable, Satisfaction)> {
    let variable = |object: &Value| StateVariable::new(part.condition.variable.attribute.clone(), object.clone());
    open(part, site, query).into_iter().map(|(object, result)| (variable(object), result)).collect()
}

/// Returns true if it is undecided whether the newest run of an object satisfies the constraints.
pub(crate) fn in_doubt(part: &StatisticalPart, site: PartContext, query: &mut VerdictQuery<'_>) -> bool {
    let mut doubt = part.blind || part.objects.is_empty();
    for (object, state) in &part.objects {
        let evaluation = Evaluation { part, site, object, context: query.context };
        let outcome = evaluation.up_to(state, query.now, &mut query.troubles).outcome;
        doubt |= doubtful(part, state, outcome, query.now);
    }
    doubt
}

fn doubtful(part: &StatisticalPart, state: &NumberRun, outcome: CriteriaVerdict, now: Time) -> bool {
    let stale = part.gap_max.is_some_and(|gap| now - state.newest.at > gap);
    match outcome {
        CriteriaVerdict::Early | CriteriaVerdict::Undefined => !contradicted(part, state) || stale,
        CriteriaVerdict::OutOfRun | CriteriaVerdict::Holds | CriteriaVerdict::Fails => stale,
    }
}

fn in_order(part: &StatisticalPart) -> Vec<(&Value, &NumberRun)> {
    let mut objects: Vec<(&Value, &NumberRun)> = part.objects.iter().collect();
    objects.sort_by_key(|(_, state)| state.rank);
    objects
}

/// Returns satisfied; unknown while a statistic is undefined, a run is too short, or samples are missing; otherwise not satisfied. Also
/// computes the next instant at which time alone decides.
pub(crate) fn truth(part: &StatisticalPart, site: PartContext, query: &mut VerdictQuery<'_>) -> Truth {
    let mut met = !part.settled.is_empty();
    if met && site.keep == Keep::First {
        return Truth::True;
    }
    let mut open = part.blind || part.objects.is_empty();
    for (object, state) in &part.objects {
        let evaluation = Evaluation { part, site, object, context: query.context };
        let evaluated = evaluation.up_to(state, query.now, &mut query.troubles);
        met |= evaluated.found.is_some() || evaluated.closed_by_time.is_some() || !evaluated.over.is_empty();
        open |= doubtful(part, state, evaluated.outcome, query.now);
        if !met || site.keep == Keep::Every {
            evaluation.foresee(state, evaluated.outcome, query);
        }
    }
    Truth::of(met, open)
}

/// Returns the known facts of the newest run, for explanations: each criterion with its verdict, and the start of the run.
pub(crate) fn standing(
    part: &StatisticalPart,
    site: PartContext,
    query: &VerdictQuery<'_>,
) -> Option<crate::monitoring::numbers::statistic_runs::RunSummary> {
    let (object, state) = part.objects.iter().max_by_key(|(_, state)| state.newest.at)?;
    Evaluation { part, site, object, context: query.context }.standing(state, query.now)
}

/// Returns one criterion as text: `mean = 3 does not satisfy (> 5)`.
pub(crate) fn judgement_words(
    criterion: &crate::state::monitors::numbers::Criterion,
    judgement: &CriterionResult,
) -> String {
    let constraints: Vec<String> = criterion.constraints.iter().map(|each| Brief.constraint(each)).collect();
    let (name, wanted) = (name(&criterion.measure), constraints.join(" "));
    match judgement {
        CriterionResult::Undefined(reason) => format!("no {name}: {reason}"),
        CriterionResult::Holds(_) | CriterionResult::Fails(_) if criterion.measure == Measure::Custom => {
            format!("{name} {wanted} is false")
        }
        CriterionResult::Holds(value) => format!("{name} = {}", computed(value)),
        // Only the level of significance has no constraints.
        CriterionResult::Fails(value) if wanted.is_empty() => {
            format!("such a slope arises at random with probability {}", computed(value))
        }
        CriterionResult::Fails(value) => format!("{name} = {}, wanted {wanted}", computed(value)),
    }
}
