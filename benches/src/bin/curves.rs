//! Quality of plans as a function of processor time, and its change with the number of targets.
//!
//! `curves measure FILE.csv` runs every planner with rising budgets of work; `curves draw FILE.csv FILE.svg` draws the measurements. A
//! loss is relative to the best plan found by any planner in any run on the problem, so it may be understated.
#![allow(clippy::print_stdout, reason = "it prints its progress")]
#![allow(clippy::expect_used, reason = "a figure that cannot be kept must stop the measurement")]

use apex_model::problem::{Plan, Problem};
use apex_planning::solver::{Environment, WorkBudget};
use apex_portfolio::formats::{self, generate};
use std::collections::BTreeMap;
use std::fmt::Write;

/// Numbers of targets: of surveillance missions, and (`VISITED`) of orienteering problems.
const WATCHED: [usize; 5] = [10, 30, 100, 300, 1_000];
const VISITED: [usize; 3] = [100, 300, 1_000];
/// Number of surveillance missions for each number of targets.
const MISSIONS: u64 = 2;
/// Budgets in units of work: a unit takes about 1 us.
const BUDGETS: [u64; 8] = [1_000, 3_000, 10_000, 30_000, 100_000, 300_000, 1_000_000, 3_000_000];
/// The budget at which growth is shown.
const GROWTH_BUDGET: u64 = 100_000;
/// Size of a panel, and the space around it, in pixels.
const PANEL: (f64, f64) = (330.0, 230.0);
const ROOM: (f64, f64) = (70.0, 66.0);
/// Ranges of the drawn processor seconds and losses (per cent). Processor time is reported in ticks of 4 ms; shorter times are at the
/// left edge.
const SECONDS: (f64, f64) = (4e-3, 10.0);
const LOSS: (f64, f64) = (0.1, 100.0);
const COLOURS: [(&str, &str); 5] = [
    ("nearest-neighbour", "#999999"),
    ("two-opt", "#4477aa"),
    ("wam", "#ee6677"),
    ("anytime", "#228833"),
    ("single-visit", "#aa3377"),
];

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>().as_slice() {
        ["measure", csv] => measure(std::path::Path::new(csv)),
        ["draw", csv, svg] => {
            let rows = read(&std::fs::read_to_string(csv).expect("the figures are read"));
            std::fs::write(svg, draw(&rows)).expect("the picture is written");
        }
        _ => println!("curves measure FILE.csv | curves draw FILE.csv FILE.svg"),
    }
}

/// Returns the time that this thread has spent on a processor.
fn cpu_s() -> f64 {
    let told = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    told.split_whitespace().next().and_then(|word| word.parse::<f64>().ok()).unwrap_or(f64::NAN) * 1e-9
}

/// Measures one number of targets after another; if a run is interrupted, the file holds the finished numbers.
fn measure(csv: &std::path::Path) {
    let mut out = "kind,targets,mission,planner,budget_units,used_units,cpu_s,value\n".to_string();
    let done = |out: &str, what: &str| {
        std::fs::write(csv, out).expect("the figures are written");
        println!("{what}");
    };
    for count in VISITED {
        for number in 0..MISSIONS {
            let text = generate::oplib(count + 1, 0.5, number + 1);
            let problem =
                Problem::SingleVisit(formats::read("op", &text).expect("a generated problem can be read").problem);
            planners(&mut out, "orienteering", (count, number), &problem);
        }
        done(&out, &format!("{count} targets visited"));
    }
    for count in WATCHED {
        let cell = format!("medium-uniform-uniform-{count}-uniform").parse::<apex_portfolio::cell::Cell>();
        let cell = cell.expect("a cell");
        for number in 0..MISSIONS {
            let problem = Problem::Surveillance(cell.mission(number));
            planners(&mut out, "surveillance", (count, number), &problem);
            done(&out, &format!("{count} targets watched, mission {number}"));
        }
    }
}

/// Measures every planner that serves the problem, with every budget.
fn planners(out: &mut String, kind: &str, (count, number): (usize, u64), problem: &Problem) {
    for solver in apex_solvers::solvers().iter().filter(|solver| solver.serves(problem)) {
        for units in &BUDGETS {
            let mut budget = WorkBudget::new(*units);
            let begin_s = cpu_s();
            let mut environment = Environment { seed: 1, budget: &mut budget, report: &mut |_| {}, previous: None };
            let plan = solver.solve(problem, &mut environment).expect("a plan");
            let took_s = cpu_s() - begin_s;
            apex_planning::checker::accept(problem, &plan).expect("a plan that the checker accepts");
            let value = match &plan {
                Plan::Surveillance(plan) => plan.expected_cost,
                Plan::SingleVisit(plan) => plan.benefits,
            };
            let name = solver.name();
            // Writing to a string cannot fail.
            let _ = writeln!(out, "{kind},{count},{number},{name},{units},{},{took_s:.6},{value:.6}", budget.used);
            // A planner that ended early does nothing more with a larger budget.
            if budget.used < *units / 2 {
                break;
            }
        }
    }
}

/// The measurement of one planner on one problem with one budget.
struct CurveRow {
    surveillance: bool,
    targets: usize,
    mission: String,
    planner: String,
    units: u64,
    cpu_s: f64,
    value: f64,
}

fn read(text: &str) -> Vec<CurveRow> {
    let row = |line: &str| {
        let words: Vec<&str> = line.split(',').collect();
        let [kind, targets, mission, planner, units, _, cpu_s, value] = words.as_slice() else { return None };
        Some(CurveRow {
            surveillance: *kind == "surveillance",
            targets: targets.parse().ok()?,
            mission: (*mission).to_string(),
            planner: (*planner).to_string(),
            units: units.parse().ok()?,
            cpu_s: cpu_s.parse().ok()?,
            value: value.parse().ok()?,
        })
    };
    text.lines().skip(1).map(|line| row(line).expect("a row of figures")).collect()
}

/// Returns the mean processor seconds and mean loss in per cent over the missions of a count, for each planner and budget. A planner that
/// ended early keeps its last plan.
fn curves(rows: &[CurveRow], surveillance: bool, targets: usize) -> BTreeMap<String, Vec<(u64, f64, f64)>> {
    let chosen: Vec<&CurveRow> =
        rows.iter().filter(|row| row.surveillance == surveillance && row.targets == targets).collect();
    let best = |mission: &str| {
        let values = chosen.iter().filter(|row| row.mission == mission).map(|row| row.value);
        if surveillance { values.fold(f64::INFINITY, f64::min) } else { values.fold(f64::NEG_INFINITY, f64::max) }
    };
    let loss = |row: &CurveRow| {
        let ratio = row.value / best(&row.mission);
        100.0 * if surveillance { ratio - 1.0 } else { 1.0 - ratio }
    };
    let mut found = BTreeMap::new();
    for (planner, _) in COLOURS {
        let mut line = Vec::new();
        for units in BUDGETS {
            if !chosen.iter().any(|row| row.planner == planner && row.units == units) {
                continue;
            }
            let mut sums = (0.0, 0.0, 0.0);
            for mission in 0..MISSIONS {
                let mission = mission.to_string();
                let runs = chosen.iter().filter(|row| row.planner == planner && row.mission == mission);
                let Some(run) = runs.filter(|row| row.units <= units).max_by_key(|row| row.units) else { continue };
                sums = (sums.0 + run.cpu_s, sums.1 + loss(run), sums.2 + 1.0);
            }
            line.push((units, sums.0 / sums.2, sums.1 / sums.2));
        }
        if !line.is_empty() {
            found.insert(planner.to_string(), line);
        }
    }
    found
}

/// A panel with logarithmic axes.
struct Panel {
    left: f64,
    top: f64,
    across: (f64, f64),
}

impl Panel {
    fn x(&self, value: f64) -> f64 {
        let (low, high) = self.across;
        self.left + PANEL.0 * libm::log10(value.clamp(low, high) / low) / libm::log10(high / low)
    }
    fn y(&self, loss: f64) -> f64 {
        let (low, high) = LOSS;
        self.top + PANEL.1 * (1.0 - libm::log10(loss.clamp(low, high) / low) / libm::log10(high / low))
    }

    fn frame(&self, out: &mut String, title: &str, below: &str, ticks: &[(f64, &str)]) {
        let (left, top, right, bottom) = (self.left, self.top, self.left + PANEL.0, self.top + PANEL.1);
        let _ = writeln!(out, "<text x=\"{left:.0}\" y=\"{:.0}\" font-weight=\"bold\">{title}</text>", top - 10.0);
        for (value, word) in ticks {
            let x = self.x(*value);
            let _ = writeln!(out, "<path d=\"M{x:.1} {top:.1}V{bottom:.1}\" stroke=\"#e4e4e4\"/>");
            let _ = writeln!(out, "<text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{word}</text>", bottom + 16.0);
        }
        for (value, word) in [(0.1, "0.1 %"), (1.0, "1 %"), (10.0, "10 %"), (100.0, "100 %")] {
            let y = self.y(value);
            let _ = writeln!(out, "<path d=\"M{left:.1} {y:.1}H{right:.1}\" stroke=\"#e4e4e4\"/>");
            let _ =
                writeln!(out, "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{word}</text>", left - 6.0, y + 4.0);
        }
        let (middle, under) = (left + PANEL.0 / 2.0, bottom + 34.0);
        let _ = writeln!(out, "<text x=\"{middle:.1}\" y=\"{under:.1}\" text-anchor=\"middle\">{below}</text>");
        let _ = writeln!(
            out,
            "<rect x=\"{left:.1}\" y=\"{top:.1}\" width=\"{}\" height=\"{}\" fill=\"none\" stroke=\"#888\"/>",
            PANEL.0, PANEL.1
        );
    }

    fn line(&self, out: &mut String, points: &[(f64, f64)], colour: &str, dashes: &str, name: &str) {
        let path: Vec<String> = points.iter().map(|(x, y)| format!("{:.1} {:.1}", self.x(*x), self.y(*y))).collect();
        let _ = writeln!(
            out,
            "<path d=\"M{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\"{dashes}><title>{name}</title></path>",
            path.join("L")
        );
        for (x, y) in points {
            let (at_x, at_y) = (self.x(*x), self.y(*y));
            let _ = writeln!(
                out,
                "<circle cx=\"{at_x:.1}\" cy=\"{at_y:.1}\" r=\"3\" fill=\"{colour}\"><title>{name}: {x:.4}, {y:.2} %</title></circle>"
            );
        }
    }
}

fn colour(planner: &str) -> &'static str {
    COLOURS.iter().find(|(name, _)| *name == planner).map_or("#000000", |(_, colour)| colour)
}

fn draw(rows: &[CurveRow]) -> String {
    let (width, height) = (3.0 * (PANEL.0 + ROOM.0) + 20.0, 2.0 * (PANEL.1 + ROOM.1) + 60.0);
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {height:.0}\" width=\"{width:.0}\" height=\"{height:.0}\" font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
    );
    for (index, (planner, colour)) in COLOURS.iter().enumerate() {
        let x = ROOM.0 + 160.0 * index as f64;
        let _ = writeln!(
            out,
            "<rect x=\"{x}\" y=\"14\" width=\"14\" height=\"6\" fill=\"{colour}\"/><text x=\"{}\" y=\"21\">{planner}</text>",
            x + 20.0
        );
    }
    let place = |column: usize, row: usize, across: (f64, f64)| Panel {
        left: ROOM.0 + column as f64 * (PANEL.0 + ROOM.0),
        top: 62.0 + row as f64 * (PANEL.1 + ROOM.1),
        across,
    };
    let seconds = [(4e-3, "4 ms"), (1e-2, "10 ms"), (0.1, "0.1 s"), (1.0, "1 s"), (10.0, "10 s")];
    for (column, row, targets) in [(0, 0, 10), (1, 0, 100), (2, 0, 300), (2, 1, 1_000)] {
        let panel = place(column, row, SECONDS);
        panel.frame(
            &mut out,
            &format!("surveillance, {targets} targets: cost above the best"),
            "processor time",
            &seconds,
        );
        for (planner, line) in curves(rows, true, targets) {
            let points: Vec<(f64, f64)> = line.iter().map(|(_, cpu_s, loss)| (*cpu_s, *loss)).collect();
            panel.line(&mut out, &points, colour(&planner), "", &planner);
        }
    }
    let counts = [(10.0, "10"), (30.0, "30"), (100.0, "100"), (300.0, "300"), (1_000.0, "1,000")];
    let panel = place(0, 1, (8.0, 1_250.0));
    panel.frame(&mut out, "surveillance: loss after about 0.1 s, by targets", "targets", &counts);
    for (planner, _) in COLOURS {
        let at = |count: usize| {
            let line = curves(rows, true, count).remove(planner)?;
            line.iter().rfind(|(units, _, _)| *units <= GROWTH_BUDGET).map(|(_, _, loss)| (count as f64, *loss))
        };
        let points: Vec<(f64, f64)> = WATCHED.into_iter().filter_map(at).collect();
        if !points.is_empty() {
            panel.line(&mut out, &points, colour(planner), "", planner);
        }
    }
    let panel = place(1, 1, SECONDS);
    panel.frame(&mut out, "orienteering: value below the best", "processor time", &seconds);
    for (targets, dashes) in VISITED.into_iter().zip([" stroke-dasharray=\"2 3\"", " stroke-dasharray=\"7 3\"", ""]) {
        for (planner, line) in curves(rows, false, targets) {
            let points: Vec<(f64, f64)> = line.iter().map(|(_, cpu_s, loss)| (*cpu_s, *loss)).collect();
            panel.line(&mut out, &points, colour(&planner), dashes, &format!("{targets} targets"));
            if let Some((x, y)) = points.first() {
                let (x, y) = (panel.x(*x) + 6.0, panel.y(*y) - 4.0);
                let _ = writeln!(out, "<text x=\"{x:.1}\" y=\"{y:.1}\">{targets}</text>");
            }
        }
    }
    out.push_str("</svg>\n");
    out
}
