//! Episode index: the undecided threshold episodes of one state variable, in arrays, so that a sample costs each of them one
//! comparison.
//!
//! A threshold episode compares a number with fixed bounds, and has at most a greatest gap and a least duration. Until it is decided a
//! sample can change its truth, end its run by a gap, or complete its duration. The episode index watches for these in arrays; the monitor
//! itself is touched only when its episode is decided or queried. An unusual sample (late, replacing, of another kind) first returns every
//! episode to its monitor, which then processes the sample.

use crate::state::bindings::Bindings;
use crate::state::monitors::monitor::{ObjectRun, Run, RunSample};
pub use crate::state::threshold_episode::{
    EpisodeUpdate, IndexedRun, LeafId, OpenResult, Taken, ThresholdBounds, ThresholdEpisode, What,
};
use crate::state::wake::WakeKey;
use apex_model::quantity::Dimension;
use apex_model::time::{Duration, Time};
use apex_model::value::Value;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Above this magnitude not every integer is exact as a double: such values take the general path.
pub const EXACT_INTEGER_MAX: i64 = 1 << 53;

/// Episodes by row. All rows have received the same samples since they were added.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EpisodeIndex {
    dimension: Dimension,
    rows: BTreeMap<LeafId, usize>,
    leaves: Vec<LeafId>,
    bands: Vec<ThresholdBounds>,
    holds: Vec<bool>,
    /// Instants at which runs are long enough; the end of time without a run.
    deadlines: Vec<Time>,
    gaps: Vec<Duration>,
    states: Vec<LeafState>,
    /// Number of samples received, including the newest.
    samples: i64,
    newest: Time,
    /// The sample before the newest.
    previous: Time,
    /// A lower bound of all deadlines.
    deadline_floor: Time,
    gap_least: Duration,
    gap_most: Duration,
    window_latest: Time,
    /// First instant at which time alone decides an episode unless a sample arrives before, with the episode.
    due: Option<(Time, LeafId)>,
    /// The requested wake with its monitor; maintained by the caller that feeds the episode index.
    pub wake: Option<(WakeKey, LeafId)>,
}

/// The part of the state that seldom changes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct LeafState {
    duration_min: Duration,
    window_start: Time,
    /// True if the episode received a sample before it was added.
    seen: bool,
    came_at: i64,
    /// Start of the run that contains the newest sample, if it satisfies the bounds.
    start: Time,
    first: i64,
    contradicted: bool,
    gap: Option<Duration>,
    open: Option<OpenResult>,
    negated: bool,
    /// State before the newest sample, if that sample changed it.
    before: Before,
}

/// A row before the sample at `at`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Before {
    at: Time,
    held: bool,
    start: Time,
    first: i64,
    contradicted: bool,
    gap: Option<Duration>,
    /// Instant at which the run's result was recognised, if it had one.
    found_at: Option<Time>,
}

impl LeafState {
    /// Records that truth or run changed at the sample at `at`, which has number `sample`; `apart` if a gap lies before it, which is
    /// `cut` if it cut a run.
    fn turn(&mut self, at: Time, sample: i64, (held, holds): (bool, bool), apart: bool, cut: Option<Duration>) {
        let contradicted = !apart && (self.contradicted || (!held && self.has_seen_any(sample.saturating_sub(1))));
        let LeafState { start, first, gap, open, .. } = *self;
        let found_at = open.map(|open| open.recognised_at);
        self.before = Before { at, held, start, first, contradicted, gap, found_at };
        self.open = None;
        self.gap = cut.or(gap);
        self.contradicted = !holds || (contradicted && cut.is_none());
        (self.start, self.first) = (at, sample);
    }

    /// Returns true if it has received one of the first `samples` samples of the episode index, or one before it was added.
    fn has_seen_any(&self, samples: i64) -> bool {
        self.seen || samples > self.came_at
    }
}

/// Returns the number of samples from number `first` to number `last`.
fn length(first: i64, last: i64) -> u64 {
    u64::try_from(last.saturating_sub(first).saturating_add(1)).unwrap_or_default()
}

/// Returns the value as a plain number if comparing it as a double is exact.
pub fn plain_number(value: &Value) -> Option<(f64, Dimension)> {
    match value {
        Value::Integer(integer) if integer.unsigned_abs() > EXACT_INTEGER_MAX.unsigned_abs() => None,
        Value::Integer(_) | Value::Real(_) | Value::Quantity(_) => {
            value.as_number().filter(|(number, _)| !number.is_nan())
        }
        _ => None,
    }
}

impl EpisodeIndex {
    /// Returns an episode index without episodes, for numbers of `dimension`.
    pub fn new(dimension: Dimension) -> EpisodeIndex {
        EpisodeIndex {
            dimension,
            rows: BTreeMap::new(),
            leaves: Vec::new(),
            bands: Vec::new(),
            holds: Vec::new(),
            deadlines: Vec::new(),
            gaps: Vec::new(),
            states: Vec::new(),
            samples: 0,
            newest: Time::BEGINNING,
            previous: Time::BEGINNING,
            deadline_floor: Time::END,
            gap_least: Duration::MAX,
            gap_most: Duration::ZERO,
            window_latest: Time::BEGINNING,
            due: None,
            wake: None,
        }
    }

    /// Returns the number of episodes.
    pub fn len(&self) -> usize {
        self.leaves.len()
    }

    /// Returns true if the index has no episodes.
    pub fn is_empty(&self) -> bool {
        self.leaves.is_empty()
    }

    /// Returns true if the index holds the episode.
    pub fn contains(&self, leaf: LeafId) -> bool {
        self.rows.contains_key(&leaf)
    }

    /// Returns the first instant at which time alone decides an episode if no sample comes before.
    pub fn due(&self) -> Option<(Time, LeafId)> {
        self.due
    }

    /// Adds an undecided episode with its bounds and the run of its samples. Returns false, and changes nothing, if its samples differ
    /// from those of the others or its numbers have another dimension.
    pub fn insert(&mut self, leaf: LeafId, wanted: &ThresholdEpisode, run: Option<&ObjectRun>) -> bool {
        let same_samples = self.samples == 0 || run.is_none_or(|run| run.newest.at == self.newest);
        if wanted.dimension != self.dimension || !same_samples || self.contains(leaf) {
            return false;
        }
        if let Some(run) = run {
            if self.samples == 0 {
                (self.samples, self.newest) = (1, run.newest.at);
            }
            self.previous = run.run.as_ref().map_or(self.previous, |run| self.previous.max(run.last));
        }
        let (holds, state) = self.state_of(wanted, run);
        let waits = holds && wanted.open.is_none();
        let deadline = if waits { state.start + wanted.duration_min } else { Time::END };
        self.rows.insert(leaf, self.leaves.len());
        self.leaves.push(leaf);
        self.bands.push(wanted.band);
        self.holds.push(holds);
        self.deadlines.push(deadline);
        self.gaps.push(wanted.gap_max);
        self.states.push(state);
        self.deadline_floor = self.deadline_floor.min(deadline);
        self.gap_least = self.gap_least.min(wanted.gap_max);
        if wanted.gap_max < Duration::MAX {
            self.gap_most = self.gap_most.max(wanted.gap_max);
        }
        self.window_latest = self.window_latest.max(wanted.window_start);
        let due = deadline > self.newest && deadline <= self.newest + wanted.gap_max && wanted.gap_max < Duration::MAX;
        if due && self.due.is_none_or(|(at, _)| deadline < at) {
            self.due = Some((deadline, leaf));
        }
        true
    }

    fn state_of(&self, wanted: &ThresholdEpisode, run: Option<&ObjectRun>) -> (bool, LeafState) {
        let nothing = Before {
            at: Time::BEGINNING,
            held: false,
            start: Time::END,
            first: 0,
            contradicted: false,
            gap: None,
            found_at: None,
        };
        let mut state = LeafState {
            duration_min: wanted.duration_min,
            window_start: wanted.window_start,
            seen: false,
            came_at: self.samples,
            start: Time::END,
            first: 0,
            contradicted: false,
            gap: None,
            open: None,
            negated: wanted.negated,
            before: nothing,
        };
        let Some(ObjectRun { run, newest, contradicted, gap, found, .. }) = run else { return (false, state) };
        let found_at = found.as_ref().map(|found| found.recognised_at);
        // The state without the newest sample first; the newest is then processed as in `sample`.
        (state.contradicted, state.gap) = (*contradicted, *gap);
        if let Some(run) = run {
            let samples = i64::try_from(run.samples).unwrap_or(i64::MAX);
            (state.start, state.first) = (run.start, self.samples.saturating_sub(samples));
        }
        let (held, holds) = (run.is_some(), newest.holds.is_some());
        let cut = run.as_ref().map(|run| newest.at - run.last).filter(|gap| *gap > wanted.gap_max);
        let LeafState { start, first, .. } = state;
        if held != holds || cut.is_some() {
            state.turn(newest.at, self.samples, (held, holds), cut.is_some(), cut);
        } else {
            state.contradicted |= !holds;
        }
        state.before = Before { at: newest.at, held, start, first, contradicted: *contradicted, gap: *gap, found_at };
        (state.seen, state.open) = (true, wanted.open);
        (holds, state)
    }

    /// Returns the number of a sample that [`EpisodeIndex::sample`] can process; `None` if all episodes must be removed first.
    pub fn takes(&self, at: Time, value: &Value) -> Option<f64> {
        // Episodes that time alone has decided must be taken out before the sample is processed.
        let in_time = self.due.is_none_or(|(due, _)| due >= at);
        let ordinary = at > self.newest && at >= self.window_latest && in_time;
        let (number, dimension) = plain_number(value).filter(|_| ordinary)?;
        (dimension == self.dimension).then_some(number)
    }

    /// Processes a sample that [`EpisodeIndex::takes`] accepts, and returns its effects: runs with a result that are over, and runs that
    /// have a result from now on. The latter stay in the episode index, as open ones.
    pub fn sample(&mut self, at: Time, value: f64, told: &mut Vec<EpisodeUpdate>) {
        let gap = if self.samples == 0 { Duration::ZERO } else { at - self.newest };
        let gaps = gap > self.gap_least;
        (self.previous, self.newest) = (self.newest, at);
        self.samples = self.samples.saturating_add(1);
        let (sample, last) = (self.samples, self.previous);
        let mut floor = self.deadline_floor;
        let rows =
            self.bands.iter().zip(&mut self.holds).zip(&mut self.states).zip(&mut self.deadlines).zip(&self.gaps);
        for (((((band, held), state), deadline), gap_max), leaf) in rows.zip(&self.leaves) {
            let holds = (value >= band.least) & (value <= band.most);
            if holds != *held || (gaps && holds && gap > *gap_max) {
                let apart = gap > *gap_max;
                let cut = (*held && apart).then_some(gap);
                if let Some(OpenResult { recognised_at, .. }) = state.open {
                    let samples = length(state.first, sample.saturating_sub(1));
                    let (leaf, what, start) = (*leaf, What::Over, state.start);
                    told.push(EpisodeUpdate { leaf, what, start, last, samples, recognised_at });
                }
                if state.negated && *held && !holds {
                    let (leaf, what, start) = (*leaf, What::Contradicted, state.start);
                    told.push(EpisodeUpdate { leaf, what, start, last, samples: 0, recognised_at: at });
                }
                state.turn(at, sample, (*held, holds), apart, cut);
                *held = holds;
                *deadline = if holds { at + state.duration_min } else { Time::END };
                floor = floor.min(*deadline);
            } else if gaps && !holds && gap > *gap_max && state.negated {
                // The gap made the value unknown, and the sample contradicts it again.
                let (leaf, what, start) = (*leaf, What::Contradicted, state.start);
                told.push(EpisodeUpdate { leaf, what, start, last, samples: 0, recognised_at: at });
            }
        }
        self.deadline_floor = floor;
        self.look_at_deadlines(at, told);
    }

    /// Finds the episodes that the newest sample or the time `now` decides, and the next one that time alone will decide.
    fn look_at_deadlines(&mut self, now: Time, told: &mut Vec<EpisodeUpdate>) {
        self.due = None;
        let newest = self.newest;
        if self.deadline_floor > newest + self.gap_most {
            return;
        }
        let (mut floor, mut due) = (Time::END, None);
        let rows = self.deadlines.iter_mut().zip(&self.gaps).zip(&self.leaves).zip(&mut self.states);
        for (((deadline, gap), leaf), state) in rows {
            let licensed = *deadline <= newest + *gap && *gap < Duration::MAX;
            if *deadline <= newest || (licensed && *deadline <= now) {
                let recognised_at = if *deadline <= newest { newest } else { *deadline };
                let samples = length(state.first, self.samples);
                let (leaf, what, start) = (*leaf, What::Found, state.start);
                told.push(EpisodeUpdate { leaf, what, start, last: newest, samples, recognised_at });
                state.open = Some(OpenResult { recognised_at, newest });
                *deadline = Time::END;
            } else if licensed {
                let this = (*deadline, *leaf);
                due = Some(due.map_or(this, |least: (Time, LeafId)| least.min(this)));
            }
            floor = floor.min(*deadline);
        }
        (self.deadline_floor, self.due) = (floor, due);
    }

    fn take_each(&mut self, leaves: Vec<LeafId>, taken: &mut Taken) {
        taken.extend(leaves.into_iter().filter_map(|leaf| Some((leaf, self.take(leaf)?))));
    }

    /// Removes the episodes that have a result now, for callers that need one result only.
    pub fn take_decided(&mut self, told: &[EpisodeUpdate], taken: &mut Taken) {
        let decided = told.iter().filter(|each| each.what == What::Found).map(|each| each.leaf);
        self.take_each(decided.collect(), taken);
    }

    /// Advances the time to `now` without a sample, and returns the runs that have a result by that.
    pub fn pass_time(&mut self, now: Time, told: &mut Vec<EpisodeUpdate>) {
        if self.due.is_some_and(|(at, _)| at <= now) {
            self.look_at_deadlines(now, told);
        }
    }

    /// Returns the run of the episode in the form of its monitor: `Some(None)` if it has no sample yet, `None`
    /// if the index does not hold it.
    pub fn run_of(&self, leaf: LeafId) -> Option<Option<IndexedRun>> {
        let row = *self.rows.get(&leaf)?;
        let (state, holds) = (self.states.get(row)?, *self.holds.get(row)?);
        if !state.has_seen_any(self.samples) {
            return Some(None);
        }
        let run = |start, first: i64| Run {
            start,
            last: self.previous,
            samples: length(first, self.samples.saturating_sub(1)),
            bindings: Bindings::new(),
            first_holds: true,
            last_holds: true,
            instants: Vec::new(),
        };
        let (before, contradicted, gap, found_at) = if state.before.at == self.newest {
            let Before { held, start, first, contradicted, gap, found_at, .. } = state.before;
            (held.then(|| run(start, first)), contradicted, gap, found_at)
        } else {
            // After a gap no sample shows where a run began.
            let apart = self.samples > 1 && self.newest - self.previous > *self.gaps.get(row)?;
            let is_low = !holds && state.has_seen_any(self.samples.saturating_sub(1));
            let contradicted = !apart && (state.contradicted || is_low);
            let found_at = state.open.filter(|open| open.newest < self.newest).map(|open| open.recognised_at);
            (holds.then(|| run(state.start, state.first)), contradicted, state.gap, found_at)
        };
        let holds = holds.then(Bindings::new);
        let newest = RunSample { at: self.newest, holds, joins: true, first_holds: true, last_holds: true };
        let run = ObjectRun { rank: 0, run: before, newest, found: None, contradicted, gap };
        Some(Some(IndexedRun { run, found_at, open_at: state.open.map(|open| open.recognised_at) }))
    }

    /// Removes the episode and returns the same as [`EpisodeIndex::run_of`].
    pub fn take(&mut self, leaf: LeafId) -> Option<Option<IndexedRun>> {
        let run = self.run_of(leaf)?;
        let row = self.rows.remove(&leaf)?;
        self.leaves.swap_remove(row);
        self.bands.swap_remove(row);
        self.holds.swap_remove(row);
        self.deadlines.swap_remove(row);
        self.gaps.swap_remove(row);
        self.states.swap_remove(row);
        if let Some(moved) = self.leaves.get(row) {
            self.rows.insert(*moved, row);
        }
        if self.due.is_some_and(|(_, due)| due == leaf) {
            self.look_at_deadlines(self.newest, &mut Vec::new());
        }
        Some(run)
    }

    /// Takes all episodes out, in order of their monitors.
    pub fn take_all(&mut self, taken: &mut Taken) {
        let leaves = self.rows.keys().copied().collect();
        self.due = None;
        self.take_each(leaves, taken);
    }
}
