//! Vehicle models.

pub use apex_sim::{Airframe, VehicleModel};
