//! Margin functions: positive while the requirement is kept, in the unit stated in the name.

pub mod energy;
pub mod landing;
pub mod link;
pub mod mission_end;
pub mod sensor;
pub mod terrain;
pub mod weather;
pub mod zone;
