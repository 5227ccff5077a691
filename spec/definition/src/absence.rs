//! Absence: a whole span without the part (rule 14).

use crate::condition::{Condition, Estimation, Kind, Span, Time};
use crate::value::Bindings;
use crate::ways::{Interval, Runs, View, Way, Ways};

/// Rule 14: a whole span passed without the part. What has passed has passed: a span that was quiet when it was looked at
/// stays so when nobody knows any more what comes after it.
pub(crate) fn ways(part: &Condition, span: Span, view: View<'_>) -> Ways {
    if at_instants(part) {
        return of_instants(part, span, view);
    }
    let Quiet { mut found, decided } = quiet_spans(part, span, view);
    if decided && !comes_to_light_later(part) {
        return found;
    }
    for now in crate::verdict::instants(view.question, view.now - 1).into_iter().rev() {
        let past = view.past.up_to(now);
        let then = quiet_spans(part, span, View { past: &past, now, ..view });
        found.all.extend(then.found.all);
        if then.decided && !comes_to_light_later(part) {
            break;
        }
    }
    found.all.sort_by_key(|way| way.hull);
    found.all.dedup();
    found
}

/// Does it hold at instants, so that a result may be gone at the next?
fn at_instants(condition: &Condition) -> bool {
    match &condition.kind {
        Kind::Measurement(measurement) => matches!(measurement.estimation, Some(Estimation::Regression(_))),
        Kind::Not(_) | Kind::Function(..) => true,
        Kind::And(parts, _) | Kind::Or(parts) | Kind::InOrder(parts, _) => parts.iter().any(at_instants),
        _ => false,
    }
}

/// What holds at instants is looked at at every instant. A span begins with the creation, after evidence that is over, or at
/// the first instant from which on the part is known not to hold; it is broken by an instant of which nobody knows.
fn of_instants(part: &Condition, span: Span, view: View<'_>) -> Ways {
    let mut found = Ways::default();
    let mut begin = Some(view.created);
    let mut passed: Vec<Time> = Vec::new();
    for now in crate::verdict::instants(view.question, view.now) {
        passed.extend(begin.filter(|begin| begin + span < now));
        let past = view.past.up_to(now);
        let against = crate::ways::ways(part, View { runs: Runs::Whole, past: &past, now, ..view });
        let there = against.all.iter().any(|way| way.open || way.instant || way.lasts == Some(now));
        (found.unknown, found.doubt) = (None, false);
        if there || against.doubt {
            begin = None;
            found.doubt = !there;
            found.unknown = against.unknown.or(Some("nobody knows whether it holds".into())).filter(|_| !there);
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

/// May evidence of the part be known only after it has begun? Then a span may have been quiet as far as was known.
fn comes_to_light_later(part: &Condition) -> bool {
    match &part.kind {
        // A value that persists is asked for at an instant to come, and its evidence is the sample before.
        Kind::Measurement(measurement) => {
            matches!(measurement.estimation, Some(Estimation::Persist(_))) && !measurement.timestamp.is_empty()
        }
        Kind::Event(..) | Kind::Delay(..) | Kind::Timestamp(..) => false,
        Kind::Or(parts) => parts.iter().any(comes_to_light_later),
        _ => true,
    }
}

/// Spans without the part, if it is known where there was none.
struct Quiet {
    found: Ways,
    decided: bool,
}

/// The spans without the part up to now. One begins with the creation, or after evidence of the part.
fn quiet_spans(part: &Condition, span: Span, view: View<'_>) -> Quiet {
    // The whole run of an episode counts, and a value as long as it persists: while they go on nothing is absent, and
    // while nobody knows whether they do, nobody knows.
    let against = crate::ways::ways(part, View { runs: Runs::Whole, ..view });
    if against.all.iter().any(|way| way.open || way.lasts == Some(view.now)) {
        return Quiet { found: Ways::default(), decided: false };
    }
    if against.doubt {
        let unknown = against.unknown.or_else(|| Some("nobody knows whether it goes on".into()));
        return Quiet { found: Ways { all: Vec::new(), unknown, doubt: true }, decided: false };
    }
    // A span begins with the creation, its instant included; after the end of evidence, its instant excluded; or at the
    // instant at which a value persists no more.
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

/// The evidence, and on as long as what it rests on persists.
fn lasting(way: &Way) -> Option<Interval> {
    way.hull.map(|(start, end)| (start, way.lasts.map_or(end, |lasts| lasts.max(end))))
}
