//! The search where ways take the same time at every departure: ruin and recreation over a timetable, with cooling.
//!
//! Whether a visit fits between two others, and when the route then ends, is told by three numbers a stop; so an insertion
//! is priced in a step, however long the route. Where the budget is known coolings take all of it but what the bound
//! needs: three from nothing, of which each ends in a good route though perhaps far from the best one, and a last one from
//! the best of them that begins less hot. Else rounds follow each other, each longer than the one before.
//! Bound: none but the budget; equal seed and budget give an equal route.

mod annealing;
mod bound;
mod flown;
mod network;
mod reasons;
mod recreate;
mod repair;
mod route;
mod ruin;
mod turn;

#[cfg(test)]
mod tests;

use super::schedule::{Choice, Schedule};
use crate::bound::Meter;
use annealing::{Annealing, Round};
use apex_model::problem::SingleVisitPlan;
use apex_model::solver::{Budget, Environment};
use network::Network;
use route::Route;

/// Units of the first round where nobody knows how long the search may take; each has half as many again as the one before.
const ROUND_UNITS: u64 = 60_000;
/// Rounds in a row without gain after which the search ends.
const STALE_ROUNDS_MAX: u32 = 30;
/// Temperatures at the beginning and the end, in mean values of a target: of a new plan, of one with many targets, and of
/// one that was good before a change.
const FRESH: (f64, f64) = (2.0, 0.05);
const FRESH_OF_MANY: (f64, f64) = (2.0, 0.2);
const CHANGED: (f64, f64) = (0.1, 0.02);
/// Coolings of a new plan from nothing, the share of the work that they take together, and how hot the last one begins, as a
/// share of their heat. With more nodes or less work than these one cooling takes all: shorter ones would end too early.
const FRESH_ROUNDS: u32 = 3;
const FRESH_SHARE: f64 = 0.75;
const LAST_HEAT: f64 = 0.1;
const ROUNDS_NODES_MAX: usize = 400;
const ROUNDS_UNITS_MIN: u64 = 10_000;
/// Share of the budget that the bound may take, and what it takes at most.
const BOUND_SHARE: f64 = 0.15;
const BOUND_UNITS_MAX: u64 = 3_000_000;
/// So few targets are found out about: the proof, which may find a better route, takes half of the budget, and of a large
/// one all but what the search needs.
const FEW: usize = 40;
const SEARCH_UNITS_OF_FEW: u64 = 300_000;
const BOUND_UNITS_MAX_OF_FEW: u64 = 100_000_000;

/// What the search found.
pub(super) struct Found {
    /// The visits in order.
    pub(super) order: Vec<Choice>,
    /// No route is worth more, where that was found out.
    pub(super) bound: Option<f64>,
    /// For targets that are left out, why.
    pub(super) reasons: Vec<(usize, String)>,
}

/// Hears of the first order.
pub(super) type Tell<'t> = dyn FnMut(&mut Schedule<'_>, Vec<Choice>, &mut Environment<'_>) + 't;

/// The best order found within the budget; none where the problem needs the general search. Begins from what `previous`
/// visits, where there is such a plan.
pub(super) fn run(
    schedule: &mut Schedule<'_>,
    usable: &[usize],
    previous: Option<&SingleVisitPlan>,
    environment: &mut Environment<'_>,
    tell: &mut Tell<'_>,
) -> Option<Found> {
    let mut network = Network::new(schedule, usable, environment.budget)?;
    let visits = previous.map(|plan| repair::visits(&network, schedule.problem, plan)).unwrap_or_default();
    let mut first = Route::of(&network, &visits);
    repair::mend(&network, &mut first);
    Annealing::new(&network, environment.seed).fill_all(&mut first, environment.budget);
    tell(schedule, choices(&network, &first), environment);
    network.find_neighbours();
    let budget = &mut *environment.budget;
    let bound_units = budget.left().map_or(ROUND_UNITS, |left| match network.targets <= FEW {
        true => left.saturating_sub(SEARCH_UNITS_OF_FEW).max(left / 2).min(BOUND_UNITS_MAX_OF_FEW),
        false => ((BOUND_SHARE * left as f64) as u64).min(BOUND_UNITS_MAX),
    });
    let heat = match previous {
        Some(_) => CHANGED,
        None if network.visits().len() > annealing::ALL_MISSING_MAX => FRESH_OF_MANY,
        None => FRESH,
    };
    let rounds = if previous.is_none() && network.nodes.len() <= ROUNDS_NODES_MAX { FRESH_ROUNDS } else { 0 };
    let mut best = search(&network, first, (environment.seed, heat, rounds), bound_units, budget);
    // The knapsack alone looks at every leg twice.
    let pays = bound_units as usize > network.nodes.len() * network.nodes.len() / 100;
    let proven = pays.then(|| bound::highest_value(&network, best.value, bound_units, budget));
    if let Some(better) = proven.as_ref().and_then(|proven| proven.better.as_deref()) {
        best = Route::of(&network, better);
    }
    let bound = proven.map(|proven| proven.bound);
    Some(Found { order: choices(&network, &best), bound, reasons: reasons::left_out(&network, &best) })
}

/// Work units that a proof may take where somebody asks how good a plan is: some seconds.
const PROOF_UNITS: u64 = 4_000_000;

/// No plan over the `usable` targets gathers more than this, nor less than `reached`, which some plan does: of problems that
/// need the general search, with every way at its best departure and without costs and order. None with too many targets, for
/// problems that the search here serves, whose plans bring their bounds, and where the budget is too small to find the ways.
pub(super) fn at_best_departures(
    schedule: &mut Schedule<'_>,
    usable: &[usize],
    reached: f64,
    meter: &mut Meter<'_>,
) -> Option<f64> {
    if network::serves(schedule) {
        return None;
    }
    let network = Network::relaxed(schedule, usable, meter)?;
    let left = meter.budget().left().unwrap_or(u64::MAX);
    let before = meter.used();
    let found = bound::highest_value(&network, reached, PROOF_UNITS.min(left), meter.budget()).bound;
    if left < PROOF_UNITS && meter.used() - before >= left && found > reached {
        meter.cut();
    }
    Some(found)
}

/// Cools down until only `spare` is left of the budget: so many rounds from nothing, and one from the best of `first` and theirs.
fn search(
    network: &Network,
    first: Route,
    (seed, heat, rounds): (u64, (f64, f64), u32),
    spare: u64,
    budget: &mut dyn Budget,
) -> Route {
    let mut annealing = Annealing::new(network, seed);
    let mean = network.nodes.iter().map(|node| node.value).sum::<f64>() / network.visits().len().max(1) as f64;
    let (mut hot, cold) = (heat.0 * mean, heat.1 * mean);
    let mut best = first;
    // A search for ever would never cool: it ends by itself like one by the clock.
    let known = budget.left().map(|left| left.saturating_sub(spare)).filter(|units| *units < u64::MAX >> 8);
    if let Some(mut left) = known {
        let rounds = if left < ROUNDS_UNITS_MIN { 0 } else { rounds };
        let each = (FRESH_SHARE / f64::from(rounds.max(1)) * left as f64) as u64;
        for _ in 0..rounds {
            let found = annealing.round(&Route::new(network), Round { units: each, hot, cold }, budget);
            best = annealing.better(best, found);
            left -= each;
        }
        if rounds > 0 {
            hot = (LAST_HEAT * hot).max(cold);
        }
        let found = annealing.round(&best, Round { units: left, hot, cold }, budget);
        return annealing.better(best, found);
    }
    let (mut units, mut stale) = (ROUND_UNITS, 0);
    while stale < STALE_ROUNDS_MAX && !budget.exhausted() {
        stale += 1;
        let start = if stale % 3 == 2 { annealing.first(budget) } else { best.clone() };
        let found = annealing.round(&start, Round { units, hot, cold }, budget);
        if annealing.score(&found) > annealing.score(&best) + 1e-9 {
            stale = 0;
            best = found;
        }
        units += units / 2;
    }
    best
}

fn choices(network: &Network, route: &Route) -> Vec<Choice> {
    let choice = |node: u32| {
        let node = network.node(node);
        Choice { target: node.target as usize, manoeuvre: node.manoeuvre as usize, not_before_s: f64::NEG_INFINITY }
    };
    route.visits().map(choice).collect()
}
