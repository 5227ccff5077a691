//! Options of `apex fork`.

use clap::Args;
use std::path::PathBuf;

/// `apex fork`
#[derive(Args)]
pub struct ForkOptions {
    /// The flight record.
    pub record: PathBuf,
    /// The instant from which the flight differs, for example `9h`.
    #[arg(long, allow_hyphen_values = true, value_name = "TIME")]
    pub at: String,
    /// Further inputs after the instant, as JSON lines in the format of a scenario.
    #[arg(long, value_name = "FILE")]
    pub inputs: Option<PathBuf>,
    /// Visit these targets in this order instead of planning: `zaca,lick,butler-2`.
    #[arg(long, value_name = "TARGETS", value_delimiter = ',')]
    pub plan: Vec<String>,
    /// Factor on the simulated wind; forecasts do not change.
    #[arg(long, allow_hyphen_values = true, value_name = "FACTOR")]
    pub wind_factor: Option<f64>,
    /// File of the simulated wind; forecasts do not change.
    #[arg(long, value_name = "FILE", conflicts_with = "wind_factor")]
    pub weather: Option<PathBuf>,
    /// Seed of turbulence and radio links.
    #[arg(long, value_name = "NUMBER")]
    pub seed: Option<u64>,
    /// Stop at this mission time.
    #[arg(long, allow_hyphen_values = true, value_name = "TIME")]
    pub until: Option<String>,
    /// The flight record to write; default is the record's name with `-fork`.
    #[arg(long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Planners that are programs.
    #[command(flatten)]
    pub programs: super::SolverProgramOptions,
    /// Print both reports as JSON.
    #[arg(long)]
    pub json: bool,
}
