//! Statistics of a sliding window against exact arithmetic, on data that lose digits in floating point.

use crate::monitoring::numbers::sliding_window::{contents, drop_before, push};
use crate::state::monitors::numbers::{Point, SlidingWindow};
use apex_model::time::{Duration, Time};

/// Returns noise of a fixed sequence, as whole multiples of the unit.
fn noise(index: i64, size: i64) -> i64 {
    let mixed =
        (index as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ ((index as u64) >> 7).wrapping_mul(0xD1B5_4A32_D192_ED03);
    (mixed >> 33) as i64 % (2 * size + 1) - size
}

/// Returns the greatest relative errors of variance, mean and slope. Values are `(offset + k) * unit` for whole numbers k, so that
/// integer arithmetic gives the exact result.
fn worst(offset: i64, unit: f64, number: impl Fn(i64) -> i64, samples: i64, length: i64) -> [f64; 3] {
    let mut window = SlidingWindow::default();
    let mut worst = [0.0_f64; 3];
    for at in 0..samples {
        let value = (offset as f64 + number(at) as f64) * unit;
        push(
            &mut window,
            Point { at: Time(at * 1_000_000), number: Some(value), held: Duration(1), may_be_first: true },
        );
        drop_before(&mut window, Time((at - length + 1) * 1_000_000), false, |_| {});
        if at < length || at % 97 != 0 {
            continue;
        }
        let found = contents(&window, Time((at - length + 1) * 1_000_000)).moments;
        let (n, inside) = (i128::from(length), || (at - length + 1)..=at);
        let (mut sum, mut squares, mut common) = (0_i128, 0_i128, 0_i128);
        for index in inside() {
            let k = i128::from(number(index));
            (sum, squares, common) = (sum + k, squares + k * k, common + k * i128::from(index - at));
        }
        let times: i128 = inside().map(|index| i128::from(index - at)).sum();
        let spread = inside().map(|index| i128::from(index - at).pow(2)).sum::<i128>() * n - times * times;
        let variance = (n * squares - sum * sum) as f64 / (n * n) as f64 * unit * unit;
        let mean = (i128::from(offset) * n + sum) as f64 / n as f64 * unit;
        let slope = (n * common - times * sum) as f64 / spread as f64 * unit * 1e3;
        let error = |found: Option<f64>, right: f64| ((found.unwrap() - right) / right).abs();
        for (slot, error) in worst.iter_mut().zip([
            error(found.variance(), variance),
            error(found.mean(), mean),
            error(found.slope_per_s(), slope),
        ]) {
            *slot = slot.max(error);
        }
    }
    worst
}

#[test]
fn offsets_spikes_and_small_noise_cost_no_digits() {
    let tiny = libm::ldexp(1.0, -23);
    let cases = [
        (
            "1e9 offset, 1e-3 noise",
            worst(1_000_000_000 << 23, tiny, |index| noise(index, 8_388) + index, 20_000, 1_000),
        ),
        (
            "one 1e8 spike",
            worst(
                0,
                tiny,
                |index| if index == 5_000 { 100_000_000 << 23 } else { noise(index, 8_388) + index + 9 },
                20_000,
                1_000,
            ),
        ),
        (
            "longitude, 1e-7 noise",
            worst(-122 << 40, libm::ldexp(1.0, -40), |index| noise(index, 110_000) + index * 7, 20_000, 1_000),
        ),
        (
            "a million samples",
            worst(1_000_000_000 << 23, tiny, |index| noise(index, 8_388) + index % 4_096, 1_000_000, 64),
        ),
    ];
    for (name, errors) in cases {
        println!("{name}: variance {:.1e}, mean {:.1e}, slope {:.1e}", errors[0], errors[1], errors[2]);
        assert!(errors.iter().all(|error| *error <= 1e-9), "{name}: {errors:?}");
    }
}
