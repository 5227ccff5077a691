//! The options of `apex profile`.

use clap::{Args, Subcommand};
use std::path::PathBuf;

/// The commands of `apex profile`.
#[derive(Subcommand)]
pub enum ProfileCommand {
    /// Measure planners on the missions of cells, and write the profile.
    Build(ProfileBuildOptions),
    /// Measure some planners again, or new ones, and put them into a profile.
    Update(ProfileUpdateOptions),
    /// Merge parts that were measured separately into one profile, for example parts from several machines.
    Merge(ProfileMergeOptions),
    /// Print the best planner of each cell, or draw it.
    Show(ProfileShowOptions),
    /// Compare two profiles, a profile with the paper's Figure 4, or the choices of selection with the best planners.
    Compare(ProfileCompareOptions),
}

/// `apex profile build`
#[derive(Args)]
pub struct ProfileBuildOptions {
    /// The profile to write.
    pub profile: PathBuf,
    /// Cells such as `small-fixed-fixed-8-uniform`, or `all` (243, the default) or `subset` (27).
    #[arg(long, value_delimiter = ',', value_name = "CELL,..", default_value = "all")]
    pub cells: Vec<String>,
    /// Number of missions of each cell.
    #[arg(long, value_name = "NUMBER", default_value_t = 50)]
    pub missions: u64,
    /// Planning times, ascending; a millisecond is 1,000 units of work.
    #[arg(long, value_delimiter = ',', value_name = "TIME,..", default_value = "1ms,3ms,10ms")]
    pub budgets: Vec<String>,
    /// Planners to measure.
    #[arg(
        long,
        value_delimiter = ',',
        value_name = "NAME,..",
        default_value = "nearest-neighbour,two-opt,wam,anytime"
    )]
    pub planners: Vec<String>,
    /// Also write the table that solver selection reads, as CSV.
    #[arg(long, value_name = "FILE")]
    pub table: Option<PathBuf>,
    /// Options of the measurement.
    #[command(flatten)]
    pub work: ProfileWorkOptions,
}

/// `apex profile update`
#[derive(Args)]
pub struct ProfileUpdateOptions {
    /// The profile to change.
    pub profile: PathBuf,
    /// Planners to measure again, or to add; without any, only the table is written again.
    #[arg(long, value_delimiter = ',', value_name = "NAME,..")]
    pub planners: Vec<String>,
    /// Also write the table that solver selection reads, as CSV.
    #[arg(long, value_name = "FILE")]
    pub table: Option<PathBuf>,
    /// Options of the measurement.
    #[command(flatten)]
    pub work: ProfileWorkOptions,
}

/// `apex profile merge`
#[derive(Args)]
pub struct ProfileMergeOptions {
    /// The profile to write.
    pub profile: PathBuf,
    /// Profiles of the same missions and budgets, of some cells or some planners each.
    #[arg(required = true, value_name = "PART")]
    pub parts: Vec<PathBuf>,
    /// Also write the table that solver selection reads, as CSV.
    #[arg(long, value_name = "FILE")]
    pub table: Option<PathBuf>,
}

/// Options of a measurement of planners.
#[derive(Args)]
pub struct ProfileWorkOptions {
    /// Missions measured at the same time; the result does not depend on it. Default is one for each core.
    #[arg(long, value_name = "NUMBER")]
    pub threads: Option<usize>,
    /// Print neither a progress bar nor times.
    #[arg(long)]
    pub no_progress: bool,
}

/// `apex profile show`
#[derive(Args)]
pub struct ProfileShowOptions {
    /// The profile; default is the one that ships.
    pub profile: Option<PathBuf>,
    /// Only this planning time.
    #[arg(long, value_name = "TIME")]
    pub budget: Option<String>,
    /// Only this cell, with every planner.
    #[arg(long, value_name = "CELL")]
    pub cell: Option<String>,
    /// Draw heat maps instead, as SVG.
    #[arg(long, value_name = "FILE", conflicts_with = "cell")]
    pub svg: Option<PathBuf>,
    /// Draw the paper's Figure 4 next to the measured results.
    #[arg(long, requires = "svg")]
    pub figure_4: bool,
    /// Print as JSON lines.
    #[arg(long, conflicts_with = "svg")]
    pub json: bool,
}

/// `apex profile compare`
#[derive(Args)]
pub struct ProfileCompareOptions {
    /// The profile; default is the one that ships.
    pub profile: Option<PathBuf>,
    /// The profile to compare with; default is the paper's Figure 4.
    pub with: Option<PathBuf>,
    /// Run selection on missions that no profile has seen, and print by how much its choices cost more than the best planner's.
    #[arg(long, conflicts_with_all = ["profile", "with"])]
    pub regret: bool,
    /// Numbers of targets for which regret is measured.
    #[arg(
        long,
        value_delimiter = ',',
        value_name = "NUMBER,..",
        default_value = "4,6,8,12,16,24",
        requires = "regret"
    )]
    pub counts: Vec<usize>,
    /// Number of missions of each cell on which regret is measured.
    #[arg(long, value_name = "NUMBER", default_value_t = 2, requires = "regret")]
    pub missions: u64,
    /// Planning times that are compared; default is every planning time of the profile.
    #[arg(long, value_delimiter = ',', value_name = "TIME,..")]
    pub budgets: Vec<String>,
    /// Options of the measurement.
    #[command(flatten)]
    pub work: ProfileWorkOptions,
    /// Print as JSON lines.
    #[arg(long)]
    pub json: bool,
}
