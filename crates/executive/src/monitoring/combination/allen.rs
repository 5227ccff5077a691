//! Allen relations (M&I)
//! What: finds results of neighbouring parts that are in the required relation.
//! Runs: whenever a verdict is requested, and at the instant at which a gap ends a run that matters.
//! Reads: results of the parts, evaluation context.
//! Writes: the Allen part of a monitor.
//! Bound: O(new results x kept results) for two parts. At most `MONITOR_RESULTS_MAX` results of a part are kept, and only those that an
//! open or future run can still be related to; a single one if no constraint chooses.
//! PDL: `:before` .. `:cotemporal`, `:tolerance`, `:constraint`.
//! Paper: Table 1 row 11, Allen temporal predicates; Appendix B.

use crate::expression::EvalContext;
use crate::monitoring::combination::dominance::{bounds_only, easier, keep_best, keep_first_choices};
use crate::monitoring::combination::logic;
use crate::monitoring::combination::part_results::{self, PartResults, TentativeResult};
use crate::monitoring::combination::relation::{
    Decision, Edge, KnownInterval, PointComparison, decide, decide_link, links,
};
use crate::monitoring::part::{ConditionFaults, PartContext, Truth};
use crate::monitoring::verdict_query::VerdictQuery;
use crate::state::bindings::{Bindings, joined};
use crate::state::monitors::monitor::{AllenPart, Chain, Keep, RelationSide, Satisfaction};
use apex_model::agent_limits::Limit;
use apex_model::because::Evidence;
use apex_model::condition::AllenRelation;
use apex_model::event::StateVariable;
use apex_model::evidence_list::EvidenceList;
use apex_model::symbol::Symbol;
use apex_model::time::Time;
use std::collections::BTreeMap;

/// Number of kept results of a part from which on useless ones are removed.
pub(crate) const SWEEP_AT_LEAST: usize = 32;

/// Starts again.
pub(crate) fn forget(part: &mut AllenPart) {
    part.sides.iter_mut().for_each(|side| *side = RelationSide::default());
    part.found.clear();
    part.passing.clear();
    part.undecided = false;
    part.decides_at = None;
}

/// Returns true if the part can no longer change.
pub(crate) fn is_done(part: &AllenPart, site: PartContext) -> bool {
    site.keep == Keep::First && !part.found.is_empty()
}

/// Removes the results of a sample that another sample of the same instant replaced.
pub(crate) fn replace(part: &mut AllenPart, variable: &StateVariable, at: Time) {
    let of_it = |evidence: &Evidence| matches!(evidence, Evidence::Sample { variable: own, at: own_at, .. } if own == variable && *own_at == at);
    let stands = |result: &Satisfaction| !result.evidence.iter().any(of_it);
    for side in &mut part.sides {
        let before = side.settled.len();
        side.settled.retain(&stands);
        if side.settled.len() < before {
            side.count = side.settled.len() as u64;
            side.newest = side.settled.iter().map(|result| (result.interval, false)).max_by_key(|((_, end), _)| *end);
        }
    }
    part.found.retain(|chain| stands(&chain.result));
    part.passing.retain(|chain| stands(&chain.result));
}

/// Considers the results of the parts, after they have caught up with the present.
pub(crate) fn advance(
    part: &mut AllenPart,
    site: PartContext,
    tag: Option<&Symbol>,
    context: &dyn EvalContext,
    troubles: &mut ConditionFaults,
) {
    if is_done(part, site) {
        return;
    }
    let mut query = VerdictQuery::new(context);
    let mut extents: Vec<PartResults> =
        part.parts.iter_mut().map(|each| part_results::take(each, &mut query)).collect();
    let mut join = RelationJoin::new(part, &extents, context);
    join.run();
    let RelationJoin { met, undecided, exhausted, .. } = join;
    if exhausted {
        query.troubles.reached(Limit::MonitorCombinations, context, site.place);
    }
    part.undecided = undecided;
    let changes = extents.iter().filter_map(|each| each.changes_at);
    part.decides_at = changes.chain(query.wake).filter(|at| *at > query.now).min();
    let mut chains: Vec<(Chain, bool)> = Vec::new();
    for (chain, settled) in met {
        if logic::constraints_hold(tag, &part.constraints, chain.result.interval, &chain.result.bindings, &mut query) {
            chains.push((chain, settled));
        }
    }
    chains.sort_by(|(a, _), (b, _)| a.intervals.cmp(&b.intervals));
    note(part, site, chains, &mut query.troubles);
    for (index, each) in extents.iter_mut().enumerate() {
        keep(part, index, each);
    }
    for index in 0..part.sides.len() {
        sweep(part, site, index, &extents, &mut query);
    }
    troubles.append(query.troubles);
}

/// Stores related results: final ones permanently, others until the next evaluation. A result that was known before keeps the instant at
/// which it was recognised.
fn note(part: &mut AllenPart, site: PartContext, chains: Vec<(Chain, bool)>, troubles: &mut ConditionFaults) {
    let starts = |each: &Chain| each.intervals.iter().map(|(start, _)| *start).collect::<Vec<_>>();
    // The map is keyed by starts. Of several with equal starts the first remains, because it is inserted last.
    let passing = std::mem::take(&mut part.passing);
    let known: BTreeMap<_, _> = passing.iter().rev().map(|known| (starts(known), known.result.recognised_at)).collect();
    for (mut chain, settled) in chains {
        if let Some(recognised_at) = known.get(&starts(&chain)) {
            chain.result.recognised_at = *recognised_at;
        }
        if site.keep == Keep::First {
            part.found.push(chain);
            return;
        }
        if !settled {
            if part.passing.len() < troubles.results_max {
                part.passing.push(chain);
            } else {
                troubles.too_many_results(site.place);
            }
        } else {
            if part.found.len() >= troubles.results_max {
                troubles.too_many_results(site.place);
                part.found.drain(..troubles.results_max / 4);
            }
            part.found.push(chain);
        }
    }
}

/// Adds the new results of a part to its kept ones.
fn keep(part: &mut AllenPart, index: usize, extents: &mut PartResults) {
    let Some(side) = part.sides.get_mut(index) else { return };
    let newest = extents.settled.iter().map(|result| (result.interval, false));
    let passing = extents.passing.iter().map(|extent| (extent.result.interval, extent.open));
    // A newest result that was not final may have been withdrawn.
    let before = side.newest.filter(|_| side.count > 0);
    side.newest = newest.chain(passing).max_by_key(|((_, end), _)| *end).or(before);
    side.count += extents.settled.len() as u64;
    side.settled.append(&mut extents.settled);
}

/// A result of a part within a search.
#[derive(Clone, Copy)]
struct Item<'a> {
    result: &'a Satisfaction,
    open: bool,
    settled: bool,
}

/// Returns the interval of a result as known at `now`.
fn span(interval: (Time, Time), open: bool, now: Time) -> KnownInterval {
    if open { KnownInterval::growing(interval, now) } else { KnownInterval::of(interval) }
}

impl Item<'_> {
    fn span(&self, now: Time) -> KnownInterval {
        span(self.result.interval, self.open, now)
    }
}

/// Search for chains of related results of which at least one is new.
struct RelationJoin<'a> {
    relation: AllenRelation,
    part: &'a AllenPart,
    extents: &'a [PartResults],
    now: Time,
    combinations: u64,
    combinations_max: u64,
    met: Vec<(Chain, bool)>,
    undecided: bool,
    exhausted: bool,
}

impl<'a> RelationJoin<'a> {
    fn new(part: &'a AllenPart, extents: &'a [PartResults], context: &dyn EvalContext) -> RelationJoin<'a> {
        RelationJoin {
            relation: part.relation,
            part,
            extents,
            now: context.now(),
            combinations: 0,
            combinations_max: context.limits().of(Limit::MonitorCombinations),
            met: Vec::new(),
            undecided: false,
            exhausted: false,
        }
    }

    /// Finds all chains with a new result, each once: for every new result, the chains in which it is the first new one, in order of
    /// parts.
    fn run(&mut self) {
        let count = self.extents.len();
        let mut chain: Vec<Item<'a>> = Vec::with_capacity(count);
        for first_new in 0..count {
            for item in self.fresh(first_new) {
                chain.clear();
                chain.push(item);
                self.extend_left(first_new, first_new, &mut chain);
            }
        }
    }

    fn fresh(&self, index: usize) -> Vec<Item<'a>> {
        let Some(extents) = self.extents.get(index) else { return Vec::new() };
        let settled = extents.settled.iter().map(|result| Item { result, open: false, settled: true });
        let passing =
            extents.passing.iter().map(|TentativeResult { result, open }| Item { result, open: *open, settled: false });
        settled.chain(passing).collect()
    }

    fn kept(&self, index: usize) -> impl Iterator<Item = Item<'a>> + use<'a> {
        let side: &'a [Satisfaction] =
            self.part.sides.get(index).map(|side| side.settled.as_slice()).unwrap_or_default();
        side.iter().map(|result| Item { result, open: false, settled: true })
    }

    /// Extends `chain`, which holds the results of the parts from `leftmost` to `first_new`, to the left by old results.
    fn extend_left(&mut self, leftmost: usize, first_new: usize, chain: &mut Vec<Item<'a>>) {
        let Some(next) = leftmost.checked_sub(1) else {
            self.extend_right(first_new + 1, chain);
            return;
        };
        for item in self.kept(next) {
            let Some(right) = chain.first() else { return };
            if self.related(&item, right) {
                chain.insert(0, item);
                self.extend_left(next, first_new, chain);
                chain.remove(0);
            }
        }
    }

    /// Extends `chain`, which holds the results of the parts before `index`, to the right.
    fn extend_right(&mut self, index: usize, chain: &mut Vec<Item<'a>>) {
        if index >= self.extents.len() {
            self.meet(chain);
            return;
        }
        for item in self.kept(index).chain(self.fresh(index)) {
            let Some(left) = chain.last() else { return };
            if self.related(left, &item) {
                chain.push(item);
                self.extend_right(index + 1, chain);
                chain.pop();
            }
        }
    }

    fn related(&mut self, left: &Item<'_>, right: &Item<'_>) -> bool {
        let (first, second) = (left.span(self.now), right.span(self.now));
        let decision = decide(self.relation, self.part.tolerance, first, second);
        if decision == Decision::Fails || !self.agree(left, right) {
            return false;
        }
        self.undecided |= decision == Decision::Open;
        decision == Decision::Holds
    }

    /// Returns true if both bind shared variables to equal values.
    fn agree(&self, left: &Item<'_>, right: &Item<'_>) -> bool {
        let bound = |name: &Symbol| right.result.bindings.get(name);
        !self.part.shares
            || left.result.bindings.iter().all(|(name, value)| bound(name).is_none_or(|other| other.matches(value)))
    }

    fn meet(&mut self, chain: &[Item<'a>]) {
        self.combinations += 1;
        if self.combinations > self.combinations_max {
            self.exhausted = true;
            return;
        }
        let intervals: Vec<(Time, Time)> = chain.iter().map(|item| item.result.interval).collect();
        let hull = intervals.iter().copied().reduce(|(start, end), (from, to)| (start.min(from), end.max(to)));
        let bindings = chain.iter().try_fold(Bindings::new(), |all, item| joined(&all, &item.result.bindings));
        let (Some(interval), Some(bindings)) = (hull, bindings) else { return };
        let evidence = chain.iter().fold(EvidenceList::default(), |all, item| all.joined(&item.result.evidence));
        let settled = chain.iter().all(|item| item.settled);
        let result = Satisfaction { interval, recognised_at: self.now, bindings, evidence };
        self.met.push((Chain { intervals, result }, settled));
    }
}

/// Drops the results of part `index` that no future result can be related to, and all but the best if any one suffices. Future results
/// begin at the newest sample of the part or later, because samples of one variable may arrive later than those of another. If too many
/// results remain, future results are assumed to begin now or later.
fn sweep(part: &mut AllenPart, site: PartContext, index: usize, looks: &[PartResults], query: &mut VerdictQuery<'_>) {
    let Some(side) = part.sides.get(index) else { return };
    if side.settled.len() < side.sweep_at.max(SWEEP_AT_LEAST) {
        return;
    }
    retain_useful(part, site, index, looks, None);
    let most = query.troubles.results_max;
    if part.sides.get(index).is_some_and(|side| side.settled.len() > most) {
        retain_useful(part, site, index, looks, Some(query.now));
    }
    let Some(side) = part.sides.get_mut(index) else { return };
    if side.settled.len() > most {
        query.troubles.too_many_results(site.place);
        side.settled.drain(..most / 4);
    }
    side.sweep_at = side.settled.len().saturating_mul(2).min(most + 1);
}

fn retain_useful(part: &mut AllenPart, site: PartContext, index: usize, looks: &[PartResults], now: Option<Time>) {
    let Some(side) = part.sides.get(index) else { return };
    let any_will_do = site.keep == Keep::First && part.constraints.is_empty() && part.parts.len() == 2;
    let longer = part.parts.len() > 2;
    let mut useful = vec![true; side.settled.len()];
    for (neighbour, is_left) in index.checked_sub(1).map(|left| (left, true)).into_iter().chain([(index + 1, false)]) {
        let (Some(look), Some(other)) = (looks.get(neighbour), part.sides.get(neighbour)) else { continue };
        if look.anywhere {
            continue;
        }
        let coming = KnownInterval::coming(now.unwrap_or(look.from));
        let runs = look.runs.iter().chain(&look.silent);
        let mut partners: Vec<KnownInterval> =
            runs.map(|run| KnownInterval::growing(*run, now.unwrap_or(run.1))).collect();
        let possible = |result: &Satisfaction, partner: KnownInterval| {
            let own = KnownInterval::of(result.interval);
            let (first, second) = if is_left { (partner, own) } else { (own, partner) };
            decide(part.relation, part.tolerance, first, second) != Decision::Fails
        };
        if any_will_do && bounds_only(part.relation) {
            let mut best = keep_best(&side.settled, &useful, &partners, possible);
            let easier = |one: &Satisfaction, other: &Satisfaction| easier(part.relation, is_left, one, other);
            keep_first_choices(&side.settled, &mut best, |result| possible(result, coming), easier);
            useful.iter_mut().zip(best).for_each(|(useful, best)| *useful &= best);
            continue;
        }
        partners.push(coming);
        if longer {
            // Existing results have been related to this one already, but the chain may still lack a result of another part.
            let passing = look.passing.iter().map(|extent| &extent.result);
            partners.extend(other.settled.iter().chain(passing).map(|result| KnownInterval::of(result.interval)));
        }
        for (result, useful) in side.settled.iter().zip(useful.iter_mut()) {
            *useful &= partners.iter().any(|partner| possible(result, *partner));
        }
    }
    let Some(side) = part.sides.get_mut(index) else { return };
    let mut useful = useful.into_iter();
    side.settled.retain(|_| useful.next().unwrap_or(true));
}

/// Returns all results up to now. Results recognised at one instant are ordered by those of their parts, in written order.
pub(crate) fn results(part: &AllenPart) -> Vec<Satisfaction> {
    let mut chains: Vec<&Chain> = part.found.iter().chain(&part.passing).collect();
    chains.sort_by(|a, b| (a.result.recognised_at, &a.intervals).cmp(&(b.result.recognised_at, &b.intervals)));
    chains.into_iter().map(|chain| chain.result.clone()).collect()
}

/// Returns satisfied; unknown if the data do not decide whether a part without results holds; otherwise not satisfied.
pub(crate) fn truth(part: &AllenPart, query: &mut VerdictQuery<'_>) -> Truth {
    if !part.found.is_empty() || !part.passing.is_empty() {
        return Truth::True;
    }
    let sides = part.parts.iter().zip(&part.sides).filter(|(_, side)| side.newest.is_none());
    let missing: Vec<Truth> = sides.map(|(each, _)| logic::truth(each, query)).collect();
    missing.into_iter().min().filter(|least| *least == Truth::Unknown).unwrap_or(Truth::False)
}

/// Returns the first pair of adjacent parts whose newest results violate the relation: the index of the first part, and the reason as
/// text.
pub(crate) fn mismatch(part: &AllenPart, now: Time) -> Option<(usize, String)> {
    let pairs = part.sides.iter().zip(part.sides.iter().skip(1)).enumerate();
    pairs.filter_map(|(index, (left, right))| Some((index, left.newest?, right.newest?))).find_map(
        |(index, left, right)| {
            let (first, second) = (span(left.0, left.1, now), span(right.0, right.1, now));
            let decided = |link| decide_link(link, part.tolerance, first, second);
            let missed = links(part.relation).iter().min_by_key(|link| decided(**link))?;
            let words = match decided(*missed) {
                Decision::Holds => return None,
                Decision::Open => "it is not known whether",
                Decision::Fails => "it is not so that",
            };
            let edge = |edge: Edge| match edge {
                Edge::FirstStart => format!("the start of the first, {}", left.0.0),
                Edge::FirstEnd => format!("the end of the first, {}", end_words(left)),
                Edge::SecondStart => format!("the start of the second, {}", right.0.0),
                Edge::SecondEnd => format!("the end of the second, {}", end_words(right)),
            };
            let link = match missed.1 {
                PointComparison::Earlier => "is before",
                PointComparison::Same => "is",
            };
            Some((index, format!("{words} {}, {link} {}", edge(missed.0), edge(missed.2))))
        },
    )
}

fn end_words(((_, end), open): ((Time, Time), bool)) -> String {
    if open { format!("{end} or later") } else { end.to_string() }
}
