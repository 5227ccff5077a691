//! Points of pairs (M&I)
//! What: keeps the instants at which intervals of an episode can begin and end, where any two samples of a run make an interval.
//! Runs: on every sample of an episode that is a part of an order of points.
//! Reads: the run of the newest sample.
//! Writes: the points of the episode.
//! Bound: O(1) per sample; O(log n) for the run of one of n points.
//! PDL: `:episode` in an `:in-order` with a `:delay`, or with `:any`.
//! Paper: Table 1, row 11.

use crate::monitoring::part::{ConditionFaults, PartContext, remember};
use crate::state::bindings::Bindings;
use crate::state::monitors::monitor::{NewestPoints, PairPoints, Run, RunSample, Satisfaction};
use apex_model::evidence_list::EvidenceList;
use apex_model::time::{Duration, Time};

fn point(at: Time) -> Satisfaction {
    Satisfaction { interval: (at, at), recognised_at: at, bindings: Bindings::new(), evidence: EvidenceList::default() }
}

impl PairPoints {
    /// Returns the points of an episode that has no samples yet, with its least and greatest duration.
    pub(crate) fn lasting(durations: (Duration, Duration)) -> PairPoints {
        PairPoints { durations, ..PairPoints::default() }
    }

    /// Replaces the newest sample. `run` is the run that contains it.
    pub(crate) fn replace_newest(&mut self, newest: &RunSample, run: Option<&Run>) {
        let used = self.newest.as_ref().is_some_and(|before| before.at == newest.at && before.used);
        self.newest = run.map(|run| {
            let goes_on = self.runs.last().is_some_and(|(start, _)| *start == run.start);
            let (least, most) = self.durations;
            let lasts = |begun: &Time| newest.at - *begun >= least && newest.at - *begun <= most;
            let earliest = self.begun.get(self.begun.partition_point(|begun| newest.at - *begun > most));
            let begun = goes_on && earliest.is_some_and(lasts) || newest.first_holds && lasts(&newest.at);
            let ends = newest.last_holds && begun;
            NewestPoints {
                run_start: run.start,
                at: newest.at,
                start: newest.first_holds.then(|| point(newest.at)),
                end: ends.then(|| point(newest.at)),
                used,
            }
        });
    }

    /// Adds the newest sample, of the instant `at`, to the past.
    pub(crate) fn settle(&mut self, at: Time, site: PartContext, troubles: &mut ConditionFaults) {
        self.settled_at = Some(at);
        let Some(newest) = self.newest.take() else { return };
        match self.runs.last_mut() {
            Some((start, last)) if *start == newest.run_start => *last = at,
            _ => {
                self.runs.push((newest.run_start, at));
                self.begun.clear();
            }
        }
        if let Some(start) = newest.start {
            let past = self.begun.partition_point(|begun| at - *begun > self.durations.1);
            self.begun.drain(..past);
            // Without a greatest duration, the first one permits every end that a later one permits.
            if self.begun.is_empty() || self.durations.1 < Duration::MAX {
                self.begun.push_back(at);
            }
            remember(&mut self.starts, start, site, troubles);
        }
        if let Some(end) = newest.end {
            self.held = true;
            if !newest.used {
                remember(&mut self.ends, end, site, troubles);
            }
        }
    }

    /// Returns true if a pair was found since results were reported, or ends with the newest sample.
    pub(crate) fn holds(&self) -> bool {
        self.held || self.newest.as_ref().is_some_and(|newest| newest.end.is_some())
    }

    /// Returns the newest end that belongs to no reported result.
    pub(crate) fn newest_end(&self) -> Option<&Satisfaction> {
        self.newest.as_ref().filter(|newest| !newest.used)?.end.as_ref()
    }

    /// Returns the first and the last known sample of the run that contains the instant of a point.
    pub(crate) fn run_of(&self, at: Time) -> (Time, Time) {
        if let Some(newest) = self.newest.as_ref().filter(|newest| newest.run_start <= at) {
            return (newest.run_start, newest.at);
        }
        let after = self.runs.partition_point(|(start, _)| *start <= at);
        after.checked_sub(1).and_then(|place| self.runs.get(place)).copied().unwrap_or((at, at))
    }

    /// Returns true if no later sample can belong to the run whose last known sample is `last`.
    pub(crate) fn is_over(&self, last: Time) -> bool {
        self.newest.as_ref().is_none_or(|newest| newest.run_start > last)
            && self.settled_at.is_some_and(|settled| settled > last)
    }

    /// Removes the runs before the first kept point. The last run is kept, because it may continue.
    pub(crate) fn drop_runs(&mut self) {
        let firsts = [self.starts.first(), self.ends.first()];
        let first = firsts.into_iter().flatten().map(|point| point.interval.0).min();
        let before = self.runs.partition_point(|(_, last)| first.is_none_or(|first| *last < first));
        self.runs.drain(..before.min(self.runs.len().saturating_sub(1)));
    }

    /// Takes the pairs known so far out. Only pairs that begin in the present run and end with a later sample are still to come.
    pub(crate) fn use_up(&mut self) {
        self.held = false;
        self.ends.clear();
        match &mut self.newest {
            Some(newest) => {
                newest.used = true;
                let present = newest.run_start;
                self.starts.retain(|start| start.interval.0 >= present);
            }
            None => self.starts.clear(),
        }
        self.drop_runs();
    }

    /// Returns the interval of a known pair.
    pub(crate) fn first_pair(&self) -> Option<(Time, Time)> {
        let (least, most) = self.durations;
        let mut ends = self.ends.iter().chain(self.newest_end()).map(|end| end.interval.0);
        ends.find_map(|end| {
            let run_start = self.run_of(end).0;
            let newest = self.newest.as_ref().and_then(|newest| newest.start.as_ref());
            let mut starts = self.starts.iter().chain(newest).map(|start| start.interval.0);
            let start = starts.find(|start| *start >= run_start && end - *start >= least && end - *start <= most);
            start.map(|start| (start, end))
        })
    }
}
