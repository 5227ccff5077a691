//! Fires that break out at structures, by Poisson processes with the mission's rates, drawn by seed before the flight; and looks that
//! detect them.
//!
//! A look begins with a picture of the structure and lasts while the camera points there. In clear air each fire that burns during a look
//! is detected with the stated probability; this is decided once for each look and fire. Bound: O(fires) for each step of a look.

use super::{BurnableSite, IgnitionSpec};
use crate::random::Random;
use apex_geo::fire::FireSpread;
use apex_model::problem::Position;
use libm::log;

const STREAM: u64 = 2_000;
const STREAM_OF_LOOKS: u64 = 5_000;
/// Fires after this time are not drawn: no flight is longer.
const HORIZON_S: f64 = 5.0 * 86_400.0;
/// Maximum number of fires of one structure.
const FIRES_MAX: usize = 10_000;

/// A fire.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fire {
    pub(crate) site: usize,
    /// Instant at which the fire broke out, in mission time; negative if before the mission.
    pub(crate) broke_out_s: f64,
    spread: FireSpread,
    seen: bool,
}

impl Fire {
    /// Returns the fire's size at an instant after it broke out.
    pub(crate) fn area_m2(&self, now_s: f64) -> f64 {
        self.spread.area_m2(now_s - self.broke_out_s)
    }
}

/// A look that continues.
#[derive(Clone, Debug)]
struct Look {
    camera: usize,
    site: usize,
    /// Fires for which detection in this look is already decided.
    judged: Vec<usize>,
}

/// All fires of a flight.
#[derive(Clone, Debug)]
pub(crate) struct Ignitions {
    spec: IgnitionSpec,
    pub(crate) sites: Vec<BurnableSite>,
    /// By the instants at which they broke out.
    fires: Vec<Fire>,
    /// Fires that have been reported as broken out.
    reported: usize,
    looks: Vec<Look>,
    random: Random,
}

impl Ignitions {
    /// Draws the fires. `wind_mps` is the open wind at a place and time.
    pub(crate) fn new(
        spec: IgnitionSpec,
        sites: Vec<BurnableSite>,
        seed: u64,
        wind_mps: impl Fn(Position, f64) -> f64,
    ) -> Ignitions {
        let mut fires = Vec::new();
        for (site, index) in sites.iter().zip(0usize..) {
            let random = Random::new(seed, STREAM + index as u64);
            let begins = instants(site, random).into_iter();
            fires.extend(begins.map(|broke_out_s| Fire {
                site: index,
                broke_out_s,
                spread: FireSpread::in_wind(wind_mps(site.position, broke_out_s.max(0.0))),
                seen: false,
            }));
        }
        fires.sort_by(|a, b| a.broke_out_s.total_cmp(&b.broke_out_s));
        let random = Random::new(seed, STREAM_OF_LOOKS);
        Ignitions { spec, sites, fires, reported: 0, looks: Vec::new(), random }
    }

    /// Returns the instant at which the next fire breaks out.
    pub(crate) fn next_s(&self) -> Option<f64> {
        self.fires.get(self.reported).map(|fire| fire.broke_out_s)
    }

    /// Returns the fires that have broken out since the last call.
    pub(crate) fn broken_out(&mut self, now_s: f64) -> Vec<Fire> {
        let new: Vec<Fire> =
            self.fires.iter().skip(self.reported).take_while(|fire| fire.broke_out_s <= now_s).copied().collect();
        self.reported += new.len();
        new
    }

    /// Returns the structure at a place.
    pub(crate) fn site_at(&self, place: Position) -> Option<usize> {
        const NEAR_M: f64 = 25.0;
        self.sites.iter().position(|site| crate::path::bearing(site.position, place).1 <= NEAR_M)
    }

    /// Begins a camera's look with a picture that shows the structure; returns true if the look reports a fire where there is none.
    pub(crate) fn begin_look(&mut self, camera: usize, site: usize, now_s: f64) -> bool {
        self.end_looks(|known| known == camera);
        self.looks.push(Look { camera, site, judged: Vec::new() });
        let burns = self.fires.iter().any(|fire| fire.site == site && fire.broke_out_s <= now_s && !fire.seen);
        self.spec.false_alarm > 0.0 && !burns && self.random.uniform() < self.spec.false_alarm
    }

    /// Ends the looks of the cameras that `is_over` names.
    pub(crate) fn end_looks(&mut self, is_over: impl Fn(usize) -> bool) {
        self.looks.retain(|look| !is_over(look.camera));
    }

    /// Returns the fires that are detected now for the first time.
    pub(crate) fn sighted(&mut self, now_s: f64) -> Vec<Fire> {
        let Ignitions { spec, fires, looks, random, .. } = self;
        let mut seen = Vec::new();
        for look in looks.iter_mut() {
            for (index, fire) in fires.iter_mut().enumerate() {
                if fire.broke_out_s > now_s {
                    break;
                }
                let new = fire.site == look.site && !fire.seen && !look.judged.contains(&index);
                if !new || fire.area_m2(now_s) < spec.seen_from_m2 {
                    continue;
                }
                look.judged.push(index);
                if spec.detection >= 1.0 || random.uniform() < spec.detection {
                    fire.seen = true;
                    seen.push(*fire);
                }
            }
        }
        seen
    }
}

/// Returns the instants of a Poisson process with a changing rate: exponential steps of the integrated rate, piece by piece.
fn instants(site: &BurnableSite, mut random: Random) -> Vec<f64> {
    let steps = &site.rate.steps;
    let mut found = Vec::new();
    let mut left = -log(random.uniform());
    for (index, (time_s, events_per_s)) in steps.iter().enumerate() {
        // The first rate also holds before its time.
        let mut at_s = if index == 0 { -site.initial_age_s } else { time_s.max(-site.initial_age_s) };
        let end_s = steps.get(index + 1).map_or(HORIZON_S, |(next_s, _)| next_s.min(HORIZON_S));
        while found.len() < FIRES_MAX && *events_per_s > 0.0 && at_s < end_s {
            let step_s = left / events_per_s;
            if at_s + step_s >= end_s {
                left -= (end_s - at_s) * events_per_s;
                break;
            }
            at_s += step_s;
            found.push(at_s);
            left = -log(random.uniform());
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use apex_model::problem::EventRate;

    fn site(steps: &[(f64, f64)]) -> BurnableSite {
        BurnableSite {
            name: "barn".to_owned(),
            position: Position { latitude_deg: 40.0, longitude_deg: -100.0 },
            rate: EventRate { steps: steps.to_vec() },
            initial_age_s: 600.0,
        }
    }

    fn fires(detection: f64, seed: u64) -> Ignitions {
        let spec = IgnitionSpec { detection, seen_from_m2: 0.0, false_alarm: 0.0 };
        Ignitions::new(spec, vec![site(&[(0.0, 0.001)])], seed, |_, _| 5.0)
    }

    /// The number of fires has the mean and variance of the integrated rate, for the 600 s before the mission and for each piece of the
    /// rate.
    #[test]
    fn fires_break_out_with_the_rates_of_the_mission() {
        let changing = site(&[(0.0, 0.002), (1_000.0, 0.0), (2_000.0, 0.01)]);
        let count = |seed: u64, from_s: f64, until_s: f64| {
            let found = instants(&changing, Random::new(seed, STREAM));
            found.iter().filter(|at_s| (from_s..until_s).contains(*at_s)).count() as f64
        };
        for (from_s, until_s, mean) in [(-600.0, 1_000.0, 3.2), (1_000.0, 2_000.0, 0.0), (2_000.0, 2_500.0, 5.0)] {
            let counts: Vec<f64> = (0..4_000).map(|seed| count(seed, from_s, until_s)).collect();
            let average = counts.iter().sum::<f64>() / 4_000.0;
            let variance = counts.iter().map(|count| (count - average) * (count - average)).sum::<f64>() / 4_000.0;
            assert!((average - mean).abs() < 0.12, "{average} for {mean}");
            assert!((variance - mean).abs() < 0.3, "variance {variance} for {mean}");
        }
    }

    /// A look every half hour sees with probability d: the expected latency is T (1/d - 1/2).
    #[test]
    fn the_latency_follows_from_the_probability_of_detection() {
        let (period_s, detection) = (1_800.0, 0.8);
        let (mut latency_s, mut count) = (0.0, 0.0);
        for seed in 0..400 {
            let mut fires = fires(detection, seed);
            let mut unseen: Vec<f64> = Vec::new();
            for look in 1..=40 {
                let now_s = f64::from(look) * period_s;
                unseen.extend(fires.broken_out(now_s).iter().map(|fire| fire.broke_out_s));
                let before =
                    fires.fires.iter().filter(|fire| fire.seen).map(|fire| fire.broke_out_s).collect::<Vec<_>>();
                fires.begin_look(0, 0, now_s);
                fires.sighted(now_s);
                for fire in fires.fires.iter().filter(|fire| fire.seen && !before.contains(&fire.broke_out_s)) {
                    if fire.broke_out_s >= 0.0 && fire.broke_out_s < 30.0 * period_s {
                        (latency_s, count) = (latency_s + now_s - fire.broke_out_s, count + 1.0);
                    }
                }
            }
        }
        let expected_s = period_s * (1.0 / detection - 0.5);
        let mean_s = latency_s / count;
        assert!((mean_s / expected_s - 1.0).abs() < 0.02, "{mean_s} for {expected_s} ({count} fires)");
    }

    #[test]
    fn small_fires_hide_and_others_are_seen_once_while_the_look_lasts() {
        let mut fires = fires(1.0, 3);
        let now_s = fires.fires[0].broke_out_s.max(0.0) + 10.0;
        assert!(fires.sighted(now_s).is_empty(), "no look");
        fires.spec.seen_from_m2 = 1e9;
        fires.begin_look(0, 0, now_s);
        assert!(fires.sighted(now_s).is_empty());
        fires.spec.seen_from_m2 = 0.0;
        assert_eq!(fires.sighted(now_s).first().map(|fire| fire.site), Some(0));
        assert!(fires.sighted(now_s).is_empty(), "once");
    }
}
