//! Vehicle models.

pub use apex_vehicle::{Airframe, VehicleModel};
