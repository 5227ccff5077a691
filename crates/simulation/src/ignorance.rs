//! Realised next to expected cost of ignorance of a series of flights.

use serde::Serialize;

/// Realised next to expected ignorance over many flights.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct IgnoranceSummary {
    /// Flights compared.
    pub flights: usize,
    /// Fires that broke out in these flights.
    pub fires: u64,
    /// Number of these fires that were seen.
    pub seen: u64,
    /// Mean cost of the fires of a flight.
    pub realised: f64,
    /// Mean of the expected costs.
    pub expected: f64,
    /// Standard error of the mean difference.
    pub standard_error: f64,
}

impl IgnoranceSummary {
    /// Returns the summary of flights with these realised and expected costs; `None` for fewer than two.
    pub(crate) fn of(pairs: &[(f64, f64)], (fires, seen): (u64, u64)) -> Option<IgnoranceSummary> {
        let count = pairs.len() as f64;
        let mean = |of: fn(&(f64, f64)) -> f64| pairs.iter().map(of).sum::<f64>() / count;
        let (realised, expected) = (mean(|pair| pair.0), mean(|pair| pair.1));
        let deviation = |(real, wanted): &(f64, f64)| real - wanted - realised + expected;
        let squares: f64 = pairs.iter().map(|pair| deviation(pair) * deviation(pair)).sum();
        (pairs.len() > 1).then(|| IgnoranceSummary {
            flights: pairs.len(),
            fires,
            seen,
            realised,
            expected,
            standard_error: (squares / (count - 1.0) / count).sqrt(),
        })
    }

    /// Returns the difference of realised and expected in standard errors.
    pub fn deviation(&self) -> f64 {
        if self.standard_error > 0.0 { (self.realised - self.expected) / self.standard_error } else { 0.0 }
    }
}
