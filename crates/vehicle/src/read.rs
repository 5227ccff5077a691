//! Reading a vehicle model from the text of a vehicle file.

use crate::energy::{BatteryModel, EnergyModel, FlightPower, FuelModel, Reserve, StatedEndurance};
use crate::error::{FileName, VehicleFileError};
use crate::json::Node;
use crate::model::{Airframe, AttitudeHold, CruiseLevel, PlanningModel, ReportIntervals, TurnModel, VehicleModel};
use crate::section::Section;
use crate::sensor::{CarriedSensor, Optics, SensorModel};
use crate::shipped::ShippedSensor;

/// The version of the format, the value of `format`.
const FORMAT: &str = "apex-vehicle-2";
const ROOT: &[&str] = &[
    "format",
    "name",
    "airframe",
    "flight",
    "turns",
    "attitude_hold",
    "fuel",
    "battery",
    "reserve",
    "endurance",
    "sensors",
    "report",
    "planning",
];
const FLIGHT: &[&str] = &[
    "mass_kg",
    "indicated_airspeed_m_s_stall",
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
    "wind_m_s_max",
    "glide_ratio",
    "final_approach_m",
    "final_approach_height_m",
    "braking_share",
    "drag_per_s",
];
const TURNS: &[&str] = &["bank_share", "circle_width"];
const ATTITUDE_HOLD: &[&str] = &["roll_deg_per_edr", "natural_frequency_rad_s", "damping_ratio"];
const FUEL: &[&str] = &[
    "capacity_kg",
    "flow_kg_h_reference",
    "speed_m_s_reference",
    "share",
    "altitude_m_reference",
    "low_altitude_penalty",
    "climb_penalty",
    "descent_saving",
];
const BATTERY: &[&str] = &[
    "capacity_wh",
    "health_share",
    "discharge_efficiency",
    "temperature_c",
    "temperature_share",
    "avionics_w",
    "climb_efficiency",
    "descent_saving",
    "rotor",
    "wing",
];
const ROTOR: &[&str] = &["blade_w", "induced_w", "tip_speed_m_s", "induced_speed_m_s", "parasite_w_s3_m3"];
const WING: &[&str] = &["power_w_reference", "speed_m_s_reference", "parasite_share"];
const RESERVE: &[&str] = &["duration_min", "share"];
const ENDURANCE: &[&str] = &["cruise_min", "hover_min"];
const SENSOR: &[&str] = &["name", "sensor", "mode"];
const REPORT: &[&str] = &["scanning_s", "manoeuvring_s", "cruise_s"];
const PLANNING: &[&str] =
    &["cruise_altitude_m", "cruise_height_m", "climb_share", "descent_share", "ceiling_share", "visit_height_m"];

type Read<T> = Result<T, VehicleFileError>;

impl VehicleModel {
    /// Reads the text of a vehicle file whose sensors ship with Apex; `file` names it in errors.
    ///
    /// # Errors
    /// Like [`VehicleModel::parse_with`]; a sensor that is a file.
    pub fn parse(file: &str, text: &str) -> Result<VehicleModel, VehicleFileError> {
        VehicleModel::parse_with(file, text, &mut |_| Ok(None))
    }

    /// Reads the text of a vehicle file; `file` is its name in errors. `sensor_file` takes the reference to a sensor and returns the name
    /// (for errors) and the text of its file, or `None` if the sensor is one that ships with Apex.
    ///
    /// # Errors
    /// Text that is not JSON; a member that is unknown, repeated, missing or of the wrong type; a figure without a source, or one that no
    /// flying vehicle can have; an unknown sensor; an invalid sensor file; an error of `sensor_file`.
    pub fn parse_with(
        file: &str,
        text: &str,
        sensor_file: &mut SensorFile<'_>,
    ) -> Result<VehicleModel, VehicleFileError> {
        let name = FileName::vehicle(file);
        let root: Node = serde_json::from_str(text).map_err(|error| {
            let help = "compare with a file of library/vehicles; docs/reference/vehicles.md describes it";
            name.error("", "JSON (RFC 8259)", error.to_string(), help)
        })?;
        let model = read(name, &root, sensor_file)?;
        model.validate(file)?;
        Ok(model)
    }
}

/// Returns the name and the text of the sensor file that a vehicle file refers to, or `None` for a shipped sensor. The error is the
/// reason why the file cannot be read.
pub type SensorFile<'a> = dyn FnMut(&str) -> Result<Option<(String, String)>, String> + 'a;

fn read(file: FileName<'_>, root: &Node, sensor_file: &mut SensorFile<'_>) -> Read<VehicleModel> {
    let root = Section::open(file, "", root, ROOT)?;
    root.word("format", &[FORMAT])?;
    let airframe = match root.word("airframe", &["fixed-wing", "rotorcraft"])? {
        "rotorcraft" => Airframe::Rotorcraft,
        _ => Airframe::FixedWing,
    };
    let section = |name: &str, known: &[&str]| section(&root, name, known);
    let sensors = sensors(&root, sensor_file)?;
    let flight = section("flight", FLIGHT)?;
    let fixed_wing = airframe == Airframe::FixedWing;
    let of_fixed_wing = |name: &str| flight.figure_if(name, fixed_wing, "rotorcraft");
    let of_rotorcraft = |name: &str| flight.figure_if(name, !fixed_wing, "fixed wing");
    Ok(VehicleModel {
        name: root.name("my-uav")?,
        airframe,
        mass_kg: flight.figure("mass_kg")?,
        indicated_airspeed_m_s_stall: of_fixed_wing("indicated_airspeed_m_s_stall")?,
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
        wind_m_s_max: flight.figure("wind_m_s_max")?,
        glide_ratio: flight.figure("glide_ratio")?,
        final_approach_m: of_fixed_wing("final_approach_m")?,
        final_approach_height_m: of_fixed_wing("final_approach_height_m")?,
        braking_share: of_rotorcraft("braking_share")?,
        drag_per_s: of_rotorcraft("drag_per_s")?,
        turns: turns(&section("turns", TURNS)?)?,
        attitude_hold: attitude_hold(&section("attitude_hold", ATTITUDE_HOLD)?)?,
        energy: energy(&root)?,
        reserve: reserve(&section("reserve", RESERVE)?)?,
        endurance: endurance(&section("endurance", ENDURANCE)?, fixed_wing)?,
        scanner: CarriedSensor::recorder_of_lines(&sensors),
        cameras: sensors.iter().filter_map(CarriedSensor::camera).collect(),
        sensors,
        report: report(&section("report", REPORT)?)?,
        planning: planning(&section("planning", PLANNING)?)?,
    })
}

fn turns(section: &Section<'_>) -> Read<TurnModel> {
    Ok(TurnModel { bank_share: section.figure("bank_share")?, circle_width: section.figure("circle_width")? })
}

fn attitude_hold(section: &Section<'_>) -> Read<AttitudeHold> {
    Ok(AttitudeHold {
        roll_deg_per_edr: section.figure("roll_deg_per_edr")?,
        natural_frequency_rad_s: section.figure("natural_frequency_rad_s")?,
        damping_ratio: section.figure("damping_ratio")?,
    })
}

fn fuel(section: &Section<'_>) -> Read<FuelModel> {
    let shares = section.figures("share")?;
    let share = <[f64; 3]>::try_from(shares).map_err(|other| {
        let help = "write the constant, the linear and the cubic share of the flow";
        section.wrong("share", "three numbers", format!("a list of {}", other.len()), help)
    })?;
    Ok(FuelModel {
        capacity_kg: section.figure("capacity_kg")?,
        flow_kg_h_reference: section.figure("flow_kg_h_reference")?,
        speed_m_s_reference: section.figure("speed_m_s_reference")?,
        share,
        altitude_m_reference: section.figure("altitude_m_reference")?,
        low_altitude_penalty: section.figure("low_altitude_penalty")?,
        climb_penalty: section.figure("climb_penalty")?,
        descent_saving: section.figure("descent_saving")?,
    })
}

/// Returns the fuel section or the battery section: exactly one must be present.
fn energy(root: &Section<'_>) -> Read<EnergyModel> {
    match (root.member("fuel"), root.member("battery")) {
        (_, None) => Ok(EnergyModel::Fuel(fuel(&section(root, "fuel", FUEL)?)?)),
        (None, Some(_)) => Ok(EnergyModel::Battery(battery(&section(root, "battery", BATTERY)?)?)),
        (Some(_), Some(node)) => {
            let help = "keep the section of the vehicle's energy source";
            Err(root.wrong("battery", "no battery in addition to `fuel`", node.describe(), help))
        }
    }
}

fn battery(section: &Section<'_>) -> Read<BatteryModel> {
    let power = match (section.member("rotor"), section.member("wing")) {
        (Some(node), None) => rotor(&Section::open(section.file(), "battery.rotor", node, ROTOR)?)?,
        (None, Some(node)) => wing(&Section::open(section.file(), "battery.wing", node, WING)?)?,
        (first, _) => {
            let found = if first.is_some() { "both" } else { "neither" };
            let help = "describe the power of level flight by rotors or by wings";
            return Err(section.wrong("", "either `rotor` or `wing`", found, help));
        }
    };
    Ok(BatteryModel {
        capacity_wh: section.figure("capacity_wh")?,
        health_share: section.figure("health_share")?,
        discharge_efficiency: section.figure("discharge_efficiency")?,
        temperature_c: section.figures("temperature_c")?,
        temperature_share: section.figures("temperature_share")?,
        avionics_w: section.figure("avionics_w")?,
        climb_efficiency: section.figure("climb_efficiency")?,
        descent_saving: section.figure("descent_saving")?,
        power,
    })
}

fn rotor(section: &Section<'_>) -> Read<FlightPower> {
    Ok(FlightPower::Rotor {
        blade_w: section.figure("blade_w")?,
        induced_w: section.figure("induced_w")?,
        tip_speed_m_s: section.figure("tip_speed_m_s")?,
        induced_speed_m_s: section.figure("induced_speed_m_s")?,
        parasite_w_s3_m3: section.figure("parasite_w_s3_m3")?,
    })
}

fn wing(section: &Section<'_>) -> Read<FlightPower> {
    Ok(FlightPower::Wing {
        power_w_reference: section.figure("power_w_reference")?,
        speed_m_s_reference: section.figure("speed_m_s_reference")?,
        parasite_share: section.figure("parasite_share")?,
    })
}

fn reserve(section: &Section<'_>) -> Read<Reserve> {
    match either(section, "duration_min", "share")? {
        (true, minutes) => Ok(Reserve::Minutes(minutes)),
        (false, share) => Ok(Reserve::Share(share)),
    }
}

/// Reads the one of two figures that is present; true if it is the first one.
fn either(section: &Section<'_>, first: &str, second: &str) -> Read<(bool, f64)> {
    match (section.figure_optional(first)?, section.figure_optional(second)?) {
        (Some(value), None) => Ok((true, value)),
        (None, Some(value)) => Ok((false, value)),
        (found, _) => {
            let found = if found.is_some() { "both" } else { "neither" };
            let help = format!("give one of the two: `{first}` or `{second}`");
            Err(section.wrong("", &format!("either `{first}` or `{second}`"), found, &help))
        }
    }
}

fn endurance(section: &Section<'_>, fixed_wing: bool) -> Read<StatedEndurance> {
    let hover_min = section.figure_if("hover_min", !fixed_wing, "fixed wing")?;
    Ok(StatedEndurance { cruise_min: section.figure("cruise_min")?, hover_min: (!fixed_wing).then_some(hover_min) })
}

/// Opens a section that must be present.
fn section<'a>(root: &Section<'a>, name: &str, known: &[&str]) -> Read<Section<'a>> {
    let help = "add the section; docs/reference/vehicles.md lists its members";
    Section::open(root.file(), name, root.required(name, "an object", help)?, known)
}

fn sensors(root: &Section<'_>, sensor_file: &mut SensorFile<'_>) -> Read<Vec<CarriedSensor>> {
    let mut carried = Vec::new();
    for (path, node) in root.items("sensors")? {
        carried.push(sensor(&Section::open(root.file(), &path, node, SENSOR)?, sensor_file)?);
    }
    Ok(carried)
}

fn sensor(section: &Section<'_>, sensor_file: &mut SensorFile<'_>) -> Read<CarriedSensor> {
    const HELP: &str = "name a sensor that ships, or a sensor file that ends in .json";
    section.required("sensor", "the name of a sensor", HELP)?;
    let reference = section.text("sensor")?.unwrap_or_default();
    let unreadable = |reason: String| section.wrong("sensor", "a sensor that can be read", reason, HELP);
    let (file, text) = match sensor_file(reference).map_err(unreadable)? {
        Some(found) => found,
        None => {
            let shipped = ShippedSensor::find(reference)
                .map_err(|reason| section.wrong("sensor", "a sensor that ships, or a file", reason, HELP))?;
            (shipped.file.to_owned(), shipped.text.to_owned())
        }
    };
    let model = SensorModel::parse(&file, &text)?;
    Ok(CarriedSensor {
        name: section.name("camera-1")?,
        reference: reference.to_owned(),
        mode: mode(section, &model)?,
        model,
    })
}

/// Returns the mode in which a line scanner is used. The member may be left out if the scanner has only one mode.
fn mode(section: &Section<'_>, model: &SensorModel) -> Read<Option<String>> {
    let Optics::LineScanner { modes } = &model.optics else {
        return match section.member("mode") {
            None => Ok(None),
            Some(node) => {
                let expected = format!("nothing for a sensor of kind {}", model.kind());
                Err(section.wrong(
                    "mode",
                    &expected,
                    node.describe(),
                    "delete the member: only line scanners have modes",
                ))
            }
        };
    };
    let names = || modes.iter().map(|mode| format!("`{}`", mode.name)).collect::<Vec<_>>().join(", ");
    let found = match (section.text("mode")?, modes.as_slice()) {
        (None, [only]) => Some(only),
        (None, _) => None,
        (Some(name), _) => modes.iter().find(|mode| mode.name == name),
    };
    let found = found.ok_or_else(|| {
        let given = section.member("mode").map_or_else(|| "nothing".to_owned(), Node::describe);
        section.wrong("mode", &format!("one of {}", names()), given, "name the mode that is used")
    })?;
    Ok(Some(found.name.clone()))
}

fn report(section: &Section<'_>) -> Read<ReportIntervals> {
    Ok(ReportIntervals {
        scanning_s: section.figure("scanning_s")?,
        manoeuvring_s: section.figure("manoeuvring_s")?,
        cruise_s: section.figure("cruise_s")?,
    })
}

fn planning(section: &Section<'_>) -> Read<PlanningModel> {
    let cruise = match either(section, "cruise_altitude_m", "cruise_height_m")? {
        (true, altitude_m) => CruiseLevel::Altitude(altitude_m),
        (false, height_m) => CruiseLevel::Height(height_m),
    };
    Ok(PlanningModel {
        cruise,
        climb_share: section.figure("climb_share")?,
        descent_share: section.figure("descent_share")?,
        ceiling_share: section.figure("ceiling_share")?,
        visit_height_m: section.figure("visit_height_m")?,
    })
}
