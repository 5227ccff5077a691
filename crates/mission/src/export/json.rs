//! A plan as one object of JSON, for programs: `docs/reference/schema/plan.schema.json`.

use crate::deliberation::Deliberation;
use crate::export::table::PlanFacts;
use crate::plan::input::Benchmark;
use crate::plan::proof::Proof;
use apex_solvers::bounds::age_grid::cycles::WithoutEnd;

/// Writes the problem, the plan, its value and its proven bound.
pub fn write(name: &str, benchmark: Option<&Benchmark>, solved: &Deliberation, facts: &PlanFacts<'_>) -> String {
    let PlanFacts { proven, turns, survival, air_changes } = facts;
    let Proof { value, bound, gap, proven_optimal } = proven.proof;
    let answer = serde_json::json!({
        "mission": name,
        "format": benchmark.map(|benchmark| benchmark.format),
        "vehicles": benchmark.and_then(|Benchmark { vehicles, .. }| *vehicles),
        "reason": solved.reason,
        "people_plan_better": solved.people_plan_better,
        "value": value,
        "bound": bound,
        "gap": gap,
        "proven_optimal": proven_optimal && !air_changes,
        "work_units": solved.work,
        "bound_work_units": proven.work,
        "bound_complete": proven.complete,
        "cpu_s": solved.cpu_s,
        "plan": solved.plan,
        "survival_cost": survival,
        "turns": turns.as_ref().map(|turns| serde_json::json!({
            "radius_m": turns.radius_m,
            "ways": turns.ways,
            "time_s": turns.time_s,
        })),
        "without_end": proven.without_end.as_ref().map(without_end),
    });
    format!("{answer}\n")
}

/// Writes the evaluation of the plan's cycle as an endless flight.
fn without_end(of: &WithoutEnd) -> serde_json::Value {
    serde_json::json!({
        "cost_per_s": of.cost_per_s,
        "cost_per_s_bound": of.cost_per_s_bound,
        "better_cycle": of.better.as_ref().map(|(cycle, _)| cycle),
        "better_cost_per_s": of.better.as_ref().map(|(_, cost_per_s)| cost_per_s),
    })
}
