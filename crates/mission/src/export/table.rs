//! A plan as a table for operators.

use crate::deliberation::Deliberation;
use crate::plan::input::Benchmark;
use crate::plan::proof::{Proof, Proven};
use crate::plan::turns::Turns;
use crate::text::{name_width, named, wrapped};
use apex_model::problem::{Plan, SingleVisitPlan, SurveillancePlan};
use apex_model::time::Time;
use apex_portfolio::formats;
use apex_solvers::bounds::age_grid::cycles::WithoutEnd;
use std::fmt::Write;

/// A smaller gap consists of rounding errors alone.
const OPTIMAL: f64 = 1e-6;
const SECONDS_PER_HOUR: f64 = 3600.0;
/// Visits of a better cycle that are shown.
const CYCLE_SHOWN: usize = 24;

/// Facts about a plan that the plan does not hold.
#[derive(Clone, Copy, Debug)]
pub struct PlanFacts<'a> {
    /// Proven bound.
    pub proven: &'a Proven,
    /// Cost of turns.
    pub turns: Option<Turns>,
    /// Cost of a surveillance plan if only first events count, if requested.
    pub survival: Option<f64>,
    /// True if the forecast of the air changes during the mission: observations are predicted, and the bound is proven, in the air of the
    /// earliest arrival at each target.
    pub air_changes: bool,
}

/// Writes the problem, the planner with its reason, the visits, their values, and the targets left out.
pub fn write(name: &str, benchmark: Option<&Benchmark>, solved: &Deliberation, facts: &PlanFacts<'_>) -> String {
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = write_benchmark(&mut out, name, benchmark);
    let _ = write_table(&mut out, solved, facts);
    if benchmark.is_some_and(|benchmark| benchmark.asked == formats::ProblemKind::Tour) {
        let _ = write_tour(&mut out, facts.proven);
    }
    out
}

/// Writes the length of a tour with its proven bound.
fn write_tour(out: &mut String, proven: &Proven) -> std::fmt::Result {
    let Proof { value, bound, gap, proven_optimal } = proven.proof;
    match bound.zip(gap) {
        Some((bound, _)) if proven_optimal => {
            writeln!(out, "  length {value:.2}, proven to be the best: no tour is shorter than {bound:.2}")
        }
        Some((bound, gap)) => {
            let share = 100.0 * gap;
            writeln!(out, "  length {value:.2}: no tour is shorter than {bound:.2}, this one is within {share:.1} %")
        }
        None => writeln!(out, "  length {value:.2}: no bound is known"),
    }
}

/// Writes the interpretation of a benchmark's file.
fn write_benchmark(out: &mut String, name: &str, benchmark: Option<&Benchmark>) -> std::fmt::Result {
    let Some(Benchmark { format, asked, vehicles }) = benchmark else { return Ok(()) };
    let asked = match asked {
        formats::ProblemKind::OrienteeringWithWindows => "the most value within windows",
        formats::ProblemKind::Orienteering => "the most value within a length",
        formats::ProblemKind::Tour => "the shortest tour of all",
    };
    writeln!(out, "{name}: {format}; the problem asks for {asked}")?;
    match vehicles {
        Some(vehicles) if *vehicles != 1 => writeln!(out, "the file names {vehicles} vehicles; this is a plan for one"),
        _ => Ok(()),
    }
}

fn write_table(out: &mut String, solved: &Deliberation, facts: &PlanFacts<'_>) -> std::fmt::Result {
    let words = |text: &str| text.split(' ').map(str::to_string).collect::<Vec<_>>();
    writeln!(out, "{}", wrapped(&words(solved.plan.summary()), " ", 0, "  "))?;
    writeln!(out, "planned by {} in {} units of work", solved.plan.solver(), solved.work)?;
    writeln!(out, "  chosen because: {}\n", wrapped(&words(&solved.reason), " ", 18, "    "))?;
    match &solved.plan {
        Plan::SingleVisit(plan) => write_single_visit(out, plan, facts.air_changes)?,
        Plan::Surveillance(plan) => write_surveillance(out, plan)?,
    }
    if let (Plan::Surveillance(plan), Some(cost)) = (&solved.plan, facts.survival) {
        write_survival(out, plan.expected_cost, cost)?;
    }
    if let Some(turns) = &facts.turns {
        write_turns(out, turns)?;
    }
    if let Some(without_end) = &facts.proven.without_end {
        write_without_end(out, without_end)?;
    }
    let work = facts.proven.work;
    match facts.proven.complete {
        true => writeln!(out, "  bounds proven in {work} units of work")?,
        false => {
            writeln!(out, "  bounds proven so far in {work} units of work: a greater `--bound-budget` may prove more")?
        }
    }
    let left_out = solved.plan.left_out();
    if !left_out.is_empty() {
        writeln!(out, "\nnot visited:")?;
    }
    let width = name_width("", left_out.iter().map(|left| left.target.as_str()));
    left_out.iter().try_for_each(|left| writeln!(out, "{}", named(&left.target, width, &left.reason)))
}

fn clock(seconds: f64) -> String {
    Time::from_seconds(seconds.round()).to_string()
}

fn write_single_visit(out: &mut String, plan: &SingleVisitPlan, air_changes: bool) -> std::fmt::Result {
    let width = name_width("target", plan.visits.iter().map(|visit| visit.target.as_str()));
    writeln!(out, "  {:<width$} {:>10} {:>10} {:>10} {:>8}", "target", "arrive", "begin", "end", "worth")?;
    for visit in &plan.visits {
        writeln!(
            out,
            "  {:<width$} {:>10} {:>10} {:>10} {:>8.2}",
            visit.target,
            clock(visit.arrive_s),
            clock(visit.begin_s),
            clock(visit.end_s),
            visit.worth
        )?;
    }
    writeln!(out, "\n  benefits {:.2}, costs {:.2}, score {:.2}", plan.benefits, plan.costs, plan.score)?;
    writeln!(out, "  back at {}, fuel used in level flight {:.0} kg", clock(plan.end_s), plan.fuel_used_kg)?;
    match plan.benefits_bound.zip(plan.gap()) {
        Some((bound, gap)) if gap < OPTIMAL && air_changes => {
            writeln!(out, "  no plan can have benefits above {bound:.2}, and this plan has them, {EARLIEST_AIR}")
        }
        Some((bound, gap)) if gap < OPTIMAL && plan.costs == 0.0 => {
            writeln!(out, "  proven to be the best: no plan can have benefits above {bound:.2}")
        }
        Some((bound, gap)) if gap < OPTIMAL => {
            writeln!(
                out,
                "  proven: no plan can have benefits above {bound:.2}; a plan with the same benefits may cost less"
            )
        }
        Some((bound, gap)) => {
            let share = 100.0 * gap;
            writeln!(out, "  no plan can have benefits above {bound:.2}: this one is within {share:.1} % of the most")?;
            if air_changes { writeln!(out, "  the bound holds {EARLIEST_AIR}") } else { Ok(()) }
        }
        None => writeln!(out, "  no bound is known"),
    }
}

/// Condition of a bound in air and light that change.
const EARLIEST_AIR: &str = "in the air and the sun of the earliest arrivals; they change later";

fn write_surveillance(out: &mut String, plan: &SurveillancePlan) -> std::fmt::Result {
    if !plan.cycle.is_empty() {
        let stops: Vec<String> = plan.cycle.iter().map(ToString::to_string).collect();
        writeln!(out, "  cycle: {}", wrapped(&stops, " -> ", 9, "         "))?;
    } else if !plan.visits.is_empty() {
        let width = name_width("site", plan.visits.iter().map(|visit| visit.target.as_str()));
        writeln!(out, "  {:<width$} {:>10} {:>10}", "site", "begin", "end")?;
        for visit in &plan.visits {
            let (begin, end) = (clock(visit.arrive_s), clock(visit.end_s));
            writeln!(out, "  {:<width$} {begin:>10} {end:>10}", visit.target)?;
        }
        writeln!(out)?;
    }
    writeln!(
        out,
        "  {} visits until the horizon, expected cost of ignorance {:.4}",
        plan.visits.len(),
        plan.expected_cost
    )?;
    match plan.expected_cost_bound.zip(plan.gap()) {
        Some((bound, gap)) if gap < OPTIMAL => {
            writeln!(out, "  proven to be the best: no plan that never waits can cost less than {bound:.4}")
        }
        Some((bound, gap)) => {
            writeln!(
                out,
                "  no plan that never waits can cost less than {bound:.4}: this one is within {:.1} % of the best",
                100.0 * gap
            )
        }
        None => writeln!(out, "  no bound is known"),
    }
}

/// Writes the difference between the expected cost of all events and that of first events only.
fn write_survival(out: &mut String, added: f64, survival: f64) -> std::fmt::Result {
    let less = if added > 0.0 { 100.0 * (1.0 - survival / added).max(0.0) } else { 0.0 };
    writeln!(out, "  if only the first event after an observation counts: {survival:.4}, {less:.1} % less")
}

/// Writes the cost of turns, which shows the gain of a vehicle that turns more tightly.
fn write_turns(out: &mut String, turns: &Turns) -> std::fmt::Result {
    let Turns { radius_m, ways, time_s } = *turns;
    let each_s = if ways > 0 { time_s / ways as f64 } else { 0.0 };
    writeln!(out, "  turns of {radius_m:.0} m make {ways} ways {} longer, {each_s:.0} s each", clock(time_s))
}

/// Writes the cost per hour of the cycle as an endless flight.
fn write_without_end(out: &mut String, of: &WithoutEnd) -> std::fmt::Result {
    let hourly = |cost_per_s: f64| SECONDS_PER_HOUR * cost_per_s;
    let least = hourly(of.cost_per_s_bound);
    let above = |cost_per_s: f64| 100.0 * (1.0 - of.cost_per_s_bound / cost_per_s).max(0.0);
    writeln!(
        out,
        "  flown without end it costs {:.4} per hour; none can cost less than {least:.4}: this one is within {:.1} % of the best",
        hourly(of.cost_per_s),
        above(of.cost_per_s)
    )?;
    let Some((cycle, cost_per_s)) = &of.better else { return Ok(()) };
    let shown: Vec<String> = cycle.iter().take(CYCLE_SHOWN).cloned().collect();
    let rest = cycle.len().saturating_sub(CYCLE_SHOWN);
    let rest = if rest > 0 { format!(" and {rest} more (`--json` has all)") } else { String::new() };
    let cycle = wrapped(&shown, " -> ", 4, "    ");
    writeln!(out, "  a cycle that costs {:.4} per hour: {cycle}{rest}", hourly(*cost_per_s))
}
