//! Figures that follow from a vehicle file, against which a reader can check it: ranges, turns, pixels, swaths, scan rates.

use crate::climb::Climb;
use crate::energy::{EnergyModel, density_ratio};
use crate::model::{Airframe, VehicleModel};
use crate::sensor::{CarriedSensor, Optics, ScannerMode};
use libm::{cos, tan};

/// Standard acceleration of gravity.
const GRAVITY_M_S2: f64 = 9.806_65;

/// A sensor's view of flat ground from one height, in level flight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sight {
    /// Height above the ground, m.
    pub height_m: f64,
    /// Pixel straight below, m.
    pub nadir_pixel_m: f64,
    /// Pixel across the track at the edge of the field of view, m.
    pub edge_pixel_m: f64,
    /// Width of the strip seen, m.
    pub swath_m: f64,
    /// Slowest scan rate without gaps between lines at cruise speed in still air, lines per second; `None` for a camera.
    pub scan_rate_hz_min: Option<f64>,
}

/// Least height at which successive lines leave no gaps, for one scan rate, at cruise speed in still air.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GapFreeHeight {
    /// Scan rate, lines per second.
    pub scan_rate_hz: f64,
    /// Height above the ground, m.
    pub height_m: f64,
}

/// Returns the radius of a turn with `bank_deg` at `true_airspeed_m_s` in still air, m: `V^2 / (g tan bank)`.
pub fn turn_radius_m(true_airspeed_m_s: f64, bank_deg: f64) -> f64 {
    true_airspeed_m_s * true_airspeed_m_s / (GRAVITY_M_S2 * tan(bank_deg.to_radians()))
}

/// Angle of attack of a fixed wing at its slowest speed, and that at which it has no lift, rad (assumption).
const ANGLE_OF_ATTACK_RAD: (f64, f64) = (0.16, 0.02);

/// Airspeed at which a fixed wing leaves the ground, as a multiple of its slowest one (assumption).
pub const LIFT_OFF_SPEED: f64 = 1.15;
/// Acceleration on the ground as a multiple of the greatest in flight: brakes and take-off power (assumption).
pub const GROUND_ACCELERATION: f64 = 2.0;

/// Time after a change of airspeed in which it settles, s: two time constants of an automatic throttle (assumption).
const SPEED_SETTLES_S: f64 = 10.0;

impl VehicleModel {
    /// Returns time and length through the air of a change of true airspeed in level flight: at the greatest acceleration, then settling.
    pub fn speed_change(&self, from_m_s: f64, to_m_s: f64) -> (f64, f64) {
        let changes_s = (to_m_s - from_m_s).abs() / self.acceleration_m_s2_max;
        (changes_s + SPEED_SETTLES_S, 0.5 * (from_m_s + to_m_s) * changes_s + SPEED_SETTLES_S * to_m_s)
    }

    /// Returns the time that a flight at cruise speed loses by slowing to `true_airspeed_m_s` before a line and by becoming as fast again
    /// after it, s, at `ground_speed_m_s` of cruise; below zero for a faster line.
    pub fn speed_change_losses_s(&self, true_airspeed_m_s: f64, ground_speed_m_s: f64) -> (f64, f64) {
        let cruise_m_s = self.true_airspeed_m_s_cruise;
        let lost_s = |(seconds, air_m): (f64, f64)| (cruise_m_s * seconds - air_m) / ground_speed_m_s.max(1.0);
        (
            lost_s(self.speed_change(cruise_m_s, true_airspeed_m_s)),
            lost_s(self.speed_change(true_airspeed_m_s, cruise_m_s)),
        )
    }

    /// Returns the slowest true airspeed at an altitude in the standard atmosphere, m/s.
    pub fn true_airspeed_m_s_min(&self, altitude_m: f64) -> f64 {
        self.indicated_airspeed_m_s_min / libm::sqrt(density_ratio(altitude_m))
    }

    /// Returns the length of the run on the ground before a fixed wing lifts off, m: `V^2 / (2 a)`.
    pub fn take_off_run_m(&self, altitude_m: f64) -> f64 {
        let lift_off_m_s = LIFT_OFF_SPEED * self.true_airspeed_m_s_min(altitude_m);
        lift_off_m_s * lift_off_m_s / (2.0 * GROUND_ACCELERATION * self.acceleration_m_s2_max)
    }

    /// Returns the pitch angle of a fixed wing in level flight by its slowest indicated airspeed over the present one, rad: lift at one g
    /// needs an angle of attack that falls with the square of the indicated airspeed.
    pub fn level_pitch_rad(slowness: f64) -> f64 {
        ANGLE_OF_ATTACK_RAD.0 * slowness * slowness - ANGLE_OF_ATTACK_RAD.1
    }

    /// Returns the greatest climb rate as a function of the altitude.
    pub fn climb(&self) -> Climb {
        Climb { rate_m_s_max: self.climb_rate_m_s_max, ceiling_m: self.ceiling_m }
    }

    /// Returns the pitch angle of level flight at cruise speed, rad; 0 for a rotorcraft.
    pub fn cruise_pitch_rad(&self, altitude_m: f64) -> f64 {
        match self.airframe {
            Airframe::FixedWing => {
                let indicated_m_s = self.true_airspeed_m_s_cruise * libm::sqrt(density_ratio(altitude_m));
                VehicleModel::level_pitch_rad((self.indicated_airspeed_m_s_min / indicated_m_s).min(1.0))
            }
            Airframe::Rotorcraft => 0.0,
        }
    }

    /// Returns the radius of the turns that plans use at cruise speed, m; 0 for a rotorcraft, which turns in place.
    pub fn planned_turn_radius_m(&self) -> f64 {
        match self.airframe {
            Airframe::FixedWing => {
                turn_radius_m(self.true_airspeed_m_s_cruise, self.turns.bank_share * self.bank_deg_max)
            }
            Airframe::Rotorcraft => 0.0,
        }
    }

    /// Returns the range in still air at cruise with the reserve untouched, m.
    pub fn range_m(&self) -> f64 {
        (self.stored_full() - self.reserve()) / self.drain_cruise_per_s() * self.true_airspeed_m_s_cruise
    }

    /// Returns the unit in which the energy on board is printed, and the size of that unit in kg or J.
    pub fn energy_unit(&self) -> (&'static str, f64) {
        match self.energy {
            EnergyModel::Fuel(_) => ("kg", 1.0),
            EnergyModel::Battery(_) => ("Wh", crate::energy::JOULES_PER_WH),
        }
    }

    /// Returns the view of `sensor` of this vehicle from `height_m`, straight below.
    pub fn sight(&self, sensor: &CarriedSensor, height_m: f64) -> Sight {
        let (pixel_rad, field_of_view_deg) = match &sensor.model.optics {
            Optics::LineScanner { .. } => {
                sensor.scanner_mode().map_or((0.0, 0.0), |mode| (mode.pixel_mrad * 1e-3, mode.field_of_view_deg))
            }
            Optics::Frame(frame) => (frame.pixel_rad(), frame.field_of_view_deg()),
            Optics::Video(video) => (video.pixel_rad(), video.field_of_view_deg),
        };
        let half_rad = field_of_view_deg.to_radians() / 2.0;
        let nadir_pixel_m = pixel_rad * height_m;
        // The rays of a scanner's line are equally spaced in angle, the pixels of a camera on a plane.
        let edge_pixel_m = match sensor.model.optics {
            Optics::LineScanner { .. } => nadir_pixel_m / (cos(half_rad) * cos(half_rad)),
            Optics::Frame(_) | Optics::Video(_) => nadir_pixel_m,
        };
        Sight {
            height_m,
            nadir_pixel_m,
            edge_pixel_m,
            swath_m: 2.0 * height_m * tan(half_rad),
            scan_rate_hz_min: sensor.scanner_mode().map(|mode| self.scan_rate_hz_min(mode, height_m)),
        }
    }

    /// Returns the slowest scan rate without gaps at `height_m`, lines per second: `V (1 + overlap) / (pixel height)`.
    fn scan_rate_hz_min(&self, mode: &ScannerMode, height_m: f64) -> f64 {
        self.true_airspeed_m_s_cruise * (1.0 + mode.overlap_share) / (mode.pixel_mrad * 1e-3 * height_m)
    }

    /// Returns the least height without gaps at cruise speed, for each scan rate of `mode`.
    pub fn gap_free_heights(&self, mode: &ScannerMode) -> Vec<GapFreeHeight> {
        let height = |scan_rate_hz: &f64| GapFreeHeight {
            scan_rate_hz: *scan_rate_hz,
            height_m: self.scan_rate_hz_min(mode, 1.0) / scan_rate_hz,
        };
        mode.scan_rates_hz.iter().map(height).collect()
    }

    /// Returns the three heights at which the figures of sensors are printed. For a fixed wing with a line scanner: a quarter, a half and
    /// three quarters of the ceiling. Otherwise: half, once and twice the height from which sites are visited.
    pub fn sample_heights_m(&self) -> [f64; 3] {
        match self.airframe {
            Airframe::FixedWing if self.sensors.iter().any(|sensor| sensor.scanner_mode().is_some()) => {
                [0.25, 0.5, 0.75].map(|share| share * self.ceiling_m)
            }
            Airframe::FixedWing | Airframe::Rotorcraft => {
                [0.5, 1.0, 2.0].map(|times| times * self.planning.visit_height_m)
            }
        }
    }

    /// Returns the greatest height at which the pixel straight below is at most `resolution_m`, m.
    pub fn height_for_resolution_m(&self, sensor: &CarriedSensor, resolution_m: f64) -> f64 {
        resolution_m / self.sight(sensor, 1.0).nadir_pixel_m
    }
}
