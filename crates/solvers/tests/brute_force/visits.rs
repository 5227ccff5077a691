//! Claims of planners and proofs about a random single-visit problem, compared with the truth.

use crate::chance::Chance;
use crate::{visit_orders, visit_problems};
use apex_model::problem::{Plan, Problem, SingleVisitPlan, SingleVisitProblem};
use apex_planning::meter::Meter;
use apex_planning::solver::{Environment, Solver, WorkBudget};
use apex_solvers::planners::human::Human;
use apex_solvers::planners::single_visit::SingleVisit;

/// Margin with which times must be kept, negative: a tolerance, because `apex_planning::checker` allows a microsecond.
const LENIENT_S: f64 = -1e-5;
/// Work that suffices to enumerate the orders of seven targets.
const ENOUGH: u64 = 1_000_000;
/// Share within which sums of worths are equal.
const SAME: f64 = 1e-9;

/// Returns the false claims about the problem of this seed.
pub(crate) fn differences(seed: u64) -> Vec<String> {
    let mut chance = Chance::new(seed);
    let problem = visit_problems::problem(&mut chance);
    let mut found = of_problem(&mut chance, &problem);
    let text = || serde_json::to_string(&Problem::SingleVisit(problem.clone())).expect("JSON");
    found.iter_mut().for_each(|difference| *difference = format!("{difference}\n  {}", text()));
    found
}

/// Returns the claims about a given problem, by the planner and by poor plans of operators.
pub(crate) fn of_problem(chance: &mut Chance, problem: &SingleVisitProblem) -> Vec<String> {
    let reached = visit_orders::greatest_benefits(problem, 0.0);
    let most = visit_orders::greatest_benefits(problem, LENIENT_S);
    let mut found = Vec::new();
    let posed = Problem::SingleVisit(problem.clone());
    let units = chance.of(&[1, 300, 3_000, 10_000]);
    match solved(&SingleVisit, &posed, units) {
        Ok(plan) => found.extend(claims(problem, plan, (reached, most), "planned")),
        Err(why) if reached > -visit_orders::all_missed(problem) => {
            found.push(format!("no plan, and {reached} is possible: {why}"))
        }
        Err(_) => {}
    }
    // All orders of few targets are compared; without costs the best one has the greatest benefits.
    let is_enumerated = problem.targets.len() <= 7 && problem.targets.iter().all(|target| target.timing.is_empty());
    let is_free = problem.crew.is_empty() && problem.failure.probability_per_hour <= 0.0;
    if problem.travel.is_some() && is_enumerated && is_free {
        match solved(&SingleVisit, &posed, ENOUGH) {
            Ok(plan) if plan.benefits < reached - SAME * scale_of(problem, reached) => {
                found.push(format!("planned {} with enough budget, and {reached} is possible", plan.benefits));
            }
            Ok(_) | Err(_) => {}
        }
    }
    let poor = Human { visits: order(chance, problem), repeat: false };
    if let Ok(plan) = solved(&poor, &posed, units) {
        found.extend(claims(problem, plan, (reached, most), "brought"));
    }
    found
}

fn solved(solver: &dyn Solver, problem: &Problem, units: u64) -> Result<SingleVisitPlan, String> {
    let mut budget = WorkBudget::new(units);
    let mut environment = Environment { seed: 1, budget: &mut budget, report: &mut |_| {}, previous: None };
    match solver.solve(problem, &mut environment)? {
        Plan::SingleVisit(plan) => Ok(plan),
        Plan::Surveillance(_) => panic!("the plan is of another kind"),
    }
}

/// Returns some targets in random order.
fn order(chance: &mut Chance, problem: &SingleVisitProblem) -> Vec<String> {
    let mut names: Vec<String> = problem.targets.iter().map(|target| target.name.clone()).collect();
    (1..names.len()).for_each(|index| names.swap(index, chance.below(index + 1)));
    names.truncate(1 + chance.below(2));
    names
}

/// Returns the size of the sums whose rounding is tolerated.
fn scale_of(problem: &SingleVisitProblem, benefits: f64) -> f64 {
    (benefits.abs() + visit_orders::all_missed(problem)).max(1.0)
}

fn claims(
    problem: &SingleVisitProblem,
    mut plan: SingleVisitPlan,
    (reached, most): (f64, f64),
    who: &str,
) -> Vec<String> {
    let posed = Problem::SingleVisit(problem.clone());
    let mut found: Vec<String> = Vec::new();
    let scale = SAME * scale_of(problem, most);
    let visits: Vec<(String, usize, f64)> =
        plan.visits.iter().map(|visit| (visit.target.clone(), visit.manoeuvre, visit.begin_s)).collect();
    let worth = visit_orders::worth_of(problem, &visits);
    if (worth - plan.benefits).abs() > scale {
        found.push(format!("{who}: the plan claims {} and is worth {worth}", plan.benefits));
    }
    if plan.benefits > most + scale {
        found.push(format!("{who}: the plan claims {} where no order is worth more than {most}", plan.benefits));
    }
    let mut bounded = |plan: &SingleVisitPlan, when: &str| {
        if let Some(bound) = plan.benefits_bound.filter(|bound| *bound < reached - scale) {
            let worth = plan.benefits;
            found.push(format!("{who}: {when} the bound is {bound}, {reached} is possible, the plan is worth {worth}"));
        }
    };
    bounded(&plan, "at first");
    let mut proven = Plan::SingleVisit(plan.clone());
    let mut budget = WorkBudget::new(20_000);
    if let Err(contradiction) = apex_solvers::prove(&posed, &mut proven, &mut Meter::new(&mut budget)) {
        return vec![format!("{who}: {contradiction}")];
    }
    if let Plan::SingleVisit(proven) = proven {
        plan = proven;
    }
    bounded(&plan, "after the proof");
    found
}
