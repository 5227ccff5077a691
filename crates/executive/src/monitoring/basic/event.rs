//! Event detection (M&I)
//! What: detects a message whose form matches.
//! Runs: on every message that may match; once over the remembered messages.
//! Reads: histories, evaluation context.
//! Writes: the event part of a monitor.
//! Bound: one bounded match per message.
//! PDL: any list that is not a known form; `(:atomic-episode ..)`.
//! Paper: Appendix B, atomic episodes.

use crate::expression::{EvalContext, EvaluationError};
use crate::monitoring::constraints::{RightSide, all};
use crate::monitoring::part::{ConditionFaults, PartContext, remember};
use crate::monitoring::pattern_matching::match_pattern;
use crate::state::bindings::Bindings;
use crate::state::histories::history::Occurrence;
use crate::state::monitors::monitor::{EventPart, Interest, Keep, Satisfaction, Window};
use apex_model::because::Evidence;
use apex_model::condition::{Condition, ConditionKind};
use apex_model::evidence_list::EvidenceList;
use apex_model::pattern::Pattern;
use apex_model::time::{Duration, Time};
use apex_model::value::Value;

/// Clears the results and processes the remembered messages.
pub(crate) fn backfill(
    part: &mut EventPart,
    site: PartContext,
    context: &dyn EvalContext,
    troubles: &mut ConditionFaults,
) {
    part.settled.clear();
    part.blind = !context.histories().events_cover(site.window.start);
    for Occurrence { at, sequence, form } in context.histories().events_from(site.window.start) {
        notice(part, site, form, *at, *sequence, context, troubles);
    }
}

/// Processes a message.
pub(crate) fn notice(
    part: &mut EventPart,
    site: PartContext,
    form: &Value,
    at: Time,
    sequence: u64,
    context: &dyn EvalContext,
    troubles: &mut ConditionFaults,
) {
    if !site.window.contains(at, sequence) || (site.keep == Keep::First && !part.settled.is_empty()) {
        return;
    }
    let mut bindings = Bindings::new();
    match holds(part, site, form, at, &mut bindings, context) {
        Ok(true) => {
            let evidence = EvidenceList::one(Evidence::Event { form: form.clone(), at, sequence });
            remember(
                &mut part.settled,
                Satisfaction { interval: (at, at), recognised_at: at, bindings, evidence },
                site,
                troubles,
            );
        }
        Ok(false) => {}
        Err(error) => troubles.add(error),
    }
}

fn holds(
    part: &EventPart,
    site: PartContext,
    form: &Value,
    at: Time,
    bindings: &mut Bindings,
    context: &dyn EvalContext,
) -> Result<bool, EvaluationError> {
    if !match_pattern(&part.pattern, form, bindings, context, site.place)? {
        return Ok(false);
    }
    let (stamp, timing) = (Value::Time(at), &part.timing);
    Ok(all(&timing.start, &stamp, RightSide::Instant, bindings, context, site.place)?
        && all(&timing.end, &stamp, RightSide::Instant, bindings, context, site.place)?
        && all(&timing.duration, &Value::Duration(Duration::ZERO), RightSide::Span, bindings, context, site.place)?)
}

/// Collects the patterns of the messages that a condition combines, but not those of parts that it negates or relates in time.
pub(crate) fn patterns<'a>(condition: &'a Condition, found: &mut Vec<&'a Pattern>) {
    match &condition.kind {
        ConditionKind::Event { pattern, .. } => found.push(pattern),
        ConditionKind::And(parts, _) | ConditionKind::Or(parts, _) | ConditionKind::InOrder(parts, _) => {
            parts.iter().for_each(|part| patterns(part, found));
        }
        ConditionKind::Probing { condition, .. } => patterns(condition, found),
        _ => {}
    }
}

/// Inserts messages from before the window that no step has answered in front of the found ones.
pub(crate) fn hear(
    part: &mut EventPart,
    site: PartContext,
    heard: &[Occurrence],
    context: &dyn EvalContext,
    troubles: &mut ConditionFaults,
) {
    let found = std::mem::take(&mut part.settled);
    let open = PartContext { window: Window { start: Time::BEGINNING, after_sequence: None }, ..site };
    for Occurrence { at, sequence, form } in heard {
        notice(part, open, form, *at, *sequence, context, troubles);
        if site.keep == Keep::First && !part.settled.is_empty() {
            return;
        }
    }
    for result in found {
        if !part.settled.iter().any(|known| known.evidence == result.evidence) {
            remember(&mut part.settled, result, site, troubles);
        }
    }
}

/// Returns the messages that may match.
pub(crate) fn interest(pattern: &Pattern) -> Interest {
    let head = match pattern {
        Pattern::Literal(value) => Some(value),
        Pattern::List(parts) => match parts.first() {
            Some(Pattern::Literal(value)) => Some(value),
            _ => None,
        },
        _ => None,
    };
    head.and_then(head_of).map_or(Interest::AnyEvent, Interest::EventHead)
}

/// Returns the symbol by which messages of this form are routed: its head, or the form itself.
pub(crate) fn head_of(form: &Value) -> Option<apex_model::symbol::Symbol> {
    let head = match form {
        Value::List(items) => items.first()?,
        other => other,
    };
    head.as_symbol().cloned()
}
