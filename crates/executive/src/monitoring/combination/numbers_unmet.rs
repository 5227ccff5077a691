//! Explanation of computed values (M&I)
//! What: describes the present state of a persisted value, a fitted line, a statistic or a trend that a condition waits for.
//! Runs: on request (`apex why`).
//! Reads: the part, histories, evaluation context.
//! Writes: nothing.
//! Bound: linear in the objects that are followed and in the criteria.
//! PDL: `:estimation`, `:stats`, `:trend`.
//! Paper: section V, explanation of behaviour.

use crate::monitoring::combination::unmet::{PartFacts, distance, newest};
use crate::monitoring::numbers::aggregates::CriterionResult;
use crate::monitoring::numbers::regression::{self, FittedLine, Saying};
use crate::monitoring::numbers::statistics;
use crate::monitoring::part::PartContext;
use crate::monitoring::verdict_query::VerdictQuery;
use crate::state::monitors::numbers::{PersistedPart, RegressionPart, StatisticalPart};
use apex_model::estimate::computed;
use apex_model::time::Time;

/// Describes a persisted value: its variable, its validity, and its distance from the constraint.
pub(crate) fn persisted(leaf: &PersistedPart, site: PartContext, query: &VerdictQuery<'_>) -> PartFacts {
    let attribute = &leaf.condition.variable.attribute;
    let Some((variable, sample)) = newest(leaf.variable.as_ref(), attribute, query) else {
        return PartFacts::no_sample();
    };
    let Some(held) = leaf.objects.values().max_by_key(|held| held.at) else {
        let what = format!(
            "{variable} = {} at {}, which is not a sample that this condition waits for",
            sample.value, sample.at
        );
        return PartFacts::words(what).since(Some(sample.at));
    };
    let mut now = format!("{variable} = {}, persisted since {}", held.value, held.at);
    let expires = held.at + leaf.timeout;
    let mut until = None;
    if expires < query.now {
        now.push_str(&format!("; it expired at {expires}, older than {}", leaf.timeout));
    } else if leaf.blind {
        now.push_str("; older samples are no longer kept");
    } else if held.holds.is_some() {
        until = Some(site.window.start).filter(|start| *start > query.now);
        now.push_str(", which is outside of the window");
    } else if let Some(distance) = distance(&leaf.tests, &held.value) {
        now.push_str(&format!(", {distance} off"));
    }
    let distance = distance(&leaf.tests, &held.value);
    PartFacts { until, distance, ..PartFacts::words(now).since(Some(held.at)) }
}

/// Describes a fitted line, or the reason for which there is none.
pub(crate) fn regression(leaf: &RegressionPart, site: PartContext, query: &mut VerdictQuery<'_>) -> PartFacts {
    let attribute = &leaf.condition.variable.attribute;
    let Some((variable, sample)) = newest(leaf.variable.as_ref(), attribute, query) else {
        return PartFacts::no_sample();
    };
    let sayings = regression::all(leaf, site, query);
    let Some(saying) = sayings.into_iter().last() else {
        let what =
            format!("{variable} = {} at {}, which is not a sample that the line is fitted to", sample.value, sample.at);
        return PartFacts::words(what).since(Some(sample.at));
    };
    match saying {
        Saying::Met(result) => PartFacts::words("the line meets the constraints").since(Some(result.recognised_at)),
        Saying::WillBe(at, value, line) => {
            let now = format!(
                "{}; it is {} at {at} if it continues so",
                course(&variable, &line, query.now),
                line.value(value)
            );
            PartFacts { until: Some(at), ..PartFacts::words(now).since(Some(line.last.0)) }
        }
        Saying::Unmet(line) => PartFacts::words(course(&variable, &line, query.now)).since(Some(line.last.0)),
        Saying::Unknown(refusal) => {
            PartFacts::words(format!("{variable} = {} at {}; {refusal}", sample.value, sample.at))
                .since(Some(sample.at))
        }
    }
}

fn course(variable: &str, line: &FittedLine, now: Time) -> String {
    let words = |si: Option<f64>| si.map_or("unknown".to_owned(), |si| computed(&line.value(si)));
    let moments = &line.moments;
    format!(
        "the line through {} of {variable} gives {} now, {} at the last of them, error {}",
        samples(moments.count()),
        words(moments.line_at(now)),
        words(moments.line_at(line.last.0)),
        words(moments.error())
    )
}

fn samples(count: u64) -> String {
    if count == 1 { "1 sample".to_owned() } else { format!("{count} samples") }
}

/// Describes a statistic or trend: each criterion with its present value, and the length of the run or window.
pub(crate) fn statistical(leaf: &StatisticalPart, site: PartContext, query: &VerdictQuery<'_>) -> PartFacts {
    let attribute = &leaf.condition.variable.attribute;
    let Some((variable, sample)) = newest(leaf.variable.as_ref(), attribute, query) else {
        return PartFacts::no_sample();
    };
    let mut now = format!("{variable} = {}", sample.value);
    if leaf.blind {
        now.push_str("; older samples are no longer kept");
    }
    let Some(standing) = statistics::standing(leaf, site, query) else {
        let gap = leaf.objects.values().find_map(|state| state.gap);
        now.push_str(&gap.map(|gap| format!("; the last run was cut by a gap of {gap}")).unwrap_or_default());
        return PartFacts::words(now).since(Some(sample.at));
    };
    let over =
        if leaf.slides { format!("over the last {}", leaf.duration_min) } else { format!("since {}", standing.start) };
    now.push_str(&format!("; {} {over}", samples(standing.samples)));
    let failing = standing.judgements.iter().filter(|(_, judgement)| !matches!(judgement, CriterionResult::Holds(_)));
    let mut told: Vec<String> =
        failing.map(|(criterion, judgement)| statistics::judgement_words(criterion, judgement)).collect();
    if told.is_empty() {
        told = standing
            .judgements
            .iter()
            .map(|(criterion, judgement)| statistics::judgement_words(criterion, judgement))
            .collect();
    }
    now.push_str(&format!(": {}", told.join(", ")));
    if let Some(most) = leaf.gap_max {
        let silence = query.now - sample.at;
        if silence > most {
            now.push_str(&format!("; no sample for {silence}, more than the gap of {most} allowed"));
        } else if let Some(gap) = standing.gap {
            now.push_str(&format!("; a gap of {gap} > {most} cut it before"));
        }
    }
    if let Some(at) = standing.long_enough_at {
        now.push_str(&format!("; it is long enough at {at} if it continues"));
    }
    PartFacts { until: standing.long_enough_at, ..PartFacts::words(now).since(Some(standing.start)) }
}
