//! Explanation of conditions (M&I)
//! What: lists the parts of a condition that do not hold, with their present state and since when.
//! Runs: on request (`apex why`).
//! Reads: the monitor, histories, evaluation context.
//! Writes: nothing.
//! Bound: linear in the condition and in the objects it follows.
//! PDL: all conditions.
//! Paper: section V, explanation of behaviour.

use crate::monitoring::basic::time_conditions::{TimeForm, span};
use crate::monitoring::basic::{measurement, task_state};
use crate::monitoring::combination::{absence, allen, logic, numbers_unmet};
use crate::monitoring::episodes::run_update::{gap_cut, with_newest};
use crate::monitoring::mismatch::first_mismatch;
use crate::monitoring::numbers::cyclic;
use crate::monitoring::part::Truth;
use crate::monitoring::verdict_query::VerdictQuery;
use crate::state::histories::history::{Occurrence, Sample};
use crate::state::monitors::monitor::{
    AbsentPart, AllenPart, Composite, EpisodePart, EventPart, MeasurementPart, Part, PartKind, Test, TimePart, Unmet,
    Window,
};
use apex_forms::print::Style::Brief;
use apex_model::condition::Relation;
use apex_model::event::StateVariable;
use apex_model::pattern::Pattern;
use apex_model::source::Place;
use apex_model::symbol::Symbol;
use apex_model::task::TaskId;
use apex_model::time::Time;
use apex_model::value::Value;

/// Known facts about an unmet part.
#[derive(Default)]
pub(crate) struct PartFacts {
    pub(crate) now: String,
    /// True if no sample or message has arrived that the part could judge.
    pub(crate) unobserved: bool,
    pub(crate) since: Option<Time>,
    pub(crate) until: Option<Time>,
    pub(crate) distance: Option<Value>,
}

impl PartFacts {
    pub(crate) fn words(now: impl Into<String>) -> PartFacts {
        PartFacts { now: now.into(), ..PartFacts::default() }
    }

    /// Returns the facts about a part whose variable has no sample.
    pub(crate) fn no_sample() -> PartFacts {
        PartFacts { unobserved: true, ..PartFacts::words("no sample yet") }
    }

    pub(crate) fn since(self, since: Option<Time>) -> PartFacts {
        PartFacts { since, ..self }
    }

    fn unmet(self, what: String, place: Place) -> Unmet {
        let PartFacts { now, unobserved, since, until, distance } = self;
        Unmet { what, now, unobserved, since, until, distance, place }
    }
}

/// Adds the unmet parts of `part` to `list`.
pub(crate) fn collect(part: &Part, query: &mut VerdictQuery<'_>, list: &mut Vec<Unmet>) {
    if logic::truth(part, query) == Truth::True {
        return;
    }
    match &part.kind {
        PartKind::And(composite) | PartKind::InOrder(composite) => several(part, composite, query, list),
        PartKind::Or(composite) => several(part, composite, query, list),
        PartKind::Allen(leaf) => related(part, leaf, query, list),
        PartKind::Not(inner) => {
            let what = format!("(:not {})", text(inner));
            let now = match logic::truth(inner, query) {
                Truth::True => "the inner condition holds".into(),
                Truth::False | Truth::Unknown => "the data do not show whether the inner condition holds".into(),
            };
            let since = logic::results(inner, query).first().map(|result| result.recognised_at);
            list.push(PartFacts { now, since, ..PartFacts::default() }.unmet(what, part.place));
        }
        _ => {
            list.push(state(part, query).unmet(text(part), part.place));
        }
    }
}

fn several(part: &Part, composite: &Composite, query: &mut VerdictQuery<'_>, list: &mut Vec<Unmet>) {
    let before = list.len();
    composite.parts.iter().for_each(|part| collect(part, query, list));
    // In an order, a delay counts from the part before it: as a part alone it says nothing about the others.
    let counts = |each: &Part| !matches!((&part.kind, &each.kind), (PartKind::InOrder(_), PartKind::Delay(_)));
    let mut others = composite.parts.iter().filter(|each| counts(each));
    if list.len() == before || others.all(|each| logic::truth(each, query) == Truth::True) {
        let constraints = match composite.constraints.as_slice() {
            [] => "each part holds, but not together: shared variables or the order differ".to_owned(),
            some => {
                let texts: Vec<String> = some.iter().map(|each| Brief.expression(each)).collect();
                format!("each part holds, but not together with {}", texts.join(" "))
            }
        };
        list.push(PartFacts::words(constraints).unmet(text(part), part.place));
    }
}

/// Returns the PDL text of a part.
pub(crate) fn text(part: &Part) -> String {
    let several = |name: &str, composite: &Composite| {
        format!("({name} {})", composite.parts.iter().map(text).collect::<Vec<_>>().join(" "))
    };
    match &part.kind {
        PartKind::Measurement(leaf) => Brief.measurement(&leaf.condition),
        PartKind::Episode(leaf) => Brief.episode(&leaf.condition),
        PartKind::Persisted(leaf) => Brief.measurement(&leaf.condition),
        PartKind::Regression(leaf) => Brief.measurement(&leaf.condition),
        PartKind::Statistical(leaf) => Brief.episode(&leaf.condition),
        PartKind::Cyclic(leaf) => Brief.cyclic(&leaf.condition),
        PartKind::Event(leaf) => Brief.event(&leaf.pattern, &leaf.timing),
        PartKind::TaskEnded(leaf) => task_state::ended_words(&leaf.variable),
        PartKind::TaskState(leaf) => Brief.task_state(&leaf.expression, &leaf.state),
        PartKind::Timestamp(leaf) => Brief.span(":timestamp", &leaf.from, leaf.to.as_ref()),
        PartKind::Delay(leaf) => Brief.span(":delay", &leaf.from, leaf.to.as_ref()),
        PartKind::And(composite) => several(":and", composite),
        PartKind::Or(composite) => several(":or", composite),
        PartKind::InOrder(composite) => several(":in-order", composite),
        PartKind::Not(inner) => format!("(:not {})", text(inner)),
        PartKind::Allen(leaf) => {
            let parts = leaf.parts.iter().map(text).collect::<Vec<_>>().join(" ");
            format!("(:{} {parts})", leaf.relation.word())
        }
        PartKind::Absent(leaf) => format!("(:absent {} :for {})", text(&leaf.part), leaf.length),
        PartKind::Function(leaf) => Brief.function(&leaf.expression),
    }
}

/// Describes the parts of a relation without results, or else the mismatch of the newest results.
fn related(part: &Part, leaf: &AllenPart, query: &mut VerdictQuery<'_>, list: &mut Vec<Unmet>) {
    let before = list.len();
    for (each, side) in leaf.parts.iter().zip(&leaf.sides) {
        if side.newest.is_none() {
            collect(each, query, list);
        }
    }
    if list.len() > before {
        return;
    }
    let relation = format!(":{}", leaf.relation.word());
    let known = match allen::mismatch(leaf, query.now) {
        Some((index, mismatch)) => {
            let named = |index: usize| leaf.parts.get(index).map(text).unwrap_or_default();
            let (first, second) = (named(index), named(index + 1));
            let told = leaf.decides_at.filter(|_| leaf.undecided);
            let told = told.map(|at| format!("; if no sample comes, it is decided at {at}")).unwrap_or_default();
            PartFacts::words(format!("{mismatch}; the first is {first}, the second {second}{told}"))
        }
        None if leaf.constraints.is_empty() => {
            PartFacts::words(format!("the newest results are {relation}, but bind shared variables differently"))
        }
        None => {
            let texts: Vec<String> = leaf.constraints.iter().map(|each| Brief.expression(each)).collect();
            PartFacts::words(format!("the newest results are {relation}, but not with {}", texts.join(" ")))
        }
    };
    list.push(PartFacts { until: leaf.decides_at, ..known }.unmet(text(part), part.place));
}

/// Describes the time for which the part has been absent, and the instant at which that suffices.
fn absence_state(leaf: &AbsentPart, query: &VerdictQuery<'_>) -> PartFacts {
    let (silence, over) = absence::state(leaf, query.now);
    let since = Some(leaf.since);
    let (now, since, until) = match (leaf.goes_on, leaf.unknown) {
        (true, _) => (format!("{} continues", text(&leaf.part)), None, leaf.decides_at),
        (_, true) => (format!("the data do not show whether {} continues", text(&leaf.part)), since, leaf.decides_at),
        _ => (format!("it has been absent for {silence} of {}", leaf.length), since, Some(over)),
    };
    PartFacts { until: until.filter(|at| *at > query.now), ..PartFacts::words(now).since(since) }
}

/// Returns the known facts about a part.
pub(crate) fn state(part: &Part, query: &mut VerdictQuery<'_>) -> PartFacts {
    let start = part.window.start;
    match &part.kind {
        PartKind::Measurement(leaf) => measurement_state(leaf, part.window, query),
        PartKind::Episode(leaf) => episode_state(leaf, query),
        PartKind::Persisted(leaf) => numbers_unmet::persisted(leaf, crate::monitoring::part::site(part), query),
        PartKind::Regression(leaf) => numbers_unmet::regression(leaf, crate::monitoring::part::site(part), query),
        PartKind::Statistical(leaf) => numbers_unmet::statistical(leaf, crate::monitoring::part::site(part), query),
        PartKind::Cyclic(leaf) => {
            let words = cyclic::words(leaf, crate::monitoring::part::site(part), query);
            words.map_or_else(PartFacts::no_sample, PartFacts::words)
        }
        PartKind::Event(leaf) if leaf.blind => PartFacts::words("older messages are no longer remembered"),
        PartKind::Event(leaf) => event_state(leaf, part, query),
        PartKind::TaskEnded(leaf) => task_words(leaf.task, &format!("?{} is not known yet", leaf.variable), query),
        PartKind::TaskState(leaf) => task_words(leaf.task, "the task is not known yet", query),
        PartKind::Timestamp(leaf) => time_state(leaf, TimeForm::Timestamp, start, query),
        PartKind::Delay(leaf) => time_state(leaf, TimeForm::Delay, start, query).since(Some(start)),
        PartKind::Absent(leaf) => absence_state(leaf, query),
        PartKind::Function(leaf) => match &leaf.value {
            Some(value) => PartFacts::words(format!("its value is {value}")),
            None => PartFacts::words("it has no value yet"),
        },
        PartKind::And(_) | PartKind::Or(_) | PartKind::InOrder(_) | PartKind::Not(_) | PartKind::Allen(_) => {
            PartFacts::default()
        }
    }
}

/// Describes a missing message: either none matches, or how the newest one with the same first word differs.
fn event_state(leaf: &EventPart, part: &Part, query: &VerdictQuery<'_>) -> PartFacts {
    let start = part.window.start;
    let since = (start != Time::BEGINNING).then_some(start);
    let events = query.context.histories().events_from(Time::BEGINNING);
    let Some(newest) = events.filter(|event| begins_alike(&leaf.pattern, &event.form)).last() else {
        return PartFacts { unobserved: true, ..PartFacts::words("no such event yet").since(since) };
    };
    let Occurrence { form, at, sequence } = newest;
    let reason = match first_mismatch(&leaf.pattern, form, query.context) {
        Some(mismatch) => format!("it {mismatch}"),
        None if *at < start => "that was before the wait began".into(),
        None if !part.window.contains(*at, *sequence) => "a step has answered that one".into(),
        None => "its guards, segments or timing do not fit".into(),
    };
    let now = format!("no such event yet; the last one like it was {form} at {at}: {reason}");
    PartFacts { unobserved: true, ..PartFacts::words(now).since(since) }
}

/// Returns true if the form begins with the first word of the pattern.
fn begins_alike(pattern: &Pattern, form: &Value) -> bool {
    let wanted = match pattern {
        Pattern::Literal(literal) => literal.head(),
        Pattern::List(parts) => match parts.first() {
            Some(Pattern::Literal(first)) => first.as_symbol(),
            _ => None,
        },
        _ => None,
    };
    wanted.is_some_and(|wanted| form.head() == Some(wanted))
}

pub(crate) fn newest(
    known: Option<&StateVariable>,
    attribute: &Symbol,
    query: &VerdictQuery<'_>,
) -> Option<(String, Sample)> {
    let histories = query.context.histories();
    match known {
        Some(variable) => histories.get(variable)?.newest().map(|sample| (variable.to_string(), sample.clone())),
        None => histories
            .of_attribute(attribute)
            .filter_map(|(variable, history)| Some((variable.to_string(), history.newest()?.clone())))
            .max_by_key(|(_, sample)| (sample.at, sample.sequence)),
    }
}

fn measurement_state(leaf: &MeasurementPart, window: Window, query: &VerdictQuery<'_>) -> PartFacts {
    let Some((variable, sample)) = newest(leaf.variable.as_ref(), &leaf.condition.variable.attribute, query) else {
        return PartFacts::no_sample();
    };
    let distance = distance(&leaf.tests, &sample.value);
    let mut now = format!("{variable} = {}", sample.value);
    if sample.at < window.start {
        now.push_str(", measured before the wait began");
    } else if leaf.blind {
        now.push_str("; older samples are no longer kept");
    } else if !measurement::has_seen_any(leaf, window, query.context) {
        now.push_str(", which is not a sample that this condition waits for");
    } else if let Some(distance) = &distance {
        now.push_str(&format!(", {distance} off"));
    }
    PartFacts { now, since: Some(sample.at), distance, ..PartFacts::default() }
}

/// Returns the distance of a value from the nearest threshold that it fails.
pub(crate) fn distance(tests: &[Test], value: &Value) -> Option<Value> {
    let (own, dimension) = value.as_number()?;
    let missed = tests.iter().filter_map(|test| match test {
        Test::Fixed { relation, right } => right.as_number().map(|(wanted, _)| (relation, wanted)),
        Test::General(_) => None,
    });
    let misses = missed.filter(|(relation, wanted)| match relation {
        Relation::Equal => own != *wanted,
        Relation::Different => false,
        Relation::Less | Relation::LessOrEqual => own >= *wanted,
        Relation::Greater | Relation::GreaterOrEqual => own <= *wanted,
    });
    let off = misses.map(|(_, wanted)| difference(own, wanted)).reduce(f64::max)?;
    Some(match value {
        Value::Integer(_) if libm::trunc(off) == off => Value::Integer(off as i64),
        _ => Value::measured(off, dimension),
    })
}

/// Returns the distance between two numbers, without digits that neither of them has.
fn difference(one: f64, other: f64) -> f64 {
    let off = (one - other).abs();
    let scale = one.abs().max(other.abs());
    if off == 0.0 || !off.is_finite() {
        return off;
    }
    let lost = libm::log10(scale / off).clamp(0.0, 14.0) as usize;
    format!("{off:.*e}", 14_usize.saturating_sub(lost)).parse().unwrap_or(off)
}

fn episode_state(leaf: &EpisodePart, query: &VerdictQuery<'_>) -> PartFacts {
    let Some((variable, sample)) = newest(leaf.variable.as_ref(), &leaf.condition.variable.attribute, query) else {
        return PartFacts::no_sample();
    };
    let run = leaf
        .runs
        .values()
        .filter_map(|state| with_newest(leaf, state).map(|run| (run, state)))
        .max_by_key(|(run, _)| run.last);
    let Some((run, state)) = run else {
        let gap = leaf.runs.values().find_map(|state| state.gap);
        let gap = gap.map(|gap| format!("; the last run was cut by a gap of {gap}")).unwrap_or_default();
        let silence = query.now - sample.at;
        let silent = leaf.gap_max.filter(|most| silence > *most);
        let silent = silent.map(|most| format!("; no sample for {silence}, more than the gap of {most} allowed"));
        let now = format!("{variable} = {}{gap}{}", sample.value, silent.unwrap_or_default());
        return PartFacts::words(now).since(Some(sample.at));
    };
    let mut now = format!("{variable} = {}, holds for {} so far", sample.value, run.last - run.start);
    if let Some(most) = leaf.gap_max {
        let silence = query.now - state.newest.at;
        if silence > most {
            now.push_str(&format!("; no sample for {silence}, more than the gap of {most} allowed"));
        } else if let Some(gap) = gap_cut(leaf, state).or(state.gap) {
            now.push_str(&format!("; a gap of {gap} > {most} cut it before"));
        }
    }
    let silent = leaf.gap_max.is_some_and(|most| query.now - state.newest.at > most);
    let until = Some(run.start + leaf.duration_min).filter(|at| *at > query.now && !silent);
    if let Some(at) = until {
        now.push_str(&format!("; it is long enough at {at} if it continues"));
    }
    PartFacts { until, ..PartFacts::words(now).since(Some(run.start)) }
}

fn task_words(task: Option<TaskId>, unknown: &str, query: &VerdictQuery<'_>) -> PartFacts {
    let Some(task) = task else { return PartFacts::words(unknown) };
    match query.context.task_state(task) {
        Some(state) => PartFacts::words(format!("{task} is {state}")).since(query.context.task_start(task)),
        None => PartFacts::words(format!("{task} is no longer known")),
    }
}

fn time_state(leaf: &TimePart, kind: TimeForm, start: Time, query: &VerdictQuery<'_>) -> PartFacts {
    match span(leaf, kind, start, query.context) {
        Err(error) => PartFacts::words(error.message),
        Ok((from, _)) if from > query.now => {
            PartFacts { until: Some(from), ..PartFacts::words(format!("it is {}, {from} is to come", query.now)) }
        }
        Ok((from, _)) => PartFacts::words(format!("it is {}, {from} had passed before the wait began", query.now)),
    }
}
