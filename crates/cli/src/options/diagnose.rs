//! Options of `apex diagnose`.

use clap::Args;
use std::path::PathBuf;

/// `apex diagnose`
#[derive(Args)]
pub struct DiagnoseOptions {
    /// The model file.
    pub model: PathBuf,
    /// Print its testability: D-matrix, detection, isolation, ambiguity groups, redundant tests (the default).
    #[arg(long, conflicts_with_all = ["results", "pdl"])]
    pub report: bool,
    /// Diagnose the test outcomes in this file.
    #[arg(long, value_name = "FILE", conflicts_with = "pdl")]
    pub results: Option<PathBuf>,
    /// Print monitors of its tests and responses to its failures as PDL.
    #[arg(long, conflicts_with = "json")]
    pub pdl: bool,
    /// Print as JSON.
    #[arg(long)]
    pub json: bool,
}
