//! The vehicle models that ship with Apex, embedded from `library/vehicles/`.

use crate::model::VehicleModel;

/// A vehicle file that ships with Apex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ShippedVehicle {
    /// The name by which a mission asks for it.
    pub name: &'static str,
    /// The name of its file in the repository and in flight records.
    pub file: &'static str,
    /// The file's text.
    pub text: &'static str,
}

/// All of them, by name.
pub const SHIPPED: &[ShippedVehicle] = &[
    ShippedVehicle {
        name: "predator-b",
        file: "library/vehicles/predator-b.json",
        text: include_str!("../../../library/vehicles/predator-b.json"),
    },
    ShippedVehicle {
        name: "rmax",
        file: "library/vehicles/rmax.json",
        text: include_str!("../../../library/vehicles/rmax.json"),
    },
];

impl ShippedVehicle {
    /// Returns the shipped vehicle file called `name`, in any case.
    ///
    /// # Errors
    /// An error message that lists the shipped models if none has this name.
    pub fn find(name: &str) -> Result<ShippedVehicle, String> {
        let folded = name.to_lowercase();
        SHIPPED.iter().find(|shipped| shipped.name == folded).copied().ok_or_else(|| {
            let names = || SHIPPED.iter().map(|shipped| shipped.name);
            let hint = crate::section::nearest(&folded, names()).map(|near| format!("; did you mean `{near}`?"));
            let known: Vec<&str> = names().collect();
            format!("unknown vehicle model `{name}`{} (known: {})", hint.unwrap_or_default(), known.join(", "))
        })
    }
}

impl VehicleModel {
    /// Returns the shipped model called `name`, in any case.
    ///
    /// # Errors
    /// As [`ShippedVehicle::find`]; a shipped file that is invalid, which a test excludes.
    pub fn named(name: &str) -> Result<VehicleModel, String> {
        let shipped = ShippedVehicle::find(name)?;
        VehicleModel::parse(shipped.file, shipped.text).map_err(|error| error.to_string())
    }
}
