//! Quality of plans for orienteering, compared with peers at equal processor time.
//!
//! `problems FOLDER` writes generated problems as files for the peers; `ours SECONDS..` plans them and prints JSON; `report FOLDER`
//! compares `ours.json`, `pyvrp.json` and `ortools.json` of the folder; `proven SECONDS..` counts the problems with few targets that are
//! solved to proven optimality. Gaps are relative to the best plan of any run, including our long run, because proven optima exist for
//! narrow windows only.
#![allow(clippy::print_stdout, reason = "the table is what the program is for")]
#![allow(clippy::expect_used, reason = "a figure that cannot be kept must stop the measurement")]

use apex_model::problem::{Plan, Problem, SingleVisitPlan, SingleVisitProblem};
use apex_planning::solver::{Environment, Solver, WorkBudget};
use apex_portfolio::formats::{self, generate};
use apex_solvers::planners::single_visit::SingleVisit;
use serde_json::{Map, Value, json};
use std::path::Path;

/// Without `APEX_BENCH_EVERY`, one in this many of the 76 problems with windows is measured.
const EVERY: usize = 10;
/// One in this many of the measured problems is reduced to few targets.
const EVERY_OF_FEW: usize = 4;
/// Number of plans made after a change; the reported one has the median time to its first plan.
const REPLANS: usize = 25;
/// Units of work that represent a second.
const UNITS_PER_S: u64 = 1_000_000;
/// Peers calculate with whole hundredths of seconds.
const HUNDREDTHS: f64 = 100.0;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>().as_slice() {
        ["problems", folder] => problems(Path::new(folder)),
        ["ours", spans @ ..] => println!("{}", ours(spans)),
        ["report", folder] => report(Path::new(folder)),
        ["proven", spans @ ..] => proven(spans),
        _ => tell_usage(),
    }
}

fn tell_usage() {
    println!("orienteering problems FOLDER | ours SECONDS.. | report FOLDER | proven SECONDS..");
}

/// Returns the problems that are measured: name and problem.
fn suite() -> Vec<(String, SingleVisitProblem)> {
    let every = std::env::var("APEX_BENCH_EVERY").ok().and_then(|text| text.parse().ok()).filter(|every| *every > 0);
    let windows = generate::windows_suite().into_iter().step_by(every.unwrap_or(EVERY));
    let texts = windows.chain([("op1000".to_string(), generate::oplib(1_001, 0.5, 1))]);
    texts
        .map(|(name, text)| {
            (name.clone(), formats::read(&name, &text).expect("a generated problem can be read").problem)
        })
        .collect()
}

fn problems(folder: &Path) {
    std::fs::create_dir_all(folder).expect("the folder is made");
    for (name, problem) in suite() {
        let whole = |time_s: f64| (time_s * HUNDREDTHS).floor() as i64;
        let near = |time_s: f64| (time_s * HUNDREDTHS).round() as i64;
        let travel = problem.travel.as_ref().expect("given times");
        let out: Vec<i64> = std::iter::once(0.0).chain(travel.from_start_s.iter().copied()).map(near).collect();
        let mut legs = vec![out];
        for (home_s, row) in travel.to_base_s.iter().zip(&travel.between_s) {
            legs.push(std::iter::once(*home_s).chain(row.iter().copied()).map(near).collect());
        }
        let limit = whole(problem.end_s.expect("an end"));
        let targets: Vec<Value> = problem
            .targets
            .iter()
            .map(|target| {
                let window = target.windows.first();
                json!({
                    "profit": target.value as i64,
                    "service": near(target.manoeuvres.first().map_or(0.0, |manoeuvre| manoeuvre.duration_s)),
                    "opens": window.map_or(0, |window| near(window.from_s)),
                    "closes": window.map_or(limit, |window| whole(window.until_s)),
                })
            })
            .collect();
        let text = json!({ "limit": limit, "targets": targets, "legs": legs }).to_string();
        std::fs::write(folder.join(format!("{name}.json")), text).expect("the problem is written");
    }
}

/// Returns the processor time of this thread. The system updates it at task switches, so the function causes one.
fn cpu_s() -> f64 {
    std::thread::yield_now();
    let told = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    told.split_whitespace().next().and_then(|word| word.parse::<f64>().ok()).unwrap_or(f64::NAN) * 1e-9
}

fn planned(solver: &dyn Solver, problem: &SingleVisitProblem, units: u64) -> (SingleVisitPlan, f64, f64) {
    planned_from(None, solver, problem, units)
}

fn planned_from(
    previous: Option<&Plan>,
    solver: &dyn Solver,
    problem: &SingleVisitProblem,
    units: u64,
) -> (SingleVisitPlan, f64, f64) {
    let problem = Problem::SingleVisit(problem.clone());
    let mut budget = WorkBudget::new(units);
    let begin_s = cpu_s();
    let mut first_s = f64::NAN;
    let mut report = |_: &Plan| first_s = if first_s.is_nan() { cpu_s() - begin_s } else { first_s };
    let mut environment = Environment { seed: 1, budget: &mut budget, report: &mut report, previous };
    let plan = solver.solve(&problem, &mut environment).expect("a plan");
    let whole_s = cpu_s() - begin_s;
    apex_planning::checker::accept(&problem, &plan).expect("a plan that the checker accepts");
    match plan {
        Plan::SingleVisit(plan) => (plan, whole_s, first_s),
        Plan::Surveillance(_) => another_plan(),
    }
}

#[expect(clippy::panic, reason = "a planner that answers another question must stop the measurement")]
fn another_plan() -> ! {
    panic!("a single-visit problem has a single-visit plan")
}

fn ours(spans: &[&str]) -> Value {
    let mut all = Map::new();
    for (name, problem) in suite() {
        let mut rows = Map::new();
        for seconds in spans {
            let units = UNITS_PER_S * seconds.parse::<u64>().expect("whole seconds");
            let (plan, cpu_s, _) = planned(&SingleVisit, &problem, units);
            rows.insert(
                (*seconds).into(),
                json!({"value": plan.benefits, "cpu_s": cpu_s, "bound": plan.benefits_bound}),
            );
        }
        all.insert(name, Value::Object(rows));
    }
    all.insert("replan".into(), replan());
    Value::Object(all)
}

/// Returns a problem of a thousand targets after a change: one target has become worthless, and the flight must end 2 % earlier.
fn replan() -> Value {
    let mut problem =
        formats::read("op", &generate::oplib(1_001, 0.5, 2)).expect("a generated problem can be read").problem;
    let (before, _, _) = planned(&SingleVisit, &problem, 10_000_000);
    let gone = before.visits.get(100).map(|visit| visit.target.clone());
    for target in problem.targets.iter_mut().filter(|target| Some(&target.name) == gone.as_ref()) {
        target.value = 0.0;
    }
    problem.end_s = problem.end_s.map(|end_s| 0.98 * end_s);
    let (long, _, _) = planned(&SingleVisit, &problem, 10_000_000);
    let before = Plan::SingleVisit(before);
    let mut runs: Vec<_> = (0..REPLANS).map(|_| planned_from(Some(&before), &SingleVisit, &problem, 35_000)).collect();
    runs.sort_by(|(_, _, a), (_, _, b)| a.total_cmp(b));
    let (quick, quick_s, first_s) = runs.swap_remove(REPLANS / 2);
    json!({
        "first_feasible_ms": 1e3 * first_s, "quick_ms": 1e3 * quick_s, "quick": quick.benefits,
        "long": long.benefits, "loss_percent": 100.0 * (1.0 - quick.benefits / long.benefits),
    })
}

fn report(folder: &Path) {
    let read = |name: &str| {
        let text = std::fs::read_to_string(folder.join(name)).unwrap_or_else(|_| "{}".into());
        serde_json::from_str::<Value>(&text).expect("JSON")
    };
    let (ours, pyvrp, ortools) = (read("ours.json"), read("pyvrp.json"), read("ortools.json"));
    let columns = ["apex 1", "apex 10", "pyvrp 1", "pyvrp 10", "ortools 1", "ortools 10"];
    println!("| problem | best | bound | {} |\n|---|---|---|{}", columns.join(" | "), "---|".repeat(columns.len()));
    let mut gaps: Vec<Vec<f64>> = vec![Vec::new(); columns.len()];
    for (name, rows) in ours.as_object().into_iter().flatten().filter(|(name, _)| *name != "replan") {
        let of = |column: &str| {
            let (who, seconds) = column.split_once(' ')?;
            let (file, place) = match who {
                "apex" => (&ours, format!("/{name}/{seconds}/value")),
                "pyvrp" => (&pyvrp, format!("/{name}/{seconds}")),
                _ => (&ortools, format!("/{name}/{seconds}")),
            };
            file.pointer(&place)?.as_f64()
        };
        let values: Vec<Option<f64>> = columns.iter().map(|column| of(column)).collect();
        let own = |what: &str| {
            let rows = rows.as_object().into_iter().flatten();
            rows.filter_map(|(_, row)| row.get(what)?.as_f64()).collect::<Vec<f64>>()
        };
        let best = values.iter().flatten().copied().chain(own("value")).fold(0.0, f64::max);
        let bound = own("bound").into_iter().fold(f64::INFINITY, f64::min);
        let mut line = format!("| {name} | {best} | {bound} |");
        for (value, gaps) in values.iter().zip(&mut gaps) {
            let gap = value.map(|value| 100.0 * (1.0 - value / best));
            line += &gap.map_or(" - |".into(), |gap| format!(" {gap:.2} % |"));
            gaps.extend(gap.filter(|_| name != "op1000"));
        }
        println!("{line}");
    }
    let mean = |gaps: &Vec<f64>| format!(" {:.2} % |", gaps.iter().sum::<f64>() / gaps.len().max(1) as f64);
    let worst = |gaps: &Vec<f64>| format!(" {:.2} % |", gaps.iter().copied().fold(0.0, f64::max));
    println!("| mean with windows | | |{}", gaps.iter().map(mean).collect::<String>());
    println!("| worst with windows | | |{}", gaps.iter().map(worst).collect::<String>());
    println!("\nreplanning after a change, 1,000 targets: {}", ours.get("replan").unwrap_or(&Value::Null));
}

/// Returns the problem with its first `count` targets.
fn cut(mut problem: SingleVisitProblem, count: usize) -> SingleVisitProblem {
    problem.targets.truncate(count);
    if let Some(travel) = problem.travel.as_mut() {
        travel.from_start_s.truncate(count);
        travel.to_base_s.truncate(count);
        travel.between_s.truncate(count);
        travel.between_s.iter_mut().for_each(|row| row.truncate(count));
    }
    problem
}

/// Counts the problems of 20 and of 40 targets that are solved with a bound that proves optimality.
fn proven(spans: &[&str]) {
    for count in [20, 40] {
        for seconds in spans {
            let units = UNITS_PER_S * seconds.parse::<u64>().expect("whole seconds");
            let (mut solved, mut all, mut gap, mut cpu_s) = (0, 0, 0.0_f64, 0.0);
            for (name, text) in generate::windows_suite().into_iter().step_by(EVERY_OF_FEW) {
                let problem = cut(formats::read(&name, &text).expect("a generated problem can be read").problem, count);
                let (plan, took_s, _) = planned(&SingleVisit, &problem, units);
                let bound = plan.benefits_bound.unwrap_or(f64::INFINITY);
                all += 1;
                solved += usize::from(bound <= plan.benefits + 1e-6);
                gap = gap.max(bound / plan.benefits - 1.0);
                if bound > plan.benefits + 1e-6 {
                    println!("  {name}: {:.1} of at most {bound:.1}, {took_s:.1} s", plan.benefits);
                }
                cpu_s += took_s;
            }
            println!(
                "{count} targets, {seconds} s: {solved} of {all} proven optimal, the widest gap {:.1} %, {:.1} s each",
                100.0 * gap,
                cpu_s / all as f64
            );
        }
    }
}
