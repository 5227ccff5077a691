//! The vehicle of a mission: its model from a vehicle file, and its figures as constants of PDL.

pub(crate) mod stated;

use crate::Files;
use crate::error::{ErrorKind, MissionError, MissionResult};
use crate::files::text_of;
use crate::sources::Sources;
use apex_geo::travel;
use apex_model::library::Library;
use apex_pdl::SourceText;
pub use apex_vehicle::{Airframe, VehicleModel};
use apex_vehicle::{CruiseLevel, EnergyModel, JOULES_PER_WH, ShippedSensor, ShippedVehicle, VehicleFileError};
pub use stated::ModelSource;
use stated::vehicle_of;
use std::fmt::Write;
use std::path::Path;

/// The library of constants that the vehicle file of a mission defines. The text that ships has the figures of `predator-b`.
pub const FIGURES_LIBRARY: &str = "vehicle-figures";
/// Name of the generated text. Records find it by its last part, like all libraries.
const FIGURES_NAME: &str = "generated/vehicle-figures.pdl";
const SHIPPED_FIGURES_NAME: &str = "library/vehicle-figures.pdl";

/// Reads a vehicle model with its sensors: a shipped one by name, or a vehicle file, whose name ends in `.json`.
///
/// # Errors
/// An unknown model, a path to something else than a vehicle file, a file that cannot be read or is invalid.
pub fn read(name: &str) -> MissionResult<VehicleModel> {
    let path = Path::new(name);
    let is_file = path.extension().is_some_and(|extension| extension == "json");
    if !is_file && (path.extension().is_some() || name.contains('/')) {
        return Err(MissionError::setting(format!("`{name}` names no vehicle"))
            .because("a vehicle file is a JSON file whose name ends in .json")
            .help("write the name of such a file, or of a shipped model; `apex vehicle` lists them"));
    }
    let file = path.file_name().filter(|_| is_file).map(|file| file.to_string_lossy().into_owned());
    let source = file.map_or_else(|| ModelSource::Shipped(name.to_string()), ModelSource::File);
    let sources = Sources::Folder(path.parent().unwrap_or(Path::new("")).to_path_buf());
    let place_of = |_: &str| "the command line".to_string();
    load(&source, &mut Files { sources: &sources, place_of: &place_of, data: Vec::new() })
}

/// Reads the vehicle model and keeps the bytes of its file for the record. For a shipped model, a copy in a record has precedence over
/// that of this version.
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
                        MissionError::setting("the vehicle model is unknown")
                            .at((files.place_of)("vehicle"))
                            .because(reason)
                            .help("write the name of a shipped model, or the name of a vehicle file: in quotes, with its ending .json")
                    })?;
                    (shipped.file.to_string(), shipped.text.to_string())
                }
            };
            let model = with_sensors(&file, &text, files)?;
            files.data.push((file, text.into_bytes()));
            Ok(model)
        }
        ModelSource::File(name) => {
            let file = files.read("model", &Some(name.clone()), |file| Ok((file.place.clone(), file.text()?)))?;
            let (place, text) =
                file.ok_or_else(|| MissionError::new(ErrorKind::Vehicle, format!("{name}: no vehicle model")))?;
            with_sensors(&place, &text, files)
        }
    }
}

/// Reads a vehicle model with its sensors and keeps the bytes of the sensor files for the record.
fn with_sensors(file: &str, text: &str, files: &mut Files<'_>) -> MissionResult<VehicleModel> {
    let place = file.to_string();
    let mut read: Vec<(String, Vec<u8>)> = Vec::new();
    let sources = files.sources;
    let parsed = VehicleModel::parse_with(file, text, &mut |reference: &str| {
        let (name, place, bytes) = sensor_file(reference, sources, &place)?;
        let text = text_of(&place, bytes.clone()).map_err(|error| error.to_string())?;
        read.push((name, bytes));
        Ok(Some((place, text)))
    });
    for (name, bytes) in read {
        if !files.data.iter().any(|(known, _)| *known == name) {
            files.data.push((name, bytes));
        }
    }
    parsed.map_err(invalid)
}

/// Returns the name in the record, the name in messages, and the bytes of the sensor that the vehicle file `vehicle` calls `reference`: a
/// file next to the mission, or a shipped sensor, of which a copy in a record has precedence.
fn sensor_file(reference: &str, sources: &Sources, vehicle: &str) -> Result<(String, String, Vec<u8>), String> {
    if reference.ends_with(".json") {
        let file = sources
            .read(reference, || format!("{vehicle} names it as `\"sensor\": \"{reference}\"`"))
            .map_err(|error| error.to_string())?;
        return Ok((reference.to_string(), file.place, file.bytes));
    }
    let shipped = ShippedSensor::find(reference);
    let name = shipped.as_ref().map_or_else(|_| format!("library/sensors/{reference}.json"), |it| it.file.to_string());
    let bytes = match sources.held(&name) {
        Some(bytes) => bytes.to_vec(),
        None => shipped?.text.as_bytes().to_vec(),
    };
    Ok((name.clone(), name, bytes))
}

fn invalid(error: VehicleFileError) -> MissionError {
    MissionError::new(ErrorKind::Vehicle, error.place()).because(error.reason()).help(error.help)
}

/// Returns the text that replaces the library of figures in a program; `None` if the program does not use that library, names no readable
/// vehicle, or has the vehicle whose figures ship.
pub(crate) fn figures_for(
    library: &Library,
    folder: &Path,
    read: &mut dyn FnMut(&Path) -> MissionResult<String>,
) -> Option<SourceText> {
    let shipped = library.sources.iter().find(|source| &*source.name == SHIPPED_FIGURES_NAME)?;
    let application = library.application.as_ref()?;
    application.option("vehicle")?;
    // Errors of the vehicle are reported when the mission is loaded.
    let model = match vehicle_of(application, library).ok()?.model {
        ModelSource::Shipped(name) => VehicleModel::named(&name).ok()?,
        ModelSource::File(name) => {
            let text = read(&folder.join(&name)).ok()?;
            let mut sensor = |reference: &str| match reference.ends_with(".json") {
                true => read(&folder.join(reference))
                    .map(|text| Some((reference.to_string(), text)))
                    .map_err(|error| error.to_string()),
                false => Ok(None),
            };
            VehicleModel::parse_with(&name, &text, &mut sensor).ok()?
        }
    };
    let text = figures(&model);
    (text != *shipped.text).then(|| SourceText { name: FIGURES_NAME.to_string(), text })
}

/// Returns the figures of a vehicle as a library of PDL.
pub fn figures(model: &VehicleModel) -> String {
    let (capacity_kg, low_kg, low_share, hour_w) = match model.energy {
        EnergyModel::Fuel(_) => (model.stored_full(), (model.low() * 10.0).round() / 10.0, 0.0, 0.0),
        EnergyModel::Battery(_) => {
            let low_share = (model.low() / model.stored_full() * 1e4).round() / 1e4;
            (0.0, 0.0, low_share, (model.stored_full() / JOULES_PER_WH * 10.0).round() / 10.0)
        }
    };
    let cruise = match model.planning.cruise {
        CruiseLevel::Altitude(altitude_m) => ("cruise-altitude", altitude_m, "m"),
        CruiseLevel::Height(height_m) => ("cruise-height", height_m, "m"),
    };
    let way_m = way_altitude_m_max(model);
    let circle_m = (model.turns.circle_width * turn_radius_m(model)).round();
    let reserve_share = (model.reserve() / model.stored_full() * 1e4).round() / 1e4;
    let constants = [
        ("level-roll-max", model.level_roll_deg_max, "deg"),
        ("bank-max", model.bank_deg_max, "deg"),
        ("cruise-airspeed", model.true_airspeed_m_s_cruise, "m/s"),
        ("airspeed-max", model.true_airspeed_m_s_max, "m/s"),
        ("climb-rate-max", model.climb_rate_m_s_max, "m/s"),
        ("descent-rate-max", model.descent_rate_m_s_max, "m/s"),
        ("ceiling", model.ceiling_m, "m"),
        ("circle-radius", circle_m, "m"),
        ("wind-max", model.wind_m_s_max, "m/s"),
        cruise,
        ("way-altitude-max", way_m, "m"),
        ("fuel-capacity", capacity_kg, "kg"),
        ("low-fuel", low_kg, "kg"),
        ("low-charge", low_share, ""),
        ("hour-power", hour_w, "W"),
        ("reserve-share", reserve_share, ""),
        ("glide-ratio", model.glide_ratio, ""),
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

/// Returns the greatest altitude of a way to a landing place: the cruise altitude, at which plans fly home. For a vehicle that cruises at a
/// height it is the ceiling, because such a vehicle keeps its present altitude.
pub(crate) fn way_altitude_m_max(model: &VehicleModel) -> f64 {
    match model.planning.cruise {
        CruiseLevel::Altitude(altitude_m) => altitude_m,
        CruiseLevel::Height(_) => model.ceiling_m,
    }
}

/// Returns the turn radius that plans assume; 0 for a vehicle that turns on the spot.
pub fn turn_radius_m(model: &VehicleModel) -> f64 {
    match model.airframe {
        Airframe::FixedWing => travel::turn_radius_m(
            model.true_airspeed_m_s_cruise,
            (model.turns.bank_share * model.bank_deg_max).to_radians(),
        ),
        Airframe::Rotorcraft => 0.0,
    }
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
