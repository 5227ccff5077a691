//! User-defined costs: any function of the age of an event, evaluated where needed and checked against the rules of
//! costs.
//!
//! The rules are checked only at the ages at which the function is evaluated. There it must be finite, not negative and, except for
//! rounding, nowhere less than at a younger evaluated age.

use crate::eci::{self, ExpectedCost, Likelihoods, TargetCost};
use crate::survival;
use apex_model::problem::{SurveillanceProblem, SurveillanceTarget, SurveillanceVisit};
use std::collections::BTreeMap;

/// Share of a cost by which a function may fall before this no longer counts as rounding.
pub(crate) const ROUNDING: f64 = 1e-12;

/// Maximum number of calls of one target's cost function in one score.
pub const CALLS_MAX: usize = 4_000_000;

/// Cost of an event by its age in seconds, or an error message.
pub type Function<'a> = dyn FnMut(f64) -> Result<f64, String> + 'a;

/// A user-defined cost.
pub struct UserCost<'a> {
    /// The cost by age.
    pub function: Box<Function<'a>>,
    /// Known ages at which the function jumps or has a kink; they reduce the calls of integrals.
    pub jumps_s: Vec<f64>,
}

/// Returns the function's cost at `age_s`.
///
/// # Errors
/// An error message if the cost is missing, negative or not finite.
pub(crate) fn ask(function: &mut Function<'_>, age_s: f64) -> Result<f64, String> {
    let cost =
        function(age_s).map_err(|why| format!("the cost of an event {age_s} s old cannot be computed: {why}"))?;
    if !cost.is_finite() || cost < 0.0 {
        return Err(format!("the cost of an event {age_s} s old is {cost}; a cost is finite and not negative"));
    }
    Ok(cost)
}

/// Returns the error message for a function that falls from the younger to the older of two ages, given with their costs.
pub(crate) fn falls((young_s, young): (f64, f64), (old_s, old): (f64, f64)) -> String {
    format!("the cost of an event falls from {young} at {young_s} s to {old} at {old_s} s; cost never falls with age")
}

/// Returns the expected cost of ignorance of `visits`, in any order. Targets named in `own` have those costs instead of their families'
/// costs, integrated by quadrature to [`eci::QUADRATURE_TOLERANCE`]. `likelihoods` states whether all events or only first ones count.
///
/// # Errors
/// An error message that names the target: an unknown target, a visit without a time, or an invalid cost with its age.
pub fn expected_cost_with(
    problem: &SurveillanceProblem,
    visits: &[SurveillanceVisit],
    own: &mut BTreeMap<String, UserCost<'_>>,
    likelihoods: Likelihoods,
) -> Result<ExpectedCost, String> {
    let known = |name: &str| problem.targets.iter().any(|target| target.name == name);
    let named = visits.iter().map(|visit| &visit.target).chain(own.keys());
    if let Some(stranger) = named.into_iter().find(|name| !known(name)) {
        let names: Vec<&str> = problem.targets.iter().map(|target| target.name.as_str()).take(12).collect();
        return Err(format!("{stranger} is not a target of the problem; targets are {}", names.join(", ")));
    }
    if let Some(visit) = visits.iter().find(|visit| !visit.end_s.is_finite()) {
        return Err(format!("a visit of {} ends at {}, which is not a time", visit.target, visit.end_s));
    }
    let cost_of = |target: &SurveillanceTarget| {
        let mut ends_s: Vec<f64> =
            visits.iter().filter(|visit| visit.target == target.name).map(|visit| visit.end_s).collect();
        ends_s.sort_by(f64::total_cmp);
        match own.get_mut(&target.name) {
            None => target_cost(target, ends_s, problem.horizon_s, likelihoods),
            Some(cost) => target_cost_of(target, cost, ends_s, problem.horizon_s, likelihoods),
        }
        .map_err(|why| format!("{}: {why}", target.name))
    };
    let targets = problem.targets.iter().map(cost_of).collect::<Result<Vec<TargetCost>, String>>()?;
    Ok(ExpectedCost { total: targets.iter().map(|target| target.expected_cost).sum(), targets })
}

/// Returns the cost of a target whose cost function is of the model's families.
fn target_cost(
    target: &SurveillanceTarget,
    ends_s: Vec<f64>,
    horizon_s: f64,
    likelihoods: Likelihoods,
) -> Result<TargetCost, String> {
    eci::over_intervals(target, ends_s, horizon_s, |from_s, until_s| match likelihoods {
        Likelihoods::Added => Ok(eci::interval_cost(target, from_s, until_s)),
        Likelihoods::Survival => survival::interval_cost(target, from_s, until_s),
    })
}

fn target_cost_of(
    target: &SurveillanceTarget,
    cost: &mut UserCost<'_>,
    ends_s: Vec<f64>,
    horizon_s: f64,
    likelihoods: Likelihoods,
) -> Result<TargetCost, String> {
    let UserCost { function, jumps_s } = cost;
    let mut asked: Vec<(f64, f64)> = Vec::new();
    let mut trouble: Option<String> = None;
    let mut watched = |age_s: f64| {
        // After the first error the function is not called again: a sum with NaN ends the integral.
        if trouble.is_some() {
            return f64::NAN;
        }
        if asked.len() >= CALLS_MAX {
            trouble =
                Some(format!("integrating the cost takes more than {CALLS_MAX} calls; name the ages of its jumps"));
            return f64::NAN;
        }
        match ask(function.as_mut(), age_s) {
            Ok(cost) => {
                asked.push((age_s, cost));
                cost
            }
            Err(why) => {
                trouble = Some(why);
                f64::NAN
            }
        }
    };
    let total = eci::over_intervals(target, ends_s, horizon_s, |from_s, until_s| {
        let interval_cost = match likelihoods {
            Likelihoods::Added => eci::interval_cost_of,
            Likelihoods::Survival => survival::interval_cost_of,
        };
        interval_cost(&target.rate, &mut watched, jumps_s, from_s, until_s)
    });
    match trouble.or_else(|| fall(asked)) {
        Some(why) => Err(why),
        None => total,
    }
}

/// Returns the error message for the first fall of a function among all evaluated ages; `None` if it never falls.
fn fall(mut asked: Vec<(f64, f64)>) -> Option<String> {
    asked.sort_by(|(one_s, _), (other_s, _)| one_s.total_cmp(other_s));
    let mut highest = (0.0, 0.0);
    for (age_s, cost) in asked {
        if cost < highest.1 * (1.0 - ROUNDING) {
            return Some(falls(highest, (age_s, cost)));
        }
        if cost > highest.1 {
            highest = (age_s, cost);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::eci::{cost_at, expected_cost, tests::families};
    use apex_model::problem::{CostFunction, EventRate, Position, TravelTimes};
    use proptest::prelude::*;

    fn problem(cost: CostFunction, rate: EventRate) -> SurveillanceProblem {
        let target = |name: &str, cost| SurveillanceTarget {
            name: name.to_string(),
            position: Position::default(),
            dwell_s: 0.0,
            rate: rate.clone(),
            cost,
            initial_age_s: 120.0,
        };
        SurveillanceProblem {
            targets: vec![target("a", cost), target("b", CostFunction::Linear { cost_per_s: 1.0 })],
            travel: TravelTimes::default(),
            horizon_s: 3_600.0,
            return_to_base: false,
            endurance_s: None,
        }
    }

    fn visits(ends: &[(&str, f64)]) -> Vec<SurveillanceVisit> {
        ends.iter()
            .map(|(target, end_s)| SurveillanceVisit { target: (*target).to_string(), arrive_s: *end_s, end_s: *end_s })
            .collect()
    }

    fn scored(
        problem: &SurveillanceProblem,
        ends: &[(&str, f64)],
        cost: impl FnMut(f64) -> Result<f64, String>,
    ) -> Result<ExpectedCost, String> {
        let own = UserCost { function: Box::new(cost), jumps_s: Vec::new() };
        expected_cost_with(problem, &visits(ends), &mut BTreeMap::from([("a".to_string(), own)]), Likelihoods::Added)
    }

    proptest! {
        #[test]
        fn a_family_written_as_a_function_costs_the_same(
            cost in families(), rate in 0.0..2.0f64, first in 0.0..4_000.0f64, second in 0.0..4_000.0f64,
        ) {
            let rate = EventRate { steps: vec![(0.0, rate), (1_000.0, 1.0)] };
            let problem = problem(cost.clone(), rate);
            let ends = [("a", first.max(second)), ("b", 70.0), ("a", first.min(second))];
            let with = scored(&problem, &ends, |age_s| Ok(cost_at(&cost, age_s))).unwrap();
            let mut sorted = visits(&ends);
            sorted.sort_by(|one, other| one.end_s.total_cmp(&other.end_s));
            let exact = expected_cost(&problem, &sorted);
            prop_assert!((with.total - exact.total).abs() <= 1e-9 * exact.total.max(1.0), "{with:?} {exact:?}");
            prop_assert_eq!(&with.targets[1], &exact.targets[1]);
            prop_assert_eq!(with.targets[0].observations, exact.targets[0].observations);
            prop_assert_eq!(with.targets[0].longest_gap_s, exact.targets[0].longest_gap_s);
            let own = UserCost { function: Box::new(|age_s| Ok(cost_at(&cost, age_s))), jumps_s: Vec::new() };
            let mut own = BTreeMap::from([("a".to_string(), own)]);
            let first = expected_cost_with(&problem, &visits(&ends), &mut own, Likelihoods::Survival).unwrap();
            let exact = survival::expected_cost(&problem, &sorted).unwrap();
            prop_assert!((first.total - exact.total).abs() <= 1e-9 * exact.total.max(1.0), "{first:?} {exact:?}");
        }
    }

    #[test]
    fn an_error_is_reported_with_target_and_age() {
        let problem = problem(CostFunction::Linear { cost_per_s: 1.0 }, EventRate::constant(1.0));
        let told = |cost: &dyn Fn(f64) -> f64| scored(&problem, &[("a", 60.0)], |age_s| Ok(cost(age_s))).unwrap_err();
        assert!(told(&|_| -1.0).starts_with("a: the cost of an event "), "{}", told(&|_| -1.0));
        assert!(told(&|_| -1.0).contains(" s old is -1; a cost is finite and not negative"));
        assert!(told(&|_| f64::INFINITY).contains("is inf; a cost is finite"));
        assert!(told(&|age_s| 5_000.0 - age_s).starts_with("a: the cost of an event falls from "));
        assert!(told(&|age_s| libm::sin(age_s) + 1.0).contains("cost never falls"));
        let mut calls = 0;
        let raises = scored(&problem, &[], |_| {
            calls += 1;
            Err("no idea".to_string())
        });
        assert!(raises.unwrap_err().contains("s old cannot be computed: no idea"));
        assert_eq!(calls, 1, "the function is not called again after a failure");
    }

    #[test]
    fn strangers_and_times_that_are_invalid_are_reported() {
        let problem = problem(CostFunction::Linear { cost_per_s: 1.0 }, EventRate::constant(1.0));
        let told = |ends: &[(&str, f64)]| scored(&problem, ends, Ok).unwrap_err();
        assert_eq!(told(&[("barn", 1.0)]), "barn is not a target of the problem; targets are a, b");
        assert!(told(&[("b", f64::NAN)]).contains("a visit of b ends at NaN"));
        let own = UserCost { function: Box::new(Ok), jumps_s: Vec::new() };
        let unknown =
            expected_cost_with(&problem, &[], &mut BTreeMap::from([("c".to_string(), own)]), Likelihoods::Added);
        assert!(unknown.unwrap_err().contains("c is not a target"));
    }
}
