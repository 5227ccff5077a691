//! From the text of a vehicle file to a vehicle model.

use crate::error::VehicleFileError;
use crate::json::Node;
use crate::model::{
    Airframe, CameraModel, FuelModel, PlanningModel, ReportIntervals, ScannerModel, TurnModel, VehicleModel,
};
use crate::section::{Section, nearest};

/// The version of the format, the value of `format`.
const FORMAT: &str = "apex-vehicle-1";
const ROOT: &[&str] =
    &["format", "name", "airframe", "flight", "turns", "fuel", "scanner", "cameras", "report", "planning"];
const FLIGHT: &[&str] = &[
    "indicated_airspeed_m_s_min",
    "true_airspeed_m_s_cruise",
    "true_airspeed_m_s_max",
    "acceleration_m_s2_max",
    "bank_deg_max",
    "level_roll_deg_max",
    "roll_rate_deg_s_max",
    "yaw_rate_deg_s_max",
    "climb_rate_m_s_max",
    "descent_rate_m_s_max",
    "ceiling_m",
    "glide_ratio",
    "final_approach_m",
    "final_approach_height_m",
    "braking_share",
    "drag_per_s",
];
const TURNS: &[&str] = &["bank_share", "circle_width"];
const FUEL: &[&str] = &[
    "capacity_kg",
    "low_kg",
    "flow_kg_h_reference",
    "speed_m_s_reference",
    "share",
    "altitude_m_reference",
    "low_altitude_penalty",
    "climb_penalty",
    "descent_saving",
];
const SCANNER: &[&str] = &["field_of_view_deg", "pixel_mrad", "heights_m", "first_join_s", "further_join_s"];
const CAMERA: &[&str] = &[
    "name",
    "tilt_deg_min",
    "tilt_deg_max",
    "pan_deg_max",
    "slew_rate_deg_s",
    "field_of_view_deg",
    "power_up_s",
    "picture_s",
];
const REPORT: &[&str] = &["scanning_s", "manoeuvring_s", "cruise_s"];
const PLANNING: &[&str] =
    &["cruise_altitude_m", "climb_share", "descent_share", "ceiling_share", "reserve_share", "visit_height_m"];

type Read<T> = Result<T, VehicleFileError>;

impl VehicleModel {
    /// Reads the text of a vehicle file; `file` names it in errors.
    ///
    /// # Errors
    /// Text that is not JSON, a member that is unknown, repeated, missing or of another type, a figure without a source, a
    /// figure that describes nothing that can fly.
    pub fn parse(file: &str, text: &str) -> Result<VehicleModel, VehicleFileError> {
        let root: Node = serde_json::from_str(text).map_err(|error| VehicleFileError {
            file: file.to_owned(),
            path: String::new(),
            expected: "JSON (RFC 8259)".to_owned(),
            found: error.to_string(),
            help: "compare with a file of library/vehicles; docs/reference/vehicles.md describes it".to_owned(),
        })?;
        let model = read(file, &root)?;
        model.validate(file)?;
        Ok(model)
    }
}

fn read(file: &str, root: &Node) -> Read<VehicleModel> {
    let root = Section::open(file, "", root, ROOT)?;
    word(&root, "format", &[FORMAT])?;
    let airframe = match word(&root, "airframe", &["fixed-wing", "rotorcraft"])? {
        "rotorcraft" => Airframe::Rotorcraft,
        _ => Airframe::FixedWing,
    };
    let section = |name: &str, known: &[&str]| {
        let node = root.required(name, "an object", "add the section; docs/reference/vehicles.md lists its members")?;
        Section::open(file, name, node, known)
    };
    let scanner = match root.member("scanner") {
        Some(node) => Some(scanner(&Section::open(file, "scanner", node, SCANNER)?)?),
        None => None,
    };
    let flight = section("flight", FLIGHT)?;
    let fixed_wing = airframe == Airframe::FixedWing;
    let of_fixed_wing = |name: &str| flight.figure_if(name, fixed_wing, "rotorcraft");
    let of_rotorcraft = |name: &str| flight.figure_if(name, !fixed_wing, "fixed wing");
    Ok(VehicleModel {
        name: name(&root)?,
        airframe,
        indicated_airspeed_m_s_min: of_fixed_wing("indicated_airspeed_m_s_min")?,
        true_airspeed_m_s_cruise: flight.figure("true_airspeed_m_s_cruise")?,
        true_airspeed_m_s_max: flight.figure("true_airspeed_m_s_max")?,
        acceleration_m_s2_max: flight.figure("acceleration_m_s2_max")?,
        bank_deg_max: flight.figure("bank_deg_max")?,
        level_roll_deg_max: flight.figure("level_roll_deg_max")?,
        roll_rate_deg_s_max: flight.figure("roll_rate_deg_s_max")?,
        yaw_rate_deg_s_max: flight.figure("yaw_rate_deg_s_max")?,
        climb_rate_m_s_max: flight.figure("climb_rate_m_s_max")?,
        descent_rate_m_s_max: flight.figure("descent_rate_m_s_max")?,
        ceiling_m: flight.figure("ceiling_m")?,
        glide_ratio: flight.figure("glide_ratio")?,
        final_approach_m: of_fixed_wing("final_approach_m")?,
        final_approach_height_m: of_fixed_wing("final_approach_height_m")?,
        braking_share: of_rotorcraft("braking_share")?,
        drag_per_s: of_rotorcraft("drag_per_s")?,
        turns: turns(&section("turns", TURNS)?)?,
        fuel: fuel(&section("fuel", FUEL)?)?,
        scanner,
        cameras: cameras(&root)?,
        report: report(&section("report", REPORT)?)?,
        planning: planning(&section("planning", PLANNING)?)?,
    })
}

/// Returns a text that must be one of `known`.
fn word<'a>(section: &Section<'a>, member: &str, known: &[&'static str]) -> Read<&'a str> {
    let choices = || known.iter().map(|word| format!("\"{word}\"")).collect::<Vec<_>>().join(" or ");
    let help = format!("write \"{member}\": {}", choices());
    let found = section.required(member, &choices(), &help)?;
    match section.text(member)? {
        Some(text) if known.contains(&text) => Ok(text),
        text => {
            let near = text.and_then(|text| nearest(text, known.iter().copied()));
            Err(VehicleFileError {
                file: section.file().to_owned(),
                path: section.path_of(member),
                expected: choices(),
                found: found.describe(),
                help: near.map_or(help, |near| format!("did you mean \"{near}\"?")),
            })
        }
    }
}

fn name(section: &Section<'_>) -> Read<String> {
    section.required("name", "a text", "write \"name\": \"my-uav\"")?;
    Ok(section.text("name")?.unwrap_or_default().to_owned())
}

fn turns(section: &Section<'_>) -> Read<TurnModel> {
    Ok(TurnModel { bank_share: section.figure("bank_share")?, circle_width: section.figure("circle_width")? })
}

fn fuel(section: &Section<'_>) -> Read<FuelModel> {
    let shares = section.figures("share")?;
    let share = <[f64; 3]>::try_from(shares).map_err(|other| VehicleFileError {
        file: section.file().to_owned(),
        path: section.path_of("share"),
        expected: "three numbers".to_owned(),
        found: format!("a list of {}", other.len()),
        help: "write the constant, the linear and the cubic share of the flow".to_owned(),
    })?;
    Ok(FuelModel {
        capacity_kg: section.figure("capacity_kg")?,
        low_kg: section.figure("low_kg")?,
        flow_kg_h_reference: section.figure("flow_kg_h_reference")?,
        speed_m_s_reference: section.figure("speed_m_s_reference")?,
        share,
        altitude_m_reference: section.figure("altitude_m_reference")?,
        low_altitude_penalty: section.figure("low_altitude_penalty")?,
        climb_penalty: section.figure("climb_penalty")?,
        descent_saving: section.figure("descent_saving")?,
    })
}

fn scanner(section: &Section<'_>) -> Read<ScannerModel> {
    Ok(ScannerModel {
        field_of_view_deg: section.figure("field_of_view_deg")?,
        pixel_mrad: section.figure("pixel_mrad")?,
        heights_m: section.figures("heights_m")?,
        first_join_s: section.figure("first_join_s")?,
        further_join_s: section.figure("further_join_s")?,
    })
}

fn cameras(root: &Section<'_>) -> Read<Vec<CameraModel>> {
    let items = match root.member("cameras") {
        None => return Ok(Vec::new()),
        Some(Node::List(items)) => items,
        Some(other) => {
            return Err(VehicleFileError {
                file: root.file().to_owned(),
                path: root.path_of("cameras"),
                expected: "a list of cameras".to_owned(),
                found: other.describe(),
                help: "write [..] with one object for each camera, or leave it out".to_owned(),
            });
        }
    };
    let open = |(number, node)| Section::open(root.file(), &format!("cameras[{number}]"), node, CAMERA);
    items.iter().enumerate().map(|item| camera(&open(item)?)).collect()
}

fn camera(section: &Section<'_>) -> Read<CameraModel> {
    Ok(CameraModel {
        name: name(section)?,
        tilt_deg_min: section.figure("tilt_deg_min")?,
        tilt_deg_max: section.figure("tilt_deg_max")?,
        pan_deg_max: section.figure("pan_deg_max")?,
        slew_rate_deg_s: section.figure("slew_rate_deg_s")?,
        field_of_view_deg: section.figure("field_of_view_deg")?,
        power_up_s: section.figure("power_up_s")?,
        picture_s: section.figure("picture_s")?,
    })
}

fn report(section: &Section<'_>) -> Read<ReportIntervals> {
    Ok(ReportIntervals {
        scanning_s: section.figure("scanning_s")?,
        manoeuvring_s: section.figure("manoeuvring_s")?,
        cruise_s: section.figure("cruise_s")?,
    })
}

fn planning(section: &Section<'_>) -> Read<PlanningModel> {
    Ok(PlanningModel {
        cruise_altitude_m: section.figure("cruise_altitude_m")?,
        climb_share: section.figure("climb_share")?,
        descent_share: section.figure("descent_share")?,
        ceiling_share: section.figure("ceiling_share")?,
        reserve_share: section.figure("reserve_share")?,
        visit_height_m: section.figure("visit_height_m")?,
    })
}
