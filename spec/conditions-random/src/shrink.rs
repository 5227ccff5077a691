//! Reduces a question that is answered differently to a small one.

use crate::compare::{Finding, compare};
use apex_definition::Question;
use apex_definition::condition::{Condition, Cyclic, Episode, Kind, Measurement};

/// Returns a minimal question that is still answered differently, found by removing one part after another.
pub fn shrink(question: &Question) -> Question {
    let mut smallest = question.clone();
    while let Some(smaller) = simpler(&smallest).into_iter().find(differs) {
        smallest = smaller;
    }
    smallest
}

fn differs(question: &Question) -> bool {
    matches!(compare(question), Finding::Different(_))
}

/// Questions with one part removed.
fn simpler(question: &Question) -> Vec<Question> {
    let mut found = Vec::new();
    for index in 0..question.arrivals.len() {
        let mut less = question.clone();
        less.arrivals.remove(index);
        found.push(less);
    }
    for condition in less_of(&question.condition) {
        found.push(Question { condition, ..question.clone() });
    }
    if question.created > 0 {
        found.push(Question { created: 0, ..question.clone() });
    }
    if !question.lateness.is_empty() {
        found.push(Question { lateness: Default::default(), ..question.clone() });
    }
    found
}

fn less_of(condition: &Condition) -> Vec<Condition> {
    let with = |kind: Kind| Condition { tag: condition.tag.clone(), kind };
    let mut found = Vec::new();
    match &condition.kind {
        Kind::And(parts, tests) => {
            found.extend(parts.iter().cloned());
            found.extend(shorter(parts, 1).into_iter().map(|parts| with(Kind::And(parts, Vec::new()))));
            found.extend(shorter(tests, 0).into_iter().map(|tests| with(Kind::And(parts.clone(), tests))));
            found.extend(changed(parts).into_iter().map(|parts| with(Kind::And(parts, tests.clone()))));
        }
        Kind::Or(parts) => {
            found.extend(parts.iter().cloned());
            found.extend(shorter(parts, 1).into_iter().chain(changed(parts)).map(|parts| with(Kind::Or(parts))));
        }
        Kind::InOrder(parts, tests) => {
            found.extend(parts.iter().cloned());
            found.extend(shorter(parts, 2).into_iter().map(|parts| with(Kind::InOrder(parts, Vec::new()))));
            found.extend(shorter(tests, 0).into_iter().map(|tests| with(Kind::InOrder(parts.clone(), tests))));
            found.extend(changed(parts).into_iter().map(|parts| with(Kind::InOrder(parts, tests.clone()))));
        }
        Kind::Allen { relation, parts, tolerance, tests } => {
            let again =
                |parts: Vec<Condition>, tests| Kind::Allen { relation: *relation, parts, tolerance: *tolerance, tests };
            found.extend(parts.iter().cloned());
            found.extend(shorter(parts, 2).into_iter().map(|parts| with(again(parts, Vec::new()))));
            found.extend(shorter(tests, 0).into_iter().map(|tests| with(again(parts.clone(), tests))));
            found.extend(changed(parts).into_iter().map(|parts| with(again(parts, tests.clone()))));
            if *tolerance > 0 {
                let (relation, parts, tests) = (*relation, parts.clone(), tests.clone());
                found.push(with(Kind::Allen { relation, parts, tolerance: 0, tests }));
            }
        }
        Kind::Not(part) => {
            found.push((**part).clone());
            found.extend(less_of(part).into_iter().map(|part| with(Kind::Not(Box::new(part)))));
        }
        Kind::Absent(part, span) => {
            found.push((**part).clone());
            found.extend(less_of(part).into_iter().map(|part| with(Kind::Absent(Box::new(part), *span))));
        }
        Kind::Episode(episode) => {
            found.extend(less_of_episode(episode).into_iter().map(|episode| with(Kind::Episode(episode))));
        }
        Kind::Measurement(measurement) => {
            let all = less_of_measurement(measurement);
            found.extend(all.into_iter().map(|measurement| with(Kind::Measurement(measurement))));
        }
        Kind::Event(pattern, when) => {
            found.extend(shorter(when, 0).into_iter().map(|when| with(Kind::Event(pattern.clone(), when))));
        }
        Kind::Cyclic(cyclic) => {
            let all = less_of_cyclic(cyclic);
            found.extend(all.into_iter().map(|cyclic| with(Kind::Cyclic(cyclic))));
        }
        Kind::Delay(least, Some(_)) => found.push(with(Kind::Delay(*least, None))),
        Kind::Timestamp(from, Some(_)) => found.push(with(Kind::Timestamp(*from, None))),
        Kind::Delay(..) | Kind::Timestamp(..) | Kind::Function(..) | Kind::TaskEnded(_) | Kind::TaskState(..) => {}
    }
    found
}

fn less_of_episode(episode: &Episode) -> Vec<Episode> {
    let mut found = Vec::new();
    let mut with = |change: &dyn Fn(&mut Episode)| {
        let mut less = episode.clone();
        change(&mut less);
        if less != *episode {
            found.push(less);
        }
    };
    with(&|less| less.variable.tests.clear());
    with(&|less| less.value.clear());
    with(&|less| less.first_value.clear());
    with(&|less| less.last_value.clear());
    with(&|less| less.start.clear());
    with(&|less| less.end.clear());
    with(&|less| less.duration.clear());
    with(&|less| less.stats.clear());
    with(&|less| less.trend.clear());
    with(&|less| less.gap = None);
    with(&|less| less.any = false);
    found
}

fn less_of_cyclic(cyclic: &Cyclic) -> Vec<Cyclic> {
    let mut found = Vec::new();
    let mut with = |change: &dyn Fn(&mut Cyclic)| {
        let mut less = cyclic.clone();
        change(&mut less);
        if less != *cyclic {
            found.push(less);
        }
    };
    with(&|less| less.variable.tests.clear());
    with(&|less| less.amplitude.clear());
    with(&|less| less.cycles.clear());
    with(&|less| less.hysteresis = None);
    found
}

fn less_of_measurement(measurement: &Measurement) -> Vec<Measurement> {
    let mut found = Vec::new();
    let mut with = |change: &dyn Fn(&mut Measurement)| {
        let mut less = measurement.clone();
        change(&mut less);
        if less != *measurement {
            found.push(less);
        }
    };
    with(&|less| less.variable.tests.clear());
    with(&|less| less.value.truncate(1));
    with(&|less| less.timestamp.clear());
    with(&|less| less.estimation = None);
    found
}

/// Returns the list without one of its items, not shorter than `least`.
fn shorter<T: Clone>(items: &[T], least: usize) -> Vec<Vec<T>> {
    let without = |index: usize| {
        let mut less = items.to_vec();
        less.remove(index);
        less
    };
    if items.len() <= least { Vec::new() } else { (0..items.len()).map(without).collect() }
}

/// Returns the lists in which one part is simpler.
fn changed(parts: &[Condition]) -> Vec<Vec<Condition>> {
    let mut found = Vec::new();
    for (index, part) in parts.iter().enumerate() {
        for less in less_of(part) {
            let mut parts = parts.to_vec();
            if let Some(place) = parts.get_mut(index) {
                *place = less;
            }
            found.push(parts);
        }
    }
    found
}
