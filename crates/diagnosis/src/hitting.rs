//! Minimal hitting sets: the smallest sets of failure modes that explain all failed tests, the likeliest first.
//!
//! The search is depth first, so that it already has good sets if it runs out of nodes. Every set is reached once: among the modes of a
//! branching clause, modes tried earlier are available to later branches, and modes still to be tried are not. A partial set is abandoned
//! if one of its modes is no longer the only one to hit some clause (Murakami and Uno 2014). Once enough sets have been found, partial
//! sets that cannot be cheaper than the worst of these are abandoned, too; the bound adds the cheapest modes of clauses that share no
//! mode.
//! Bound: the nodes given, each O(words x (modes of the set + forbidden sets)).

use crate::bits::Bits;

/// Reason for which a search ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SearchEnd {
    /// All minimal sets were found.
    All,
    /// There may be more minimal sets, but none is likelier than the sets found.
    Likeliest,
    /// The node limit ended the search: there may be more sets, even likelier ones.
    NodeLimit,
}

/// Input of a search.
pub(crate) struct Problem<'a> {
    /// Number of modes.
    pub(crate) modes: usize,
    /// Sets that must each be hit; none is empty or part of another.
    pub(crate) clauses: &'a [Bits],
    /// Forbidden sets: no result may contain all modes of one of them.
    pub(crate) nogoods: &'a [Bits],
    /// Cost of each mode, above 0.
    pub(crate) costs: &'a [f64],
    /// Maximum number of sets that are kept.
    pub(crate) keep: usize,
    /// Maximum number of partial sets that are examined.
    pub(crate) nodes: usize,
}

/// A set with its cost.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct HittingSet {
    pub(crate) set: Bits,
    pub(crate) cost: f64,
}

/// Number of open clauses considered for branching, from the first on; the smallest come first if the caller sorts them.
const SCANNED_MAX: usize = 12;
/// Maximum number of open clauses that the bound considers.
const BOUND_SCANNED_MAX: usize = 48;
/// Sums of the same costs in another order differ by less than this.
const TOLERANCE: f64 = 1e-9;

/// Returns the cheapest minimal hitting sets, by cost and then in order.
pub(crate) fn search(problem: &Problem<'_>) -> (Vec<HittingSet>, SearchEnd) {
    let clauses = problem.clauses.len();
    let mut columns = vec![Bits::new(clauses); problem.modes];
    let mut available = Bits::new(problem.modes);
    for (index, clause) in problem.clauses.iter().enumerate() {
        for mode in clause.iter() {
            if let Some(column) = columns.get_mut(mode) {
                column.insert(index);
            }
        }
        available.extend(clause);
    }
    let mut search = HittingSearch {
        problem,
        all: Bits::of(clauses, 0..clauses),
        columns,
        nodes: problem.nodes,
        found: Vec::new(),
        end: SearchEnd::All,
        chosen: Vec::new(),
    };
    let state =
        PartialSet { set: Bits::new(problem.modes), once: Bits::new(clauses), twice: Bits::new(clauses), cost: 0.0 };
    search.extend(&state, &mut available);
    if search.found.is_empty() && search.end == SearchEnd::NodeLimit {
        search.greedy(state);
    }
    (search.found, search.end)
}

/// A partial set.
struct PartialSet {
    set: Bits,
    /// Clauses that are hit at least once, and at least twice.
    once: Bits,
    twice: Bits,
    cost: f64,
}

struct HittingSearch<'a> {
    problem: &'a Problem<'a>,
    /// All clauses.
    all: Bits,
    /// The clauses that each mode hits.
    columns: Vec<Bits>,
    nodes: usize,
    /// By cost, the most expensive at the end.
    found: Vec<HittingSet>,
    end: SearchEnd,
    chosen: Vec<usize>,
}

impl HittingSearch<'_> {
    /// Extends a partial set in all possible ways. On return `available` is unchanged.
    fn extend(&mut self, state: &PartialSet, available: &mut Bits) {
        let Some(branch) = self.branch(state, available) else {
            if state.once.len() == self.problem.clauses.len() {
                self.keep(state);
            }
            return;
        };
        if self.is_beaten(state, available) {
            self.end = self.end.worse(SearchEnd::Likeliest);
            return;
        }
        available.subtract(&branch);
        for mode in self.in_order(&branch, state) {
            if self.nodes == 0 {
                self.end = SearchEnd::NodeLimit;
                break;
            }
            self.nodes -= 1;
            let Some(next) = self.with(state, mode) else { continue };
            self.chosen.push(mode);
            self.extend(&next, available);
            self.chosen.pop();
            if self.end == SearchEnd::NodeLimit {
                break;
            }
            available.insert(mode);
        }
        available.extend(&branch);
    }

    /// Finds one set if the node limit was reached before any was found. It repeatedly takes the mode that hits the first open clause and
    /// the most others for its cost, and finally removes unneeded modes.
    fn greedy(&mut self, mut state: PartialSet) {
        loop {
            let clause = self.unhit(&state).next();
            let Some(mode) = clause.map(|clause| self.in_order(clause, &state)) else { break };
            let Some(mode) = mode.first().copied() else { return };
            state.set.insert(mode);
            self.columns.get(mode).into_iter().for_each(|column| state.once.extend(column));
        }
        let hits = |set: &Bits| self.problem.clauses.iter().all(|clause| clause.intersects(set));
        for mode in state.set.clone().iter() {
            state.set.remove(mode);
            if !hits(&state.set) {
                state.set.insert(mode);
            }
        }
        if !self.problem.nogoods.iter().any(|nogood| nogood.is_subset(&state.set)) {
            self.keep(&state);
        }
    }

    /// Returns the available modes of the clause with the fewest among the first open ones; `None` if all clauses are hit, or one cannot
    /// be hit.
    fn branch(&self, state: &PartialSet, available: &Bits) -> Option<Bits> {
        let mut fewest: Option<(usize, &Bits)> = None;
        for clause in self.unhit(state).take(SCANNED_MAX) {
            let count = clause.common(available);
            if count == 0 {
                return None;
            }
            if fewest.is_none_or(|(least, _)| count < least) {
                fewest = Some((count, clause));
            }
        }
        let (_, clause) = fewest?;
        let mut branch = clause.clone();
        branch.retain(available);
        Some(branch)
    }

    /// Returns the clauses that are not hit, in their order.
    fn unhit<'s>(&'s self, state: &'s PartialSet) -> impl Iterator<Item = &'s Bits> {
        let open = self.all.words().iter().zip(state.once.words()).map(|(all, once)| all & !once);
        open.enumerate()
            .flat_map(|(word, rest)| Bits::numbers(word, rest))
            .filter_map(|index| self.problem.clauses.get(index))
    }

    /// Returns the modes of a clause, ordered so that modes that hit many clauses for their cost come first.
    fn in_order(&self, branch: &Bits, state: &PartialSet) -> Vec<usize> {
        let worth = |mode: usize| {
            let hits = self.columns.get(mode).map_or(0, |column| column.beyond(&state.once));
            self.cost(mode) / hits.max(1) as f64
        };
        let mut modes: Vec<(f64, usize)> = branch.iter().map(|mode| (worth(mode), mode)).collect();
        modes.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        modes.into_iter().map(|(_, mode)| mode).collect()
    }

    fn cost(&self, mode: usize) -> f64 {
        self.problem.costs.get(mode).copied().unwrap_or(f64::INFINITY)
    }

    /// Returns the partial set with one more mode; `None` if another mode then becomes unneeded, or if the set contains a forbidden set.
    fn with(&self, state: &PartialSet, mode: usize) -> Option<PartialSet> {
        let column = self.columns.get(mode)?;
        let (mut once, mut twice, mut set) = (state.once.clone(), state.twice.clone(), state.set.clone());
        let pairs = twice.words_mut().iter_mut().zip(once.words()).zip(column.words());
        pairs.for_each(|((twice, once), column)| *twice |= once & column);
        once.extend(column);
        set.insert(mode);
        let is_needed = |chosen: &usize| self.columns.get(*chosen).is_some_and(|column| column.beyond(&twice) > 0);
        let is_good =
            self.chosen.iter().all(is_needed) && !self.problem.nogoods.iter().any(|nogood| nogood.is_subset(&set));
        is_good.then(|| PartialSet { set, once, twice, cost: state.cost + self.cost(mode) })
    }

    /// Returns true if no extension of this partial set can be cheaper than the worst kept set.
    fn is_beaten(&self, state: &PartialSet, available: &Bits) -> bool {
        let worst = match self.found.last() {
            Some(worst) if self.found.len() >= self.problem.keep => worst.cost,
            _ => return false,
        };
        let mut bound = state.cost;
        let mut seen = Bits::new(self.problem.modes);
        for clause in self.unhit(state).take(BOUND_SCANNED_MAX) {
            let mut ways = clause.clone();
            ways.retain(available);
            if !ways.intersects(&seen) {
                bound += ways.iter().map(|mode| self.cost(mode)).fold(f64::INFINITY, f64::min);
                seen.extend(&ways);
            }
        }
        bound > worst + TOLERANCE
    }

    fn keep(&mut self, state: &PartialSet) {
        // Summed in the order of the modes: equal sets have equal costs, however they were reached.
        let cost = state.set.iter().map(|mode| self.cost(mode)).sum();
        let found = HittingSet { set: state.set.clone(), cost };
        let order =
            |other: &HittingSet| other.cost.total_cmp(&cost).then_with(|| other.set.iter().cmp(found.set.iter()));
        let at = self.found.partition_point(|other| order(other).is_lt());
        self.found.insert(at, found);
        if self.found.len() > self.problem.keep {
            self.found.truncate(self.problem.keep);
            self.end = self.end.worse(SearchEnd::Likeliest);
        }
    }
}

impl SearchEnd {
    pub(crate) fn worse(self, other: SearchEnd) -> SearchEnd {
        match (self, other) {
            (SearchEnd::NodeLimit, _) | (_, SearchEnd::NodeLimit) => SearchEnd::NodeLimit,
            (SearchEnd::Likeliest, _) | (_, SearchEnd::Likeliest) => SearchEnd::Likeliest,
            (SearchEnd::All, SearchEnd::All) => SearchEnd::All,
        }
    }
}
