//! `apex vehicle`: checks vehicle files and prints the figures that follow from them.

use crate::error::CliResult;
use crate::options::VehicleOptions;
use crate::output;
use apex_mission::vehicle;
use apex_vehicle::SHIPPED;

/// Prints each vehicle; without any, the list of those that ship.
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
