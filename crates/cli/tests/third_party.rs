//! Good and bad planners of third parties in flight: the plans of the good one are flown; faults of bad ones are named in the record, and
//! the flight continues.

#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, reason = "a test stops at an unexpected result")]

mod common;

use apex_model::problem::{Plan, Problem, SurveillancePlan, SurveillanceVisit};
use apex_planning::solver::{Environment, Solver};
use common::{Desk, mission};
use std::process::Command;
use std::sync::Arc;

const EXAMPLE: &str = include_str!("../examples/swaps.rs");
const FORM: &str = "(solver auto (index (patrol the structures)) :budget 500ms)";

#[test]
fn the_example_is_short_and_on_the_page() {
    assert!(EXAMPLE.lines().count() < 60, "{}", EXAMPLE.lines().count());
    let guide = include_str!("../../../docs/guides/adding-a-solver.md");
    assert!(guide.contains(&format!("```rust\n{EXAMPLE}```\n")), "the guide shows other code than examples/swaps.rs");
}

#[test]
fn the_example_plans_flies_and_is_measured() {
    let program = std::path::Path::new(env!("CARGO_BIN_EXE_apex")).with_file_name("examples").join("swaps");
    assert!(program.is_file(), "examples are built by `cargo test -p apex-cli` without --test");
    let desk = Desk::with_mission("plain-watch");
    desk.change("m/mission.pdl", FORM, "(solver swaps (index (patrol the structures)) :budget 20ms)");
    let run = |arguments: &[&str]| {
        let output = Command::new(&program).args(arguments).current_dir(desk.path(".")).output().unwrap();
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(output.status.success(), "{text}{}", String::from_utf8_lossy(&output.stderr));
        text
    };
    let table = run(&["plan", &mission("structure-watch"), "--solver", "swaps", "--budget", "50ms"]);
    assert!(table.contains("planned by swaps") && table.contains("no plan that never waits can cost less"), "{table}");
    run(&["fly", "m", "--record", "flown.apex", "--no-progress"]);
    desk.apex(&["trace", "flown.apex", "--type", "plan"]).well().told(&["because swaps answered request 0"]);
    desk.apex(&["replay", "flown.apex"]).well();
    let cell = "small-fixed-fixed-4-uniform";
    run(&[
        "profile",
        "build",
        "mine.txt",
        "--cells",
        cell,
        "--missions",
        "3",
        "--budgets",
        "1ms",
        "--planners",
        "swaps,two-opt",
        "--no-progress",
    ]);
    assert!(desk.read("mine.txt").contains("swaps"));
    desk.apex(&["plan", cell, "--solver", "swaps"]).complained(2, &["no solver `swaps`", "two-opt"]);
}

#[test]
fn a_measured_planner_gets_into_the_table_and_is_chosen_by_it() {
    let mut planners = apex_solvers::shipped();
    planners.add(Arc::new(Shortcut)).unwrap();
    let desk = Desk::with_mission("plain-watch");
    let path = |name: &str| desk.path(name).display().to_string();
    let (profile, table, record, folder) = (path("mine.txt"), path("mine.csv"), path("r.apex"), path("m"));
    let run = |arguments: &[&str]| {
        let code = apex_cli::try_main(["apex"].iter().chain(arguments).map(Into::into), planners.clone()).unwrap();
        assert_eq!(format!("{code:?}"), format!("{:?}", std::process::ExitCode::SUCCESS), "{arguments:?}");
    };
    let cell = "small-fixed-fixed-4-uniform";
    let missions = ["--cells", cell, "--missions", "6", "--budgets", "1ms", "--no-progress"];
    let build = ["profile", "build", &profile, "--planners", "nearest-neighbour"];
    run(&[build.as_slice(), missions.as_slice()].concat());
    // An additional planner is measured on the same missions.
    run(&["profile", "update", &profile, "--planners", "shortcut", "--table", &table, "--no-progress"]);
    assert!(desk.read("mine.csv").contains("shortcut"), "{}", desk.read("mine.csv"));
    // The table chooses the planner; no option names it.
    run(&["fly", &folder, "--record", &record, "--table", &table, "--until", "3min", "--no-progress"]);
    desk.apex(&["trace", "r.apex", "--type", "plan"]).well().told(&["because shortcut answered request 0"]);
    // A program without that planner reports it.
    let other = desk.apex(&["plan", "m", "--table", "mine.csv"]);
    other.complained(2, &["there is no solver `shortcut`, which the profile table chooses"]);
    desk.write("broken.csv", "cell,budget_units,best,verdict,next,effect_percent\nnonsense,1\n");
    desk.apex(&["plan", "m", "--table", "broken.csv"]).complained(2, &["broken.csv:2:"]);
    desk.write("foreign.csv", "cell,budget\nnonsense,1\n");
    desk.apex(&["plan", "m", "--table", "foreign.csv"]).complained(2, &["foreign.csv:1:", "not the heading"]);
}

/// Improves on nearest neighbour by calling another planner.
struct Shortcut;

impl Solver for Shortcut {
    fn name(&self) -> &str {
        "shortcut"
    }
    fn serves(&self, problem: &Problem) -> bool {
        matches!(problem, Problem::Surveillance(_))
    }
    fn solve(&self, problem: &Problem, environment: &mut Environment<'_>) -> Result<Plan, String> {
        let mut plan = apex_solvers::solver("anytime").ok_or("there is none")?.solve(problem, environment)?;
        if let Plan::Surveillance(plan) = &mut plan {
            plan.solver = self.name().to_string();
        }
        Ok(plan)
    }
}

/// A planner that misbehaves in the way of its name.
struct Bad(&'static str);

impl Solver for Bad {
    fn name(&self) -> &str {
        self.0
    }
    fn serves(&self, problem: &Problem) -> bool {
        matches!(problem, Problem::Surveillance(_))
    }
    fn solve(&self, problem: &Problem, environment: &mut Environment<'_>) -> Result<Plan, String> {
        let Problem::Surveillance(problem) = problem else { return Err("surveillance only".into()) };
        let visit = |target: &str, end_s| SurveillanceVisit { target: target.into(), arrive_s: end_s - 1.0, end_s };
        let target = problem.targets[0].name.as_str();
        let mut hoard: Vec<Vec<u8>> = Vec::new();
        let visits = match self.0 {
            "panics" => panic!("no idea left"),
            "loops" => loop {
                environment.budget.charge(1);
            },
            "hangs" => loop {
                std::thread::sleep(std::time::Duration::from_millis(1));
            },
            "hoards" => loop {
                hoard.push(vec![7; 1 << 20]);
                environment.budget.charge(1);
                assert!(hoard.len() < 2_000, "it was not stopped");
                std::thread::sleep(std::time::Duration::from_micros(100));
            },
            "lies" => vec![visit(target, 2.0)],
            "dreams" => vec![visit("atlantis", 1e9)],
            "numbs" => vec![visit(target, f64::NAN)],
            "floods" => vec![visit(target, 100.0); 200_000],
            _ => Vec::new(),
        };
        Ok(Plan::Surveillance(SurveillancePlan {
            solver: self.0.into(),
            cycle: Vec::new(),
            visits,
            return_s: None,
            expected_cost: if self.0 == "boasts" { -1.0 } else { 1.0 },
            expected_cost_bound: None,
            left_out: Vec::new(),
            summary: "a wonderful plan".into(),
        }))
    }
}

/// Flies the watch of structures with a bad planner; the mission continues after its failure.
fn fly_with(name: &'static str, more: &[&str]) -> Desk {
    let desk = Desk::with_mission("plain-watch");
    desk.change("m/mission.pdl", FORM, &format!("(solver {name} (index (patrol the structures)) :budget 1ms)"));
    // Without a plan this mission would fail; with this step it continues.
    let patrol = "(step patrol (patrol the structures) (waitfor (end ?up))";
    desk.change("m/mission.pdl", patrol, &format!("{patrol} (on-failure (inform (without-a-plan)))"));
    let mut planners = apex_solvers::shipped();
    planners.add(Arc::new(Bad(name))).unwrap();
    let (folder, record) = (desk.path("m").display().to_string(), desk.path("r.apex").display().to_string());
    let arguments = ["apex", "fly", &folder, "--record", &record, "--no-progress"];
    let code = apex_cli::try_main(arguments.iter().chain(more).map(Into::into), planners).unwrap();
    assert_eq!(format!("{code:?}"), format!("{:?}", std::process::ExitCode::SUCCESS), "{name}");
    desk
}

#[test]
fn misconduct_is_named_in_the_record_and_the_flight_continues() {
    for (name, named) in [
        ("panics", "the solver panics failed: no idea left"),
        ("loops", "the solver loops continued after its 1000 units of work"),
        ("hangs", "the solver hangs gave no answer within 0.2 s and was abandoned"),
        ("hoards", "the solver hoards took more than 64 MiB of memory"),
        ("lies", "before it can be there"),
        ("dreams", "visits atlantis, which is not a target"),
        ("numbs", "the plan of `numbs` breaks"),
        ("floods", "200000 visits, more than 100000"),
        ("boasts", "claims an expected cost of -1"),
    ] {
        // Only the solver that hangs needs a timeout: a slow machine must not abandon the others.
        let timeout = if name == "hangs" { "0.2s" } else { "60s" };
        let memory = if name == "hoards" { "64" } else { "100000" };
        let desk = fly_with(name, &["--until", "5min", "--solver-timeout", timeout, "--solver-memory", memory]);
        let trace = desk.apex(&["trace", "r.apex"]).well();
        assert!(trace.out.contains(named), "{name}: `{named}` is not in\n{}", trace.out);
        // The executive continues: it handles the failure, watches the radio, and flies until the end time.
        let late = desk.apex(&["trace", "r.apex", "--from", "4:50"]).well();
        assert!(trace.out.contains("(without-a-plan)") && late.out.contains("signal-level"), "{name}\n{}", trace.out);
        desk.apex(&["replay", "r.apex"]).well();
    }
}

#[test]
fn a_paced_flight_holds_mission_time_until_a_planner_that_hangs_is_abandoned() {
    // Mission time stops while the planner hangs (decision 0120), so the pace that an operator chose does not affect the flight.
    let desk = fly_with("hangs", &["--until", "2min", "--pace", "60", "--solver-timeout", "3s"]);
    let trace = desk.apex(&["trace", "r.apex"]).well();
    assert!(trace.out.contains("(without-a-plan)"), "{}", trace.out);
    let late = desk.apex(&["trace", "r.apex", "--from", "1:50"]).well();
    assert!(late.out.contains("signal-level"), "{}", late.out);
    desk.apex(&["replay", "r.apex"]).well();
}

#[test]
fn nonsense_in_a_paced_flight_is_refused_as_in_a_fast_one() {
    let desk = fly_with("lies", &["--until", "90s", "--pace", "20"]);
    let trace = desk.apex(&["trace", "r.apex"]).well();
    assert!(trace.out.contains("before it can be there") && trace.out.contains("(without-a-plan)"), "{}", trace.out);
    desk.apex(&["replay", "r.apex"]).well();
}
