//! Claims of planners and proofs about a random surveillance problem, compared with the truth.

use crate::chance::Chance;
use crate::{watch_problems, watch_words};
use apex_model::problem::{Plan, Problem, SurveillancePlan, SurveillanceProblem};
use apex_planning::meter::Meter;
use apex_planning::solver::{Environment, Solver, WorkBudget};
use apex_solvers::bounds;
use apex_solvers::planners::human::Human;

/// Share within which costs are equal.
const SAME: f64 = 1e-7;

/// Returns the false claims about the problem of this seed.
pub(crate) fn differences(seed: u64) -> Vec<String> {
    let mut chance = Chance::new(seed ^ 0x5157);
    let problem = watch_problems::problem(&mut chance);
    let mut found = of_problem(&mut chance, &problem);
    let text = || serde_json::to_string(&Problem::Surveillance(problem.clone())).expect("JSON");
    found.iter_mut().for_each(|difference| *difference = format!("{difference}\n  {}", text()));
    found
}

/// Returns the claims about a given problem.
pub(crate) fn of_problem(chance: &mut Chance, problem: &SurveillanceProblem) -> Vec<String> {
    let changes = problem.targets.iter().flat_map(|target| target.rate.steps.iter().map(|(at_s, _)| *at_s));
    let change_s = changes.filter(|at_s| *at_s > 0.0).fold(0.3 * problem.horizon_s, f64::min);
    let waits_s = [0.0, 0.17 * problem.horizon_s, change_s];
    let Some((without, waiting)) = watch_words::least_costs(problem, &waits_s, 1e-9) else { return Vec::new() };
    let mut found = Vec::new();
    let posed = Problem::Surveillance(problem.clone());
    let units = chance.of(&[1, 500, 2_000]);
    let solvers = apex_solvers::solvers();
    let serving: Vec<_> = solvers.iter().filter(|solver| solver.serves(&posed)).collect();
    let solver = serving[chance.below(serving.len())];
    match solved(&**solver, &posed, units) {
        Ok(plan) => found.extend(claims(problem, plan, (without, waiting), solver.name(), chance)),
        Err(why) => {
            let idle = watch_words::cost_of(problem, &[]);
            if without < idle * (1.0 - SAME) {
                found.push(format!("{}: no plan, and {without} is possible, idle {idle}: {why}", solver.name()));
            }
        }
    }
    let visits = (0..=chance.below(2)).map(|_| format!("T{}", chance.below(problem.targets.len()))).collect();
    if let Ok(plan) = solved(&Human { visits, repeat: chance.percent(50) }, &posed, units) {
        found.extend(claims(problem, plan, (without, waiting), "brought", chance));
    }
    let mut budget = WorkBudget::new(chance.of(&[10, 1_000, 5_000]));
    let bound = bounds::expected_cost_within(problem, &mut Meter::new(&mut budget));
    let verified = bounds::verified(problem, &bound.proof);
    for (number, what) in [(bound.expected_cost, "bound"), (verified, "verified bound")] {
        if number > waiting + SAME * waiting.max(1.0) {
            found.push(format!("{what} of all flights {number}, and {waiting} is possible; {:?}", bound.proof));
        }
    }
    found
}

fn solved(solver: &dyn Solver, problem: &Problem, units: u64) -> Result<SurveillancePlan, String> {
    let mut budget = WorkBudget::new(units);
    let mut environment = Environment { seed: 1, budget: &mut budget, report: &mut |_| {}, previous: None };
    match solver.solve(problem, &mut environment)? {
        Plan::Surveillance(plan) => Ok(plan),
        Plan::SingleVisit(_) => panic!("the plan is of another kind"),
    }
}

fn claims(
    problem: &SurveillanceProblem,
    plan: SurveillancePlan,
    (without, waiting): (f64, f64),
    who: &str,
    chance: &mut Chance,
) -> Vec<String> {
    let mut found = Vec::new();
    let same = |least: f64| SAME * least.max(1.0);
    let visits: Vec<(String, f64)> = plan.visits.iter().map(|visit| (visit.target.clone(), visit.end_s)).collect();
    let cost = watch_words::cost_of(problem, &visits);
    if (cost - plan.expected_cost).abs() > same(cost) {
        found.push(format!("{who}: the plan claims {} and costs {cost}", plan.expected_cost));
    }
    // The enumerated flights end a margin before the limit, which plans may use up; hence the tolerance.
    if plan.expected_cost < without - 1e-6 * without.max(1.0) - 1e-6 {
        found.push(format!("{who}: the plan claims {} where no word costs less than {without}", plan.expected_cost));
    }
    let mut proven = Plan::Surveillance(plan);
    let mut budget = WorkBudget::new(chance.of(&[100, 3_000, 20_000]));
    let posed = Problem::Surveillance(problem.clone());
    if let Err(contradiction) = apex_solvers::prove(&posed, &mut proven, &mut Meter::new(&mut budget)) {
        return vec![format!("{who}: {contradiction}")];
    }
    if let Plan::Surveillance(plan) = proven
        && let Some(bound) = plan.expected_cost_bound
    {
        let (cost, visits) = (plan.expected_cost, visits.len());
        if bound > without + same(without) {
            found.push(format!(
                "{who}: the bound is {bound}, {without} is possible; the plan costs {cost}, {visits} visits"
            ));
        }
        // A claim that nothing is better includes flights that wait.
        if (cost - bound).abs() < 1e-6 * cost && waiting < cost * (1.0 - 1e-5) {
            found.push(format!("{who}: {cost} is claimed to be the least, and {waiting} is possible with waiting"));
        }
    }
    found
}
