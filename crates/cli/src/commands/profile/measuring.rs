//! Runs the tasks of a measurement on several threads, with a progress bar.

use crate::error::{CliError, CliResult};
use crate::options::ProfileWorkOptions;
use indicatif::{ProgressBar, ProgressStyle};

/// Maximum number of threads.
const THREADS_MAX: usize = 1024;

/// Runs `task` for each number below `count`. A progress bar with title `title` is shown on standard error.
///
/// # Errors
/// The error of the first task (by number) that failed; no further task is started afterwards.
pub(super) fn each<T: Send>(
    options: &ProfileWorkOptions,
    title: &str,
    count: usize,
    task: impl Fn(usize) -> Result<T, String> + Sync,
) -> CliResult<Vec<T>> {
    let threads = threads(options)?.min(count.max(1));
    let bar = bar(options, title, count);
    let done = apex_portfolio::parallel::each(threads, count, task, || bar.inc(1));
    bar.finish_and_clear();
    done.map_err(|why| {
        CliError::failure("the measurement was abandoned")
            .because(why)
            .help("the planner made no valid plan: correct it, or measure without it")
    })
}

fn threads(options: &ProfileWorkOptions) -> CliResult<usize> {
    match options.threads {
        None => Ok(std::thread::available_parallelism().map_or(1, usize::from)),
        Some(threads) if (1..=THREADS_MAX).contains(&threads) => Ok(threads),
        Some(threads) => Err(CliError::user(format!("invalid value `{threads}` for `--threads`"))
            .help(format!("write a number from 1 to {THREADS_MAX}"))),
    }
}

fn bar(options: &ProfileWorkOptions, title: &str, count: usize) -> ProgressBar {
    let bar = if options.no_progress { ProgressBar::hidden() } else { ProgressBar::new(count as u64) };
    if let Ok(style) = ProgressStyle::with_template("{bar:40} {percent:>3} %  {msg}  (real {elapsed}, left {eta})") {
        bar.set_style(style);
    }
    bar.set_message(title.to_string());
    bar
}

/// Returns the CPU time of this process; `None` if the system does not report it.
pub(super) fn cpu_s() -> Option<f64> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    // After the name in brackets: state is the third field, user and system time are the 14th and 15th, in hundredths of a second.
    let (_, fields) = stat.rsplit_once(')')?;
    let ticks: Vec<f64> = fields.split_whitespace().skip(11).take(2).filter_map(|ticks| ticks.parse().ok()).collect();
    (ticks.len() == 2).then(|| ticks.iter().sum::<f64>() / 100.0)
}
