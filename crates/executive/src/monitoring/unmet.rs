//! Explanation of conditions (M&I)
//! What: the parts of a condition that do not hold, with what is known about each and since when.
//! Runs: when a person asks (`apex why`).
//! Reads: the monitor, histories, surroundings.
//! Writes: nothing.
//! Bound: linear in the condition and in the objects it follows.
//! PDL: all conditions.
//! Paper: section V, explanation of behaviour.

use super::runs::with_newest;
use super::time_conditions::{Kind, span};
use super::{Asking, Truth, logic, measurement, task_state};
use crate::explanation::words;
use apex_model::event::StateVariable;
use apex_model::history::Sample;
use apex_model::monitor::{Composite, EpisodePart, MeasurementPart, Part, PartKind, TimePart, Unmet, Window};
use apex_model::symbol::Symbol;
use apex_model::task::TaskId;
use apex_model::time::Time;

/// Adds the unmet parts of `part` to `list`.
pub(super) fn collect(part: &Part, asking: &mut Asking<'_>, list: &mut Vec<Unmet>) {
    if logic::truth(part, asking) == Truth::True {
        return;
    }
    match &part.kind {
        PartKind::And(composite) | PartKind::InOrder(composite) => several(part, composite, asking, list),
        PartKind::Or(composite) => several(part, composite, asking, list),
        PartKind::Not(inner) => {
            let what = format!("(:not {})", text(inner));
            let now = match logic::truth(inner, asking) {
                Truth::True => "the inner condition holds".into(),
                Truth::False | Truth::Unknown => "the data do not say whether the inner condition holds".into(),
            };
            let since = logic::results(inner, asking).first().map(|result| result.recognised_at);
            list.push(Unmet { what, now, since, place: part.place });
        }
        _ => {
            let (now, since) = state(part, asking);
            list.push(Unmet { what: text(part), now, since, place: part.place });
        }
    }
}

fn several(part: &Part, composite: &Composite, asking: &mut Asking<'_>, list: &mut Vec<Unmet>) {
    let before = list.len();
    composite.parts.iter().for_each(|part| collect(part, asking, list));
    let waits = |part: &Part| matches!(part.kind, PartKind::Delay(_));
    if list.len() == before
        || list.iter().skip(before).count() == composite.parts.iter().filter(|part| waits(part)).count()
    {
        let constraints = match composite.constraints.as_slice() {
            [] => "each part holds, but not together: shared variables or the order differ".to_owned(),
            some => {
                let texts: Vec<String> = some.iter().map(words::expression).collect();
                format!("each part holds, but not together with {}", texts.join(" "))
            }
        };
        list.push(Unmet { what: text(part), now: constraints, since: None, place: part.place });
    }
}

/// The PDL text of a part.
pub(super) fn text(part: &Part) -> String {
    let several = |name: &str, composite: &Composite| {
        format!("({name} {})", composite.parts.iter().map(text).collect::<Vec<_>>().join(" "))
    };
    match &part.kind {
        PartKind::Measurement(leaf) => words::measurement(&leaf.condition),
        PartKind::Episode(leaf) => words::episode(&leaf.condition),
        PartKind::Event(leaf) => words::event(&leaf.pattern, &leaf.timing),
        PartKind::TaskEnded(leaf) => task_state::ended_words(&leaf.variable),
        PartKind::TaskState(leaf) => words::task_state(&leaf.expression, &leaf.state),
        PartKind::Timestamp(leaf) => words::span(":timestamp", &leaf.from, leaf.to.as_ref()),
        PartKind::Delay(leaf) => words::span(":delay", &leaf.from, leaf.to.as_ref()),
        PartKind::And(composite) => several(":and", composite),
        PartKind::Or(composite) => several(":or", composite),
        PartKind::InOrder(composite) => several(":in-order", composite),
        PartKind::Not(inner) => format!("(:not {})", text(inner)),
    }
}

/// What is known about a part, and since when.
fn state(part: &Part, asking: &Asking<'_>) -> (String, Option<Time>) {
    let start = part.window.start;
    match &part.kind {
        PartKind::Measurement(leaf) => measurement_state(leaf, part.window, asking),
        PartKind::Episode(leaf) => episode_state(leaf, asking),
        PartKind::Event(leaf) if leaf.blind => ("older messages are no longer remembered".into(), None),
        PartKind::Event(_) => ("no such event yet".into(), (start != Time::BEGINNING).then_some(start)),
        PartKind::TaskEnded(leaf) => task_words(leaf.task, &format!("?{} is not known yet", leaf.variable), asking),
        PartKind::TaskState(leaf) => task_words(leaf.task, "the task is not known yet", asking),
        PartKind::Timestamp(leaf) => (time_state(leaf, Kind::Timestamp, start, asking), None),
        PartKind::Delay(leaf) => (time_state(leaf, Kind::Delay, start, asking), Some(start)),
        PartKind::And(_) | PartKind::Or(_) | PartKind::InOrder(_) | PartKind::Not(_) => (String::new(), None),
    }
}

fn newest(known: Option<&StateVariable>, attribute: &Symbol, asking: &Asking<'_>) -> Option<(String, Sample)> {
    let histories = asking.surroundings.histories();
    match known {
        Some(variable) => histories.get(variable)?.newest().map(|sample| (variable.to_string(), sample.clone())),
        None => histories
            .of_attribute(attribute)
            .filter_map(|(variable, history)| Some((variable.to_string(), history.newest()?.clone())))
            .max_by_key(|(_, sample)| (sample.at, sample.sequence)),
    }
}

fn measurement_state(leaf: &MeasurementPart, window: Window, asking: &Asking<'_>) -> (String, Option<Time>) {
    let Some((variable, sample)) = newest(leaf.variable.as_ref(), &leaf.condition.variable.attribute, asking) else {
        return ("no sample yet".into(), None);
    };
    let mut now = format!("{variable} = {}", sample.value);
    if sample.at < window.start {
        now.push_str(", measured before this was waited for");
    } else if leaf.blind {
        now.push_str("; older samples are no longer kept");
    } else if !measurement::has_seen_any(leaf, window, asking.surroundings) {
        now.push_str(", which is not among what this waits for");
    }
    (now, Some(sample.at))
}

fn episode_state(leaf: &EpisodePart, asking: &Asking<'_>) -> (String, Option<Time>) {
    let Some((variable, sample)) = newest(leaf.variable.as_ref(), &leaf.condition.variable.attribute, asking) else {
        return ("no sample yet".into(), None);
    };
    let run = leaf
        .runs
        .values()
        .filter_map(|state| with_newest(leaf, state).map(|run| (run, state)))
        .max_by_key(|(run, _)| run.last);
    let Some((run, state)) = run else {
        let gap = leaf.runs.values().find_map(|state| state.gap);
        let gap = gap.map(|gap| format!("; the last run was cut by a gap of {gap}")).unwrap_or_default();
        return (format!("{variable} = {}{gap}", sample.value), Some(sample.at));
    };
    let mut now = format!("{variable} = {}, holds for {} so far", sample.value, run.last - run.start);
    if let Some(most) = leaf.gap_max {
        let silence = asking.now - state.newest.at;
        if silence > most {
            now.push_str(&format!("; no sample for {silence}, more than the gap of {most} allowed"));
        } else if let Some(gap) = state.gap {
            now.push_str(&format!("; a gap of {gap} > {most} cut it before"));
        }
    }
    (now, Some(run.start))
}

fn task_words(task: Option<TaskId>, unknown: &str, asking: &Asking<'_>) -> (String, Option<Time>) {
    let Some(task) = task else { return (unknown.into(), None) };
    match asking.surroundings.task_state(task) {
        Some(state) => (format!("{task} is {state}"), asking.surroundings.task_start(task)),
        None => (format!("{task} is not known any more"), None),
    }
}

fn time_state(leaf: &TimePart, kind: Kind, start: Time, asking: &Asking<'_>) -> String {
    match span(leaf, kind, start, asking.surroundings) {
        Err(error) => error.message,
        Ok((from, _)) if from > asking.now => format!("it is {}, {from} is to come", asking.now),
        Ok((from, _)) => format!("it is {}, {from} had passed before this was waited for", asking.now),
    }
}
