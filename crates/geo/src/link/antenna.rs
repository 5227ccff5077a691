//! An end of a radio link.

use crate::geodesy::Position;

/// An antenna of a link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Antenna {
    /// Position.
    pub position: Position,
    /// Altitude above mean sea level, m.
    pub altitude_m: f64,
    /// Height above the ground, m.
    pub height_m: f64,
}
