//! Failures over time: stated times, and Poisson processes drawn by seed before the flight.
//!
//! Bound: O(active failures and those that began since the last query of changes) for each query; at most [`SPANS_MAX`] spans of one
//! failure.

use super::{FaultKind, FaultSpec};
use crate::instants;
use crate::random::Random;
use apex_model::time::{Duration, Time};
use libm::log;

/// Number of the random stream of the first failure; each further failure has the next number.
const STREAM: u64 = 1_000;
/// Upper limit on the length of a flight, up to which random failures are drawn.
const HORIZON_S: f64 = 30.0 * 86_400.0;
/// Maximum number of occurrences of one failure with a rate.
const SPANS_MAX: usize = 10_000;

/// One occurrence of a failure, from its beginning (included) to its end (excluded).
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FaultSpan {
    pub(crate) from: Time,
    pub(crate) until: Time,
    pub(crate) kind: FaultKind,
    /// Camera, modem or state variable, in small letters; empty where the kind has none.
    pub(crate) of: String,
    pub(crate) by: Option<f64>,
}

impl FaultSpan {
    pub(crate) fn holds(&self, now: Time) -> bool {
        self.from <= now && now < self.until
    }
}

/// All failures of a flight, by their beginnings. No query may be about an instant before the last [`Faults::changes`].
#[derive(Clone, Debug)]
pub(crate) struct Faults {
    spans: Vec<FaultSpan>,
    /// The number of spans that had begun at the last query of changes: those before it are over, or are in `open`.
    begun: usize,
    /// The spans that were active at the last query of changes, by ascending index.
    open: Vec<usize>,
}

/// A failure that has begun or is over.
pub(crate) struct FaultChange {
    pub(crate) span: FaultSpan,
    pub(crate) begins: bool,
}

impl Faults {
    pub(crate) fn new(specs: &[FaultSpec], seed: u64) -> Faults {
        let mut spans: Vec<FaultSpan> = specs
            .iter()
            .zip(0u64..)
            .flat_map(|(spec, index)| spans_of(spec, Random::new(seed, STREAM + index)))
            .collect();
        spans.sort_by_key(|span| (span.from, span.kind));
        Faults { spans, begun: 0, open: Vec::new() }
    }

    /// Returns all failures of the flight, by their beginnings.
    pub(crate) fn all(&self) -> impl Iterator<Item = &FaultSpan> {
        self.spans.iter()
    }

    /// Returns the failures that hold now, by their beginnings.
    pub(crate) fn active(&self, now: Time) -> impl Iterator<Item = &FaultSpan> {
        let open = self.open.iter().filter_map(|index| self.spans.get(*index));
        open.chain(self.since_changes(now)).filter(move |span| span.holds(now))
    }

    /// Returns the spans that began after the last query of changes, and not later than `now`.
    fn since_changes(&self, now: Time) -> impl Iterator<Item = &FaultSpan> {
        self.spans.iter().skip(self.begun).take_while(move |span| span.from <= now)
    }

    /// Returns the first failure of a kind that is active now and concerns this object, or concerns no particular object.
    pub(crate) fn find(&self, kind: FaultKind, of: &str, now: Time) -> Option<&FaultSpan> {
        self.active(now).find(|span| span.kind == kind && (span.of.is_empty() || span.of.eq_ignore_ascii_case(of)))
    }

    /// Returns the next beginning or end that [`Faults::changes`] has not reported; `now` if one is already due.
    pub(crate) fn next_change(&self, now: Time) -> Option<Time> {
        let mut open = self.open.iter().filter_map(|index| self.spans.get(*index));
        if open.any(|span| !span.holds(now)) || self.since_changes(now).any(|span| span.holds(now)) {
            return Some(now);
        }
        let ends = self.open.iter().filter_map(|index| self.spans.get(*index)).map(|span| span.until);
        let next = self.spans.iter().skip(self.begun).map(|span| span.from).find(|from| *from > now);
        ends.chain(next).filter(|at| *at < Time::END).min()
    }

    /// Returns the failures that began or ended since the last call, in order.
    pub(crate) fn changes(&mut self, now: Time) -> Vec<FaultChange> {
        let new = self.since_changes(now).count();
        let mut changes = Vec::new();
        let before = std::mem::take(&mut self.open);
        let known = before.len();
        for (place, index) in before.into_iter().chain(self.begun..self.begun + new).enumerate() {
            let Some(span) = self.spans.get(index) else { continue };
            let holds = span.holds(now);
            if holds != (place < known) {
                changes.push(FaultChange { span: span.clone(), begins: holds });
            }
            if holds {
                self.open.push(index);
            }
        }
        self.begun += new;
        changes
    }
}

fn spans_of(spec: &FaultSpec, mut random: Random) -> Vec<FaultSpan> {
    let span = |from_s: f64| {
        let from = instants::not_before(Time::from_seconds(from_s));
        let until = spec.for_s.map_or(Time::END, |for_s| from + instants::span(for_s).max(Duration(1_000_000)));
        let of = spec.of.clone().unwrap_or_default().to_lowercase();
        FaultSpan { from, until, kind: spec.fault, of, by: spec.by }
    };
    if let Some(at_s) = spec.at_s {
        return vec![span(at_s)];
    }
    let per_s = spec.rate_per_h.unwrap_or_default() / 3_600.0;
    let mut spans = Vec::new();
    let mut at_s = 0.0;
    while per_s > 0.0 && spans.len() < SPANS_MAX {
        // A failure begins only after the previous one has ended.
        at_s -= log(random.uniform()) / per_s;
        if at_s > HORIZON_S {
            break;
        }
        spans.push(span(at_s));
        let Some(for_s) = spec.for_s else { break };
        at_s += for_s;
    }
    spans
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spec(at_s: Option<f64>, rate_per_h: Option<f64>, for_s: Option<f64>) -> FaultSpec {
        FaultSpec { fault: FaultKind::Engine, of: None, by: None, at_s, rate_per_h, for_s }
    }

    #[test]
    fn a_stated_failure_begins_and_ends_once() {
        let mut faults = Faults::new(&[spec(Some(10.0), None, Some(5.0))], 1);
        let holds = |faults: &Faults, at_s: f64| faults.active(Time::from_seconds(at_s)).count();
        assert_eq!([9.9, 10.0, 14.9, 15.0].map(|at_s| holds(&faults, at_s)), [0, 1, 1, 0]);
        assert_eq!(faults.next_change(Time::ZERO), Some(Time::from_seconds(10.0)));
        let begins = |faults: &mut Faults, at_s: f64| {
            faults.changes(Time::from_seconds(at_s)).iter().map(|change| change.begins).collect::<Vec<_>>()
        };
        assert_eq!(begins(&mut faults, 10.0), [true]);
        assert!(begins(&mut faults, 11.0).is_empty());
        assert_eq!(begins(&mut faults, 15.0), [false]);
    }

    /// Times between the beginnings of failures without length are exponential: mean and deviation are 1 / rate.
    #[test]
    fn failures_by_rate_are_a_poisson_process() {
        let faults = Faults::new(&[spec(None, Some(10.0), Some(0.001))], 7);
        let begins: Vec<f64> = faults.spans.iter().map(|span| span.from.seconds()).collect();
        let gaps: Vec<f64> = begins.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let count = gaps.len() as f64;
        let mean = gaps.iter().sum::<f64>() / count;
        let sigma = libm::sqrt(gaps.iter().map(|gap| (gap - mean) * (gap - mean)).sum::<f64>() / count);
        assert!(count > 6_000.0 && (mean / 360.0 - 1.0).abs() < 0.04, "{count} gaps of {mean} s");
        assert!((sigma / mean - 1.0).abs() < 0.05, "{sigma} for {mean}");
        let other = Faults::new(&[spec(None, Some(10.0), Some(0.001))], 8);
        assert_ne!(faults.spans[0], other.spans[0]);
    }

    /// The naive twin: every query reads all spans.
    struct Naive {
        spans: Vec<FaultSpan>,
        known: Vec<bool>,
    }

    impl Naive {
        fn next_change(&self, now: Time) -> Option<Time> {
            if self.spans.iter().zip(&self.known).any(|(span, known)| span.holds(now) != *known) {
                return Some(now);
            }
            let instants = self.spans.iter().flat_map(|span| [span.from, span.until]);
            instants.filter(|at| *at > now && *at < Time::END).min()
        }

        fn changes(&mut self, now: Time) -> Vec<(FaultSpan, bool)> {
            let mut changes = Vec::new();
            for (span, known) in self.spans.iter().zip(&mut self.known) {
                if span.holds(now) != *known {
                    *known = span.holds(now);
                    changes.push((span.clone(), *known));
                }
            }
            changes
        }
    }

    /// Long and short failures, some without an end, are queried at irregular instants, sometimes without a query of changes in between.
    #[test]
    fn the_naive_twin_gives_the_same_answers() {
        let mut random = Random::new(11, 5);
        for seed in 0..8 {
            let specs = [
                spec(None, Some(30.0), Some(50.0)),
                spec(None, Some(5.0), Some(2_000.0)),
                spec(None, Some(100.0), Some(0.5)),
                spec(Some(400.0 * f64::from(u32::try_from(seed).unwrap())), None, None),
            ];
            let mut faults = Faults::new(&specs, seed);
            let mut naive = Naive { known: vec![false; faults.spans.len()], spans: faults.spans.clone() };
            let mut now_s = 0.0;
            for step in 0..600 {
                now_s += 90.0 * random.uniform() * random.uniform();
                let now = instants::not_before(Time::from_seconds(now_s));
                assert_eq!(faults.next_change(now), naive.next_change(now), "seed {seed} at {now}");
                let active: Vec<&FaultSpan> = naive.spans.iter().filter(|span| span.holds(now)).collect();
                assert_eq!(faults.active(now).collect::<Vec<_>>(), active, "seed {seed} at {now}");
                if step % 3 != 1 {
                    let changes = faults.changes(now).into_iter().map(|change| (change.span, change.begins));
                    assert_eq!(changes.collect::<Vec<_>>(), naive.changes(now), "seed {seed} at {now}");
                }
            }
        }
    }
}
