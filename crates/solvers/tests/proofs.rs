//! Proofs of single-visit plans at full size, with what they remember in use.
#![allow(clippy::expect_used, clippy::panic, reason = "a test")]

use apex_model::problem::{Plan, Problem};
use apex_model::solver::{Budget, Environment, Solver, WorkBudget};
use apex_solvers::formats::{self, generate};
use apex_solvers::single_visit::SingleVisit;

/// A hundred targets with narrow windows: the proof ends long before the budget does. Of `c107` it finds the best route too,
/// which this seed's first cooling misses by a visit or two.
#[test]
fn a_hundred_targets_with_narrow_windows_are_proven_soon() {
    let known = [("c107", 570.0), ("r107", 296.0), ("rc103", 360.0), ("r201", 691.0), ("pr07", 515.0)];
    for (name, text) in generate::windows_suite() {
        let Some((_, most)) = known.iter().find(|(other, _)| name == *other) else { continue };
        let problem = Problem::SingleVisit(formats::read(&name, &text).expect("the project's own problem").problem);
        let mut budget = WorkBudget::new(1_000_000);
        let mut environment = Environment { seed: 2, budget: &mut budget, report: &mut |_| {}, previous: None };
        let plan = SingleVisit.solve(&problem, &mut environment).expect("a plan");
        assert_eq!(apex_solvers::checker::violations(&problem, &plan), Vec::<String>::new());
        let Plan::SingleVisit(plan) = plan else { panic!("of another kind") };
        assert_eq!((plan.benefits, plan.benefits_bound), (*most, Some(*most)), "{name}: {}", plan.summary);
        assert!(budget.used() < 500_000, "{name}: {} units", budget.used());
    }
}
