//! Absence: a whole span without evidence of the part (rule 14).

use crate::condition::{Condition, Estimation, Kind, Span, Term, Time, Variable};
use crate::history::{Arrival, Past, What, known};
use crate::value::{Bindings, Value};
use crate::verdict::Question;
use crate::ways::{Interval, Runs, View, Way, Ways};

/// Rule 14: a whole span has passed without evidence of the part. A span that had passed without evidence when it was judged stays valid,
/// even if it is unknown what follows it.
pub(crate) fn ways(part: &Condition, span: Span, view: View<'_>) -> Ways {
    if at_instants(part) {
        return of_instants(part, span, view);
    }
    let Quiet { mut found, decided } = quiet_spans(part, span, view);
    let again = is_judged_again(part, view);
    if again && decided && !comes_to_light_later(part) {
        return found;
    }
    for now in crate::verdict::instants(view.question, view.now - 1).into_iter().rev() {
        let (past, back) = known_of(part, now, again, view);
        let then = quiet_spans(part, span, View { past: &past, now, ..view });
        let stays = |way: &Way| way.hull.is_some_and(|(_, end)| back.is_none_or(|back| end < back));
        found.all.extend(then.found.all.into_iter().filter(stays));
        if again && then.decided && !comes_to_light_later(part) {
            break;
        }
    }
    found.all.sort_by_key(|way| way.hull);
    found.all.dedup();
    found
}

/// Rule 17: returns true if past instants are judged again when a sample comes late. They are if a variable of the part is declared with
/// `:lateness`, or if nothing of the part comes late, which gives the same result.
fn is_judged_again(part: &Condition, view: View<'_>) -> bool {
    let watched = variables(part);
    let is_late = |arrival: &Arrival| arrival.at < arrival.arrives && watched.iter().any(|each| is_of(arrival, each));
    watched.iter().any(|each| view.question.lateness.contains_key(&each.attribute))
        || !view.question.arrivals.iter().any(is_late)
}

/// Returns the knowledge by which an instant is judged: all of it if the instant is judged `again`, otherwise the part that arrived
/// before the first sample from after the instant. Also returns the earliest sample that arrived since: a span that had reached it
/// is no longer known to have passed.
fn known_of(part: &Condition, then: Time, again: bool, view: View<'_>) -> (Past, Option<Time>) {
    // The value of a function at an instant cannot be queried later, so the instant is judged by the knowledge at that time.
    if asks_functions(part) {
        return (known(&view.question.arrivals, &view.question.lateness, then.min(view.past.known_at)), None);
    }
    if again {
        return (view.past.up_to(then), None);
    }
    let (question, watched) = (view.question, variables(part));
    let counts = |number: usize, arrival: &Arrival| {
        watched.iter().any(|each| is_of(arrival, each)) && changes(question, number, arrival)
    };
    let come: Vec<&Arrival> =
        question.arrivals.iter().filter(|arrival| arrival.arrives <= view.past.known_at).collect();
    let after = come.iter().enumerate().find(|(number, arrival)| arrival.at > then && counts(*number, arrival));
    let before = after.map_or(come.len(), |(number, _)| number);
    let since = come.iter().enumerate().skip(before);
    let back = since.filter(|(number, arrival)| counts(*number, arrival)).map(|(_, arrival)| arrival.at);
    let back = back.filter(|at| *at >= view.created).min();
    let past = known(&question.arrivals[..before], &question.lateness, view.past.known_at);
    (past.up_to(then), back)
}

/// Returns true if the condition calls a function.
fn asks_functions(condition: &Condition) -> bool {
    match &condition.kind {
        Kind::Function(..) => true,
        Kind::And(parts, _) | Kind::Or(parts) | Kind::InOrder(parts, _) | Kind::Allen { parts, .. } => {
            parts.iter().any(asks_functions)
        }
        Kind::Not(part) | Kind::Absent(part, _) => asks_functions(part),
        _ => false,
    }
}

/// Returns true if the sample counts when it arrives.
fn changes(question: &Question, number: usize, arrival: &Arrival) -> bool {
    let count = |end: usize| {
        let past = known(&question.arrivals[..end], &question.lateness, arrival.arrives);
        let all = past.variables.into_iter().map(|series| (series.attribute, series.object, series.samples));
        all.collect::<Vec<_>>()
    };
    count(number) != count(number + 1)
}

fn is_of(arrival: &Arrival, variable: &Variable) -> bool {
    match &arrival.what {
        What::Sample(attribute, object, _) => {
            let is = |wanted: &Value| *wanted == Value::symbol(object);
            *attribute == variable.attribute && !matches!(&variable.object, Term::Is(wanted) if !is(wanted))
        }
        What::Message(_) | What::Moved(..) => false,
    }
}

/// Returns the variables that the condition watches.
fn variables(condition: &Condition) -> Vec<&Variable> {
    match &condition.kind {
        Kind::Measurement(measurement) => vec![&measurement.variable],
        Kind::Episode(episode) => vec![&episode.variable],
        Kind::Cyclic(cyclic) => vec![&cyclic.variable],
        Kind::And(parts, _) | Kind::Or(parts) | Kind::InOrder(parts, _) | Kind::Allen { parts, .. } => {
            parts.iter().flat_map(variables).collect()
        }
        Kind::Not(part) | Kind::Absent(part, _) => variables(part),
        _ => Vec::new(),
    }
}

/// Returns true if the condition holds at instants, so that the next sample may end its result.
fn at_instants(condition: &Condition) -> bool {
    match &condition.kind {
        Kind::Measurement(measurement) => matches!(measurement.estimation, Some(Estimation::Regression(_))),
        Kind::Not(_) | Kind::Function(..) => true,
        Kind::And(parts, _) | Kind::Or(parts) | Kind::InOrder(parts, _) => parts.iter().any(at_instants),
        _ => false,
    }
}

/// Returns the ways of a condition that holds at instants, judged at each of them. A span begins with the creation, after evidence that
/// has ended, or at the first instant at which the part is known not to hold; an unknown instant ends the span.
fn of_instants(part: &Condition, span: Span, view: View<'_>) -> Ways {
    let mut found = Ways::default();
    let mut begin = Some(view.created);
    let mut passed: Vec<Time> = Vec::new();
    let again = is_judged_again(part, view);
    for now in crate::verdict::instants(view.question, view.now) {
        let (past, back) = known_of(part, now, again, view);
        passed.extend(begin.filter(|begin| begin + span < now && back.is_none_or(|back| begin + span < back)));
        let against = crate::ways::ways(part, View { runs: Runs::Whole, past: &past, now, ..view });
        let there = against.all.iter().any(|way| way.open || way.instant || way.lasts == Some(now));
        (found.unknown, found.doubt) = (None, false);
        if there || against.doubt {
            begin = None;
            found.doubt = !there;
            found.unknown = against.unknown.or(Some("unknown whether it holds".into())).filter(|_| !there);
            continue;
        }
        let ends = against.all.iter().filter_map(|way| match (way.hull, way.lasts) {
            (Some((_, end)), Some(lasts)) if lasts > end => Some(lasts + 1),
            (hull, _) => hull.map(|(_, end)| end),
        });
        begin = ends.chain([begin.unwrap_or(now)]).max();
    }
    passed.extend(begin.filter(|begin| begin + span <= view.now));
    passed.dedup();
    found.all =
        passed.into_iter().map(|begin| Way::over((begin, begin + span), begin + span, Bindings::new())).collect();
    found
}

/// Returns true if evidence of the part may become known only after it has begun. Until then a span counts as without evidence.
fn comes_to_light_later(part: &Condition) -> bool {
    match &part.kind {
        // A persistent value is required at a later instant, and its evidence is the sample before.
        Kind::Measurement(measurement) => {
            matches!(measurement.estimation, Some(Estimation::Persist(_))) && !measurement.timestamp.is_empty()
        }
        Kind::Event(..) | Kind::Delay(..) | Kind::Timestamp(..) => false,
        Kind::Or(parts) => parts.iter().any(comes_to_light_later),
        _ => true,
    }
}

/// Spans without the part, as far as that is known.
struct Quiet {
    found: Ways,
    decided: bool,
}

/// Returns the spans without the part up to now. A span begins with the creation, or after evidence of the part.
fn quiet_spans(part: &Condition, span: Span, view: View<'_>) -> Quiet {
    // The whole run of an episode counts, and a value for as long as it persists. While they continue the part is not absent, and while
    // their continuation is unknown, absence is unknown.
    let against = crate::ways::ways(part, View { runs: Runs::Whole, ..view });
    if against.all.iter().any(|way| way.open || way.lasts == Some(view.now)) {
        return Quiet { found: Ways::default(), decided: false };
    }
    if against.doubt {
        let unknown = against.unknown.or_else(|| Some("unknown whether it continues".into()));
        return Quiet { found: Ways { all: Vec::new(), unknown, doubt: true }, decided: false };
    }
    // A span begins with the creation, including its instant; after the end of evidence, excluding its instant; or at the instant at
    // which a value no longer persists.
    let mut spans = vec![(view.created, view.created)];
    for way in against.all.iter().filter(|way| lasting(way).is_some_and(|(_, end)| end >= view.created)) {
        spans.extend(match (way.lasts, way.hull) {
            (Some(lasts), Some((_, end))) if lasts > end => Some((lasts + 1, lasts + 1)),
            (_, hull) => hull.map(|(_, end)| (end, end + 1)),
        });
    }
    spans.sort_unstable();
    spans.dedup();
    let there = |way: &Way, begin: Time, first: Time| match (way.hull, way.lasts) {
        (Some((start, end)), Some(lasts)) if lasts > end => lasts >= begin && start <= begin + span,
        (hull, _) => hull.is_some_and(|(start, end)| end >= first && start <= begin + span),
    };
    let quiet = |begin: Time, first: Time| !against.all.iter().any(|way| there(way, begin, first));
    let passed = spans.into_iter().filter(|(begin, first)| begin + span <= view.now && quiet(*begin, *first));
    let ways: Vec<Way> =
        passed.map(|(begin, _)| Way::over((begin, begin + span), begin + span, Bindings::new())).collect();
    Quiet { found: ways.into(), decided: true }
}

/// Returns the evidence, extended for as long as the values that it is based on persist.
fn lasting(way: &Way) -> Option<Interval> {
    way.hull.map(|(start, end)| (start, way.lasts.map_or(end, |lasts| lasts.max(end))))
}
