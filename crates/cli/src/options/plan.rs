//! Options of `apex plan`.

use clap::Args;
use std::path::PathBuf;

/// `apex plan`
#[derive(Args)]
pub struct PlanOptions {
    /// The mission's folder, or its `mission.pdl`; a problem in a file of JSON, or in a benchmark's format (TOPTW, Solomon,
    /// OPLib, TSPLIB); or a test mission, such as `small-fixed-fixed-8-uniform` or `small-fixed-fixed-8-uniform@7`.
    pub mission: PathBuf,
    /// Number of vehicles; plans are for one vehicle, even if a benchmark file names more.
    #[arg(long, value_name = "NUMBER")]
    pub vehicles: Option<usize>,
    /// Use this solver instead of the one that solver selection chooses.
    #[arg(long, value_name = "NAME")]
    pub solver: Option<String>,
    /// Choose the solver by this table instead of the one that ships; `apex profile build --table` writes one.
    #[arg(long, value_name = "FILE", conflicts_with = "solver")]
    pub table: Option<PathBuf>,
    /// Planners that are programs.
    #[command(flatten)]
    pub programs: super::SolverProgramOptions,
    /// Time limit of the solver, in the time of a flight; default is the mission's own, or 10 s.
    #[arg(long, value_name = "TIME")]
    pub budget: Option<String>,
    /// Time limit of proofs (upper bounds on any plan), in the time of a flight. Default is 10 s, which suffices for every known
    /// proof of up to 24 targets of surveillance; with `--budget` it is the time that planning did not use plus a twentieth of
    /// the budget or 0.5 s, whichever is longer, and at most 10 s.
    #[arg(long, allow_hyphen_values = true, value_name = "TIME")]
    pub bound_budget: Option<String>,
    /// Seed of the solver's random numbers; default is the mission's own, or 1.
    #[arg(long, value_name = "NUMBER")]
    pub seed: Option<u64>,
    /// Do not plan: these targets in this order are an operator's plan (planner `human`), to be scored and printed like any other.
    #[arg(long, value_delimiter = ',', value_name = "TARGET,..", conflicts_with_all = ["solver", "table"])]
    pub visits: Vec<String>,
    /// Do not plan: this file holds a plan as `--json` prints it, drawn or edited by an operator (planner `human`), to be checked,
    /// scored and printed like any other.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["visits", "solver", "table", "problem"])]
    pub plan: Option<PathBuf>,
    /// Take only the order of the plan's visits (and their manoeuvres), and compute the times again.
    #[arg(long, requires = "plan")]
    pub retime: bool,
    /// For surveillance: the visits are a cycle that the vehicle repeats.
    #[arg(long, requires = "visits")]
    pub repeat: bool,
    /// For surveillance: also print the cost of the plan if only the first event after an observation counts, which suits events that are
    /// not rare.
    #[arg(long)]
    pub survival: bool,
    /// Do not plan: print the problem as JSON.
    #[arg(long, conflicts_with_all = ["solver", "budget", "bound_budget", "format", "json", "survival"])]
    pub problem: bool,
    /// Format of the plan; default is that of the name of `--out`, or a table.
    #[arg(long, value_enum, conflicts_with = "json")]
    pub format: Option<PlanFormat>,
    /// Print as JSON: short for `--format json`.
    #[arg(long)]
    pub json: bool,
    /// Output of the plan; default is standard output.
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// For `--format qgc`: height of the whole flight above the start, for example `60m`; required if the problem has no altitudes.
    #[arg(long, allow_hyphen_values = true, value_name = "HEIGHT")]
    pub height: Option<String>,
}

/// Format of a plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum PlanFormat {
    /// A table for operators.
    Table,
    /// One object with the plan, its value, bound and processor time.
    Json,
    /// A procedure for the mission's goal.
    Pdl,
    /// The path, the targets and the airspace for maps.
    Geojson,
    /// The same for virtual globes.
    Kml,
    /// Mission items and a fence for QGroundControl.
    Qgc,
}
