//! Results of parts (M&I)
//! What: splits the results of a part into final and tentative ones, which may still grow; temporal relations read them.
//! Runs: whenever a relation or an absence evaluates its parts.
//! Reads: the part, evaluation context.
//! Writes: removes final results of measurements, persisted values, episodes and events from the part, so that each is processed once.
//! Bound: O(new results + objects) for measurements, persisted values, episodes and events; for others the cost of their results.
//! PDL: Allen relations, `:absent`.
//! Paper: Table 1 row 11; section III, incremental interpretation.

use crate::monitoring::basic::time_conditions::{self, TimeForm};
use crate::monitoring::combination::logic;
use crate::monitoring::episodes::run_update::{advance_run, with_newest};
use crate::monitoring::numbers::{cyclic, persistence, regression, statistics};
use crate::monitoring::part::{PartContext, Truth, site};
use crate::monitoring::reported_results::Used;
use crate::monitoring::time_bounds::TICK;
use crate::monitoring::verdict_query::VerdictQuery;
use crate::state::monitors::monitor::{EpisodePart, Part, PartKind, Satisfaction};
use apex_model::because::Evidence;
use apex_model::event::StateVariable;
use apex_model::expression::{Expr, ExprKind};
use apex_model::source::Place;
use apex_model::symbol::Symbol;
use apex_model::time::{Duration, Time};
use apex_model::value::Value;

/// A result that may still change.
pub(crate) struct TentativeResult {
    /// Present knowledge, with the part's tag bound.
    pub(crate) result: Satisfaction,
    /// True if the result contains an open run, whose end is not known.
    pub(crate) open: bool,
}

/// Results of a part since the last evaluation.
#[derive(Default)]
pub(crate) struct PartResults {
    /// New results that nothing can change any longer.
    pub(crate) settled: Vec<Satisfaction>,
    /// Results that are not final; every evaluation lists all of them.
    pub(crate) passing: Vec<TentativeResult>,
    /// First and last evidence of open runs, whether they are results already or not.
    pub(crate) runs: Vec<(Time, Time)>,
    /// First and last evidence of runs that a lack of samples has ended: a sample that is still on its way would continue them.
    pub(crate) silent: Vec<(Time, Time)>,
    /// Later results begin at this instant or later, except for open runs.
    pub(crate) from: Time,
    /// Later results may lie anywhere.
    pub(crate) anywhere: bool,
    /// True if it is unknown whether an episode of the part continues: it has no sample, no sample shows where its run began, or expected
    /// samples are missing.
    pub(crate) doubt: bool,
    /// Instant at which the passing of time alone can change these results.
    pub(crate) changes_at: Option<Time>,
}

/// Returns the results of `part`. A measurement counts as final only when no sample of the same instant can replace it any longer.
pub(crate) fn take_final(part: &mut Part, query: &mut VerdictQuery<'_>) -> PartResults {
    let PartKind::Measurement(leaf) = &mut part.kind else { return take(part, query) };
    let mut extents = PartResults::default();
    if let Some(seen) = &mut leaf.seen {
        extents.settled.append(&mut seen.settled);
        let newest = seen.newest.samples().filter_map(|newest| newest.result.clone());
        extents.passing.extend(newest.map(|result| TentativeResult { result, open: false }));
    }
    extents
}

/// Returns the results of `part`.
pub(crate) fn take(part: &mut Part, query: &mut VerdictQuery<'_>) -> PartResults {
    let site = site(part);
    let mut extents = PartResults { from: query.now, ..PartResults::default() };
    match &mut part.kind {
        PartKind::Measurement(leaf) => {
            if leaf.variable.is_some() {
                let newest = leaf.seen.as_ref().and_then(|seen| seen.newest.samples().next().map(|sample| sample.at));
                extents.from = newest.unwrap_or(site.window.start);
            }
            if let Some(seen) = &mut leaf.seen {
                extents.settled.append(&mut seen.settled);
                extents.settled.extend(seen.newest.take_results());
            }
        }
        PartKind::Event(leaf) => extents.settled.append(&mut leaf.settled),
        PartKind::Episode(leaf) => {
            extents.settled.append(&mut leaf.settled);
            if leaf.variable.is_some() {
                extents.from = leaf.runs.values().next().map_or(site.window.start, |state| state.newest.at);
            }
            passing_episodes(leaf, site, query, &mut extents);
        }
        PartKind::Persisted(leaf) => {
            extents.settled.append(&mut leaf.settled);
            let newest = persistence::results(leaf, site, query);
            extents.passing.extend(newest.into_iter().map(|result| TentativeResult { result, open: false }));
            extents.anywhere = true;
            extents.doubt = persistence::in_doubt(leaf, query.now);
            // Evaluated to learn the instants at which future windows begin.
            persistence::truth(leaf, site, query);
        }
        // The only result of a fixed delay is final as soon as the time has passed.
        PartKind::Delay(leaf) if is_constant(&leaf.from) && leaf.to.as_ref().is_none_or(is_constant) => {
            let result = time_conditions::result(leaf, TimeForm::Delay, site.window.start);
            let taken = result.is_some() && std::mem::replace(&mut leaf.taken, true);
            extents.settled.extend(result.filter(|_| !taken));
            extents.from = leaf.span.map_or(query.now, |(from, _)| from.max(query.now));
            extents.doubt = leaf.span.is_none();
        }
        _ => composite(part, query, &mut extents),
    }
    let results = extents.settled.iter_mut().chain(extents.passing.iter_mut().map(|extent| &mut extent.result));
    bind_tag(part.tag.as_ref(), results);
    extents.settled.sort_by_key(|result| result.recognised_at);
    extents
}

fn is_constant(expr: &Expr) -> bool {
    matches!(expr.kind, ExprKind::Constant(_))
}

fn bind_tag<'a>(tag: Option<&Symbol>, results: impl Iterator<Item = &'a mut Satisfaction>) {
    let Some(tag) = tag else { return };
    results.for_each(|result| result.bindings.set(tag.clone(), Value::Interval(result.interval.0, result.interval.1)));
}

fn passing_episodes(leaf: &EpisodePart, site: PartContext, query: &mut VerdictQuery<'_>, extents: &mut PartResults) {
    let now = query.now;
    extents.doubt = leaf.blind || leaf.runs.is_empty();
    let mut objects: Vec<_> = leaf.runs.iter().collect();
    objects.sort_by_key(|(_, run)| run.rank);
    for (object, state) in objects {
        let judged = advance_run(leaf, site, object, state, now, query.context, &mut query.troubles);
        let over = judged.over.into_iter().chain(judged.closed_by_time);
        extents.passing.extend(over.map(|result| TentativeResult { result, open: false }));
        let silent_from = silent_from(leaf, state.newest.at);
        let open = silent_from.is_none_or(|at| at > now);
        let unseen = judged.run.is_some() && judged.found.is_none() && !judged.contradicted;
        extents.doubt |= !open || unseen;
        match judged.run {
            Some(run) if open => {
                extents.runs.push((run.start, run.last));
                extents.changes_at = extents.changes_at.into_iter().chain(silent_from).min();
            }
            Some(run) => extents.silent.push((run.start, run.last)),
            None => {}
        }
        extents.passing.extend(judged.found.map(|result| TentativeResult { result, open }));
    }
}

/// Returns the instant from which on a run is over, and the value unknown, if no sample arrives after the one at `last`.
fn silent_from(leaf: &EpisodePart, last: Time) -> Option<Time> {
    leaf.gap_max.map(|gap| last + gap + TICK)
}

/// Adds the results of a composite. All are tentative, because every evaluation computes them again; a result that rests on an open run
/// is open.
fn composite(part: &Part, query: &mut VerdictQuery<'_>, extents: &mut PartResults) {
    let mut runs = Runs::default();
    runs.collect(part, query, &mut extents.changes_at);
    let results = logic::results(part, query);
    let mut without = runs.results_without_open(part, query);
    for result in results {
        let mut open = result.evidence.iter().any(|evidence| rests_on(evidence, &runs.open));
        // One run may continue for one part and be over for another: a result that exists without the open run rests on the ended one.
        if let Some(place) = without.iter().position(|other| open && *other == result) {
            without.swap_remove(place);
            open = false;
        }
        if result.recognised_at <= query.now {
            extents.passing.push(TentativeResult { result, open });
        }
    }
    let open = runs.open;
    extents.anywhere = true;
    extents.doubt = match logic::truth(part, query) {
        Truth::False => false,
        Truth::Unknown => true,
        // The found result remains true; whether it continues depends on its episodes.
        Truth::True => is_in_doubt(part, query),
    };
    extents.runs.extend(open.iter().map(|run| run.interval));
}

/// Returns true if a combination certainly does not hold: then no part within it matters as undecided.
fn certainly_not(part: &Part, query: &mut VerdictQuery<'_>) -> bool {
    let combines = matches!(part.kind, PartKind::And(_) | PartKind::Or(_) | PartKind::InOrder(_) | PartKind::Allen(_));
    combines && logic::truth(part, query) == Truth::False
}

/// Returns true if an episode within the part is undecided.
fn is_in_doubt(part: &Part, query: &mut VerdictQuery<'_>) -> bool {
    let mut doubt = match &part.kind {
        PartKind::Episode(leaf) => {
            let mut own = PartResults::default();
            passing_episodes(leaf, site(part), query, &mut own);
            own.doubt
        }
        PartKind::Statistical(leaf) => statistics::in_doubt(leaf, site(part), query),
        PartKind::Persisted(leaf) => persistence::in_doubt(leaf, query.now),
        PartKind::Cyclic(leaf) => cyclic::in_doubt(leaf, site(part), query),
        PartKind::Regression(leaf) => regression::in_doubt(leaf, site(part), query),
        PartKind::Function(leaf) => leaf.value.is_none(),
        // Absences that were found remain; the absence itself knows whether another one is undecided.
        PartKind::Absent(leaf) => return leaf.unknown,
        // A `:not` is false if its part is true, even if something within the part is undecided.
        PartKind::Not(inner) => return query.of_everything(|query| logic::truth(inner, query)) == Truth::Unknown,
        _ => false,
    };
    for_each_inner(part, &mut |inner| doubt |= !certainly_not(inner, query) && is_in_doubt(inner, query));
    doubt
}

fn rests_on(evidence: &Evidence, open: &[PartRun]) -> bool {
    match evidence {
        Evidence::Run { variable, start, end, .. } => {
            open.iter().any(|run| run.variable == *variable && run.interval.0 <= *start && *end == run.interval.1)
        }
        _ => false,
    }
}

/// Returns the first instant after `now` at which some part within is undecided because no sample has arrived for too long.
pub(crate) fn silent_after(part: &Part, now: Time) -> Option<Time> {
    let after = |newest: Time, most: Duration| newest.0.checked_add(most.0).map(|last| Time(last) + TICK);
    let mut first = match &part.kind {
        PartKind::Episode(leaf) => {
            leaf.runs.values().filter_map(|state| after(state.newest.at, leaf.gap_max?)).filter(|at| *at > now).min()
        }
        PartKind::Statistical(leaf) => {
            leaf.objects.values().filter_map(|state| after(state.newest.at, leaf.gap_max?)).filter(|at| *at > now).min()
        }
        PartKind::Persisted(leaf) => {
            leaf.objects.values().filter_map(|sample| after(sample.at, leaf.timeout)).filter(|at| *at > now).min()
        }
        PartKind::Regression(leaf) => {
            leaf.objects.values().filter_map(|fit| after(fit.last()?.0, leaf.gap_max?)).filter(|at| *at > now).min()
        }
        _ => None,
    };
    for_each_inner(part, &mut |inner| first = first.into_iter().chain(silent_after(inner, now)).min());
    first
}

/// The newest run of a part, which is a result.
#[derive(Clone, PartialEq)]
struct PartRun {
    part: Place,
    variable: StateVariable,
    interval: (Time, Time),
    result: Satisfaction,
}

/// The newest runs of all episodes within a composite that are results.
#[derive(Default)]
struct Runs {
    /// Runs that continue.
    open: Vec<PartRun>,
    /// Runs whose last sample is older than the permitted gap.
    silent: Vec<PartRun>,
}

impl Runs {
    fn collect(&mut self, part: &Part, query: &mut VerdictQuery<'_>, changes_at: &mut Option<Time>) {
        let now = query.now;
        let mut add = |gap_max: Option<Duration>, run: PartRun| {
            let silent_from = gap_max.map(|gap| run.interval.1 + gap + TICK);
            if silent_from.is_some_and(|at| at <= now) {
                self.silent.push(run);
                return;
            }
            self.open.push(run);
            *changes_at = changes_at.iter().copied().chain(silent_from).min();
        };
        match &part.kind {
            PartKind::Statistical(leaf) => {
                for (variable, result) in statistics::open_of_variables(leaf, site(part), query) {
                    add(leaf.gap_max, PartRun { part: part.place, variable, interval: result.interval, result });
                }
            }
            PartKind::Episode(leaf) => {
                for (object, state) in &leaf.runs {
                    let judged = advance_run(leaf, site(part), object, state, now, query.context, &mut query.troubles);
                    let Some((run, result)) = with_newest(leaf, state).zip(judged.found) else { continue };
                    let variable = StateVariable::new(leaf.condition.variable.attribute.clone(), object.clone());
                    add(leaf.gap_max, PartRun { part: part.place, variable, interval: (run.start, run.last), result });
                }
            }
            _ => {}
        }
        for_each_inner(part, &mut |inner| self.collect(inner, query, changes_at));
    }

    /// Returns the results of `part` without the open runs, if it is undecided on which run a result rests.
    fn results_without_open(&self, part: &Part, query: &mut VerdictQuery<'_>) -> Vec<Satisfaction> {
        let alike = |run: &PartRun| {
            self.silent.iter().any(|other| other.variable == run.variable && other.interval.1 == run.interval.1)
        };
        if !self.open.iter().any(alike) || keeps_results(part) {
            return Vec::new();
        }
        let mut used = Used::default();
        self.open.iter().for_each(|run| used.add(run.part, &run.result));
        let before = query.used.replace(used);
        let results = logic::results(part, query);
        query.used = before;
        results
    }
}

/// Returns true if results of inner parts are kept as found, and not computed again at every evaluation.
fn keeps_results(part: &Part) -> bool {
    let mut keeps = matches!(part.kind, PartKind::Allen(_) | PartKind::Absent(_));
    for_each_inner(part, &mut |inner| keeps |= keeps_results(inner));
    keeps
}

/// Calls a function for each direct part of `part`.
pub(crate) fn for_each_inner(part: &Part, act: &mut dyn FnMut(&Part)) {
    match &part.kind {
        PartKind::And(composite) | PartKind::Or(composite) | PartKind::InOrder(composite) => {
            composite.parts.iter().for_each(act);
        }
        PartKind::Not(inner) => act(inner),
        PartKind::Allen(leaf) => leaf.parts.iter().for_each(act),
        PartKind::Absent(leaf) => act(&leaf.part),
        PartKind::Measurement(_)
        | PartKind::Episode(_)
        | PartKind::Persisted(_)
        | PartKind::Regression(_)
        | PartKind::Statistical(_)
        | PartKind::Cyclic(_)
        | PartKind::Event(_)
        | PartKind::TaskEnded(_)
        | PartKind::TaskState(_)
        | PartKind::Timestamp(_)
        | PartKind::Delay(_)
        | PartKind::Function(_) => {}
    }
}
