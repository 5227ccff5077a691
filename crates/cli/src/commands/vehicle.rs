//! `apex vehicle`: checks vehicle files and prints derived figures.

use crate::error::CliResult;
use crate::options::VehicleOptions;
use crate::output;
use apex_mission::vehicle;
use apex_vehicle::SHIPPED;

/// Prints each vehicle; without names, the list of the shipped ones.
pub fn run(options: &VehicleOptions) -> CliResult {
    if options.vehicles.is_empty() {
        for shipped in SHIPPED {
            output::print_line(format_args!("{}  {}", shipped.name, shipped.file))?;
        }
    }
    for (number, name) in options.vehicles.iter().enumerate() {
        let model = vehicle::read(name)?;
        if number > 0 {
            output::print_line("")?;
        }
        output::print(model.sheet())?;
    }
    Ok(())
}
