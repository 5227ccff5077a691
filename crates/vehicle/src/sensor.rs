//! The types of a sensor model. Units are part of the names; angles are degrees.

use crate::model::CameraModel;
use serde::{Deserialize, Serialize};

/// Slew rate given to a mount that does not move: its one direction is always reached at once.
const FIXED_SLEW_DEG_S: f64 = 360.0;

/// A sensor: the bands it sees, its modes, its mount, and the size of its data.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SensorModel {
    /// Name of the type, for messages.
    pub name: String,
    /// Optics and detector.
    pub optics: Optics,
    /// Parts of the spectrum that the sensor records, and what is visible in each.
    pub bands: Vec<Band>,
    /// Mount on the airframe.
    pub mount: Mount,
    /// Limits on the vehicle's motion while the sensor records.
    pub motion: MotionLimits,
    /// Least angle between the sun and the edge of the field of view; 0: the sun does no harm.
    pub sun_keep_out_deg: f64,
    /// From power-up to ready.
    pub start_up_s: f64,
    /// From the command to the image in memory; 0 for a line scanner, which records lines.
    pub picture_s: f64,
    /// Electrical power while it records.
    pub power_w: f64,
    /// Mass with its mount.
    pub mass_kg: f64,
    /// Temperature inside the sensor, if it limits use.
    pub temperature: Option<SensorTemperature>,
    /// Size, processing and storage of its data.
    pub data: SensorData,
}

/// Optics and detector by kind of sensor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Optics {
    /// Scans lines across the track below the aircraft.
    LineScanner {
        /// Modes; one of them is used throughout a flight.
        modes: Vec<ScannerMode>,
    },
    /// Takes single pictures.
    Frame(FrameOptics),
    /// Takes a stream of pictures.
    Video(VideoOptics),
}

/// A mode of a line scanner: one scan head with its scan rates.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ScannerMode {
    /// Name in vehicle files and messages.
    pub name: String,
    /// Angle of one pixel (instantaneous field of view).
    pub pixel_mrad: f64,
    /// Full field of view across the track.
    pub field_of_view_deg: f64,
    /// Scan rates to choose from, rising, lines per second.
    pub scan_rates_hz: Vec<f64>,
    /// Share of a line that must overlap the previous line.
    pub overlap_share: f64,
}

/// A frame camera.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FrameOptics {
    /// Pixels across the direction of flight.
    pub pixels_across: f64,
    /// Pixels along the direction of flight.
    pub pixels_along: f64,
    /// Spacing of the pixels on the detector.
    pub pixel_um: f64,
    /// Focal length.
    pub focal_mm: f64,
    /// Shortest time from one picture to the next.
    pub interval_s_min: f64,
    /// Exposure in daylight.
    pub exposure_s: f64,
}

/// A video camera.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct VideoOptics {
    /// Pixels of a row.
    pub pixels_across: f64,
    /// Rows.
    pub pixels_along: f64,
    /// Full horizontal field of view.
    pub field_of_view_deg: f64,
    /// Pictures per second.
    pub frame_rate_hz: f64,
}

/// A part of the spectrum, and what is visible in it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Band {
    /// Name, for example `thermal infrared`.
    pub name: String,
    /// Shortest wavelength, at half response.
    pub from_um: f64,
    /// Longest wavelength, at half response.
    pub to_um: f64,
    /// Usable by day.
    pub by_day: bool,
    /// Usable by night.
    pub by_night: bool,
    /// Sees through cloud.
    pub through_cloud: bool,
    /// Sees through smoke.
    pub through_smoke: bool,
}

/// Mount of a sensor on the airframe. Tilt is 0 ahead and -90 straight down; pan is clockwise from the nose.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Mount {
    /// The mount points in one fixed direction relative to the airframe.
    Fixed {
        /// Tilt.
        tilt_deg: f64,
        /// Pan.
        pan_deg: f64,
    },
    /// The mount is turned by motors.
    Gimbal {
        /// Lowest tilt.
        tilt_deg_min: f64,
        /// Highest tilt.
        tilt_deg_max: f64,
        /// Pan to either side; 0: the mount only tilts.
        pan_deg_max: f64,
        /// Slew rate of tilt and pan.
        slew_rate_deg_s: f64,
        /// Time from the end of a slew until the picture is steady.
        settle_s: f64,
    },
}

/// Motion of the vehicle up to which the data are valid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MotionLimits {
    /// Roll angle up to which data are fully valid.
    pub roll_deg_valid: f64,
    /// Roll angle from which they are worthless; equal to the former for a hard limit.
    pub roll_deg_zero: f64,
    /// Shift between lines or within a picture, in pixels, up to which data are fully valid.
    pub shift_px_valid: f64,
    /// Shift in pixels from which they are worthless.
    pub shift_px_zero: f64,
}

/// Heat balance of a sensor: `dT/dt = (self_heating - conductance (T - T_outside)) / heat_capacity`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SensorTemperature {
    /// Lowest temperature of use.
    pub low_c: f64,
    /// Highest temperature of use.
    pub high_c: f64,
    /// Heat capacity.
    pub heat_capacity_j_k: f64,
    /// Thermal conductance to the air outside.
    pub conductance_w_k: f64,
    /// Heat made while it records.
    pub self_heating_w: f64,
}

/// Size, processing and storage of the data of a sensor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SensorData {
    /// Bytes of one line or picture.
    pub image_bytes: f64,
    /// Time to process a line set or a picture on board into a product.
    pub processing_s: f64,
    /// Bytes of the product that is sent.
    pub product_bytes: f64,
    /// Bytes that fit on board.
    pub store_bytes: f64,
}

/// A sensor on a vehicle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CarriedSensor {
    /// Name in commands and events, for example `camera-1`.
    pub name: String,
    /// The sensor as the vehicle file names it: the name of a shipped sensor or a file.
    pub reference: String,
    /// Name of the mode in use; `None` for a sensor without modes.
    pub mode: Option<String>,
    /// The sensor.
    pub model: SensorModel,
}

impl CarriedSensor {
    /// Returns the mode in use of a line scanner; `None` for other sensors.
    pub fn scanner_mode(&self) -> Option<&ScannerMode> {
        let Optics::LineScanner { modes } = &self.model.optics else { return None };
        modes.iter().find(|mode| Some(&mode.name) == self.mode.as_ref())
    }
}

/// Share of the width of a picture that overlaps the neighbouring strip.
const SIDELAP_SHARE: f64 = 0.2;

impl CarriedSensor {
    /// Returns the sensor that records lines over the ground: the line scanner in its selected mode, or else a frame camera that can look
    /// straight down.
    pub fn recorder_of_lines(sensors: &[CarriedSensor]) -> Option<ScannerMode> {
        let scanner = sensors.iter().find_map(CarriedSensor::scanner_mode).cloned();
        scanner.or_else(|| sensors.iter().find_map(CarriedSensor::strip))
    }

    /// Returns the strip made by overlapping pictures of a frame camera that looks straight down, as a scanner mode; `None` for other
    /// sensors, and for a camera that cannot look straight down. A fifth of each picture overlaps the neighbouring strip.
    pub fn strip(&self) -> Option<ScannerMode> {
        let Optics::Frame(frame) = &self.model.optics else { return None };
        self.model.sees_nadir().then(|| ScannerMode {
            name: "strip of pictures".to_owned(),
            pixel_mrad: frame.pixel_rad() * 1e3,
            field_of_view_deg: full_angle_deg(frame.pixels_across * frame.pixel_rad() * (1.0 - SIDELAP_SHARE)),
            scan_rates_hz: Vec::new(),
            overlap_share: 0.0,
        })
    }

    /// Returns the sensor as the camera used by commands; `None` for a line scanner. A fixed mount has equal limits and turns at once.
    pub fn camera(&self) -> Option<CameraModel> {
        let (field_of_view_deg, interval_s_min) = match &self.model.optics {
            Optics::LineScanner { .. } => return None,
            Optics::Frame(frame) => (frame.field_of_view_deg(), frame.interval_s_min),
            Optics::Video(video) => (video.field_of_view_deg, 1.0 / video.frame_rate_hz),
        };
        let (tilt_deg_min, tilt_deg_max, pan_deg_max, slew_rate_deg_s) = match self.model.mount {
            Mount::Fixed { tilt_deg, .. } => (tilt_deg, tilt_deg, 0.0, FIXED_SLEW_DEG_S),
            Mount::Gimbal { tilt_deg_min, tilt_deg_max, pan_deg_max, slew_rate_deg_s, .. } => {
                (tilt_deg_min, tilt_deg_max, pan_deg_max, slew_rate_deg_s)
            }
        };
        Some(CameraModel {
            name: self.name.clone(),
            tilt_deg_min,
            tilt_deg_max,
            pan_deg_max,
            slew_rate_deg_s,
            field_of_view_deg,
            power_up_s: self.model.start_up_s,
            picture_s: self.model.picture_s,
            interval_s_min,
        })
    }
}

impl SensorModel {
    /// Returns the word of its kind in files.
    pub fn kind(&self) -> &'static str {
        match self.optics {
            Optics::LineScanner { .. } => "line-scanner",
            Optics::Frame(_) => "frame",
            Optics::Video(_) => "video",
        }
    }

    /// Returns true if the sensor can look straight down.
    pub fn sees_nadir(&self) -> bool {
        match (&self.optics, &self.mount) {
            (Optics::LineScanner { .. }, _) => true,
            (_, Mount::Fixed { tilt_deg, .. }) => *tilt_deg == -90.0,
            (_, Mount::Gimbal { tilt_deg_min, .. }) => *tilt_deg_min <= -90.0,
        }
    }

    /// Returns true if a band works by night.
    pub fn works_by_night(&self) -> bool {
        self.bands.iter().any(|band| band.by_night)
    }

    /// Returns true if a band works by day.
    pub fn works_by_day(&self) -> bool {
        self.bands.iter().any(|band| band.by_day)
    }
}

impl FrameOptics {
    /// Returns the angle of one pixel at the centre of the picture, rad: pixel spacing over focal length.
    pub fn pixel_rad(&self) -> f64 {
        self.pixel_um * 1e-3 / self.focal_mm
    }

    /// Returns the full field of view across the direction of flight.
    pub fn field_of_view_deg(&self) -> f64 {
        full_angle_deg(self.pixels_across * self.pixel_rad())
    }

    /// Returns the full field of view along the direction of flight.
    pub fn field_of_view_along_deg(&self) -> f64 {
        full_angle_deg(self.pixels_along * self.pixel_rad())
    }
}

impl VideoOptics {
    /// Returns the angle of one pixel at the centre of the picture, rad.
    pub fn pixel_rad(&self) -> f64 {
        2.0 * libm::tan(self.field_of_view_deg.to_radians() / 2.0) / self.pixels_across
    }

    /// Returns the full vertical field of view.
    pub fn field_of_view_along_deg(&self) -> f64 {
        full_angle_deg(self.pixels_along * self.pixel_rad())
    }
}

/// Returns the full angle of a picture whose width is `size` at distance 1.
fn full_angle_deg(size: f64) -> f64 {
    (2.0 * libm::atan(size / 2.0)).to_degrees()
}
