//! Failures over time: stated times, and Poisson processes drawn by seed before the flight.
//!
//! Bound: O(spans) for each question; at most [`SPANS_MAX`] spans of one failure.

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

/// All failures of a flight, by their beginnings.
#[derive(Clone, Debug)]
pub(crate) struct Faults {
    spans: Vec<FaultSpan>,
    /// For each span, whether it was active at the last query.
    known: Vec<bool>,
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
        let known = vec![false; spans.len()];
        Faults { spans, known }
    }

    /// Returns the failures that hold now.
    pub(crate) fn active(&self, now: Time) -> impl Iterator<Item = &FaultSpan> {
        self.spans.iter().take_while(move |span| span.from <= now).filter(move |span| span.holds(now))
    }

    /// Returns the first failure of a kind that is active now and concerns this object, or concerns no particular object.
    pub(crate) fn find(&self, kind: FaultKind, of: &str, now: Time) -> Option<&FaultSpan> {
        self.active(now).find(|span| span.kind == kind && (span.of.is_empty() || span.of.eq_ignore_ascii_case(of)))
    }

    /// Returns the next beginning or end that [`Faults::changes`] has not reported; `now` if one is already due.
    pub(crate) fn next_change(&self, now: Time) -> Option<Time> {
        if self.spans.iter().zip(&self.known).any(|(span, known)| span.holds(now) != *known) {
            return Some(now);
        }
        let instants = self.spans.iter().flat_map(|span| [span.from, span.until]);
        instants.filter(|at| *at > now && *at < Time::END).min()
    }

    /// Failures that began or ended since the last call, in order.
    pub(crate) fn changes(&mut self, now: Time) -> Vec<FaultChange> {
        let mut changes = Vec::new();
        for (span, known) in self.spans.iter().zip(&mut self.known) {
            let holds = span.holds(now);
            if holds != *known {
                *known = holds;
                changes.push(FaultChange { span: span.clone(), begins: holds });
            }
        }
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
}
