//! A bound that a known plan violates: bound or plan is wrong, so neither is reported.

use apex_model::problem::{Plan, Problem};
use std::fmt;

/// Share within which a value and its bound are equal: both are sums, and proofs round.
const SAME: f64 = 1e-7;

/// An internal error: a bound and a plan that contradict each other, with the data to reproduce it.
#[derive(Clone, Debug, PartialEq)]
pub struct Contradiction {
    /// The problem.
    pub problem: Box<Problem>,
    /// The plan, without the bound.
    pub plan: Box<Plan>,
    /// Value of the plan: expected cost of surveillance, benefits of single visits, or length of a tour.
    pub value: f64,
    /// The bound: no plan should have a better value.
    pub bound: f64,
}

impl Contradiction {
    /// Returns the error for a plan of this value if it is better than `bound`; `None` if the two agree. `less_is_better` for costs and
    /// lengths.
    pub fn found(
        problem: &Problem,
        plan: &Plan,
        (value, bound): (f64, f64),
        less_is_better: bool,
    ) -> Option<Contradiction> {
        let slack = SAME * value.abs().max(bound.abs()).max(SAME);
        let beyond = if less_is_better { bound - value } else { value - bound };
        // A value that is not a number is not a bound either.
        let agrees = beyond <= slack;
        let error = || Contradiction { problem: problem.clone().into(), plan: plan.clone().into(), value, bound };
        (!agrees).then(error)
    }
}

impl fmt::Display for Contradiction {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Contradiction { value, bound, .. } = self;
        write!(
            formatter,
            "internal error: a plan of value {value} is better than its bound {bound}, so one of the two is wrong"
        )
    }
}

impl std::error::Error for Contradiction {}

/// Compares the stated bound of a plan with the plan's value; a plan that violates its bound loses the bound. A remaining rounding error
/// is removed.
pub(super) fn check(problem: &Problem, plan: &mut Plan) -> Result<(), Contradiction> {
    let (value, bound, less_is_better) = match plan {
        Plan::Surveillance(plan) => (plan.expected_cost, &mut plan.expected_cost_bound, true),
        Plan::SingleVisit(plan) => (plan.benefits, &mut plan.benefits_bound, false),
    };
    let Some(stated) = *bound else { return Ok(()) };
    let rounded = if less_is_better { stated.min(value) } else { stated.max(value) };
    *bound = None;
    match Contradiction::found(problem, plan, (value, stated), less_is_better) {
        Some(contradiction) => Err(contradiction),
        None => {
            match plan {
                Plan::Surveillance(plan) => plan.expected_cost_bound = Some(rounded),
                Plan::SingleVisit(plan) => plan.benefits_bound = Some(rounded),
            }
            Ok(())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::state_at_least;
    use super::*;
    use apex_planning::examples::surveillance as examples;
    use apex_planning::surveillance::scenario::Scenario;

    #[test]
    fn a_bound_beyond_a_known_plan_is_an_error_and_is_not_stated() {
        let problem = examples::random(4, 2);
        let plan = Scenario::new(&problem).unwrap().cycle_plan("test", &[0, 1, 2, 3]);
        let (cost, posed) = (plan.expected_cost, Problem::Surveillance(problem));
        let mut plan = Plan::Surveillance(plan);
        let error = state_at_least(&posed, &mut plan, |_| 1.01 * cost).unwrap_err();
        assert_eq!((error.value, error.bound, *error.problem == posed), (cost, 1.01 * cost, true));
        assert!(error.to_string().starts_with("internal error: a plan of value "), "{error}");
        let stated = |plan: &Plan| match plan {
            Plan::Surveillance(plan) => plan.expected_cost_bound,
            Plan::SingleVisit(_) => None,
        };
        assert_eq!(stated(&plan), None);
        state_at_least(&posed, &mut plan, |_| cost * (1.0 + 1e-9)).unwrap();
        assert_eq!(stated(&plan), Some(cost), "a rounding error is not a contradiction");
        let no_number = state_at_least(&posed, &mut plan, |_| f64::NAN);
        assert!(no_number.is_ok(), "a bound that is not a number is ignored");
    }
}
