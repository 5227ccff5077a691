//! Features of a question, for counts and to distinguish kinds of differences.

use apex_definition::condition::{Condition, Constraint, Cyclic, Estimation, Kind, Statistic, Term};
use apex_definition::{Question, Value, What};
use std::collections::BTreeSet;

/// Returns the forms and odd data of a question.
pub fn features(question: &Question) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    of_condition(&question.condition, &mut found);
    if question.created > 0 {
        found.insert("created later".into());
    }
    let mut seen = BTreeSet::new();
    for arrival in &question.arrivals {
        match &arrival.what {
            What::Sample(_, _, None) => {
                found.insert("not a number".into());
            }
            What::Sample(_, _, Some(Value::Number(number))) if number.is_infinite() => {
                found.insert("infinity".into());
            }
            What::Sample(attribute, object, _) => {
                if !seen.insert((attribute.clone(), object.clone(), arrival.at)) {
                    found.insert("duplicate".into());
                }
            }
            What::Message(_) | What::Moved(..) => {}
        }
        if arrival.at < arrival.arrives {
            found.insert("late".into());
        }
    }
    if !question.lateness.is_empty() {
        found.insert(":lateness".into());
    }
    found
}

/// Returns true if the condition holds at instants, so that the next sample may end its result.
fn at_instants(condition: &Condition) -> bool {
    match &condition.kind {
        Kind::Measurement(measurement) => matches!(measurement.estimation, Some(Estimation::Regression(_))),
        Kind::Not(_) | Kind::Function(..) => true,
        Kind::And(parts, _) | Kind::Or(parts) | Kind::InOrder(parts, _) | Kind::Allen { parts, .. } => {
            parts.iter().any(at_instants)
        }
        Kind::Absent(part, _) => at_instants(part),
        _ => false,
    }
}

fn parts(condition: &Condition) -> &[Condition] {
    match &condition.kind {
        Kind::And(parts, _) | Kind::Or(parts) | Kind::InOrder(parts, _) | Kind::Allen { parts, .. } => parts,
        Kind::Not(part) | Kind::Absent(part, _) => std::slice::from_ref(&**part),
        _ => &[],
    }
}

fn is_weighted(statistic: Statistic) -> bool {
    use Statistic::{TimeWeightedDeviation, TimeWeightedMean, TimeWeightedVariance};
    matches!(statistic, TimeWeightedMean | TimeWeightedVariance | TimeWeightedDeviation)
}

fn of_cyclic(cyclic: &Cyclic) -> Vec<&'static str> {
    let parts = [
        (":cyclic", true),
        (":amplitude", !cyclic.amplitude.is_empty()),
        (":cycles", !cyclic.cycles.is_empty()),
        (":hysteresis", cyclic.hysteresis.is_some()),
    ];
    parts.into_iter().filter(|(_, has)| *has).map(|(name, _)| name).collect()
}

fn of_condition(condition: &Condition, found: &mut BTreeSet<String>) {
    let mut add = |what: &str| {
        found.insert(what.into());
    };
    match &condition.kind {
        Kind::Measurement(measurement) => {
            add(":measurement");
            match &measurement.estimation {
                Some(Estimation::Persist(None)) => add(":persist"),
                Some(Estimation::Persist(Some(_))) => add(":persist with a timeout"),
                Some(Estimation::Regression(_)) => add(":linear-regression"),
                None => {}
            }
            if !measurement.timestamp.is_empty() {
                add(":timestamp of a measurement");
            }
            if matches!(measurement.variable.object, Term::Variable(_)) {
                add("object variable");
            }
            if measurement.value.iter().any(|constraint| matches!(constraint, Constraint::Bind(_))) {
                add("= ?x");
            }
        }
        Kind::Episode(episode) => {
            add(if episode.gap.is_some() { ":episode with a gap" } else { ":episode" });
            let parts = [
                (":first-value", !episode.first_value.is_empty()),
                (":last-value", !episode.last_value.is_empty()),
                (":duration", !episode.duration.is_empty()),
                (":start or :end", !episode.start.is_empty() || !episode.end.is_empty()),
                (":stats", !episode.stats.is_empty()),
                (":time-weighted", episode.stats.iter().any(|(statistic, ..)| is_weighted(*statistic))),
                (":trend", !episode.trend.is_empty()),
                ("object variable", matches!(episode.variable.object, Term::Variable(_))),
                ("no :value", episode.value.is_empty()),
                (":any", episode.any),
            ];
            parts.into_iter().filter(|(_, has)| *has).for_each(|(name, _)| add(name));
        }
        Kind::Cyclic(cyclic) => of_cyclic(cyclic).iter().for_each(|what| add(what)),
        Kind::And(_, tests) => add(if tests.is_empty() { ":and" } else { ":and with :constraint" }),
        Kind::Or(_) => add(":or"),
        Kind::Not(_) => add(":not"),
        Kind::Absent(part, _) => {
            add(":absent");
            if at_instants(part) {
                add(":absent of an instant");
            }
        }
        Kind::InOrder(_, tests) => add(if tests.is_empty() { ":in-order" } else { ":in-order with :constraint" }),
        Kind::Allen { relation, tolerance, .. } => {
            add(&format!("Allen {relation:?}"));
            if *tolerance > 0 {
                add(":tolerance");
            }
        }
        Kind::Delay(..) => add(":delay"),
        Kind::Timestamp(..) => add(":timestamp"),
        Kind::Event(_, when) => add(if when.is_empty() { "event" } else { "event with :timing" }),
        Kind::Function(..) => add(":function"),
        Kind::TaskEnded(_) | Kind::TaskState(..) => add("task"),
    }
    parts(condition).iter().for_each(|part| of_condition(part, found));
}
