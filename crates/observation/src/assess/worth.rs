//! Value of one look for one wanted look, as a product of factors.

use super::context::{AssessContext, Product};
use crate::clarity::clear_probability;
use crate::grid::TargetGrid;
use crate::looks::{CellLook, StripFacts, TargetPass};
use crate::result::LossCause;
use crate::target::{ObservedTarget, WantedLook};
use crate::timing::{LightNeed, sun::SunDirection, windows_factor};
use apex_geo::geodesy::RAD_PER_DEG;

/// Number of causes of losses.
pub(super) const CAUSES: usize = LossCause::ALL.len();

/// Timing of one strip for one wanted look, without light.
#[derive(Clone, Copy, Debug)]
struct StripTiming {
    window: f64,
    slope: f64,
    overpass: f64,
    latency: f64,
    order: f64,
    product: f64,
}

/// Values of looks for one wanted look.
pub(super) struct StripWorth<'a> {
    /// The wanted look.
    pub(super) look: &'a WantedLook,
    grid: &'a TargetGrid,
    timings: Vec<Vec<StripTiming>>,
    /// Direction of the sun at each strip, if light is required.
    suns: Vec<Vec<[f64; 3]>>,
    /// True if a look has a value but the time of its arrival on the ground is unknown.
    pub(super) is_arrival_missing: bool,
}

/// The value of one look of a cell.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct LookWorth {
    /// Probability that the line is valid; 1 as flown.
    pub(super) valid: f64,
    /// Probability that no cloud hides the cell; 1 as flown.
    pub(super) clear: f64,
    /// Clarity of the look if it is valid.
    pub(super) s: f64,
    /// Clarity times resolution.
    pub(super) sr: f64,
    /// Clarity times resolution times timing.
    pub(super) sro: f64,
}

impl LookWorth {
    /// Returns the expected value of this look alone.
    pub(super) fn expected(&self) -> f64 {
        self.valid * self.clear * self.sro
    }
}

impl<'a> StripWorth<'a> {
    pub(super) fn new(
        target: &'a ObservedTarget,
        look: &'a WantedLook,
        grid: &'a TargetGrid,
        passes: &[&TargetPass],
        context: &AssessContext<'_>,
    ) -> StripWorth<'a> {
        let mut is_arrival_missing = false;
        let timings = passes.iter().map(|pass| {
            let timing = |strip: &StripFacts| {
                let on_ground_s = look.latency.and_then(|_| arrival_s(strip, context.products));
                is_arrival_missing |= on_ground_s.is_none() && look.latency.is_some();
                StripTiming::new(target, look, strip.time_s, on_ground_s, context)
            };
            pass.strips.iter().map(timing).collect()
        });
        let timings = timings.collect();
        let suns = if look.light == LightNeed::Any { Vec::new() } else { suns(passes, context.zero_unix_s) };
        StripWorth { look, grid, timings, suns, is_arrival_missing }
    }

    fn timing(&self, pass: u32, strip: u32) -> Option<&StripTiming> {
        self.timings.get(pass as usize)?.get(strip as usize)
    }

    fn light(&self, pass: u32, look: &CellLook) -> f64 {
        if self.look.light == LightNeed::Any {
            return 1.0;
        }
        let Some(sun) = self.suns.get(pass as usize).and_then(|suns| suns.get(look.strip as usize)) else { return 0.0 };
        let sine: f64 = self.grid.normal(look.cell as usize).iter().zip(sun).map(|(a, b)| a * b).sum();
        self.look.light.factor(libm::asin(sine.clamp(-1.0, 1.0)) / RAD_PER_DEG)
    }

    fn angle(&self, look: &CellLook) -> f64 {
        self.look
            .look_angles
            .map_or(1.0, |angles| angles.factor(libm::acos(f64::from(look.look_cosine).min(1.0)) / RAD_PER_DEG))
    }

    fn size(&self, look: &CellLook) -> f64 {
        self.look.resolution.factor(f64::from(look.pixel_along_m), f64::from(look.pixel_across_m))
    }

    /// Returns the value of a look; `interval` is the factor of the time since the previous look that counts. It is called for each look of
    /// each cell, so its callers contain it.
    #[inline]
    pub(super) fn of(&self, pass: u32, look: &CellLook, strip: &StripFacts, interval: f64) -> LookWorth {
        let clear = clear_of(look, strip);
        let steady = strip.weights.steady() * f64::from(look.glint);
        let (valid, clear, s) = if strip.is_flown {
            (1.0, 1.0, steady * strip.weights.roll * clear)
        } else {
            (strip.weights.roll, clear, steady)
        };
        let sr = s * self.size(look) * self.angle(look);
        let timing = self.timing(pass, look.strip).map_or(0.0, |timing| timing.product);
        let sro = if sr > 0.0 && timing > 0.0 { sr * timing * self.light(pass, look) * interval } else { 0.0 };
        LookWorth { valid, clear, s, sr, sro }
    }

    /// Adds the losses of a look that counts with probability `used` to the causes.
    pub(super) fn add_losses(
        &self,
        pass: u32,
        look: &CellLook,
        strip: &StripFacts,
        (used, interval): (f64, f64),
        losses: &mut [f64; CAUSES],
    ) {
        let (weights, timing) = (&strip.weights, self.timing(pass, look.strip));
        let flown = |weight: f64| if strip.is_flown { weight } else { 1.0 };
        let of = |part: fn(&StripTiming) -> f64| timing.map_or(0.0, part);
        let factors = [
            (LossCause::AttitudeNotRecorded, weights.attitude_known),
            (LossCause::Roll, flown(weights.roll)),
            (LossCause::Rates, weights.rates),
            (LossCause::LineGaps, weights.line_gaps),
            (LossCause::Smear, weights.smear),
            (LossCause::TooDark, weights.exposed),
            (LossCause::SensorNotReady, weights.ready),
            (LossCause::Cloud, flown(clear_of(look, strip))),
            (LossCause::Glint, f64::from(look.glint)),
            (LossCause::TooCoarse, self.size(look)),
            (LossCause::LookAngle, self.angle(look)),
            (LossCause::WrongTime, of(|timing| timing.window)),
            (LossCause::ValueFallen, of(|timing| timing.slope)),
            (LossCause::NoLight, self.light(pass, look)),
            (LossCause::NoOverpass, of(|timing| timing.overpass)),
            (LossCause::LateOnGround, of(|timing| timing.latency)),
            (LossCause::Order, of(|timing| timing.order)),
            (LossCause::Interval, interval),
        ];
        let mut left = used;
        for (cause, factor) in factors {
            add(losses, cause, left * (1.0 - factor));
            left *= factor;
        }
    }

    /// Adds the loss of a cell that no predicted look sees validly, with probability `missed`, divided between roll and cloud as for its
    /// best look.
    pub(super) fn add_missed(&self, look: &CellLook, strip: &StripFacts, missed: f64, losses: &mut [f64; CAUSES]) {
        let (valid, clear) = (strip.weights.roll, clear_of(look, strip));
        let whole = 1.0 - valid * clear;
        if whole > 0.0 {
            add(losses, LossCause::Roll, missed * (1.0 - valid) / whole);
            add(losses, LossCause::Cloud, missed * valid * (1.0 - clear) / whole);
        }
    }
}

/// Adds a share to a cause.
pub(super) fn add(losses: &mut [f64; CAUSES], cause: LossCause, share: f64) {
    if let Some(sum) = losses.get_mut(cause as usize) {
        *sum += share;
    }
}

fn clear_of(look: &CellLook, strip: &StripFacts) -> f64 {
    let share = strip.weights.clear_share;
    if strip.is_flown || share >= 1.0 || share <= 0.0 {
        return share;
    }
    let cosine = f64::from(look.look_cosine).clamp(1e-6, 1.0);
    clear_probability(share, libm::sqrt(1.0 - cosine * cosine) / cosine)
}

impl StripTiming {
    fn new(
        target: &ObservedTarget,
        look: &WantedLook,
        time_s: f64,
        on_ground_s: Option<f64>,
        context: &AssessContext<'_>,
    ) -> StripTiming {
        let order = target.after.iter().fold(1.0, |product, first| {
            let is_seen = context.first_valid_s.get(&first.target).is_some_and(|seen_s| *seen_s <= time_s);
            if is_seen { product } else { product * first.discount.clamp(0.0, 1.0) }
        });
        let window = windows_factor(&look.windows, time_s);
        let slope = look.slope.as_ref().map_or(1.0, |slope| slope.factor(time_s).clamp(0.0, 1.0));
        let overpass = look.overpass.as_ref().map_or(1.0, |need| need.factor(time_s));
        let latency = look.latency.map_or(1.0, |need| need.factor(on_ground_s.map(|ground_s| ground_s - time_s)));
        let product = window * slope * overpass * latency * order;
        StripTiming { window, slope, overpass, latency, order, product }
    }
}

/// Returns the first instant at which the image of a strip is on the ground, on its own or in a product that contains it; `None` if
/// neither is known.
fn arrival_s(strip: &StripFacts, products: &[Product]) -> Option<f64> {
    let holds = |product: &&Product| product.from_s <= strip.time_s && strip.time_s <= product.until_s;
    let received = products.iter().filter(holds).map(|product| product.on_ground_s);
    received.chain(strip.on_ground_s).reduce(f64::min)
}

/// Returns the direction of the sun at each strip, turning evenly between the ends of a pass.
fn suns(passes: &[&TargetPass], zero_unix_s: f64) -> Vec<Vec<[f64; 3]>> {
    let of_pass = |pass: &&TargetPass| {
        let (Some(first), Some(last)) = (pass.strips.first(), pass.strips.last()) else { return Vec::new() };
        let track = SunDirection::track(zero_unix_s + first.time_s, zero_unix_s + last.time_s);
        pass.strips.iter().map(|strip| track(zero_unix_s + strip.time_s).unit()).collect()
    };
    passes.iter().map(of_pass).collect()
}
