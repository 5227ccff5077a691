//! Turbulence: the roll from the air in addition to the commanded bank. Gusts are in `gusts`.
//!
//! The roll angle is the response of the attitude hold to white noise, `phi'' + 2 zeta omega phi' + omega^2 phi = noise`, scaled so that
//! its stationary deviation is `roll_deg_per_edr * EDR` of the vehicle file. A step is exact for every length: the state moves by the
//! transition matrix, and the step's noise has the covariance that a stationary state loses in the transition. So the statistics at the
//! ends of steps do not depend on the steps. Deviation and spectrum: MIL-F-8785C (roll gust), see `apex_vehicle::AttitudeHold`.

use crate::gusts::{GustScales, Gusts};
use crate::random::Random;
use apex_geo::geodesy::RAD_PER_DEG;
use apex_vehicle::AttitudeHold;
use libm::{cos, cosh, exp, sin, sinh, sqrt};

/// Streams of the seed.
const ROLL_STREAM: u64 = 1;
const GUST_STREAM: u64 = 2;
/// In smooth air, roll below this counts as gone.
const ROLL_RAD_MIN: f64 = 1e-6;

/// The turbulence acting on one vehicle.
#[derive(Clone, Debug)]
pub(crate) struct Turbulence {
    hold: AttitudeHold,
    random: Random,
    /// Gusts by Dryden's spectra.
    pub(crate) gusts: Gusts,
    /// Roll that the air has added.
    pub(crate) roll_rad: f64,
    /// Rate of this roll.
    pub(crate) roll_rate_rad_s: f64,
}

/// One exact step of the attitude hold: the transition matrix, and the triangular root of the noise covariance, for a process of standard
/// deviation one.
#[derive(Clone, Copy, Debug)]
struct AttitudeStep {
    transition: [[f64; 2]; 2],
    noise: [[f64; 2]; 2],
}

impl AttitudeStep {
    fn new(hold: &AttitudeHold, dt: f64) -> AttitudeStep {
        let (omega, zeta) = (hold.natural_frequency_rad_s, hold.damping_ratio);
        let decay = exp(-zeta * omega * dt);
        // cos and sin of the damped oscillation; the sine over its frequency.
        let (cosine, sine) = if zeta < 1.0 {
            let damped = omega * sqrt(1.0 - zeta * zeta);
            (cos(damped * dt), sin(damped * dt) / damped)
        } else if zeta > 1.0 {
            let spread = omega * sqrt(zeta * zeta - 1.0);
            (cosh(spread * dt), sinh(spread * dt) / spread)
        } else {
            (1.0, dt)
        };
        let transition = [
            [decay * (cosine + zeta * omega * sine), decay * sine],
            [-decay * omega * omega * sine, decay * (cosine - zeta * omega * sine)],
        ];
        let [[a, b], [c, d]] = transition;
        // The stationary covariance is diagonal: 1 and omega^2.
        let rate = omega * omega;
        let angle_angle = (1.0 - a * a - b * b * rate).max(0.0);
        let angle_rate = -a * c - b * d * rate;
        let rate_rate = (rate - c * c - d * d * rate).max(0.0);
        let first = sqrt(angle_angle);
        let second = if first > 0.0 { angle_rate / first } else { 0.0 };
        let noise = [[first, 0.0], [second, sqrt((rate_rate - second * second).max(0.0))]];
        AttitudeStep { transition, noise }
    }
}

impl Turbulence {
    /// Returns smooth air, for a vehicle that holds its attitude like `hold`.
    pub(crate) fn new(hold: AttitudeHold, seed: u64) -> Turbulence {
        let (random, gusts) = (Random::new(seed, ROLL_STREAM), Gusts::new(Random::new(seed, GUST_STREAM)));
        Turbulence { hold, random, gusts, roll_rad: 0.0, roll_rate_rad_s: 0.0 }
    }

    /// Draws roll and bumps from another seed from now on; the present roll stays.
    pub(crate) fn reseed(&mut self, seed: u64) {
        self.random = Random::new(seed, ROLL_STREAM);
        self.gusts.reseed(Random::new(seed, GUST_STREAM));
    }

    /// Stops all motion by turbulence, because the vehicle is on the ground.
    pub(crate) fn rest(&mut self) {
        (self.roll_rad, self.roll_rate_rad_s) = (0.0, 0.0);
        self.gusts.rest();
    }

    /// Flies `dt` seconds through air of turbulence `edr` (m^(2/3)/s), `height_m` above the ground at `true_airspeed`.
    pub(crate) fn fly(&mut self, (edr, height_m): (f64, f64), true_airspeed: f64, dt: f64) {
        self.advance(edr, dt);
        if edr > 0.0 {
            self.gusts.advance(&GustScales::at(height_m, edr), true_airspeed, dt);
        } else {
            self.gusts.rest();
        }
    }

    /// Moves roll and roll rate `dt` seconds on in air of turbulence `edr` (m^(2/3)/s).
    fn advance(&mut self, edr: f64, dt: f64) {
        let sigma_rad = self.hold.roll_deg_per_edr * edr * RAD_PER_DEG;
        let smooth = edr <= 0.0;
        if smooth && self.roll_rad.abs() < ROLL_RAD_MIN && self.roll_rate_rad_s.abs() < ROLL_RAD_MIN {
            return self.rest();
        }
        let AttitudeStep { transition: [[a, b], [c, d]], noise: [[first, _], [second, third]] } =
            AttitudeStep::new(&self.hold, dt);
        let (one, other) = if smooth { (0.0, 0.0) } else { (self.random.normal(), self.random.normal()) };
        let (roll, rate) = (self.roll_rad, self.roll_rate_rad_s);
        self.roll_rad = a * roll + b * rate + sigma_rad * first * one;
        self.roll_rate_rad_s = c * roll + d * rate + sigma_rad * (second * one + third * other);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hold(roll_deg_per_edr: f64, damping_ratio: f64) -> AttitudeHold {
        AttitudeHold { roll_deg_per_edr, natural_frequency_rad_s: 1.0, damping_ratio }
    }

    /// Statistics of a long flight in constant turbulence.
    struct Seen {
        sigma_deg: f64,
        rate_deg_s: f64,
        within_3_deg: f64,
        episodes_per_minute: f64,
    }

    fn fly(hold: AttitudeHold, edr: f64, dt: f64, hours: f64, seed: u64) -> Seen {
        let mut air = Turbulence::new(hold, seed);
        let steps = (hours * 3_600.0 / dt) as usize;
        let (mut squares, mut rates, mut within, mut episodes, mut outside) = (0.0, 0.0, 0_usize, 0_usize, false);
        for _ in 0..steps {
            air.advance(edr, dt);
            let (roll_deg, rate_deg_s) = (air.roll_rad / RAD_PER_DEG, air.roll_rate_rad_s / RAD_PER_DEG);
            squares += roll_deg * roll_deg;
            rates += rate_deg_s * rate_deg_s;
            let beyond = roll_deg.abs() > 3.0;
            within += usize::from(!beyond);
            episodes += usize::from(beyond && !outside);
            outside = beyond;
        }
        let count = steps as f64;
        Seen {
            sigma_deg: sqrt(squares / count),
            rate_deg_s: sqrt(rates / count),
            within_3_deg: within as f64 / count,
            episodes_per_minute: episodes as f64 / (hours * 60.0),
        }
    }

    /// Shares of time within 3 deg from `erf(3 / (sqrt 2 sigma))`, to three digits.
    const WITHIN_3_DEG: [(f64, [f64; 6]); 4] = [
        (4.4, [1.000, 1.000, 1.000, 0.999, 0.977, 0.870]),
        (7.5, [1.000, 1.000, 0.992, 0.954, 0.818, 0.626]),
        (10.0, [1.000, 0.997, 0.954, 0.866, 0.683, 0.495]),
        (15.0, [1.000, 0.954, 0.818, 0.683, 0.495, 0.343]),
    ];

    #[test]
    fn the_share_of_level_wings_follows_from_the_edr() {
        for (per_edr, shares) in WITHIN_3_DEG {
            for (edr, share) in [0.05, 0.10, 0.15, 0.20, 0.30, 0.45].into_iter().zip(shares) {
                let seen = fly(hold(per_edr, 0.7), edr, 0.5, 20.0, 5);
                assert!((seen.sigma_deg / (per_edr * edr) - 1.0).abs() < 0.02, "{per_edr} {edr}: {}", seen.sigma_deg);
                assert!((seen.within_3_deg - share).abs() < 0.012, "{per_edr} {edr}: {}", seen.within_3_deg);
            }
        }
    }

    #[test]
    fn the_length_of_a_step_does_not_change_the_statistics() {
        for damping_ratio in [0.3, 0.7, 1.0, 1.6] {
            for dt in [0.2, 0.5, 1.0, 5.0] {
                let seen = fly(hold(10.0, damping_ratio), 0.2, dt, 60.0, 11);
                assert!((seen.sigma_deg - 2.0).abs() < 0.06, "{damping_ratio} {dt}: {}", seen.sigma_deg);
                assert!((seen.rate_deg_s - 2.0).abs() < 0.06, "{damping_ratio} {dt}: {}", seen.rate_deg_s);
                assert!((seen.within_3_deg - 0.866).abs() < 0.015, "{damping_ratio} {dt}: {}", seen.within_3_deg);
            }
        }
    }

    /// Rice's formula for a normal process: `omega / pi exp(-limit^2 / (2 sigma^2))` begin each second. Samples 0.2 s apart miss
    /// the shortest.
    #[test]
    fn spans_beyond_the_limit_are_as_frequent_as_theory_says() {
        let fine = fly(hold(10.0, 0.7), 0.2, 0.02, 20.0, 3).episodes_per_minute;
        let theory = 60.0 / std::f64::consts::PI * exp(-9.0 / 8.0);
        assert!((fine / theory - 1.0).abs() < 0.08, "{fine} for {theory}");
        let sampled = fly(hold(10.0, 0.7), 0.2, 0.2, 40.0, 3).episodes_per_minute;
        assert!((4.9..theory).contains(&sampled), "{sampled}");
    }

    #[test]
    fn smooth_air_is_level_and_the_roll_of_rough_air_dies_out_in_it() {
        let mut air = Turbulence::new(hold(10.0, 0.7), 2);
        air.advance(0.0, 1.0);
        assert_eq!((air.roll_rad, air.roll_rate_rad_s, air.gusts.bump_m_s2), (0.0, 0.0, 0.0));
        (0..100).for_each(|_| air.advance(0.4, 0.2));
        let rough = air.roll_rad;
        air.advance(0.0, 0.01);
        assert!((air.roll_rad - rough).abs() < 0.01 && rough != 0.0, "no jump: {rough}");
        (0..60).for_each(|_| air.advance(0.0, 1.0));
        assert_eq!((air.roll_rad, air.roll_rate_rad_s), (0.0, 0.0));
    }
}
