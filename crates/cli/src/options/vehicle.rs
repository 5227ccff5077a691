//! Options of `apex vehicle`.

use clap::Args;

/// `apex vehicle`
#[derive(Args)]
pub struct VehicleOptions {
    /// Names of vehicles that ship, or vehicle files that end in .json; without any, those that ship are listed.
    pub vehicles: Vec<String>,
}
