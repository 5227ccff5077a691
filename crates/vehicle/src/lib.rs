//! Vehicle models: what an airframe can do, what it carries and how plans for it are made, read from vehicle files.
//!
//! A vehicle file is JSON in which every figure names its source; `docs/reference/vehicles.md` describes it. The simulator and the
//! planner read the same model. The crate reads text and touches no file.

mod error;
mod json;
mod model;
mod read;
mod section;
mod shipped;
mod validate;

pub use error::VehicleFileError;
pub use model::{
    Airframe, CameraModel, FuelModel, PlanningModel, ReportIntervals, ScannerModel, TurnModel, VehicleModel,
};
pub use shipped::{SHIPPED, ShippedVehicle};
