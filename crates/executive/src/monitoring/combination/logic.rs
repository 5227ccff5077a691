//! Logic and order (M&I)
//! What: combines the results of parts: all of them, one of them, none, or in sequence.
//! Runs: whenever the verdict is requested.
//! Reads: the monitor's tree, evaluation context.
//! Writes: nothing.
//! Bound: O(parts) where parts share nothing; else `MONITOR_COMBINATIONS_MAX` combinations.
//! PDL: `:and`, `:or`, `:not`, `:in-order`, `:delay`, `:constraint`.
//! Paper: Table 1, rows 11 and 12; Appendix B.

use crate::expression::{WithBindings, evaluate};
use crate::monitoring::basic::time_conditions::{self, TimeForm, delays};
use crate::monitoring::basic::{measurement, task_state};
use crate::monitoring::combination::{absence, allen, dominance, point_order};
use crate::monitoring::episodes::episode;
use crate::monitoring::numbers::{cyclic, persistence, regression, statistics};
use crate::monitoring::part::Truth;
use crate::monitoring::time_bounds::TICK;
use crate::monitoring::verdict_query::VerdictQuery;
use crate::state::bindings::{Bindings, joined};
use crate::state::monitors::monitor::{Composite, Keep, Part, PartKind, Satisfaction};
use apex_model::agent_limits::Limit;
use apex_model::because::Evidence;
use apex_model::evidence_list::EvidenceList;
use apex_model::expression::Expr;
use apex_model::symbol::Symbol;
use apex_model::time::{Duration, Time};
use apex_model::value::Value;

/// Returns the truth of the part now. A part that dropped results at a limit is not certainly false; [`combined`] decides whether that
/// matters for a part that combines others.
pub(crate) fn truth(part: &Part, query: &mut VerdictQuery<'_>) -> Truth {
    let combines = matches!(part.kind, PartKind::And(_) | PartKind::Or(_) | PartKind::InOrder(_) | PartKind::Not(_));
    match truth_of_kind(part, query) {
        Truth::False if part.forgotten && !combines => Truth::Unknown,
        truth => truth,
    }
}

fn truth_of_kind(part: &Part, query: &mut VerdictQuery<'_>) -> Truth {
    let site = crate::monitoring::part::site(part);
    match &part.kind {
        PartKind::Measurement(leaf) => Truth::of(measurement::any(leaf), leaf.blind),
        PartKind::Episode(leaf) => episode::truth(leaf, site, query.now, query.context, &mut query.troubles),
        PartKind::Persisted(leaf) => persistence::truth(leaf, site, query),
        PartKind::Regression(leaf) => regression::truth(leaf, site, query),
        PartKind::Statistical(leaf) => statistics::truth(leaf, site, query),
        PartKind::Cyclic(leaf) => cyclic::truth(leaf, site, query),
        PartKind::Event(leaf) => Truth::of(any_by(&leaf.settled, query.now), leaf.blind),
        PartKind::TaskEnded(leaf) => Truth::of(leaf.ended.is_some_and(|ended| ended <= query.now), leaf.task.is_none()),
        PartKind::TaskState(leaf) => Truth::of(any_by(&leaf.settled, query.now), leaf.task.is_none()),
        PartKind::Timestamp(leaf) | PartKind::Delay(leaf) => {
            Truth::of(leaf.reached.is_some_and(|reached| reached <= query.now), leaf.span.is_none())
        }
        PartKind::Not(inner) => query.of_everything(|query| truth(inner, query)).negated(),
        PartKind::Allen(leaf) => allen::truth(leaf, query),
        PartKind::Absent(leaf) => absence::truth(leaf),
        PartKind::Function(leaf) => Truth::of(leaf.holds.is_some(), leaf.value.is_none()),
        PartKind::And(composite) => {
            let all =
                composite.parts.iter().fold(Truth::True, |all, part| all.min(truth_beside(part, composite, query)));
            combined(part, composite, all, query)
        }
        PartKind::InOrder(composite) => {
            let all = composite
                .parts
                .iter()
                .filter(|part| !matches!(part.kind, PartKind::Delay(_)))
                .fold(Truth::True, |all, part| all.min(truth(part, query)));
            combined(part, composite, all, query)
        }
        PartKind::Or(composite) => {
            let one = composite.parts.iter().fold(Truth::False, |one, part| one.max(truth(part, query)));
            combined(part, composite, one, query)
        }
    }
}

/// Returns true for messages, tasks and time: results may have arrived since the instant that is evaluated again.
fn comes_at_an_instant(kind: &PartKind) -> bool {
    use PartKind::{Delay, Event, TaskEnded, TaskState, Timestamp};
    matches!(kind, Event(_) | TaskEnded(_) | TaskState(_) | Timestamp(_) | Delay(_))
}

/// Returns true if a result was known at `now`. When an earlier instant is evaluated again, later results are known too.
fn any_by(settled: &[Satisfaction], now: Time) -> bool {
    settled.iter().any(|result| result.recognised_at <= now)
}

/// Returns the truth of a part of an `:and`. Negated shared variables can be judged only in combination.
fn truth_beside(part: &Part, composite: &Composite, query: &mut VerdictQuery<'_>) -> Truth {
    let inner = match &part.kind {
        PartKind::Not(inner) if composite.combines => inner,
        _ => return truth(part, query),
    };
    let stands_alone = |result: &Satisfaction| composite.shared.iter().all(|name| result.bindings.get(name).is_none());
    query.of_everything(|query| match truth(inner, query) {
        // The result agrees with every result of the other parts, because it binds no variable that they bind.
        Truth::True if results(inner, query).iter().any(stands_alone) => Truth::False,
        // A result that was dropped at a limit might have agreed.
        Truth::True if inner.forgotten => Truth::Unknown,
        Truth::True | Truth::False => Truth::True,
        Truth::Unknown => Truth::Unknown,
    })
}

fn combined(part: &Part, composite: &Composite, separately: Truth, query: &mut VerdictQuery<'_>) -> Truth {
    if !composite.combines || separately != Truth::True {
        return separately;
    }
    let before = query.troubles.limits_reached;
    match results(part, query).is_empty() {
        false => Truth::True,
        true if part.forgotten || query.troubles.limits_reached > before => Truth::Unknown,
        true => Truth::False,
    }
}

/// Returns all results of the part up to now, earliest recognised first, with the part's tag bound.
pub(crate) fn results(part: &Part, query: &mut VerdictQuery<'_>) -> Vec<Satisfaction> {
    let site = crate::monitoring::part::site(part);
    let mut results = match &part.kind {
        PartKind::Measurement(leaf) => measurement::results(leaf),
        PartKind::Episode(leaf) => episode::results(leaf, site, query.now, query.context, &mut query.troubles),
        PartKind::Persisted(leaf) => persistence::results(leaf, site, query),
        PartKind::Regression(leaf) => regression::results(leaf, site, query),
        PartKind::Statistical(leaf) => statistics::results(leaf, site, query),
        PartKind::Cyclic(leaf) => cyclic::results(leaf, site, query),
        PartKind::Event(leaf) => leaf.settled.clone(),
        PartKind::TaskEnded(leaf) => task_state::ended_result(leaf).into_iter().collect(),
        PartKind::TaskState(leaf) => leaf.settled.clone(),
        PartKind::Timestamp(leaf) => {
            time_conditions::result(leaf, TimeForm::Timestamp, site.window.start).into_iter().collect()
        }
        PartKind::Delay(leaf) => {
            time_conditions::result(leaf, TimeForm::Delay, site.window.start).into_iter().collect()
        }
        PartKind::Not(inner) => match query.of_everything(|query| truth(inner, query)) {
            Truth::False => vec![nothing_until(inner, query.now)],
            Truth::True | Truth::Unknown => Vec::new(),
        },
        PartKind::Allen(leaf) => allen::results(leaf),
        PartKind::Absent(leaf) => leaf.found.clone(),
        PartKind::Function(leaf) => leaf.holds.clone().into_iter().collect(),
        PartKind::And(composite) => Combination::new(part, composite, false).run(query),
        PartKind::InOrder(composite) => match &composite.order {
            Some(order) => point_order::results(part, composite, order, query),
            None => Combination::new(part, composite, true).run(query),
        },
        PartKind::Or(composite) => alternatives(part, composite, query),
    };
    if comes_at_an_instant(&part.kind) {
        results.retain(|result| result.recognised_at <= query.now);
    }
    if let Some(used) = &query.used {
        results.retain(|result| !used.contains(part.place, result));
    }
    if let Some(tag) = &part.tag {
        for result in &mut results {
            result.bindings.set(tag.clone(), Value::Interval(result.interval.0, result.interval.1));
        }
    }
    results.sort_by_key(|result| result.recognised_at);
    results
}

/// Returns the result of the part that was recognised first, as [`results`] would list it.
pub(crate) fn first_result(part: &Part, query: &mut VerdictQuery<'_>) -> Option<Satisfaction> {
    match (&part.kind, &part.tag) {
        (PartKind::Measurement(leaf), None) => measurement::first_result(leaf),
        (PartKind::Event(leaf), None) => leaf.settled.iter().min_by_key(|result| result.recognised_at).cloned(),
        _ => results(part, query).into_iter().next(),
    }
}

fn nothing_until(inner: &Part, now: Time) -> Satisfaction {
    let evidence = EvidenceList::one(absence(inner, now));
    Satisfaction { interval: (now, now), recognised_at: now, bindings: Bindings::new(), evidence }
}

fn absence(inner: &Part, at: Time) -> Evidence {
    Evidence::Absence { what: crate::monitoring::combination::unmet::text(inner), at }
}

fn alternatives(part: &Part, composite: &Composite, query: &mut VerdictQuery<'_>) -> Vec<Satisfaction> {
    let mut all: Vec<Satisfaction> = composite.parts.iter().flat_map(|part| results(part, query)).collect();
    all.retain(|result| alternative_holds(part.tag.as_ref(), &composite.constraints, result, query));
    all
}

/// Returns true if the constraints on this tag of an `:or` are satisfied by the result of one of its parts.
pub(crate) fn alternative_holds(
    tag: Option<&Symbol>,
    constraints: &[Expr],
    result: &Satisfaction,
    query: &mut VerdictQuery<'_>,
) -> bool {
    constraints_hold(tag, constraints, result.interval, &result.bindings, query)
}

/// Returns true if all `constraints` hold for a result. They see its bindings and its own `tag`.
pub(crate) fn constraints_hold(
    tag: Option<&Symbol>,
    constraints: &[Expr],
    interval: (Time, Time),
    bindings: &Bindings,
    query: &mut VerdictQuery<'_>,
) -> bool {
    if constraints.is_empty() {
        return true;
    }
    let mut bindings = bindings.clone();
    if let Some(tag) = tag {
        bindings.set(tag.clone(), Value::Interval(interval.0, interval.1));
    }
    let seen = WithBindings { below: query.context, bindings: &bindings };
    for constraint in constraints {
        match evaluate(constraint, &seen) {
            Ok(value) if value.is_true() => {}
            Ok(_) => return false,
            Err(error) => {
                query.troubles.add(error);
                return false;
            }
        }
    }
    true
}

/// The search for combinations of results that agree.
struct Combination<'a> {
    part: &'a Part,
    composite: &'a Composite,
    ordered: bool,
    combinations: u64,
    found: Vec<Satisfaction>,
}

/// A combination of the results of the first parts.
#[derive(Clone)]
struct Partial {
    hull: Option<(Time, Time)>,
    /// End of the last part, or the window's start: the next part must come after it.
    end: Time,
    recognised_at: Time,
    bindings: Bindings,
    evidence: EvidenceList,
}

/// A part with its results, and the required delay before it.
struct SequencePart {
    results: Vec<Satisfaction>,
    /// Start of the first and of the last result.
    extent: Option<(Time, Time)>,
    delay: Option<(Duration, Duration)>,
    /// The part is a `:not`: true now, and at any later instant as long as nothing happens.
    stands: bool,
}

impl SequencePart {
    /// Returns false if none of the results comes late enough behind a part that ended at `end`, or none early enough.
    fn may_follow(&self, end: Time) -> bool {
        let (least, most) = self.delay.unwrap_or((TICK, Duration::MAX));
        let starts = self.extent.is_some_and(|(first, last)| last - end >= least && first - end <= most);
        self.stands || starts
    }
}

impl<'a> Combination<'a> {
    fn new(part: &'a Part, composite: &'a Composite, ordered: bool) -> Combination<'a> {
        Combination { part, composite, ordered, combinations: 0, found: Vec::new() }
    }

    fn run(mut self, query: &mut VerdictQuery<'_>) -> Vec<Satisfaction> {
        let mut steps = Vec::new();
        let mut nots = Vec::new();
        let mut absent = Vec::new();
        let mut delay = None;
        for (number, part) in self.composite.parts.iter().enumerate() {
            match &part.kind {
                PartKind::Delay(leaf) if self.ordered => match delays(leaf, query.context) {
                    // Consecutive delays add up.
                    Ok((least, most)) => {
                        let (before, before_most) = delay.unwrap_or((Duration::ZERO, Duration::ZERO));
                        delay = Some((before + least, before_most + most));
                    }
                    Err(error) => {
                        query.troubles.add(error);
                        return Vec::new();
                    }
                },
                PartKind::Not(inner) if !self.ordered && self.composite.combines => {
                    if inner.forgotten || query.of_everything(|query| truth(inner, query)) == Truth::Unknown {
                        return Vec::new();
                    }
                    absent.push(absence(inner, query.now));
                    nots.push(query.of_everything(|query| results(inner, query)));
                }
                PartKind::Not(inner) if !self.ordered => match query.of_everything(|query| truth(inner, query)) {
                    Truth::False => {
                        absent.push(absence(inner, query.now));
                        nots.push(Vec::new());
                    }
                    Truth::True | Truth::Unknown => return Vec::new(),
                },
                kind => {
                    let mut results = results(part, query);
                    if self.composite.sweep_at.is_some() && !self.composite.is_paired(number) {
                        dominance::one_for_each_binding(&mut results);
                    }
                    let stands = matches!(kind, PartKind::Not(_));
                    let starts = || results.iter().map(|result| result.interval.0);
                    let extent = starts().min().zip(starts().max());
                    steps.push(SequencePart { results, extent, delay: delay.take(), stands });
                }
            }
        }
        let start = Partial {
            hull: None,
            end: self.part.window.start,
            recognised_at: self.part.window.start,
            bindings: Bindings::new(),
            evidence: absent.into(),
        };
        if self.cannot_complete(&steps, delay, query) {
            return Vec::new();
        }
        self.extend(&steps, &nots, delay, start, query);
        self.found.sort_by_key(|result| result.recognised_at);
        self.found
    }

    /// Returns true if no combination can be complete now, so that none has to be tried: a part has no result, or the delay at the end is
    /// over after none of the results of the last part. Requests a wake for the first of them.
    fn cannot_complete(
        &self,
        steps: &[SequencePart],
        last_delay: Option<(Duration, Duration)>,
        query: &mut VerdictQuery<'_>,
    ) -> bool {
        // A `:not` holds at instants, and its evaluation requests the wake.
        if steps.iter().any(|step| step.stands) {
            return false;
        }
        if steps.iter().any(|step| step.results.is_empty()) {
            return true;
        }
        let Some(((least, _), last)) = last_delay.zip(steps.last()) else { return false };
        let first = last.results.iter().map(|result| result.interval.1 + least).min();
        match first.filter(|over| *over > query.now) {
            Some(over) => {
                query.wake_at(over);
                true
            }
            None => false,
        }
    }

    fn extend(
        &mut self,
        steps: &[SequencePart],
        nots: &[Vec<Satisfaction>],
        last_delay: Option<(Duration, Duration)>,
        partial: Partial,
        query: &mut VerdictQuery<'_>,
    ) {
        let Some((step, rest)) = steps.split_first() else {
            self.complete(nots, last_delay, partial, query);
            return;
        };
        // The wake of a `:not` is requested below, when the combination is evaluated.
        let next = rest.first().filter(|_| self.ordered && !step.stands);
        let goes_on = |result: &&Satisfaction| next.is_none_or(|next| next.may_follow(result.interval.1));
        for result in step.results.iter().filter(goes_on) {
            self.combinations += 1;
            if self.combinations > query.context.limits().of(Limit::MonitorCombinations) {
                query.troubles.reached(Limit::MonitorCombinations, query.context, self.part.place);
                return;
            }
            if self.ordered && !self.follows(&partial, step, result) {
                // The result will follow the preceding part once enough time has passed: it is evaluated again at that instant.
                let due = partial.end + step.delay.map_or(TICK, |(least, _)| least);
                if step.stands && due > query.now {
                    query.wake_at(due);
                }
                continue;
            }
            let Some(bindings) = joined(&partial.bindings, &result.bindings) else { continue };
            let hull = partial
                .hull
                .map_or(result.interval, |(start, end)| (start.min(result.interval.0), end.max(result.interval.1)));
            let next = Partial {
                hull: Some(hull),
                end: result.interval.1,
                recognised_at: partial.recognised_at.max(result.recognised_at),
                bindings,
                evidence: partial.evidence.joined(&result.evidence),
            };
            self.extend(rest, nots, last_delay, next, query);
            // If the other parts leave no choice, the first combination found is the earliest.
            if self.part.keep == Keep::First && !self.composite.combines && !self.found.is_empty() {
                return;
            }
        }
    }

    fn follows(&self, partial: &Partial, step: &SequencePart, result: &Satisfaction) -> bool {
        let between = result.interval.0 - partial.end;
        match (step.delay, partial.hull) {
            (Some((least, most)), _) => between >= least && between <= most,
            (None, Some(_)) => between > Duration::ZERO,
            (None, None) => true,
        }
    }

    fn complete(
        &mut self,
        nots: &[Vec<Satisfaction>],
        last_delay: Option<(Duration, Duration)>,
        mut partial: Partial,
        query: &mut VerdictQuery<'_>,
    ) {
        let excluded = nots.iter().flatten().any(|result| joined(&partial.bindings, &result.bindings).is_some());
        // A part that only requires time to pass is satisfied at one instant.
        let instant = last_delay.map_or(query.now, |(least, _)| partial.end + least);
        let interval = partial.hull.unwrap_or((instant, instant));
        let constraints = &self.composite.constraints;
        if excluded || !constraints_hold(self.part.tag.as_ref(), constraints, interval, &partial.bindings, query) {
            return;
        }
        if !nots.is_empty() || partial.hull.is_none() && last_delay.is_none() {
            partial.recognised_at = query.now;
        }
        if let Some((least, _)) = last_delay {
            let over = partial.end + least;
            partial.recognised_at = partial.recognised_at.max(over);
            if over > query.now {
                query.wake_at(over);
                return;
            }
            let instant = EvidenceList::one(Evidence::Instant { since: Some(partial.end), at: over });
            partial.evidence = partial.evidence.joined(&instant);
        }
        if self.found.len() < query.troubles.results_max {
            let Partial { recognised_at, bindings, evidence, .. } = partial;
            self.found.push(Satisfaction { interval, recognised_at, bindings, evidence });
        } else {
            query.troubles.too_many_results(self.part.place);
        }
    }
}
