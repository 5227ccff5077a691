//! The samples of a signal in a window of time: thinned for drawing, with statistics and excursions of all samples.

use super::limits::{self, Raised};
use super::sample::StoredSample;
use super::store::Series;
use super::types::{Signal, SignalKind, SignalWindow, Statistics};
use std::borrow::Cow;

/// Up to this number of samples per pixel each sample is returned.
const SAMPLES_PER_PIXEL: usize = 2;

impl Series {
    /// Returns the samples of the window that had arrived by `at`, in buckets for `pixels`.
    pub(in crate::record::view) fn window(
        &self,
        signal: Signal,
        (from, to): (i64, i64),
        at: i64,
        pixels: usize,
        raised: &Raised,
    ) -> SignalWindow {
        let first = self.samples.partition_point(|sample| sample.at_ns < from);
        let end = self.samples.partition_point(|sample| sample.at_ns <= to);
        let window_samples = arrived(self.samples.get(first..end).unwrap_or_default(), at);
        let inside = &*window_samples;
        let before = self.samples.get(..first).unwrap_or_default();
        let before = before.iter().rev().find(|sample| sample.arrived_ns <= at);
        let of_words = signal.kind == SignalKind::Words;
        let drawn: Vec<&[StoredSample]> = if of_words {
            // A word holds until the next one: only changes are drawn.
            inside.chunk_by(|a, b| a.value.to_bits() == b.value.to_bits()).collect()
        } else if inside.len() <= pixels.saturating_mul(SAMPLES_PER_PIXEL) {
            inside.chunks(1).collect()
        } else {
            let pixel = |sample: &StoredSample| {
                i128::from(sample.at_ns - from) * pixels as i128 / i128::from((to - from).max(1))
            };
            inside.chunk_by(|a, b| pixel(a) == pixel(b)).collect()
        };
        let mut window = SignalWindow {
            t_ns: Vec::with_capacity(drawn.len() + 1),
            low: Vec::new(),
            high: Vec::new(),
            mean: Vec::new(),
            count: Vec::new(),
            words: if of_words { self.words.clone() } else { Vec::new() },
            statistics: if of_words { None } else { statistics(inside) },
            samples: inside.len(),
            excursions: Vec::new(),
            left_out: 0,
            signal,
        };
        for bucket in before.map(std::slice::from_ref).into_iter().chain(drawn) {
            let Some((first, summary)) = bucket.first().zip(statistics(bucket)) else { continue };
            window.t_ns.push(first.at_ns);
            window.low.push(summary.low);
            window.high.push(summary.high);
            window.mean.push(if of_words { summary.last } else { summary.mean });
            window.count.push(u32::try_from(summary.samples).unwrap_or(u32::MAX));
        }
        if !of_words && !window.signal.limits.is_empty() {
            // An excursion may have begun long before the window.
            let known = arrived(&self.samples, at);
            (window.excursions, window.left_out) =
                limits::excursions(&window.signal.limits, &known, (from, to), raised);
        }
        window
    }
}

/// Returns the samples that had arrived by `at`; copied only if some had not.
fn arrived(samples: &[StoredSample], at: i64) -> Cow<'_, [StoredSample]> {
    let has_arrived = |sample: &&StoredSample| sample.arrived_ns <= at;
    if samples.iter().all(|sample| has_arrived(&sample)) {
        return Cow::Borrowed(samples);
    }
    Cow::Owned(samples.iter().filter(has_arrived).copied().collect())
}

fn statistics(samples: &[StoredSample]) -> Option<Statistics> {
    let (first, last) = (samples.first()?.value, samples.last()?.value);
    let number = samples.len() as f64;
    let (mut low, mut high, mut sum) = (f64::INFINITY, f64::NEG_INFINITY, 0.0);
    for sample in samples {
        low = low.min(sample.value);
        high = high.max(sample.value);
        sum += sample.value;
    }
    let mean = sum / number;
    let squares: f64 = samples.iter().map(|sample| (sample.value - mean) * (sample.value - mean)).sum();
    let deviation = (squares / number).sqrt();
    Some(Statistics { samples: samples.len(), low, high, mean, deviation, first, last })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn signal() -> Signal {
        let name = "(roll-angle aircraft-1)".to_owned();
        let (attribute, object) = ("roll-angle".to_owned(), "aircraft-1".to_owned());
        Signal {
            name,
            attribute,
            object,
            unit: "deg".into(),
            kind: SignalKind::Number,
            first_ns: 0,
            limits: Vec::new(),
        }
    }

    fn series(values: &[f64]) -> Series {
        let sample = |(index, value): (usize, &f64)| {
            let at_ns = index as i64 * 10;
            StoredSample { at_ns, arrived_ns: at_ns + 3, value: *value }
        };
        Series { samples: values.iter().enumerate().map(sample).collect(), words: Vec::new() }
    }

    #[test]
    fn a_sample_is_known_when_it_has_arrived() {
        let series = series(&[1.0, 2.0, 9.0]);
        let window = series.window(signal(), (0, 100), 22, 100, &Raised::default());
        assert_eq!((window.samples, window.statistics.unwrap().high), (2, 2.0));
        let window = series.window(signal(), (0, 100), 23, 100, &Raised::default());
        assert_eq!((window.samples, window.statistics.unwrap().high), (3, 9.0));
    }

    #[test]
    fn a_line_enters_the_window_from_the_sample_before_it() {
        let window = series(&[1.0, 2.0, 9.0, 4.0]).window(signal(), (15, 25), 100, 100, &Raised::default());
        assert_eq!((window.t_ns, window.high, window.samples), (vec![10, 20], vec![2.0, 9.0], 1));
    }

    proptest! {
        /// Extremes, mean and number of a window are those of all its samples, however much the drawing is thinned.
        #[test]
        fn buckets_hold_every_sample_of_the_window(
            values in prop::collection::vec(-50.0..50.0f64, 1..400),
            from in 0i64..4_000, length in 1i64..4_000, pixels in 1usize..60,
        ) {
            let (to, at) = (from + length, 3_000);
            let window = series(&values).window(signal(), (from, to), at, pixels, &Raised::default());
            let inside: Vec<f64> = values.iter().enumerate()
                .filter(|(index, _)| { let t = *index as i64 * 10; t >= from && t <= to && t + 3 <= at })
                .map(|(_, value)| *value).collect();
            let skipped = usize::from(window.t_ns.first().is_some_and(|first| *first < from));
            let count: u32 = window.count.iter().skip(skipped).sum();
            prop_assert_eq!(count as usize, inside.len());
            prop_assert!(window.t_ns.len() <= skipped + inside.len().min((pixels + 1) * SAMPLES_PER_PIXEL));
            let fold = |list: &[f64], of: fn(f64, f64) -> f64| list.iter().copied().reduce(of);
            prop_assert_eq!(fold(window.low.get(skipped..).unwrap(), f64::min), fold(&inside, f64::min));
            prop_assert_eq!(fold(window.high.get(skipped..).unwrap(), f64::max), fold(&inside, f64::max));
        }
    }
}
