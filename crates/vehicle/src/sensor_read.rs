//! Reading a sensor model from the text of a sensor file.

use crate::error::{FileName, VehicleFileError};
use crate::json::Node;
use crate::section::Section;
use crate::sensor::{
    Band, FrameOptics, MotionLimits, Mount, Optics, ScannerMode, SensorData, SensorModel, SensorTemperature,
    VideoOptics,
};

/// The version of the format, the value of `format`.
const FORMAT: &str = "apex-sensor-1";
const ROOT: &[&str] = &[
    "format",
    "name",
    "kind",
    "bands",
    "modes",
    "frame",
    "video",
    "mount",
    "motion",
    "sun_keep_out_deg",
    "start_up_s",
    "picture_s",
    "power_w",
    "mass_kg",
    "temperature",
    "data",
];
const BAND: &[&str] = &["name", "from_um", "to_um", "by_day", "by_night", "through_cloud", "through_smoke"];
const MODE: &[&str] = &["name", "pixel_mrad", "field_of_view_deg", "scan_rates_hz", "overlap_share"];
const FRAME: &[&str] = &["pixels_across", "pixels_along", "pixel_um", "focal_mm", "interval_s_min", "exposure_s"];
const VIDEO: &[&str] = &["pixels_across", "pixels_along", "field_of_view_deg", "frame_rate_hz"];
const MOUNT: &[&str] =
    &["tilt_deg", "pan_deg", "tilt_deg_min", "tilt_deg_max", "pan_deg_max", "slew_rate_deg_s", "settle_s"];
const MOTION: &[&str] = &["roll_deg_valid", "roll_deg_zero", "shift_px_valid", "shift_px_zero"];
const TEMPERATURE: &[&str] = &["low_c", "high_c", "heat_capacity_j_k", "conductance_w_k", "self_heating_w"];
const DATA: &[&str] = &["image_bytes", "processing_s", "product_bytes", "store_bytes"];
const HELP_SECTION: &str = "add the section; docs/reference/sensors.md lists its members";

type SensorResult<T> = Result<T, VehicleFileError>;

impl SensorModel {
    /// Reads the text of a sensor file; `file` is its name in errors.
    ///
    /// # Errors
    /// Text that is not JSON; a member that is unknown, repeated, missing or of the wrong type; a figure without a source, or one that no
    /// sensor can have.
    pub fn parse(file: &str, text: &str) -> Result<SensorModel, VehicleFileError> {
        let file = FileName::sensor(file);
        let root: Node = serde_json::from_str(text).map_err(|error| {
            let help = "compare with a file of library/sensors; docs/reference/sensors.md describes it";
            file.error("", "JSON (RFC 8259)", error.to_string(), help)
        })?;
        let model = read(file, &root)?;
        model.validate(file)?;
        Ok(model)
    }
}

fn read(file: FileName<'_>, root: &Node) -> SensorResult<SensorModel> {
    let root = Section::open(file, "", root, ROOT)?;
    root.word("format", &[FORMAT])?;
    let optics = optics(&root)?;
    let scans = matches!(optics, Optics::LineScanner { .. });
    Ok(SensorModel {
        name: root.name("my-camera")?,
        bands: bands(&root)?,
        mount: mount(&root, scans)?,
        motion: motion(&open(&root, "motion", MOTION)?)?,
        sun_keep_out_deg: root.figure("sun_keep_out_deg")?,
        start_up_s: root.figure("start_up_s")?,
        picture_s: root.figure_if("picture_s", !scans, "line scanner")?,
        power_w: root.figure("power_w")?,
        mass_kg: root.figure("mass_kg")?,
        temperature: root.member("temperature").map(|_| temperature(&root)).transpose()?,
        data: data(&open(&root, "data", DATA)?)?,
        optics,
    })
}

/// Opens a section that must be present.
fn open<'a>(root: &Section<'a>, name: &str, known: &[&str]) -> SensorResult<Section<'a>> {
    Section::open(root.file(), name, root.required(name, "an object", HELP_SECTION)?, known)
}

/// Reads the section of the sensor's kind, and rejects the sections of other kinds.
fn optics(root: &Section<'_>) -> SensorResult<Optics> {
    let kind = root.word("kind", &["line-scanner", "frame", "video"])?;
    let own = match kind {
        "line-scanner" => "modes",
        other => other,
    };
    for other in ["modes", "frame", "video"] {
        if other != own
            && let Some(node) = root.member(other)
        {
            let expected = format!("nothing for a sensor of kind {kind}");
            return Err(root.wrong(other, &expected, node.describe(), "delete the member, or correct `kind`"));
        }
    }
    Ok(match own {
        "modes" => Optics::LineScanner { modes: modes(root)? },
        "frame" => Optics::Frame(frame(&open(root, "frame", FRAME)?)?),
        _ => Optics::Video(video(&open(root, "video", VIDEO)?)?),
    })
}

fn modes(root: &Section<'_>) -> SensorResult<Vec<ScannerMode>> {
    root.required("modes", "a list of modes", "write [..] with one object for each scan head")?;
    let mode = |(path, node): (String, &Node)| {
        let section = Section::open(root.file(), &path, node, MODE)?;
        Ok(ScannerMode {
            name: section.name("1.25 mrad")?,
            pixel_mrad: section.figure("pixel_mrad")?,
            field_of_view_deg: section.figure("field_of_view_deg")?,
            scan_rates_hz: section.figures("scan_rates_hz")?,
            overlap_share: section.figure("overlap_share")?,
        })
    };
    root.items("modes")?.into_iter().map(mode).collect()
}

fn frame(section: &Section<'_>) -> SensorResult<FrameOptics> {
    Ok(FrameOptics {
        pixels_across: section.figure("pixels_across")?,
        pixels_along: section.figure("pixels_along")?,
        pixel_um: section.figure("pixel_um")?,
        focal_mm: section.figure("focal_mm")?,
        interval_s_min: section.figure("interval_s_min")?,
        exposure_s: section.figure("exposure_s")?,
    })
}

fn video(section: &Section<'_>) -> SensorResult<VideoOptics> {
    Ok(VideoOptics {
        pixels_across: section.figure("pixels_across")?,
        pixels_along: section.figure("pixels_along")?,
        field_of_view_deg: section.figure("field_of_view_deg")?,
        frame_rate_hz: section.figure("frame_rate_hz")?,
    })
}

fn bands(root: &Section<'_>) -> SensorResult<Vec<Band>> {
    root.required("bands", "a list of bands", "write [..] with one object for each band")?;
    let band = |(path, node): (String, &Node)| {
        let section = Section::open(root.file(), &path, node, BAND)?;
        Ok(Band {
            name: section.name("visible")?,
            from_um: section.figure("from_um")?,
            to_um: section.figure("to_um")?,
            by_day: section.truth("by_day")?,
            by_night: section.truth("by_night")?,
            through_cloud: section.truth("through_cloud")?,
            through_smoke: section.truth("through_smoke")?,
        })
    };
    root.items("bands")?.into_iter().map(band).collect()
}

/// Returns the mount; a line scanner looks straight down and has none.
fn mount(root: &Section<'_>, scans: bool) -> SensorResult<Mount> {
    if scans {
        return match root.member("mount") {
            None => Ok(Mount::Fixed { tilt_deg: -90.0, pan_deg: 0.0 }),
            Some(node) => Err(root.wrong(
                "mount",
                "nothing for a line scanner",
                node.describe(),
                "delete the member: a line scanner looks straight down",
            )),
        };
    }
    let section = open(root, "mount", MOUNT)?;
    let fixed = ["tilt_deg", "pan_deg"];
    if fixed.iter().any(|name| section.member(name).is_some()) {
        let moving = MOUNT.iter().find(|name| !fixed.contains(*name) && section.member(name).is_some());
        if let Some(moving) = moving {
            let expected = "no range in addition to `tilt_deg` and `pan_deg`, which are a fixed mount";
            return Err(section.wrong(
                moving,
                expected,
                "a figure",
                "give either a fixed direction or a gimbal's limits",
            ));
        }
        return Ok(Mount::Fixed { tilt_deg: section.figure("tilt_deg")?, pan_deg: section.figure("pan_deg")? });
    }
    Ok(Mount::Gimbal {
        tilt_deg_min: section.figure("tilt_deg_min")?,
        tilt_deg_max: section.figure("tilt_deg_max")?,
        pan_deg_max: section.figure("pan_deg_max")?,
        slew_rate_deg_s: section.figure("slew_rate_deg_s")?,
        settle_s: section.figure("settle_s")?,
    })
}

fn motion(section: &Section<'_>) -> SensorResult<MotionLimits> {
    Ok(MotionLimits {
        roll_deg_valid: section.figure("roll_deg_valid")?,
        roll_deg_zero: section.figure("roll_deg_zero")?,
        shift_px_valid: section.figure("shift_px_valid")?,
        shift_px_zero: section.figure("shift_px_zero")?,
    })
}

fn temperature(root: &Section<'_>) -> SensorResult<SensorTemperature> {
    let section = open(root, "temperature", TEMPERATURE)?;
    Ok(SensorTemperature {
        low_c: section.figure("low_c")?,
        high_c: section.figure("high_c")?,
        heat_capacity_j_k: section.figure("heat_capacity_j_k")?,
        conductance_w_k: section.figure("conductance_w_k")?,
        self_heating_w: section.figure("self_heating_w")?,
    })
}

fn data(section: &Section<'_>) -> SensorResult<SensorData> {
    Ok(SensorData {
        image_bytes: section.figure("image_bytes")?,
        processing_s: section.figure("processing_s")?,
        product_bytes: section.figure("product_bytes")?,
        store_bytes: section.figure("store_bytes")?,
    })
}
