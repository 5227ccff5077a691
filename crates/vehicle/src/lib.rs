//! Vehicle and sensor models: what an airframe can do, what it carries and how plans for it are made, read from files.
//!
//! A vehicle file is JSON in which every figure names its source; `docs/reference/vehicles.md` and `docs/reference/sensors.md`
//! describe the files. The simulator and the planner read the same model. The crate reads text and touches no file.

mod climb;
pub mod derived;
mod energy;
mod error;
mod json;
mod model;
mod read;
mod rules;
mod section;
mod sensor;
mod sensor_read;
mod sensor_rules;
mod sheet;
mod shipped;
mod validate;

pub use climb::Climb;
pub use energy::{
    BatteryModel, EnergyModel, FlightPower, FuelModel, JOULES_PER_WH, Reserve, StatedEndurance, density_ratio,
    ideal_hover_w, standard_temperature_c,
};
pub use error::{FileKind, VehicleFileError};
pub use model::{
    Airframe, AttitudeHold, CameraModel, CruiseLevel, PlanningModel, ReportIntervals, TurnModel, VehicleModel,
};
pub use read::SensorFile;
pub use sensor::{
    Band, CarriedSensor, FrameOptics, MotionLimits, Mount, Optics, ScannerMode, SensorData, SensorModel,
    SensorTemperature, VideoOptics,
};
pub use shipped::{SHIPPED, SHIPPED_SENSORS, ShippedSensor, ShippedVehicle};
