//! Radio links between a ground station and an aircraft: path loss, diffraction over terrain, link budget, margin.
//!
//! Sources: free space ITU-R P.525; effective earth radius 4/3 ITU-R P.834; single knife edge ITU-R P.526; two-ray ground
//! reflection Rappaport, "Wireless Communications", 2nd ed., section 4.6. Losses are in dB and positive; powers are in dBm.
//! Bound: a budget is O(samples of the profile), at most [`PROFILE_SAMPLES_MAX`].

mod antenna;
mod budget;
mod diffraction;
mod level;
mod path_loss;
#[cfg(test)]
mod tests;

pub use antenna::Antenna;
pub use budget::{FULL_LEVEL_DB, RadioFigures};
pub use diffraction::{
    PROFILE_SAMPLES_MAX, diffraction_loss_db, fresnel_clearance_m, knife_edge_loss_db, knife_edge_nu, radio_horizon_m,
};
pub use level::{EXPONENT, LevelLaw, LevelModel, Shadow, ShadowShape};
pub use path_loss::{free_space_loss_db, free_space_range_m, two_ray_crossover_m, two_ray_loss_db, wavelength_m};
