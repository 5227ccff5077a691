//! Rules for the figures of a sensor model.

use crate::error::{FileName, VehicleFileError};
use crate::rules::{Checker, Rule};
use crate::sensor::{Band, Mount, Optics, ScannerMode, SensorModel};

/// Upper limit on fields of view: a wider view of flat ground would have no edge.
const FIELD_OF_VIEW_DEG_MAX: f64 = 170.0;

impl SensorModel {
    /// Checks that the figures describe a sensor that can see; `file` names the file in errors.
    ///
    /// # Errors
    /// The first figure that breaks a rule, with the rule.
    pub(crate) fn validate(&self, file: FileName<'_>) -> Result<(), VehicleFileError> {
        let check = Checker { file };
        check_optics(&check, &self.optics)?;
        check_bands(&check, &self.bands)?;
        check_mount(&check, &self.mount)?;
        let motion = &self.motion;
        let figures = [
            ("roll_deg_valid", motion.roll_deg_valid, Rule::AboveUpTo(0.0, 90.0)),
            ("roll_deg_zero", motion.roll_deg_zero, Rule::AboveUpTo(0.0, 90.0)),
            ("shift_px_valid", motion.shift_px_valid, Rule::Positive),
            ("shift_px_zero", motion.shift_px_zero, Rule::Positive),
        ];
        check.each("motion", &figures)?;
        check.at_most("motion.roll_deg_valid", motion.roll_deg_valid, motion.roll_deg_zero, "motion.roll_deg_zero")?;
        check.at_most("motion.shift_px_valid", motion.shift_px_valid, motion.shift_px_zero, "motion.shift_px_zero")?;
        let figures = [
            ("sun_keep_out_deg", self.sun_keep_out_deg, Rule::Between(0.0, 90.0)),
            ("start_up_s", self.start_up_s, Rule::NotNegative),
            ("picture_s", self.picture_s, Rule::NotNegative),
            ("power_w", self.power_w, Rule::NotNegative),
            ("mass_kg", self.mass_kg, Rule::NotNegative),
        ];
        check.each("", &figures)?;
        self.check_temperature(&check)?;
        let data = &self.data;
        let figures = [
            ("image_bytes", data.image_bytes, Rule::Positive),
            ("processing_s", data.processing_s, Rule::NotNegative),
            ("product_bytes", data.product_bytes, Rule::Positive),
            ("store_bytes", data.store_bytes, Rule::Positive),
        ];
        check.each("data", &figures)?;
        check.at_most("data.image_bytes", data.image_bytes, data.store_bytes, "data.store_bytes")
    }

    fn check_temperature(&self, check: &Checker<'_>) -> Result<(), VehicleFileError> {
        let Some(temperature) = &self.temperature else { return Ok(()) };
        let figures = [
            ("low_c", temperature.low_c, Rule::Between(-273.15, 500.0)),
            ("high_c", temperature.high_c, Rule::Between(-273.15, 500.0)),
            ("heat_capacity_j_k", temperature.heat_capacity_j_k, Rule::Positive),
            ("conductance_w_k", temperature.conductance_w_k, Rule::Positive),
            ("self_heating_w", temperature.self_heating_w, Rule::NotNegative),
        ];
        check.each("temperature", &figures)?;
        check.below("temperature.low_c", temperature.low_c, temperature.high_c, "temperature.high_c")
    }
}

fn check_optics(check: &Checker<'_>, optics: &Optics) -> Result<(), VehicleFileError> {
    let field_of_view = Rule::AboveUpTo(0.0, FIELD_OF_VIEW_DEG_MAX);
    match optics {
        Optics::LineScanner { modes } => check_modes(check, modes),
        Optics::Frame(frame) => {
            let figures = [
                ("pixels_across", frame.pixels_across, Rule::Positive),
                ("pixels_along", frame.pixels_along, Rule::Positive),
                ("pixel_um", frame.pixel_um, Rule::Positive),
                ("focal_mm", frame.focal_mm, Rule::Positive),
                ("interval_s_min", frame.interval_s_min, Rule::Positive),
                ("exposure_s", frame.exposure_s, Rule::Positive),
            ];
            check.each("frame", &figures)?;
            // The field of view follows from pixels and focal length, so a wrong unit in one of them shows up here.
            check.each("frame", &[("focal_mm: field of view in degrees", frame.field_of_view_deg(), field_of_view)])
        }
        Optics::Video(video) => {
            let figures = [
                ("pixels_across", video.pixels_across, Rule::Positive),
                ("pixels_along", video.pixels_along, Rule::Positive),
                ("field_of_view_deg", video.field_of_view_deg, field_of_view),
                ("frame_rate_hz", video.frame_rate_hz, Rule::Positive),
            ];
            check.each("video", &figures)
        }
    }
}

fn check_modes(check: &Checker<'_>, modes: &[ScannerMode]) -> Result<(), VehicleFileError> {
    if modes.is_empty() {
        return Err(check.file.error("modes", "one or more modes", "none", "describe each scan head as a mode"));
    }
    for (number, mode) in modes.iter().enumerate() {
        let section = format!("modes[{number}]");
        let figures = [
            ("pixel_mrad", mode.pixel_mrad, Rule::Positive),
            ("field_of_view_deg", mode.field_of_view_deg, Rule::AboveUpTo(0.0, FIELD_OF_VIEW_DEG_MAX)),
            ("overlap_share", mode.overlap_share, Rule::Between(0.0, 0.95)),
        ];
        check.each(&section, &figures)?;
        let pixel_deg = (mode.pixel_mrad * 1e-3).to_degrees();
        if pixel_deg > mode.field_of_view_deg {
            let expected = format!("at most the field of view, {} degrees", mode.field_of_view_deg);
            let found = format!("{pixel_deg:.3} degrees");
            let help = "correct one of the two figures; a pixel is in thousandths of a radian";
            return Err(check.file.error(format!("{section}.pixel_mrad"), expected, found, help));
        }
        let rates = &mode.scan_rates_hz;
        let positive = rates.iter().all(|rate| rate.is_finite() && *rate > 0.0);
        let rising = rates.iter().zip(rates.iter().skip(1)).all(|(low, high)| low < high);
        if rates.is_empty() || !positive || !rising {
            let expected = "one or more rates greater than zero, each greater than the one before";
            let path = format!("{section}.scan_rates_hz");
            return Err(check.file.error(path, expected, format!("{rates:?}"), "list the rates in rising order"));
        }
        if modes.iter().take(number).any(|other| other.name == mode.name) {
            let found = format!("`{}` again", mode.name);
            return Err(check.file.error(format!("{section}.name"), "a unique name", found, "rename the mode"));
        }
    }
    Ok(())
}

fn check_bands(check: &Checker<'_>, bands: &[Band]) -> Result<(), VehicleFileError> {
    if bands.is_empty() {
        return Err(check.file.error("bands", "one or more bands", "none", "describe what the sensor sees"));
    }
    for (number, band) in bands.iter().enumerate() {
        let section = format!("bands[{number}]");
        let figures = [("from_um", band.from_um, Rule::Positive), ("to_um", band.to_um, Rule::Positive)];
        check.each(&section, &figures)?;
        check.below(&format!("{section}.from_um"), band.from_um, band.to_um, "to_um")?;
        if !band.by_day && !band.by_night {
            let help = "set `by_day` or `by_night`, or delete the band";
            return Err(check.file.error(section, "a band that sees by day or by night", "neither", help));
        }
    }
    Ok(())
}

fn check_mount(check: &Checker<'_>, mount: &Mount) -> Result<(), VehicleFileError> {
    let tilt = Rule::Between(-90.0, 90.0);
    match mount {
        Mount::Fixed { tilt_deg, pan_deg } => {
            check.each("mount", &[("tilt_deg", *tilt_deg, tilt), ("pan_deg", *pan_deg, Rule::Between(-180.0, 180.0))])
        }
        Mount::Gimbal { tilt_deg_min, tilt_deg_max, pan_deg_max, slew_rate_deg_s, settle_s } => {
            let figures = [
                ("tilt_deg_min", *tilt_deg_min, tilt),
                ("tilt_deg_max", *tilt_deg_max, tilt),
                ("pan_deg_max", *pan_deg_max, Rule::Between(0.0, 180.0)),
                ("slew_rate_deg_s", *slew_rate_deg_s, Rule::Positive),
                ("settle_s", *settle_s, Rule::NotNegative),
            ];
            check.each("mount", &figures)?;
            check.below("mount.tilt_deg_min", *tilt_deg_min, *tilt_deg_max, "mount.tilt_deg_max")
        }
    }
}
