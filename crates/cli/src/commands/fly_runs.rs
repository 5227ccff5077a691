//! `apex fly --runs`: many flights of a mission as a table and a summary.

use crate::error::CliResult;
use crate::options::FlyOptions;
use crate::{output, stopping};
use apex_mission::Mission;
use apex_mission::deliberation::PlanningResources;
use apex_model::time::Time;
use apex_simulation::{RunSummary, RunTerms, RunsTable, fly_runs};
use indicatif::{ProgressBar, ProgressStyle};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Flies the series, writes its table, prints its summary. Ctrl-C ends it after the flights in progress.
pub fn run(
    options: &FlyOptions,
    runs: usize,
    until: Option<Time>,
    mission: &Arc<Mission>,
    means: &PlanningResources,
) -> CliResult {
    let table = options.out.as_deref().map(RunsTable::open).transpose()?;
    let jobs = options.jobs.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, usize::from));
    let terms = RunTerms { first_seed: options.seed, runs, jobs, until };
    let stopped = Arc::new(AtomicBool::new(false));
    let signal = Arc::clone(&stopped);
    stopping::at_signal(move || signal.store(true, Ordering::Relaxed));
    let bar = runs_bar(runs, options.no_progress || options.json);
    let rows = fly_runs(mission, means, &terms, || {
        bar.inc(1);
        !stopped.load(Ordering::Relaxed)
    });
    bar.finish_and_clear();
    let rows = rows?;
    table.map_or(Ok(()), |table| table.write(&rows))?;
    let summary = RunSummary::of(&rows);
    if options.json {
        return output::print_line(serde_json::json!({ "summary": summary, "runs": rows }));
    }
    output::print(summary)?;
    let told = |path: &Path| output::print_line(format_args!("Table: {} rows in {}", rows.len(), path.display()));
    options.out.as_deref().map_or(Ok(()), told)
}

/// Returns a bar over the flights of a series.
fn runs_bar(runs: usize, hidden: bool) -> ProgressBar {
    let bar = if hidden { ProgressBar::hidden() } else { ProgressBar::new(runs as u64) };
    if let Ok(style) = ProgressStyle::with_template("{bar:40} {pos} of {len} flights  (real {elapsed}, left {eta})") {
        bar.set_style(style);
    }
    bar
}
