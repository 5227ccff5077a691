//! Turbulence: a restless roll and, now and then, a burst that takes the wings off level for several seconds.
//!
//! Strength comes from the wind field (0 smooth .. 1 severe). Bursts arrive at random with a rate that grows with the
//! square of the strength: at 0.5 about thirty an hour, at 0.1 one an hour, in smooth air none.

use crate::random::{Random, Wander};
use apex_geo::geodesy::RAD_PER_DEG;
use libm::sin;
use std::f64::consts::PI;

const BURSTS_PER_HOUR_SEVERE: f64 = 120.0;
const BURST_S: (f64, f64) = (6.0, 20.0);
const BURST_ROLL_DEG: (f64, f64) = (4.0, 8.0);
const BURST_ROLL_DEG_PER_STRENGTH: f64 = 8.0;
const WANDER_ROLL_DEG: f64 = 1.2;
const WANDER_S: f64 = 2.5;

/// The turbulence that one vehicle feels.
#[derive(Clone, Debug)]
pub(crate) struct Turbulence {
    random: Random,
    wander: Wander,
    /// How much hazard is left until the next burst.
    until_burst: f64,
    burst: Option<Burst>,
    roll_rad: f64,
    /// Random vertical acceleration for each unit of strength, -1..1 mostly.
    pub(crate) bump: f64,
}

#[derive(Clone, Debug)]
struct Burst {
    age_s: f64,
    duration_s: f64,
    roll_rad: f64,
}

impl Turbulence {
    pub(crate) fn new(seed: u64) -> Turbulence {
        let mut random = Random::new(seed, 1);
        let until_burst = random.exponential();
        let wander = Wander::new(Random::new(seed, 2), WANDER_S);
        Turbulence { random, wander, until_burst, burst: None, roll_rad: 0.0, bump: 0.0 }
    }

    /// Bursts and restlessness draw from another seed from now on; a burst under way ends as it began.
    pub(crate) fn reseed(&mut self, seed: u64) {
        let Turbulence { random, wander, until_burst, .. } = Turbulence::new(seed);
        (self.random, self.wander, self.until_burst) = (random, wander, until_burst);
    }

    /// Roll that the air adds, `dt` later, at `strength`; and the rate at which it changed.
    pub(crate) fn after(&mut self, strength: f64, dt: f64) -> (f64, f64) {
        let strength = strength.clamp(0.0, 1.0);
        if strength == 0.0 && self.burst.is_none() {
            let rate = -self.roll_rad / dt;
            (self.roll_rad, self.bump) = (0.0, 0.0);
            return (0.0, rate);
        }
        self.bump = self.wander.after(dt);
        self.until_burst -= BURSTS_PER_HOUR_SEVERE * strength * strength * dt / 3600.0;
        if self.until_burst <= 0.0 {
            self.until_burst = self.random.exponential();
            self.burst = Some(self.new_burst(strength));
        }
        let mut roll_rad = self.bump * WANDER_ROLL_DEG * strength * RAD_PER_DEG;
        if let Some(burst) = &mut self.burst {
            burst.age_s += dt;
            let sine = sin(PI * (burst.age_s / burst.duration_s).min(1.0));
            roll_rad += burst.roll_rad * sine * sine;
            if burst.age_s >= burst.duration_s {
                self.burst = None;
            }
        }
        let rate = (roll_rad - self.roll_rad) / dt;
        self.roll_rad = roll_rad;
        (roll_rad, rate)
    }

    fn new_burst(&mut self, strength: f64) -> Burst {
        let size = self.random.between(BURST_ROLL_DEG.0, BURST_ROLL_DEG.1) + BURST_ROLL_DEG_PER_STRENGTH * strength;
        let sense = if self.random.uniform() < 0.5 { -1.0 } else { 1.0 };
        let duration_s = self.random.between(BURST_S.0, BURST_S.1);
        Burst { age_s: 0.0, duration_s, roll_rad: sense * size * RAD_PER_DEG }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Spans of at least `seconds_min` beyond three degrees in one hour.
    fn violations(strength: f64, seconds_min: u32) -> u32 {
        let mut turbulence = Turbulence::new(11);
        let (mut spans, mut length) = (0, 0);
        for _ in 0..3600 {
            let (roll_rad, _) = turbulence.after(strength, 1.0);
            length = if roll_rad.abs() > 3.0 * RAD_PER_DEG { length + 1 } else { 0 };
            spans += u32::from(length == seconds_min);
        }
        spans
    }

    #[test]
    fn smooth_air_is_level_and_rough_air_is_not() {
        assert_eq!(violations(0.0, 1), 0);
        let rough = violations(0.5, 4);
        assert!((10..60).contains(&rough), "{rough}");
        assert!(violations(0.1, 4) < 8);
    }
}
