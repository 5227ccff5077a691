//! Options of `apex fly`.

use crate::options::SolverProgramOptions;
use clap::Args;
use std::path::PathBuf;

/// `apex fly`
#[derive(Args)]
pub struct FlyOptions {
    /// The mission's folder, or its `mission.pdl`.
    pub mission: PathBuf,
    /// The flight record to write; default is the mission's name with `.apex` in the current folder.
    #[arg(long, value_name = "FILE")]
    pub record: Option<PathBuf>,
    /// Wait for the disk with each commit of the record, so that a power cut loses nothing that was acknowledged.
    #[arg(long, conflicts_with = "runs")]
    pub power_safe: bool,
    /// Folder on another disk in which the record continues when its own disk accepts no more data.
    #[arg(long, value_name = "FOLDER", conflicts_with = "runs")]
    pub spare_folder: Option<PathBuf>,
    /// Sign the record with the key in this file when it is closed: 64 hexadecimal digits, as `openssl rand -hex 32` writes them.
    #[arg(long, value_name = "FILE", conflicts_with = "runs")]
    pub sign: Option<PathBuf>,
    /// Stop at this mission time, for example `2h`.
    #[arg(long, allow_hyphen_values = true, value_name = "TIME")]
    pub until: Option<String>,
    /// Seed of the simulated world; default is the mission's own.
    #[arg(long, allow_hyphen_values = true, value_name = "NUMBER")]
    pub seed: Option<u64>,
    /// Simulated seconds per second of wall time; default is as fast as possible.
    #[arg(long, allow_hyphen_values = true, value_name = "FACTOR")]
    pub pace: Option<f64>,
    /// Choose the solver by this table instead of the one that ships; `apex profile build --table` writes one.
    #[arg(long, value_name = "FILE")]
    pub table: Option<PathBuf>,
    /// Wall time after which a solver that does not return is abandoned; default is 5 minutes.
    #[arg(long, alias = "solver-patience", value_name = "TIME")]
    pub solver_timeout: Option<String>,
    /// Mebibytes that a solver program may take, or by which this program may grow while a solver works in it; default is 1024.
    #[arg(long, value_name = "NUMBER")]
    pub solver_memory: Option<u32>,
    #[command(flatten)]
    pub programs: SolverProgramOptions,
    /// Fly this many flights, each in a world with the next seed, and print a summary; no record is written.
    #[arg(long, value_name = "NUMBER", conflicts_with_all = ["record", "serve", "pace", "paused"])]
    pub runs: Option<usize>,
    /// Flights at the same time; default is one for each processor. The results do not depend on it.
    #[arg(long, value_name = "NUMBER", requires = "runs")]
    pub jobs: Option<usize>,
    /// Table of the flights of `--runs`, .parquet or .csv.
    #[arg(long, value_name = "FILE", requires = "runs")]
    pub out: Option<PathBuf>,
    /// Serve Sherpa while flying, and continue after the flight.
    #[arg(long)]
    pub serve: bool,
    /// Begin paused: mission time stands still at 0 until the page resumes it.
    #[arg(long)]
    pub paused: bool,
    /// Port of Sherpa.
    #[arg(long, default_value_t = 8040, value_name = "NUMBER", requires = "serve")]
    pub port: u16,
    /// No progress bar.
    #[arg(long)]
    pub no_progress: bool,
    /// Print the report as JSON.
    #[arg(long)]
    pub json: bool,
}
