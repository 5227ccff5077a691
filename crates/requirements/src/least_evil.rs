//! Choice of the requirement to violate if no flight keeps all of them.

use serde::{Deserialize, Serialize};
use std::cmp::Ordering;

/// Harm that a violation may cause, worst first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Harm {
    /// Harm on the ground.
    PeopleOnGround,
    /// The aircraft.
    Aircraft,
    /// Other users of the airspace.
    Airspace,
    /// The mission.
    Mission,
}

/// One requirement that a choice violates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Breach {
    /// Harm that it may cause.
    pub harm: Harm,
    /// Depth of the violation times its duration: the integral of the negative margin over time, in units of the requirement's default
    /// margin times seconds, so that violations of one kind of harm are comparable.
    pub size: f64,
}

/// Compares two choices by their violations: lexicographically by harm, worst harm first, then by the sum of the sizes of that harm.
/// `Less` is the lesser evil; no violation is the least.
pub fn compare(a: &[Breach], b: &[Breach]) -> Ordering {
    let size = |breaches: &[Breach], harm: Harm| -> f64 {
        breaches.iter().filter(|breach| breach.harm == harm).map(|breach| breach.size.max(0.0)).sum()
    };
    [Harm::PeopleOnGround, Harm::Aircraft, Harm::Airspace, Harm::Mission]
        .into_iter()
        .map(|harm| size(a, harm).total_cmp(&size(b, harm)))
        .find(|order| order.is_ne())
        .unwrap_or(Ordering::Equal)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn breach(harm: Harm, size: f64) -> Breach {
        Breach { harm, size }
    }

    #[test]
    fn a_long_breach_of_airspace_is_less_than_a_lost_aircraft() {
        let airspace = [breach(Harm::Airspace, 1e6), breach(Harm::Mission, 1e6)];
        let aircraft = [breach(Harm::Aircraft, 1e-3)];
        assert_eq!(compare(&airspace, &aircraft), Ordering::Less);
        assert_eq!(compare(&[], &airspace), Ordering::Less);
        assert_eq!(compare(&[breach(Harm::Airspace, 2.0)], &[breach(Harm::Airspace, 3.0)]), Ordering::Less);
        let (deep, split) = ([breach(Harm::Airspace, 5.0)], [breach(Harm::Airspace, 2.0), breach(Harm::Airspace, 3.0)]);
        assert_eq!(compare(&deep, &split), Ordering::Equal);
    }
}
