//! Adaptive Gauss-Kronrod quadrature (7 and 15 points). It serves to check closed forms, and to integrate user-defined cost functions.
//!
//! Both rules miss jumps beyond the outermost nodes, and pairs of jumps that are symmetric about the middle. So the function is also
//! compared with the polynomial through the nodes at both ends.
//! Bound: at most [`PIECES_MAX`] bisections, 17 evaluations each.

use std::sync::LazyLock;

/// Maximum number of pieces of one integral. Bisecting down to the last bit of one jump takes 60.
pub const PIECES_MAX: usize = 4_000;

const NODES: [f64; 7] = [
    0.991_455_371_120_812_6,
    0.949_107_912_342_758_5,
    0.864_864_423_359_769_1,
    0.741_531_185_599_394_4,
    0.586_087_235_467_691_1,
    0.405_845_151_377_397_2,
    0.207_784_955_007_898_47,
];
const KRONROD: [f64; 7] = [
    0.022_935_322_010_529_224,
    0.063_092_092_629_978_55,
    0.104_790_010_322_250_18,
    0.140_653_259_715_525_92,
    0.169_004_726_639_267_9,
    0.190_350_578_064_785_4,
    0.204_432_940_075_298_9,
];
const KRONROD_MIDDLE: f64 = 0.209_482_141_084_727_82;
/// Weights of the 7-point Gauss rule at the odd nodes above (0 elsewhere).
const GAUSS: [f64; 7] =
    [0.0, 0.129_484_966_168_869_7, 0.0, 0.279_705_391_489_276_64, 0.0, 0.381_830_050_505_118_9, 0.0];
const GAUSS_MIDDLE: f64 = 0.417_959_183_673_469_4;

/// Points of comparison, in halves of a piece's width from its middle, and the width that the comparison represents.
const COMPARED: [(f64, f64); 2] = [(-1.0, 0.009), (1.0, 0.009)];
/// Distance from an end, as a share of the larger end's value, within which a point counts as the end: a jump there belongs to the next
/// piece.
const END_SHARE: f64 = 1e-13;

/// Returns the nodes of a piece, including those mirrored into its other half.
fn nodes() -> impl Iterator<Item = f64> + Clone {
    NODES.iter().map(|node| -node).chain([0.0]).chain(NODES.iter().rev().copied())
}

/// Weight of each node's value in the polynomial through all nodes, at each point of [`COMPARED`].
static SHARES: LazyLock<[[f64; 15]; 2]> = LazyLock::new(|| {
    COMPARED.map(|(place, _)| {
        let mut shares = [0.0; 15];
        for (share, node) in shares.iter_mut().zip(nodes()) {
            *share = nodes().filter(|other| *other != node).map(|other| (place - other) / (node - other)).product();
        }
        shares
    })
});

#[derive(Clone, Copy)]
struct Subinterval {
    from: f64,
    until: f64,
    value: f64,
    error: f64,
}

fn rule(function: &mut dyn FnMut(f64) -> f64, from: f64, until: f64) -> Subinterval {
    let (middle, half) = (0.5 * (from + until), 0.5 * (until - from));
    let mut values = [0.0; 15];
    for (value, node) in values.iter_mut().zip(nodes()) {
        *value = function(middle + half * node);
    }
    let weighted = |sides: [f64; 7], at_middle: f64| {
        let weights = sides.into_iter().chain([at_middle]).chain(sides.into_iter().rev());
        values.iter().zip(weights).map(|(value, weight)| value * weight).sum::<f64>()
    };
    let (kronrod, gauss) = (weighted(KRONROD, KRONROD_MIDDLE), weighted(GAUSS, GAUSS_MIDDLE));
    let inside = END_SHARE * from.abs().max(until.abs());
    let mut error = (kronrod - gauss).abs();
    for ((place, width), shares) in COMPARED.iter().zip(SHARES.iter()) {
        let expected: f64 = values.iter().zip(shares).map(|(value, share)| value * share).sum();
        let at = (middle + half * place).min(until - inside).max(from + inside);
        error += width * (function(at) - expected).abs();
    }
    Subinterval { from, until, value: kronrod * half, error: error * half }
}

/// Returns the integral of `function` from `from` to `until`, to `tolerance` relative to the integral (or absolute below 1). `breaks` are
/// known kinks and jumps; without them the result is as accurate but slower.
///
/// # Errors
/// An error message if the function yields a value that is not finite or the tolerance is not reached.
pub fn integrate(
    function: &mut dyn FnMut(f64) -> f64,
    from: f64,
    until: f64,
    breaks: &[f64],
    tolerance: f64,
) -> Result<f64, String> {
    let mut cuts: Vec<f64> = breaks.iter().copied().filter(|at| *at > from && *at < until).collect();
    cuts.push(from);
    cuts.push(until);
    cuts.sort_by(f64::total_cmp);
    let mut pieces: Vec<Subinterval> =
        cuts.iter().zip(cuts.iter().skip(1)).map(|(a, b)| rule(function, *a, *b)).collect();
    while pieces.len() < PIECES_MAX {
        let value: f64 = pieces.iter().map(|piece| piece.value).sum();
        let error: f64 = pieces.iter().map(|piece| piece.error).sum();
        if !value.is_finite() || !error.is_finite() {
            return Err(format!("the function has no finite integral between {from} and {until}"));
        }
        if error <= tolerance * value.abs().max(1.0) {
            return Ok(value);
        }
        let worst = (0..pieces.len()).max_by(|a, b| {
            let error_of = |index: &usize| pieces.get(*index).map_or(0.0, |piece| piece.error);
            error_of(a).total_cmp(&error_of(b))
        });
        let Some(worst) = worst else { return Ok(0.0) };
        let piece = pieces.swap_remove(worst);
        let middle = 0.5 * (piece.from + piece.until);
        if middle <= piece.from || middle >= piece.until {
            // The piece is a jump between two neighbouring floating-point numbers: its integral is negligible.
            pieces.push(Subinterval { error: 0.0, ..piece });
            continue;
        }
        pieces.push(rule(function, piece.from, middle));
        pieces.push(rule(function, middle, piece.until));
    }
    Err(format!("the integral between {from} and {until} does not converge; name the places of its jumps"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rules_are_exact_where_they_must_be() {
        let piece = rule(&mut |_| 1.0, -1.0, 1.0);
        assert!((piece.value - 2.0).abs() < 1e-15 && piece.error < 1e-15);
        // Kronrod's 15 points are exact to degree 22.
        let piece = rule(&mut |x| libm::pow(x, 22.0), -1.0, 1.0);
        assert!((piece.value - 2.0 / 23.0).abs() < 1e-14);
    }

    #[test]
    fn smooth_and_broken_functions() {
        let sine = integrate(&mut libm::sin, 0.0, std::f64::consts::PI, &[], 1e-12).unwrap();
        assert!((sine - 2.0).abs() < 1e-12);
        let jump = integrate(&mut |x| if x < 1.0 / 3.0 { 0.0 } else { 1.0 }, 0.0, 1.0, &[], 1e-12).unwrap();
        assert!((jump - 2.0 / 3.0).abs() < 1e-11);
    }

    /// Jumps at every thousandth of the interval, alone and with a second jump at the mirrored place.
    #[test]
    fn no_jump_is_overlooked() {
        for thousandth in 0..990 {
            let (first, second) = (1e-3 * f64::from(thousandth) + 3e-4, 0.997 - 1e-3 * f64::from(thousandth));
            let step = |x: f64, at: f64| if x < at { 0.0 } else { 1.0 };
            let one = integrate(&mut |x| step(x, first), 0.0, 1.0, &[], 1e-11).unwrap();
            assert!((one - (1.0 - first)).abs() < 2e-11, "{one} {first}");
            let two = integrate(&mut |x| step(x, first) + step(x, second), 0.0, 1.0, &[], 1e-11).unwrap();
            assert!((two - (2.0 - first - second)).abs() < 4e-11, "{two} {first} {second}");
        }
    }

    #[test]
    fn jumps_that_are_named_take_few_calls() {
        let mut calls = 0;
        let mut steps = |x: f64| {
            calls += 1;
            if x < 1.0 / 3.0 { 0.0 } else { 1.0 }
        };
        assert!((integrate(&mut steps, 0.0, 1.0, &[1.0 / 3.0], 1e-12).unwrap() - 2.0 / 3.0).abs() < 1e-12);
        assert_eq!(calls, 2 * 17);
    }

    #[test]
    fn nonsense_is_an_error() {
        assert!(integrate(&mut |x| 1.0 / x, 0.0, 1.0, &[], 1e-10).is_err());
        assert!(integrate(&mut |_| f64::NAN, 0.0, 1.0, &[], 1e-10).is_err());
        assert_eq!(integrate(&mut |x| x, 2.0, 2.0, &[], 1e-10), Ok(0.0));
    }
}
