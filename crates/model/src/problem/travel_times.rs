//! Given travel times, for one departure or for several, with linear interpolation between them.
//!
//! Bound: O(1) for times that do not depend on the departure, O(log departures) else.

use serde::{Deserialize, Serialize};

/// A travel time that means that no path exists; finite, so that JSON can represent it. Every greater time means the same.
pub const UNREACHABLE_S: f64 = 1e15;

/// Travel times in seconds, in general asymmetric (wind). [`UNREACHABLE_S`] means that no path exists. Indices are those of the problem's
/// targets.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TravelTimes {
    /// From the start to each target.
    pub from_start_s: Vec<f64>,
    /// `between_s[from][to]`; the diagonal is the time to observe the same target again at once.
    pub between_s: Vec<Vec<f64>>,
    /// From each target to the base; may be empty if the problem requires no return.
    pub to_base_s: Vec<f64>,
    /// Times for later departures, by rising departure; empty if times do not depend on the departure. The times above are then for a
    /// departure at 0 or before. Between two departures times change linearly, after the last one they stay constant. A vehicle that
    /// departs later does not arrive earlier.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub later: Vec<LaterTimes>,
}

/// The times of [`TravelTimes`] for leaving at `depart_s`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LaterTimes {
    /// Departure, in seconds of the problem's time.
    pub depart_s: f64,
    /// From the start to each target.
    pub from_start_s: Vec<f64>,
    /// `between_s[from][to]`.
    pub between_s: Vec<Vec<f64>>,
    /// From each target to the base.
    pub to_base_s: Vec<f64>,
}

/// Two ends of a leg.
#[derive(Clone, Copy)]
enum LegEnds {
    Out(usize),
    Between(usize, usize),
    Home(usize),
}

fn one(times: &[f64], index: usize) -> f64 {
    times.get(index).copied().unwrap_or(UNREACHABLE_S)
}

fn pair(rows: &[Vec<f64>], from: usize, to: usize) -> f64 {
    rows.get(from).and_then(|row| row.get(to)).copied().unwrap_or(UNREACHABLE_S)
}

impl LaterTimes {
    fn leg_s(&self, leg: LegEnds) -> f64 {
        match leg {
            LegEnds::Out(to) => one(&self.from_start_s, to),
            LegEnds::Between(from, to) => pair(&self.between_s, from, to),
            LegEnds::Home(from) => one(&self.to_base_s, from),
        }
    }
}

impl TravelTimes {
    /// Removes all paths from the start and the targets to a target, and from it to the targets, at every departure. Its path to the base
    /// stays: no plan reaches it.
    pub fn shut(&mut self, target: usize) {
        fn shut(from_start_s: &mut [f64], between_s: &mut [Vec<f64>], target: usize) {
            from_start_s.get_mut(target).into_iter().for_each(|time_s| *time_s = UNREACHABLE_S);
            for (from, row) in between_s.iter_mut().enumerate() {
                let of_target = |(to, _): &(usize, &mut f64)| from == target || *to == target;
                row.iter_mut().enumerate().filter(of_target).for_each(|(_, time_s)| *time_s = UNREACHABLE_S);
            }
        }
        shut(&mut self.from_start_s, &mut self.between_s, target);
        self.later.iter_mut().for_each(|later| shut(&mut later.from_start_s, &mut later.between_s, target));
    }

    /// Returns true if times do not depend on the departure.
    pub fn is_constant(&self) -> bool {
        self.later.is_empty()
    }

    /// Returns the time from the start to target `to`, leaving at 0.
    pub fn start_to(&self, to: usize) -> f64 {
        one(&self.from_start_s, to)
    }

    /// Returns the time from target `from` to target `to`, leaving at 0.
    pub fn between(&self, from: usize, to: usize) -> f64 {
        pair(&self.between_s, from, to)
    }

    /// Returns the time from target `from` to the base, leaving at 0.
    pub fn to_base(&self, from: usize) -> f64 {
        one(&self.to_base_s, from)
    }

    /// Returns the time from the start to target `to`, leaving at `depart_s`.
    pub fn start_to_at(&self, to: usize, depart_s: f64) -> f64 {
        if self.later.is_empty() { self.start_to(to) } else { self.at(LegEnds::Out(to), depart_s) }
    }

    /// Returns the time from target `from` to target `to`, leaving at `depart_s`.
    pub fn between_at(&self, from: usize, to: usize, depart_s: f64) -> f64 {
        if self.later.is_empty() { self.between(from, to) } else { self.at(LegEnds::Between(from, to), depart_s) }
    }

    /// Returns the time from target `from` to the base, leaving at `depart_s`.
    pub fn to_base_at(&self, from: usize, depart_s: f64) -> f64 {
        if self.later.is_empty() { self.to_base(from) } else { self.at(LegEnds::Home(from), depart_s) }
    }

    /// Returns the time from target `from` to target `to` at the best departure.
    pub fn between_s_min(&self, from: usize, to: usize) -> f64 {
        self.least_of(LegEnds::Between(from, to))
    }

    /// Returns the time from the start to target `to` at the best departure.
    pub fn start_to_s_min(&self, to: usize) -> f64 {
        self.least_of(LegEnds::Out(to))
    }

    /// Returns the time from target `from` to the base at the best departure.
    pub fn to_base_s_min(&self, from: usize) -> f64 {
        self.least_of(LegEnds::Home(from))
    }

    /// Returns constant times that are a lower bound for every departure: between two departures, times lie between those of both.
    pub fn least(&self) -> TravelTimes {
        self.merged(|leg| self.least_of(leg))
    }

    /// Returns the mean times over departures from 0 to `until_s`; a leg without a path at some departure has no path.
    pub fn mean(&self, until_s: f64) -> TravelTimes {
        self.merged(|leg| self.mean_of(leg, until_s))
    }

    fn first(&self, leg: LegEnds) -> f64 {
        match leg {
            LegEnds::Out(to) => self.start_to(to),
            LegEnds::Between(from, to) => self.between(from, to),
            LegEnds::Home(from) => self.to_base(from),
        }
    }

    fn at(&self, leg: LegEnds, depart_s: f64) -> f64 {
        let after = self.later.partition_point(|later| later.depart_s <= depart_s);
        let before = after.checked_sub(1).and_then(|before| self.later.get(before));
        let (from_s, time_s) = before.map_or((0.0, self.first(leg)), |before| (before.depart_s, before.leg_s(leg)));
        match self.later.get(after) {
            Some(next) if depart_s > from_s => {
                let next_s = next.leg_s(leg);
                if time_s.max(next_s) >= UNREACHABLE_S {
                    return UNREACHABLE_S;
                }
                time_s + (next_s - time_s) * ((depart_s - from_s) / (next.depart_s - from_s))
            }
            _ => time_s,
        }
    }

    fn least_of(&self, leg: LegEnds) -> f64 {
        self.later.iter().fold(self.first(leg), |least_s, later| least_s.min(later.leg_s(leg)))
    }

    fn mean_of(&self, leg: LegEnds, until_s: f64) -> f64 {
        let (mut sum, mut from_s, mut time_s, mut most_s) = (0.0, 0.0, self.first(leg), self.first(leg));
        for later in &self.later {
            let end_s = later.depart_s.min(until_s);
            most_s = most_s.max(later.leg_s(leg));
            let next_s = self.at(leg, end_s);
            sum += 0.5 * (time_s + next_s) * (end_s - from_s).max(0.0);
            (from_s, time_s) = (end_s, next_s);
        }
        sum += time_s * (until_s - from_s).max(0.0);
        if most_s >= UNREACHABLE_S || until_s <= 0.0 { most_s } else { sum / until_s }
    }

    fn merged(&self, time_s: impl Fn(LegEnds) -> f64) -> TravelTimes {
        let row =
            |(from, row): (usize, &Vec<f64>)| (0..row.len()).map(|to| time_s(LegEnds::Between(from, to))).collect();
        TravelTimes {
            from_start_s: (0..self.from_start_s.len()).map(|to| time_s(LegEnds::Out(to))).collect(),
            between_s: self.between_s.iter().enumerate().map(row).collect(),
            to_base_s: (0..self.to_base_s.len()).map(|from| time_s(LegEnds::Home(from))).collect(),
            later: Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn times() -> TravelTimes {
        let later = |depart_s: f64, there_s: f64| LaterTimes {
            depart_s,
            from_start_s: vec![there_s],
            between_s: vec![vec![2.0 * there_s]],
            to_base_s: vec![UNREACHABLE_S],
        };
        TravelTimes {
            from_start_s: vec![100.0],
            between_s: vec![vec![200.0]],
            to_base_s: vec![50.0],
            later: vec![later(100.0, 60.0), later(200.0, 80.0)],
        }
    }

    #[test]
    fn straight_lines_lead_from_one_departure_to_the_next() {
        let times = times();
        let at = [-5.0, 0.0, 50.0, 100.0, 150.0, 200.0, 1e9].map(|depart_s| times.start_to_at(0, depart_s));
        assert_eq!(at, [100.0, 100.0, 80.0, 60.0, 70.0, 80.0, 80.0]);
        assert_eq!((times.between_at(0, 0, 50.0), times.between_s_min(0, 0)), (160.0, 120.0));
        assert_eq!((times.to_base_at(0, 0.0), times.to_base_at(0, 1.0)), (50.0, UNREACHABLE_S), "no way later");
        assert_eq!(times.between_at(0, 7, 50.0), UNREACHABLE_S);
    }

    #[test]
    fn what_is_least_and_what_is_the_mean() {
        let times = times();
        let least = times.least();
        assert_eq!((least.start_to(0), least.between(0, 0), least.to_base(0)), (60.0, 120.0, 50.0));
        assert!(least.is_constant() && least.least() == least);
        // 80 over the first hundred seconds, 70 over the second, 80 over the third.
        let mean = times.mean(300.0);
        assert!((mean.start_to(0) - 230.0 / 3.0).abs() < 1e-12);
        assert_eq!((mean.to_base(0), times.mean(50.0).start_to(0)), (UNREACHABLE_S, 90.0));
    }
}
