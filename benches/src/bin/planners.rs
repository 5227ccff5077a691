//! Comparison of surveillance planners on test missions: mean log ratio of expected costs at equal CPU time.
//!
//! - `planners MILLISECONDS MISSIONS LONG_MILLISECONDS [CELL ..]`: 2-Opt, WAM and the anytime planner with the same CPU time; the gap of
//!   the anytime planner to its best result from other seeds in the longer time (0: not measured), and to the proven bound. MISSIONS is a
//!   range FROM..TO of mission numbers, or N for 0..N; the cell `all` means all cells.
//! - `planners cycles MISSIONS POINTS [CELL ..]`: gap of the best endlessly repeated cycle of four targets to the lower bound that a grid
//!   of POINTS target ages gives, for the missions 0..MISSIONS.
//! - `planners pairs FROM TO OURS_MILLISECONDS THEIRS_MILLISECONDS [CELL ..]`: one CSV row for each of the missions FROM..TO, with
//!   expected costs and CPU seconds. OURS is the time of the anytime planner, THEIRS that of 2-Opt and WAM.
//! - `planners tally FILE ..`: summary of the rows of all files, for each cell and for all.

use apex_model::problem::{Plan, Problem};
use apex_planning::meter::Meter;
use apex_planning::solver::{Budget, Environment, WorkBudget};
use apex_portfolio::cell::Cell;
use apex_solvers::bounds::age_grid::cycles;
use std::collections::BTreeMap;
use std::ops::Range;

/// Number of columns in a row of `pairs`.
const COLUMNS: usize = 8;

/// Returns the CPU time of this thread, in nanoseconds.
fn cpu_ns() -> u64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    text.split(' ').next().and_then(|first| first.parse().ok()).unwrap_or(0)
}

/// A budget of CPU time. The clock is read after every 2,000 units of work.
struct CpuBudget {
    until_ns: u64,
    used: u64,
    next: u64,
    over: bool,
}

impl Budget for CpuBudget {
    fn charge(&mut self, units: u64) {
        self.used += units;
        if self.used >= self.next {
            self.next = self.used + 2_000;
            self.over = cpu_ns() >= self.until_ns;
        }
    }
    fn exhausted(&self) -> bool {
        self.over
    }
    fn used(&self) -> u64 {
        self.used
    }
}

fn cost(solver: &str, problem: &Problem, milliseconds: u64, seed: u64) -> (f64, u64, f64) {
    let begin = cpu_ns();
    let mut budget = CpuBudget { until_ns: begin + milliseconds * 1_000_000, used: 0, next: 0, over: false };
    let Some(solver) = apex_solvers::solver(solver) else { return (f64::NAN, 0, 0.0) };
    let plan = {
        let mut environment = Environment { seed, budget: &mut budget, report: &mut |_| {}, previous: None };
        solver.solve(problem, &mut environment)
    };
    let took = (cpu_ns() - begin) as f64 * 1e-6;
    match plan {
        Ok(Plan::Surveillance(plan)) => (plan.expected_cost, budget.used, took),
        _ => (f64::NAN, 0, took),
    }
}

/// Returns the least cost found by the anytime planner from successive seeds, each run to its end, within this time.
fn best_of(problem: &Problem, milliseconds: u64) -> f64 {
    let (mut best, mut left_ms, mut seed) = (f64::INFINITY, milliseconds as f64, 7);
    while left_ms > 0.0 {
        let (found, _, took_ms) = cost("anytime", problem, left_ms as u64, seed);
        best = best.min(found);
        // At least 1 ms counts, so that the loop ends if the system has no CPU clock.
        left_ms -= took_ms.max(1.0);
        seed += 1;
    }
    best
}

/// Prints the mean gap of the best cycle of four targets to its lower bound, in percent of the cost, for each cell.
fn cycles(missions: u64, points: usize, names: &[String]) {
    let cells = Cell::all().into_iter().filter(|cell| match names {
        [] => cell.to_string().contains("-4-"),
        names => names.contains(&cell.to_string()),
    });
    let (mut near, mut all, mut count) = (0, 0.0, 0);
    for cell in cells {
        let (mut gap, mut took) = (0.0, 0.0);
        for number in 0..missions {
            let begin = cpu_ns();
            let mut budget = WorkBudget::new(u64::MAX);
            let mut meter = Meter::new(&mut budget);
            let Some(best) = cycles::best_within(&cell.mission(number), &[], points, &mut meter) else { continue };
            gap += 100.0 * (1.0 - best.cost_per_s_bound / best.cost_per_s) / missions as f64;
            took += (cpu_ns() - begin) as f64 * 1e-9 / missions as f64;
        }
        println!("{:44} gap {gap:6.2} %   {took:5.2} s", cell.to_string());
        near += usize::from(gap <= 2.0);
        all += gap;
        count += 1;
    }
    println!("{near} of {count} cells at most 2 %, mean {:.2} %", all / f64::from(count));
}

/// Prints the costs of all three planners, one mission after another over all cells, so that an interrupted run has complete missions.
fn pairs(missions: std::ops::Range<u64>, ours_ms: u64, theirs_ms: u64, names: &[String]) {
    println!("mission,cell,two_opt,wam,anytime,two_opt_s,wam_s,anytime_s");
    for number in missions {
        for cell in Cell::all().into_iter().filter(|cell| names.is_empty() || names.contains(&cell.to_string())) {
            let problem = Problem::Surveillance(cell.mission(number));
            let (two_opt, _, two_opt_ms) = cost("two-opt", &problem, theirs_ms, 1);
            let (wam, _, wam_ms) = cost("wam", &problem, theirs_ms, 1);
            let (anytime, _, anytime_ms) = cost("anytime", &problem, ours_ms, 1);
            let (two_opt_s, wam_s, anytime_s) = (1e-3 * two_opt_ms, 1e-3 * wam_ms, 1e-3 * anytime_ms);
            println!("{number},{cell},{two_opt},{wam},{anytime},{two_opt_s:.3},{wam_s:.3},{anytime_s:.3}");
        }
    }
}

/// Prints the mean logarithm of the anytime planner's cost over the lesser cost of the others, in percent: for each cell in which it is
/// above -0.1 %, and in total.
fn tally(rows: &str) {
    let mut cells: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    let mut spent_s = [0.0; 3];
    // A measurement in parts has a heading in each, and a last row cut short at the interruption of a part.
    for line in rows.lines().filter(|line| !line.starts_with("mission,")) {
        let words: Vec<&str> = line.split(',').collect();
        if words.len() != COLUMNS {
            continue;
        }
        let number = |index: usize| words.get(index).and_then(|word| word.parse::<f64>().ok()).unwrap_or(f64::NAN);
        let ratio = (number(4) / number(2).min(number(3))).ln();
        cells.entry(words.get(1).copied().unwrap_or_default().to_string()).or_default().push(ratio);
        spent_s.iter_mut().zip(5..).for_each(|(sum, index)| *sum += number(index));
    }
    let mean = |ratios: &[f64]| 100.0 * ratios.iter().sum::<f64>() / ratios.len() as f64;
    let of_cell: Vec<(f64, &String, usize)> =
        cells.iter().map(|(cell, ratios)| (mean(ratios), cell, ratios.len())).collect();
    let missions: usize = of_cell.iter().map(|(_, _, count)| count).sum();
    let worse = of_cell.iter().filter(|(mean, _, _)| *mean > 0.1).count();
    let better = of_cell.iter().filter(|(mean, _, _)| *mean <= -1.0).count();
    for (mean, cell, count) in of_cell.iter().filter(|(mean, _, _)| *mean > -0.1) {
        println!("{cell:44} {mean:7.3} %, {count} missions");
    }
    let all = of_cell.iter().map(|(mean, _, _)| mean).sum::<f64>() / of_cell.len() as f64;
    println!(
        "{} cells, {missions} missions: at least 1 % better in {better}, more than 0.1 % worse in {worse}",
        cells.len()
    );
    let [two_opt_s, wam_s, anytime_s] = spent_s.map(|sum| sum / missions as f64);
    println!("mean {all:.2} %; CPU seconds a mission: 2-Opt {two_opt_s:.3}, WAM {wam_s:.3}, anytime {anytime_s:.3}");
}

fn no_rows(file: &str, why: &std::io::Error) -> String {
    eprintln!("{file}: {why}; its rows are skipped");
    String::new()
}

/// Reads `FROM..TO`; a number `N` means `0..N`.
fn range(text: &str) -> Option<Range<u64>> {
    let (from, to) = text.split_once("..").unwrap_or(("0", text));
    Some(from.parse().ok()?..to.parse().ok()?)
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let [first, files @ ..] = arguments.as_slice()
        && first == "tally"
    {
        let read = |file: &String| std::fs::read_to_string(file).unwrap_or_else(|why| no_rows(file, &why));
        return tally(&files.iter().map(read).collect::<Vec<String>>().join("\n"));
    }
    if arguments.first().is_some_and(|first| first == "cycles") {
        let number = |index: usize| arguments.get(index).and_then(|text| text.parse().ok());
        let names = arguments.get(3..).unwrap_or_default();
        return cycles(number(1).unwrap_or(1), number(2).unwrap_or(56_000) as usize, names);
    }
    if arguments.first().is_some_and(|first| first == "pairs") {
        let number = |index: usize| arguments.get(index).and_then(|text| text.parse().ok()).unwrap_or(0);
        return pairs(number(1)..number(2), number(3), number(4), arguments.get(5..).unwrap_or_default());
    }
    let number =
        |index: usize, default: u64| arguments.get(index).and_then(|text| text.parse().ok()).unwrap_or(default);
    let (milliseconds, long) = (number(0, 100), number(2, 0));
    let chosen = arguments.get(1).and_then(|text| range(text)).unwrap_or(0..5);
    let missions = chosen.end.saturating_sub(chosen.start).max(1);
    let cells: Vec<Cell> = match arguments.get(3..) {
        Some([all]) if all == "all" => Cell::all(),
        Some(names) if !names.is_empty() => names.iter().filter_map(|name| name.parse().ok()).collect(),
        _ => Cell::subset(),
    };
    let (mut all, mut worst, mut all_proven, mut better, mut bound_ms) = (0.0, 0.0_f64, 0.0, 0, 0.0);
    for cell in &cells {
        let (mut ratio, mut two, mut gap, mut units, mut took, mut proven) = (0.0, 0.0, 0.0, 0, 0.0, 0.0);
        for number in chosen.clone() {
            let mission = cell.mission(number);
            let begin = cpu_ns();
            let bound = apex_solvers::bounds::expected_cost_without_waiting(&mission).expected_cost;
            bound_ms += (cpu_ns() - begin) as f64 * 1e-6 / missions as f64;
            let problem = Problem::Surveillance(mission);
            let two_opt = cost("two-opt", &problem, milliseconds, 1).0;
            let wam = cost("wam", &problem, milliseconds, 1).0;
            let (any, used, ms) = cost("anytime", &problem, milliseconds, 1);
            ratio += (any / two_opt.min(wam)).ln();
            two += (wam / two_opt).ln();
            units += used;
            took += ms;
            let mut least = any;
            if long > 0 {
                let best = best_of(&problem, long).min(any);
                gap += (any / best).ln();
                least = best;
            }
            proven += least / bound - 1.0;
        }
        let mean = |sum: f64| 100.0 * sum / missions as f64;
        println!(
            "{:44} any/min {:7.2} %   wam/2opt {:7.2} %   gap {:6.3} %   proven {:6.2} %   {:8} units {:6.1} ms",
            cell.to_string(),
            mean(ratio),
            mean(two),
            mean(gap),
            mean(proven),
            units / missions,
            took / missions as f64
        );
        all += mean(gap);
        worst = worst.max(mean(gap));
        all_proven += mean(proven);
        better += usize::from(mean(ratio) <= -1.0);
    }
    let cells = cells.len() as f64;
    println!("mean gap {:.3} %, worst cell {worst:.3} %; 1 % better than both in {better} cells", all / cells);
    println!("mean proven gap {:.2} %, {:.0} ms per bound", all_proven / cells, bound_ms / cells);
}
