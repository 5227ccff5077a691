//! Operators' plans: the operator states which targets are visited in which order; the rest is computed, and the plan
//! is checked and scored like any other (paper, section V.C: an operator is one of the planners that are compared).
//!
//! In surveillance the order is flown once, or repeated until the mission ends. Of single visits each is made in the way (manoeuvre,
//! waiting for a better time) with the highest value, given the others.
//! Bound: O(visits) of surveillance; of single visits O(visits^2 x ways of a target).

pub mod brought;

use crate::planners::single_visit;
pub use crate::planners::single_visit::OrderFault;
use apex_model::problem::{Plan, Problem, SurveillanceProblem};
use apex_planning::solver::{Environment, Solver};
use apex_planning::surveillance::scenario::Scenario;

/// The planner's name, also of imported plans.
const NAME: &str = "human";

/// Planner for an order of visits that an operator states.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Human {
    /// Names of targets in the order of visits.
    pub visits: Vec<String>,
    /// True to repeat the order until the mission ends.
    pub repeat: bool,
}

impl Solver for Human {
    fn name(&self) -> &'static str {
        NAME
    }

    fn serves(&self, _: &Problem) -> bool {
        true
    }

    fn solve(&self, problem: &Problem, environment: &mut Environment<'_>) -> Result<Plan, String> {
        self.plan(problem, environment).map_err(|fault| fault.reason)
    }
}

impl Human {
    /// Returns the plan, as [`Solver::solve`].
    ///
    /// # Errors
    /// The first visit that cannot be made.
    pub fn plan(&self, problem: &Problem, environment: &mut Environment<'_>) -> Result<Plan, OrderFault> {
        let names: Vec<&str> = match problem {
            Problem::Surveillance(problem) => problem.targets.iter().map(|target| target.name.as_str()).collect(),
            Problem::SingleVisit(problem) => problem.targets.iter().map(|target| target.name.as_str()).collect(),
        };
        let order = self.visits.iter().enumerate().map(|(visit, name)| {
            let index = names.iter().position(|known| known == name);
            index.ok_or_else(|| {
                let reason = format!("there is no target `{name}`; there are {}", names.join(", "));
                OrderFault { visit: Some(visit), reason }
            })
        });
        let order = order.collect::<Result<Vec<usize>, OrderFault>>()?;
        match problem {
            Problem::Surveillance(problem) => self.watched(problem, &order, environment),
            Problem::SingleVisit(_) if self.repeat => Err("single visits are not repeated: leave `repeat` out".into()),
            Problem::SingleVisit(problem) => {
                let order: Vec<(usize, Option<usize>)> = order.into_iter().map(|target| (target, None)).collect();
                single_visit::in_order(problem, self.name(), &order, environment).map(Plan::SingleVisit)
            }
        }
    }

    fn watched(
        &self,
        problem: &SurveillanceProblem,
        order: &[usize],
        environment: &mut Environment<'_>,
    ) -> Result<Plan, OrderFault> {
        let scenario = Scenario::new(problem)?;
        let flown = scenario.flown(order.iter().copied());
        if let Some(name) = self.visits.get(flown.len()) {
            let number = flown.len() + 1;
            let reason = format!("visit {number}, of {name}, cannot be made: it would end after the flight has to");
            return Err(OrderFault { visit: Some(flown.len()), reason });
        }
        let plan = match self.repeat {
            true => scenario.cycle_plan(self.name(), order),
            false => scenario.plan(self.name(), order.iter().copied()),
        };
        scenario.charge(0, environment.budget);
        Ok(Plan::Surveillance(plan))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use apex_planning::examples::single_visit as fires;
    use apex_planning::examples::surveillance as examples;
    use apex_planning::solver::WorkBudget;

    fn solve(solver: &dyn Solver, problem: &Problem) -> Result<Plan, String> {
        let mut budget = WorkBudget::new(100_000);
        let mut environment = Environment { seed: 1, budget: &mut budget, report: &mut |_| {}, previous: None };
        let plan = solver.solve(problem, &mut environment)?;
        assert_eq!(apex_planning::checker::violations(problem, &plan), Vec::<String>::new());
        Ok(plan)
    }

    fn fault(solver: &Human, problem: &Problem) -> OrderFault {
        let mut budget = WorkBudget::new(100_000);
        let mut environment = Environment { seed: 1, budget: &mut budget, report: &mut |_| {}, previous: None };
        solver.plan(problem, &mut environment).unwrap_err()
    }

    fn human(visits: &[&str], repeat: bool) -> Human {
        Human { visits: visits.iter().map(ToString::to_string).collect(), repeat }
    }

    #[test]
    fn a_round_drawn_by_an_operator_is_flown_until_the_end_and_scored() {
        let problem = examples::random(4, 2);
        let names: Vec<&str> = problem.targets.iter().map(|target| target.name.as_str()).collect();
        let asked = Problem::Surveillance(problem.clone());
        let of = |order: &[&str], repeat| match solve(&human(order, repeat), &asked).unwrap() {
            Plan::Surveillance(plan) => plan,
            Plan::SingleVisit(_) => panic!("the plan is of another kind"),
        };
        let (round, once) = (of(&names, true), of(&names, false));
        assert_eq!((round.solver.as_str(), round.cycle.len(), once.visits.len()), ("human", 4, 4));
        assert!(round.visits.len() > 4 && round.expected_cost < once.expected_cost);
        // The reasons are those of a list of visits: no planner made a cycle.
        let reasons = of(&names[..1], false).left_out;
        assert!(reasons.len() == 3 && !reasons.iter().any(|left_out| left_out.reason.contains("cycle")), "{reasons:?}");
        let unknown = fault(&human(&[names[0], "atlantis"], false), &asked);
        assert!(unknown.reason.starts_with("there is no target `atlantis`; there are "), "{unknown:?}");
        assert_eq!(unknown.visit, Some(1));
        let long: Vec<&str> = names.iter().copied().cycle().take(1_000).collect();
        let late = fault(&human(&long, false), &asked);
        assert!(late.reason.contains("would end after the flight has to"), "{late:?}");
        assert!(late.reason.starts_with(&format!("visit {}, of ", late.visit.unwrap() + 1)), "{late:?}");
    }

    #[test]
    fn fires_in_the_order_of_an_operator_are_seen_in_the_best_way() {
        let asked = Problem::SingleVisit(fires::western_states(40_000.0));
        let score = |plan: &Plan| match plan {
            Plan::SingleVisit(plan) => plan.score,
            Plan::Surveillance(_) => f64::NAN,
        };
        let best = solve(&single_visit::SingleVisit, &asked).unwrap();
        let order = best.targets();
        let again = solve(&human(&order, false), &asked).unwrap();
        assert_eq!(again.targets(), order);
        assert!(score(&again) > 0.9 * score(&best), "{} {}", score(&again), score(&best));
        let mut twice = order.clone();
        twice.push(order[0]);
        let refused = fault(&human(&twice, false), &asked);
        assert!(refused.reason.contains(&format!("visit {}, of {}", twice.len(), order[0])), "{refused:?}");
        assert_eq!(refused.visit, Some(order.len()));
        assert_eq!(fault(&human(&order, true), &asked).visit, None);
    }

    #[test]
    fn a_gate_of_no_value_may_come_first() {
        let mut problem = fires::western_states(86_400.0);
        let names: Vec<String> = problem.targets.iter().take(3).map(|target| target.name.clone()).collect();
        problem.targets[0].value = 0.0;
        problem.precedence = vec![(names[0].clone(), names[1].clone())];
        let order: Vec<&str> = names.iter().map(String::as_str).collect();
        let plan = solve(&human(&order, false), &Problem::SingleVisit(problem)).unwrap();
        assert_eq!(plan.targets(), order);
    }
}
