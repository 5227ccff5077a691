//! `apex fly --runs`: many flights of a mission as a table and a summary.

use crate::error::{CliError, CliResult};
use crate::options::FlyOptions;
use crate::{output, stopping, table_file};
use apex_mission::Mission;
use apex_mission::deliberation::PlanningResources;
use apex_model::time::Time;
use apex_simulation::{RunRow, RunSummary, RunTerms, fly_runs};
use apex_tables::{Cells, write_columns};
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
    let out = options.out.as_deref().map(|path| Ok::<_, CliError>((path, is_parquet(path)?))).transpose()?;
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
    if let Some((path, is_parquet)) = out {
        let file = table_file::created(path)?;
        write_columns(file, is_parquet, &columns(&rows)).map_err(|error| table_file::unwritten(Some(path), &error))?;
    }
    let summary = RunSummary::of(&rows);
    if options.json {
        return output::print_line(serde_json::json!({ "summary": summary, "runs": rows }));
    }
    output::print(summary)?;
    out.map_or(Ok(()), |(path, _)| output::print_line(format_args!("Table: {} rows in {}", rows.len(), path.display())))
}

/// Returns a bar over the flights of a series.
fn runs_bar(runs: usize, hidden: bool) -> ProgressBar {
    let bar = if hidden { ProgressBar::hidden() } else { ProgressBar::new(runs as u64) };
    if let Ok(style) = ProgressStyle::with_template("{bar:40} {pos} of {len} flights  (real {elapsed}, left {eta})") {
        bar.set_style(style);
    }
    bar
}

fn is_parquet(path: &Path) -> CliResult<bool> {
    match path.extension().map(|extension| extension.to_string_lossy().to_ascii_lowercase()).as_deref() {
        Some("parquet" | "pq") => Ok(true),
        Some("csv") => Ok(false),
        _ => Err(CliError::user(format!("the name in `--out {}` does not determine the format", path.display()))
            .help("end the name in .parquet or .csv")),
    }
}

fn columns(rows: &[RunRow]) -> Vec<(&'static str, Cells)> {
    let integers = |cell: fn(&RunRow) -> u64| {
        Cells::Integers(rows.iter().map(|row| i64::try_from(cell(row)).unwrap_or(i64::MAX)).collect())
    };
    let numbers = |cell: fn(&RunRow) -> Option<f64>| Cells::Numbers(rows.iter().map(cell).collect());
    let texts = |cell: fn(&RunRow) -> String| Cells::Texts(rows.iter().map(cell).collect());
    vec![
        ("seed", integers(|row| row.seed)),
        ("outcome", texts(|row| row.outcome.word().to_string())),
        ("reason", texts(|row| row.reason.clone())),
        ("end_s", numbers(|row| Some(row.end_s))),
        ("score", numbers(|row| row.score)),
        ("benefits", numbers(|row| row.benefits)),
        ("expected_cost", numbers(|row| row.expected_cost)),
        ("fires", numbers(|row| row.fires.map(|fires| fires as f64))),
        ("fires_seen", numbers(|row| row.fires_seen.map(|fires| fires as f64))),
        ("realised_cost", numbers(|row| row.realised_cost)),
        ("expected_cost_stated", numbers(|row| row.expected_cost_stated)),
        ("observed", integers(|row| row.observed)),
        ("left_out", integers(|row| row.left_out)),
        ("reflies", integers(|row| row.reflies)),
        ("plans", integers(|row| row.plans)),
        ("positions", integers(|row| row.positions)),
        ("inside_zones", integers(|row| row.inside_zones)),
        ("outside_permitted", integers(|row| row.outside_permitted)),
        ("near_ground", integers(|row| row.near_ground)),
        ("beyond_landing_distance", integers(|row| row.beyond_landing_distance)),
        ("said_broken", integers(|row| row.said_broken)),
    ]
}
