//! The vehicle of a mission: its model from a vehicle file, and its figures as constants of PDL.

use crate::Files;
use crate::error::{ErrorKind, MissionError, MissionResult};
use crate::files::text_of;
use crate::settings;
use apex_geo::coverage::LineScanner;
use apex_model::library::Library;
use apex_pdl::SourceText;
pub use apex_vehicle::{Airframe, VehicleModel};
use apex_vehicle::{ShippedVehicle, VehicleFileError};
use std::fmt::Write;
use std::path::Path;

/// The library of constants that the vehicle file of a mission defines. The text that ships has the figures of `predator-b`.
pub const FIGURES_LIBRARY: &str = "vehicle-figures";
/// Name of the text that replaces it. Records find it by the last part, as they find all libraries.
const FIGURES_NAME: &str = "generated/vehicle-figures.pdl";
const SHIPPED_FIGURES_NAME: &str = "library/vehicle-figures.pdl";

/// Where a mission's vehicle model comes from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ModelSource {
    /// A model that ships with Apex, by name.
    Shipped(String),
    /// A vehicle file, relative to the mission's folder.
    File(String),
}

/// Reads the vehicle model and keeps the bytes of its file for the record. Of a shipped model, the copy that a record holds
/// counts more than the one of this version.
///
/// # Errors
/// An unknown model, a file that cannot be read or is invalid.
pub(crate) fn load(source: &ModelSource, files: &mut Files<'_>) -> MissionResult<VehicleModel> {
    match source {
        ModelSource::Shipped(name) => {
            let (file, text) = match files.sources.held(&format!("library/vehicles/{name}.json")) {
                Some(bytes) => (format!("library/vehicles/{name}.json"), text_of(name, bytes.to_vec())?),
                None => {
                    let shipped = ShippedVehicle::find(name).map_err(|reason| {
                        MissionError::setting("the mission's vehicle is unknown")
                            .at(&files.place)
                            .because(reason)
                            .help("write a known `:model` in :vehicle, or the name of a vehicle file in quotes")
                    })?;
                    (shipped.file.to_string(), shipped.text.to_string())
                }
            };
            let model = VehicleModel::parse(&file, &text).map_err(invalid)?;
            files.data.push((file, text.into_bytes()));
            Ok(model)
        }
        ModelSource::File(name) => {
            let model = files.read("model", &Some(name.clone()), |file| {
                VehicleModel::parse(&file.place, &file.text()?).map_err(invalid)
            })?;
            model.ok_or_else(|| MissionError::new(ErrorKind::Vehicle, format!("{name}: no vehicle model")))
        }
    }
}

fn invalid(error: VehicleFileError) -> MissionError {
    MissionError::new(ErrorKind::Vehicle, error.place()).because(error.reason()).help(error.help)
}

/// Returns the line scanner of a vehicle; `None` if it carries none.
pub(crate) fn line_scanner(model: &VehicleModel) -> Option<LineScanner> {
    let scanner = model.scanner.as_ref()?;
    Some(LineScanner { field_of_view_deg: scanner.field_of_view_deg, pixel_mrad: scanner.pixel_mrad })
}

/// Returns the text that has to replace the library of figures in a program: `None` if the program does not use that
/// library, names no vehicle that can be read, or has the vehicle whose figures ship.
pub(crate) fn figures_for(
    library: &Library,
    folder: &Path,
    read: &mut dyn FnMut(&Path) -> MissionResult<String>,
) -> Option<SourceText> {
    let shipped = library.sources.iter().find(|source| &*source.name == SHIPPED_FIGURES_NAME)?;
    let application = library.application.as_ref()?;
    application.option("vehicle")?;
    // Errors of the vehicle are reported when the mission is loaded.
    let model = match settings::vehicle_of(application, String::new()).ok()?.0 {
        ModelSource::Shipped(name) => VehicleModel::named(&name).ok()?,
        ModelSource::File(name) => VehicleModel::parse(&name, &read(&folder.join(&name)).ok()?).ok()?,
    };
    let text = figures(&model);
    (text != *shipped.text).then(|| SourceText { name: FIGURES_NAME.to_string(), text })
}

/// Returns the figures of a vehicle as a library of PDL.
pub fn figures(model: &VehicleModel) -> String {
    let constants = [
        ("level-roll-max", model.level_roll_deg_max, "deg"),
        ("bank-max", model.bank_deg_max, "deg"),
        ("cruise-airspeed", model.true_airspeed_m_s_cruise, "m/s"),
        ("airspeed-max", model.true_airspeed_m_s_max, "m/s"),
        ("climb-rate-max", model.climb_rate_m_s_max, "m/s"),
        ("descent-rate-max", model.descent_rate_m_s_max, "m/s"),
        ("ceiling", model.ceiling_m, "m"),
        ("cruise-altitude", model.planning.cruise_altitude_m, "m"),
        ("fuel-capacity", model.fuel.capacity_kg, "kg"),
        ("low-fuel", model.fuel.low_kg, "kg"),
        ("reserve-share", model.planning.reserve_share, ""),
    ];
    let mut text = format!(
        ";;; Figures of the vehicle `{}`, from its vehicle file. A mission's own vehicle replaces this text; a program without a\n\
         ;;; vehicle has the figures of `predator-b`. Generated: docs/reference/vehicles.md describes each.\n\n\
         (in-apex-bundle :vehicle-figures)\n\n",
        model.name
    );
    for (name, value, unit) in constants {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "(defconstant +vehicle-{name}+ {value}{unit})");
    }
    text
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a failed test should stop")]

    use super::*;

    #[test]
    fn the_shipped_figures_are_those_of_predator_b() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(SHIPPED_FIGURES_NAME);
        assert_eq!(crate::files::read_text(&path).unwrap(), figures(&VehicleModel::named("predator-b").unwrap()));
    }
}
