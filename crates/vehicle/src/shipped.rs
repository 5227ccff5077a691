//! The vehicle and sensor models that ship with Apex, embedded from `library/vehicles/` and `library/sensors/`.

use crate::model::VehicleModel;

/// A vehicle file that ships with Apex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ShippedVehicle {
    /// The name by which a mission refers to the vehicle.
    pub name: &'static str,
    /// The name of its file in the repository and in flight records.
    pub file: &'static str,
    /// The file's text.
    pub text: &'static str,
}

/// All shipped vehicle files, in the order of their names.
pub const SHIPPED: &[ShippedVehicle] = &[
    ShippedVehicle {
        name: "fixed-wing-mapper",
        file: "library/vehicles/fixed-wing-mapper.json",
        text: include_str!("../../../library/vehicles/fixed-wing-mapper.json"),
    },
    ShippedVehicle {
        name: "global-hawk",
        file: "library/vehicles/global-hawk.json",
        text: include_str!("../../../library/vehicles/global-hawk.json"),
    },
    ShippedVehicle {
        name: "predator-b",
        file: "library/vehicles/predator-b.json",
        text: include_str!("../../../library/vehicles/predator-b.json"),
    },
    ShippedVehicle {
        name: "quadrotor",
        file: "library/vehicles/quadrotor.json",
        text: include_str!("../../../library/vehicles/quadrotor.json"),
    },
    ShippedVehicle {
        name: "rmax",
        file: "library/vehicles/rmax.json",
        text: include_str!("../../../library/vehicles/rmax.json"),
    },
];

/// A sensor file that ships with Apex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ShippedSensor {
    /// The name by which a vehicle file refers to the sensor.
    pub name: &'static str,
    /// The name of its file in the repository and in flight records.
    pub file: &'static str,
    /// The file's text.
    pub text: &'static str,
}

/// All shipped sensor files, in the order of their names.
pub const SHIPPED_SENSORS: &[ShippedSensor] = &[
    ShippedSensor {
        name: "ams-wildfire",
        file: "library/sensors/ams-wildfire.json",
        text: include_str!("../../../library/sensors/ams-wildfire.json"),
    },
    ShippedSensor {
        name: "mapping-camera",
        file: "library/sensors/mapping-camera.json",
        text: include_str!("../../../library/sensors/mapping-camera.json"),
    },
    ShippedSensor {
        name: "predator-turret",
        file: "library/sensors/predator-turret.json",
        text: include_str!("../../../library/sensors/predator-turret.json"),
    },
    ShippedSensor {
        name: "quadrotor-camera",
        file: "library/sensors/quadrotor-camera.json",
        text: include_str!("../../../library/sensors/quadrotor-camera.json"),
    },
    ShippedSensor {
        name: "rmax-camera",
        file: "library/sensors/rmax-camera.json",
        text: include_str!("../../../library/sensors/rmax-camera.json"),
    },
];

impl ShippedVehicle {
    /// Returns the shipped vehicle file called `name`, in any case.
    ///
    /// # Errors
    /// An error message that lists the shipped models if none has this name.
    pub fn find(name: &str) -> Result<ShippedVehicle, String> {
        let folded = name.to_lowercase();
        let found = SHIPPED.iter().find(|shipped| shipped.name == folded).copied();
        found.ok_or_else(|| unknown("vehicle model", name, SHIPPED.iter().map(|shipped| shipped.name)))
    }
}

impl ShippedSensor {
    /// Returns the shipped sensor file called `name`, in any case.
    ///
    /// # Errors
    /// An error message that lists the shipped sensors if none has this name.
    pub fn find(name: &str) -> Result<ShippedSensor, String> {
        let folded = name.to_lowercase();
        let found = SHIPPED_SENSORS.iter().find(|shipped| shipped.name == folded).copied();
        found.ok_or_else(|| unknown("sensor", name, SHIPPED_SENSORS.iter().map(|shipped| shipped.name)))
    }
}

fn unknown(what: &str, name: &str, known: impl Iterator<Item = &'static str> + Clone) -> String {
    let near = crate::section::nearest(&name.to_lowercase(), known.clone());
    let hint = near.map(|near| format!("; did you mean `{near}`?"));
    let known: Vec<&str> = known.collect();
    format!("unknown {what} `{name}`{} (known: {})", hint.unwrap_or_default(), known.join(", "))
}

impl VehicleModel {
    /// Returns the shipped model called `name`, in any case.
    ///
    /// # Errors
    /// Like [`ShippedVehicle::find`]; a shipped file that is invalid, which a test excludes.
    pub fn named(name: &str) -> Result<VehicleModel, String> {
        let shipped = ShippedVehicle::find(name)?;
        VehicleModel::parse(shipped.file, shipped.text).map_err(|error| error.to_string())
    }
}
