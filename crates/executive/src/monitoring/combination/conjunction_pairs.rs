//! Pairs of parts of a conjunction (M&I)
//! What: keeps, of two parts of an `:and` whose results must lie within limits of each other, the results that a reported one may need.
//! Runs: with the sweep of the conjunction.
//! Reads: the parts' results.
//! Writes: removes results from the parts.
//! Bound: O(n log n) for n kept results; those that remain lie within the limits, or are the first for their bindings.
//! PDL: `:constraint` in an `:and`.
//! Paper: Table 1, row 11.
//!
//! Of combinations that are recognised at one instant, the one with the earliest result of the part that is written first is reported.
//! Once a result of that part has a partner, later ones with equal bindings are useless: while the other parts are to come, every such
//! combination is recognised with them. A result whose partner is still to come is kept until its limits exclude every later partner.

use crate::expression::EvalContext;
use crate::monitoring::combination::condition_names::collect;
use crate::monitoring::combination::order_constraints;
use crate::monitoring::combination::point_steps::{PointRole, points, settled, settled_mut, watermark};
use crate::monitoring::memory::retention;
use crate::monitoring::reported_results::Used;
use crate::state::bindings::{PlainBindings, joined};
use crate::state::monitors::monitor::{Composite, Part, PartKind, PointLimit, Satisfaction};
use apex_model::condition::Condition;
use apex_model::pattern::Pattern;
use apex_model::symbol::Symbol;
use apex_model::time::{Duration, Time};
use std::collections::BTreeSet;

/// Returns the pairs of parts that the constraints relate; `None` if there are none, or if a constraint states something else. The parts of
/// a pair are messages or samples of named or bound objects without `:lateness`, and bind the same variables.
pub(crate) fn create(
    composite: &Composite,
    conditions: &[Condition],
    context: &dyn EvalContext,
) -> Option<Vec<PointLimit>> {
    let points = points(composite);
    let mut pairs = order_constraints::between(composite)?;
    let mut seen = BTreeSet::new();
    for pair in &mut pairs {
        pair.first = points.get(pair.first)?.0;
        pair.second = points.get(pair.second)?.0;
        if !seen.insert(pair.first) || !seen.insert(pair.second) {
            return None;
        }
    }
    let unbound = |index: usize| {
        let mut names: BTreeSet<&Symbol> = BTreeSet::new();
        conditions.get(index).into_iter().for_each(|condition| collect(condition, &mut names));
        names.retain(|name| context.variable(name).is_none());
        names
    };
    let is_point = |index: usize| match composite.parts.get(index).map(|part| &part.kind) {
        Some(PartKind::Measurement(leaf)) => {
            let pattern = &leaf.condition.variable;
            let declared = context.library().state_variables.get(&pattern.attribute);
            let named = leaf.variable.is_some() || matches!(pattern.object, Pattern::Variable(_));
            named && declared.and_then(retention::lateness).is_none()
        }
        Some(PartKind::Event(_)) => true,
        _ => false,
    };
    let fits = |pair: &PointLimit| {
        is_point(pair.first) && is_point(pair.second) && unbound(pair.first) == unbound(pair.second)
    };
    (!pairs.is_empty() && pairs.iter().all(fits)).then_some(pairs)
}

/// Drops the results of the pairs that no reported result needs any longer; returns the number of kept ones. `used` are results of
/// combinations that were reported already.
pub(crate) fn sweep(composite: &mut Composite, used: Option<&Used>, now: Time) -> usize {
    let mut kept = 0;
    for pair in composite.pairs.clone() {
        let needed = match (composite.parts.get(pair.first), composite.parts.get(pair.second)) {
            (Some(first), Some(second)) => PairSweep { pair, first, second, used, now }.needed(),
            _ => continue,
        };
        for (index, needed) in [(pair.first, needed.0), (pair.second, needed.1)] {
            let Some(list) = composite.parts.get_mut(index).and_then(|part| settled_mut(part, PointRole::Whole)) else {
                continue;
            };
            let newest = list.len().saturating_sub(1);
            let mut place = 0;
            list.retain(|_| {
                place += 1;
                // The newest settled result shows that the part has held.
                place > newest || needed.contains(&(place - 1))
            });
            kept += list.len();
        }
    }
    kept
}

/// One sweep of a pair.
struct PairSweep<'a> {
    pair: PointLimit,
    first: &'a Part,
    second: &'a Part,
    used: Option<&'a Used>,
    now: Time,
}

impl<'a> PairSweep<'a> {
    /// Returns the places of the needed results of both parts.
    fn needed(&self) -> (BTreeSet<usize>, BTreeSet<usize>) {
        let (firsts, seconds) = (self.in_order(self.first), self.in_order(self.second));
        let (mut needed_firsts, mut needed_seconds) = (BTreeSet::new(), BTreeSet::new());
        let (mut complete, mut waiting) = (BTreeSet::new(), BTreeSet::new());
        for (place, result) in firsts {
            let bindings = result.bindings.plain();
            if complete.contains(&bindings) {
                continue;
            }
            let (from, to) = self.after(result);
            let begin = seconds.partition_point(|(_, each)| each.interval.0 < from);
            let within = seconds.iter().skip(begin).take_while(|(_, each)| each.interval.0 <= to);
            let mut partners = within.filter(|(_, each)| joined(&result.bindings, &each.bindings).is_some());
            if let Some((partner, _)) = partners.next() {
                needed_firsts.insert(place);
                needed_seconds.insert(*partner);
                complete.insert(bindings);
            } else if self.may_come(self.second, result, to) && self.is_first(&mut waiting, bindings, self.pair.most) {
                needed_firsts.insert(place);
            }
        }
        waiting.clear();
        for (place, result) in seconds {
            let bindings = result.bindings.plain();
            let last = Time(result.interval.0.0.saturating_sub(self.pair.least.0));
            let least = Duration(self.pair.least.0.saturating_neg());
            if !complete.contains(&bindings)
                && self.may_come(self.first, result, last)
                && self.is_first(&mut waiting, bindings, least)
            {
                needed_seconds.insert(place);
            }
        }
        (needed_firsts, needed_seconds)
    }

    /// Returns the settled results that do not belong to a reported one, with their places, in order of time.
    fn in_order(&self, part: &'a Part) -> Vec<(usize, &'a Satisfaction)> {
        let counts = |result: &Satisfaction| self.used.is_none_or(|used| !used.contains(part.place, result));
        let all = settled(part, PointRole::Whole).iter().enumerate();
        let mut all: Vec<_> = all.filter(|(_, result)| counts(result)).collect();
        all.sort_by_key(|(_, result)| result.recognised_at);
        all
    }

    /// Returns the first and last instant of partners of a result of the first part.
    fn after(&self, result: &Satisfaction) -> (Time, Time) {
        let at = result.interval.0.0;
        (Time(at.saturating_add(self.pair.least.0)), Time(at.saturating_add(self.pair.most.0)))
    }

    /// Returns true if a result of `part` may still come that agrees with `result`, at `last` or before.
    fn may_come(&self, part: &Part, result: &Satisfaction, last: Time) -> bool {
        watermark(part, &result.bindings, self.now).is_none_or(|watermark| watermark <= last)
    }

    /// Returns true if no earlier result with these bindings waits for the same partners: without a greatest time to a partner, it permits
    /// all that a later one permits.
    fn is_first(&self, waiting: &mut BTreeSet<PlainBindings>, bindings: PlainBindings, most: Duration) -> bool {
        most != Duration::MAX || waiting.insert(bindings)
    }
}
