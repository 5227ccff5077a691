//! Plans from outside: drawn by an operator, or edited after a planner made them (paper, section V.C: an operator is one of the
//! planners).
//!
//! The operator's choices are kept; everything derived from them is computed here. [`scored`] keeps visits with their times and computes
//! value, cost and left-out targets again; [`retimed`] keeps only the order (for single visits the manoeuvres too) and computes the
//! times. Neither states that the plan may be flown: the checker decides that.
//! Bound: O(visits x targets), and what [`Human`] takes.

use super::{Human, NAME};
use crate::planners::single_visit;
use apex_metrics::eci;
use apex_model::problem::{
    LeftOut, Plan, Problem, SingleVisitPlan, SingleVisitProblem, SurveillancePlan, SurveillanceProblem,
};
use apex_planning::obstacle::LeftOutReason;
use apex_planning::solver::{Environment, Solver};
use apex_planning::surveillance::scenario::Scenario;

/// Reason for left-out targets if the plan states none.
const NOT_WANTED: &str = "the given plan does not visit it";

/// Returns the plan with its visits and times unchanged, by planner `human`, and with all derived figures computed.
///
/// # Errors
/// If the plan answers another kind of problem, or a visit names something that does not exist.
pub fn scored(problem: &Problem, plan: &Plan) -> Result<Plan, String> {
    match (problem, plan) {
        (Problem::Surveillance(problem), Plan::Surveillance(plan)) => {
            watched(problem, plan.clone()).map(Plan::Surveillance)
        }
        (Problem::SingleVisit(problem), Plan::SingleVisit(plan)) => {
            visited(problem, plan.clone()).map(Plan::SingleVisit)
        }
        _ => Err(another_kind(problem)),
    }
}

/// Returns a plan with the order of the given one and new times, by planner `human`. If the visits are laps of the plan's cycle, or there
/// are none, the cycle is flown repeatedly; otherwise the edited visits are kept and the cycle is dropped.
///
/// # Errors
/// Like [`scored`]; also the reason for which a visit is impossible.
pub fn retimed(problem: &Problem, plan: &Plan, environment: &mut Environment<'_>) -> Result<Plan, String> {
    match (problem, plan) {
        (Problem::Surveillance(of), Plan::Surveillance(plan)) => {
            let visits = plan.visits.iter().map(|visit| visit.target.clone());
            known(of, plan.visits.iter().map(|visit| &visit.target))?;
            let repeat = is_flown_in_laps(of, plan)?;
            let visits: Vec<String> = if repeat { plan.cycle.clone() } else { visits.collect() };
            Human { visits, repeat }.solve(problem, environment)
        }
        (Problem::SingleVisit(problem), Plan::SingleVisit(plan)) => {
            let mut order = Vec::new();
            for (number, visit) in (1_usize..).zip(&plan.visits) {
                order.push((target_of(problem, number, &visit.target, visit.manoeuvre)?, Some(visit.manoeuvre)));
            }
            let plan = single_visit::in_order(problem, NAME, &order, environment);
            plan.map(Plan::SingleVisit).map_err(|fault| fault.reason)
        }
        _ => Err(another_kind(problem)),
    }
}

/// Returns true if the visits are those of the plan's cycle, flown until the flight must end. For a cycle without visits they are derived
/// from it.
fn is_flown_in_laps(problem: &SurveillanceProblem, plan: &SurveillancePlan) -> Result<bool, String> {
    if plan.cycle.is_empty() {
        return Ok(false);
    }
    known(problem, plan.cycle.iter())?;
    let laps = plan.cycle.iter().cycle();
    if !plan.visits.iter().zip(laps).all(|(visit, name)| visit.target == *name) {
        return Ok(false);
    }
    let index = |name: &String| problem.targets.iter().position(|target| target.name == *name);
    let word = plan.cycle.iter().filter_map(index).collect::<Vec<usize>>().into_iter().cycle();
    Ok(plan.visits.is_empty() || plan.visits.len() >= Scenario::new(problem)?.flown(word).len())
}

fn another_kind(problem: &Problem) -> String {
    match problem {
        Problem::Surveillance(_) => "it is a plan of single visits, but the problem is one of surveillance",
        Problem::SingleVisit(_) => "it is a plan of surveillance, but the problem is one of single visits",
    }
    .to_string()
}

fn unknown<'a>(number: usize, name: &str, known: impl Iterator<Item = &'a str>) -> String {
    let known: Vec<&str> = known.collect();
    format!("visit {number} names `{name}`, which is not a target; the targets are {}", known.join(", "))
}

/// Checks that the visits name known targets.
fn known<'a>(problem: &SurveillanceProblem, visits: impl Iterator<Item = &'a String>) -> Result<(), String> {
    let names = || problem.targets.iter().map(|target| target.name.as_str());
    let strange = |name: &&String| !names().any(|known| known == name.as_str());
    let found = visits.zip(1_usize..).find(|(name, _)| strange(name));
    found.map_or(Ok(()), |(name, number)| Err(unknown(number, name, names())))
}

/// Returns the index of a visit's target.
fn target_of(problem: &SingleVisitProblem, number: usize, name: &str, manoeuvre: usize) -> Result<usize, String> {
    let names = || problem.targets.iter().map(|target| target.name.as_str());
    let found = names().position(|known| known == name).ok_or_else(|| unknown(number, name, names()))?;
    let ways = problem.targets.get(found).map_or(0, |target| target.manoeuvres.len());
    if manoeuvre >= ways {
        return Err(format!(
            "visit {number}, of {name}, has manoeuvre {manoeuvre}, but its target has {ways}, numbered from 0"
        ));
    }
    Ok(found)
}

/// Returns the targets that are not visited, each with the reason in the given plan or, without one, [`NOT_WANTED`].
fn left_out<'a>(
    names: impl Iterator<Item = &'a str>,
    is_visited: impl Fn(&str) -> bool,
    given: &[LeftOut],
) -> Vec<LeftOut> {
    let left_out = |name: &str| {
        let given = given.iter().find(|left_out| left_out.target == name).cloned();
        given.unwrap_or_else(|| LeftOutReason::from(NOT_WANTED).of(name.to_string()))
    };
    names.filter(|name| !is_visited(name)).map(left_out).collect()
}

fn watched(problem: &SurveillanceProblem, plan: SurveillancePlan) -> Result<SurveillancePlan, String> {
    known(problem, plan.visits.iter().map(|visit| &visit.target))?;
    let names = || problem.targets.iter().map(|target| target.name.as_str());
    let index = |name: &str| names().position(|known| known == name);
    let cycle = if is_flown_in_laps(problem, &plan)? { plan.cycle } else { Vec::new() };
    let last = plan.visits.last().and_then(|visit| Some((index(&visit.target)?, visit.end_s)));
    let home_s = || last.map_or(0.0, |(target, end_s)| end_s + problem.travel.to_base_at(target, end_s));
    let expected_cost = eci::expected_cost(problem, &plan.visits).total;
    let visited = |name: &str| plan.visits.iter().any(|visit| visit.target == name);
    let left_out = left_out(names(), visited, &plan.left_out);
    let summary = format!(
        "{} visits to {} of {} targets in {:.0} s; expected cost of ignorance {expected_cost:.4}.",
        plan.visits.len(),
        problem.targets.len() - left_out.len(),
        problem.targets.len(),
        problem.horizon_s,
    );
    Ok(SurveillancePlan {
        solver: NAME.to_string(),
        return_s: problem.return_to_base.then(home_s),
        expected_cost,
        expected_cost_bound: None,
        left_out,
        summary,
        cycle,
        visits: plan.visits,
    })
}

fn visited(problem: &SingleVisitProblem, mut plan: SingleVisitPlan) -> Result<SingleVisitPlan, String> {
    for (number, visit) in (1_usize..).zip(&mut plan.visits) {
        let target = problem.targets.get(target_of(problem, number, &visit.target, visit.manoeuvre)?);
        let manoeuvre = target.and_then(|target| Some((target, target.manoeuvres.get(visit.manoeuvre)?)));
        let Some((target, manoeuvre)) = manoeuvre else { continue };
        visit.timing = target.timing_at(visit.begin_s);
        visit.worth = target.value * manoeuvre.quality.product() * visit.timing;
    }
    let names = problem.targets.iter().map(|target| target.name.as_str());
    let left_out = left_out(names, |name| plan.visits.iter().any(|visit| visit.target == name), &plan.left_out);
    // The bound in a plan from outside may be valid for another problem only.
    let plan = SingleVisitPlan {
        solver: NAME.to_string(),
        left_out,
        benefits_bound: Some(single_visit::most(problem)),
        ..plan
    };
    Ok(single_visit::scored(problem, plan))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planners::{single_visit::SingleVisit, two_opt::TwoOpt};
    use apex_planning::checker::violations;
    use apex_planning::examples::single_visit as fires;
    use apex_planning::examples::surveillance as examples;
    use apex_planning::solver::WorkBudget;

    fn planned(solver: &dyn Solver, problem: &Problem) -> Plan {
        let mut budget = WorkBudget::new(100_000);
        let mut environment = Environment { seed: 1, budget: &mut budget, report: &mut |_| {}, previous: None };
        solver.solve(problem, &mut environment).unwrap()
    }

    fn again(problem: &Problem, plan: &Plan) -> Result<Plan, String> {
        let mut budget = WorkBudget::new(100_000);
        let mut environment = Environment { seed: 1, budget: &mut budget, report: &mut |_| {}, previous: None };
        retimed(problem, plan, &mut environment)
    }

    fn of(plan: Plan) -> SurveillancePlan {
        match plan {
            Plan::Surveillance(plan) => plan,
            Plan::SingleVisit(_) => panic!("the plan is of another kind"),
        }
    }

    #[test]
    fn a_planners_plan_brought_back_is_worth_the_same() {
        let watch = Problem::Surveillance(examples::random(5, 2));
        let visits = Problem::SingleVisit(fires::western_states(40_000.0));
        for (problem, solver) in [(&watch, &TwoOpt as &dyn Solver), (&visits, &SingleVisit)] {
            let plan = planned(solver, problem);
            let mut stale = plan.clone();
            match &mut stale {
                Plan::Surveillance(plan) => (plan.expected_cost, plan.left_out) = (1.0, Vec::new()),
                Plan::SingleVisit(plan) => (plan.score, plan.benefits, plan.fuel_used_kg) = (-1.0, 0.0, 0.0),
            }
            assert_ne!(violations(problem, &stale), Vec::<String>::new());
            for brought in [scored(problem, &stale).unwrap(), again(problem, &stale).unwrap()] {
                assert_eq!((brought.solver(), brought.targets()), ("human", plan.targets()));
                assert_eq!(violations(problem, &brought), Vec::<String>::new());
                match (&brought, &plan) {
                    (Plan::Surveillance(brought), Plan::Surveillance(plan)) => {
                        assert!((brought.expected_cost - plan.expected_cost).abs() < 1e-9 * plan.expected_cost);
                    }
                    (Plan::SingleVisit(brought), Plan::SingleVisit(plan)) => {
                        assert!(brought.score > plan.score - 1e-6, "{} {}", brought.score, plan.score);
                    }
                    _ => panic!("the plan is of another kind"),
                }
            }
        }
    }

    #[test]
    fn times_stay_as_they_are_or_are_computed_again() {
        let problem = Problem::Surveillance(examples::random(4, 2));
        let mut edited = of(planned(&TwoOpt, &problem));
        edited.cycle.clear();
        edited.visits.truncate(3);
        edited.visits[1].arrive_s -= 100.0;
        let edited = Plan::Surveillance(edited);
        let broken = violations(&problem, &scored(&problem, &edited).unwrap());
        assert!(broken.len() == 1 && broken[0].contains("on visit 2"), "{broken:?}");
        let mended = of(again(&problem, &edited).unwrap());
        assert_eq!(mended.visits.len(), 3);
        assert_eq!(violations(&problem, &Plan::Surveillance(mended)), Vec::<String>::new());
    }

    #[test]
    fn edited_visits_are_no_longer_the_cycle_that_they_came_from() {
        let problem = Problem::Surveillance(examples::random(4, 2));
        let plan = of(planned(&TwoOpt, &problem));
        assert!(plan.cycle.len() > 2 && plan.visits.len() > plan.cycle.len() + 4, "{plan:?}");
        let names =
            |plan: &SurveillancePlan| -> Vec<String> { plan.visits.iter().map(|visit| visit.target.clone()).collect() };
        let kept = of(again(&problem, &Plan::Surveillance(plan.clone())).unwrap());
        assert_eq!((&kept.cycle, names(&kept)), (&plan.cycle, names(&plan)));
        let unflown = SurveillancePlan { visits: Vec::new(), ..plan.clone() };
        assert_eq!(names(&of(again(&problem, &Plan::Surveillance(unflown)).unwrap())), names(&plan));
        // Fewer laps than the time permits, and another order that takes longer than the cycle's.
        let mut fewer = plan.clone();
        fewer.visits.truncate(plan.visits.len() - 1);
        let mut other = fewer.clone();
        other.visits.truncate(plan.visits.len() - 4);
        other.visits.swap(0, 1);
        for edited in [fewer, other] {
            let brought = again(&problem, &Plan::Surveillance(edited.clone())).unwrap();
            assert_eq!(violations(&problem, &brought), Vec::<String>::new());
            let brought = of(brought);
            assert_eq!((brought.cycle.len(), names(&brought)), (0, names(&edited)));
            let as_it_is = scored(&problem, &Plan::Surveillance(edited)).unwrap();
            assert_eq!(of(as_it_is).cycle.len(), 0);
        }
        let strange = SurveillancePlan { visits: Vec::new(), cycle: vec!["atlantis".into()], ..plan };
        let refused = again(&problem, &Plan::Surveillance(strange)).unwrap_err();
        assert!(refused.starts_with("visit 1 names `atlantis`, which is not a target"), "{refused}");
    }

    #[test]
    fn a_manoeuvre_that_an_operator_chose_is_flown() {
        let problem = fires::western_states(40_000.0);
        let asked = Problem::SingleVisit(problem.clone());
        let Plan::SingleVisit(mut edited) = planned(&SingleVisit, &asked) else {
            panic!("the plan is of another kind")
        };
        // Visits that take longer in another manoeuvre still fit.
        edited.visits.truncate(4);
        let ways = |name: &str| problem.targets.iter().find(|target| target.name == name).unwrap().manoeuvres.len();
        let at = edited.visits.iter().position(|visit| ways(&visit.target) > 1).unwrap();
        let mut flown = 0;
        for wanted in 0..ways(&edited.visits[at].target) {
            edited.visits[at].manoeuvre = wanted;
            let Ok(Plan::SingleVisit(plan)) = again(&asked, &Plan::SingleVisit(edited.clone())) else { continue };
            assert_eq!(plan.visits[at].manoeuvre, wanted);
            flown += 1;
        }
        assert!(flown > 1, "several ways can be flown");
        edited.visits[1].manoeuvre = 99;
        let refused = again(&asked, &Plan::SingleVisit(edited)).unwrap_err();
        assert!(refused.starts_with("visit 2, of ") && refused.contains("has manoeuvre 99"), "{refused}");
    }

    #[test]
    fn what_does_not_belong_is_named() {
        let problem = Problem::Surveillance(examples::random(3, 2));
        let mut plan = of(planned(&TwoOpt, &problem));
        plan.visits[1].target = "atlantis".into();
        plan.cycle.clear();
        let once = Plan::Surveillance(plan);
        let refused = scored(&problem, &once).unwrap_err();
        assert!(refused.starts_with("visit 2 names `atlantis`, which is not a target; the targets are "), "{refused}");
        assert_eq!(again(&problem, &once).unwrap_err(), refused);
        let other = Problem::SingleVisit(fires::western_states(40_000.0));
        let plan = planned(&TwoOpt, &problem);
        assert!(scored(&other, &plan).unwrap_err().contains("the problem is one of single visits"));
        assert!(again(&other, &plan).unwrap_err().contains("the problem is one of single visits"));
    }
}
