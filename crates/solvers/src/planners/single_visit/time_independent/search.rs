//! Divides the budget between annealing runs and proofs.
//!
//! The search proceeds in stages, each with more units than all before it, from the same seed: more budget never gives a worse route.
//! With few targets, annealing runs follow the first stages, and one proof takes all remaining units. Annealing takes all units that
//! proofs do not need: three runs from the empty route, each of which ends in a good route that may be far from the best, and a last run
//! from the best of them at a lower initial temperature. With few targets, a proof by labels is tried after the first run: it often takes
//! less work than the other runs, and finds the best route if the first run did not. Without a known budget, runs of increasing length
//! follow each other.
use super::annealing::{self, Annealing, Round};
use super::polish;
use super::route::Route;
use crate::bounds::routes::{self, BoundSearch, FEW, Proven};
use crate::routing::network::Network;
use apex_planning::random::Generator;
use apex_planning::solver::Budget;

/// Units of the first run if the budget is not known; each later run has half as many again.
const ROUND_UNITS: u64 = 60_000;
/// Maximum number of consecutive runs without gain.
const STALE_ROUNDS_MAX: u32 = 30;
/// Initial and final temperatures, as multiples of the mean value of a target: for a new plan, for a new plan with many targets,
/// and for a good plan after a change.
const FRESH: (f64, f64) = (2.0, 0.05);
const FRESH_OF_MANY: (f64, f64) = (2.0, 0.2);
const CHANGED: (f64, f64) = (0.1, 0.02);
/// Number of runs of a new plan from the empty route, their share of the work, and the ratio of the last run's initial temperature to
/// theirs. Above the limit of nodes or below the limit of work, a single run takes all of it: shorter runs would end too early.
const FRESH_ROUNDS: u32 = 3;
const FRESH_SHARE: f64 = 0.75;
const LAST_HEAT: f64 = 0.1;
const ROUNDS_NODES_MAX: usize = 400;
const ROUNDS_UNITS_MIN: u64 = 10_000;
/// Share of the last run that a cooler run takes at its end if there are many targets.
const COOLER_SHARE: f64 = 0.3;
/// Share of the budget that a proof after the first run may take.
const EARLY_SHARE: f64 = 0.15;
/// If runs are more than twice as long, a run of this many units precedes that proof and the others.
const QUICK_UNITS: u64 = 100_000;
const QUICK_UNITS_OF_FEW: u64 = 37_500;
/// Share of the budget that the final bound may take, and its maximum in units.
const BOUND_SHARE: f64 = 0.15;
const BOUND_UNITS_MAX: u64 = 3_000_000;
/// With few targets, proofs, which may find a better route, take half of the budget; of a large budget they take all but this share,
/// which is at least this many units.
const SEARCH_SHARE_OF_FEW: f64 = 0.15;
const SEARCH_UNITS_OF_FEW: u64 = 300_000;
const BOUND_UNITS_MAX_OF_FEW: u64 = 100_000_000;
/// With few targets, the last decade of stages.
const STAGED_UNITS_OF_FEW: u64 = 100_000;

/// Share of a stage's search that shortens the best route while that visits all of many targets.
const TOUR_SHARE: f64 = 0.7;

/// Units of work at which the first stage ends, counted from the planner's start, and the growth factor of stages: usual budgets end with
/// a stage. Up to [`ROUNDS_NODES_MAX`] nodes a stage contains several annealing runs; above, a single one, which is of little use before
/// its end, so intermediate stages exist. A stage is skipped if less than the given part of it remains.
const FIRST_STAGE: u64 = 1_000;
const STAGE_STEP: u64 = 10;
const STAGE_BETWEEN_OF_MANY: u64 = 3;
const STAGE_PART_MIN: u64 = 4;
/// Relative tolerance between a value and its bound, for sums in different order.
const SAME_SHARE: f64 = 1e-9;

/// A search in progress.
pub(super) struct SearchDriver<'n> {
    network: &'n Network,
    /// Network of the bounds; it admits every feasible route of the problem.
    bounded: &'n Network,
    annealing: Annealing<'n>,
    /// True for a new plan with many targets.
    is_of_many: bool,
    /// Mean value of a target.
    mean: f64,
    /// Temperatures in units of value.
    hot: f64,
    cold: f64,
    /// Annealing runs from the empty route.
    rounds: u32,
    best: Route,
    question: Option<BoundSearch<'n>>,
    bound: Option<f64>,
    /// Generator of the random choices in [`SearchDriver::shorten`].
    chance: Generator,
}

impl<'n> SearchDriver<'n> {
    /// Creates a search from the route `first`; runs of a plan that is not `fresh` also begin there. The second network is that of
    /// the bounds.
    pub(super) fn new([network, bounded]: [&'n Network; 2], seed: u64, first: Route, fresh: bool) -> SearchDriver<'n> {
        let is_of_many = fresh && network.visits().len() > annealing::ALL_MISSING_MAX;
        let heat = match fresh {
            false => CHANGED,
            true if is_of_many => FRESH_OF_MANY,
            true => FRESH,
        };
        let mean = network.nodes.iter().map(|node| node.value).sum::<f64>() / network.visits().len().max(1) as f64;
        SearchDriver {
            network,
            bounded,
            annealing: Annealing::new(network, seed),
            is_of_many,
            mean,
            hot: heat.0 * mean,
            cold: heat.1 * mean,
            rounds: if fresh && network.nodes.len() <= ROUNDS_NODES_MAX { FRESH_ROUNDS } else { 0 },
            best: first,
            question: None,
            bound: None,
            chance: Generator::new(seed),
        }
    }

    /// Returns the best route within the budget, and an upper bound on the benefits, if one was found.
    pub(super) fn run(mut self, budget: &mut dyn Budget) -> (Route, Option<f64>) {
        // Annealing needs a known number of units; an unlimited budget is searched like one that a clock ends.
        match budget.left().filter(|left| *left < u64::MAX >> 8) {
            Some(left) if self.network.targets <= FEW => self.stages_of_few(budget.used().saturating_add(left), budget),
            Some(_) => self.stages(u64::MAX >> 8, budget),
            None => {
                self.go_on(budget);
                self.ask_finally(ROUND_UNITS, budget);
            }
        }
        (self.best, self.bound)
    }

    /// Runs the search for few targets: stages up to [`STAGED_UNITS_OF_FEW`], then as many annealing runs of fixed lengths as fit into
    /// `whole` units, and one proof with all remaining units, because an interrupted proof must start again. A smaller budget makes the
    /// same runs and ends earlier.
    fn stages_of_few(&mut self, whole: u64, budget: &mut dyn Budget) {
        self.stages(STAGED_UNITS_OF_FEW, budget);
        let mut end = STAGED_UNITS_OF_FEW * STAGE_STEP;
        while end <= whole && !self.is_settled() && !budget.exhausted() {
            self.cool((SEARCH_SHARE_OF_FEW * end as f64) as u64, 0, budget);
            end *= STAGE_BETWEEN_OF_MANY;
        }
        self.question = None;
        self.ask_finally(budget.left().unwrap_or(0), budget);
    }

    /// Runs the stages of all decades up to `until` units, or until the budget ends. A stage does not depend on the rest of the
    /// budget, so a smaller budget runs the same stages and ends earlier: it never finds a better route.
    fn stages(&mut self, until: u64, budget: &mut dyn Budget) {
        let goes_between = self.network.nodes.len() > ROUNDS_NODES_MAX || self.network.targets <= FEW;
        let mut decade = FIRST_STAGE;
        while decade <= until {
            let ends = [decade, decade * STAGE_BETWEEN_OF_MANY];
            for end in ends.into_iter().take(if goes_between { 2 } else { 1 }) {
                if self.is_settled() || budget.exhausted() {
                    return;
                }
                let left = end.saturating_sub(budget.used());
                if left >= end / STAGE_PART_MIN {
                    // A finished proof cannot be continued; a new one has more units from its first step on.
                    self.question = None;
                    self.stage(left, budget);
                }
            }
            decade *= STAGE_STEP;
        }
    }

    /// Runs annealing and proofs for `left` units; ends early if a proof settles the problem.
    fn stage(&mut self, left: u64, budget: &mut dyn Budget) {
        let (early, spare) = self.for_proofs(left);
        let search = left.saturating_sub(spare);
        let tour = if self.is_tour() { (TOUR_SHARE * search as f64) as u64 } else { 0 };
        self.shorten(tour, budget);
        self.cool(search - tour, early, budget);
        self.ask_finally(spare, budget);
    }

    /// Returns true if the best route visits all of many targets, all open from the start: only its length can be improved.
    fn is_tour(&self) -> bool {
        let all = self.best.seen.iter().all(|seen| *seen);
        all && self.network.targets > FEW && self.network.is_always_open()
    }

    /// Searches for a shorter order of the visits for `units`.
    fn shorten(&mut self, units: u64, budget: &mut dyn Budget) {
        if units == 0 {
            return;
        }
        let visits = polish::shorter(self.network, &self.best, units, &mut self.chance, budget);
        let route = Route::of(self.network, &visits);
        if route.is_feasible() {
            self.keep(route);
        }
    }

    fn ask_finally(&mut self, units: u64, budget: &mut dyn Budget) {
        if !self.is_settled() {
            self.ask(BoundSearch::answer, units, budget);
        }
    }

    /// Returns the units, of `left`, for the proof after the first run and for the final proof.
    fn for_proofs(&self, left: u64) -> (u64, u64) {
        let of = |share: f64| (share * left as f64) as u64;
        if self.network.targets > FEW {
            return (of(EARLY_SHARE), of(BOUND_SHARE).min(BOUND_UNITS_MAX));
        }
        let search = of(SEARCH_SHARE_OF_FEW).max(SEARCH_UNITS_OF_FEW);
        (of(EARLY_SHARE), left.saturating_sub(search).max(left / 2).min(BOUND_UNITS_MAX_OF_FEW))
    }

    /// Returns true if no route has more value. Bounds are on benefits; they ignore costs.
    fn is_settled(&self) -> bool {
        let value = self.best.value;
        self.network.cost_per_tick == 0.0 && self.bound.is_some_and(|bound| bound <= value + SAME_SHARE * value.abs())
    }

    /// Anneals for `units`, of which a proof after the first run takes `early`; ends early if the proof settles the problem.
    fn cool(&mut self, units: u64, early: u64, budget: &mut dyn Budget) {
        let until = budget.used().saturating_add(units);
        let rounds = if units < ROUNDS_UNITS_MIN { 0 } else { self.rounds };
        let early = if self.network.targets <= routes::ng_sets::TARGETS_MAX { early.min(units / 2) } else { 0 };
        let each = (FRESH_SHARE / f64::from(rounds.max(1)) * (units - early) as f64) as u64;
        // Labels need a good route, but not a very good one.
        let quick = if self.network.targets <= FEW { QUICK_UNITS_OF_FEW } else { QUICK_UNITS };
        let quick = Some(quick).filter(|quick| rounds > 0 && early > 0 && 2 * quick < each);
        for (round, units) in quick.into_iter().chain((0..rounds).map(|_| each)).enumerate() {
            self.round(&Route::new(self.network), (units, self.hot), budget);
            if round == 0 && early > 0 {
                self.ask(BoundSearch::ask_labels, early, budget);
                if self.is_settled() {
                    return;
                }
            }
        }
        let left = until.saturating_sub(budget.used());
        let cooler = if self.is_of_many { (COOLER_SHARE * left as f64) as u64 } else { 0 };
        let hot = if rounds > 0 { (LAST_HEAT * self.hot).max(self.cold) } else { self.hot };
        self.round(&self.best.clone(), (left - cooler, hot), budget);
        if self.is_of_many {
            (self.hot, self.cold) = (CHANGED.0 * self.mean, CHANGED.1 * self.mean);
            self.round(&self.best.clone(), (until.saturating_sub(budget.used()), self.hot), budget);
        }
    }

    /// Repeats runs of increasing length until [`STALE_ROUNDS_MAX`] runs in sequence bring no gain, or the budget ends.
    fn go_on(&mut self, budget: &mut dyn Budget) {
        let (mut units, mut stale) = (ROUND_UNITS, 0);
        while stale < STALE_ROUNDS_MAX && !budget.exhausted() {
            stale += 1;
            let start = if stale % 3 == 2 { self.annealing.first(budget) } else { self.best.clone() };
            let before = self.annealing.score(&self.best);
            self.round(&start, (units, self.hot), budget);
            if self.annealing.score(&self.best) > before + 1e-9 {
                stale = 0;
            }
            units += units / 2;
        }
    }

    fn round(&mut self, start: &Route, (units, hot): (u64, f64), budget: &mut dyn Budget) {
        let found = self.annealing.round(start, Round { units, hot, cold: self.cold }, budget);
        self.keep(found);
    }

    fn keep(&mut self, found: Route) {
        if self.annealing.is_better(&found, &self.best) {
            self.best = found;
        }
    }

    /// Computes an upper bound on the benefits within `units`.
    fn ask(&mut self, how: fn(&mut BoundSearch<'n>, f64, u64, &mut dyn Budget), units: u64, budget: &mut dyn Budget) {
        // The knapsack bound alone reads every leg twice.
        let nodes = self.network.nodes.len();
        if units as usize <= nodes * nodes / 100 {
            return;
        }
        let question = self.question.get_or_insert_with(|| BoundSearch::new(self.bounded));
        how(question, self.best.value, units, budget);
        let Proven { bound, better } = question.told();
        self.bound = Some(self.bound.map_or(bound, |known| known.min(bound)));
        if let Some(better) = better {
            // A route that is feasible in the relaxed network by a part of a tick may be infeasible in the true one; the bound then stays
            // above the best route.
            let route = Route::of(self.network, &better);
            if route.is_feasible() {
                self.keep(route);
            }
        }
    }
}
