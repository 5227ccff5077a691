//! The largest sampling gaps within results (rules 8 and 22), for sessions that request them. A sample costs O(1) on average, and nothing
//! in other sessions.

use crate::state::monitors::monitor::Satisfaction;
use crate::state::recorded::Recorded;
use apex_model::because::Evidence;
use apex_model::event::StateVariable;
use apex_model::limits::SPACINGS_MAX;
use apex_model::time::{Duration, Time};
use std::collections::{BTreeMap, VecDeque};

/// The longest time without a sample within a run on which a result rests.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SamplingGap {
    /// Variable of the samples.
    pub variable: StateVariable,
    /// The sample before the gap.
    pub start: Time,
    /// The sample after it.
    pub end: Time,
}

impl SamplingGap {
    /// Returns the time from sample to sample.
    pub fn length(&self) -> Duration {
        self.end - self.start
    }
}

/// The spacings of the samples of all variables.
#[derive(Clone, Debug, Default)]
pub(super) struct Spacings {
    variables: BTreeMap<StateVariable, OfVariable>,
}

/// Spacings of one variable: the data for the largest spacing up to the newest sample, or up to the preceding one, which ends a run that
/// does not contain the newest sample.
#[derive(Clone, Debug)]
struct OfVariable {
    /// All spacings since this instant are known.
    known_from: Time,
    newest: Time,
    /// Between the last two samples.
    last: Option<(Time, Time)>,
    /// Of the earlier spacings, those longer than every later one; they become shorter and shorter.
    peaks: VecDeque<(Time, Time)>,
}

impl Spacings {
    /// Records that a sample of `variable` was recorded with this result.
    pub(super) fn note(&mut self, variable: &StateVariable, at: Time, recorded: Option<Recorded>) {
        match recorded {
            Some(Recorded::Appended) => match self.variables.get_mut(variable) {
                Some(known) => known.append(at),
                None => {
                    self.variables.insert(variable.clone(), OfVariable::from(at));
                }
            },
            // The sample divides a spacing that is no longer stored: the known spacings begin again.
            Some(Recorded::Inserted) => {
                if let Some(known) = self.variables.get_mut(variable) {
                    *known = OfVariable::from(known.newest);
                }
            }
            Some(Recorded::Replaced | Recorded::Repeated | Recorded::TooLate | Recorded::Missing) | None => {}
        }
    }

    /// Returns the largest gap of each run on which the result rests, if known; a run of one sample has none.
    pub(super) fn of(&self, result: &Satisfaction) -> Vec<SamplingGap> {
        let of_run = |evidence: &Evidence| {
            let Evidence::Run { variable, start, end, .. } = evidence else { return None };
            let (start, end) = self.variables.get(variable)?.largest(*start, *end)?;
            Some(SamplingGap { variable: variable.clone(), start, end })
        };
        result.evidence.iter().filter_map(of_run).collect()
    }
}

fn length((start, end): (Time, Time)) -> Duration {
    end - start
}

impl OfVariable {
    fn from(at: Time) -> OfVariable {
        OfVariable { known_from: at, newest: at, last: None, peaks: VecDeque::new() }
    }

    fn append(&mut self, at: Time) {
        if let Some(last) = self.last {
            while self.peaks.back().is_some_and(|peak| length(*peak) <= length(last)) {
                self.peaks.pop_back();
            }
            self.peaks.push_back(last);
            if self.peaks.len() > SPACINGS_MAX
                && let Some((_, end)) = self.peaks.pop_front()
            {
                self.known_from = end;
            }
        }
        self.last = Some((self.newest, at));
        self.newest = at;
    }

    /// Returns the largest spacing between `start` and `end`, the latest of equal ones; `None` if it is not known.
    fn largest(&self, start: Time, end: Time) -> Option<(Time, Time)> {
        let (before, _) = self.last?;
        if start < self.known_from || (end != self.newest && end != before) {
            return None;
        }
        let first = self.peaks.partition_point(|(from, _)| *from < start);
        let peak = self.peaks.get(first).copied();
        let last = self.last.filter(|(from, _)| end == self.newest && *from >= start);
        match (peak, last) {
            (Some(peak), Some(last)) if length(last) < length(peak) => Some(peak),
            (peak, last) => last.or(peak),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Compares the spacing with that of all samples.
        #[test]
        fn the_largest_spacing_is_that_of_all_samples(steps in prop::collection::vec(1i64..6, 1..40), from in 0usize..40) {
            let times: Vec<Time> = steps.iter().scan(0, |at, step| { *at += step; Some(Time(*at)) }).collect();
            let mut known = OfVariable::from(times[0]);
            for (number, at) in times.iter().enumerate().skip(1) {
                known.append(*at);
                for end in [number - 1, number] {
                    let start = from.min(end);
                    let pairs = times[start..=end].windows(2).map(|pair| (pair[0], pair[1]));
                    // The latest of the largest spacings.
                    let expected = pairs.max_by_key(|pair| length(*pair));
                    prop_assert_eq!(known.largest(times[start], times[end]), expected);
                }
            }
        }
    }

    #[test]
    fn what_is_not_known_is_not_reported() {
        let mut known = OfVariable::from(Time(10));
        assert_eq!(known.largest(Time(10), Time(10)), None);
        [12, 20, 21].into_iter().for_each(|at| known.append(Time(at)));
        assert_eq!(known.largest(Time(9), Time(21)), None, "before the first sample");
        assert_eq!(known.largest(Time(10), Time(12)), None, "ended two samples ago");
        assert_eq!(known.largest(Time(12), Time(20)), Some((Time(12), Time(20))));
        assert_eq!(known.largest(Time(21), Time(21)), None, "one sample");
    }
}
