//! The naive arbiter: the rules of `pdl.md`, Conflicts and of decisions 0008, 0010, 0013, 0023, 0029, 0031 and 0035, one by one, with
//! every set of holders tried. It shares no code with the executive.

mod order;
mod room;

use super::world::{FUEL, Moment, Node, RESOURCES, World};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// Not created yet, or ended and removed.
    Absent,
    Pending,
    Enabled,
    Ongoing,
    Interrupted,
}

/// A task that was refused, and the earliest instant at which it can begin, if known.
struct Awaited {
    task: usize,
    earliest: Option<i64>,
}

/// Result of one arbitration, in the order of its decisions.
struct Outcome {
    granted: Vec<usize>,
    /// Displaced holders with the winners.
    displaced: Vec<(usize, usize)>,
    /// Tasks whose needs can never be met.
    impossible: Vec<usize>,
}

/// Everything that decides an arbitration, except for the time.
#[derive(PartialEq)]
struct Competition {
    states: Vec<State>,
    suspended: Vec<bool>,
    failed: Vec<bool>,
    needs: Vec<[f64; 4]>,
    totals: [f64; 4],
}

/// The state that the rules read.
pub struct Twin {
    nodes: Vec<Node>,
    pub states: Vec<State>,
    suspended: Vec<bool>,
    /// Tasks whose needs can never be met, and whose failure is not handled yet.
    failed: Vec<bool>,
    /// Serial number of the creation of each task.
    born: Vec<u32>,
    /// Instant of the last change of state.
    since: Vec<u32>,
    /// Time for which the task was ongoing before that change.
    worked: Vec<u32>,
    /// Remainder of each need: parts of a reservation that descendants consumed are subtracted.
    needs: Vec<[f64; 4]>,
    pub totals: [f64; 4],
    now: u32,
    births: u32,
    /// Events of this instant: tasks created now receive them too.
    present: Option<Moment>,
    /// Competition at the last decision of the arbiter.
    competed: Option<Competition>,
}

impl Twin {
    /// Returns the world at its beginning, when the root has started.
    pub fn new(world: &World) -> Twin {
        let nodes = world.nodes.clone();
        let count = nodes.len();
        let needs = nodes.iter().map(|node| node.needs.map(f64::from)).collect();
        let mut twin = Twin {
            nodes,
            states: vec![State::Absent; count],
            suspended: vec![false; count],
            failed: vec![false; count],
            born: vec![0; count],
            since: vec![0; count],
            worked: vec![0; count],
            needs,
            totals: RESOURCES.map(|(_, total)| total),
            now: 0,
            births: 0,
            present: None,
            competed: None,
        };
        twin.create_children(None);
        twin.settle();
        twin
    }

    /// Processes one instant.
    pub fn happen(&mut self, moment: &Moment) {
        self.now += 1;
        self.present = Some(moment.clone());
        match moment {
            Moment::Changes(go, stop) => {
                let mut stop = stop.clone();
                stop.sort_by_key(|each| self.born[*each]);
                for each in stop {
                    self.end(each, true);
                }
                for each in go {
                    if self.states[*each] == State::Pending {
                        self.states[*each] = State::Enabled;
                    }
                }
            }
            Moment::Hold(each) => {
                if self.states[*each] != State::Absent && !self.suspended[*each] {
                    self.suspended[*each] = true;
                    for other in 0..self.nodes.len() {
                        if (other == *each || self.is_above(*each, other)) && self.states[other] == State::Ongoing {
                            self.change(other, State::Interrupted);
                        }
                    }
                }
            }
            Moment::Free(each) => self.suspended[*each] &= self.states[*each] == State::Absent,
        }
        self.settle();
    }

    fn change(&mut self, task: usize, state: State) {
        if self.states[task] == State::Ongoing {
            self.worked[task] += self.now - self.since[task];
        }
        self.states[task] = state;
        self.since[task] = self.now;
    }

    fn create_children(&mut self, parent: Option<usize>) {
        for child in (0..self.nodes.len()).filter(|child| self.nodes[*child].parent == parent).collect::<Vec<_>>() {
            self.births += 1;
            self.born[child] = self.births;
            self.suspended[child] = false;
            self.worked[child] = 0;
            let (go, stop) = match &self.present {
                Some(Moment::Changes(go, stop)) => (go.contains(&child), stop.contains(&child)),
                Some(Moment::Hold(task)) => {
                    self.suspended[child] = *task == child;
                    (false, false)
                }
                Some(Moment::Free(_)) | None => (false, false),
            };
            let state = match (stop, self.nodes[child].waits && !go) {
                (true, _) => State::Absent,
                (false, true) => State::Pending,
                (false, false) => State::Enabled,
            };
            self.change(child, state);
        }
        if let Some(parent) = parent.filter(|parent| self.is_done(*parent)) {
            self.end(parent, true);
        }
    }

    fn is_done(&self, group: usize) -> bool {
        let gone = |each: usize| self.states[each] == State::Absent && !self.failed[each];
        (0..self.nodes.len()).all(|each| self.nodes[each].parent != Some(group) || gone(each))
    }

    fn is_above(&self, ancestor: usize, task: usize) -> bool {
        self.ancestors(task).skip(1).any(|each| each == ancestor)
    }

    fn related(&self, a: usize, b: usize) -> bool {
        a == b || self.is_above(a, b) || self.is_above(b, a)
    }

    /// Returns the task and all its ancestors.
    fn ancestors(&self, task: usize) -> impl Iterator<Item = usize> + '_ {
        std::iter::successors(Some(task), |each| self.nodes[*each].parent)
    }

    fn end_below(&mut self, task: usize) {
        for child in (0..self.nodes.len()).filter(|child| self.nodes[*child].parent == Some(task)).collect::<Vec<_>>() {
            self.end(child, false);
        }
    }

    /// Ends a task with its subtree; its reservations are consumed if it ended on its own.
    fn end(&mut self, task: usize, used: bool) {
        self.failed[task] = false;
        if self.states[task] == State::Absent {
            return;
        }
        self.end_below(task);
        if used && self.states[task] == State::Ongoing {
            let consumed = self.needs[task][FUEL];
            self.totals[FUEL] -= consumed;
            let above: Vec<usize> = self.ancestors(task).skip(1).collect();
            for ancestor in above.into_iter().filter(|each| self.states[*each] == State::Ongoing).collect::<Vec<_>>() {
                self.needs[ancestor][FUEL] = (self.needs[ancestor][FUEL] - consumed).max(0.0);
            }
        }
        self.states[task] = State::Absent;
        if let Some(parent) = self.nodes[task].parent.filter(|parent| used && self.is_done(*parent)) {
            self.end(parent, true);
        }
    }

    /// Repeats contention until nothing changes. The passing of time alone grants nothing.
    fn settle(&mut self) {
        for _ in 0..100 {
            let competition = Competition {
                states: self.states.clone(),
                suspended: self.suspended.clone(),
                failed: self.failed.clone(),
                needs: self.needs.clone(),
                totals: self.totals,
            };
            if self.competed.as_ref() == Some(&competition) {
                return;
            }
            self.competed = Some(competition);
            self.contend();
        }
        panic!("the twin does not come to rest");
    }

    fn is_eligible(&self, task: usize) -> bool {
        let may = match self.states[task] {
            State::Interrupted => true,
            State::Enabled => self.parent_works(task),
            State::Absent | State::Pending | State::Ongoing => false,
        };
        may && self.ancestors(task).all(|each| !self.suspended[each])
    }

    fn contend(&mut self) {
        let mut claimants: Vec<usize> = (0..self.nodes.len()).filter(|task| self.is_eligible(*task)).collect();
        let Outcome { granted, displaced, impossible } = loop {
            let outcome = self.arbitrate(&claimants);
            let barred = self.barred(&outcome);
            if barred.is_empty() {
                break outcome;
            }
            claimants.retain(|task| !barred.contains(task));
        };
        for (task, _) in displaced {
            self.change(task, State::Interrupted);
        }
        self.handle_failures();
        for task in impossible {
            // A failure handler does not begin below a task that stops: it is considered again when that task continues.
            if self.parent_works(task) {
                self.end_below(task);
                self.states[task] = State::Absent;
                self.failed[task] = true;
            }
        }
        let mut begin = Vec::new();
        for task in granted {
            if self.states[task] == State::Enabled && self.nodes[task].is_group {
                begin.push(task);
            }
            if self.is_eligible(task) {
                self.change(task, State::Ongoing);
            }
        }
        begin.sort_by_key(|task| self.born[*task]);
        for task in begin {
            if self.states[task] == State::Ongoing {
                self.create_children(Some(task));
            }
        }
    }

    /// Lets handlers of failures of the preceding round begin, even if the parent has just lost its resources: the failed task is ongoing
    /// until its failure is handled.
    fn handle_failures(&mut self) {
        let handled: Vec<usize> = (0..self.nodes.len()).filter(|task| self.failed[*task]).collect();
        for task in &handled {
            self.failed[*task] = false;
            if let Some(parent) = self.nodes[*task].parent.filter(|parent| self.is_done(*parent)) {
                self.end(parent, true);
            }
        }
    }

    fn parent_works(&self, task: usize) -> bool {
        self.nodes[task].parent.is_none_or(|parent| self.states[parent] == State::Ongoing)
    }

    /// Returns the steps that do not begin because their parent stops: those whose parent stops for a task that surely begins; without any
    /// of these, the last such step.
    fn barred(&self, outcome: &Outcome) -> Vec<usize> {
        let parent_stops_for = |task: usize| {
            let parent = self.nodes[task].parent.filter(|parent| !outcome.granted.contains(parent))?;
            outcome.displaced.iter().find(|(loser, _)| *loser == parent).map(|(_, winner)| *winner)
        };
        let begins = |task: &&usize| self.states[**task] == State::Enabled;
        let granted = outcome.granted.iter().filter(begins);
        let orphans: Vec<(usize, usize)> = granted.filter_map(|task| Some((*task, parent_stops_for(*task)?))).collect();
        let is_orphan = |task: usize| orphans.iter().any(|(orphan, _)| *orphan == task);
        let certain: Vec<usize> =
            orphans.iter().filter(|(_, cause)| !is_orphan(*cause)).map(|(task, _)| *task).collect();
        if certain.is_empty() { orphans.last().map(|(task, _)| *task).into_iter().collect() } else { certain }
    }

    fn priority(&self, task: usize) -> f64 {
        let counts = |each: &usize| *each == task || self.states[*each] != State::Interrupted;
        let clauses = self.ancestors(task).filter(counts).filter_map(|each| self.nodes[each].priority);
        clauses.reduce(f64::max).unwrap_or(0.0)
    }

    fn cost(&self, task: usize) -> f64 {
        self.nodes[task].cost.unwrap_or(0.1)
    }

    fn rank(&self, task: usize) -> Option<i32> {
        if self.nodes[task].rank.is_some() {
            return self.nodes[task].rank;
        }
        let parent = self.nodes[task].parent.filter(|parent| self.nodes[*parent].ranked)?;
        let before = (0..task).filter(|each| self.nodes[*each].parent == Some(parent)).count();
        Some(before as i32 + 1)
    }

    /// Returns `Some(true)` if `a` has the lower rank among the siblings at which the lines of ancestors part; `None` if no ranks decide.
    fn before_by_rank(&self, a: usize, b: usize) -> Option<bool> {
        let (first, second): (Vec<usize>, Vec<usize>) = (self.ancestors(a).collect(), self.ancestors(b).collect());
        let pair = first.iter().flat_map(|x| second.iter().map(move |y| (*x, *y)));
        let mut siblings = pair.filter(|(x, y)| x != y && self.nodes[*x].parent == self.nodes[*y].parent);
        let (x, y) = siblings.next()?;
        match (self.rank(x), self.rank(y)) {
            (Some(x), Some(y)) if x != y => Some(x < y),
            _ => None,
        }
    }

    /// Returns the sort key of a claimant; better claimants have lower keys.
    fn key(&self, task: usize, competitors: &[usize]) -> impl PartialOrd + use<> {
        let waits_to_begin = self.waits_to_begin(task, competitors);
        let parent = self.nodes[task].parent.map_or(0, |parent| self.born[parent]);
        (-self.priority(task), waits_to_begin, parent, task, self.born[task])
    }

    /// Returns true if the task has not begun, or a task that has not begun precedes it.
    fn waits_to_begin(&self, task: usize, competitors: &[usize]) -> bool {
        let mut ahead = competitors.iter().filter(|each| self.goes_before(**each, task));
        !matches!(self.states[task], State::Ongoing | State::Interrupted)
            || ahead.any(|each| self.waits_to_begin(*each, competitors))
    }

    fn share(&self, a: usize, b: usize) -> bool {
        (0..4).any(|which| self.needs[a][which] > 0.0 && self.needs[b][which] > 0.0)
    }

    /// Arbitrates among all claimants, the best first.
    fn arbitrate(&self, claimants: &[usize]) -> Outcome {
        let mut remaining = claimants.to_vec();
        let mut held: Vec<usize> = (0..self.nodes.len()).filter(|each| self.states[*each] == State::Ongoing).collect();
        let (mut granted, mut awaited): (Vec<usize>, Vec<Awaited>) = (Vec::new(), Vec::new());
        let (mut displaced, mut impossible) = (Vec::new(), Vec::new());
        let order = self.order(claimants.iter().chain(&held).copied().collect());
        let first = |remaining: &[usize]| order.iter().copied().find(|task| remaining.contains(task));
        let weight = |task: usize| self.weight(task, &order);
        let defence = |task: usize| weight(task) + self.cost(task);
        while let Some(best) = first(&remaining) {
            remaining.retain(|each| *each != best);
            if (0..4).any(|which| self.needs[best][which] > self.totals[which]) {
                impossible.push(best);
                continue;
            }
            let loses = |holder: &usize| {
                let by_rank = self.before_by_rank(best, *holder);
                !self.related(best, *holder)
                    && self.share(best, *holder)
                    && by_rank.unwrap_or(weight(best) > defence(*holder))
            };
            let weakest_first = self.weakest_first(held.iter().copied().filter(loses).collect(), &defence);
            // Bit `i` of a number selects holder `i`, the weakest first: a set with a stronger strongest member has a greater number.
            let sets = 0..1_u32 << weakest_first.len();
            let members = |set: u32| {
                let list = weakest_first.iter().enumerate();
                list.filter(move |(bit, _)| set & 1 << bit != 0).map(|(_, task)| *task).collect::<Vec<_>>()
            };
            let enough = |set: &u32| {
                let gone = members(*set);
                let stays: Vec<usize> = held.iter().copied().filter(|each| !gone.contains(each)).collect();
                let counts = self.counts(best, &awaited, *set == 0);
                (0..4).all(|which| self.fits(best, which, &[&stays[..], &granted, &counts].concat()))
            };
            match sets.into_iter().find(enough) {
                Some(set) => {
                    for loser in members(set) {
                        held.retain(|each| *each != loser);
                        displaced.push((loser, best));
                        remaining.push(loser);
                    }
                    granted.push(best);
                }
                None => {
                    let gone = weakest_first;
                    let stays: Vec<usize> = held.iter().copied().filter(|each| !gone.contains(each)).collect();
                    let counts = self.counts(best, &awaited, gone.is_empty());
                    let earliest = self.earliest(best, &[stays, granted.clone()].concat(), &counts, &awaited);
                    awaited.push(Awaited { task: best, earliest });
                }
            }
        }
        Outcome { granted, displaced, impossible }
    }
}
