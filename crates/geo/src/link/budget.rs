//! The budget of a link: received power, margin and signal level.

use super::antenna::Antenna;
use super::diffraction::diffraction_loss_db;
use super::path_loss::{free_space_loss_db, two_ray_loss_db, wavelength_m};
use crate::geodesy::{self, Position};
use serde::{Deserialize, Serialize};

/// Power over the sensitivity at which a signal level is 1, dB.
pub const FULL_LEVEL_DB: f64 = 40.0;

/// Figures of a link between two radios. The sum counts in both directions: antennas are reciprocal.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RadioFigures {
    /// Carrier frequency, Hz.
    pub frequency_hz: f64,
    /// Power at the transmitter, dBm.
    pub power_dbm: f64,
    /// Gains of both antennas together, dBi.
    pub gains_dbi: f64,
    /// Losses in cables and connectors of both ends together, dB.
    pub losses_db: f64,
    /// Least power at which the receiver works, dBm.
    pub sensitivity_dbm: f64,
    /// Reserve over the sensitivity for fading, dB.
    pub fade_margin_db: f64,
}

impl Default for RadioFigures {
    /// Returns a telemetry modem of 1 W at 915 MHz with two dipoles.
    fn default() -> RadioFigures {
        RadioFigures {
            frequency_hz: 915e6,
            power_dbm: 30.0,
            gains_dbi: 4.0,
            losses_db: 6.0,
            sensitivity_dbm: -95.0,
            fade_margin_db: 10.0,
        }
    }
}

impl RadioFigures {
    /// Returns the radio with the power for which free space alone gives a signal level of 1 at `distance_m`.
    pub fn with_full_level_at(self, distance_m: f64) -> RadioFigures {
        let loss_db = free_space_loss_db(self.frequency_hz, distance_m);
        let power_dbm = self.sensitivity_dbm + FULL_LEVEL_DB + loss_db + self.losses_db - self.gains_dbi;
        RadioFigures { power_dbm, ..self }
    }

    /// Returns the signal level of a margin: 0 at the sensitivity, 1 from [`FULL_LEVEL_DB`] above it on, linear in dB in between.
    pub fn signal_level(&self, margin_db: f64) -> f64 {
        ((margin_db + self.fade_margin_db) / FULL_LEVEL_DB).clamp(0.0, 1.0)
    }

    /// Returns the margin of a signal level, dB: the inverse of [`RadioFigures::signal_level`] between 0 and 1.
    pub fn margin_of_level_db(&self, level: f64) -> f64 {
        FULL_LEVEL_DB * level - self.fade_margin_db
    }

    /// Returns the received power for a loss between the antennas, dBm: power, plus gains, minus losses.
    pub fn received_dbm(&self, loss_db: f64) -> f64 {
        self.power_dbm + self.gains_dbi - self.losses_db - loss_db
    }

    /// Returns the received power over sensitivity and fade margin, dB. Negative: the requirement of the link is violated.
    pub fn margin_db(&self, received_dbm: f64) -> f64 {
        received_dbm - self.sensitivity_dbm - self.fade_margin_db
    }

    /// Returns the loss between two antennas over the ground of `elevation_m_at` (m above mean sea level), dB: free space with the
    /// worst knife edge of the profile, or two-ray ground reflection where that is more. Antennas nearer than a metre count
    /// as a metre apart.
    pub fn loss_db(&self, from: &Antenna, to: &Antenna, elevation_m_at: impl Fn(Position) -> f64) -> f64 {
        let ground_m = geodesy::distance_m(from.position, to.position);
        let slant_m = libm::hypot(ground_m, to.altitude_m - from.altitude_m).max(1.0);
        let free_db = free_space_loss_db(self.frequency_hz, slant_m);
        let edge_db = diffraction_loss_db(from, to, ground_m, wavelength_m(self.frequency_hz), elevation_m_at);
        let reflected_db = two_ray_loss_db(self.frequency_hz, slant_m, from.height_m, to.height_m);
        (free_db + edge_db).max(reflected_db)
    }

    /// Returns the margin between two antennas, dB: [`RadioFigures::margin_db`] after the loss of [`RadioFigures::loss_db`].
    pub fn predicted_margin_db(&self, from: &Antenna, to: &Antenna, elevation_m_at: impl Fn(Position) -> f64) -> f64 {
        self.margin_db(self.received_dbm(self.loss_db(from, to, elevation_m_at)))
    }
}
