//! A user-defined cost as a table of the model, so that planners and bounds can use it.
//!
//! # Guarantee
//! The function must never fall between the ages 0 and `oldest_s`; `C` is its cost at `oldest_s`. Then at every age the table is within
//! `relative_error` of the cost, or within `relative_error` of [`LEAST_SHARE`] of `C` where the cost is less. Excepted are gaps around
//! jumps, in total [`JUMP_SHARE`] of `oldest_s` for each `C` of height. So the cost of every interval is met within `relative_error` of
//! the sum of that cost and of its length times [`LEAST_SHARE`] of `C`, plus [`JUMP_SHARE`] of `C oldest_s`.
//!
//! This is proven, not estimated from samples: between two evaluated ages a function that never falls lies between its costs at them, and
//! ages are added until neighbouring costs are close enough. A fall between two evaluated ages cannot be detected. In that case, and
//! beyond `oldest_s`, where the table is constant, nothing is guaranteed.
//! Bound: at most [`ASKED_MAX`] calls and [`POINTS_MAX`] points.

use crate::user_cost::{self, Function, ROUNDING};

/// Maximum number of points of one table; planners search them at every step.
pub const POINTS_MAX: usize = 1_000;
/// Maximum number of calls of the function. A smooth function takes half as many for a relative error of 1e-5.
pub const ASKED_MAX: usize = 4_000_000;
/// Share of the cost at the oldest age: a smaller cost has the same absolute error as a cost of this share.
pub const LEAST_SHARE: f64 = 1e-3;
/// Largest distance between the two points around a jump, as a share of the oldest age: forty halvings.
pub const JUMP_SHARE: f64 = 1.0 / (1_u64 << 40) as f64;

/// Returns points `(age_s, cost)` by rising age from 0 to `oldest_s`, for `CostFunction::Table`.
///
/// # Errors
/// An error message with the age at which the cost is missing, negative or not finite, or falls; also if too many calls or points are
/// needed.
pub fn tabulate(function: &mut Function<'_>, oldest_s: f64, relative_error: f64) -> Result<Vec<(f64, f64)>, String> {
    if !oldest_s.is_finite() || oldest_s <= 0.0 {
        return Err(format!("the oldest age is {oldest_s} s; it must be a positive number"));
    }
    if !(relative_error > 0.0 && relative_error <= 0.5) {
        return Err(format!("the relative error is {relative_error}; it must be above 0 and at most 0.5"));
    }
    let oldest = user_cost::ask(function, oldest_s)?;
    // One half is for the behaviour between evaluated ages, the other for the straight lines; slightly less in total, because the lines'
    // half is relative to the cost at the older end.
    let share = 0.5 * relative_error / (1.0 + relative_error);
    let near = |cost: f64| share * cost.max(LEAST_SHARE * oldest);
    let asked = asked(function, (oldest_s, oldest), near)?;
    let points = straightened(&asked, near);
    if points.len() > POINTS_MAX {
        return Err(format!(
            "the table of the cost needs {} points and may have {POINTS_MAX}; allow a relative error above {relative_error}",
            points.len()
        ));
    }
    Ok(points)
}

/// Halves the ages from 0 to the oldest until neighbours are `near` each other in cost, or in age as near as around a jump.
fn asked(
    function: &mut Function<'_>,
    oldest: (f64, f64),
    near: impl Fn(f64) -> f64,
) -> Result<Vec<(f64, f64)>, String> {
    let rounding = ROUNDING * oldest.1;
    let between = |low: (f64, f64), (age_s, cost): (f64, f64), high: (f64, f64)| {
        if cost < low.1 - rounding {
            return Err(user_cost::falls(low, (age_s, cost)));
        }
        if cost > high.1 + rounding {
            return Err(user_cost::falls((age_s, cost), high));
        }
        Ok((age_s, cost.clamp(low.1, high.1)))
    };
    let mut youngest = (0.0, user_cost::ask(function, 0.0)?);
    youngest = between((0.0, 0.0), youngest, oldest)?;
    let mut done = vec![youngest];
    let mut last = youngest;
    // Ends of intervals still to be done, the next one last.
    let mut ahead = vec![oldest];
    while let Some(next) = ahead.last().copied() {
        if next.1 - last.1 <= near(last.1) || next.0 - last.0 <= JUMP_SHARE * oldest.0 {
            ahead.pop();
            done.push(next);
            last = next;
            continue;
        }
        if done.len() + ahead.len() >= ASKED_MAX {
            return Err(format!(
                "the table of the cost takes more than {ASKED_MAX} calls and reaches {} s of age; allow a greater relative error",
                last.0
            ));
        }
        let middle_s = last.0 + 0.5 * (next.0 - last.0);
        ahead.push(between(last, (middle_s, user_cost::ask(function, middle_s)?), next)?);
    }
    Ok(done)
}

/// Returns a subset of the points, by rising age, such that straight lines between them pass all other points `near` enough. Each line
/// extends as far as possible.
fn straightened(points: &[(f64, f64)], near: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
    let Some((first, rest)) = points.split_first() else { return Vec::new() };
    let (mut corners, mut corner) = (vec![*first], *first);
    // Slopes that pass all points since the corner, and the last of these points.
    let (mut least, mut most, mut last) = (f64::NEG_INFINITY, f64::INFINITY, *first);
    let slope = |from: (f64, f64), to: (f64, f64)| (to.1 - from.1) / (to.0 - from.0);
    for point in rest {
        if !(least..=most).contains(&slope(corner, *point)) {
            corners.push(last);
            corner = last;
            (least, most) = (f64::NEG_INFINITY, f64::INFINITY);
        }
        let room = near(point.1);
        least = least.max(slope(corner, (point.0, point.1 - room)));
        most = most.min(slope(corner, (point.0, point.1 + room)));
        last = *point;
    }
    if last.0 > corner.0 {
        corners.push(last);
    }
    corners
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::eci::{self, QUADRATURE_TOLERANCE, cost_at, cost_integral, tests::families, tests::jumps};
    use crate::quadrature;
    use apex_model::problem::CostFunction;
    use proptest::prelude::*;

    const OLDEST_S: f64 = 4_000.0;

    fn tabulated(cost: &CostFunction, relative_error: f64) -> CostFunction {
        let points = tabulate(&mut |age_s| Ok(cost_at(cost, age_s)), OLDEST_S, relative_error).unwrap();
        assert!(points.windows(2).all(|pair| pair[0].0 < pair[1].0 && pair[0].1 <= pair[1].1), "{points:?}");
        CostFunction::Table { points }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn intervals_cost_what_quadrature_says(
            cost in families(), error in 5e-4..0.3f64, ends in (0.0..OLDEST_S, 0.0..OLDEST_S),
        ) {
            let table = tabulated(&cost, error);
            let (from, until) = (ends.0.min(ends.1), ends.0.max(ends.1));
            let mut function = |age_s| cost_at(&cost, age_s);
            let exact = quadrature::integrate(&mut function, from, until, &jumps(&cost), QUADRATURE_TOLERANCE).unwrap();
            let off = cost_integral(&table, until) - cost_integral(&table, from) - exact;
            let oldest = cost_at(&cost, OLDEST_S);
            let least = LEAST_SHARE * oldest * (until - from);
            let allowed = error * (exact + least) + 2.0 * JUMP_SHARE * oldest * OLDEST_S + 1e-9;
            prop_assert!(off.abs() <= allowed, "off by {off}, allowed {allowed}");
        }

        #[test]
        fn costs_without_jumps_are_met_everywhere(
            cost in families(), error in 5e-4..0.3f64, ages in prop::collection::vec(0.0..OLDEST_S, 50),
        ) {
            let table = tabulated(&cost, error);
            let oldest = cost_at(&cost, OLDEST_S);
            for age_s in ages {
                let exact = cost_at(&cost, age_s);
                if jumps(&cost).iter().any(|jump_s| (jump_s - age_s).abs() < 1e-6) {
                    continue;
                }
                let off = cost_at(&table, age_s) - exact;
                prop_assert!(off.abs() <= error * exact.max(LEAST_SHARE * oldest) + 1e-11 * oldest, "{off} at {age_s} s");
            }
        }

        /// Steps at halves and quarters, where samples at even distances would see a straight line.
        #[test]
        fn stairs_are_seen(parts in 1..40u32, error in 1e-3..0.3f64) {
            let stair_s = OLDEST_S / f64::from(parts);
            let stairs = |age_s: f64| (age_s / stair_s).floor();
            let points = tabulate(&mut |age_s| Ok(stairs(age_s)), OLDEST_S, error).unwrap();
            let table = CostFunction::Table { points };
            let exact = 0.5 * f64::from(parts) * f64::from(parts - 1) * stair_s;
            let off = cost_integral(&table, OLDEST_S) - exact;
            prop_assert!(off.abs() <= error * (exact + LEAST_SHARE * f64::from(parts) * OLDEST_S), "off by {off}");
        }
    }

    #[test]
    fn few_points_where_few_will_do() {
        let points = |cost: &dyn Fn(f64) -> f64| tabulate(&mut |age_s| Ok(cost(age_s)), 3_600.0, 1e-4).unwrap();
        assert_eq!(points(&|_| 0.0), [(0.0, 0.0), (3_600.0, 0.0)]);
        assert_eq!(points(&|_| 7.0), [(0.0, 7.0), (3_600.0, 7.0)]);
        assert_eq!(points(&|age_s| 2.0 * age_s), [(0.0, 0.0), (3_600.0, 7_200.0)]);
        let step = points(&|age_s| if age_s < 1_000.0 { 0.0 } else { 5.0 });
        assert_eq!(step.len(), 4);
        assert!((step[1].0 - 1_000.0).abs() < 1e-8 && (step[2].0 - 1_000.0).abs() < 1e-8, "{step:?}");
        let saturating = points(&|age_s| -libm::expm1(-age_s / 600.0)).len();
        assert!((50..300).contains(&saturating), "{saturating}");
    }

    #[test]
    fn what_is_not_a_cost_is_reported_with_its_age() {
        let told = |cost: &dyn Fn(f64) -> f64| tabulate(&mut |age_s| Ok(cost(age_s)), 100.0, 1e-2).unwrap_err();
        assert!(told(&|age_s| 1.0 - age_s).contains("100 s old is -99"));
        assert!(told(&|_| f64::NAN).contains("100 s old is NaN"));
        assert!(told(&|age_s| 101.0 - age_s).contains("falls from 101 at 0 s to 1 at 100 s"));
        let dented = |age_s: f64| if (50.0..60.0).contains(&age_s) { 1.0 } else { age_s };
        assert!(told(&dented).contains("falls from"), "{}", told(&dented));
        let low = |age_s: f64| if (60.0..70.0).contains(&age_s) { 1.0 } else { age_s };
        assert!(told(&low).contains("falls from 50 at 50 s to 1 at 62.5 s"), "{}", told(&low));
        let raised = tabulate(&mut |age_s| Err(format!("no idea of {age_s}")), 100.0, 1e-2).unwrap_err();
        assert!(raised.contains("100 s old cannot be computed: no idea of 100"), "{raised}");
    }

    #[test]
    fn rounding_is_not_a_fall() {
        let mut calls = 0;
        let mut wobbling = |age_s: f64| {
            calls += 1;
            Ok(age_s.floor() + if calls % 2 == 0 { 1e-11 } else { 0.0 })
        };
        let points = tabulate(&mut wobbling, 100.0, 0.1).unwrap();
        assert!(points.windows(2).all(|pair| pair[0].1 <= pair[1].1), "{points:?}");
    }

    #[test]
    fn limits_are_reported() {
        let mut line = |age_s: f64| Ok(age_s);
        assert!(tabulate(&mut line, 0.0, 0.1).unwrap_err().contains("oldest age"));
        assert!(tabulate(&mut line, f64::INFINITY, 0.1).unwrap_err().contains("oldest age"));
        assert!(tabulate(&mut line, 10.0, 0.0).unwrap_err().contains("relative error"));
        assert!(tabulate(&mut line, 10.0, 1e-9).unwrap_err().contains("more than 4000000 calls"));
        let mut stairs = |age_s: f64| Ok((1_000.0 * age_s).floor());
        assert!(tabulate(&mut stairs, 10.0, 0.001).unwrap_err().contains("points and may have 1000"));
    }

    #[test]
    fn a_table_is_scored_like_its_function() {
        let cost = CostFunction::Saturating { maximum: 3.0, rate_per_s: 1.0 / 600.0 };
        let table = tabulated(&cost, 1e-4);
        let (exact, near) = (eci::cost_integral(&cost, 900.0), eci::cost_integral(&table, 900.0));
        assert!((near / exact - 1.0).abs() < 1e-4 && near != exact, "{near} {exact}");
    }
}
