//! `apex plan`: what a mission's planner would do from the start, without flying.

use crate::mission::Mission;
use crate::mission::bookkeeping::Bookkeeping;
use crate::mission::deliberator::{Deliberation, solve, translate};
use crate::mission::problem::pose;
use crate::options::PlanOptions;
use crate::trouble::{Outcome, Trouble};
use apex_model::problem::{Plan, SingleVisitPlan, SurveillancePlan};
use apex_model::time::{Duration, Time};
use apex_model::value::Value;

/// Deliberation time where the mission declares none.
const BUDGET_DEFAULT: Duration = Duration(10_000_000_000);

/// Plans and prints.
pub fn run(options: &PlanOptions) -> Outcome {
    let mission = Mission::load(&options.mission)?;
    let (goal, budget) = goal_and_budget(&mission);
    let problem = pose(&mission, &Bookkeeping::default(), Time::ZERO)
        .map_err(|reason| Trouble::user("there is nothing to plan").because(reason))?;
    let solved = solve(problem, options.solver.as_deref(), budget, mission.settings.seed)
        .map_err(|reason| Trouble::user("no plan was found").because(reason))?;
    if options.json {
        let json = serde_json::json!({
            "mission": mission.settings.name,
            "reason": solved.reason,
            "work_units": solved.work,
            "plan": solved.plan,
        });
        println!("{json}");
    } else if options.pdl {
        print!("{}", translate(&solved, &goal, 1, &mission).source.text);
    } else {
        print_table(&solved);
    }
    Ok(())
}

/// The goal and budget of the mission's first declared solver.
fn goal_and_budget(mission: &Mission) -> (Value, Duration) {
    let declared = mission.library.solvers.first();
    let budget = declared.and_then(|solver| solver.budget.as_ref()).and_then(|budget| match &budget.kind {
        apex_model::expression::ExprKind::Constant(Value::Duration(duration)) => Some(*duration),
        _ => None,
    });
    let goal = declared.and_then(|solver| ground(&solver.index));
    (goal.unwrap_or_else(|| Value::list([Value::symbol("plan")])), budget.unwrap_or(BUDGET_DEFAULT))
}

/// The goal that an index without variables serves.
fn ground(index: &apex_model::pattern::Pattern) -> Option<Value> {
    use apex_model::pattern::Pattern;
    match index {
        Pattern::Literal(value) => Some(value.clone()),
        Pattern::List(items) => items.iter().map(ground).collect::<Option<Vec<_>>>().map(Value::list),
        _ => None,
    }
}

fn print_table(solved: &Deliberation) {
    println!("{}", solved.plan.summary());
    println!("planned by {} ({}), {} work units\n", solved.plan.solver(), solved.reason, solved.work);
    match &solved.plan {
        Plan::SingleVisit(plan) => print_single_visit(plan),
        Plan::Surveillance(plan) => print_surveillance(plan),
    }
    if !solved.plan.left_out().is_empty() {
        println!("\nnot visited:");
        for left in solved.plan.left_out() {
            println!("  {:<16} {}", left.target, left.reason);
        }
    }
}

fn clock(seconds: f64) -> String {
    Time::from_seconds(seconds.round()).to_string()
}

fn print_single_visit(plan: &SingleVisitPlan) {
    println!("  {:<16} {:>10} {:>10} {:>10} {:>8}", "target", "arrive", "begin", "end", "worth");
    for visit in &plan.visits {
        println!(
            "  {:<16} {:>10} {:>10} {:>10} {:>8.2}",
            visit.target,
            clock(visit.arrive_s),
            clock(visit.begin_s),
            clock(visit.end_s),
            visit.worth
        );
    }
    println!("\n  benefits {:.2}, costs {:.2}, score {:.2}", plan.benefits, plan.costs, plan.score);
    println!("  back at {}, fuel used {:.0} kg", clock(plan.end_s), plan.fuel_used_kg);
    if let Some(bound) = plan.benefits_bound {
        println!("  no plan can have benefits above {bound:.2}");
    }
}

fn print_surveillance(plan: &SurveillancePlan) {
    if !plan.cycle.is_empty() {
        println!("  cycle: {}", plan.cycle.join(" -> "));
    }
    println!("  {} visits until the horizon, expected cost of ignorance {:.4}", plan.visits.len(), plan.expected_cost);
    if let Some(bound) = plan.expected_cost_bound {
        println!("  no plan can cost less than {bound:.4}");
    }
}
