//! Gusts of turbulent air: Dryden's spectra of MIL-F-8785C (3.7.1 and 3.7.2), by height above the ground.
//!
//! There are three components, each made from white noise by a filter: along the flight `sigma sqrt(2 L / V) / (1 + s L / V)`, across and
//! upwards `sigma sqrt(L / V) (1 + sqrt(3) s L / V) / (1 + s L / V)^2`. A step of the filters is exact for every length: the state moves
//! by the transition matrix, and the step's noise has the covariance that a stationary state loses in the transition.
//!
//! Scales: above 2,000 ft they are 1,750 ft for all components; below 1,000 ft the upward one is the height, and the level ones are `h /
//! (0.177 + 0.000823 h)^1.2` (feet); between these heights they are linear. The eddy dissipation rate of the layer sets the upward
//! deviation, `sigma = EDR L^(1/3) / 0.894`; below 1,000 ft the deviation of the level components is larger by the factor `1 / (0.177 +
//! 0.000823 h)^0.4`.
//!
//! Roll from turbulence is in `turbulence`. Gusts do not move the flight path: the autopilot's corrections are part of the roll stated in
//! vehicle files.

use crate::random::Random;
use libm::{cbrt, exp, pow, sqrt};

const FOOT_M: f64 = 0.3048;
/// Least height of the low-altitude model, ft.
const LOWEST_FT: f64 = 10.0;
/// Heights between which the models are blended, ft.
const LOW_FT: f64 = 1_000.0;
const HIGH_FT: f64 = 2_000.0;
/// Scale above [`HIGH_FT`], ft.
const SCALE_FT: f64 = 1_750.0;
/// `EDR = SHARE sigma L^(-1/3)`.
const EDR_SHARE: f64 = 0.894;
/// Least airspeed at which gusts are passed, because they also drift over a hovering vehicle.
const AIRSPEED_M_S_MIN: f64 = 3.0;
/// The aircraft follows a vertical gust with this lag (simulation assumption), in steps of at most this length.
const HEAVE_S: f64 = 1.0;
const HEAVE_STEP_S: f64 = 0.5;

/// Scale (m) and deviation (m/s) of the components along, across and upwards.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct GustScales {
    pub(crate) scale_m: [f64; 3],
    pub(crate) sigma_m_s: [f64; 3],
}

impl GustScales {
    /// Returns the scales `height_m` above the ground in turbulence of `edr` (m^(2/3)/s).
    pub(crate) fn at(height_m: f64, edr: f64) -> GustScales {
        let height_ft = height_m / FOOT_M;
        if height_ft <= LOW_FT {
            return GustScales::low(height_ft.max(LOWEST_FT), edr);
        }
        let high = GustScales::high(edr);
        if height_ft >= HIGH_FT {
            return high;
        }
        let (low, share) = (GustScales::low(LOW_FT, edr), (height_ft - LOW_FT) / (HIGH_FT - LOW_FT));
        let mix = |a: [f64; 3], b: [f64; 3]| {
            let [[a, b, c], [d, e, f]] = [a, b];
            [a + share * (d - a), b + share * (e - b), c + share * (f - c)]
        };
        GustScales { scale_m: mix(low.scale_m, high.scale_m), sigma_m_s: mix(low.sigma_m_s, high.sigma_m_s) }
    }

    fn low(height_ft: f64, edr: f64) -> GustScales {
        let shape = 0.177 + 0.000_823 * height_ft;
        let (level_m, up_m) = (FOOT_M * height_ft / pow(shape, 1.2), FOOT_M * height_ft);
        let up = edr * cbrt(up_m) / EDR_SHARE;
        let level = up / pow(shape, 0.4);
        GustScales { scale_m: [level_m, level_m, up_m], sigma_m_s: [level, level, up] }
    }

    fn high(edr: f64) -> GustScales {
        let scale_m = FOOT_M * SCALE_FT;
        GustScales { scale_m: [scale_m; 3], sigma_m_s: [edr * cbrt(scale_m) / EDR_SHARE; 3] }
    }
}

/// The second-order filter for noise of deviation one: a first-order process and its lagged copy.
#[derive(Clone, Copy, Debug, Default)]
struct Lateral {
    first: f64,
    second: f64,
}

/// Factors of one step of a [`Lateral`]: the same for all steps of a flight of some length.
struct LateralStep {
    /// The step in units of `L / V`.
    angle: f64,
    kept: f64,
    root: f64,
    across: f64,
    rest: f64,
}

impl LateralStep {
    /// Returns the factors of a step of `angle`, in units of `L / V`.
    fn new(angle: f64) -> LateralStep {
        let kept = exp(-angle);
        // The stationary covariance is [[1, 1/2], [1/2, 1/2]].
        let square = kept * kept;
        let first_first = (1.0 - square).max(0.0);
        let first_second = 0.5 - square * (angle + 0.5);
        let second_second = (0.5 - square * (angle * angle + angle + 0.5)).max(0.0);
        let root = sqrt(first_first);
        let across = if root > 0.0 { first_second / root } else { 0.0 };
        LateralStep { angle, kept, root, across, rest: sqrt((second_second - across * across).max(0.0)) }
    }
}

impl Lateral {
    /// Advances the filter by a step, with two independent normal numbers.
    fn step(&mut self, step: &LateralStep, (one, other): (f64, f64)) {
        let LateralStep { angle, kept, root, across, rest } = *step;
        let (first, second) = (kept * self.first, kept * (angle * self.first + self.second));
        self.first = first + root * one;
        self.second = second + across * one + rest * other;
    }

    /// Returns the gust for a deviation of one.
    fn value(&self) -> f64 {
        let root = sqrt(3.0);
        (root * self.first + (1.0 - root) * self.second) / sqrt(2.0)
    }
}

/// The gusts acting on one vehicle.
#[derive(Clone, Debug)]
pub(crate) struct Gusts {
    random: Random,
    along: f64,
    across: Lateral,
    up: Lateral,
    heave_m_s: f64,
    /// Components along, across (to the right) and upwards, m/s.
    velocity_m_s: [f64; 3],
    /// Upward acceleration of the vehicle, m/s2.
    pub(crate) bump_m_s2: f64,
}

impl Gusts {
    /// Returns gusts of zero strength.
    pub(crate) fn new(random: Random) -> Gusts {
        let (across, up) = (Lateral::default(), Lateral::default());
        Gusts { random, along: 0.0, across, up, heave_m_s: 0.0, velocity_m_s: [0.0; 3], bump_m_s2: 0.0 }
    }

    /// Sets the gusts to zero: on the ground, and in smooth air.
    pub(crate) fn rest(&mut self) {
        (self.along, self.across, self.up) = (0.0, Lateral::default(), Lateral::default());
        (self.heave_m_s, self.bump_m_s2, self.velocity_m_s) = (0.0, 0.0, [0.0; 3]);
    }

    /// Returns the component along the flight, m/s.
    pub(crate) fn along_m_s(&self) -> f64 {
        let [along, ..] = self.velocity_m_s;
        along
    }

    /// Returns the component across the flight, to the right, m/s.
    pub(crate) fn across_m_s(&self) -> f64 {
        let [_, across, _] = self.velocity_m_s;
        across
    }

    /// Returns the component upwards, m/s.
    pub(crate) fn up_m_s(&self) -> f64 {
        let [.., up] = self.velocity_m_s;
        up
    }

    /// Draws from another stream from now on.
    pub(crate) fn reseed(&mut self, random: Random) {
        self.random = random;
    }

    /// Flies `dt` seconds through the air at `true_airspeed`.
    pub(crate) fn advance(&mut self, scales: &GustScales, true_airspeed: f64, dt: f64) {
        let steps = libm::ceil(dt / HEAVE_STEP_S).max(1.0);
        let step_s = dt / steps;
        let speed = true_airspeed.max(AIRSPEED_M_S_MIN);
        let angle = |scale_m: f64| step_s * speed / scale_m;
        let [along, across, up] = scales.scale_m.map(angle);
        let [sigma_along, sigma_across, sigma_up] = scales.sigma_m_s;
        let (kept, fades) = (exp(-along), exp(-step_s / HEAVE_S));
        let root = sqrt(1.0 - kept * kept);
        let (across, up) = (LateralStep::new(across), LateralStep::new(up));
        for _ in 0..steps as u32 {
            self.along = kept * self.along + root * self.random.normal();
            // The process along the flight needs one number; recorded flights have drawn two.
            self.random.skip_normal();
            let mut pair = || (self.random.normal(), self.random.normal());
            self.across.step(&across, pair());
            self.up.step(&up, pair());
            let gust = sigma_up * self.up.value();
            let before = self.heave_m_s;
            self.heave_m_s = gust + (before - gust) * fades;
            self.bump_m_s2 = (self.heave_m_s - before) / step_s;
        }
        self.velocity_m_s = [sigma_along * self.along, sigma_across * self.across.value(), sigma_up * self.up.value()];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// MIL-F-8785C: 1,750 ft everywhere above 2,000 ft; at 1,000 ft all scales are 1,000 ft.
    #[test]
    fn scales_follow_the_height() {
        let high = GustScales::at(3_000.0, 0.2);
        assert!(high.scale_m.iter().all(|scale_m| (scale_m - 533.4).abs() < 1e-9));
        // 9.07 m/s for each unit of EDR at this scale.
        assert!(high.sigma_m_s.iter().all(|sigma| (sigma - 0.2 * 9.07).abs() < 0.005), "{:?}", high.sigma_m_s);
        let thousand = GustScales::at(304.8, 0.2);
        assert!(thousand.scale_m.iter().all(|scale_m| (scale_m - 304.8).abs() < 0.1), "{:?}", thousand.scale_m);
        // 200 ft: 0.177 + 0.1646 = 0.3416; 200 / 0.3416^1.2 = 725.9 ft level, 200 ft upwards, level gusts 1.537 times as strong.
        let low = GustScales::at(200.0 * FOOT_M, 0.2);
        assert!((low.scale_m[0] / FOOT_M - 725.9).abs() < 0.5 && (low.scale_m[2] / FOOT_M - 200.0).abs() < 1e-9);
        assert!((low.sigma_m_s[0] / low.sigma_m_s[2] - 1.537).abs() < 0.001);
        let middle = GustScales::at(1_500.0 * FOOT_M, 0.2);
        assert!((middle.scale_m[0] / FOOT_M - 1_375.0).abs() < 0.5, "halfway: {:?}", middle.scale_m);
    }

    fn flown(dt: f64, hours: f64, seed: u64, height_m: f64) -> (GustScales, Vec<[f64; 3]>) {
        let scales = GustScales::at(height_m, 0.3);
        let mut gusts = Gusts::new(Random::new(seed, 5));
        let count = (hours * 3_600.0 / dt) as usize;
        let seen = (0..count).map(|_| {
            gusts.advance(&scales, 95.0, dt);
            gusts.velocity_m_s
        });
        (scales, seen.collect())
    }

    #[test]
    fn deviations_are_those_of_the_layer_whatever_the_step() {
        for (dt, height_m) in [(0.2, 3_000.0), (0.5, 100.0), (3.0, 3_000.0), (10.0, 3_000.0)] {
            let (scales, seen) = flown(dt, 40.0, 4, height_m);
            for (axis, sigma) in scales.sigma_m_s.into_iter().enumerate() {
                let squares: f64 = seen.iter().map(|gust| gust[axis] * gust[axis]).sum();
                let found = sqrt(squares / seen.len() as f64);
                assert!((found / sigma - 1.0).abs() < 0.05, "{dt} s, {height_m} m, axis {axis}: {found} for {sigma}");
            }
        }
    }

    /// Correlations of Dryden's model at a distance x: `exp(-x/L)` along, `exp(-x/L) (1 - x/(2 L))` across and upwards.
    #[test]
    fn correlations_are_those_of_the_spectra() {
        let dt = 0.5;
        let (scales, seen) = flown(dt, 60.0, 9, 3_000.0);
        for lag in [2_usize, 8, 20] {
            let distance = lag as f64 * dt * 95.0 / scales.scale_m[0];
            let wanted =
                [exp(-distance), exp(-distance) * (1.0 - 0.5 * distance), exp(-distance) * (1.0 - 0.5 * distance)];
            for (axis, wanted) in wanted.into_iter().enumerate() {
                let sigma = scales.sigma_m_s[axis];
                let products: f64 = seen.iter().zip(&seen[lag..]).map(|(a, b)| a[axis] * b[axis]).sum();
                let found = products / (seen.len() - lag) as f64 / (sigma * sigma);
                assert!((found - wanted).abs() < 0.06, "lag {lag}, axis {axis}: {found} for {wanted}");
            }
        }
    }

    #[test]
    fn equal_seeds_meet_equal_gusts() {
        let last = |seed: u64| flown(0.5, 0.1, seed, 500.0).1.pop().unwrap().map(f64::to_bits);
        assert_eq!(last(3), last(3));
        assert_ne!(last(3), last(4));
    }
}
